"""Robots with their base, tool and payload set, and all that shows how they are set."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc.spec import Pose
from strategies import PAYLOAD, POSE, Case, cases

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

theorem = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
TURNED = Pose(rotation=((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), translation=(0.1, 0.2, -0.3))
HANGING = Pose(rotation=((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)), translation=(0.0, 0.5, 2.0))
LOAD = (1.5, (0.01, -0.02, 0.1), (0.01, 0.001, 0.0, 0.02, 0.0, 0.015))


def bits(robot: rg.Robot, case: Case) -> bytes:
    """Bits of the results that base, tool and payload go into, for one motion."""
    q, qd, qdd, f, w, dw = case.motion
    base = rg.BaseMotion(specific_force=f, angular_velocity=w, angular_acceleration=dw)
    results = [
        *(robot.forward_kinematics(q, frame) for frame in robot.frame_names),
        robot.jacobian(q),
        robot.gravity_torque(q, case.g),
        robot.gravity_torque_batch(q[None], case.g),
        robot.inverse_dynamics(q, qd, qdd, base),
        robot.base_wrench(q, qd, qdd, base),
        robot.mass_matrix(q),
        robot.center_of_mass(q),
        robot.inertial_parameters(),
    ]
    return b"".join(result.tobytes() for result in results)


def moving(spec: RobotSpec) -> Case:
    """Some motion of a robot."""
    n = len(spec.coordinate_names)
    q, qd, qdd = (size * np.linspace(-0.7, 1.1, n) for size in (1.0, -2.0, 3.0))
    return Case(spec, q, qd, qdd, np.array([1.0, -2.0, 9.5]), np.array([0.1, 0.2, -0.3]), np.array([0.5, -1.0, 2.0]))


def words(robot: rg.Robot) -> tuple[object, ...]:
    return robot.base, robot.tool, robot.tip, robot.payload


def set_base(robot: rg.Robot, pose: Pose) -> None:
    robot.set_base(pose.rotation, pose.translation)


def set_tool(robot: rg.Robot, pose: Pose, link: str | None = None) -> None:
    robot.set_tool(pose.rotation, pose.translation, link)


def change(robot: rg.Robot, draw: st.DrawFn) -> None:
    """One call of a setter."""
    what = draw(st.sampled_from(("base", "tool", "payload", "nothing")))
    if what == "base":
        set_base(robot, draw(POSE))
    elif what == "tool":
        set_tool(robot, draw(POSE), draw(st.sampled_from((None, *robot.frame_names))))
    elif what == "payload":
        robot.set_payload(*draw(PAYLOAD))
    else:
        robot.clear_payload()


@st.composite
def settled(draw: st.DrawFn) -> tuple[rg.Robot, Case]:
    """Any robot after some changes, and a motion of it."""
    case = draw(cases(most=8))
    robot = rg.Robot(case.spec)
    for _ in range(draw(st.integers(0, 6))):
        change(robot, draw)
    return robot, case
