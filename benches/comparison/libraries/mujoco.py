"""MuJoCo: only the steps that the result needs; gravity is an option of the model, a moving base a free joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco as mj
import numpy as np

from comparison.arm import LEVEL, Arm
from comparison.call import Call

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from comparison.arm import Array

    Arrays = list[Array]


def build(arm: Arm, *, floating: bool = False) -> tuple[mj.MjModel, mj.MjData]:
    """The model and its data; gravity is that of a level base, or none if it floats."""
    spec = mj.MjSpec()
    body = spec.worldbody
    if floating:
        body = body.add_body(name="base", mass=1.0, inertia=[1.0, 1.0, 1.0])
        body.add_freejoint()
    for link in arm.spec.links:
        pose, quaternion = arm.placement(link), np.empty(4)
        mj.mju_mat2Quat(quaternion, pose[:3, :3].ravel())
        xx, xy, xz, yy, yz, zz = link.inertia
        body = body.add_body(
            name=link.name,
            pos=pose[:3, 3],
            quat=quaternion,
            mass=link.mass,
            ipos=link.com,
            fullinertia=[xx, yy, zz, xy, xz, yz],
            explicitinertial=True,
        )
        body.add_joint(name=f"joint of {link.name}", type=mj.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0])
    body.add_site(name="tool", pos=arm.tool)
    model = spec.compile()
    model.opt.gravity[:] = 0.0 if floating else LEVEL
    return model, mj.MjData(model)


def calls(arm: Arm) -> Iterator[Call]:
    """All but the regressor."""

    def call(operation: str, way: str, run: Callable[[int], Any], fetches: int) -> Call:
        return Call("mujoco", operation, way, run, fetches)

    yield call("gravity", "set gravity, kinematics, comPos, rne", gravity(arm), 2)
    yield call("kinematics", "kinematics", kinematics(arm), 1)
    yield call("jacobian", "kinematics, comPos, jacSite", jacobian(arm), 1)
    yield call("inverse_dynamics", "kinematics, comPos, comVel, rne", inverse_dynamics(arm), 3)
    yield call("moving_base", "the same, free joint", moving_base(arm), 3)
    yield call("mass_matrix", "kinematics, comPos, makeM, fullM", mass_matrix(arm), 1)


def gravity(arm: Arm) -> Callable[[int], Any]:
    model, data = build(arm)
    Q, G, qpos, field, out = arm.q, arm.g, data.qpos, model.opt.gravity, np.empty(arm.n)
    frames, center, rne = mj.mj_kinematics, mj.mj_comPos, mj.mj_rne

    def run(k: int) -> Any:
        field[:] = G[k]
        qpos[:] = Q[k]
        frames(model, data)
        center(model, data)
        rne(model, data, 0, out)
        return out

    return run


def kinematics(arm: Arm) -> Callable[[int], Any]:
    model, data = build(arm)
    Q, qpos, frames, pose = arm.q, data.qpos, mj.mj_kinematics, np.eye(4)
    place, rotation = data.site_xpos[0], data.site_xmat[0].reshape(3, 3)

    def run(k: int) -> Any:
        qpos[:] = Q[k]
        frames(model, data)
        pose[:3, :3] = rotation
        pose[:3, 3] = place
        return pose

    return run


def jacobian(arm: Arm) -> Callable[[int], Any]:
    model, data = build(arm)
    Q, qpos, out = arm.q, data.qpos, np.empty((6, arm.n))
    linear, angular = out[:3], out[3:]
    frames, center, compute = mj.mj_kinematics, mj.mj_comPos, mj.mj_jacSite

    def run(k: int) -> Any:
        qpos[:] = Q[k]
        frames(model, data)
        center(model, data)
        compute(model, data, linear, angular, 0)
        return out

    return run


def newton_euler(model: mj.MjModel, data: mj.MjData, Q: Arrays, V: Arrays, A: Arrays) -> Callable[[int], Any]:
    """The recursion for whole vectors of positions, rates and accelerations."""
    qpos, qvel, qacc, out = data.qpos, data.qvel, data.qacc, np.empty(model.nv)
    frames, center, rates, rne = mj.mj_kinematics, mj.mj_comPos, mj.mj_comVel, mj.mj_rne

    def run(k: int) -> Any:
        qpos[:] = Q[k]
        qvel[:] = V[k]
        qacc[:] = A[k]
        frames(model, data)
        center(model, data)
        rates(model, data)
        rne(model, data, 1, out)
        return out[-7:]

    return run


def inverse_dynamics(arm: Arm) -> Callable[[int], Any]:
    return newton_euler(*build(arm), arm.q, arm.qd, arm.qdd)


def moving_base(arm: Arm) -> Callable[[int], Any]:
    """Without gravity the free joint's acceleration is the specific force; the long vectors are made beforehand."""
    Q = [np.concatenate([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], q]) for q in arm.q]
    V = [np.concatenate([np.zeros(3), *parts]) for parts in zip(arm.w, arm.qd, strict=True)]
    A = [np.concatenate(parts) for parts in zip(arm.f, arm.dw, arm.qdd, strict=True)]
    return newton_euler(*build(arm, floating=True), Q, V, A)


def mass_matrix(arm: Arm) -> Callable[[int], Any]:
    model, data = build(arm)
    Q, qpos, out = arm.q, data.qpos, np.empty((arm.n, arm.n))
    frames, center, make, full = mj.mj_kinematics, mj.mj_comPos, mj.mj_makeM, mj.mj_fullM

    def run(k: int) -> Any:
        qpos[:] = Q[k]
        frames(model, data)
        center(model, data)
        make(model, data)
        full(model, data, out)
        return out

    return run
