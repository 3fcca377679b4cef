"""What a sensor sent, kept in a file byte by byte: decoded whole, and given again as it was taken.

The file says nothing about when its bytes came. Times are those of the sensor's own clock, or one period of the rate
apart where it sends none; where its clock went back, as it does when a board restarts, the next period follows.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import accumulate, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ravengc._convert import as_number
from ravengc.errors import ConfigError, SensorError
from ravengc.sensors.recorded import Recording
from ravengc.sensors.replay import ReplaySensor
from ravengc.sensors.units import AXES, Axes

if TYPE_CHECKING:
    from ravengc.sensors.decoders.base import Decoder
    from ravengc.sensors.sample import Measurement, Statistics, Triple

__all__ = ["Capture", "CapturedSensor", "read_capture"]

LARGEST = 64 * 2**20
PIECE = 65536
DEFAULT_HZ, FASTEST_HZ = 100.0, 1e5
LONGEST_NS = 3_600_000_000_000
"""Where a clock is further ahead than this, it has jumped."""
LATEST_NS = 2**62


class Capture(NamedTuple):
    """A decoded file: the recording, the angular velocity of each sample (rad/s, None without), and the counts."""

    recording: Recording
    rates: list[Triple | None]
    statistics: Statistics
    remark: str


class CapturedSensor(ReplaySensor):
    """Gives the samples of a capture; the arguments are those of :class:`ReplaySensor`."""

    def __init__(self, capture: Capture, *, speed: float = 1.0, repeat: bool = False, axes: Axes = AXES) -> None:
        super().__init__(capture.recording, speed=speed, repeat=repeat, axes=axes)
        self.name = f"file:{capture.recording.file}"
        self.statistics = replace(capture.statistics)
        self.remark = capture.remark
        self._rates = capture.rates

    def _rate(self, row: int) -> Triple | None:
        return self._rates[row]


def read_capture(path: str, decoder: Decoder, rate_hz: float = DEFAULT_HZ) -> Capture:
    """Decode a file of at most 64 MiB. Raises SensorError if it cannot be read, ConfigError for a rate that is none."""
    if not 0.0 < as_number(rate_hz, "rate") <= FASTEST_HZ:
        raise ConfigError(f"rate {rate_hz:g} Hz: expected a positive number of at most {FASTEST_HZ:g}")
    found = _decoded(path, decoder)
    force = np.array([measurement.specific_force for measurement in found], dtype=np.float64).reshape(-1, 3)
    recording = Recording(path, _times(found, round(1e9 / rate_hz)), force, None, 0)
    rates = [measurement.angular_velocity for measurement in found]
    return Capture(recording, rates, decoder.statistics, decoder.remark)


def _decoded(path: str, decoder: Decoder) -> list[Measurement]:
    found: list[Measurement] = []
    try:
        with Path(path).open("rb") as file:
            while (data := file.read(PIECE)) and decoder.statistics.bytes_received <= LARGEST:
                decoder.statistics.bytes_received += len(data)
                found += decoder.feed(data)
    except OSError as error:
        raise SensorError(f"file {path!r} cannot be read: {error.strerror or error}") from error
    if decoder.statistics.bytes_received > LARGEST:
        raise SensorError(f"file {path!r} is larger than {LARGEST // 2**20} MiB; cut it into parts")
    return found


def _times(found: list[Measurement], period_ns: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Time of each measurement since the first, ns."""
    steps = [_step(before, now, period_ns) for before, now in pairwise(found)]
    return np.array([min(time, LATEST_NS) for time in accumulate(steps, initial=0)][: len(found)], dtype=np.int64)


def _step(before: Measurement, now: Measurement, period_ns: int) -> int:
    """Time between two measurements, ns, by the sensor's clock where that makes sense."""
    if before.clock_ns is not None and now.clock_ns is not None and 0 < now.clock_ns - before.clock_ns < LONGEST_NS:
        return now.clock_ns - before.clock_ns
    return period_ns * now.steps
