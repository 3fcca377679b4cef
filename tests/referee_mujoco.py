"""A robot in MuJoCo, built body by body from the reference's frames: nothing of the simulator's own model writer.

The base hangs on a free joint, turned and moving somehow in a world with gravity of its own; what the robot feels in
base axes is chosen through the joint's acceleration. So the results must not depend on where the base is, on how fast
it flies, or on how much of the specific force is gravity. Coupled robots are compared in their coordinates.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ravengc import reference as ref
from referee_coupling import coupling

if TYPE_CHECKING:
    from ravengc.spec import LinkSpec, RobotSpec

POSITION = (0.3, -1.1, 2.0)
ATTITUDE = np.array((0.5, -0.1, 0.7, 0.5)) / np.linalg.norm((0.5, -0.1, 0.7, 0.5))
VELOCITY = (1.5, -2.0, 0.5)
GRAVITY = np.array((3.0, -7.0, -11.0))
KINDS = {"revolute": mujoco.mjtJoint.mjJNT_HINGE, "prismatic": mujoco.mjtJoint.mjJNT_SLIDE}
FREE = 6


class Referee:
    """The same functions as :class:`ravengc.Robot`, by MuJoCo; base motions as (f, w, dw)."""

    def __init__(self, spec: RobotSpec) -> None:
        self.coupling, self.offset = coupling(spec)
        self.model = build(spec)
        self.columns = np.array([self.model.joint(link.name).dofadr[0] for link in spec.moving_links])
        self.data = mujoco.MjData(self.model)
        self.turn = np.zeros(9)
        mujoco.mju_quat2Mat(self.turn, ATTITUDE)
        self.turn = self.turn.reshape(3, 3)

    def inverse_dynamics(self, q, qd, qdd, f, w, dw) -> np.ndarray:
        return self.coupling.T @ self.forces(q, qd, qdd, f, w, dw)[self.columns]

    def base_wrench(self, q, qd, qdd, f, w, dw) -> np.ndarray:
        """A free joint's force is in world axes, its moment in those of the body."""
        wrench = self.forces(q, qd, qdd, f, w, dw)[:FREE]
        return np.concatenate([self.turn.T @ wrench[:3], wrench[3:]])

    def gravity_torque(self, q, g) -> np.ndarray:
        still = np.zeros(self.coupling.shape[1])
        return self.inverse_dynamics(q, still, still, -g, np.zeros(3), np.zeros(3))

    def forces(self, q, qd, qdd, f, w, dw) -> np.ndarray:
        """Generalised forces of the free base and of all joints of the mechanism."""
        data = self.data
        self.put(q)
        data.qvel[:] = self.motion(VELOCITY, w, qd)
        data.qacc[:] = self.motion(self.turn @ f + GRAVITY, dw, qdd)
        mujoco.mj_comVel(self.model, data)
        found = np.zeros(self.model.nv)
        mujoco.mj_rne(self.model, data, 1, found)
        return found

    def mass_matrix(self, q) -> np.ndarray:
        self.put(q)
        mujoco.mj_crb(self.model, self.data)
        momenta = np.zeros((self.coupling.shape[1], self.model.nv))
        for momentum, qd in zip(momenta, np.eye(len(momenta)), strict=True):
            mujoco.mj_mulM(self.model, self.data, momentum, self.motion(np.zeros(3), np.zeros(3), qd))
        return momenta[:, self.columns] @ self.coupling

    def forward_kinematics(self, q, frame: str) -> np.ndarray:
        self.put(q)
        place = self.place(frame)
        pose = np.eye(4)
        pose[:3, :3] = self.turn.T @ place.xmat.reshape(3, 3)
        pose[:3, 3] = self.turn.T @ (place.xpos - POSITION)
        return pose

    def jacobian(self, q, frame: str, axes: str) -> np.ndarray:
        self.put(q)
        place = self.place(frame)
        linear, angular = np.zeros((2, 3, self.model.nv))
        body = self.model.site("tool").bodyid[0] if frame == "tool" else self.model.body(frame).id
        mujoco.mj_jac(self.model, self.data, linear, angular, place.xpos, body)
        turn = self.turn if axes == "base" else place.xmat.reshape(3, 3)
        return np.vstack([turn.T @ linear, turn.T @ angular])[:, self.columns] @ self.coupling

    def center_of_mass(self, q) -> np.ndarray:
        """Of the bodies that some joint moves: those not welded to the base."""
        self.put(q)
        mass = self.model.body_mass * (self.model.body_weldid > self.model.body("base").id)
        return self.turn.T @ (mass @ self.data.xipos / mass.sum() - POSITION)

    def motion(self, linear, angular, joints) -> np.ndarray:
        """Rates or accelerations of the base and of the mechanism's joints in MuJoCo's order."""
        found = np.zeros(self.model.nv)
        found[:3], found[3:FREE], found[self.columns] = linear, angular, self.coupling @ joints
        return found

    def place(self, frame: str):
        return self.data.site("tool") if frame == "tool" else self.data.body(frame)

    def put(self, q) -> None:
        """Set the pose and work out where everything is; the base stands as always."""
        self.data.qpos[: FREE + 1] = *POSITION, *ATTITUDE
        self.data.qpos[self.columns + 1] = (
            self.coupling @ q + self.offset
        )  # a free joint has a position more than rates
        self.data.qvel[:] = 0.0
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)


def build(spec: RobotSpec) -> mujoco.MjModel:
    """All bodies where the reference puts them when every joint of the mechanism is at zero."""
    free = replace(spec, coupling=None)
    rest = np.zeros(len(free.moving_links))
    frames: dict[str | None, np.ndarray] = {None: np.eye(4), **ref.link_frames(free, rest)}
    axes = dict(zip((link.name for link in free.moving_links), ref.joint_axes(free, rest), strict=True))
    model = mujoco.MjSpec()
    model.option.gravity = GRAVITY
    base = model.worldbody.add_body(name="base")
    base.add_freejoint()
    base.explicitinertial, base.mass, base.inertia = True, 1.0, np.ones(3)
    bodies = {None: base}
    for link in spec.links:
        pos, quat = relative(frames[link.parent], frames[link.name])
        body = bodies[link.name] = bodies[link.parent].add_body(name=link.name, pos=pos, quat=quat)
        body.explicitinertial = True
        body.mass, body.inertia, body.ipos, body.iquat = 1.0, np.ones(3), link.com, quaternion(principal(link)[1])
        if link.joint != "fixed":
            direction, point = axes[link.name]
            frame = frames[link.name]
            here = frame[:3, :3].T @ (point - frame[:3, 3])
            body.add_joint(name=link.name, type=KINDS[link.joint], axis=frame[:3, :3].T @ direction, pos=here)
    tip = spec.tip or spec.links[-1].name
    pos, quat = relative(frames[tip], frames["tool"])
    bodies[tip].add_site(name="tool", pos=pos, quat=quat)
    return with_masses(model.compile(), spec)


def with_masses(model: mujoco.MjModel, spec: RobotSpec) -> mujoco.MjModel:
    """The masses and principal moments of the links in place of those compiled; the base has none."""
    model.body_mass[:], model.body_inertia[:] = 0.0, 0.0
    for link in spec.links:
        body = model.body(link.name).id
        model.body_mass[body], model.body_inertia[body] = link.mass, principal(link)[0]
    model.body_subtreemass[:] = model.body_mass
    for body in reversed(range(1, model.nbody)):
        model.body_subtreemass[model.body_parentid[body]] += model.body_subtreemass[body]
    return model


def relative(parent: np.ndarray, child: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and quaternion of a frame in another."""
    turn = parent[:3, :3].T
    return turn @ (child[:3, 3] - parent[:3, 3]), quaternion(turn @ child[:3, :3])


def quaternion(rotation: np.ndarray) -> np.ndarray:
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, rotation.ravel())
    return found


def principal(link: LinkSpec) -> tuple[np.ndarray, np.ndarray]:
    """Principal moments of inertia and their axes, a rotation."""
    xx, xy, xz, yy, yz, zz = link.inertia
    moments, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return moments, axes
