"""A serial arm in KDL: DH rows of either convention as its segments, in axes of frame 0.

KDL takes gravity when a solver is built. A modified row stands before its joint, so its segments are one row late.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import PyKDL

if TYPE_CHECKING:
    from ravengc.spec import LinkSpec, RobotSpec

JOINTS = {"revolute": PyKDL.Joint.RotZ, "prismatic": PyKDL.Joint.TransZ, "fixed": PyKDL.Joint.Fixed}


class Referee:
    """Torques and poses of a serial arm, in axes of frame 0."""

    def __init__(self, spec: RobotSpec) -> None:
        self.chain = PyKDL.Chain()
        for link in spec.links:
            for segment in segments(link, spec.convention):
                self.chain.addSegment(segment)

    def gravity_torque(self, q, g) -> np.ndarray:
        out = PyKDL.JntArray(len(q))
        PyKDL.ChainDynParam(self.chain, PyKDL.Vector(*g)).JntToGravity(array(q), out)
        return np.array(list(out))

    def mass_matrix(self, q) -> np.ndarray:
        out = PyKDL.JntSpaceInertiaMatrix(len(q))
        PyKDL.ChainDynParam(self.chain, PyKDL.Vector.Zero()).JntToMass(array(q), out)
        return np.array([[out[i, j] for j in range(len(q))] for i in range(len(q))])

    def inverse_dynamics(self, q, qd, qdd, g) -> np.ndarray:
        out, none = PyKDL.JntArray(len(q)), [PyKDL.Wrench.Zero()] * self.chain.getNrOfSegments()
        solver = PyKDL.ChainIdSolver_RNE(self.chain, PyKDL.Vector(*g))
        solver.CartToJnt(array(q), array(qd), array(qdd), none, out)
        return np.array(list(out))

    def forward_kinematics(self, q) -> np.ndarray:
        out = PyKDL.Frame()
        PyKDL.ChainFkSolverPos_recursive(self.chain).JntToCart(array(q), out)
        return np.array([[out[i, j] for j in range(4)] for i in range(3)])

    def jacobian(self, q) -> np.ndarray:
        out = PyKDL.Jacobian(len(q))
        PyKDL.ChainJntToJacSolver(self.chain).JntToJac(array(q), out)
        return np.array([[out[i, j] for j in range(len(q))] for i in range(6)])


def segments(link: LinkSpec, convention: str) -> list[PyKDL.Segment]:
    """The joint and its row; a modified row is a fixed segment, and its joint with the mass another."""
    row, joint = link.placement, PyKDL.Joint(JOINTS[link.joint])
    if convention == "standard":
        return [PyKDL.Segment(joint, PyKDL.Frame.DH(row.a, row.alpha, row.d, row.theta), inertia(link))]
    place = PyKDL.Frame.DH_Craig1989(row.a, row.alpha, row.d, row.theta)
    before = PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.Fixed), place)
    return [before, PyKDL.Segment(joint, PyKDL.Frame.Identity(), inertia(link))]


def inertia(link: LinkSpec) -> PyKDL.RigidBodyInertia:
    xx, xy, xz, yy, yz, zz = link.inertia
    return PyKDL.RigidBodyInertia(link.mass, PyKDL.Vector(*link.com), PyKDL.RotationalInertia(xx, yy, zz, xy, xz, yz))


def array(values) -> PyKDL.JntArray:
    out = PyKDL.JntArray(len(values))
    for i, value in enumerate(values):
        out[i] = float(value)
    return out
