"""Lines of plain numbers, as most sketches print them: no checksum, so a flipped digit cannot be noticed.

The separator is a comma, a semicolon, a tab or blanks. ``columns`` names what stands where: ax ay az (specific force,
in ``unit``), gx gy gz (angular velocity, in ``gyro_unit``), t_s t_ms t_us (the sensor's clock; t_ms and t_us wrap at
32 bits), and ``-`` for what is passed over. Without it, three numbers are ax ay az, and six have gx gy gz behind.
Lines of anything else, such as a header, are counted and passed over. Axes: the sensor's own.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from ravengc._convert import check_choice
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.sensors.clock import Unwrapper
from ravengc.sensors.decoders.lines import TextDecoder, numbers, triple
from ravengc.sensors.sample import Measurement
from ravengc.sensors.units import RATE_UNITS, acceleration_factor

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["CsvDecoder", "parse_columns"]

FORCE, RATE = ("ax", "ay", "az"), ("gx", "gy", "gz")
CLOCKS = {"t_s": 1e9, "t_ms": 1e6, "t_us": 1e3}
"""Names of the clock's column, and the nanoseconds in its unit."""
WRAPPING = ("t_ms", "t_us")
BY_COUNT = {3: FORCE, 6: FORCE + RATE}
LATEST_NS = 1e18
SEPARATOR = re.compile(rb"[ \t]*[,;\t ][ \t]*")


def parse_columns(text: str) -> tuple[str, ...]:
    """Read ``t_us,ax,ay,az``; ConfigError for an unknown name, one twice, or part of a vector."""
    names = tuple(name.strip() for name in text.split(","))
    known = (*FORCE, *RATE, *CLOCKS, "-")
    for name in names:
        if name not in known:
            raise ConfigError(f"columns: unknown {shown(name)}{did_you_mean(name, known)} (known: {listed(known)})")
        if name != "-" and names.count(name) > 1:
            raise ConfigError(f"columns: {name!r} stands there twice in {shown(text)}")
    if not set(FORCE) <= set(names) or len(set(RATE) & set(names)) not in (0, 3) or len(set(CLOCKS) & set(names)) > 1:
        needed = "expected ax, ay and az, all or none of gx, gy, gz, and at most one clock"
        raise ConfigError(f"columns {shown(text)}: {needed}")
    return names


class CsvDecoder(TextDecoder):
    """Reads lines of numbers; see the module for the arguments."""

    def __init__(
        self, *, unit: str = "m/s^2", sends: str = "specific_force", gyro_unit: str = "rad/s", columns: str = ""
    ) -> None:
        super().__init__()
        self._factor = acceleration_factor(unit, sends)
        check_choice(gyro_unit, RATE_UNITS, "gyro_unit")
        self._rate_factor = RATE_UNITS[gyro_unit]
        self._columns = parse_columns(columns) if columns else None
        self._clock = Unwrapper(32)
        self._begun = False

    def feed(self, data: bytes) -> list[Measurement]:
        """Take bytes in and give a measurement for every good line but the first, which may have lost its beginning."""
        lines = self._lines.lines(data)
        if lines and not self._begun:
            self._begun = True
            self.statistics.unconfirmed += 1
            del lines[0]
        return self._measurements(lines)

    def _measurement(self, line: bytes) -> Measurement | None:
        if line.startswith(b"#"):
            self.statistics.other_frames += 1
            return None
        values = numbers(SEPARATOR.split(line))
        names = self._columns or BY_COUNT.get(len(values or ()))
        if values is None or names is None or len(names) != len(values):
            self._refuse(values, names)
            return None
        return self._from_values(dict(zip(names, values, strict=True)))

    def _refuse(self, values: list[float] | None, names: Sequence[str] | None) -> None:
        self.statistics.bad_content += 1
        if values is not None:
            expected = f"columns are {','.join(names)}" if names else "say which is which: columns=t_us,ax,ay,az"
            self.remark = f"lines of {len(values)} numbers; {expected}"

    def _from_values(self, named: dict[str, float]) -> Measurement:
        force = triple([named[name] for name in FORCE], self._factor)
        rate = triple([named[name] for name in RATE], self._rate_factor) if RATE[0] in named else None
        return Measurement(force, rate, self._clock_ns(named))

    def _clock_ns(self, named: dict[str, float]) -> int | None:
        name = next((name for name in CLOCKS if name in named), None)
        if name is None or not abs(named[name] * CLOCKS[name]) < LATEST_NS:
            return None
        if name in WRAPPING:
            return int(CLOCKS[name]) * self._clock.unwrap(int(named[name]))
        return int(named[name] * CLOCKS[name])
