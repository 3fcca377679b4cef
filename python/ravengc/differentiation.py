"""Derivatives of recorded signals without a phase shift, for samples at any increasing times.

At every sample a parabola is fitted by least squares to the samples around it (Savitzky and Golay, Analytical Chemistry
36(8), 1964, here on the actual time stamps), and its slope is the derivative. Windows are symmetric, so nothing is
delayed; at the two ends they keep their width and lean inward. Three samples give the central difference.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_count, as_double, as_number
from ravengc.errors import ArgumentError
from ravengc.messages import shown

__all__ = ["differentiate", "window_for"]

FloatArray = npt.NDArray[np.float64]
COEFFICIENTS = 3
HANKEL = np.add.outer(np.arange(COEFFICIENTS), np.arange(COEFFICIENTS))
"""Powers in VᵀV: its row i, column j is Σ u^(i+j)."""
SLOPE = np.array([[0.0], [1.0], [0.0]])
BLOCK = 4096
"""Samples treated together: few enough to stay in the processor's cache."""


def differentiate(t: npt.ArrayLike, values: npt.ArrayLike, window: int) -> FloatArray:
    """Time derivative of ``values`` (samples, k) at the increasing stamps ``t`` (s), from ``window`` samples each.

    Times are taken relative to each sample and scaled to at most 1, which keeps the normal equations well conditioned.
    Raises ArgumentError for stamps that do not increase, values of another shape, an even window, one below 3, and one
    longer than the recording.
    """
    stamps, signals = _stamps(t), as_double(values, "values")
    if signals.ndim != 2 or len(signals) != stamps.size:
        raise ArgumentError(f"values has shape {signals.shape}; expected ({stamps.size}, k), a row for every stamp")
    _check(window, stamps.size)
    slopes = np.empty(signals.shape)
    for first in range(0, stamps.size, BLOCK):
        rows = np.arange(first, min(first + BLOCK, stamps.size))
        slopes[rows] = _slopes(stamps, signals, rows, window)
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


def window_for(t: npt.ArrayLike, span: float) -> int:
    """The odd number of samples, at least 3, that spans about ``span`` seconds at the recording's median rate.

    Raises ArgumentError for stamps that do not increase and for a span that is negative or not finite.
    """
    stamps, seconds = _stamps(t), as_number(span, "span")
    if not 0.0 <= seconds < np.inf:
        raise ArgumentError(f"span of {seconds} s; expected zero (three samples) or more")
    if stamps.size < 2:
        return COEFFICIENTS
    steps = 0.5 * seconds / float(np.median(np.diff(stamps)))
    return 2 * max(1, round(min(steps, stamps.size))) + 1


def _stamps(t: npt.ArrayLike) -> FloatArray:
    stamps = as_double(t, "t")
    if stamps.ndim != 1 or not np.isfinite(stamps).all() or not (np.diff(stamps) > 0.0).all():
        raise ArgumentError(f"t is {shown(t)}; expected finite stamps (samples,) that increase")
    return stamps


def _check(window: int, samples: int) -> None:
    if as_count(window, "window", COEFFICIENTS) % 2 == 0:
        raise ArgumentError(f"window of {shown(window)} samples; expected an odd number")
    if window > samples:
        raise ArgumentError(f"window of {shown(window)} samples for a recording of {samples}; take a shorter one")
