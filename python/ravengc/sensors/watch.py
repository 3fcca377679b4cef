"""A look at a sensor's stream through its chain: a recording to its end, a live sensor for a while."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import ravengc
from ravengc.sensors.live import LiveSensor
from ravengc.sensors.seen import Watch

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from ravengc.sensors.address import Address
    from ravengc.sensors.sample import Sample, Sensor

__all__ = ["WatchedSensor", "watch"]

STEP_NS = 1_000_000
"""A recording's chain is stepped as by a loop at 1 kHz."""
LONGEST_GAP_NS = 5_000_000_000
LIVE_STEP_S = 0.002
TICK_S = 0.2


def watch(
    address: Address,
    chain: ravengc.Accelerometer,
    *,
    declared_hz: float,
    seconds: float | None,
    on_tick: Callable[[Watch], None] | None = None,
) -> Watch:
    """Watch a sensor for ``seconds`` (a recording: to its end, as fast as it can be read)."""
    found = Watch(declared_hz, address, state=chain.state)
    if address.is_recording:
        return _watch_recording(address.with_defaults(speed=math.inf).prepare()(), chain, found, seconds)
    return _watch_live(address, chain, found, 5.0 if seconds is None else seconds, on_tick)


def _watch_recording(sensor: Sensor, chain: ravengc.Accelerometer, found: Watch, seconds: float | None) -> Watch:
    start: int | None = None
    now = 0
    while (sample := sensor.read(0.0)) is not None:
        start = sample.stamp_ns if start is None else start
        for due in _steps(now, sample.stamp_ns - start):
            chain.step(start + due)
            found.note(1e-9 * due, chain)
            now = due
        if seconds is not None and 1e-9 * now > seconds:
            break
        found.take(1e-9 * now, sample)
        chain.push(*sample)
        chain.step(start + now)
        found.note(1e-9 * now, chain)
    found.link, found.remark = sensor.statistics.as_dict(), sensor.remark
    sensor.close()
    return found.close(chain)


def _steps(now: int, to: int) -> Iterator[int]:
    """The times (ns) at which a loop steps on the way; of a long gap the first seconds, in which all has happened."""
    yield from range(now + STEP_NS, min(to, now + LONGEST_GAP_NS), STEP_NS)
    if to > now:
        yield to


def _watch_live(
    address: Address,
    chain: ravengc.Accelerometer,
    found: Watch,
    seconds: float,
    on_tick: Callable[[Watch], None] | None,
) -> Watch:
    ticked = 0.0
    sensor = WatchedSensor(chain, address.prepare(), found)
    try:
        while (at := 1e-9 * (time.monotonic_ns() - sensor.start_ns)) < seconds and sensor.reader.running:
            sensor.update(at)
            found.note(at, chain)
            if on_tick is not None and at - ticked >= TICK_S:
                ticked = at
                on_tick(found)
            time.sleep(LIVE_STEP_S)
    except KeyboardInterrupt:
        pass
    finally:
        found.link = sensor.reader.statistics.as_dict()
        found.remark = sensor.remark
        sensor.close()
    return found.close(chain)


class WatchedSensor(LiveSensor):
    """A live sensor that shows its samples to a watch, ``found``, on the way to the chain; times are from its start."""

    def __init__(self, accelerometer: ravengc.Accelerometer, open_sensor: Callable[[], Sensor], found: Watch) -> None:
        self.found, self.start_ns = found, time.monotonic_ns()
        super().__init__(accelerometer, open_sensor, found.address)

    def judged_by(self, seconds: dict[str, float]) -> Watch:
        """The watch with what the chain says at the end, after so many seconds in each state in somebody's loop."""
        chain, found = self.accelerometer, self.found.close(self.accelerometer)
        found.seconds, found.state, found.likely_unit = seconds, chain.state, chain.likely_unit
        found.alarm_names = {name for name in ravengc.FAULTS if found.counters[name]}
        found.link = self.reader.statistics.as_dict()
        return found

    def _deliver(self, sample: Sample) -> None:
        self.found.take(1e-9 * (sample.stamp_ns - self.start_ns), sample)
        super()._deliver(sample)
