"""The equations in plain NumPy, joint by joint, for scale: this project's own reference."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from comparison.agreement import controlled
from comparison.arm import LEVEL, Arm
from comparison.call import Call
from ravengc import reference

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


def calls(arm: Arm) -> Iterator[Call]:
    """All but the regressor, which the reference gets by evaluating the torque 70 times."""
    spec, Q, V, A, G, F, W, D = arm.spec, arm.q, arm.qd, arm.qdd, arm.g, arm.f, arm.w, arm.dw

    def call(operation: str, run: Callable[[int], Any], fetches: int) -> Call:
        return Call("numpy", operation, "plain loop", run, fetches)

    yield call("gravity", lambda k: reference.gravity_torque(spec, Q[k], G[k]), 2)
    yield call("kinematics", lambda k: reference.forward_kinematics(spec, Q[k]), 1)
    yield call("jacobian", lambda k: reference.jacobian(spec, Q[k]), 1)
    yield call("inverse_dynamics", lambda k: reference.inverse_dynamics(spec, Q[k], V[k], A[k], -LEVEL), 3)
    yield call("moving_base", lambda k: reference.inverse_dynamics(spec, Q[k], V[k], A[k], F[k], W[k], D[k]), 6)
    yield call("control", lambda k: controlled(arm, k, G[k]), 4)
    yield call("mass_matrix", lambda k: reference.mass_matrix(spec, Q[k]), 1)
