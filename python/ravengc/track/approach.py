"""How the tool closes in: its velocity relative to the point, from the error. Scalars, as it runs every cycle.

proportional:  u = K e, no faster than u_max                        behind a moving target by v / K without feed-forward
step:          u = u_step e / |e|, at most the error in one cycle   unit steps along the way, as the method was proposed
smooth:        |u| = K d if d <= a / K^2, else sqrt(2 a (d - a / (2 K^2)))

With a smooth approach u, and what is fed forward of the target's velocity, each change by at most a_max dt in a cycle.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.track.settings import TrackSettings

__all__ = ["Approach", "Triple"]

Triple = tuple[float, float, float]

BRAKING = 0.85
"""Share of the acceleration that braking plans with; the rest follows the target's surprises."""


class Approach:
    """Velocities of the last cycle: closing in, ``u`` (m/s) and ``w`` (rad/s), and carried along, ``v`` (m/s)."""

    __slots__ = ("_dt", "_linear", "_linear_change", "_turn", "_turn_change", "u", "v", "w")

    def __init__(self, settings: TrackSettings) -> None:
        self._dt = 1.0 / settings.rate_hz
        self._linear, self._turn = _speeds(settings, self._dt)
        smooth = settings.approach == "smooth"
        self._linear_change = settings.acceleration_max * self._dt if smooth else math.inf
        self._turn_change = settings.angular_acceleration_max * self._dt if smooth else math.inf
        self.u: Triple = (0.0, 0.0, 0.0)
        self.v: Triple = (0.0, 0.0, 0.0)
        self.w: Triple = (0.0, 0.0, 0.0)

    def close_in(self, error: Triple, turn: Triple, carried: Triple) -> None:
        """Go on by a cycle: where the point is from the tool (m), the rotation to it (rad), its velocity (m/s)."""
        self.v = _towards(self.v, carried, self._linear_change)
        self.u = _towards(self.u, _along(error, self._linear), self._linear_change)
        self.w = _towards(self.w, _along(turn, self._turn), self._turn_change)

    def slowed(self, scale: float) -> None:
        """Take over what the joints could do: ``scale`` of the velocity, that of the target included."""
        x, y, z = self.u
        a, b, c = self.v
        lost = scale - 1.0
        self.u = (scale * x + lost * a, scale * y + lost * b, scale * z + lost * c)
        self.w = (scale * self.w[0], scale * self.w[1], scale * self.w[2])


def _speeds(settings: TrackSettings, dt: float) -> tuple[Callable[[float], float], Callable[[float], float]]:
    """Closing speeds by distance (m/s of m, rad/s of rad)."""
    turning = settings.angular_speed_max
    if settings.approach == "smooth":
        gain = settings.closing_gain_per_s
        return (
            _braking(gain, BRAKING * settings.acceleration_max, settings.speed_max),
            _braking(gain, BRAKING * settings.angular_acceleration_max, turning),
        )
    turn_gain = settings.angular_gain_per_s
    if settings.approach == "step":
        return lambda d: min(settings.step_speed, d / dt), lambda d: min(turn_gain * d, turning)
    return lambda d: min(settings.gain_per_s * d, settings.speed_max), lambda d: min(turn_gain * d, turning)


def _braking(gain: float, braking: float, fastest: float) -> Callable[[float], float]:
    knee = braking / gain**2

    def speed(distance: float) -> float:
        if distance <= knee:
            return min(gain * distance, fastest)
        return min(math.sqrt(2.0 * braking * (distance - knee / 2.0)), fastest)

    return speed


def _along(error: Triple, speed: Callable[[float], float]) -> Triple:
    x, y, z = error
    distance = math.sqrt(x * x + y * y + z * z)
    if not 0.0 < distance < math.inf:
        return (0.0, 0.0, 0.0)
    factor = speed(distance) / distance
    return (factor * x, factor * y, factor * z)


def _towards(last: Triple, wanted: Triple, most: float) -> Triple:
    """On from ``last`` straight to ``wanted``, by no more than ``most``."""
    x, y, z = wanted[0] - last[0], wanted[1] - last[1], wanted[2] - last[2]
    change = math.sqrt(x * x + y * y + z * z)
    if change <= most:
        return wanted
    part = most / change
    return (last[0] + part * x, last[1] + part * y, last[2] + part * z)
