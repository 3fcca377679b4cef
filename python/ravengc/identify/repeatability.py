"""How well a motion repeats itself: the error that no model of the motion can go below."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ravengc.identify.recording import FloatArray, Recording

__all__ = ["repeatability"]

ALIKE = 0.02
"""RMS difference of two periods of q, as a share of its RMS, below which the motion counts as the same."""
SHORTEST = 20


def repeatability(recording: Recording) -> FloatArray | None:
    """RMS difference of the torques of successive periods over the root of two, (n,); ``None`` if nothing repeats.

    NaN for a joint of which not every torque counts.
    """
    period = _period(recording.q)
    if period is None:
        return None
    differences = recording.tau[period:] - recording.tau[:-period]
    floor = np.sqrt((differences**2).mean(axis=0) / 2.0)
    return np.where(recording.counts.all(axis=0), floor, np.nan)


def _period(q: FloatArray) -> int | None:
    """The number of samples after which q is the same, if at least half a period more was recorded."""
    centred = q - q.mean(axis=0)
    size = float(np.sqrt((centred**2).sum(axis=1).mean()))
    longest = int(len(q) / 1.5)
    if size == 0.0 or longest <= SHORTEST:
        return None
    differences = _mean_square_differences(centred, longest)
    start = int(np.argmax(differences > 0.5 * size**2))  # beyond the first rise: close samples are alike
    if start == 0:
        return None
    best = start + int(np.argmin(differences[start:]))
    return best if best >= SHORTEST and differences[best] < (ALIKE * size) ** 2 else None


def _mean_square_differences(q: FloatArray, longest: int) -> FloatArray:
    """Mean of |q(i + lag) - q(i)|² for every lag, by transforms: the sum of squares less twice the correlation."""
    samples = len(q)
    length = 1 << (2 * samples - 1).bit_length()
    spectrum = np.fft.rfft(q, length, axis=0)
    correlation = np.fft.irfft((np.abs(spectrum) ** 2).sum(axis=1), length)[:longest]
    squares = np.concatenate([[0.0], np.cumsum((q**2).sum(axis=1))])
    lags = np.arange(longest)
    both = squares[samples - lags] + squares[samples] - squares[lags]
    return np.asarray((both - 2.0 * correlation) / (samples - lags))
