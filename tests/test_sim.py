"""The simulated plant against the core, and prescribed base motions against MuJoCo and their own derivatives."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc
from bounds import assert_close, bounds
from ravengc import sim
from ravengc.errors import ArgumentError, ConfigError, MissingExtraError, ModelError
from ravengc.monitored import STATES
from ravengc.sim import BaseTrajectory, Plant, SampledAccelerometer
from ravengc.spec import CouplingSpec, DhRow, LinkSpec, RobotSpec
from strategies import coordinates, grid, robots, vectors

if TYPE_CHECKING:
    from ravengc.spec import Vector

pytest.importorskip("mujoco")

SLOW_DRAWS = [HealthCheck.too_slow, HealthCheck.data_too_large]
agreement = settings(max_examples=40, deadline=None, suppress_health_check=SLOW_DRAWS)
TO_MUJOCO = 1e-10
LEVEL = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))
BUNDLED = (
    "raven2_gold",
    "raven2_green",
    "rrbot",
    "rrbot_modified",
    "dvrk_mtml",
    "dvrk_psm_si",
    "dvrk_ecm_si",
    "panda",
    "pa10",
)

SIX = st.tuples(*[grid(-0.5, 0.5)] * 6)
SIX_RATES = st.tuples(*[grid(0.0, 1.5)] * 6)
PLACE = vectors(grid(-1.0, 1.0))
MOTION = st.builds(sim.oscillating, amplitude=SIX, hz=SIX_RATES, phase=SIX, offset=SIX, pivot=PLACE)
TIME = grid(0.0, 10.0)


def pendulum(mass: float = 2.0) -> ravengc.Robot:
    """A point mass half a metre along x of a horizontal joint: inertia 0.5 kg m^2, gravity torque m g / 2 at zero."""
    rod = LinkSpec(name="rod", placement=DhRow(alpha=np.pi / 2), mass=mass, com=(0.5, 0.0, 0.0), massless=mass == 0.0)
    return ravengc.Robot(RobotSpec(name="pendulum", convention="modified", links=(rod,)))


def vee(matrix: np.ndarray) -> np.ndarray:
    """The vector of the antisymmetric part of a matrix."""
    return 0.5 * np.array((matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]))


@settings(deadline=None)
@given(MOTION, TIME, PLACE)
def test_base_motion_is_the_derivative_of_the_base_pose(base: BaseTrajectory, t: float, point: Vector) -> None:
    h = 2e-4
    rotations = [base.rotation(t + k * h) for k in (-1, 0, 1)]
    before, now, after = (base.position(t + k * h) + base.rotation(t + k * h) @ point for k in (-1, 0, 1))
    inverse = rotations[1].T
    f, w, dw = base.motion_at(t, point)
    assert_close(f, inverse @ ((after - 2.0 * now + before) / h**2 - LEVEL), bound=1.0, tolerance=2e-3)
    assert_close(w, vee(inverse @ (rotations[2] - rotations[0])) / (2.0 * h), bound=1.0, tolerance=2e-4)
    assert_close(dw, vee(inverse @ (rotations[2] - 2.0 * rotations[1] + rotations[0])) / h**2, 1.0, tolerance=2e-3)


@agreement
@given(MOTION, TIME, PLACE)
def test_accelerometer_and_gyro_of_mujoco_read_the_closed_form(base: BaseTrajectory, t: float, place: Vector) -> None:
    plant = Plant(pendulum(), base, sensor=place)
    plant.reset([0.7], [3.0], time=t)
    f, w, _ = base.motion_at(t, place)
    assert_close(plant.accelerometer(), f, bound=1.0, tolerance=TO_MUJOCO)
    assert_close(plant.gyro(), w, bound=1.0, tolerance=TO_MUJOCO)


def test_accelerometer_does_not_depend_on_the_arm() -> None:
    base = sim.rocking(10, 20, hz=1.0, pivot=(0.0, 0.0, -0.3))
    plant = Plant(pendulum(), base)
    plant.reset([0.3])
    plant.step([100.0], 0.25)
    assert abs(plant.qd[0]) > 1.0
    assert_close(plant.accelerometer(), base.motion_at(plant.time, (0.0, 0.0, 0.0))[0], bound=1.0, tolerance=TO_MUJOCO)


def check_dynamics(spec: RobotSpec, base: BaseTrajectory, t: float, motion: tuple[np.ndarray, ...]) -> None:
    """MuJoCo's torques and mass matrix are the core's, on this base at this time."""
    robot = ravengc.Robot(spec)
    plant = Plant(robot, base, rotor_inertia=1.0)
    plant.reset(motion[0], time=t)
    f, w, dw = base.motion_at(t, (0.0, 0.0, 0.0))
    scale = bounds(spec, *motion, f, w, dw)
    torque = robot.inverse_dynamics(*motion, base.motion(t))
    assert_close(plant.inverse_dynamics(*motion), torque, scale.torque, TO_MUJOCO)
    assert_close(plant.mass_matrix(), robot.mass_matrix(motion[0]), scale.mass_matrix, TO_MUJOCO)


@agreement
@given(st.data(), robots(), MOTION, TIME)
def test_mujoco_agrees_with_the_core_on_random_robots(
    data: st.DataObject, spec: RobotSpec, base: BaseTrajectory, t: float
) -> None:
    check_dynamics(spec, base, t, tuple(data.draw(coordinates(spec, size)) for size in (np.pi, 3.0, 10.0)))


@pytest.mark.parametrize("name", BUNDLED)
def test_mujoco_agrees_with_the_core_on_bundled_robots(name: str) -> None:
    spec = ravengc.load(name).spec
    base = sim.oscillating(amplitude=(0.1, 0.2, 0.3, 0.3, 0.2, 0.1), hz=(0.5, 0.7, 0.3, 0.9, 0.4, 0.6))
    q, qd, qdd = np.random.default_rng(1).standard_normal((3, len(spec.coordinate_names)))
    check_dynamics(spec, base, 0.37, (q, qd, qdd))


@agreement
@given(st.data(), robots(solid=True, most=6), MOTION)
def test_a_step_is_the_forward_dynamics(data: st.DataObject, spec: RobotSpec, base: BaseTrajectory) -> None:
    robot = ravengc.Robot(spec)
    q, qd, tau = (data.draw(coordinates(spec, size)) for size in (np.pi, 1.0, 1.0))
    plant = Plant(robot, base)
    plant.reset(q, qd)
    acceleration = robot.forward_dynamics(q, qd, tau, base.motion(0.0))
    plant.step(tau, h := 1e-4)
    assert_close(plant.qd, qd + h * acceleration, bound=1.0 + np.abs(h * acceleration).max(), tolerance=1e-8)
    assert_close(plant.q, q + h * plant.qd, bound=1.0)


@pytest.mark.parametrize("name", BUNDLED)
def test_the_gravity_torque_holds_the_arm_on_a_tilted_base(name: str) -> None:
    robot = ravengc.load(name)
    plant = Plant(robot, sim.tilted(20.0, "y"), rotor_inertia=0.1)
    plant.reset(start := np.full(robot.n, 0.4))
    for _ in range(50):
        plant.step(robot.gravity_torque(plant.q, -plant.accelerometer()), 1e-3)
    assert_close(plant.q, start, bound=1.0, tolerance=1e-9)


def test_rotors_add_to_the_inertia_of_the_coordinates() -> None:
    plant = Plant(pendulum(), rotor_inertia=1.5)
    plant.reset([np.pi / 2])
    plant.step([4.0], h := 5e-4)
    assert plant.qd[0] == pytest.approx(h * 4.0 / (0.5 + 1.5), rel=1e-9)


@pytest.mark.parametrize(("torque", "moves"), [(2.9, False), (3.1, True), (-2.9, False), (-3.1, True)])
def test_coulomb_friction_sticks_below_its_limit_and_slides_at_it(torque: float, moves: bool) -> None:
    plant = Plant(pendulum(), coulomb=3.0)
    plant.reset([np.pi / 2])
    plant.step([torque], h := 5e-4)
    rate = h * (torque - np.copysign(3.0, torque)) / 0.5 if moves else 0.0
    assert plant.qd[0] == pytest.approx(rate, abs=1e-12)


def test_coulomb_friction_stops_coupled_joints_for_good() -> None:
    robot = ravengc.load("raven2_gold")
    plant = Plant(robot, coulomb=(3.5, 2.1, 14.0))
    plant.reset([0.8, 1.5, 0.4], [0.5, -0.5, 0.1])
    for _ in range(100):
        plant.step(robot.gravity_torque(plant.q, LEVEL), 1e-2)
    assert plant.qd == pytest.approx(np.zeros(3), abs=1e-12)


def test_viscous_friction_is_stable_however_large() -> None:
    plant = Plant(pendulum(), viscous=1e9)
    plant.reset([np.pi / 2], [1.0])
    plant.step([0.0], 0.01)
    assert 0.0 <= plant.qd[0] < 1e-3


def test_motion_without_friction_keeps_its_energy() -> None:
    robot = pendulum()
    plant = Plant(robot, step_s=1e-4)
    plant.reset([0.5])
    before = robot.potential_energy(plant.q, LEVEL)
    plant.step([0.0], 0.3)
    kinetic = 0.5 * plant.qd @ plant.mass_matrix() @ plant.qd
    assert kinetic > 1.0
    assert kinetic + robot.potential_energy(plant.q, LEVEL) == pytest.approx(before, abs=5e-3)


def test_a_step_of_any_length_ends_on_time() -> None:
    plant = Plant(pendulum(), step_s=0.0005)
    for _ in range(7):
        plant.step([0.0], 1.0 / 1300.0)
    assert plant.time == pytest.approx(7.0 / 1300.0, abs=1e-15)


def test_no_time_changes_nothing() -> None:
    plant = Plant(pendulum(), coulomb=1.0)
    plant.reset([0.4], [1.0], time=1e9)
    plant.step([5.0], 0.0)
    assert (plant.q[0], plant.qd[0], plant.time) == (0.4, 1.0, 1e9)
    plant.step([5.0], 1e-3)
    assert plant.time > 1e9


def test_a_wrong_torque_shows_and_a_reset_ends_it() -> None:
    plant = Plant(pendulum(), coulomb=1.0)
    plant.step([np.nan], 1e-3)
    assert np.isnan(plant.q).all()
    plant.reset([0.4])
    plant.step([0.0], 1e-3)
    assert np.isfinite(plant.q).all()


def test_massless_moving_links_need_rotors() -> None:
    with pytest.raises(ModelError, match=r"'rod' moves no inertia.*rotor_inertia"):
        Plant(pendulum(mass=0.0))
    Plant(pendulum(mass=0.0), rotor_inertia=1e-3).step([0.0], 1e-3)


def test_a_coupled_mechanism_stays_on_its_coupling() -> None:
    links = tuple(
        LinkSpec(name=name, parent=parent, placement=DhRow(a=0.3), mass=1.0, com=(0.1, 0.0, 0.0))
        for name, parent in (("upper", None), ("lower", "upper"), ("tip", "lower"))
    )
    coupling = CouplingSpec(coordinates=("grip",), matrix=((1.0,), (-2.0,), (1.0,)), offset=(0.1, 0.2, 0.3))
    plant = Plant(ravengc.Robot(RobotSpec(name="mimic", convention="modified", links=links, coupling=coupling)))
    plant.reset([0.2])
    plant.step([5.0], 0.2)
    assert plant.q[0] != pytest.approx(0.2)
    assert 'name="lower"' in plant.mjcf


def test_without_mujoco_the_message_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'ravengc\[sim\]'"):
        Plant(pendulum())


@pytest.mark.parametrize(
    "options",
    [
        {"coulomb": -1.0},
        {"viscous": (1.0, 2.0)},
        {"rotor_inertia": np.nan},
        {"rotor_inertia": -np.eye(1)},
        {"step_s": 0.0},
        {"sensor": (0.0, np.nan, 0.0)},
    ],
)
def test_impossible_options_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(ArgumentError):
        Plant(pendulum(), **options)


@pytest.mark.parametrize("tau", [1.0, [1.0, 2.0], [[1.0]]])
def test_torques_of_another_shape_are_refused(tau: object) -> None:
    with pytest.raises(ArgumentError, match="tau must be 1 numbers"):
        Plant(pendulum()).step(tau, 1e-3)


@pytest.mark.parametrize("q", [[0.0, 0.0], [np.nan]])
def test_impossible_positions_are_refused(q: list[float]) -> None:
    with pytest.raises(ArgumentError, match="q must be 1 finite numbers"):
        Plant(pendulum()).reset(q)


def test_rocking_starts_at_rest_at_its_low_end_and_keeps_its_bounds() -> None:
    base = sim.rocking(10.0, 20.0, hz=1.0, axis=(0.0, -2.0, 0.0))
    angles = np.rad2deg([base.state(t).position[3] for t in np.linspace(0.0, 1.0, 101)])
    assert angles[0] == pytest.approx(10.0)
    assert base.state(0.0).velocity == pytest.approx(np.zeros(6))
    assert (angles.min(), angles.max()) == pytest.approx((10.0, 20.0))
    f, _, _ = base.motion_at(0.5, (0.0, 0.0, 0.0))
    assert f[0] == pytest.approx(ravengc.STANDARD_GRAVITY * np.sin(np.deg2rad(20.0)))


@pytest.mark.parametrize("axis", ["w", (0.0, 0.0, 0.0), (1.0, 2.0), (np.nan, 0.0, 1.0)])
def test_impossible_axes_are_refused(axis: object) -> None:
    with pytest.raises((ArgumentError, ConfigError), match="axis"):
        sim.tilted(10.0, axis)


@pytest.mark.parametrize("hz", [0.0, -1.0, np.inf])
def test_impossible_rates_are_refused(hz: float) -> None:
    with pytest.raises(ConfigError, match="hz"):
        sim.rocking(0.0, 1.0, hz=hz)


def test_the_sensor_gives_the_nominal_vector_then_follows_its_samples() -> None:
    tilted = np.array((1.0, 0.0, 9.755))
    sensor = SampledAccelerometer(lambda: tilted, hz=100.0, noise=1e-6)
    sensor.update(0.009)
    assert np.isnan(sensor.age)
    assert (STATES[sensor.state], tuple(sensor.gravity)) == ("nominal", tuple(LEVEL))
    for k in range(10, 500):
        sensor.update(1e-3 * k)
    assert (STATES[sensor.state], sensor.status) == ("live", 0)
    np.testing.assert_allclose(sensor.gravity, -tilted, atol=1e-4)
    assert sensor.age == pytest.approx(0.009)
    assert sensor.accelerometer.counters["received"] == 49


def test_of_several_missed_samples_only_the_latest_counts() -> None:
    sensor = SampledAccelerometer(lambda: np.array((0.0, 0.0, 9.81)), hz=100.0)
    sensor.update(0.055)
    assert sensor.accelerometer.counters["received"] == 1


def test_sensor_noise_comes_from_its_seed() -> None:
    def sampled(seed: int) -> tuple[float, ...]:
        sensor = SampledAccelerometer(lambda: np.array((0.0, 0.0, 9.81)), noise=0.1, seed=seed)
        for k in range(400):
            sensor.update(1e-3 * k)
        return tuple(sensor.gravity)

    assert sampled(1) == sampled(1) != sampled(2)


def test_a_strict_chain_is_live_when_it_is_warm() -> None:
    sensor = SampledAccelerometer(lambda: np.array((0.0, 0.0, 9.81)), noise=0.01, policy="strict")
    assert not sensor.accelerometer.armable
    sensor.warm_up(1.0)
    assert sensor.accelerometer.armable
    sensor.update(0.0)
    assert STATES[sensor.state] == "live"


@pytest.mark.parametrize("options", [{"hz": 0.0}, {"noise": -1.0}, {"hz": np.nan}])
def test_impossible_sensors_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(ConfigError):
        SampledAccelerometer(lambda: np.zeros(3), **options)
