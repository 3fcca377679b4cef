"""A look at a sensor's stream through its chain: rate, jitter, size and direction of gravity, states, alarms."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

import ravengc
from ravengc.monitored import STATES
from ravengc.sensors.live import LiveSensor

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.sensors.address import Address
    from ravengc.sensors.sample import Sample, Sensor

__all__ = ["Episode", "Watch", "watch"]

STEP_NS = 1_000_000
"""A recording's chain is stepped as by a loop at 1 kHz."""
LIVE_STEP_S = 0.002
TICK_S = 0.2


@dataclass(slots=True)
class Episode:
    """A time during which alarms stood, from ``begin`` to ``end`` (s): their names, and the norms meanwhile."""

    begin: float
    end: float
    alarms: tuple[str, ...]
    lowest: float = math.inf
    highest: float = -math.inf

    def explained(self) -> str:
        """What they mean, and what the samples were like."""
        words = "; ".join(ravengc.FAULTS[name] for name in self.alarms)
        return words if self.lowest > self.highest else f"{words} (norm {self.lowest:.2f} to {self.highest:.2f} m/s²)"


@dataclass(slots=True)
class Watch:
    """What was seen of a stream. Times in s from the start, forces in m/s²."""

    declared_hz: float
    stamps: list[float] = field(default_factory=list)
    norms: list[float] = field(default_factory=list)
    tilts: list[float] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(STATES, 0.0))
    episodes: list[Episode] = field(default_factory=list)
    counters: dict[str, int] = field(default_factory=dict)
    link: dict[str, int] = field(default_factory=dict)
    likely_unit: str | None = None
    remark: str = ""
    state: str = "nominal"
    has_gyro: bool = False
    _last: float | None = None

    def take(self, at: float, sample: Sample) -> None:
        """Remember a sample."""
        norm = math.dist(sample.specific_force, (0.0, 0.0, 0.0))
        self.stamps.append(at)
        self.norms.append(norm)
        self.has_gyro |= sample.angular_velocity is not None
        if self.episodes and self.episodes[-1].end >= at - 0.1 and math.isfinite(norm):
            episode = self.episodes[-1]
            episode.lowest, episode.highest = min(episode.lowest, norm), max(episode.highest, norm)

    def note(self, at: float, chain: ravengc.Accelerometer) -> None:
        """Remember the chain as it is after a step."""
        if self._last is not None:
            self.seconds[self.state] += at - self._last
        self._last, self.state = at, chain.state
        self.likely_unit = chain.likely_unit or self.likely_unit
        if chain.state == "live":
            g = chain.gravity
            self.tilts.append(math.degrees(math.atan2(math.hypot(g.x, g.y), -g.z)))
        if chain.status & 0xFFFF_FFFF:
            self._alarm(at, chain.alarms)

    def _alarm(self, at: float, alarms: tuple[str, ...]) -> None:
        if self.episodes and at - self.episodes[-1].end < 0.01:
            episode = self.episodes[-1]
            episode.end = at
            episode.alarms += tuple(name for name in alarms if name not in episode.alarms)
        else:
            self.episodes.append(Episode(at, at, alarms))

    def close(self, chain: ravengc.Accelerometer) -> Watch:
        """Take the counts at the end."""
        self.counters = chain.counters
        return self

    @property
    def rate_hz(self) -> float:
        """Samples per second: one over the median time between them; NaN for fewer than two."""
        return (
            1.0 / float(np.median(self._gaps())) if len(self.stamps) > 1 and np.median(self._gaps()) > 0.0 else math.nan
        )

    @property
    def jitter_s(self) -> float:
        """Standard deviation of the time between samples, s; NaN for fewer than two."""
        return float(np.std(self._gaps())) if len(self.stamps) > 1 else math.nan

    def _gaps(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        return np.diff(self.stamps)

    def verdicts(self) -> list[str]:
        """What is wrong, in words; what is right, if nothing is."""
        said = [self.remark] if self.remark else []
        if not self.stamps:
            return [*said, "no sample came"]
        norm = float(np.nanmedian(self.norms)) if np.isfinite(self.norms).any() else math.nan
        if self.likely_unit is not None:
            said.append(f"norm {norm:.4g}: looks like {self.likely_unit}, not m/s²: set unit = {self.likely_unit}")
        if abs(self.rate_hz / self.declared_hz - 1.0) > 0.1:
            said.append(f"{self.rate_hz:.4g} samples per second, declared are {self.declared_hz:g}: set rate_hz")
        if self.jitter_s * self.rate_hz > 0.5:
            said.append(f"samples come unevenly: {1e3 * self.jitter_s:.1f} ms around {1e3 / self.rate_hz:.1f} ms")
        bad = sum(self.link.get(name, 0) for name in ("bad_checksum", "bad_content"))
        if bad:
            said.append(f"{bad} frames with a wrong checksum or content: a bad cable, another baud rate or format")
        said += [f"{len(self.episodes)} times alarmed"] if self.episodes else []
        return said or ["nothing wrong was seen"]

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain data."""
        norms = np.array([norm for norm in self.norms if math.isfinite(norm)])
        size = {"median": np.median(norms), "lowest": norms.min(), "highest": norms.max()} if len(norms) else None
        return {
            "samples": len(self.stamps),
            "rate_hz": self.rate_hz,
            "jitter_s": self.jitter_s,
            "norm_m_s2": size,
            "tilt_deg": float(np.median(self.tilts)) if self.tilts else None,
            "gyroscope": self.has_gyro,
            "seconds": self.seconds,
            "alarms": [
                {"begin_s": one.begin, "end_s": one.end, "alarms": one.alarms, "explained": one.explained()}
                for one in self.episodes
            ],
            "counters": self.counters,
            "link": self.link,
            "likely_unit": self.likely_unit,
            "verdicts": self.verdicts(),
        }


def watch(
    address: Address,
    chain: ravengc.Accelerometer,
    *,
    declared_hz: float,
    seconds: float | None,
    on_tick: Callable[[Watch], None] | None = None,
) -> Watch:
    """Watch a sensor for ``seconds`` (a recording: to its end, as fast as it can be read)."""
    found = Watch(declared_hz)
    if address.kind == "replay" and "speed" not in address.options:
        return _watch_recording(address.with_defaults(speed=math.inf).prepare()(), chain, found, seconds)
    return _watch_live(address, chain, found, 5.0 if seconds is None else seconds, on_tick)


def _watch_recording(sensor: Sensor, chain: ravengc.Accelerometer, found: Watch, seconds: float | None) -> Watch:
    start: int | None = None
    now = 0
    while (sample := sensor.read(0.0)) is not None:
        start = sample.stamp_ns if start is None else start
        while now < sample.stamp_ns - start:
            now = min(now + STEP_NS, sample.stamp_ns - start)
            chain.step(start + now)
            found.note(1e-9 * now, chain)
        if seconds is not None and 1e-9 * now > seconds:
            break
        found.take(1e-9 * now, sample)
        chain.push(*sample)
        chain.step(start + now)
        found.note(1e-9 * now, chain)
    found.link = sensor.statistics.as_dict()
    sensor.close()
    return found.close(chain)


def _watch_live(
    address: Address,
    chain: ravengc.Accelerometer,
    found: Watch,
    seconds: float,
    on_tick: Callable[[Watch], None] | None,
) -> Watch:
    start, ticked = time.monotonic_ns(), 0.0
    sensor = _Watched(chain, address.prepare(), found, start)
    try:
        while (at := 1e-9 * (time.monotonic_ns() - start)) < seconds and sensor.reader.running:
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


class _Watched(LiveSensor):
    """Shows its samples to a watch on the way to the chain."""

    def __init__(
        self, chain: ravengc.Accelerometer, open_sensor: Callable[[], Sensor], found: Watch, start: int
    ) -> None:
        self._found, self._start = found, start
        super().__init__(chain, open_sensor)

    def _deliver(self, sample: Sample) -> None:
        self._found.take(1e-9 * (sample.stamp_ns - self._start), sample)
        super()._deliver(sample)
