"""A real sensor behind its chain: read by a thread, stepped by the loop."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from ravengc.monitored import MonitoredSensor
from ravengc.sensors.reader import SensorReader

if TYPE_CHECKING:
    from collections.abc import Callable

    import ravengc
    from ravengc.sensors.reader import ReaderEvent
    from ravengc.sensors.sample import Sample, Sensor

__all__ = ["LiveSensor"]


class LiveSensor(MonitoredSensor):
    """A real sensor: a thread reads it and hands its samples to the chain; a lost link is reopened.

    ``open_sensor`` makes the sensor, each time anew. ``events`` are the last openings, losses and errors of the link.
    """

    EVENTS = 100

    def __init__(self, accelerometer: ravengc.Accelerometer, open_sensor: Callable[[], Sensor]) -> None:
        super().__init__(accelerometer)
        self.events: list[ReaderEvent] = []
        self.reader = SensorReader(open_sensor, self._deliver, self._happened).start()

    def update(self, _time: float) -> None:
        """Step the chain now, whatever time of the plant it is."""
        self.step(time.monotonic_ns())

    def close(self) -> None:
        """Stop reading."""
        self.reader.stop()

    def _deliver(self, sample: Sample) -> None:
        self.accelerometer.push(*sample)

    def _happened(self, event: ReaderEvent) -> None:
        self.events.append(event)
        del self.events[: -self.EVENTS]
