"""A sensor made of a link and a decoder: bytes in, stamped samples out."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from typing import TYPE_CHECKING

from ravengc.errors import SensorError
from ravengc.sensors.clock import ClockMap, spread
from ravengc.sensors.sample import Measurement, Sample, Statistics
from ravengc.sensors.units import AXES, Axes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.sensors.decoders.base import Decoder
    from ravengc.sensors.links import Link

__all__ = ["StreamSensor"]

LONGEST_WAIT_S = 0.25
"""How long to wait for bytes before the decoder may speak again."""


class StreamSensor:
    """Reads samples from a link through a decoder, in the axes ``axes`` (the sensor's own by default).

    Where the sensor sends its clock, stamps are that clock on the host's CLOCK_MONOTONIC; else they are arrivals, and
    frames that arrive together are spread evenly over the time since those before them.
    """

    def __init__(self, link: Link, decoder: Decoder, *, axes: Axes = AXES) -> None:
        self.name = link.name
        self._link = link
        self._decoder = decoder
        self._axes = axes
        self._clock = ClockMap()
        self._stamp_ns = time.monotonic_ns()
        self._seq = -1
        self._ready: deque[Sample] = deque()

    @property
    def statistics(self) -> Statistics:
        """Counts since it was opened."""
        counts = self._decoder.statistics
        counts.clock_restarts, counts.foreign_datagrams = self._clock.restarts, self._link.foreign
        return counts

    @property
    def remark(self) -> str:
        """What is wrong with the stream, or what the sensor said, in words."""
        return self._decoder.remark

    @property
    def finished(self) -> bool:
        """Whether the end of a file was reached and all of it was given."""
        return self._link.finished and not self._ready

    def read(self, timeout_s: float) -> Sample | None:
        """Wait at most ``timeout_s`` for the next sample; None if there was none. SensorError if the link is gone."""
        deadline = time.monotonic() + timeout_s
        while not self._ready:
            left = deadline - time.monotonic()
            self._exchange(min(left, LONGEST_WAIT_S))
            if not self._ready and (self._link.finished or time.monotonic() >= deadline):
                return None
        return self._ready.popleft()

    def close(self) -> None:
        """Say goodbye where the protocol has it, and close the link; more than once is no error."""
        farewell = self._decoder.farewell()
        with contextlib.suppress(SensorError):  # a link that is gone hears nothing
            if farewell:
                self._link.send(farewell)
        self._link.close()

    def _exchange(self, timeout_s: float) -> None:
        if outgoing := self._decoder.outgoing(time.monotonic_ns()):
            self._link.send(outgoing)
        data = self._link.receive(timeout_s)
        arrival_ns = time.monotonic_ns()
        if data:
            self._decoder.statistics.bytes_received += len(data)
            self._take(data, arrival_ns)

    def _take(self, data: bytes, arrival_ns: int) -> None:
        ends_lines = self._link.is_datagram and self._decoder.is_text
        measurements = self._decoder.feed(data + b"\n" if ends_lines else data)
        self._decoder.statistics.samples += len(measurements)
        stamps = self._stamps(measurements, arrival_ns)
        self._ready.extend(map(self._sample, measurements, stamps))

    def _stamps(self, measurements: Sequence[Measurement], arrival_ns: int) -> list[int]:
        """Clock readings mapped; arrivals spread over the time since the previous ones."""
        if not measurements:
            return []
        arrivals = spread(len(measurements), self._stamp_ns, arrival_ns)
        self._stamp_ns = arrivals[-1]
        clocks = (measurement.clock_ns for measurement in measurements)
        return [
            arrival if clock is None else self._clock.stamp(clock, arrival_ns)
            for clock, arrival in zip(clocks, arrivals, strict=True)
        ]

    def _sample(self, measurement: Measurement, stamp_ns: int) -> Sample:
        self._seq += measurement.steps
        force, rate = measurement.specific_force, measurement.angular_velocity
        return Sample(self._seq, stamp_ns, self._axes.turn(force), None if rate is None else self._axes.turn(rate))
