"""The loop's numbers: closed forms, the reference example, a robot on joints that nobody commands, and time itself."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc import control, stability
from ravengc.errors import ConfigError, RavenGCError
from ravengc.spec import IDENTITY, JointOrigin, LinkSpec, Pose
from ravengc.stability import Mount, OneLink, Sensing, certify, linearise, parse_mount, poles_right_of, remedies, trials
from ravengc.stability.remedy import with_own_reaction_removed, with_stiffer_joints
from ravengc.trajectory import swing_within_limits
from stability_cases import EX1, links
from strategies import robots

VARIANTS = [
    ({}, 0.1696 + 15.201j, -5.138),
    ({"latency_s": 0.0, "cutoff_hz": 100.0}, -0.1294 + 15.686j, 3.144),
    ({"base_damping_ratio": 0.05}, -0.3263 + 15.227j, 9.942),
    ({"kp": 600.0, "kd": 12.0}, -0.0761 + 15.645j, 1.873),
]
ONE = rg.from_dh(
    [{"joint": "revolute", "alpha": 0.0, "a": 0.0, "d": 0.0, "theta": 0.0, "mass": 2.0, "com": (0.4, 0.0, 0.0),
      "inertia": (0.01, 0.0, 0.0, 0.02, 0.0, 0.03)}],
    convention="modified",
)  # fmt: skip
"""A link about z, its centre of mass along x: it pushes the base along y."""


@pytest.mark.parametrize(("changes", "pole", "c_eff"), VARIANTS)
def test_the_reference_example_to_its_printed_digits(changes: dict[str, float], pole: complex, c_eff: float) -> None:
    certificate = certify(EX1.with_(**changes).system())
    assert certificate.pole.proven
    assert certificate.pole.s.real == pytest.approx(pole.real, abs=5e-5)
    assert certificate.pole.s.imag == pytest.approx(pole.imag, abs=5e-4)
    assert certificate.modes[0].effective_damping == pytest.approx(c_eff, abs=5e-4)
    assert certificate.certified == (pole.real < 0.0) == (c_eff > 0.0)
    assert certificate.count.number == (0 if certificate.certified else 2)


RAVEN = {"mass": 1.5, "length": 0.25, "inertia": 0.39, "kp": 454.3, "kd": 12.11, "latency_s": 0.03, "cutoff_hz": 20.0}
"""One link the size of the RAVEN's. Mass, lever and low-pass were searched for to give these poles: a consistency."""


@pytest.mark.parametrize(("mass", "hz", "pole"), [(15.0, 2.0, -0.1177), (5.0, 3.0, -0.1154)])
def test_a_link_like_the_ravens_is_stable_on_light_stands(mass: float, hz: float, pole: float) -> None:
    certificate = certify(EX1.with_(**RAVEN, base_mass=mass, base_frequency_hz=hz).system())
    assert certificate.certified
    assert certificate.pole.s.real == pytest.approx(pole, abs=5e-5)


def test_on_the_lighter_stand_it_loses_37_percent_of_the_damping() -> None:
    (mode,) = certify(EX1.with_(**RAVEN, base_mass=5.0, base_frequency_hz=3.0).system()).modes
    assert (mode.damping, mode.effective_damping) == pytest.approx((2.45, 1.55), abs=5e-3)
    assert mode.share == pytest.approx(1.0 - 0.37, abs=5e-3)


def test_the_reference_examples_rules_and_margins() -> None:
    assert EX1.damping == pytest.approx(3.770, abs=5e-4)
    assert EX1.lag_damping == pytest.approx(9.33, abs=5e-3)
    assert EX1.with_(cutoff_hz=None).critical_lag_s == pytest.approx(14.5e-3, abs=5e-5)
    distances = [certify(EX1.with_(**changes).system()).margins.distance for changes, _, _ in VARIANTS[:2]]
    assert distances == pytest.approx([0.221, 0.090], abs=5e-4)  # the stable one is nearer to -1
    found = {remedy.name: remedy for remedy in remedies(EX1.with_(cutoff_hz=None).system())}
    assert found["latency"].value == pytest.approx(10.37e-3, abs=5e-6)


def grown(link: OneLink, seconds: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Time and height of the base: the whole nonlinear model, y upward, by Runge and Kutta, the delay in a list.

    (M_b + m) y'' + m l (cos t t'' - sin t t'^2) + c y' + k y = 0,  J t'' + m l cos t (y'' + g) = tau
    """
    sensing, g = link.sensing, 9.80665
    late, history = round(sensing.delay_s / step), [0.0] * (round(sensing.delay_s / step) + 2)

    def accelerations(state: np.ndarray, fed: float) -> tuple[float, float]:
        y, t, v, w, _ = state
        reach = link.coupling * math.cos(t)
        tau = -link.kp * t - link.kd * w + sensing.gain * reach * fed + reach * g
        matrix = np.array(((link.total, reach), (reach, link.inertia)))
        right = (link.coupling * math.sin(t) * w * w - link.damping * v - link.stiffness * y, tau - reach * g)
        a, b = np.linalg.solve(matrix, right)
        return float(a), float(b)

    def slope(state: np.ndarray, fed: float) -> np.ndarray:
        a, b = accelerations(state, fed)
        return np.array((state[2], state[3], a, b, sensing.corner * (a - state[4])))

    state, heights = np.array((1e-3, 0.0, 0.0, 0.0, 0.0)), []
    for _ in range(round(seconds / step)):
        start, end = history[-1 - late], history[-late]
        middle = (start + end) / 2.0
        k1 = slope(state, start)
        k2 = slope(state + step / 2.0 * k1, middle)
        k3 = slope(state + step / 2.0 * k2, middle)
        k4 = slope(state + step * k3, end)
        state = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        history.append(float(state[4]))
        heights.append(state[0])
    return step * np.arange(1, len(heights) + 1), np.array(heights)


def test_the_nonlinear_model_grows_as_the_pole_says() -> None:
    t, y = grown(EX1, 12.0, 2e-3)
    peaks = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] > y[2:]) & (t[1:-1] > 2.0)) + 1
    rate = np.polyfit(t[peaks], np.log(y[peaks]), 1)[0]
    assert rate == pytest.approx(0.17, abs=0.005)
    t, y = grown(EX1.with_(base_damping_ratio=0.05), 6.0, 2e-3)
    assert np.abs(y[t > 4.0]).max() < 0.5 * np.abs(y[t < 2.0]).max()


@given(links())
@settings(max_examples=30, deadline=None)
def test_the_matrix_is_the_characteristic(link: OneLink) -> None:
    """Its determinant is D(s) / G_q(s), and 1 + L is D over that of static gravity."""
    s = np.array([0.3 + 1.7j, 2.0j, -0.2 + 9.0j]) * link.w_base
    system, characteristic = link.system(), link.characteristic(s)
    assert np.linalg.det(system.matrix(s)) == pytest.approx(characteristic / link.joint(s), rel=1e-8)
    static = link.with_(gain=0.0).characteristic(s)
    assert 1.0 + link.loop(s) == pytest.approx(characteristic / static, rel=1e-8)
    loci = stability.loci(system, s[1:2].imag)[0]
    assert loci == pytest.approx(link.loop(s[1:2]), rel=1e-8)


def test_a_robot_of_one_link_is_the_closed_form() -> None:
    drive = control.Drive(np.array([150.0]), np.array([3.0]), np.array([0.02]), "given")
    mount = Mount(directions=(0, 1, 0, 0, 0, 0), mass=10.0, frequency_hz=2.5, damping_ratio=0.01, names=("y",))
    system = linearise(ONE, [0.0], drive, mount, EX1.sensing)
    assert certify(system).pole.s == pytest.approx(certify(EX1.system()).pole.s, abs=1e-9)
    assert system.mass == pytest.approx(EX1.system().mass)
    assert system.stiffness == pytest.approx(EX1.system().stiffness)
    along_x = replace(mount, directions=np.eye(6)[:1])
    assert certify(linearise(ONE, [0.0], drive, along_x, EX1.sensing)).margins.critical_gains == ()


def on_joints(robot: rg.Robot, mass: float) -> rg.Robot:
    """The robot on a slide along y and a hinge about z that nobody commands: a base of two coordinates."""
    still = Pose(rotation=IDENTITY, translation=(0.0, 0.0, 0.0))
    slide = LinkSpec(name="slide", placement=JointOrigin(pose=still, axis=(0.0, 1.0, 0.0)), joint="prismatic",
                     massless=True)  # fmt: skip
    hinge = LinkSpec(name="hinge", placement=JointOrigin(pose=still, axis=(0.0, 0.0, 1.0)), joint="revolute",
                     parent="slide", mass=mass, inertia=(mass, 0.0, 0.0, mass, 0.0, mass))  # fmt: skip
    foot = LinkSpec(name="foot", placement=JointOrigin(pose=robot.spec.base), joint="fixed", parent="hinge",
                    massless=True)  # fmt: skip
    arm = tuple(replace(link, parent=link.parent or "foot") for link in robot.spec.links)
    return rg.Robot(replace(robot.spec, base=still, links=(slide, hinge, foot, *arm), coupling=None, transmission=None))


@pytest.mark.parametrize("name", ["raven2_gold", "panda", "rrbot"])
def test_a_base_is_two_more_joints(name: str) -> None:
    """Mass matrix and the mixed part of gravity's stiffness are those of a longer arm; so is what gravity needs."""
    robot = rg.load(name)
    q, field = np.linspace(0.3, 0.9, robot.n), np.array((0.5, -9.0, -3.0))
    drive = control.derived_drive(robot, q)
    mount = Mount(directions=np.eye(6)[[1, 5]], mass=np.diag((7.0, 7.0)), frequency_hz=2.0, damping_ratio=0.01)
    system = linearise(robot, q, drive, mount, Sensing(), gravity=field)
    longer, pose = on_joints(robot, 7.0), np.concatenate([np.zeros(2), q])
    rotors = np.diag(np.concatenate([np.zeros(2), drive.rotor_inertia]))
    assert system.mass == pytest.approx(longer.mass_matrix(pose) + rotors, abs=1e-9)
    assert system.stiffness[2:, :2] == pytest.approx(longer.gravity_stiffness(pose, field)[2:, :2], abs=1e-9)
    assert system.stiffness[:2, 2:] == pytest.approx(system.stiffness[2:, :2].T)
    moved = np.array((0.0, 1e-6))  # what the sensor reads of a tilt is what gravity needs
    fed = system.inputs @ system.reads_position[:, :2] @ moved
    turn = np.array(((1.0, 1e-6), (-1e-6, 1.0)))
    needed = robot.gravity_torque(q, np.append(turn @ field[:2], field[2])) - robot.gravity_torque(q, field)
    assert fed[2:] == pytest.approx(needed, abs=1e-9)


@given(robots(most=5, solid=True), st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_static_gravity_is_stable_for_any_arm_and_any_sliding_base(spec: object, seed: int) -> None:
    random = np.random.default_rng(seed)
    robot, m = rg.Robot(spec), int(random.integers(1, 4))
    q = random.standard_normal(robot.n)
    drive = control.derived_drive(robot, q, natural_frequency_hz=3.0)
    mount = Mount(directions=np.eye(6)[:m], mass=2.0, frequency_hz=random.uniform(0.5, 5.0, m), damping_ratio=0.02)
    sensing = Sensing(latency_s=0.05, cutoff_hz=20.0)
    assert poles_right_of(linearise(robot, q, drive, mount, sensing, law="pd+sg")).none
    assert poles_right_of(linearise(robot, q, drive, mount, sensing.with_(gain=0.0))).none


CHANGES = {
    "joint stiffness": lambda link, x: with_stiffer_joints(link.system(), x),
    "latency": lambda link, x: link.with_(latency_s=1.0 / x).system(),
    "cut-off": lambda link, x: link.with_(cutoff_hz=x).system(),
    "share fed": lambda link, x: link.with_(gain=1.0 / x).system(),
    "base damping": lambda link, x: link.with_(base_damping_ratio=0.01 * x).system(),
    "whole chain": lambda link, x: link.with_(latency_s=0.02 / x, cutoff_hz=10.0 * x).system(),
    "own reaction removed": lambda link, x: with_own_reaction_removed(link.system(), 1.0 / x),
}
"""The change that a remedy speaks of, growing with x; where less is better, x is the inverse."""
ALONG_TWO = np.eye(6)[:2]
INVERSE = {"latency", "share fed", "own reaction removed"}


@pytest.mark.parametrize("changes", [{}, {"latency_s": 0.0}, {"cutoff_hz": None}])
def test_every_remedy_is_enough_and_no_less_would_be(changes: dict[str, float]) -> None:
    link = EX1.with_(**changes)
    found = [remedy for remedy in remedies(link.system()) if remedy.value is not None]
    assert len(found) >= 4
    for remedy in found:
        enough = 1.0 / remedy.value if remedy.name in INVERSE else remedy.value
        assert poles_right_of(CHANGES[remedy.name](link, enough)).none, remedy
        if remedy.name != "own reaction removed":  # its limit may be that of the other sign
            assert not poles_right_of(CHANGES[remedy.name](link, 0.999 * enough)).none, remedy
    assert remedies(link.with_(gain=0.0).system()) == ()


def test_removing_the_own_reaction_by_a_perfect_model_leaves_nothing_to_feed_back() -> None:
    assert with_own_reaction_removed(EX1.system()).size == 3
    assert poles_right_of(with_own_reaction_removed(EX1.with_(gain=1.0).system())).none


def test_check_says_what_is_wrong_and_what_to_change() -> None:
    robot = rg.load("panda")
    q = swing_within_limits(robot.spec).centre
    drive = control.drive_for(robot, q)
    sensing = Sensing(latency_s=0.03, cutoff_hz=10.0)
    wrong, *changes = stability.check(robot, parse_mount("8:2.5:0.005:x,y"), sensing, q=q, drive=drive)
    assert wrong.startswith("not certified: ")
    assert any(text.startswith("raise the joints' natural frequency") for text in changes)
    assert stability.check(robot, parse_mount("15000:2:0.02"), sensing, q=q, drive=drive) == ()
    assert stability.check(robot, parse_mount("8:2.5:0.005"), sensing, q=q, drive=drive, law="pd+sg") == ()
    (passive,) = stability.check(robot, parse_mount("8:2.5:0.005"), sensing, q=q, drive=drive, law="passive")
    assert "no PD term" in passive


def test_a_small_campaign_finds_nothing_that_is_certified_and_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trials, "ROBOT_SHARE", 0.05)
    monkeypatch.setattr(trials, "STEPS", (4_000, 8_000))
    done = []
    tallies = stability.campaign(40, seed=3, on_progress=lambda count, of: done.append((count, of)))
    assert [tally.kind for tally in tallies] == ["one link", "robots"]
    assert sum(tally.cases for tally in tallies) == 40
    assert all(tally.holds for tally in tallies)
    assert sum(tally.unstable_grew for tally in tallies) >= 0.8 * sum(tally.unstable for tally in tallies) > 0
    assert done[-1] == (40, 40)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Sensing(latency_s=-1.0), r"latency_s is -1.0; expected a number from 0 to 10 s"),
        (lambda: Sensing(rate_hz=math.nan), "rate_hz is nan; expected a number from 1 to 1e"),
        (lambda: EX1.with_(mass=-2.0), r"mass is -2.0; expected a number from 1e-06 to 1e\+06 kg"),
        (lambda: EX1.with_(inertia=0.1), "inertia .at least mass . length.2. is 0.1; expected a number from 0.32"),
        (lambda: parse_mount("15:2"), "mount '15:2': write MASS:HZ:ZETA"),
        (lambda: parse_mount("0:2:0.01"), "mount: mass is 0.0; expected a number from 1e-06"),
        (lambda: parse_mount("15:-2:0.01"), "frequency_hz is -2.0; expected a number from 0.001 to 10000 Hz"),
        (lambda: parse_mount("15:2:0.01:w"), "direction 'w' is unknown: choose 'x', 'y'"),
        (lambda: parse_mount("15:2:0.01:x,x"), "names the same one twice"),
        (lambda: parse_mount("15:2:0.01:0,0,0"), "has no direction"),
        (lambda: Mount(directions=np.eye(6), mass=1.0, damping_ratio=0.1), "neither of stiffness and frequency_hz"),
        (lambda: Mount(directions=np.ones((2, 6)), mass=1.0, stiffness=1.0, damping=1.0), "combination of the others"),
        (lambda: Mount(directions=np.eye(6), mass=-1.0, stiffness=1.0, damping=1.0), "mass is -1.0; expected zero or"),
        (lambda: Mount(directions=ALONG_TWO, mass=(5, -1), stiffness=1.0, damping=1.0), r"mass is \(5, -1\); expected"),
        (lambda: Mount(directions=ALONG_TWO, mass=1.0, stiffness=0.0, damping=1.0), "stiffness is 0.0; expected above"),
        (lambda: Mount(directions=ALONG_TWO, mass=1e9, stiffness=1.0, damping=1.0), "expected one, 2 or 2 x 2 numbers"),
        (
            lambda: Mount(directions=ALONG_TWO, mass=[[1.0, 2.0], [2.0, 1.0]], stiffness=1.0, damping=1.0),
            "mass: smallest eigenvalue -1; expected all zero or more",
        ),
    ],
)
def test_impossible_numbers_are_refused_with_the_range(call: object, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        call()  # type: ignore[operator]


def test_arguments_of_the_wrong_kind_are_errors_of_ours() -> None:
    robot, mount, sensing = rg.load("rrbot"), parse_mount("5:2:0.01:y"), Sensing()
    good = {"robot": robot, "q": (0.1, 0.2), "drive": control.derived_drive(robot, (0.1, 0.2)), "mount": mount,
            "sensing": sensing, "law": "pd+dg", "gravity": (0.0, 0.0, -9.81), "sensor": (0.0, 0.0, 0.0)}  # fmt: skip
    linearise(**good)
    for name in good:
        for value in (None, "x", -1.5, math.nan, [], {}, object(), np.full(3, np.nan), np.zeros((2, 2, 2))):
            with pytest.raises(RavenGCError):
                linearise(**(good | {name: value}))
    for function in (certify, remedies):
        with pytest.raises(RavenGCError):
            function("system")
    for cases in (0, -1, 2.5, "many"):
        with pytest.raises(RavenGCError):
            stability.campaign(cases)
