"""Prescribed motions of a robot's base: six coordinates whose velocity and acceleration are known exactly.

The base is carried by three slides along the world's axes and three hinges, one after the other, about the axes u1,
u2, u3 through a pivot that is fixed in the base. With s(t) the slides, a(t) the hinge angles and c the pivot in base
axes,

    R_WB = rot(u1, a1) rot(u2, a2) rot(u3, a3)          p_WB = c + s - R_WB c

so a simulator that has slide and hinge joints carries the same base with the same six numbers. (A body that is moved
without joints has no velocity, and an accelerometer on it would see the tilt alone.)
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc._convert import as_double, as_number, as_vector
from ravengc.config.physical import LARGEST, TOLERANCE
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import shown

__all__ = ["BaseState", "CarriedBase", "PrescribedBase"]

Array = NDArray[np.float64]
Axis = str | Sequence[float]
Triple = tuple[float, float, float]

NAMED_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
LATEST = 2.0 * LARGEST
"""Latest time (s): a plant may begin at 1e9 s."""
WORLD_GRAVITY = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))


class BaseState(NamedTuple):
    """Coordinates of the base, each (6,): three slides (m), then three hinges (rad), and their two time derivatives."""

    position: Array
    velocity: Array
    acceleration: Array


class PrescribedBase(Protocol):
    """What a plant asks of a base motion: where its hinges are, and its coordinates at a time."""

    @property
    def axes(self) -> Array:
        """Axes of the hinges, orthonormal rows, (3, 3), in base axes at level."""

    @property
    def pivot(self) -> Array:
        """The point the hinges turn about, (3,), m, base axes."""

    def state(self, t: float) -> BaseState:
        """The six coordinates at time ``t`` (s) with their velocities and accelerations."""


class CarriedBase:
    """What follows from the six coordinates of a base: pose, specific force, angular velocity and acceleration."""

    __slots__ = ()

    axes: Array
    pivot: Array
    description: str

    @abstractmethod
    def state(self, t: float) -> BaseState:
        """The six coordinates at time ``t`` (s) with their velocities and accelerations."""

    def rotation(self, t: float) -> Array:
        """R_WB at time ``t``, (3, 3): base axes to world axes."""
        angles = self.state(t).position[3:].tolist()
        first, second, third = (axis_rotation(axis, angle) for axis, angle in zip(self.axes, angles, strict=True))
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
        reads. Each hinge adds its own w and w' to what those before it give, seen from axes that have turned. (In
        floats: for three numbers ten times faster than arrays.)
        """
        x, y, z = (as_vector(point, "point", 3, LARGEST) - self.pivot).tolist()
        state = self.state(t)
        force: Triple = tuple((state.acceleration[:3] - WORLD_GRAVITY).tolist())
        rate: Triple = (0.0, 0.0, 0.0)
        acceleration: Triple = (0.0, 0.0, 0.0)
        moves = zip(*(part[3:].tolist() for part in state), strict=True)
        for axis, (angle, speed, gain) in zip(self.axes.tolist(), moves, strict=True):
            if angle != 0.0:
                force, rate, acceleration = (_seen_after(axis, angle, v) for v in (force, rate, acceleration))
            if speed != 0.0 or gain != 0.0:
                own = _scaled(speed, axis)
                acceleration = _sum(_sum(acceleration, _cross(rate, own)), _scaled(gain, axis))
                rate = _sum(rate, own)
        arm = (x, y, z)
        force = _sum(force, _sum(_cross(acceleration, arm), _cross(rate, _cross(rate, arm))))
        return np.array(force), np.array(rate), np.array(acceleration)


def _seen_after(axis: Sequence[float], angle: float, v: Triple) -> Triple:
    """The vector in axes that have turned: rot(axis, angle)^T v."""
    (x, y, z), (a, b, c) = axis, v
    cosine, sine = math.cos(angle), math.sin(angle)
    along = (x * a + y * b + z * c) * (1.0 - cosine)
    return (
        a * cosine - (y * c - z * b) * sine + x * along,
        b * cosine - (z * a - x * c) * sine + y * along,
        c * cosine - (x * b - y * a) * sine + z * along,
    )


def _cross(u: Triple, v: Triple) -> Triple:
    (a, b, c), (x, y, z) = u, v
    return b * z - c * y, c * x - a * z, a * y - b * x


def _scaled(factor: float, v: Sequence[float]) -> Triple:
    x, y, z = v
    return factor * x, factor * y, factor * z


def _sum(u: Triple, v: Triple) -> Triple:
    (a, b, c), (x, y, z) = u, v
    return a + x, b + y, c + z


def as_time(t: float) -> float:
    """Return a time (s) as a float; ArgumentError for what is none, or is beyond what a plant can come to."""
    number = t if type(t) is float else as_number(t, "t")
    if not abs(number) <= LATEST:
        raise ArgumentError(f"t is {number} s; expected a number of at most {LATEST:g}")
    return number


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


def orthonormal(value: Array) -> Array:
    """Return a copy of three orthonormal rows; ArgumentError for anything else."""
    axes = as_double(value, "axes")
    if axes.shape != (3, 3) or not np.abs(axes @ axes.T - np.eye(3)).max() <= TOLERANCE:
        raise ArgumentError(f"axes must be three orthonormal rows, not {shown(value)}")
    return axes.copy()


def axis_text(axes: Array) -> str:
    """The first axis in words."""
    return "(" + ", ".join(f"{value:g}" for value in np.round(axes[0], 4) + 0.0) + ")"
