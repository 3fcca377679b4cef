"""What was seen of a sensor's stream and of its chain, while somebody watched."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

import ravengc
from ravengc.monitored import STATES

if TYPE_CHECKING:
    from ravengc.sensors.address import Address
    from ravengc.sensors.sample import Sample, Triple

__all__ = ["Episode", "Watch"]

RECENT = 200
LONGEST_STEP = 0.1
"""Between samples that are farther apart, s, nobody knows how the base turned."""
BRIEF = 0.01
"""Alarms that went for less than this, s, are one."""
MOST = 200_000
"""So many numbers of a kind are kept at least."""


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
class Turning:
    """How gravity turned against what the gyroscope said: a least-squares fit of df/dt = scale f x w, sample by sample.

    The sums are of (df/dt)², (f x w)² and their product, (m/s³)².
    """

    count: int = 0
    found: float = 0.0
    told: float = 0.0
    both: float = 0.0
    _last: tuple[float, Triple, Triple] | None = None

    def take(self, at: float, force: Triple, rate: Triple) -> None:
        """Take the next sample; what is not finite and what comes after a gap says nothing."""
        last, self._last = self._last, None
        if not all(map(math.isfinite, (*force, *rate))):
            return
        self._last = (at, force, rate)
        if last is None or not 0.0 < at - last[0] <= LONGEST_STEP:
            return
        (x, y, z), (p, q, r) = last[1], last[2]
        told = (y * r - z * q, z * p - x * r, x * q - y * p)
        u, v, w = ((new - old) / (at - last[0]) for new, old in zip(force, last[1], strict=True))
        found = (u, v, w)
        self.count += 1
        self.found += _dot(found, found)
        self.told += _dot(told, told)
        self.both += _dot(found, told)

    @property
    def scale(self) -> tuple[float, float]:
        """What times the angular velocity is how gravity turned, and the standard error; NaN if unknown."""
        if not self.told > 0.0:
            return math.nan, math.nan
        scale = self.both / self.told
        left = max(self.found - scale * self.both, 0.0)
        return scale, math.sqrt(left / (3 * self.count) / self.told)


@dataclass(slots=True)
class Watch:
    """What was seen of a stream. Times in s from the start, forces in m/s².

    ``count`` samples came; ``stamps`` and ``norms`` are those of the last of them, ``tilts`` of the last live steps, so
    that a watch may last for days. ``force`` is the sum of all finite specific forces, sensor axes.
    """

    declared_hz: float
    address: Address | None = None
    count: int = 0
    stamps: list[float] = field(default_factory=list)
    norms: list[float] = field(default_factory=list)
    tilts: list[float] = field(default_factory=list)
    lowest: float = math.inf
    highest: float = -math.inf
    force: Triple = (0.0, 0.0, 0.0)
    seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(STATES, 0.0))
    episodes: list[Episode] = field(default_factory=list)
    alarms: int = 0
    alarm_names: set[str] = field(default_factory=set)
    counters: dict[str, int] = field(default_factory=dict)
    link: dict[str, int] = field(default_factory=dict)
    likely_unit: str | None = None
    remark: str = ""
    state: str = "nominal"
    has_gyro: bool = False
    turning: Turning = field(default_factory=Turning)
    _last: float | None = None
    _alarmed: bool = False

    def take(self, at: float, sample: Sample) -> None:
        """Remember a sample."""
        norm = math.dist(sample.specific_force, (0.0, 0.0, 0.0))
        self.count += 1
        _append(self.stamps, at)
        _append(self.norms, norm)
        if sample.angular_velocity is not None:
            self.has_gyro = True
            self.turning.take(at, sample.specific_force, sample.angular_velocity)
        if not math.isfinite(norm):
            return
        self.lowest, self.highest = min(self.lowest, norm), max(self.highest, norm)
        x, y, z = map(operator.add, self.force, sample.specific_force)
        self.force = (x, y, z)
        if self.episodes and self.episodes[-1].end >= at - 0.1:
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
            _append(self.tilts, math.degrees(math.atan2(math.hypot(g.x, g.y), -g.z)))
        alarmed = bool(chain.status & 0xFFFF_FFFF)
        if alarmed:
            self._alarm(at, chain.alarms)
        self._alarmed = alarmed

    def _alarm(self, at: float, alarms: tuple[str, ...]) -> None:
        """Alarms stand: those of the step before do so still, however long ago it was."""
        self.alarm_names.update(alarms)
        if self.episodes and (self._alarmed or at - self.episodes[-1].end < BRIEF):
            episode = self.episodes[-1]
            episode.end = at
            episode.alarms += tuple(name for name in alarms if name not in episode.alarms)
        else:
            self.alarms += 1
            _append(self.episodes, Episode(at, at, alarms))

    def close(self, chain: ravengc.Accelerometer) -> Watch:
        """Take the counts at the end."""
        self.counters = chain.counters
        return self

    @property
    def rate_hz(self) -> float:
        """Samples per second: one over the median time between them; NaN for fewer than two."""
        return _rate(self.stamps)

    @property
    def recent_hz(self) -> float:
        """The same for the last of them."""
        return _rate(self.stamps[-RECENT:])

    @property
    def jitter_s(self) -> float:
        """Standard deviation of the time between samples, s; NaN for fewer than two."""
        return float(np.std(np.diff(self.stamps))) if len(self.stamps) > 1 else math.nan

    @property
    def tilt(self) -> float | None:
        """The median of the tilts while it was live, deg."""
        return float(np.median(self.tilts)) if self.tilts else None

    @property
    def norm(self) -> float:
        """The median of the norms that are numbers, m/s²; NaN if none is."""
        finite = [norm for norm in self.norms if math.isfinite(norm)]
        return float(np.median(finite)) if finite else math.nan

    @property
    def up(self) -> str:
        """The sensor's axis that pointed up on average: x, -x, y, -y, z or -z."""
        largest = max(range(3), key=lambda axis: abs(self.force[axis]))
        return ("-" if self.force[largest] < 0.0 else "") + "xyz"[largest]


def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _rate(stamps: list[float]) -> float:
    gap = float(np.median(np.diff(stamps))) if len(stamps) > 1 else math.nan
    return 1.0 / gap if gap > 0.0 else math.nan


def _append(kept: list[Any], new: Any) -> None:
    """Add to what is kept; of what has become too long, the older half goes."""
    kept.append(new)
    if len(kept) >= 2 * MOST:
        del kept[:MOST]
