"""pinocchio: gravity is state of the model, a moving base takes a model with a floating joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from comparison.arm import KD, KP, LEVEL, TAU_MAX, Arm, inertia_matrix
from comparison.call import Call

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

PARAMETERS = [0, 1, 2, 3, 4, 5, 7, 6, 8, 9]
"""Where m hx hy hz Ixx Ixy Ixz Iyy Iyz Izz stand among pinocchio's parameters of a body."""


def build(arm: Arm, *, floating: bool = False) -> tuple[pin.Model, pin.Data, int]:
    """The model with its data and the tool's frame; gravity is that of a level base, or none if it floats."""
    model, joint = pin.Model(), 0
    if floating:
        joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    for link in arm.spec.links:
        pose = arm.placement(link)
        joint = model.addJoint(joint, pin.JointModelRZ(), pin.SE3(pose[:3, :3], pose[:3, 3]), link.name)
        body = pin.Inertia(link.mass, np.array(link.com), inertia_matrix(link))
        model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    tool = pin.Frame("tool", joint, pin.SE3(np.eye(3), arm.tool), pin.FrameType.OP_FRAME)
    frame = model.addFrame(tool)
    model.gravity.linear = np.zeros(3) if floating else LEVEL
    return model, model.createData(), frame


def calls(arm: Arm) -> Iterator[Call]:
    """All operations, each by its fastest call, with its own model and data."""

    def call(operation: str, way: str, run: Callable[[int], Any], fetches: int, **value: Any) -> Call:
        return Call("pinocchio", operation, way, run, fetches, **value)

    yield call("gravity", "set gravity, computeGeneralizedGravity", gravity(arm), 2)
    yield call("kinematics", "forwardKinematics, updateFramePlacement", kinematics(arm), 1)
    yield call("jacobian", "computeFrameJacobian", jacobian(arm), 1)
    model, data, _ = build(arm)
    Q, V, A = arm.q, arm.qd, arm.qdd
    yield call("inverse_dynamics", "rnea", lambda k: pin.rnea(model, data, Q[k], V[k], A[k]), 3)
    yield call("moving_base", "rnea, free-flyer", moving_base(arm), 3, value=lambda tau: tau[6:])
    yield call("mass_matrix", "crba", lambda k: pin.crba(model, data, Q[k]), 1)
    yield call("control", "gravity, then NumPy in place", control(arm), 4)
    order = [10 * body + place for body in range(arm.n) for place in PARAMETERS]
    compute = pin.computeJointTorqueRegressor
    regressor = call(
        "regressor",
        "computeJointTorqueRegressor",
        lambda k: compute(model, data, Q[k], V[k], A[k]),
        3,
        value=lambda rows: rows[:, order],
    )
    yield regressor


def gravity(arm: Arm) -> Callable[[int], Any]:
    model, data, _ = build(arm)
    Q, G, field, compute = arm.q, arm.g, model.gravity, pin.computeGeneralizedGravity

    def run(k: int) -> Any:
        field.linear = G[k]
        return compute(model, data, Q[k])

    return run


def control(arm: Arm) -> Callable[[int], Any]:
    """PD and limits as they are written with NumPy where nothing is to be allocated."""
    Q, V, T, held = arm.q, arm.qd, arm.target, gravity(arm)
    tau, damping = np.empty(arm.n), np.empty(arm.n)

    def run(k: int) -> Any:
        np.subtract(T[k], Q[k], out=tau)
        np.multiply(tau, KP, out=tau)
        np.multiply(V[k], KD, out=damping)
        np.subtract(tau, damping, out=tau)
        np.add(tau, held(k), out=tau)
        np.minimum(tau, TAU_MAX, out=tau)
        return np.maximum(tau, -TAU_MAX, out=tau)

    return run


def kinematics(arm: Arm) -> Callable[[int], Any]:
    model, data, frame = build(arm)
    Q, joints, tool = arm.q, pin.forwardKinematics, pin.updateFramePlacement

    def run(k: int) -> Any:
        joints(model, data, Q[k])
        return tool(model, data, frame).homogeneous

    return run


def jacobian(arm: Arm) -> Callable[[int], Any]:
    model, data, frame = build(arm)
    Q, compute, axes = arm.q, pin.computeFrameJacobian, pin.LOCAL_WORLD_ALIGNED
    return lambda k: compute(model, data, Q[k], frame, axes)


def moving_base(arm: Arm) -> Callable[[int], Any]:
    """Without gravity the floating base's acceleration is the specific force; the long vectors are made beforehand."""
    model, data, _ = build(arm, floating=True)
    Q = [np.concatenate([np.zeros(6), [1.0], q]) for q in arm.q]
    V = [np.concatenate([np.zeros(3), *parts]) for parts in zip(arm.w, arm.qd, strict=True)]
    A = [np.concatenate(parts) for parts in zip(arm.f, arm.dw, arm.qdd, strict=True)]
    compute = pin.rnea
    return lambda k: compute(model, data, Q[k], V[k], A[k])
