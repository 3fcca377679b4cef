"""A recording given again as if it came from a sensor: at the pace it was recorded, faster, or without waiting."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc.errors import ConfigError
from ravengc.sensors.pacing import wait_until
from ravengc.sensors.recorded import Recording
from ravengc.sensors.sample import Sample, Statistics
from ravengc.sensors.units import AXES, Axes

if TYPE_CHECKING:
    from ravengc.sensors.sample import Triple

__all__ = ["ReplaySensor"]

FASTEST = 1e6


class ReplaySensor:
    """Gives the samples of a recording, the first at its opening.

    ``speed`` 2 is twice the recorded pace, infinity no waiting at all; stamps are the host's clock at the opening plus
    the recorded time (divided by the speed, if that is finite), whatever their order. ``repeat`` starts again at the
    end; else the sensor is finished there, and silent.
    """

    def __init__(self, recording: Recording, *, speed: float = 1.0, repeat: bool = False, axes: Axes = AXES) -> None:
        check_type(recording, Recording, "recording")
        speed = as_number(speed, "speed")
        if not (0.0 < speed <= FASTEST or speed == math.inf):
            raise ConfigError(f"speed {speed:g}: expected a positive number up to {FASTEST:g}, or inf for no waiting")
        self.name = f"replay:{recording.file}"
        self.statistics = Statistics(bad_content=recording.skipped)
        self.remark = ""
        self._recording = recording
        self._pace = speed
        self._repeat = repeat
        self._axes = axes
        self._start_ns = time.monotonic_ns()
        self._count = 0
        self._length_ns = _length(recording)

    @property
    def finished(self) -> bool:
        """Whether all samples were given; of a recording without any there will be none."""
        count = len(self._recording.time_ns)
        return count == 0 or (not self._repeat and self._count >= count)

    def read(self, timeout_s: float) -> Sample | None:
        """Wait at most ``timeout_s`` for the next sample; None at once when all were given."""
        if self.finished:
            return None
        stamp_ns = self._start_ns + self._due()
        if self._pace != math.inf and not wait_until(stamp_ns, timeout_s):
            return None
        sample = self._sample(stamp_ns)
        self._count += 1
        self.statistics.samples += 1
        return sample

    def close(self) -> None:
        """Nothing is held open."""

    def _due(self) -> int:
        """Time since the opening (ns) at which the next sample is due."""
        rounds, row = divmod(self._count, len(self._recording.time_ns))
        recorded = rounds * self._length_ns + int(self._recording.time_ns[row])
        return recorded if self._pace == math.inf else round(recorded / self._pace)

    def _sample(self, stamp_ns: int) -> Sample:
        row = self._count % len(self._recording.time_ns)
        x, y, z = self._recording.force[row].tolist()
        rate = self._rate(row)
        return Sample(
            self._count, stamp_ns, self._axes.turn((x, y, z)), None if rate is None else self._axes.turn(rate)
        )

    def _rate(self, row: int) -> Triple | None:
        if self._recording.rate is None:
            return None
        p, q, r = self._recording.rate[row].tolist()
        return (p, q, r)


def _length(recording: Recording) -> int:
    """What one round takes (ns): to the last sample, and one typical step."""
    steps = np.diff(recording.time_ns)
    return int(recording.time_ns.max(initial=0)) + (max(int(np.median(steps)), 1) if len(steps) else 1_000_000_000)
