"""Signals without noise and without a delay: a zero-phase Butterworth low-pass, and accelerations from velocities.

A Butterworth filter of order N run forwards and backwards has the gain 1/(1 + (f/fc)^(2N)) and no phase; that gain is
applied to the spectrum of the signal, continued at both ends by its own point reflection.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc.errors import ArgumentError
from ravengc.identify.recording import FloatArray, Recording

__all__ = ["low_passed", "smoothed"]

ORDER = 6
SPAN = 8.0
"""How far the signal is continued at its ends, in periods of the cutoff."""
UNEVEN = 0.01
"""Share of the step by which stamps may be off an even grid."""


def smoothed(recording: Recording, cutoff_hz: float, *, trim: float = 1.0) -> Recording:
    """The recording on an even grid, low-passed, with the accelerations of its velocities.

    Positions, velocities, torques and the base's motion are filtered alike, and so are later the columns of a model:
    what is lost of one is lost of all, also of a step of friction. Velocities that were not recorded are differences of
    positions, and angular accelerations of the base those of its angular velocity.
    ``trim`` seconds are left out at both ends, where the filter guesses. Raises ArgumentError for too few samples, and
    for a joint of which some torques count and others do not: a filter would mix them.
    """
    check_type(recording, Recording, "recording")
    cutoff, edge = as_number(cutoff_hz, "cutoff_hz"), as_number(trim, "trim")
    _check_counts(recording)
    even = _on_a_grid(recording)
    step = float(even.stamps[1] - even.stamps[0])
    if not 0.0 < cutoff < 0.5 / step:
        raise ArgumentError(
            f"cutoff_hz is {cutoff:g}; expected more than 0 and less than {0.5 / step:g}, half the rate"
        )
    if not 0.0 <= edge < np.inf:
        raise ArgumentError(f"trim is {edge:g}; expected a number of seconds")
    q, tau = (low_passed(values, cutoff * step) for values in (even.q, even.tau))
    qd = slope(q, step) if even.qd is None else low_passed(even.qd, cutoff * step)
    base = _calm_base(even, cutoff, step)
    calm = replace(even, q=q, qd=qd, qdd=slope(qd, step), tau=tau, cutoff_hz=cutoff, **base)
    cut = round(edge / step)
    if 2 * cut >= even.samples:
        raise ArgumentError(f"{recording.source}: {edge:g} s at both ends are all of its {even.samples} samples")
    return calm.take(slice(cut, even.samples - cut))


def _check_counts(recording: Recording) -> None:
    counts = recording.counts
    mixed = np.flatnonzero(counts.any(axis=0) & ~counts.all(axis=0))
    if mixed.size:
        raise ArgumentError(
            f"{recording.source}: of joint {mixed[0] + 1} some torques count and others do not, which a filter"
            " would mix: give the parts as recordings of their own"
        )


def _calm_base(even: Recording, cutoff: float, step: float) -> dict[str, Any]:
    """Of the base's motion what was recorded, low-passed, and its angular acceleration if it turned."""
    names = ("specific_force", "angular_velocity", "angular_acceleration")
    recorded = {name: values for name in names if (values := getattr(even, name)) is not None}
    calm = {name: low_passed(values, cutoff * step) for name, values in recorded.items()}
    if "angular_velocity" in calm:
        calm.setdefault("angular_acceleration", slope(calm["angular_velocity"], step))
    return calm


def low_passed(values: FloatArray, cutoff: float) -> FloatArray:
    """Columns of (N, k) through the filter; ``cutoff`` in cycles per sample."""
    samples = len(values)
    reach = min(samples - 1, int(SPAN / cutoff))
    ends = [2.0 * values[:1] - values[reach:0:-1], values, 2.0 * values[-1:] - values[-2 : -2 - reach : -1]]
    whole = np.concatenate(ends) if reach else values
    length = _quick(len(whole))
    padded = np.concatenate([whole, np.broadcast_to(whole[-1:], (length - len(whole), values.shape[1]))])
    gain = 1.0 / (1.0 + (np.fft.rfftfreq(length) / cutoff) ** (2 * ORDER))
    calm = np.fft.irfft(np.fft.rfft(padded.T) * gain, length)
    return np.ascontiguousarray(calm[:, reach : reach + samples].T)


def _quick(length: int) -> int:
    """The next length whose transform is quick: 2^k, or 3 times or 5 times a power of two."""
    return min(part << max(0, -(-length // part) - 1).bit_length() for part in (1, 3, 5, 9, 15))


def slope(values: FloatArray, step: float) -> FloatArray:
    """Derivatives of columns (N, k) by central differences of the fourth order, of lower order at the ends."""
    rates = np.gradient(values, step, axis=0)
    if len(values) > 4:
        inner = -values[4:] + 8.0 * values[3:-1] - 8.0 * values[1:-3] + values[:-4]
        rates[2:-2] = inner / (12.0 * step)
    return np.asarray(rates)


def _on_a_grid(recording: Recording) -> Recording:
    """The recording at even steps of its median; itself if it has those already."""
    stamps = recording.stamps
    if stamps.size < 8:
        raise ArgumentError(f"{recording.source} has {stamps.size} samples; a filter needs at least 8")
    step = float(np.median(np.diff(stamps)))
    grid = stamps[0] + step * np.arange(int((stamps[-1] - stamps[0]) / step + 0.5) + 1)
    if grid.size == stamps.size and np.abs(grid - stamps).max() <= UNEVEN * step:
        return recording
    names = ("q", "qd", "qdd", "tau", "specific_force", "angular_velocity", "angular_acceleration")
    given = {name: getattr(recording, name) for name in names}
    between: dict[str, Any] = {
        name: _between(grid, stamps, values) for name, values in given.items() if values is not None
    }
    counted = np.repeat(recording.counts[:1], grid.size, axis=0)  # alike in all samples
    return replace(recording, stamps=grid, counted=counted, **between)


def _between(grid: FloatArray, stamps: FloatArray, values: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(grid, stamps, column) for column in values.T])
