"""Prescribed motions of a robot's base: six sinusoids whose position, velocity and acceleration are known exactly.

The base is carried by three slides along the world's axes and three hinges, one after the other, about the axes u1,
u2, u3 through a pivot that is fixed in the base. With s(t) the slides, a(t) the hinge angles and c the pivot in base
axes,

    R_WB = rot(u1, a1) rot(u2, a2) rot(u3, a3)          p_WB = c + s - R_WB c

so a simulator that has slide and hinge joints carries the same base with the same six numbers. (A body that is moved
without joints has no velocity, and an accelerometer on it would see the tilt alone.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc._convert import as_double, as_number, as_vector, check_type
from ravengc.config.physical import LARGEST, TOLERANCE
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import shown

__all__ = ["BaseState", "BaseTrajectory", "level", "oscillating", "parse_base", "rocking", "tilted"]

Array = NDArray[np.float64]
Axis = str | Sequence[float]

NAMED_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
WORLD_GRAVITY = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))


class BaseState(NamedTuple):
    """Coordinates of the base, each (6,): three slides (m), then three hinges (rad), and their two time derivatives."""

    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class BaseTrajectory:
    """Each coordinate i of the base is offset_i + amplitude_i sin(2 pi hz_i t + phase_i), for all time.

    ``offset``, ``amplitude`` (m, rad), ``hz`` and ``phase`` (rad) have six numbers: slides x, y, z, then the hinges
    about the rows of ``axes`` (orthonormal, base axes at level). ``pivot`` (m, base axes) is the point the hinges
    turn about. Raises ArgumentError for other shapes, numbers that are not finite or above 1e9, and axes that are not
    orthonormal.
    """

    offset: Array = field(default_factory=lambda: np.zeros(6))
    amplitude: Array = field(default_factory=lambda: np.zeros(6))
    hz: Array = field(default_factory=lambda: np.zeros(6))
    phase: Array = field(default_factory=lambda: np.zeros(6))
    axes: Array = field(default_factory=lambda: np.eye(3))
    pivot: Array = field(default_factory=lambda: np.zeros(3))
    description: str = "level"

    def __post_init__(self) -> None:
        """Turn what was given as lists into arrays, and check them."""
        for name, n in (("offset", 6), ("amplitude", 6), ("hz", 6), ("phase", 6), ("pivot", 3)):
            object.__setattr__(self, name, as_vector(getattr(self, name), name, n, LARGEST).copy())
        object.__setattr__(self, "axes", _orthonormal(self.axes))
        check_type(self.description, str, "description")

    def state(self, t: float) -> BaseState:
        """The six coordinates at time ``t`` (s) with their velocities and accelerations."""
        rate = 2.0 * np.pi * self.hz
        angle = rate * as_number(t, "t") + self.phase
        swing = self.amplitude * np.sin(angle)
        return BaseState(self.offset + swing, self.amplitude * rate * np.cos(angle), -rate * rate * swing)

    def rotation(self, t: float) -> Array:
        """R_WB at time ``t``, (3, 3): base axes to world axes."""
        first, second, third = self._hinge_rotations(self.state(t).position)
        return first @ second @ third

    def position(self, t: float) -> Array:
        """World position of the base origin at time ``t`` (m); zero when the base is level and not displaced."""
        return self.pivot + self.state(t).position[:3] - self.rotation(t) @ self.pivot

    def motion(self, t: float) -> ravengc.BaseMotion:
        """Specific force at the base origin, angular velocity and angular acceleration at time ``t``, in base axes."""
        force, rate, acceleration = self.motion_at(t, np.zeros(3))
        return ravengc.BaseMotion(specific_force=force, angular_velocity=rate, angular_acceleration=acceleration)

    def motion_at(self, t: float, point: Sequence[float] | Array) -> tuple[Array, Array, Array]:
        """Specific force at ``point`` (m, base axes), angular velocity and angular acceleration, all in base axes.

        f = R_WB^T (s'' - g) + w' x d + w x (w x d), with d from the pivot to the point: what an ideal accelerometer
        reads.
        """
        state = self.state(t)
        first, second, third = self._hinge_rotations(state.position)
        rate, acceleration = self._angular(state, second, third)
        arm = as_vector(point, "point", 3, LARGEST) - self.pivot
        force = (first @ second @ third).T @ (state.acceleration[:3] - WORLD_GRAVITY)
        force += np.cross(acceleration, arm) + np.cross(rate, np.cross(rate, arm))
        return force, rate, acceleration

    def _hinge_rotations(self, position: Array) -> tuple[Array, Array, Array]:
        first, second, third = (axis_rotation(axis, angle) for axis, angle in zip(self.axes, position[3:], strict=True))
        return first, second, third

    def _angular(self, state: BaseState, second: Array, third: Array) -> tuple[Array, Array]:
        """Angular velocity and acceleration in base axes: each hinge adds its own to what those before it give."""
        rate, acceleration = np.zeros(3), np.zeros(3)
        for i, rotation in enumerate((np.eye(3), second, third)):
            own_rate, own_acceleration = self.axes[i] * state.velocity[3 + i], self.axes[i] * state.acceleration[3 + i]
            rate = rotation.T @ rate
            acceleration = rotation.T @ acceleration + np.cross(rate, own_rate) + own_acceleration
            rate = rate + own_rate
        return rate, acceleration


def level() -> BaseTrajectory:
    """Stay at rest, as mounted."""
    return BaseTrajectory()


def tilted(degrees: float, axis: Axis = "x") -> BaseTrajectory:
    """Stay at rest, turned by ``degrees`` about ``axis`` (a vector in base axes, or "x", "y", "z")."""
    axes, degrees = hinge_axes(axis), as_number(degrees, "degrees")
    if not abs(degrees) <= LARGEST:
        raise ConfigError(f"degrees must be a number of at most {LARGEST:g}, not {degrees:g}")
    offset = np.array((0.0, 0.0, 0.0, np.deg2rad(degrees), 0.0, 0.0))
    return BaseTrajectory(offset=offset, axes=axes, description=f"tilted {degrees:g} deg about {_axis_text(axes)}")


def rocking(
    low_deg: float, high_deg: float, *, hz: float, axis: Axis = "x", pivot: Sequence[float] = (0.0, 0.0, 0.0)
) -> BaseTrajectory:
    """Rock between two angles (deg) about ``axis`` through ``pivot`` (m, base axes), ``hz`` times a second.

    The angle is mean - half range * cos(2 pi hz t): it starts at the low end, at rest.
    """
    axes = hinge_axes(axis)
    low_deg, high_deg, hz = as_number(low_deg, "low_deg"), as_number(high_deg, "high_deg"), as_number(hz, "hz")
    if not (abs(low_deg) <= LARGEST and abs(high_deg) <= LARGEST and 0.0 < hz <= LARGEST):
        problem = f"the angles must be finite and hz a positive number, all at most {LARGEST:g}"
        raise ConfigError(f"rocking({low_deg}, {high_deg}, hz={hz}): {problem}")
    mean, half = np.deg2rad((low_deg + high_deg) / 2.0), np.deg2rad((high_deg - low_deg) / 2.0)
    first_hinge = np.eye(6)[3]
    return BaseTrajectory(
        offset=mean * first_hinge,
        amplitude=half * first_hinge,
        hz=hz * first_hinge,
        phase=-np.pi / 2.0 * first_hinge,
        axes=axes,
        pivot=as_double(pivot, "pivot"),
        description=f"rocking {low_deg:g} to {high_deg:g} deg at {hz:g} Hz about {_axis_text(axes)}",
    )


def parse_base(text: str, *, axis: Axis = "x", pivot: Sequence[float] = (0.0, 0.0, 0.0)) -> BaseTrajectory:
    """Read ``level``, ``tilt:DEG`` or ``rocking:LOW:HIGH:HZ`` (deg, Hz); ConfigError for anything else."""
    check_type(text, str, "text")
    kind, *words = text.split(":")
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    match kind, numbers:
        case "level", [] if not words:
            return level()
        case "tilt", [degrees]:
            return tilted(degrees, axis)
        case "rocking", [low, high, hz]:
            return rocking(low, high, hz=hz, axis=axis, pivot=pivot)
    raise ConfigError(
        f"base '{text}': write level, tilt:DEG or rocking:LOW:HIGH:HZ, for example tilt:20 or rocking:10:20:1"
    )


def oscillating(
    *,
    amplitude: Sequence[float],
    hz: Sequence[float],
    phase: Sequence[float] = (0.0,) * 6,
    offset: Sequence[float] = (0.0,) * 6,
    pivot: Sequence[float] = (0.0, 0.0, 0.0),
) -> BaseTrajectory:
    """Swing in six coordinates at once, as a ship does: surge, sway, heave (m), roll, pitch, yaw (rad).

    The rotation is Rx(roll) Ry(pitch) Rz(yaw); every argument but ``pivot`` has six numbers.
    """
    return BaseTrajectory(
        offset=as_double(offset, "offset"),
        amplitude=as_double(amplitude, "amplitude"),
        hz=as_double(hz, "hz"),
        phase=as_double(phase, "phase"),
        pivot=as_double(pivot, "pivot"),
        description="oscillating in six coordinates",
    )


def hinge_axes(axis: Axis) -> Array:
    """Three orthonormal rows of which the first is ``axis``: a vector in base axes, or "x", "y", "z"."""
    if isinstance(axis, str):
        if axis not in NAMED_AXES:
            raise ConfigError(f"axis {shown(axis)} is unknown: give 'x', 'y', 'z' or three numbers")
        axis = NAMED_AXES[axis]
    first = as_vector(axis, "axis", 3)
    largest = np.abs(first).max()
    if largest == 0.0:
        raise ConfigError("axis (0, 0, 0) has no direction")
    first = first / largest
    first /= np.linalg.norm(first)
    helper = np.eye(3)[int(np.argmin(np.abs(first)))]
    second = np.cross(first, helper)
    second /= np.linalg.norm(second)
    return np.stack((first, second, np.cross(first, second)))


def axis_rotation(axis: Array, angle: float) -> Array:
    """Rotation by ``angle`` (rad) about the unit vector ``axis``, (3, 3), by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    rotation: Array = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return rotation


def _orthonormal(value: Array) -> Array:
    axes = as_double(value, "axes")
    if axes.shape != (3, 3) or not np.abs(axes @ axes.T - np.eye(3)).max() <= TOLERANCE:
        raise ArgumentError(f"axes must be three orthonormal rows, not {shown(value)}")
    return axes.copy()


def _axis_text(axes: Array) -> str:
    return "(" + ", ".join(f"{value:g}" for value in np.round(axes[0], 4) + 0.0) + ")"
