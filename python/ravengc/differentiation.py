"""Derivatives of recorded signals without a phase shift, for samples at any increasing times.

At every sample a parabola is fitted by least squares to the samples around it (Savitzky and Golay, Analytical Chemistry
36(8), 1964, here on the actual time stamps), and its slope is the derivative. Windows are symmetric, so nothing is
delayed; at the two ends they keep their width and lean inward. Three samples give the central difference.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ravengc.errors import ArgumentError

__all__ = ["differentiate", "window_for"]

FloatArray = npt.NDArray[np.float64]
COEFFICIENTS = 3
HANKEL = np.add.outer(np.arange(COEFFICIENTS), np.arange(COEFFICIENTS))
"""Powers in VᵀV: its row i, column j is Σ u^(i+j)."""
SLOPE = np.array([[0.0], [1.0], [0.0]])
BLOCK = 4096
"""Samples treated together: few enough to stay in the processor's cache."""


def differentiate(t: FloatArray, values: FloatArray, window: int) -> FloatArray:
    """Time derivative of ``values`` (samples, k) at the increasing stamps ``t`` (s), from ``window`` samples each.

    Times are taken relative to each sample and scaled to at most 1, which keeps the normal equations well conditioned.
    Raises ArgumentError for an even window, one below 3, and one longer than the recording.
    """
    _check(window, t.size)
    slopes = np.empty(values.shape)
    for first in range(0, t.size, BLOCK):
        rows = np.arange(first, min(first + BLOCK, t.size))
        slopes[rows] = _slopes(t, values, rows, window)
    return slopes


def _slopes(t: FloatArray, values: FloatArray, rows: npt.NDArray[np.int64], window: int) -> FloatArray:
    """Slopes at some samples: Σ_j w_j y_j, where w is row b of (VᵀV)⁻¹ Vᵀ for y ≈ a + b u + c u², V = [1 u u²]."""
    starts = np.clip(rows - window // 2, 0, t.size - window)
    scale = np.maximum(t[rows] - t[starts], t[starts + window - 1] - t[rows])
    moments = np.zeros((2 * COEFFICIENTS - 1, rows.size))
    for place in range(window):
        u, power = (t[starts + place] - t[rows]) / scale, np.ones(rows.size)
        for degree in range(len(moments)):
            moments[degree] += power
            power *= u
    square = np.moveaxis(moments[HANKEL], -1, 0)
    row = np.linalg.solve(square, np.broadcast_to(SLOPE, (rows.size, COEFFICIENTS, 1)))[:, :, 0]
    slopes = np.zeros((rows.size, values.shape[1]))
    for place in range(window):
        u = (t[starts + place] - t[rows]) / scale
        weights = (row[:, 0] + (row[:, 1] + row[:, 2] * u) * u) / scale
        slopes += weights[:, np.newaxis] * values[starts + place]
    return slopes


def window_for(t: FloatArray, span: float) -> int:
    """The odd number of samples, at least 3, that spans about ``span`` seconds at the recording's median rate."""
    step = float(np.median(np.diff(t))) if t.size > 1 else span
    return 2 * max(1, round(min(0.5 * span / step, t.size))) + 1


def _check(window: int, samples: int) -> None:
    if window < COEFFICIENTS or window % 2 == 0:
        raise ArgumentError(f"window of {window} samples; expected an odd number from {COEFFICIENTS}")
    if window > samples:
        raise ArgumentError(f"window of {window} samples for a recording of {samples}; take a shorter one")
