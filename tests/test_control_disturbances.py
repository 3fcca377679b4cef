"""Disturbance elements in control laws: the torque is the reference's, and a bad joint state never pushes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc import reference as ref
from ravengc.control import LAWS, Controller, Drive
from ravengc.disturbances import Constant, Friction, LinearSpring, Polynomial, SpringBetween

ELEMENTS = (
    LinearSpring(name="spring", joint="shoulder_pitch", stiffness=0.4, rest=0.1),
    Friction(name="friction", joint="outer_yaw", coulomb=0.05, viscous=0.01),
    Polynomial(name="cable", joint="wrist_platform", coefficients=(0.1, -0.2, 0.05), range=(-1.0, 1.0)),
    SpringBetween(
        name="coil", body_a="wrist_platform", point_a=(0.02, 0.0, 0.05), body_b="wrist_yaw", point_b=(0.0, 0.03, 0.0),
        stiffness=100.0, rest_length=0.02,
    ),
    Constant(name="offset", joint="elbow_pitch", torque=-0.3),
)  # fmt: skip
MTM = rg.load("dvrk_mtmr")
ROBOT = rg.Robot(replace(MTM.spec, disturbances=ELEMENTS))
DRIVE = Drive(np.ones(7), 0.1 * np.ones(7), np.zeros(7), "made up")
STATES = st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7).map(np.array)


def controller(law: str, **options: object) -> Controller:
    return Controller(ROBOT, law, DRIVE, **options)


@settings(max_examples=40, deadline=None)
@given(STATES, STATES, st.sampled_from(list(LAWS)), st.sampled_from(("joint", "motor")))
def test_laws_with_gravity_add_the_elements(q: np.ndarray, qd: np.ndarray, law: str, side: str) -> None:
    control = controller(law, feedback=side, output="joint")
    matrix = np.array(ROBOT.spec.transmission.joint_per_motor) if side == "motor" else np.eye(7)
    control.q[:], control.qd[:] = np.linalg.solve(matrix, q), np.linalg.solve(matrix, qd)
    control.q_desired[:] = q
    control.update()
    expected = ref.disturbance_torque(ROBOT.spec, q, qd) if LAWS[law].gravity != "none" else np.zeros(7)
    np.testing.assert_allclose(control.tau_disturbance, expected, atol=1e-12)
    np.testing.assert_allclose(control.tau, control.tau_pd + control.tau_gravity + expected, atol=1e-12)


def test_the_torque_goes_to_the_motors() -> None:
    control = controller("passive", feedback="joint", output="motor")
    control.q[:] = 0.3
    control.update()
    expected = ROBOT.actuator_torque(ROBOT.disturbance_torque(np.full(7, 0.3)))
    np.testing.assert_allclose(control.tau_disturbance, expected, atol=1e-14)


@pytest.mark.parametrize("law", LAWS)
def test_without_them_it_is_the_law_of_a_robot_without_elements(law: str) -> None:
    plain, without = Controller(MTM, law, DRIVE), controller(law, disturbances=False)
    for control in (plain, without):
        control.q[:], control.qd[:] = 0.2, 0.1
        control.update()
        assert not control.tau_disturbance.any()
    np.testing.assert_array_equal(plain.tau, without.tau)


def test_a_missing_joint_state_holds_the_elements_at_rest() -> None:
    """A NaN: gravity and springs at the last good pose, friction not pushed along; so is the fault that follows."""
    control = controller("passive", hold_s=0.003)
    control.q[:], control.qd[:] = 0.2, 0.5
    control.update()
    moving = control.tau_disturbance.copy()
    control.q[2] = np.nan
    for _ in range(6):
        control.update()
        np.testing.assert_array_equal(control.tau_disturbance, ROBOT.disturbance_torque(np.full(7, 0.2)))
        assert np.isfinite(control.tau).all()
    assert control.state == "fault"
    assert moving[0] > control.tau_disturbance[0] == 0.0
