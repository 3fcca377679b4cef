"""Where a recording lies still: windows in which neither the specific force nor the angular velocity changes.

A sample is still if it lies in a window over which each component's standard deviation is below a limit, and, with a
gyroscope, the mean angular velocity is near its value at rest (which also is its bias). Limits are in SI; what comes in
g or deg/s has become SI before.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc.calibration.imu import ImuRecording
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from ravengc.calibration.imu import FloatArray

__all__ = ["StillLimits", "StillSegment", "quietest", "still_segments"]

LONGEST_GAP = 5.0
"""In sample periods; across a longer pause nothing is known to have been still."""
BATCH_S = 0.25
FEWEST_SAMPLES = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class StillLimits:
    """What counts as still: standard deviations within a window of ``window_s``, and the shortest rest, ``shortest_s``.

    ``force`` is in m/s², ``rate`` in rad/s. Raises ConfigError for a limit that is not positive.
    """

    force: float = 0.05
    rate: float = 0.02
    window_s: float = 0.5
    shortest_s: float = 1.0

    def __post_init__(self) -> None:
        """Refuse limits that nothing could meet."""
        for name in ("force", "rate", "window_s", "shortest_s"):
            if not 0.0 < as_number(getattr(self, name), name) < np.inf:
                raise ConfigError(f"limits of stillness: {name} is {getattr(self, name)}; expected more than 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class StillSegment:
    """Samples ``start`` to ``stop`` (exclusive), s from ``begin`` to ``end``: the mean of what was measured.

    ``force`` (3,) is in m/s², ``rate`` (3,) in rad/s or None. ``noise`` is the standard error of ``force`` after one
    second, m/s²·√s, from ``freedom`` + 1 batches: it holds for noise that a filter in the sensor has made smooth.
    """

    start: int
    stop: int
    begin: float
    end: float
    force: FloatArray
    rate: FloatArray | None
    noise: float
    freedom: int


def still_segments(recording: ImuRecording, limits: StillLimits | None = None) -> tuple[StillSegment, ...]:
    """Return the still parts of a recording in order of time; each end is shortened by a quarter of a window."""
    check_type(recording, ImuRecording, "recording")
    limits = StillLimits() if limits is None else limits
    check_type(limits, StillLimits, "limits")
    mask = _still_samples(recording, limits)
    margin = limits.window_s / 4.0
    found = []
    for start, stop in _runs(recording, mask):
        t = recording.t[start:stop]
        first = start + int(np.searchsorted(t, t[0] + margin))
        last = start + int(np.searchsorted(t, t[-1] - margin, side="right"))
        found += [_segment(recording, *piece) for piece in _level_pieces(recording, first, last, limits)]
    return tuple(found)


def quietest(recording: ImuRecording, limits: StillLimits) -> tuple[float, float]:
    """Return the least standard deviations within a window, force (m/s²) and rate (rad/s); infinite where unknown."""
    signals = (recording.specific_force, recording.angular_velocity)
    n = _window(recording, limits)
    force, rate = (np.inf if x is None else float(_worst(x, n).min(initial=np.inf)) for x in signals)
    return force, rate


def _worst(values: FloatArray, n: int) -> FloatArray:
    """Largest standard deviation of the components over every n consecutive rows."""
    return np.asarray(_statistics(values, n)[1].max(axis=1))


def _window(recording: ImuRecording, limits: StillLimits) -> int:
    if recording.samples < 2:
        return FEWEST_SAMPLES
    return int(max(FEWEST_SAMPLES, min(round(limits.window_s / recording.period), recording.samples)))


def _statistics(values: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Mean and standard deviation of every n consecutive rows, by running sums about the overall mean."""
    centre = values.mean(axis=0) if len(values) else np.zeros(3)
    sums = [
        np.cumsum(np.vstack([np.zeros((1, 3)), power]), axis=0) for power in (values - centre, (values - centre) ** 2)
    ]
    first, second = ((total[n:] - total[:-n]) / n for total in sums)
    return first + centre, np.sqrt(np.maximum(second - first**2, 0.0))


def _still_samples(recording: ImuRecording, limits: StillLimits) -> NDArray[np.bool_]:
    n = _window(recording, limits)
    mask = np.zeros(recording.samples, dtype=bool)
    if recording.samples < n:
        return mask
    spans = recording.t[n - 1 :] - recording.t[: recording.samples - n + 1]
    windows = (_worst(recording.specific_force, n) <= limits.force) & (spans < (n + LONGEST_GAP) * recording.period)
    if recording.angular_velocity is not None:
        windows &= _turns_little(recording.angular_velocity, n, windows, limits.rate)
    for start, stop in _edges(windows):
        mask[start : stop + n - 1] = True
    return mask


def _turns_little(rates: FloatArray, n: int, windows: NDArray[np.bool_], limit: float) -> NDArray[np.bool_]:
    """Windows in which the gyroscope is quiet and near the median of all quiet ones, which is its reading at rest."""
    mean, deviation = _statistics(rates, n)
    quiet: NDArray[np.bool_] = deviation.max(axis=1) <= limit
    if not (quiet & windows).any():
        return quiet
    rest = np.median(mean[quiet & windows], axis=0)
    return np.asarray(quiet & (np.linalg.norm(mean - rest, axis=1) <= limit))


def _edges(mask: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Half-open ranges in which the mask is true."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return ((int(start), int(stop)) for start, stop in changes.reshape(-1, 2))


def _runs(recording: ImuRecording, mask: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Ranges of still samples, cut where the stamps pause."""
    gaps = (np.flatnonzero(np.diff(recording.t) > LONGEST_GAP * recording.period) + 1).tolist()
    for start, stop in _edges(mask):
        yield from pairwise([start, *(gap for gap in gaps if start < gap < stop), stop])


def _level_pieces(recording: ImuRecording, start: int, stop: int, limits: StillLimits) -> Iterator[tuple[int, int]]:
    """The range, or halves of it where it drifts: too slow a turn to be seen within a window is no rest either."""
    if (
        stop - start < FEWEST_SAMPLES
        or recording.t[stop - 1] - recording.t[start] < limits.shortest_s - limits.window_s / 2
    ):
        return
    if recording.specific_force[start:stop].std(axis=0).max() <= limits.force:
        yield start, stop
        return
    middle = (start + stop) // 2
    yield from _level_pieces(recording, start, middle, limits)
    yield from _level_pieces(recording, middle, stop, limits)


def _segment(recording: ImuRecording, start: int, stop: int) -> StillSegment:
    t, force = recording.t[start:stop], recording.specific_force[start:stop]
    rate = None if recording.angular_velocity is None else recording.angular_velocity[start:stop].mean(axis=0)
    noise, freedom = _noise(force, float(t[-1] - t[0]) * len(t) / (len(t) - 1))
    return StillSegment(
        start=start, stop=stop, begin=float(t[0]), end=float(t[-1]), force=force.mean(axis=0), rate=rate,
        noise=noise, freedom=freedom,
    )  # fmt: skip


def _noise(force: FloatArray, duration: float) -> tuple[float, int]:
    """The standard deviation of means over batches of about 0.25 s, as if of one second, and its degrees of freedom."""
    count = int(np.clip(round(duration / BATCH_S), 2, len(force) // 2))
    means = np.array([batch.mean(axis=0) for batch in np.array_split(force, count)])
    return float(np.sqrt(means.var(axis=0, ddof=1).mean() * duration / count)), count - 1
