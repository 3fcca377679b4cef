"""A slow, smooth motion that any robot can make: every joint swings about the middle of its range."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_double, as_number, as_vector
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError
from ravengc.messages import shown

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ravengc.spec import JointLimits, RobotSpec

__all__ = ["JointSwing", "swing_within_limits"]

Array = NDArray[np.float64]

LARGEST_TURN, LARGEST_SLIDE = 0.3, 0.03
TURN_PERIODS_S = (8.0, 6.0, 5.0, 7.0)
SLIDE_PERIOD_S = 10.0


class JointSwing:
    """Joint i moves as centre_i - amplitude_i cos(2 pi t / period_i): it starts at rest at its lower end.

    All arguments (n,): rad or m, and s. An amplitude of zero holds the joint at its centre. Raises ArgumentError for
    numbers that are not finite, another shape and a period that is not positive.
    """

    def __init__(self, centre: ArrayLike, amplitude: ArrayLike, period_s: ArrayLike) -> None:
        n = as_double(centre, "centre").size
        self.centre = as_vector(centre, "centre", n)
        self.amplitude = as_vector(amplitude, "amplitude", n)
        period = as_vector(period_s, "period_s", n)
        if not (period > 0.0).all():
            raise ArgumentError(f"period_s must be positive, not {shown(period_s)}")
        self._rate = 2.0 * math.pi / period
        self._angle = np.zeros(n)

    @property
    def start(self) -> Array:
        """Joint positions at time zero, (n,)."""
        return self.centre - self.amplitude

    def at(self, t: float, q: Array, qd: Array) -> None:
        """Write the positions and velocities at time ``t`` (s) into ``q`` and ``qd`` (n,)."""
        np.multiply(self._rate, t, out=self._angle)
        np.cos(self._angle, out=q)
        np.multiply(q, self.amplitude, out=q)
        np.subtract(self.centre, q, out=q)
        np.sin(self._angle, out=qd)
        np.multiply(qd, self.amplitude, out=qd)
        np.multiply(qd, self._rate, out=qd)


def swing_within_limits(robot: RobotSpec, *, scale: float = 1.0) -> JointSwing:
    """A swing for each coordinate of ``robot``: at most a fifth of its range, 0.3 rad or 0.03 m, times ``scale``.

    ``scale`` 0 holds the middle of the range. A coordinate without both limits swings about zero, or as near
    to it as its limit lets it. Raises ArgumentError for a scale that is negative or not finite.
    """
    scale = as_number(scale, "scale")
    if not 0.0 <= scale < math.inf:
        raise ArgumentError(f"scale is {scale:g}; expected a finite number, 0 or more")
    slides = sliding(robot)
    limits = [_bounds(limit) for limit in robot.coordinate_limits]
    reach = [
        min(largest, (upper - lower) / 5.0)
        for largest, (lower, upper) in zip(np.where(slides, LARGEST_SLIDE, LARGEST_TURN), limits, strict=True)
    ]
    centre = [_middle(*limit, swing) for limit, swing in zip(limits, reach, strict=True)]
    period = np.where(slides, SLIDE_PERIOD_S, np.resize(TURN_PERIODS_S, len(slides)))
    return JointSwing(np.array(centre), scale * np.array(reach), period)


def _bounds(limit: JointLimits) -> tuple[float, float]:
    return -math.inf if limit.lower is None else limit.lower, math.inf if limit.upper is None else limit.upper


def _middle(lower: float, upper: float, reach: float) -> float:
    if math.isfinite(upper - lower):
        return (lower + upper) / 2.0
    return min(max(0.0, lower + reach), upper - reach)
