"""A real sensor behind its chain: read by a thread, stepped by the loop."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Self

from ravengc._convert import check_type
from ravengc.monitored import MonitoredSensor
from ravengc.sensors.address import Address
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

    ``open_sensor`` makes the sensor, each time anew; ``address`` is where it came from, if it came from one. ``events``
    are the last openings, losses and errors of the link, ``norm`` (m/s^2) the size of the last specific force. A
    ``with`` block closes it.
    """

    EVENTS = 100

    def __init__(
        self, accelerometer: ravengc.Accelerometer, open_sensor: Callable[[], Sensor], address: Address | None = None
    ) -> None:
        super().__init__(accelerometer)
        if address is not None:
            check_type(address, Address, "address")
        self.address = address
        self.norm: float | None = None
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
        event = next((event for event in reversed(self.events) if event.kind != "stopped"), None)
        silent = event is not None and event.kind != "opened"
        return self.reader.remark or (f"{event.kind}: {event.message}" if event is not None and silent else "")

    def close(self) -> None:
        """Stop reading."""
        self.reader.stop()

    def __enter__(self) -> Self:
        """Give the sensor, which is read until the block is left."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop reading."""
        self.close()

    def _deliver(self, sample: Sample) -> None:
        self.norm = math.dist(sample.specific_force, (0.0, 0.0, 0.0))
        self.accelerometer.push(*sample)

    def _happened(self, event: ReaderEvent) -> None:
        self.events.append(event)
        del self.events[: -self.EVENTS]
