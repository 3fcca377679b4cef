"""Motion of a base for batches: nine columns per sample, specific force, angular velocity, angular acceleration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ravengc import BaseMotion

__all__ = ["Rocking", "base_motion", "held_rows", "turned"]

Array = NDArray[np.float64]


def turned(axis: Array, angle: Array, vector: Array) -> Array:
    """Turn ``vector`` (3,) by each ``angle`` (N,) about the unit vector ``axis``: Rodrigues' formula, (N, 3)."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along: Array = axis * (axis @ vector)
    return vector * cosine + np.cross(axis, vector) * sine + along * (1.0 - cosine)


def held_rows(force: Array) -> Array:
    """Rows of a base at rest, or of one whose rotation is left out: the specific force (N, 3) alone."""
    return np.hstack((force, np.zeros((len(force), 6))))


def base_motion(row: Array) -> BaseMotion:
    """Return one row (9,) as the motion that single calls take."""
    return BaseMotion(specific_force=row[:3], angular_velocity=row[3:6], angular_acceleration=row[6:])


class Rocking:
    """A base that turns about ``axis`` through ``pivot`` by mean + amplitude sin(2 pi hz t), for one period.

    ``axis`` (unit), ``pivot`` (m) and ``up`` are in base axes, angles in rad; ``up`` has the length of g.
    """

    def __init__(
        self, axis: Array, pivot: Array, up: Array, *, mean: float, amplitude: float, hz: float, samples: int
    ) -> None:
        rate = 2.0 * np.pi * hz
        self.time = np.arange(samples) / (hz * samples)
        swing = amplitude * np.sin(rate * self.time)
        self.angle = mean + swing
        self.w = np.outer(amplitude * rate * np.cos(rate * self.time), axis)
        self.dw = np.outer(-rate * rate * swing, axis)
        self.pivot = pivot
        self.up_in_base = turned(axis, -self.angle, up)

    def force_at(self, point: Array) -> Array:
        """Specific force (N, 3) that an accelerometer at ``point`` (m, base axes) reads: f = -g + w' x d + w x (w x d).

        d leads from the pivot, which stands still, to the point.
        """
        arm = np.broadcast_to(point - self.pivot, self.w.shape)
        return self.up_in_base + np.cross(self.dw, arm) + np.cross(self.w, np.cross(self.w, arm))

    def rows(self) -> Array:
        """The full motion of the base's origin."""
        return np.hstack((self.force_at(np.zeros(3)), self.w, self.dw))
