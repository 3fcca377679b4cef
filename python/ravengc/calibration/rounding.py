"""What rounding does to the mean of a sensor at rest: nothing if its noise is larger than the step, much if it is not.

Noise of standard deviation σ moves readings over the edges of steps of width q, which evens the rounding out: over all
true values, the mean of the rounded readings is wrong by B, B² = q²/2π² Σ exp(-4π² k² σ²/q²) / k² (B. Widrow and
I. Kollár, Quantization Noise, 2008). The variance of the readings is V = σ² + q²/12 - B²; q and V are seen, and B
follows. At σ = 0 it is q/√12, at σ = q/2 already q/600.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ravengc.calibration.imu import FloatArray

__all__ = ["rounding_error", "step_of"]

LARGEST_STEP = 2.0
FEWEST_LEVELS = 5
"""Readings that differ by more, m/s², or have fewer values are those of different positions."""
WHOLE = 0.01
"""How near to whole numbers of steps all differences lie where readings are rounded."""
NOISES = np.linspace(0.0, 1.0, 201)
"""σ/q."""
TERMS = np.arange(1, 200)[:, np.newaxis]


def step_of(force: FloatArray) -> float:
    """Return the largest of the steps in which the components of ``force`` (n, 3) are given, m/s²; 0 for none."""
    return max(_step(component) for component in force.T)


def rounding_error(rests: Iterable[FloatArray], step: float) -> float:
    """Return the standard error, m/s², that steps leave in the means of ``rests``, each (n, 3) readings."""
    if step == 0.0:
        return 0.0
    spread = float(np.mean([rest.var(axis=0).mean() for rest in rests])) / step**2
    left = (np.exp(-4.0 * np.pi**2 * TERMS**2 * NOISES**2) / TERMS**2).sum(axis=0) / (2.0 * np.pi**2)
    seen = NOISES**2 + left[0] - left
    return step * float(np.sqrt(np.interp(spread, seen, left)))


def _step(component: FloatArray) -> float:
    """The least difference of two readings, if all are multiples of it."""
    gaps = np.diff(np.unique(component))
    if gaps.size + 1 < FEWEST_LEVELS or gaps.min() > LARGEST_STEP:
        return 0.0
    steps = gaps / gaps.min()
    return float(gaps.min()) if np.abs(steps - np.round(steps)).max() < WHOLE else 0.0
