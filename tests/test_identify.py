"""Identification: what torques show, what they do not, and what a fit of them finds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ravengc as rg
from ravengc import identify
from ravengc.errors import CalibrationError
from ravengc.identify import Model, Recording, base_parameters
from ravengc.identify.consistent import pseudo_inertia
from ravengc.identify.repeatability import repeatability

LEVEL = 9.80665


def static(robot: rg.Robot, poses: int, tilt: float, noise: float = 0.0, seed: int = 0) -> Recording:
    """Random poses within the limits on a base tilted by up to ``tilt`` rad, held by the torques of the file."""
    random = np.random.default_rng(seed)
    q = np.array([random.uniform(limit.lower, limit.upper, poses) for limit in robot.spec.coordinate_limits]).T
    lean = random.uniform(-tilt, tilt, (2, poses))
    force = LEVEL * np.array([np.sin(lean[0]), np.cos(lean[0]) * np.sin(lean[1]), np.cos(lean[0]) * np.cos(lean[1])]).T
    tau = robot.gravity_torque_batch(q, -force) + noise * random.normal(size=q.shape)
    return Recording(stamps=np.arange(float(poses)), q=q, tau=tau, specific_force=np.ascontiguousarray(force))


@pytest.mark.parametrize(
    ("name", "level", "tilted"),
    [
        ("raven2_gold", 5, 5),
        ("pa10", 10, 12),
        ("panda", 12, 14),
        ("dvrk_mtml", 12, 14),
        ("dvrk_mtmr", 12, 14),
        ("dvrk_psm_si", 5, 5),
        ("dvrk_ecm_si", 5, 5),
        ("ur10", 10, 12),
        ("rrbot", 4, 4),
        ("rrbot_modified", 4, 4),
    ],
)
def test_gravity_shows_as_many_base_parameters_as_published(name: str, level: int, tilted: int) -> None:
    robot = rg.load(name)
    assert [base_parameters(robot, Model(), words).rank for words in ("level", "tilted")] == [level, tilted]


def test_gravity_along_joint_one_hides_two_of_ravens_five() -> None:
    robot = rg.load("raven2_gold")
    along = LEVEL * np.array([robot.base.rotation])[:, :, 2]
    assert base_parameters(robot, Model(), along).rank == 3
    assert base_parameters(robot, Model(), np.vstack([along, [0.0, 0.0, LEVEL]])).rank == 5


@pytest.mark.parametrize(("name", "ranks"), [("raven2_gold", (14, 14, 18)), ("panda", (43, 45, 49))])
def test_motion_shows_more_and_a_rocking_base_four_more_still(name: str, ranks: tuple[int, ...]) -> None:
    robot, model = rg.load(name), Model(kind="dynamics", friction=())
    assert tuple(base_parameters(robot, model, words).rank for words in ("level", "tilted", "rocking")) == ranks


def test_what_is_not_shown_is_named_with_what_would_show_it() -> None:
    found = base_parameters(rg.load("panda"), Model(), "level")
    tilt, never = found.unidentifiable
    assert tilt.startswith("panda_link1.hx; panda_link1.hy + panda_link2.hz: tilt the base")
    assert never.startswith("panda_link1.m, panda_link1.hz, panda_link2.m: no joint torque")


def test_the_base_parameters_predict_what_all_parameters_do() -> None:
    robot, model = rg.load("panda"), Model(kind="dynamics")
    found = base_parameters(robot, model, "level")
    random = np.random.default_rng(1)
    q, qd, qdd = random.normal(size=(3, 9, 7))
    recording = Recording(stamps=np.arange(9.0), q=q, qd=qd, qdd=qdd, tau=np.zeros((9, 7)))
    regressor, parameters = model.regressor(robot, recording), random.normal(size=len(found.columns))
    np.testing.assert_allclose(regressor[:, found.chosen] @ (found.K @ parameters), regressor @ parameters, atol=1e-8)


@pytest.mark.parametrize("estimator", ["ols", "wls", "huber"])
def test_exact_torques_give_the_parameters_of_the_file(estimator: str) -> None:
    robot = rg.load("raven2_gold")
    found = identify.identify(robot, static(robot, 40, 0.3), Model(), estimator)
    np.testing.assert_allclose(found.values, found.base.K @ Model().prior(robot), atol=1e-10)
    assert found.refused is None
    assert found.held_out.rms.max() < 1e-10


def test_a_massless_link_with_noise_for_a_moment_has_a_body(tmp_path: Path) -> None:
    """Of the last link of a master arm torques show two moments and no mass: noise there makes no negative one."""
    robot = rg.load("dvrk_mtmr")
    for seed in range(4):
        found = identify.identify(robot, static(robot, 80, 0.2, noise=1e-3, seed=seed), Model())
        found.write(tmp_path / "arm.toml")
        written, there = rg.load(tmp_path / "arm.toml"), static(robot, 40, 0.2, seed=9)
        torques = written.gravity_torque_batch(there.q, -there.base[:, :3])
        np.testing.assert_allclose(torques, found.predict(there), atol=1e-6)
        assert all(link.mass >= 0.0 for link in written.spec.links)


def test_formal_uncertainty_covers_white_noise() -> None:
    robot = rg.load("raven2_gold")
    found = identify.identify(robot, static(robot, 200, 0.3, noise=0.01), Model(), "ols")
    errors = (found.values - found.base.K @ Model().prior(robot)) / found.formal_sd
    assert np.abs(errors).max() < 4.0
    np.testing.assert_allclose(found.held_out.rms, 0.01, rtol=0.3)


def moving(robot: rg.Robot, seconds: float = 20.0, rate: float = 100.0) -> Recording:
    """A periodic motion of several frequencies, with the torques of the file."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    q, qd, qdd = np.zeros((3, t.size, robot.n))
    random = np.random.default_rng(3)
    for harmonic in range(1, 6):
        w, phase = 2.0 * np.pi * 0.1 * harmonic, random.uniform(0.0, 6.0, robot.n)
        size = 0.5 * random.uniform(0.3, 1.0, robot.n) / np.sqrt(harmonic)
        angle = w * t[:, np.newaxis] + phase
        q += size * np.sin(angle)
        qd += size * w * np.cos(angle)
        qdd -= size * w * w * np.sin(angle)
    level = np.tile([0.0, 0.0, LEVEL, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], (t.size, 1))
    return Recording(stamps=t, q=q, qd=qd, qdd=qdd, tau=robot.inverse_dynamics_batch(q, qd, qdd, level))


def rubbed(recording: Recording, coulomb: float, viscous: float, offset: float) -> Recording:
    return replace(recording, tau=recording.tau + coulomb * np.sign(recording.qd) + viscous * recording.qd + offset)


def test_friction_and_dynamics_are_found_together() -> None:
    robot = rg.load("panda")
    found = identify.identify(robot, rubbed(moving(robot), 0.3, 0.2, 0.1), Model(kind="dynamics"), "wls")
    for name in robot.spec.coordinate_names:
        terms = [found.coefficients[f"{name}.{term}"] for term in ("coulomb", "viscous", "offset")]
        np.testing.assert_allclose(terms, [0.3, 0.2, 0.1], atol=1e-6)
    assert found.held_out.overall < 1e-8


def test_one_percent_of_wild_torques_do_not_move_hubers_estimate() -> None:
    robot = rg.load("raven2_gold")
    recording = static(robot, 300, 0.3, noise=0.005)
    tau = recording.tau.copy()
    tau[::30] += 50.0
    wild, truth = replace(recording, tau=tau), Model().prior(robot)
    errors = {}
    for estimator in ("ols", "huber"):
        found = identify.identify(robot, wild, Model(), estimator)
        errors[estimator] = float(np.abs(found.values - found.base.K @ truth).max())
    assert errors["huber"] < 0.02 < errors["ols"]


def test_columns_that_predict_worse_are_refused_and_nothing_is_written(tmp_path: Path) -> None:
    robot = rg.load("raven2_gold")
    cables = tuple(identify.polynomial(name, range(1, 8), scale=0.5) for name in robot.spec.coordinate_names)
    recording = static(robot, 44, 0.3, noise=0.05)
    found = identify.identify(robot, recording, Model(elements=cables))
    assert found.refused is not None
    assert "worse than without" in found.refused
    with pytest.raises(CalibrationError, match="refused"):
        found.write(tmp_path / "arm.toml")
    assert not list(tmp_path.iterdir())


def test_too_little_motion_is_refused_by_name() -> None:
    robot = rg.load("raven2_gold")
    recording = static(robot, 40, 0.3)
    still = replace(recording, q=np.tile(recording.q[0], (40, 1)))
    with pytest.raises(CalibrationError, match=r"says nothing about .* every joint moves"):
        identify.identify(robot, replace(still, specific_force=None), Model())


def test_the_robot_that_is_written_holds_the_identified_torques(tmp_path: Path) -> None:
    robot, model = rg.load("raven2_gold"), Model()
    truth = rg.load("raven2_gold", mass_set="cad")
    recording = static(truth, 60, 0.3)
    found = identify.identify(robot, recording, model)
    found.write(tmp_path / "arm.toml")
    written = rg.load(tmp_path / "arm.toml")
    force = recording.specific_force
    np.testing.assert_allclose(written.gravity_torque_batch(recording.q, -force), recording.tau, atol=1e-9)
    assert "identified from recording" in written.spec.source
    assert [path.name for path in tmp_path.iterdir()] == ["arm.toml"]


def test_a_stop_gives_first_and_slips_then() -> None:
    element = identify.hysteresis("shoulder", (0.1,))
    s = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(1.0, 0.0, 101)])
    state = element.basis(s, s, s)[:, 0]
    np.testing.assert_allclose(state[[5, 50, 100]], [0.5, 1.0, 1.0])
    np.testing.assert_allclose(state[-1], -1.0)
    assert np.abs(state).max() == 1.0


def test_the_filter_passes_slow_signals_unmoved_and_stops_fast_ones() -> None:
    t = np.arange(0.0, 10.0, 0.01)
    slow, fast = np.sin(2.0 * np.pi * 0.5 * t), np.sin(2.0 * np.pi * 20.0 * t)
    recording = Recording(stamps=t, q=np.column_stack([slow, slow + fast]), tau=np.zeros((t.size, 2)))
    calm = identify.smoothed(recording, 4.0)
    kept = np.isin(t, calm.stamps)
    np.testing.assert_allclose(calm.q, slow[kept][:, np.newaxis] * [1.0, 1.0], atol=1e-3)
    rate = 2.0 * np.pi * 0.5 * np.cos(2.0 * np.pi * 0.5 * t[kept])
    np.testing.assert_allclose(calm.velocity[:, 0], rate, atol=3e-3)


def test_both_ways_cancel_friction() -> None:
    robot = rg.load("raven2_gold")
    up = static(robot, 20, 0.2)
    q, qd = np.vstack([up.q, up.q]), np.vstack([np.full_like(up.q, 0.05), np.full_like(up.q, -0.05)])
    force = np.vstack([up.specific_force, up.specific_force])
    tau = np.vstack([up.tau, up.tau]) + 0.4 * np.sign(qd) + 2.0 * qd
    passed = Recording(stamps=np.arange(40.0), q=q, qd=qd, tau=tau, specific_force=force)
    np.testing.assert_allclose(identify.both_ways(passed).tau, up.tau, atol=1e-12)
    with pytest.raises(CalibrationError, match="both sides"):
        identify.both_ways(passed.take(slice(0, 20)))


def test_a_motion_that_repeats_has_a_floor() -> None:
    robot = rg.load("panda")
    recording = moving(robot, 35.0)
    noisy = replace(recording, tau=recording.tau + 0.02 * np.random.default_rng(0).normal(size=recording.q.shape))
    floor = repeatability(noisy)
    np.testing.assert_allclose(floor, 0.02, rtol=0.1)
    assert repeatability(recording.take(slice(0, 900))) is None


@pytest.mark.parametrize("given", ["nothing", "com", "lever"])
def test_a_load_is_found(given: str) -> None:
    robot, com = rg.load("panda"), np.array([0.02, -0.03, 0.157])
    unloaded = moving(robot, 10.0)
    body = robot.body_count - 1
    weighed = np.concatenate([[1.3], 1.3 * com, 1.3 * (com @ com * np.eye(3) - np.outer(com, com))[np.triu_indices(3)]])
    columns = robot.inverse_dynamics_regressor_batch(unloaded.q, unloaded.qd, unloaded.qdd, unloaded.base)
    loaded = replace(unloaded, tau=unloaded.tau + 0.05 + columns[:, :, 10 * body :] @ weighed)
    known = {"nothing": {}, "com": {"com": com}, "lever": {"lever": float(np.linalg.norm(com))}}[given]
    found = identify.payload(robot, unloaded, loaded, **known)
    assert found.link == "panda_link7"
    assert found.mass == pytest.approx(1.3, abs=1e-8)
    np.testing.assert_allclose(found.com, com, atol=1e-8)


@pytest.mark.parametrize("known", [{}, {"com": (0.0, 0.0, 0.1)}])
def test_logs_that_are_exchanged_are_asked_about(known: dict[str, tuple[float, float, float]]) -> None:
    robot = rg.load("panda")
    unloaded = moving(robot, 10.0)
    robot.set_payload(1.5, (0.0, 0.0, 0.1))
    force = -rg.Gravity.level().z * np.array([0.0, 0.0, 1.0])
    weight = robot.gravity_torque_batch(unloaded.q, -force)
    robot.clear_payload()
    loaded = replace(unloaded, tau=unloaded.tau + weight - robot.gravity_torque_batch(unloaded.q, -force))
    with pytest.raises(CalibrationError, match=r"are the logs .* exchanged\? If not, move .* \(com\)$"):
        identify.payload(robot, loaded, unloaded, **known)


def test_two_different_motions_are_no_difference() -> None:
    robot = rg.load("panda")
    unloaded = moving(robot, 10.0)
    with pytest.raises(CalibrationError, match="the two motions differ"):
        identify.payload(robot, unloaded, replace(unloaded, q=0.8 * unloaded.q))


def mounted(tilt: float, axes: int, seed: int) -> tuple[np.ndarray, np.ndarray, Recording]:
    robot = rg.load("raven2_gold")
    recording, random = static(robot, 60, tilt, noise=0.01, seed=seed), np.random.default_rng(seed)
    if axes == 1:
        lean = random.uniform(-tilt, tilt, 60)
        force = LEVEL * np.column_stack([np.zeros(60), np.sin(lean), np.cos(lean)])
        tau = robot.gravity_torque_batch(recording.q, -force) + 0.01 * random.normal(size=recording.q.shape)
        recording = replace(recording, tau=tau, specific_force=force)
    R = np.linalg.qr(np.eye(3) + 0.3 * random.normal(size=(3, 3)))[0]
    R *= np.sign(np.linalg.det(R))
    bias = 0.1 * random.normal(size=3)
    readings = recording.specific_force @ R + bias + 0.003 * random.normal(size=(60, 3))
    return R, bias, replace(recording, specific_force=readings)


def test_tilts_about_two_axes_show_how_the_sensor_is_mounted() -> None:
    R, bias, recording = mounted(np.radians(20.0), 2, 1)
    found = identify.mounting(rg.load("raven2_gold"), recording, noise=0.003)
    angle = np.arccos(np.clip((np.trace(found.rotation @ R.T) - 1.0) / 2.0, -1.0, 1.0))
    assert np.degrees(angle) < 0.5
    assert np.abs(found.bias - bias).max() < 0.01
    assert found.condition < 50.0
    assert not found.warnings
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)


def test_tilts_about_one_axis_are_warned_about_and_a_level_base_is_refused() -> None:
    robot = rg.load("raven2_gold")
    found = identify.mounting(robot, mounted(np.radians(20.0), 1, 2)[2], noise=0.003)
    assert any("one axis" in warning for warning in found.warnings)
    with pytest.raises(CalibrationError, match="tilt it by 10 degrees"):
        identify.mounting(robot, mounted(0.0, 2, 3)[2], noise=0.003)


def unisa(name: str) -> Recording:
    with np.load(Path(__file__).parent / "data" / "ident" / f"{name}_unisa.npz") as table:
        return Recording(stamps=table["t"], **{part: table[part].astype(float) for part in ("q", "qd", "tau")})


def test_a_real_ur10_is_predicted_better_than_by_its_published_model() -> None:
    model = Model(kind="dynamics", friction=("coulomb", "viscous", "offset", "cubic_root"))
    found = identify.identify(rg.load("ur10"), identify.smoothed(unisa("ur10"), 10.0, trim=0.3), model, "wls")
    assert found.rank == 60
    assert found.refused is None
    assert found.held_out.overall < 0.068  # 7.68 % by the model published with the recording


def test_gravity_and_friction_of_a_real_panda() -> None:
    recording = identify.smoothed(unisa("panda"), 3.0, trim=0.5)
    found = identify.identify(rg.load("panda"), recording, Model(kind="gravity+friction"))
    assert found.refused is None
    assert found.held_out.overall < 0.066


def test_the_ur10s_identified_masses_are_bodies_and_predict() -> None:
    as_built, identified = rg.load("ur10"), rg.load("ur10", mass_set="identified")
    assert identified.spec.mass_sets == as_built.spec.mass_sets == ("default", "identified")
    for robot in (as_built, identified):
        assert np.linalg.eigvalsh(robot.mass_matrix(np.full(6, 0.4)))[0] > 0.0


def test_consistent_parameters_are_those_of_bodies(tmp_path: Path) -> None:
    pytest.importorskip("clarabel")
    robot = rg.load("panda")
    recording = rubbed(moving(robot, 10.0), 0.3, 0.2, 0.1)
    noisy = replace(recording, tau=recording.tau + 0.1 * np.random.default_rng(0).normal(size=recording.q.shape))
    bounds = identify.Bounds(total_mass=18.0, reach=0.5)
    found = identify.identify(robot, noisy, Model(kind="dynamics"), "consistent", bounds=bounds)
    links = found.parameters[:70].reshape(7, 10)
    assert min(np.linalg.eigvalsh(pseudo_inertia(link))[0] for link in links) > 0.0
    assert links[:, 0].sum() <= 18.0 + 1e-6
    assert (np.abs(links[:, 1:4]) <= 0.5 * links[:, :1] + 1e-6).all()
    assert found.held_out.overall < 0.05
    found.write(tmp_path / "arm.toml")
    assert rg.load(tmp_path / "arm.toml").n == 7
