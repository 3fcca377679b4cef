"""Theorems of resolved-rate motion, and the core against the reference by singular values."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc.errors import ArgumentError, ConfigError, LimitError
from ravengc.reference import resolved_rate as ref
from ravengc.resolved_rate import DAMPINGS, LIMITS, NULL_SPACES, RATE_EVENTS, TASKS, ResolvedRate, turning_about
from strategies import Case, cases

DT = 1e-3
PANDA = rg.load("panda")
HOME = np.array((0.0, 0.2, 0.0, -2.1, 0.0, 2.3, math.pi / 4))
TROCAR = (0.4, 0.0, 0.5)
FREE: dict[str, Any] = {"qd_max": np.inf, "q_min": -np.inf, "q_max": np.inf}
SINGULAR = [
    np.zeros(7), np.array((0, 0, 0, -0.07, 0, 0, 0)), np.array((0, 0.2, 0, -2.1, 0, 0, 0)),
    np.array((0, math.pi / 2, 0, 0, 0, 0, 0)), np.full(7, math.pi / 2),
    np.array((0, 0, 0, -math.pi / 2, 0, math.pi / 2, 0)),
]  # fmt: skip
agreement = settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
numbers = st.floats(-2.0, 2.0)
twists = st.lists(numbers, min_size=6, max_size=6).map(np.array)


def made(robot: rg.Robot, task: str = "twist", **options: Any) -> ResolvedRate:
    """Resolved rate with a trocar where the task has one."""
    given = {"remote_centre": TROCAR} if task == "remote_centre" else {}
    return ResolvedRate(robot, task, **(given | options))


def of_task(task: str, twist: np.ndarray) -> np.ndarray:
    """As many numbers as the task's twist has."""
    return twist[:3].copy() if task == "position" else twist


def truth(robot: rg.Robot, q: np.ndarray, twist: np.ndarray, task: str, base: np.ndarray | None = None) -> ref.Task:
    return ref.task(robot.spec, q, twist, task, base_twist=base, remote_centre=TROCAR)


@pytest.mark.parametrize("task", TASKS)
@agreement
@given(cases(), twists, twists)
def test_the_task_is_done_exactly_away_from_singularities(
    task: str, case: Case, twist: np.ndarray, base: np.ndarray
) -> None:
    robot, q = rg.Robot(case.spec), case.q
    wanted = truth(robot, q, of_task(task, twist), task, base)
    singular = np.linalg.svd(wanted.J, compute_uv=False)
    rate = made(robot, task, **FREE)
    qd = rate.step(q, of_task(task, twist), DT, base)
    assert np.isfinite(qd).all()
    size = 1.0 + np.abs(wanted.v).max() + np.abs(wanted.J).max()
    if singular[-1] > 0.0401 * max(1.0, 1e-5 * singular[0]):
        assert rate.damping_used == 0.0
        best = np.linalg.lstsq(wanted.J, wanted.v, rcond=None)[0]
        np.testing.assert_allclose(qd, best, atol=1e-10 * size * (singular[0] / singular[-1]) ** 2)
        np.testing.assert_allclose(rate.sigma_min, singular[-1], rtol=0.05)
    else:
        assert np.linalg.norm(wanted.J @ qd) <= np.linalg.norm(wanted.v) * (1.0 + 1e-6)


@pytest.mark.parametrize("task", TASKS)
def test_the_task_is_exact_to_ten_digits_on_a_real_arm(task: str) -> None:
    random = np.random.default_rng(0)
    rate, worst = made(PANDA, task, **FREE), 0.0
    for _ in range(500):
        q = HOME + random.uniform(-0.5, 0.5, 7)
        wanted = truth(PANDA, q, twist := of_task(task, random.standard_normal(6)), task)
        if np.linalg.svd(wanted.J, compute_uv=False)[-1] > 0.05:
            worst = max(worst, np.abs(wanted.J @ rate.step(q, twist, DT) - wanted.v).max())
    assert worst < 1e-10


@pytest.mark.parametrize("damping", ["constant", "manipulability", "adaptive", "filtered"])
def test_damping_is_that_of_the_singular_values_once_tracked(damping: str) -> None:
    random = np.random.default_rng(1)
    rate = made(PANDA, damping=damping, **FREE)
    for _ in range(200):
        q, twist = HOME + random.uniform(-1.5, 1.5, 7), random.standard_normal(6)
        for _ in range(30):
            qd = rate.step(q, twist, DT)
        wanted = truth(PANDA, q, twist, "twist")
        inverse = ref.damped_inverse(wanted.J, damping)
        expected = inverse.matrix @ wanted.v
        np.testing.assert_allclose(rate.damping_used, inverse.damping, atol=4e-4)
        np.testing.assert_allclose(qd, expected, atol=0.02 * np.abs(expected).max())


def test_selective_damping_is_that_of_the_singular_vectors() -> None:
    random = np.random.default_rng(2)
    rate = made(PANDA, damping="selective", qd_max=np.full(7, 2.0), q_min=-np.inf, q_max=np.inf)
    for _ in range(200):
        q, twist = random.uniform(-2.0, 2.0, 7), 0.3 * random.standard_normal(6)
        wanted = truth(PANDA, q, twist, "twist")
        expected = ref.shortened(ref.selectively_damped(wanted.J, wanted.v, 2.0), 2.0)
        np.testing.assert_allclose(rate.step(q, twist, DT), expected, atol=1e-7)


@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("task", TASKS)
def test_rates_are_within_limits_wherever_the_arm_is(task: str, damping: str, limits: str) -> None:
    if limits == "manipulability" and task == "remote_centre":
        pytest.skip("refused at construction")
    rate = made(PANDA, task, damping=damping, limits=limits)
    most = np.array([limit.velocity for limit in PANDA.spec.coordinate_limits])
    random = np.random.default_rng(3)
    poses = [*SINGULAR, *random.uniform(-3.0, 3.0, (300, 7))]
    for q in poses:
        for size in (1.0, 1e4):
            qd = rate.step(q, of_task(task, size * random.standard_normal(6)), DT)
            assert (np.abs(qd) <= most).all(), rate.reason


@pytest.mark.parametrize("name", ["raven2_gold", "rrbot", "dvrk_psm_si", "dvrk_psm", "pa10"])
@pytest.mark.parametrize("task", ["twist", "position"])
def test_small_coupled_and_sliding_arms_are_bounded_too(name: str, task: str) -> None:
    robot, random = rg.load(name), np.random.default_rng(4)
    rate = made(robot, task, qd_max=3.0, q_min=-np.inf, q_max=np.inf)
    for _ in range(300):
        q, own = random.uniform(-3.0, 3.0, robot.n), random.standard_normal(robot.n)
        twist = of_task(task, robot.jacobian(q) @ own)
        qd = rate.step(q, twist, DT)
        assert (np.abs(qd) <= 3.0).all()
        wanted = truth(robot, q, twist, task)
        if np.linalg.svd(wanted.J, compute_uv=False)[-1] > 0.041 and rate.scale == 1.0:
            np.testing.assert_allclose(wanted.J @ qd, wanted.v, atol=1e-9)


@pytest.mark.parametrize("null_space", NULL_SPACES)
@pytest.mark.parametrize("task", ["twist", "position", "pointing"])
def test_null_motion_leaves_the_task_still(task: str, null_space: str) -> None:
    random = np.random.default_rng(5)
    rate = made(PANDA, task, null_space=null_space, posture=HOME + 0.3, **(FREE if null_space != "limits" else {}))
    for _ in range(100):
        q = HOME + random.uniform(-0.4, 0.4, 7)
        qd = rate.step(q, np.zeros(3 if task == "position" else 6), DT)
        assert np.abs(truth(PANDA, q, np.zeros(6), task).J @ qd).max() < 1e-12
        assert (null_space == "none") == (not qd.any())


def test_null_motion_goes_where_it_should() -> None:
    def run(start: np.ndarray, **options: Any) -> np.ndarray:
        rate, q = made(PANDA, "position", **options), start.copy()
        for _ in range(3000):
            q = q + DT * rate.step(q, np.zeros(3), DT)
        return q

    def manipulability(q: np.ndarray) -> float:
        return math.sqrt(np.linalg.det((J := PANDA.jacobian(q)[:3]) @ J.T))

    posture = HOME + np.array((0.2, 0.0, -0.2, 0.1, 0.1, 0.0, 0.3))
    assert np.linalg.norm(run(HOME, null_space="posture", posture=posture) - posture) < np.linalg.norm(HOME - posture)
    start = HOME + np.array((0.4, 0.3, 0.5, 0.2, 0.4, 0.3, 0.0))
    assert manipulability(run(start, null_space="manipulability")) > 1.1 * manipulability(start)


def test_a_slowed_twist_keeps_its_direction() -> None:
    rate, random = made(PANDA), np.random.default_rng(6)
    for _ in range(100):
        q, twist = HOME + random.uniform(-0.4, 0.4, 7), 20.0 * random.standard_normal(6)
        done = PANDA.jacobian(q) @ rate.step(q, twist, DT)
        if rate.damping_used == 0.0:
            np.testing.assert_allclose(done, rate.scale * twist, atol=1e-9)
            assert rate.scale < 1.0
            assert rate.limiting_joint is not None
            assert PANDA.joint_names[rate.limiting_joint] in rate.reason


def test_least_squares_within_limits_do_no_less_than_slowing_down() -> None:
    random = np.random.default_rng(7)
    slowed, bent = made(PANDA), made(PANDA, limits="qp")
    for _ in range(200):
        q, twist = HOME + random.uniform(-0.4, 0.4, 7), 3.0 * random.standard_normal(6)
        J = PANDA.jacobian(q)
        left = [np.linalg.norm(J @ rate.step(q, twist, DT) - twist) for rate in (slowed, bent)]
        assert left[1] <= left[0] * (1.0 + 1e-6) + 1e-6


@pytest.mark.parametrize("limits", LIMITS)
def test_positions_stay_within_their_limits(limits: str) -> None:
    lower, upper = (np.array([getattr(x, side) for x in PANDA.spec.coordinate_limits]) for side in ("lower", "upper"))
    random = np.random.default_rng(8)
    rate, q = made(PANDA, limits=limits, qdd_max=50.0), HOME.copy()
    before = np.zeros(7)
    for cycle in range(6000):
        if cycle % 400 == 0:
            twist = random.standard_normal(6)
        qd = rate.step(q, twist, DT)
        assert np.abs(qd - before).max() <= 50.0 * DT * (1.0 + 1e-9), rate.reason
        before = qd
        q = q + DT * qd
        assert (q >= lower - 1e-12).all()
        assert (q <= upper + 1e-12).all()


def test_joints_beyond_a_limit_are_led_back() -> None:
    q = HOME.copy()
    q[3] = 0.1  # the limit is -0.0698
    rate = made(PANDA, limits="qp")
    for _ in range(1000):
        q = q + DT * rate.step(q, np.zeros(6), DT)
    assert q[3] <= -0.0697
    assert "position_limit" in rate.since


def test_a_step_in_the_twist_becomes_a_ramp() -> None:
    twist = np.array((0.3, -0.2, 0.1, 0.5, 0.0, 0.2))
    rate, q, done = made(PANDA, qdd_max=5.0, **FREE), HOME.copy(), np.zeros(6)
    before, J = np.zeros(7), PANDA.jacobian(HOME)
    for cycle in range(1200):
        wanted = twist if cycle < 400 else -twist
        qd = rate.step(q, wanted, DT)
        assert np.abs(qd - before).max() <= 5.0 * DT * (1.0 + 1e-9)
        before, done = qd, J @ qd
        assert np.linalg.norm(done - twist * (done @ twist) / (twist @ twist)) < 1e-10  # always along the twist
    np.testing.assert_allclose(done, -twist, atol=1e-10)


def test_jerk_is_limited_and_the_goal_is_not_overshot() -> None:
    rate = made(PANDA, qdd_max=5.0, qddd_max=200.0, **FREE)
    twist, past = np.array((0.3, -0.2, 0.1, 0.5, 0.0, 0.2)), [np.zeros(7), np.zeros(7)]
    goal = np.linalg.pinv(PANDA.jacobian(HOME)) @ twist
    past.extend(rate.step(HOME, twist, DT) for _ in range(600))
    rates = np.array(past)
    assert np.abs(np.diff(rates, axis=0)).max() <= 5.0 * DT * (1.0 + 1e-9)
    assert np.abs(np.diff(rates, 2, axis=0)).max() <= 200.0 * DT**2 * (1.0 + 1e-6)
    assert (np.abs(rates) <= np.abs(goal) * (1.0 + 1e-9) + 1e-12).all()
    np.testing.assert_allclose(rates[-1], goal, atol=1e-9)


@pytest.mark.parametrize("task", TASKS)
def test_a_still_target_is_held_exactly(task: str) -> None:
    pose = PANDA.forward_kinematics(HOME)
    tip, axis = pose[:3, 3], pose[:3, 2]
    target = {
        "twist": pose,
        "position": tip,
        "pointing": np.concatenate([tip, -axis]),
        "remote_centre": np.concatenate([tip, tip - 0.2 * axis]),
    }[task]
    assert np.abs(made(PANDA, task).track(HOME, target, DT)).max() < 1e-12


def walk(rate: ResolvedRate, q: np.ndarray, target: np.ndarray, steps: int = 2000) -> np.ndarray:
    for _ in range(steps):
        q = q + DT * rate.track(q, target, DT)
    return q


@pytest.mark.parametrize("angle", [0.05, 0.3, 1.0, 1.6])
def test_poses_are_reached(angle: float) -> None:
    q = HOME + angle * np.array((0.3, -0.2, 0.3, 0.2, 0.5, 0.3, -1.0))
    target = PANDA.forward_kinematics(q)
    reached = PANDA.forward_kinematics(walk(made(PANDA, gain=20.0, q_min=-np.inf, q_max=np.inf), HOME, target))
    np.testing.assert_allclose(reached, target, atol=1e-9)


@given(twists)
@settings(max_examples=50, deadline=None)
def test_orientation_errors_are_logarithms(turn: np.ndarray) -> None:
    vector = turn[3:] * 2.2
    angle = float(np.linalg.norm(vector))
    target = PANDA.forward_kinematics(HOME)
    if not 1e-9 < angle < math.pi - 1e-6:
        return
    K = np.cross(np.eye(3), vector / angle)
    R = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
    np.testing.assert_allclose(ref.rotation_vector(R), vector, atol=1e-7)
    target[:3, :3] = R @ target[:3, :3]
    rate = made(PANDA, gain=10.0, turning_gain=10.0, **FREE)
    done = PANDA.jacobian(HOME) @ rate.track(HOME, target, DT)
    np.testing.assert_allclose(done[3:], 10.0 * vector, atol=1e-7)


def test_opposed_targets_are_left() -> None:
    pose = PANDA.forward_kinematics(HOME)
    target = np.concatenate([pose[:3, 3], pose[:3, 2]])  # the outward normal along the axis: to be turned by pi
    rate = made(PANDA, "pointing", **FREE)
    assert np.isfinite(qd := rate.track(HOME, target, DT)).all()
    assert qd.any()
    assert "opposed" in rate.seen
    half = pose.copy()
    half[:3, 1:3] *= -1.0  # turned by pi about its own x
    turned = PANDA.jacobian(HOME) @ made(PANDA, gain=1.0, turning_gain=1.0, **FREE).track(HOME, half, DT)
    np.testing.assert_allclose(np.linalg.norm(turned[3:]), math.pi, rtol=1e-9)


def test_straight_lines_stay_straight() -> None:
    rate, q = made(PANDA, midpoint=True), HOME.copy()
    start = PANDA.forward_kinematics(q)
    way, worst = np.array((0.0, 0.2, 0.0)), 0.0
    for cycle in range(2000):
        q = q + DT * rate.step(q, np.concatenate([way / 2.0, np.zeros(3)]), DT)
        wanted = start[:3, 3] + way * (cycle + 1) / 2000
        worst = max(worst, np.linalg.norm(PANDA.forward_kinematics(q)[:3, 3] - wanted))
    assert worst < 1e-5
    np.testing.assert_allclose(PANDA.forward_kinematics(q)[:3, :3], start[:3, :3], atol=1e-5)


def rotation_about(axis: np.ndarray, angle: float) -> np.ndarray:
    K = np.cross(np.eye(3), axis)
    return np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K


@pytest.mark.parametrize("amplitude", [10.0, 20.0])
@pytest.mark.parametrize("task", ["twist", "position"])
def test_a_tool_stays_in_the_world_while_its_base_rocks(task: str, amplitude: float) -> None:
    """The base turns about a pivot below it; its gyroscope is read once per cycle, nothing is known ahead."""
    axis, pivot = np.array((1.0, 0.5, 0.0)) / math.sqrt(1.25), np.array((0.0, 0.0, -0.5))
    swing = math.radians(amplitude)

    def base(t: float) -> tuple[np.ndarray, np.ndarray]:
        """B in the world, and its angular velocity in its own axes."""
        R = rotation_about(axis, swing * math.sin(2.0 * math.pi * t))
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = R, pivot - R @ pivot
        return pose, axis * swing * 2.0 * math.pi * math.cos(2.0 * math.pi * t)

    rate, q, worst = made(PANDA, task, gain=200.0, q_min=-np.inf, q_max=np.inf, qd_max=10.0), HOME.copy(), 0.0
    held = base(0.0)[0] @ PANDA.forward_kinematics(q)
    for cycle in range(2000):
        pose, w = base(cycle * DT)
        target = np.linalg.inv(pose) @ held
        target = target if task == "twist" else target[:3, 3].copy()
        q = q + DT * rate.track(q, target, DT, base_twist=turning_about(pivot, w))
        tool = base((cycle + 1) * DT)[0] @ PANDA.forward_kinematics(q)
        worst = max(worst, float(np.linalg.norm(tool[:3, 3] - held[:3, 3])))
    assert worst < 1e-4


@pytest.mark.parametrize("breathes", [False, True])
def test_the_shaft_stays_in_its_trocar(breathes: bool) -> None:
    robot = rg.load("panda")
    robot.set_tool(np.eye(3), (0.0, 0.0, 0.45))
    q = HOME.copy()
    pose = robot.forward_kinematics(q)
    tip, rest = pose[:3, 3], pose[:3, 3] - 0.15 * pose[:3, 2]

    def trocar(t: float) -> tuple[np.ndarray, np.ndarray]:
        w, size = 2.0 * math.pi / 4.0, 0.0025 * breathes
        return rest + size * np.array((0, 0, 1.0 - math.cos(w * t))), size * w * np.array((0, 0, math.sin(w * t)))

    def circle(t: float) -> tuple[np.ndarray, np.ndarray]:
        w = 2.0 * math.pi / 4.0
        return (
            tip + 0.015 * np.array((math.cos(w * t) - 1.0, math.sin(w * t), 0.0)),
            0.015 * w * np.array((-math.sin(w * t), math.cos(w * t), 0.0)),
        )

    rate, worst = ResolvedRate(robot, "remote_centre", remote_centre=rest, gain=50.0, midpoint=True), [0.0, 0.0]
    for cycle in range(4000):
        (at, u), (goal, v) = trocar(cycle * DT), circle(cycle * DT)
        q = q + DT * rate.track(q, np.concatenate([goal, at]), DT, np.concatenate([v, u]))
        pose, at, goal = robot.forward_kinematics(q), trocar((cycle + 1) * DT)[0], circle((cycle + 1) * DT)[0]
        beside = np.linalg.norm(np.cross(at - pose[:3, 3], pose[:3, 2]))
        worst = np.maximum(worst, (beside, np.linalg.norm(pose[:3, 3] - goal)))
    assert max(worst) < 1e-5, worst


BAD = [np.nan, np.inf, -np.inf, 1e300]


@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("bad", BAD)
def test_bad_numbers_stop_the_arm_on_a_ramp(bad: float, limits: str) -> None:
    twist, target = np.full(6, 0.1), PANDA.forward_kinematics(HOME)
    rate = made(PANDA, qdd_max=5.0, limits=limits)
    for _ in range(100):
        before = rate.step(HOME, twist, DT)
    broken = {
        name: np.array(x, float) for name, x in {"q": HOME, "twist": twist, "base": twist, "target": target}.items()
    }
    for x in broken.values():
        x.flat[0] = bad
    for call in (
        lambda: rate.step(broken["q"], twist, DT),
        lambda: rate.step(HOME, broken["twist"], DT),
        lambda: rate.step(HOME, twist, DT, broken["base"]),
        lambda: rate.step(HOME, twist, bad),
        lambda: rate.step(HOME, twist, 0.0),
        lambda: rate.track(HOME, broken["target"], DT),
        lambda: rate.track(HOME, target, DT, broken["twist"]),
        lambda: rate.track(HOME, np.zeros((4, 4)), DT),
    ):
        rate.acknowledge()
        qd = call()
        assert np.abs(qd - before).max() <= 5.0 * DT * (1.0 + 1e-9)
        before = qd
        assert np.isfinite(rate.sigma_min)
        assert rate.status >> 32
    rate.reset()
    assert np.isfinite(rate.step(HOME, twist, DT)).all()
    assert rate.counters["cycles"] == 109


def test_directions_without_length_hold_the_tool() -> None:
    rate = made(PANDA, "pointing")
    assert not rate.track(HOME, np.concatenate([TROCAR, np.zeros(3)]), DT).any()
    assert rate.seen == ("target",)


def test_a_bound_cycle_gives_the_same_bits() -> None:
    pose, out, random = PANDA.forward_kinematics(HOME), np.empty(7), np.random.default_rng(9)
    one, other = made(PANDA), made(PANDA)
    q, target, moves, base = HOME.copy(), pose.copy(), np.zeros(6), np.zeros(6)
    cycle = one.bind(q=q, target=target, target_twist=moves, base_twist=base, out=out)
    for _ in range(50):
        q[:] = HOME + 0.1 * random.standard_normal(7)
        moves[:], base[:] = random.standard_normal((2, 6))
        cycle()
        np.testing.assert_array_equal(out, other.track(q, target, DT, moves, base))
    with pytest.raises(ArgumentError, match="either twist, or target"):
        one.bind(q=q, out=out)
    with pytest.raises(ArgumentError, match="shares memory"):
        one.bind(q=q, twist=moves, out=q)


def test_rows_of_a_twist_can_be_left_free() -> None:
    rate = made(PANDA, rows=[True, True, False, False, False, True], **FREE)
    twist = np.array((0.1, 0.2, 9.0, 9.0, 9.0, 0.3))
    done = PANDA.jacobian(HOME) @ rate.step(HOME, twist, DT)
    np.testing.assert_allclose(done[[0, 1, 5]], twist[[0, 1, 5]], atol=1e-12)


@pytest.mark.parametrize(
    ("options", "error", "match"),
    [
        ({"task": "twists"}, ConfigError, "twist"),
        ({"damping": "none"}, ConfigError, "adaptive"),
        ({"limits": "clip"}, ConfigError, "scale"),
        ({"task": "remote_centre"}, ArgumentError, "remote_centre is missing"),
        ({"null_space": "posture"}, ArgumentError, "posture is missing"),
        ({"qd_max": 0.0}, LimitError, "qd_max of 'panda_joint1' is 0.0"),
        ({"q_min": 1.0, "q_max": 1.0}, LimitError, "above q_min"),
        ({"gain": 2000.0}, ConfigError, "zero to rate_hz"),
        ({"eps": math.nan}, ConfigError, "eps is NaN"),
        ({"rows": [False] * 6}, ConfigError, "one to six rows"),
        ({"rows": [1, 0]}, ArgumentError, "six truth values"),
        ({"pointing_axis": (0, 0, 0)}, ConfigError, "not all zero"),
        ({"frame": "nowhere"}, ArgumentError, "nowhere"),
        ({"task": "remote_centre", "remote_centre": TROCAR, "limits": "manipulability"}, ConfigError, "task"),
    ],
)
def test_what_cannot_be_meant_is_refused(options: dict[str, Any], error: type[Exception], match: str) -> None:
    with pytest.raises(error, match=match):
        ResolvedRate(PANDA, **options)


def test_events_have_meanings() -> None:
    assert all(name.islower() and text for name, text in RATE_EVENTS.items())
    rate = made(PANDA, **FREE)
    rate.step(SINGULAR[0], np.full(6, 0.1), DT)
    assert "singular" in rate.seen
    assert "sigma_min" in rate.reason
