"""Resolved-rate motion: the joint rates with which a tool moves as it should, whatever its pose and its base do.

    qd = J⁺ v                                              D. Whitney, IEEE Trans. Man-Machine Systems 10(2), 1969

The arithmetic is the core's (``crates/gravcomp/src/resolved_rate.rs`` says what a step does).
:mod:`ravengc.reference.resolved_rate` is the same by singular values, as the literature writes it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ravengc import _core
from ravengc._convert import as_array, as_double, as_number, as_vector, check_choice, check_type
from ravengc.errors import ArgumentError
from ravengc.messages import shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["DAMPINGS", "LIMITS", "NULL_SPACES", "RATE_EVENTS", "TASKS", "ResolvedRate", "turning_about"]

Array = NDArray[np.float64]
Numbers: TypeAlias = "Sequence[float] | Array | float"

TASKS = ("twist", "position", "pointing", "remote_centre")
DAMPINGS = ("adaptive", "filtered", "manipulability", "constant", "selective")
LIMITS = ("scale", "qp", "manipulability")
NULL_SPACES = ("none", "limits", "posture", "manipulability")
RATE_EVENTS: dict[str, str] = _core.RATE_EVENTS
"""What can happen in a step, by name, in the order of the bits of a status word, with what it says."""


class ResolvedRate(_core.ResolvedRate):
    """Joint rates for one robot, from twists (:meth:`step`) and moving targets (:meth:`track`), bounded everywhere.

    ``task`` says what is moved: "twist", the ``frame``'s linear and angular velocity (6,), or of these the ``rows``
    that are true; "position", its origin (3,); "pointing", its origin and where its ``pointing_axis`` points, with the
    turn about that axis left free, from the same (6,); "remote_centre", its origin, with the shaft along the pointing
    axis through a trocar, from the linear velocities of both (6,). Twists are motions in the world in base axes, m/s
    and rad/s, linear first: ``base_twist`` (6,), that of the base's origin (see :func:`turning_about`), is taken off,
    so that a tool with no twist stays still in the world while its base moves; :meth:`bind` takes it from the base's
    ``Accelerometer`` too. A target is in base axes at that moment: a pose (4, 4); a point (3,); a point and the outward
    normal (6,) of the surface there, against which the pointing axis is laid; the tip's point and the trocar's (6,).
    Errors decay with ``gain`` and ``turning_gain`` (1/s; a twentieth of ``rate_hz`` unless they are given), no faster
    than ``speed_max`` (m/s) and ``turning_max`` (rad/s).

    Near singularities of the task the inverse is damped: "adaptive", λ² = λ_max² (1 - σ²/eps²) where its smallest
    singular value σ < ``eps``, exact elsewhere; "filtered", the same along that one direction; "manipulability",
    λ = λ_max (1 - w/eps) where w = sqrt(det J Jᵀ) < eps; "constant", λ_max everywhere, so that every step departs a
    little with no event; "selective", Buss and Kim's.
    Lengths weigh as radians do by ``characteristic_length``, m. What the task leaves free goes, with ``null_gain``
    (1/s), to the middle between the limits, to a ``posture`` (n,), or where manipulability grows; the task comes first.

    Rates are at most ``qd_max``, and lead no joint beyond ``q_min`` and ``q_max``: its distance from them decays with
    ``damper`` (1/s) at most. With ``limits`` "scale" the motion is slowed down as a whole, so that the tool keeps its
    direction; with "qp" the joints that are left do what those at their limits cannot, by least squares, and joints
    beyond a limit are led back; "manipulability" trades the task for manipulability besides (Haviland and Corke 2020).
    Rates start from rest, and change by at most ``qdd_max`` per second, the accelerations by ``qddd_max``, on a
    straight line: a step in the twist becomes a ramp. Limits are one number for all joints or (n,); where none are
    given, those of the robot's file count; infinite where there is none. ``midpoint`` takes J half a step ahead, where
    the arm is on average: straight lines then stay straight without a target.

    A task of more rows than the robot has coordinates is done as well as they can, by least squares; where that leaves
    something, the event "undone" and :attr:`reason` say so.

    Nothing that comes in can make a step fail: :attr:`status`, :attr:`reason`, :attr:`sigma_min`,
    :attr:`damping_used`, :attr:`scale`, :attr:`limiting_joint` and :attr:`limited_joints` say what the last one did.
    Raises ConfigError, LimitError or ArgumentError for what cannot be meant, also for ``rows``, ``remote_centre`` or a
    ``posture`` with a choice that has no use for them.
    """

    def __new__(
        cls,
        robot: Robot,
        task: Literal["twist", "position", "pointing", "remote_centre"] = "twist",
        *,
        frame: str = "tool",
        rows: Sequence[bool] | None = None,
        damping: Literal["adaptive", "filtered", "manipulability", "constant", "selective"] = "adaptive",
        eps: float = 0.04,
        lambda_max: float = 0.04,
        qd_max: Numbers | None = None,
        qdd_max: Numbers | None = None,
        qddd_max: Numbers | None = None,
        q_min: Numbers | None = None,
        q_max: Numbers | None = None,
        damper: float | None = None,
        limits: Literal["scale", "qp", "manipulability"] = "scale",
        null_space: Literal["none", "limits", "posture", "manipulability"] = "none",
        null_gain: float = 1.0,
        posture: Numbers | None = None,
        characteristic_length: float = 1.0,
        remote_centre: Sequence[float] | Array | None = None,
        pointing_axis: Sequence[float] | Array = (0.0, 0.0, 1.0),
        gain: float | None = None,
        turning_gain: float | None = None,
        speed_max: float = math.inf,
        turning_max: float = math.inf,
        midpoint: bool = False,
        rate_hz: float = 1000.0,
    ) -> Self:
        """Check what is declared, and start from rest."""
        check_type(robot, Robot, "robot")
        check_type(frame, str, "frame")
        check_type(midpoint, bool, "midpoint")
        words = _words(task=task, damping=damping, limits=limits, null_space=null_space)
        rate = as_number(rate_hz, "rate_hz")
        gain = rate / 20.0 if gain is None else as_number(gain, "gain")
        scalars = {
            "eps": eps,
            "lambda_max": lambda_max,
            "damper": min(20.0, rate) if damper is None else damper,
            "null_gain": null_gain,
            "characteristic_length": characteristic_length,
            "turning_gain": gain if turning_gain is None else turning_gain,
            "speed_max": speed_max,
            "turning_max": turning_max,
        }
        given = {"qd_max": qd_max, "q_min": q_min, "q_max": q_max, "qdd_max": qdd_max, "qddd_max": qddd_max}
        return super().__new__(
            cls,
            robot,
            frame=frame,
            rows=_rows(rows, task),
            rate_hz=rate,
            gain=gain,
            posture=_posture(robot, posture, null_space),
            remote_centre=_remote_centre(remote_centre, task),
            pointing_axis=as_vector(pointing_axis, "pointing_axis", 3),
            midpoint=midpoint,
            **words,
            **_scalars(scalars),
            **_limits(robot, given),
        )


def turning_about(pivot: Sequence[float] | Array, angular_velocity: Sequence[float] | Array) -> Array:
    """Twist (6,) of the origin of a base that turns with ``angular_velocity`` (3,) about a ``pivot`` (3,) at rest.

    All in base axes, rad/s and m. A base's inertial sensor gives the angular velocity; the pivot is where it rocks on
    its wheels, its suspension or its joint: v = -w x p.
    """
    point, w = as_vector(pivot, "pivot", 3), as_vector(angular_velocity, "angular_velocity", 3)
    return np.concatenate([np.cross(point, w), w])


def _words(**given: str) -> dict[str, Any]:
    """What is chosen from lists, each a member of its own."""
    options = {"task": TASKS, "damping": DAMPINGS, "limits": LIMITS, "null_space": NULL_SPACES}
    for name, word in given.items():
        check_choice(word, options[name], name)
    return given


def _scalars(given: dict[str, float]) -> dict[str, Any]:
    """Plain numbers."""
    return {name: as_number(x, name) for name, x in given.items()}


def _posture(robot: Robot, posture: Numbers | None, null_space: str) -> Array | None:
    """Where the joints should go, if anything says so."""
    _check_used(posture, "posture", "null_space", null_space, "posture")
    if null_space == "posture" and posture is None:
        raise ArgumentError("posture is missing: null_space 'posture' needs to know where the joints should go")
    return None if posture is None else _numbers("posture", posture, robot.n)


def _remote_centre(point: Sequence[float] | Array | None, task: str) -> Array | None:
    """Where the trocar is at first, if anything says so."""
    _check_used(point, "remote_centre", "task", task, "remote_centre")
    if task == "remote_centre" and point is None:
        raise ArgumentError(
            "remote_centre is missing: the task needs to know where the trocar is at first, in base axes"
        )
    return None if point is None else as_vector(point, "remote_centre", 3)


def _numbers(name: str, value: Numbers, n: int) -> Array:
    """One number for all, or one each."""
    numbers = as_double(value, name)
    if numbers.shape not in {(), (n,)}:
        raise ArgumentError(f"{name} must be one number or {n}, not {shown(value)}")
    return np.array(np.broadcast_to(numbers, (n,)))


def _rows(rows: object, task: str) -> Array | None:
    """Which rows of a twist count, as numbers, if anything says so."""
    _check_used(rows, "rows", "task", task, "twist")
    if rows is None:
        return None
    given = as_array(rows, "rows", kinds="biuf")
    if given.shape != (6,) or given.dtype != bool:
        raise ArgumentError(f"rows must be six truth values, linear first, not {shown(rows)}")
    return given.astype(float)


def _check_used(value: object, name: str, option: str, chosen: str, user: str) -> None:
    """Refuse what would be ignored: ``name`` is for the ``option`` "user", not for the chosen one."""
    if value is not None and chosen != user:
        raise ArgumentError(
            f"{name} is for {option} '{user}', not for '{chosen}': leave it out, or choose that {option}"
        )


def _limits(robot: Robot, given: dict[str, Numbers | None]) -> dict[str, Any]:
    """Limits as they are given, else those of the robot's file; infinite where there is none."""
    of_file = robot.spec.coordinate_limits
    defaults = {
        "qd_max": [math.inf if limit.velocity is None else limit.velocity for limit in of_file],
        "q_min": [-math.inf if limit.lower is None else limit.lower for limit in of_file],
        "q_max": [math.inf if limit.upper is None else limit.upper for limit in of_file],
    }
    chosen = {name: defaults.get(name, math.inf) if value is None else value for name, value in given.items()}
    return {name: _numbers(name, value, robot.n) for name, value in chosen.items()}
