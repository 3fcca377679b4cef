"""A serial arm in the Robotics Toolbox: DH rows of either convention, by its recursions in frames of the convention.

Its gravity is the field in world axes since 1.4, and so is ours in base axes: its world is B. It has no moving base.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import roboticstoolbox as rtb
from spatialmath import SE3

if TYPE_CHECKING:
    from ravengc.spec import LinkSpec, Pose, RobotSpec

KINDS = {
    ("standard", "revolute"): rtb.RevoluteDH,
    ("standard", "prismatic"): rtb.PrismaticDH,
    ("modified", "revolute"): rtb.RevoluteMDH,
    ("modified", "prismatic"): rtb.PrismaticMDH,
}


class Referee:
    """The same functions as :class:`ravengc.Robot`, by the toolbox.

    Its compiled recursion is wrong where the first joint slides (1.4.4 and 1.5.0), its Python text on a turned base
    (1.4.4): each is asked where it is right, the text in axes of frame 0.
    """

    def __init__(self, spec: RobotSpec) -> None:
        rows = [build_link(link, spec.convention) for link in spec.links]
        self.arm = rtb.DHRobot(rows, base=se3(spec.base), tool=se3(spec.tool))
        self.compiled = spec.links[0].joint == "revolute"
        self.bare = rtb.DHRobot([row.copy() for row in rows])
        self.turn = np.array(spec.base.rotation)

    def forward_kinematics(self, q) -> np.ndarray:
        return self.arm.fkine(q).A

    def jacobian(self, q) -> np.ndarray:
        return self.arm.jacob0(q)

    def gravity_torque(self, q, g) -> np.ndarray:
        still = np.zeros(self.arm.n)
        return self.arm.gravload(q, gravity=g) if self.compiled else self.inverse_dynamics(q, still, still, g)

    def inverse_dynamics(self, q, qd, qdd, g) -> np.ndarray:
        if self.compiled:
            return self.arm.rne(q, qd, qdd, gravity=g)
        return self.bare.rne_python(q, qd, qdd, gravity=self.turn.T @ g)

    def mass_matrix(self, q) -> np.ndarray:
        if self.compiled:
            return self.arm.inertia(q)
        still, weightless = np.zeros(self.arm.n), np.zeros(3)
        return np.array([self.inverse_dynamics(q, still, unit, weightless) for unit in np.eye(self.arm.n)])


def build_link(link: LinkSpec, convention: str) -> rtb.DHLink:
    """A row; the joint's offset stands where the coordinate is added."""
    row = link.placement
    own = {"d": row.d, "offset": row.theta} if link.joint == "revolute" else {"theta": row.theta, "offset": row.d}
    xx, xy, xz, yy, yz, zz = link.inertia
    moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return KINDS[convention, link.joint](a=row.a, alpha=row.alpha, m=link.mass, r=link.com, I=moments, **own)


def se3(pose: Pose) -> SE3:
    return SE3.Rt(np.array(pose.rotation), np.array(pose.translation), check=False)
