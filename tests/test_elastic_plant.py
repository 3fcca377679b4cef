"""The laws on the simulated RAVEN with elastic cables, read at its motors: the links come to where they should be."""

from __future__ import annotations

import math

import numpy as np
import pytest

import ravengc as rg
from ravengc import control

pytest.importorskip("mujoco")
from ravengc import sim

ROBOT, DRIVE = rg.load("raven2_gold"), control.raven2_drive()
POSE = np.array((math.pi / 4, math.pi / 2, 0.33))
CABLES = np.array((2000.0, 2000.0, 2e5))
FIRST_AXIS = tuple(np.array(ROBOT.base.rotation)[:, 2])
SECONDS, PERIOD = 1.0, 1e-3


def plant(degrees: float) -> sim.Plant:
    """The arm on a base that is turned about the axis of its first joint."""
    base = sim.tilted(degrees, FIRST_AXIS)
    damping = 0.002 * CABLES
    made = sim.Plant(
        ROBOT, base, rotor_inertia=DRIVE.rotor_inertia, cable_stiffness=CABLES, cable_damping=damping, viscous=0.5
    )
    made.reset(POSE + np.array((0.05, -0.05, 0.005)))
    return made


def link_errors(law: rg.ElasticGravity | None, degrees: float) -> np.ndarray:
    """Degrees (mm) that the links stand beside the goal, after PD on the motors with this law, or as if rigid."""
    arm, theta_d, comp = plant(degrees), POSE.copy(), np.zeros(3)
    gravity = -arm.accelerometer()
    if law is None:
        cycle = ROBOT.bind(q=arm.motor_q, gravity=gravity, out=comp)
    else:
        cycle = law.bind(theta=arm.motor_q, q_desired=POSE, gravity=gravity, out=comp, q=arm.q, theta_desired=theta_d)
    for _ in range(round(SECONDS / PERIOD)):
        cycle()
        arm.step(DRIVE.kp * (theta_d - arm.motor_q) - DRIVE.kd * arm.motor_qd + comp, PERIOD)
    return (arm.q - POSE) * (180.0 / math.pi, 180.0 / math.pi, 1000.0)


@pytest.mark.parametrize(("degrees", "left"), [(0.0, 0.026), (20.0, 0.055)])
def test_dynamic_gravity_at_the_motors_leaves_the_sag_of_the_cables(degrees: float, left: float) -> None:
    assert abs(link_errors(None, degrees)[0]) == pytest.approx(left, abs=1e-3)


@pytest.mark.parametrize("variant", ["desired", "biased", "quasi_static", "link"])
@pytest.mark.parametrize("degrees", [0.0, 20.0])
def test_the_elastic_laws_leave_nothing_of_it(variant: str, degrees: float) -> None:
    law = rg.ElasticGravity(ROBOT, CABLES, variant, kp=DRIVE.kp)
    assert law.condition.holds
    assert np.abs(link_errors(law, degrees)).max() <= 1e-4


def test_gravity_at_the_motors_with_the_right_aim_counts_the_sag_once() -> None:
    """Aimed beyond the goal, even g(theta) leaves a thousandth of the sag: stiff cables make the variants one."""
    law = rg.ElasticGravity(ROBOT, CABLES, "motor", kp=DRIVE.kp)
    assert 1e-6 < np.abs(link_errors(law, 20.0)).max() < 1e-3
