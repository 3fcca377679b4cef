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

STEP_S = 0.002


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

    def warm_up(self, patience: float) -> None:
        """Wait until the chain may be armed, for at most ``patience`` s."""
        deadline = time.monotonic() + patience
        while not self.accelerometer.armable and time.monotonic() < deadline:
            time.sleep(STEP_S)
            self.update(0.0)

    @property
    def remark(self) -> str:
        """What the sensor has to say about its stream, or why there is none."""
        event = self.reader.last_event
        lost = event is not None and event.kind in {"failed", "lost", "error"}
        return self.reader.remark or (f"{event.kind}: {event.message}" if event is not None and lost else "")

    def close(self) -> None:
        """Stop reading."""
        self.reader.stop()

    def _deliver(self, sample: Sample) -> None:
        self.accelerometer.push(*sample)

    def _happened(self, event: ReaderEvent) -> None:
        self.events.append(event)
        del self.events[: -self.EVENTS]
