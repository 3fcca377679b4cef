"""Base motions made of pieces: polynomials between times, such as an elevator's ride or a step of acceleration."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_double, as_number, as_vector, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError
from ravengc.sim.base_motion import Axis, BaseState, CarriedBase, as_time, axis_text, hinge_axes, orthonormal
from ravengc.sim.splines import twice_integrated

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["ProfiledBase", "acceleration_step", "elevator"]

Array = NDArray[np.float64]

POWERS = 6
"""Coefficients of a piece: quintic."""
LONGEST_PROFILE = 1e6
"""Largest time (s), travel (m), speed, acceleration and jerk of a profile; what is larger, is a slip."""


@dataclass(frozen=True, slots=True, eq=False)
class ProfiledBase(CarriedBase):
    """Each coordinate of the base is a polynomial of the time since the last of ``times``.

    ``times`` (k + 1,) increase (s); ``coefficients`` (k, 6, 6) hold for each piece and coordinate (slides x, y, z in
    m, then the hinges about the rows of ``axes`` in rad) the factors of 1, s, ..., s^5. Before the first and after the
    last time the base coasts with the velocity it has there. ``axes`` and ``pivot`` are those of
    :class:`BaseTrajectory`. Raises ArgumentError for shapes that do not fit and for numbers that are not finite.
    """

    times: Array
    coefficients: Array
    axes: Array = field(default_factory=lambda: np.eye(3))
    pivot: Array = field(default_factory=lambda: np.zeros(3))
    description: str = "in pieces"
    starts: tuple[float, ...] = field(init=False, repr=False)
    """The times, as floats."""

    def __post_init__(self) -> None:
        """Turn what was given as lists into arrays, check them, and add the coasting before and after."""
        times, coefficients = as_double(self.times, "times"), as_double(self.coefficients, "coefficients")
        if times.ndim != 1 or len(times) < 2 or not (np.isfinite(times).all() and (np.diff(times) > 0.0).all()):
            raise ArgumentError("times must be two or more finite numbers that increase")
        if coefficients.shape != (len(times) - 1, 6, POWERS) or not np.isfinite(coefficients).all():
            expected = f"({len(times) - 1}, 6, {POWERS}), all finite"
            raise ArgumentError(f"coefficients have shape {coefficients.shape}; expected {expected}")
        for name, value in (("times", times.copy()), ("coefficients", coefficients.copy())):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "axes", orthonormal(self.axes))
        object.__setattr__(self, "pivot", as_vector(self.pivot, "pivot", 3, LARGEST).copy())
        check_type(self.description, str, "description")
        object.__setattr__(self, "starts", tuple(times.tolist()))

    def state(self, t: float) -> BaseState:
        """The six coordinates at time ``t`` (s) with their velocities and accelerations."""
        time, starts = as_time(t), self.starts
        piece = bisect_right(starts, time) - 1
        if 0 <= piece < len(starts) - 1:
            return BaseState(*(self.coefficients[piece] @ powers(time - starts[piece])).T)
        end = 0 if piece < 0 else len(starts) - 2
        position, velocity, _ = (self.coefficients[end] @ powers(0.0 if piece < 0 else starts[-1] - starts[-2])).T
        return BaseState(position + (time - starts[0 if piece < 0 else -1]) * velocity, velocity, np.zeros(6))


def powers(s: float) -> Array:
    """1, s, ..., s^5 and their first and second derivatives, (6, 3)."""
    s2 = s * s
    s3, s4 = s2 * s, s2 * s2
    return np.array(
        (
            (1.0, 0.0, 0.0),
            (s, 1.0, 0.0),
            (s2, 2.0 * s, 2.0),
            (s3, 3.0 * s2, 6.0 * s),
            (s4, 4.0 * s3, 12.0 * s2),
            (s4 * s, 5.0 * s4, 20.0 * s3),
        )
    )


def elevator(
    travel: float, *, speed: float = 2.5, acceleration: float = 1.0, jerk: float = 2.0, start_s: float = 1.0
) -> ProfiledBase:
    """Ride an elevator ``travel`` metres up (down if negative), from rest to rest, beginning at ``start_s``.

    It is the fastest ride within ``speed`` (m/s), ``acceleration`` (m/s^2) and ``jerk`` (m/s^3): a short one reaches
    neither speed nor acceleration. ConfigError for limits that are not positive.
    """
    limits = {"speed": speed, "acceleration": acceleration, "jerk": jerk}
    for name, value in limits.items():
        limits[name] = _within(value, f"elevator: {name}", least=1e-6)
    height = _within(travel, "elevator: travel", least=-LONGEST_PROFILE)
    start = _within(start_s, "elevator: start_s", least=0.0)
    if height == 0.0:
        raise ConfigError("elevator: travel is 0 m; expected a distance up or down")
    times, accelerations = ride(abs(height), **limits)
    accelerations = [math.copysign(1.0, height) * value for value in accelerations]
    return _sliding(
        [start + time for time in times],
        accelerations,
        np.array((0.0, 0.0, 1.0)),
        f"elevator: {height:g} m at up to {limits['speed']:g} m/s, {limits['acceleration']:g} m/s^2",
    )


def acceleration_step(
    acceleration: float, axis: Axis = "x", *, start_s: float = 1.0, end_s: float = 2.0, rise_s: float = 0.0
) -> ProfiledBase:
    """Accelerate by ``acceleration`` (m/s^2) along ``axis`` from ``start_s`` to ``end_s``: as much specific force more.

    The base is level and really moves, and coasts afterwards: a robot cannot tell that from rest, and nothing in a
    plant depends on how far the base has come. With ``rise_s`` the acceleration ramps up, and down again, over that
    time within the step; without it, it jumps. ConfigError for times out of order.
    """
    direction = hinge_axes(axis)
    size = _within(acceleration, "acceleration step: acceleration", least=-LONGEST_PROFILE)
    start, end, rise = (
        _within(value, f"acceleration step: {name}", least=0.0)
        for name, value in (("start_s", start_s), ("end_s", end_s), ("rise_s", rise_s))
    )
    if not start + 2.0 * rise <= end or start == end:
        expected = "expected start_s + 2 rise_s <= end_s, and start_s before end_s"
        raise ConfigError(f"acceleration step: start_s {start:g}, end_s {end:g}, rise_s {rise:g}; {expected}")
    times = [start, start + rise, end - rise, end]
    what = f"acceleration of {size:g} m/s^2 along {axis_text(direction)} from {start:g} to {end:g} s"
    return _sliding(times, [0.0, size, size, 0.0], direction[0], what)


def ride(distance: float, *, speed: float, acceleration: float, jerk: float) -> tuple[list[float], list[float]]:
    """Times (s), from 0, and accelerations (m/s^2) at them, linear between, of the fastest way from rest to rest.

    The speed reached, v, is the lower one of the limit and what the distance allows: d = v (a/j + v/a) where the
    acceleration a is reached, else d = 2 v sqrt(v/j).
    """
    ramped = 0.5 * acceleration * (math.sqrt((acceleration / jerk) ** 2 + 4.0 * distance / acceleration))
    top = ramped - 0.5 * acceleration**2 / jerk
    if top < acceleration**2 / jerk:
        top = (0.25 * jerk * distance**2) ** (1.0 / 3.0)
    top = min(top, speed)
    most = min(acceleration, math.sqrt(top * jerk))
    ramp = most / jerk
    steady = top / most - ramp
    cruise = distance / top - (2.0 * ramp + steady)
    spans = (ramp, steady, ramp, cruise, ramp, steady, ramp)
    times = [0.0]
    for span in spans:
        times.append(times[-1] + max(span, 0.0))
    return times, [0.0, most, most, 0.0, 0.0, -most, -most, 0.0]


def _sliding(times: Sequence[float], accelerations: Sequence[float], direction: Array, what: str) -> ProfiledBase:
    """Slide along ``direction`` from rest with these accelerations, linear between ``times``; equal times are jumps."""
    begins, sizes = np.array(times), np.array(accelerations)[:, None]
    spans = np.diff(begins)
    lasting = spans > 1e-12 * begins[1:]
    along = twice_integrated(spans[lasting], sizes[:-1][lasting], sizes[1:][lasting])
    pieces = np.zeros((len(along), 6, POWERS))
    pieces[:, :3] = direction[:, None] * along
    return ProfiledBase(np.append(begins[:-1][lasting], begins[-1]), pieces, description=what)


def _within(value: float, name: str, *, least: float) -> float:
    number = as_number(value, name)
    if not least <= number <= LONGEST_PROFILE:
        raise ConfigError(f"{name} is {number:g}; expected a number from {least:g} to {LONGEST_PROFILE:g}")
    return number
