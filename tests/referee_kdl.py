"""A serial arm in KDL: DH rows of either convention as its segments, in axes of frame 0.

KDL takes gravity when a solver is built. A modified row stands before its joint, so its segments are one row late.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import PyKDL as kdl

if TYPE_CHECKING:
    from ravengc.spec import LinkSpec, RobotSpec

JOINTS = {"revolute": kdl.Joint.RotZ, "prismatic": kdl.Joint.TransZ, "fixed": kdl.Joint.Fixed}


class Referee:
    """Torques and poses of a serial arm, in axes of frame 0."""

    def __init__(self, spec: RobotSpec) -> None:
        self.chain = kdl.Chain()
        for link in spec.links:
            for segment in segments(link, spec.convention):
                self.chain.addSegment(segment)

    def gravity_torque(self, q, g) -> np.ndarray:
        out = kdl.JntArray(len(q))
        kdl.ChainDynParam(self.chain, kdl.Vector(*g)).JntToGravity(array(q), out)
        return np.array(list(out))

    def mass_matrix(self, q) -> np.ndarray:
        out = kdl.JntSpaceInertiaMatrix(len(q))
        kdl.ChainDynParam(self.chain, kdl.Vector.Zero()).JntToMass(array(q), out)
        return np.array([[out[i, j] for j in range(len(q))] for i in range(len(q))])

    def inverse_dynamics(self, q, qd, qdd, g) -> np.ndarray:
        out, none = kdl.JntArray(len(q)), [kdl.Wrench.Zero()] * self.chain.getNrOfSegments()
        solver = kdl.ChainIdSolver_RNE(self.chain, kdl.Vector(*g))
        solver.CartToJnt(array(q), array(qd), array(qdd), none, out)
        return np.array(list(out))

    def forward_kinematics(self, q) -> np.ndarray:
        out = kdl.Frame()
        kdl.ChainFkSolverPos_recursive(self.chain).JntToCart(array(q), out)
        return np.array([[out[i, j] for j in range(4)] for i in range(3)])

    def jacobian(self, q) -> np.ndarray:
        out = kdl.Jacobian(len(q))
        kdl.ChainJntToJacSolver(self.chain).JntToJac(array(q), out)
        return np.array([[out[i, j] for j in range(len(q))] for i in range(6)])


def segments(link: LinkSpec, convention: str) -> list[kdl.Segment]:
    """The joint and its row; a modified row is a fixed segment, and its joint with the mass another."""
    row, joint = link.placement, kdl.Joint(JOINTS[link.joint])
    if convention == "standard":
        return [kdl.Segment(joint, kdl.Frame.DH(row.a, row.alpha, row.d, row.theta), inertia(link))]
    place = kdl.Frame.DH_Craig1989(row.a, row.alpha, row.d, row.theta)
    before = kdl.Segment(kdl.Joint(kdl.Joint.Fixed), place)
    return [before, kdl.Segment(joint, kdl.Frame.Identity(), inertia(link))]


def inertia(link: LinkSpec) -> kdl.RigidBodyInertia:
    xx, xy, xz, yy, yz, zz = link.inertia
    return kdl.RigidBodyInertia(link.mass, kdl.Vector(*link.com), kdl.RotationalInertia(xx, yy, zz, xy, xz, yz))


def array(values) -> kdl.JntArray:
    out = kdl.JntArray(len(values))
    for i, value in enumerate(values):
        out[i] = float(value)
    return out
