"""A robot in Pinocchio, built joint by joint from the description's rows, on a fixed root or on a free one.

Pinocchio wants a tree's joints depth first, or its mass matrix and Jacobians are silently wrong: ``columns`` leads back
to the order of the description. Gravity is state of its model, so every call here sets it. The free root carries
``BALLAST`` (1 kg, 1 kg·m² at the base origin), without which its articulated inertia may be singular.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ravengc.spec import DhRow
from referee_coupling import coupling

if TYPE_CHECKING:
    from ravengc.spec import LinkSpec, Pose, RobotSpec

Z = np.array((0.0, 0.0, 1.0))
REST = np.zeros(3)
POSITION = (0.3, -1.1, 2.0)
ATTITUDE = pin.Quaternion(0.5, -0.1, 0.7, 0.5).normalized()
VELOCITY = np.array((1.5, -2.0, 0.5))  # of the base origin, in base axes
GRAVITY = np.array((3.0, -7.0, -11.0))  # in world axes
BALLAST = pin.Inertia(1.0, REST, np.eye(3))
KINDS = {"revolute": pin.JointModelRevoluteUnaligned, "prismatic": pin.JointModelPrismaticUnaligned}
FREE = 6
OURS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Order of an inertia's entries here: xx xy xz yy yz zz."""
THEIRS = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Order of an inertia's entries in Pinocchio's parameters: xx xy yy xz yz zz."""


class Tree:
    """A Pinocchio model of a robot, the joint and the pose on it of every link, and its columns in our order."""

    def __init__(self, spec: RobotSpec, *, free: bool) -> None:
        self.model = pin.Model()
        root = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root") if free else 0
        self.model.appendBodyToJoint(root, BALLAST, pin.SE3.Identity())
        self.places: dict[str | None, tuple[int, pin.SE3]] = {None: (root, se3(spec.base))}
        self.children: dict[str | None, list[LinkSpec]] = defaultdict(list)
        for link in spec.links:
            self.children[link.parent].append(link)
        self.grow(spec.convention, None)
        tip, pose = self.places[spec.tip or spec.links[-1].name]
        self.add_frame("tool", tip, pose * se3(spec.tool))
        self.joints = [self.places[link.name][0] for link in spec.moving_links]
        self.columns = np.array([self.model.joints[joint].idx_v for joint in self.joints])
        self.data = self.model.createData()

    def grow(self, convention: str, parent: str | None) -> None:
        """Add what hangs on a link, depth first."""
        carrier, pose = self.places[parent]
        for link in self.children[parent]:
            before, axis, after = steps(link, convention)
            place = carrier, pose * before * after
            if link.joint != "fixed":
                place = self.model.addJoint(carrier, KINDS[link.joint](axis), pose * before, link.name), after
            self.places[link.name] = place
            self.model.appendBodyToJoint(place[0], inertia(link), place[1])
            self.add_frame(link.name, *place)
            self.grow(convention, link.name)

    def add_frame(self, name: str, joint: int, pose: pin.SE3) -> None:
        self.model.addFrame(pin.Frame(name, joint, 0, pose, pin.FrameType.OP_FRAME))


class Referee:
    """The same functions as :class:`ravengc.Robot`, by Pinocchio; base motions as (f, w, dw)."""

    def __init__(self, spec: RobotSpec) -> None:
        self.coupling, self.offset = coupling(spec)
        self.still, self.free = Tree(spec, free=False), Tree(spec, free=True)

    def gravity_torque(self, q, g) -> np.ndarray:
        model, data, q = self.standing(q, g)
        return self.coupling.T @ pin.computeGeneralizedGravity(model, data, q)[self.still.columns]

    def gravity_stiffness(self, q, g) -> np.ndarray:
        model, data, q = self.standing(q, g)
        slope = pin.computeGeneralizedGravityDerivatives(model, data, q)
        return self.mixed(slope[np.ix_(self.still.columns, self.still.columns)])

    def potential_energy(self, q, g) -> float:
        return pin.computePotentialEnergy(*self.standing(q, g))

    def center_of_mass(self, q) -> np.ndarray:
        return pin.centerOfMass(*self.standing(q))

    def mass_matrix(self, q) -> np.ndarray:
        upper = np.triu(pin.crba(*self.standing(q)))
        full = upper + np.triu(upper, 1).T
        return self.mixed(full[np.ix_(self.still.columns, self.still.columns)])

    def forward_kinematics(self, q, frame: str) -> np.ndarray:
        model, data, q = self.standing(q)
        pin.framesForwardKinematics(model, data, q)
        return data.oMf[model.getFrameId(frame)].homogeneous

    def jacobian(self, q, frame: str, axes: str) -> np.ndarray:
        model, data, q = self.standing(q)
        chosen = pin.LOCAL_WORLD_ALIGNED if axes == "base" else pin.LOCAL
        rows = pin.computeFrameJacobian(model, data, q, model.getFrameId(frame), chosen)
        return rows.reshape(6, -1)[:, self.still.columns] @ self.coupling  # a single column comes without its axis

    def inverse_dynamics(self, q, qd, qdd, f, w, dw) -> np.ndarray:
        return self.coupling.T @ self.forces(q, qd, qdd, f, w, dw)[self.free.columns]

    def base_wrench(self, q, qd, qdd, f, w, dw) -> np.ndarray:
        """What the root's joint exerts, less what the ballast needs."""
        return self.forces(q, qd, qdd, f, w, dw)[:FREE] - np.concatenate([f, dw])

    def inverse_dynamics_spun_up(self, q, qd, qdd, f, dw) -> np.ndarray:
        """On a base that turns with ``dw`` but not yet with ``w``: by the angular part of the model's gravity."""
        model, data, q = self.standing(q, -f, -dw)
        motion = (self.permuted(self.coupling @ x) for x in (qd, qdd))
        return self.coupling.T @ pin.rnea(model, data, q, *motion)[self.still.columns]

    def forward_dynamics_spun_up(self, q, qd, tau, f, dw) -> np.ndarray:
        """By the articulated-body algorithm, on the same base; robots without coupling."""
        model, data, q = self.standing(q, -f, -dw)
        return pin.aba(model, data, q, self.permuted(qd), self.permuted(tau))[self.still.columns]

    def accelerations(self, q, qd, tau, wrench, f, w, dw) -> tuple[np.ndarray, np.ndarray]:
        """(f, dw) of the free root and the joints' qdd under their torques and the mount's wrench; no coupling.

        The ballast's share is added to the wrench; f, dw name only the motion that it is to have.
        """
        qs, v, _ = self.flying(q, qd, np.zeros_like(qd), f, w, dw)
        effort = np.zeros(self.free.model.nv)
        effort[:FREE], effort[self.free.columns] = wrench + np.concatenate([f, dw]), tau
        found = pin.aba(self.free.model, self.free.data, qs, v, effort)
        linear = found[:3] + np.cross(w, VELOCITY) - ATTITUDE.matrix().T @ GRAVITY
        return np.concatenate([linear, found[3:FREE]]), found[self.free.columns]

    def inverse_dynamics_regressor(self, q, qd, qdd, f, w, dw) -> np.ndarray:
        """Pinocchio's columns are about its joints' frames; here they lead to link frames in our order."""
        rows = pin.computeJointTorqueRegressor(self.free.model, self.free.data, *self.flying(q, qd, qdd, f, w, dw))[
            self.free.columns
        ]
        blocks = [rows[:, 10 * (joint - 1) : 10 * joint] @ self.change(joint) for joint in self.free.joints]
        return self.coupling.T @ np.hstack(blocks)

    def inertial_parameters(self) -> np.ndarray:
        return np.concatenate(
            [
                np.linalg.solve(self.change(joint), self.free.model.inertias[joint].toDynamicParameters())
                for joint in self.free.joints
            ]
        )

    def change(self, joint: int) -> np.ndarray:
        """Parameters of a body about its joint's frame, in Pinocchio's order, from those about its link frame."""
        pose = next(pose for carrier, pose in self.free.places.values() if carrier == joint).homogeneous
        return np.transpose([from_pseudo_inertia(pose @ pseudo_inertia(unit) @ pose.T) for unit in np.eye(10)])

    def forces(self, q, qd, qdd, f, w, dw) -> np.ndarray:
        return pin.rnea(self.free.model, self.free.data, *self.flying(q, qd, qdd, f, w, dw))

    def flying(self, q, qd, qdd, f, w, dw) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, rates and accelerations with the free root: it feels f in a world with gravity of its own."""
        free = self.free
        free.model.gravity = pin.Motion(GRAVITY, REST)
        position, rate, acceleration = np.zeros(free.model.nq), np.zeros(free.model.nv), np.zeros(free.model.nv)
        position[:3], position[3:7] = POSITION, ATTITUDE.coeffs()
        rate[:3], rate[3:FREE] = VELOCITY, w
        acceleration[:3] = f + ATTITUDE.matrix().T @ GRAVITY - np.cross(w, VELOCITY)  # of the twist, not of a point
        acceleration[3:FREE] = dw
        position[free.columns + 1] = self.coupling @ q + self.offset
        rate[free.columns], acceleration[free.columns] = self.coupling @ qd, self.coupling @ qdd
        return position, rate, acceleration

    def standing(self, q, g=REST, turning=REST) -> tuple[pin.Model, pin.Data, np.ndarray]:
        self.still.model.gravity = pin.Motion(np.asarray(g), np.asarray(turning))
        return self.still.model, self.still.data, self.permuted(self.coupling @ q + self.offset)

    def permuted(self, values: np.ndarray) -> np.ndarray:
        mine = np.zeros(len(values))
        mine[self.still.columns] = values
        return mine

    def mixed(self, matrix: np.ndarray) -> np.ndarray:
        return self.coupling.T @ matrix @ self.coupling


def steps(link: LinkSpec, convention: str) -> tuple[pin.SE3, np.ndarray, pin.SE3]:
    """What leads from the parent to the joint, the joint's axis, and what leads from there to the link frame."""
    row = link.placement
    if not isinstance(row, DhRow):
        return se3(row.pose), np.array(row.axis), pin.SE3.Identity()
    about_z = pin.SE3(pin.utils.rotate("z", row.theta), row.d * Z)
    about_x = pin.SE3(pin.utils.rotate("x", row.alpha), np.array((row.a, 0.0, 0.0)))
    if convention == "modified":
        return about_x * about_z, Z, pin.SE3.Identity()
    return pin.SE3.Identity(), Z, about_z * about_x


def se3(pose: Pose) -> pin.SE3:
    return pin.SE3(np.array(pose.rotation), np.array(pose.translation))


def inertia(link: LinkSpec) -> pin.Inertia:
    return pin.Inertia(link.mass, np.array(link.com), symmetric(link.inertia, OURS))


def symmetric(entries, order) -> np.ndarray:
    matrix = np.zeros((3, 3))
    for entry, (i, j) in zip(entries, order, strict=True):
        matrix[i, j] = matrix[j, i] = entry
    return matrix


def pseudo_inertia(parameters: np.ndarray) -> np.ndarray:
    """∫ [p; 1] [p; 1]ᵀ dm of a body with [m, h, I about the frame's origin], our order."""
    moments = symmetric(parameters[4:], OURS)
    spread = np.trace(moments) / 2 * np.eye(3) - moments
    first = parameters[1:4, None]
    return np.block([[spread, first], [first.T, parameters[:1]]])


def from_pseudo_inertia(matrix: np.ndarray) -> np.ndarray:
    """[m, h, I about the frame's origin] in Pinocchio's order."""
    moments = np.trace(matrix[:3, :3]) * np.eye(3) - matrix[:3, :3]
    return np.array([matrix[3, 3], *matrix[:3, 3], *(moments[i, j] for i, j in THEIRS)])
