"""Disturbance elements in the plant: it moves as they say, and a law that knows them holds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ravengc as rg
from ravengc.control import Controller, Drive
from ravengc.disturbances import Constant, Friction, LinearSpring, PiecewiseCable, SpringBetween

pytest.importorskip("mujoco")
from ravengc.sim import Plant

SPRINGS = (
    LinearSpring(name="spring", joint="joint1", stiffness=4.0, rest=0.3),
    PiecewiseCable(name="cable", joint="joint2", knots=(0.0,), pieces=((0.0, 1.0), (0.0, 5.0))),
    SpringBetween(
        name="coil", body_a="base", point_a=(0.3, 0.2, 0.0), body_b="link2", point_b=(-0.4, 0.1, 0.0), stiffness=50.0,
        rest_length=0.2,
    ),
    Constant(name="offset", joint="joint1", torque=-0.7),
)  # fmt: skip
Q = np.array((0.4, -0.9))


def rrbot(*elements: object) -> rg.Robot:
    return rg.Robot(replace(rg.load("rrbot").spec, disturbances=elements))


def test_a_step_accelerates_by_the_torque_less_the_elements() -> None:
    robot = rrbot(*SPRINGS)
    plant = Plant(robot, step_s=1e-5)
    plant.reset(Q)
    tau = np.array((3.0, -2.0))
    plant.step(tau, 1e-5)
    net = tau - robot.disturbance_torque(Q)
    expected = robot.forward_dynamics(Q, np.zeros(2), net, rg.Gravity.level())
    np.testing.assert_allclose(plant.qd / 1e-5, expected, rtol=1e-6)


def test_they_can_be_left_out() -> None:
    with_none, left_out = Plant(rg.load("rrbot")), Plant(rrbot(*SPRINGS), disturbances=False)
    for plant in (with_none, left_out):
        plant.reset(Q)
        plant.step(np.zeros(2), 0.1)
    np.testing.assert_array_equal(with_none.q, left_out.q)


def test_friction_is_that_of_the_plant() -> None:
    """An element of friction, at any ratio, is the same plant as one that was given these numbers."""
    friction = Friction(name="f", joint="joint2", coulomb=0.4, viscous=0.3, ratio=0.5)
    element, given = Plant(rrbot(friction)), Plant(rg.load("rrbot"), coulomb=(0.0, 0.4), viscous=(0.0, 0.3))
    for plant in (element, given):
        plant.reset(Q, (0.5, -2.0))
        plant.step(np.zeros(2), 0.2)
    np.testing.assert_array_equal(element.q, given.q)


def test_cables_between_rotors_and_links_start_loaded_by_the_elements() -> None:
    robot = rrbot(*SPRINGS)
    plant = Plant(robot, rotor_inertia=0.1, cable_stiffness=500.0)
    plant.reset(Q)
    load = robot.gravity_torque(Q, rg.Gravity.level()) + robot.disturbance_torque(Q)
    np.testing.assert_allclose(500.0 * (plant.motor_q - Q), load, atol=1e-9)


@pytest.mark.parametrize(("knows", "drift"), [(True, 1e-3), (False, None)])
def test_a_passive_arm_stays_where_its_law_knows_the_elements(knows: bool, drift: float | None) -> None:
    """Gravity alone lets the arm swing; with the elements, and a little friction, it stays for a second."""
    robot = rrbot(
        *SPRINGS, Friction(name="f1", joint="joint1", coulomb=0.02), Constant(name="o", joint="joint2", torque=0.1)
    )
    plant = Plant(robot, coulomb=0.02)
    plant.reset(Q)
    control = Controller(robot, "passive", Drive(*np.zeros((3, 2)), "none"), disturbances=knows)
    for _ in range(1000):
        control.q[:], control.qd[:] = plant.q, plant.qd
        control.update()
        plant.step(control.tau, 1e-3)
    moved = float(np.abs(plant.q - Q).max())
    assert moved <= drift if drift is not None else moved > 0.1
