"""Robotics Toolbox for Python: a DHRobot for dynamics (in C), its elementary transforms for kinematics (in C too)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import roboticstoolbox as rtb
from spatialmath import SE3

from comparison.arm import LEVEL, Arm, dh_row, inertia_matrix
from comparison.call import Call

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ravengc.spec import LinkSpec


def build(arm: Arm) -> rtb.DHRobot:
    """The arm; without base or friction, gravity of a level base."""

    def row(link: LinkSpec) -> rtb.RevoluteMDH:
        dh = dh_row(link)
        return rtb.RevoluteMDH(
            a=dh.a, alpha=dh.alpha, d=dh.d, m=link.mass, r=np.array(link.com), I=inertia_matrix(link)
        )

    links = [row(link) for link in arm.spec.links]
    return rtb.DHRobot(links, name="panda", tool=SE3(*arm.tool), gravity=LEVEL)


def calls(arm: Arm) -> Iterator[Call]:
    """All but the moving base and the regressor."""
    robot = build(arm)
    transforms = robot.ets()
    pose, jacobian = transforms.eval, transforms.jacob0
    Q, V, A, G = arm.q, arm.qd, arm.qdd, arm.g
    gravload, rne, inertia = robot.gravload, robot.rne, robot.inertia

    def call(operation: str, way: str, run: Any, fetches: int) -> Call:
        return Call("roboticstoolbox", operation, way, run, fetches)

    yield call("gravity", "DHRobot.gravload(gravity=)", lambda k: gravload(Q[k], gravity=G[k]), 2)
    yield call("kinematics", "ETS.eval", lambda k: pose(Q[k]), 1)
    yield call("jacobian", "ETS.jacob0", lambda k: jacobian(Q[k]), 1)
    yield call("inverse_dynamics", "DHRobot.rne", lambda k: rne(Q[k], V[k], A[k]), 3)
    yield call("mass_matrix", "DHRobot.inertia", lambda k: inertia(Q[k]), 1)
