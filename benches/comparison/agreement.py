"""Before anything is timed: all libraries compute the same numbers, and how exactly ours are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from comparison.arm import KD, KP, LEVEL, SAMPLES, TAU_MAX, Arm, along_a_path
from ravengc import reference
from ravengc.reference.kinematics import carried, moving, origin, place

if TYPE_CHECKING:
    from collections.abc import Callable

    from comparison.arm import Array
    from comparison.call import Call

TOLERANCE = 1e-10


def expected(arm: Arm, operation: str, k: int) -> Any:
    """What the reference says, in extended precision where the machine has it; the regressor in double."""
    spec, motion = arm.spec, (arm.q[k], arm.qd[k], arm.qdd[k])
    q, qd, qdd = (values.astype(np.longdouble) for values in motion)
    compute: dict[str, Callable[[], Any]] = {
        "gravity": lambda: reference.gravity_torque(spec, q, arm.g[k]),
        "live": lambda: reference.gravity_torque(spec, q, LEVEL),
        "kinematics": lambda: reference.forward_kinematics(spec, q),
        "jacobian": lambda: reference.jacobian(spec, q),
        "inverse_dynamics": lambda: reference.inverse_dynamics(spec, q, qd, qdd, -LEVEL),
        "moving_base": lambda: reference.inverse_dynamics(spec, q, qd, qdd, arm.f[k], arm.w[k], arm.dw[k]),
        "mass_matrix": lambda: reference.mass_matrix(spec, q),
        "regressor": lambda: reference.inverse_dynamics_regressor(spec, *motion, -LEVEL),
        "resolved_rate": lambda: damped(arm, k),
        "control": lambda: controlled(arm, k, arm.g[k]),
        "control_live": lambda: controlled(arm, k, LEVEL),
    }
    return compute[operation]()


def damped(arm: Arm, k: int) -> Any:
    """J' (J J' + 0.05^2 1)^-1 times the twist (w, w') of `benches/native/`."""
    J = np.asarray(reference.jacobian(arm.spec, along_a_path(arm)[k]), dtype=np.float64)
    return J.T @ np.linalg.solve(J @ J.T + 0.05**2 * np.eye(6), np.concatenate((arm.w[k], arm.dw[k])))


def controlled(arm: Arm, k: int, g: Array) -> Any:
    """Kp (q_d - q) - Kd q' + gravity torque, within its limit."""
    pd = KP * (arm.target[k] - arm.q[k]) - KD * arm.qd[k]
    return np.clip(pd + reference.gravity_torque(arm.spec, arm.q[k], g), -TAU_MAX, TAU_MAX)


def differences(arm: Arm, calls: list[Call], samples: int = 16) -> dict[str, float]:
    """Largest difference of each call from the reference, relative to the largest number in it (or 1)."""
    found: dict[str, float] = dict.fromkeys((call.key for call in calls), 0.0)
    for operation in dict.fromkeys(call.operation for call in calls):
        for k in range(0, SAMPLES, SAMPLES // samples):
            wanted = expected(arm, operation, k)
            scale = max(1.0, float(np.abs(wanted).max()))
            for call in calls:
                if call.operation == operation:
                    off = float(np.abs(call.value(call.run(k)) - wanted).max()) / scale
                    # NaN counts as a difference: max() would forget it.
                    found[call.key] = off if not off <= found[call.key] else found[call.key]
    return found


def disagreeing(found: dict[str, float]) -> list[str]:
    """Calls that are off by more than the tolerance."""
    return [key for key, off in found.items() if not off <= TOLERANCE]


def rounding_unit(arm: Arm, k: int) -> Any:
    """eps Σ m |g| |r| (n,), r from joint i to a mass: what one rounding of each term of its sum could change."""
    placed = place(arm.spec, arm.q[k])
    g = np.linalg.norm(arm.g[k])
    units = [
        sum(body.link.mass * g * np.linalg.norm(body.com - origin(joint.frame)) for body in carried(placed[i:]))
        for i, joint in enumerate(moving(placed))
    ]
    return np.finfo(np.float64).eps * np.array(units, dtype=np.float64)


def accuracy(arm: Arm, calls: list[Call], samples: int) -> dict[str, float] | None:
    """Largest error of each gravity torque in units of :func:`rounding_unit`; ``None`` without extended precision."""
    if np.finfo(np.longdouble).eps > 1e-18:
        return None
    torques = [call for call in calls if call.operation == "gravity"]
    worst = dict.fromkeys((call.key for call in torques), 0.0)
    for k in range(samples):
        wanted, unit = expected(arm, "gravity", k), rounding_unit(arm, k)
        for call in torques:
            error = np.abs(call.value(call.run(k)) - wanted) / unit
            worst[call.key] = max(worst[call.key], float(error.max()))
    return worst
