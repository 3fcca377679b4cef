"""Cables between rotors and links: statics, energy, the rigid limit, and swings that the integration leaves alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc
from ravengc import sim
from ravengc.control import raven2_drive
from ravengc.errors import ArgumentError, ModelError
from ravengc.spec import DhRow, LinkSpec, RobotSpec

if TYPE_CHECKING:
    from collections.abc import Callable

pytest.importorskip("mujoco")

LEVEL = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))
DRIVE = raven2_drive()
RAVEN = ravengc.load("raven2_gold")
NOMINAL = np.array((0.8, 1.5, 0.4))


def two_links() -> ravengc.Robot:
    """Two links of half a metre in a vertical plane, 2 and 1.5 kg, centres of mass in their middles."""
    rods = (
        LinkSpec(name="upper", placement=DhRow(alpha=np.pi / 2), mass=2.0, com=(0.25, 0.0, 0.0), inertia=flat(0.05)),
        LinkSpec(
            name="lower", parent="upper", placement=DhRow(a=0.5), mass=1.5, com=(0.25, 0.0, 0.0), inertia=flat(0.03)
        ),
    )
    return ravengc.Robot(RobotSpec(name="two links", convention="modified", links=rods))


def flat(about_z: float) -> tuple[float, float, float, float, float, float]:
    return (0.0, 0.0, 0.0, about_z, 0.0, about_z)


def turntable() -> ravengc.Robot:
    """One link about a vertical axis, 0.5 kg m^2: gravity plays no part."""
    rod = LinkSpec(name="rod", placement=DhRow(), mass=2.0, com=(0.5, 0.0, 0.0))
    return ravengc.Robot(RobotSpec(name="turntable", convention="modified", links=(rod,)))


# Statics


@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_a_held_motor_leaves_the_link_at_its_static_deflection(tilt: float) -> None:
    """The shoulder of a RAVEN II, cable 2000 N m/rad: K^-1 g, though the motors stand where they should."""
    stiffness = np.array((2000.0, 1500.0, 1e5))
    base = sim.tilted(tilt, "y")
    plant = sim.Plant(RAVEN, base, rotor_inertia=DRIVE.rotor_inertia, cable_stiffness=stiffness, cable_damping=5.0)
    plant.reset(NOMINAL)
    held = plant.motor_q.copy()
    for _ in range(300):
        gravity = RAVEN.gravity_torque(NOMINAL, -plant.accelerometer())
        plant.step(gravity + DRIVE.kp * (held - plant.motor_q) - DRIVE.kd * plant.motor_qd, 1e-3)
    np.testing.assert_allclose(plant.q, NOMINAL, atol=1e-12)
    torque = RAVEN.gravity_torque(NOMINAL, -plant.accelerometer())
    np.testing.assert_allclose(plant.motor_q - plant.q, torque / stiffness, rtol=1e-9)
    np.testing.assert_allclose(plant.cable_torque, torque, rtol=1e-9)


def test_on_a_moving_base_the_cables_begin_with_what_carries_the_arm() -> None:
    base = sim.rocking(-20, 20, hz=1.0, pivot=(0.0, 0.0, -0.3))
    plant = sim.Plant(RAVEN, base, rotor_inertia=1.0, cable_stiffness=1e4)
    plant.reset(NOMINAL, (0.1, 0.2, 0.3), time=0.4)
    torque = RAVEN.inverse_dynamics(NOMINAL, (0.1, 0.2, 0.3), np.zeros(3), base.motion(0.4))
    np.testing.assert_allclose(plant.cable_torque, torque, rtol=1e-9)
    plant.reset(NOMINAL, motor_q=NOMINAL)
    np.testing.assert_allclose(plant.cable_torque, 0.0, atol=1e-12)


STIFFNESS, KP, KD = np.array((100.0, 80.0)), np.array((60.0, 40.0)), np.array((12.0, 8.0))
GOAL = np.array((0.3, 0.5))
TWO_LINKS = two_links()
GRAVITY = (0.0, 0.0, -9.81)


def holding(q: np.ndarray) -> np.ndarray:
    return TWO_LINKS.gravity_torque(np.ascontiguousarray(q), GRAVITY)


def settled(goal: np.ndarray, compensation: Callable[[sim.Plant], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Error of the links (deg) where u = Kp (goal - o) - Kd o' + compensation has come to rest, and the largest |u|."""
    rotors, cables = (0.05, 0.03), {"cable_stiffness": STIFFNESS, "cable_damping": 1.0}
    plant = sim.Plant(TWO_LINKS, step_s=1e-3, rotor_inertia=rotors, **cables)
    plant._mechanism._model.opt.gravity[:] = GRAVITY
    plant.reset(np.zeros(2))
    peak = np.zeros(2)
    for _ in range(4000):
        u = KP * (goal - plant.motor_q) - KD * plant.motor_qd + compensation(plant)
        peak = np.maximum(peak, np.abs(u))
        plant.step(u, 2e-3)
    return np.rad2deg(plant.q - GOAL), peak


BIASED = GOAL + holding(GOAL) / STIFFNESS


@pytest.mark.parametrize(
    ("goal", "compensation", "error"),
    [
        (GOAL, lambda _: np.zeros(2), (-24.0524, -7.6654)),
        (BIASED, lambda _: np.zeros(2), (-15.6486, -5.3366)),
        (GOAL, lambda plant: holding(plant.motor_q), (-9.5122, -2.8275)),
        (GOAL, lambda _: holding(GOAL), (-9.6390, -2.9382)),
        (BIASED, lambda _: holding(GOAL), (0.0, 0.0)),
        (BIASED, lambda plant: holding(plant.motor_q), (-1.1422, -0.7669)),
        (BIASED, lambda plant: holding(plant.motor_q - holding(GOAL) / STIFFNESS), (0.0, 0.0)),
        (BIASED, lambda plant: holding(plant.q), (0.0, 0.0)),
    ],
    ids=["pd", "pd biased", "g(theta)", "g(q_d)", "Tomei", "on-line", "De Luca", "g(q)"],
)
def test_laws_with_gravity_settle_where_statics_says(
    goal: np.ndarray, compensation: Callable[[sim.Plant], np.ndarray], error: tuple[float, float]
) -> None:
    """Solutions of K (o - q) = g(q), Kp (goal - o) + compensation = g(q), found by Newton's method."""
    found, _ = settled(goal, compensation)
    assert found == pytest.approx(error, abs=1e-4)


def test_the_largest_torque_from_rest_is_the_first() -> None:
    """Kp (o_d - o_0) + g(q_d), where the rotors stand at K^-1 g(0) when they begin."""
    _, peak = settled(BIASED, lambda _: holding(GOAL))
    assert peak == pytest.approx((31.28, 22.01), abs=5e-3)


# Energy and swings


def energy(plant: sim.Plant, rotor: float, stiffness: float) -> float:
    stretch = plant.motor_q - plant.q
    moving = plant.qd @ plant.mass_matrix() @ plant.qd + rotor * plant.motor_qd @ plant.motor_qd
    return float(0.5 * moving + 0.5 * stiffness * stretch @ stretch) + plant.robot.potential_energy(plant.q, LEVEL)


def test_energy_goes_where_motors_and_damping_put_it() -> None:
    rotor, stiffness, damping, viscous, tau = 0.1, 300.0, 0.4, 0.2, np.array((6.0, 1.0))
    plant = sim.Plant(
        TWO_LINKS,
        step_s=2e-5,
        rotor_inertia=rotor,
        viscous=viscous,
        cable_stiffness=stiffness,
        cable_damping=damping,
    )
    plant.reset((0.2, -0.4))
    before, given, lost = energy(plant, rotor, stiffness), 0.0, 0.0
    for _ in range(3000):
        plant.step(tau, h := 1e-4)
        given += h * tau @ plant.motor_qd
        stretching = plant.motor_qd - plant.qd
        lost += h * (damping * stretching @ stretching + viscous * plant.motor_qd @ plant.motor_qd)
    assert abs(given) > 0.5 < lost + 0.5
    assert energy(plant, rotor, stiffness) - before == pytest.approx(given - lost, abs=2e-3)


@settings(deadline=None, max_examples=30)
@given(st.floats(1.0, 1e9), st.floats(0.01, 10.0))
def test_an_undamped_cable_swings_on_whatever_its_stiffness(stiffness: float, rotor: float) -> None:
    """x[k+1] - 2 cos(w' h) x[k] + x[k-1] = 0 with w' h = 2 atan(w h / 2): no swing grows or dies."""
    plant = sim.Plant(turntable(), rotor_inertia=rotor, cable_stiffness=stiffness)
    plant.reset([0.0], motor_q=[0.01])
    h = plant.step_s
    turn = 2.0 * np.arctan(0.5 * h * np.sqrt(stiffness * (1.0 / 0.5 + 1.0 / rotor)))
    stretches = []
    for _ in range(200):
        stretches.append((plant.motor_q - plant.q)[0])
        plant.step([0.0], h)
    x = np.array(stretches)
    np.testing.assert_allclose(x[2:] - 2.0 * np.cos(turn) * x[1:-1] + x[:-2], 0.0, atol=1e-10)
    assert np.abs(x).max() <= 0.0100001 / np.cos(0.5 * turn)


def test_stiffer_cables_approach_the_rigid_plant() -> None:
    options = {
        "rotor_inertia": DRIVE.rotor_inertia,
        "viscous": (2.0, 1.2, 20.0),
        "coulomb": (1.0, 0.6, 4.0),
    }
    rigid = swung(sim.Plant(RAVEN, sim.rocking(10, 20, hz=1.0), **options))
    differences = [
        np.abs(swung(sim.Plant(RAVEN, sim.rocking(10, 20, hz=1.0), **options, cable_stiffness=k)) - rigid).max()
        for k in (1e4, 1e6, 1e9)
    ]
    assert differences[0] > 10.0 * differences[1] > 10.0 * differences[2]
    assert differences[2] < 1e-5


def swung(plant: sim.Plant) -> np.ndarray:
    """Where the joints are while the motors follow a swing."""
    plant.reset(NOMINAL)
    found = []
    for k in range(150):
        goal = NOMINAL + np.array((0.05, 0.05, 0.01)) * (1.0 - np.cos(0.03 * k))
        plant.step(DRIVE.kp * (goal - plant.motor_q) - DRIVE.kd * plant.motor_qd, 1e-3)
        found.append(plant.q.copy())
    return np.array(found)


def test_friction_holds_the_motor_while_the_link_swings() -> None:
    plant = sim.Plant(turntable(), rotor_inertia=1.0, cable_stiffness=100.0, coulomb=5.0)
    plant.reset([0.02], motor_q=[0.0])
    plant.step([0.0], 0.05)
    assert plant.motor_q[0] == pytest.approx(0.0, abs=1e-15)
    assert abs(plant.qd[0]) > 0.1
    assert plant.friction_torque[0] == pytest.approx(100.0 * plant.q[0], rel=0.05)


# What a plant without cables says, and what is refused


def test_without_cables_motors_are_joints() -> None:
    plant = sim.Plant(RAVEN, rotor_inertia=1.0)
    plant.step((1.0, 2.0, 3.0), 0.01)
    assert not plant.elastic
    assert plant.motor_q.tolist() == plant.q.tolist()
    assert plant.motor_qd.tolist() == plant.qd.tolist()
    with pytest.raises(ModelError, match="rigid; give cable_stiffness"):
        _ = plant.cable_torque
    with pytest.raises(ArgumentError, match="motor_q is that of a plant with cables"):
        plant.reset(NOMINAL, motor_q=NOMINAL)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cable_stiffness": 0.0}, "cable_stiffness must be positive"),
        ({"cable_stiffness": (1.0, 1.0)}, "cable_stiffness must be one number or 3"),
        ({"cable_stiffness": np.nan}, "cable_stiffness must be one number or 3"),
        ({"cable_damping": 1.0}, "cable_damping needs cable_stiffness"),
        ({"cable_stiffness": 1.0, "cable_damping": -1.0}, "cable_damping must be"),
        ({"friction": "dry"}, "friction 'dry' is unknown: choose 'stick', 'soft'"),
    ],
)
def test_impossible_cables_are_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        sim.Plant(RAVEN, rotor_inertia=1.0, **options)


def test_a_cable_needs_a_rotor() -> None:
    with pytest.raises(ModelError, match="'elbow' has a cable, but a rotor without inertia; give rotor_inertia"):
        sim.Plant(RAVEN, rotor_inertia=(1.0, 0.0, 1.0), cable_stiffness=1e3)
