"""The plain text line with a checksum that ravengc's own sketches send: ``A,<t_us>,ax,ay,az[,gx,gy,gz]*XX``.

``XX`` is the exclusive or of all bytes before the star, two hexadecimal digits, as in NMEA 0183. ``t_us`` is the
sensor's clock in microseconds, 32 bits, wrapping. ax, ay, az: specific force in the unit that is set, m/s^2 by
default; gx, gy, gz: rad/s. Axes: the sensor's own.
"""

from __future__ import annotations

from ravengc.sensors.clock import Unwrapper
from ravengc.sensors.decoders.base import quoted
from ravengc.sensors.decoders.lines import TextDecoder, marked, numbers, triple, xor
from ravengc.sensors.sample import Measurement
from ravengc.sensors.units import acceleration_factor

__all__ = ["LineDecoder"]

FIELDS = (5, 8)
"""With the letter and the clock: without and with a gyroscope."""


class LineDecoder(TextDecoder):
    """Reads ``A,...*XX`` lines; ``unit`` and ``sends`` say what ax, ay, az are."""

    def __init__(self, *, unit: str = "m/s^2", sends: str = "specific_force") -> None:
        super().__init__()
        self._factor = acceleration_factor(unit, sends)
        self._clock = Unwrapper(32)

    def _measurement(self, line: bytes) -> Measurement | None:
        if line.startswith(b"#") and b"*" not in line:
            self.statistics.other_frames += 1
            self.remark = quoted(line[1:])
            return None
        if (parts := marked(line, b"A,", self.statistics)) is None:
            return None
        body, checksum = parts
        if checksum.upper() != b"%02X" % xor(body):
            self.statistics.bad_checksum += 1
            return None
        return self._from_fields(body.split(b","))

    def _from_fields(self, fields: list[bytes]) -> Measurement | None:
        values = numbers(fields[2:])
        if len(fields) not in FIELDS or not fields[1].isdigit() or values is None:
            self.statistics.bad_content += 1
            self.remark = "lines with a good checksum that are not A,t_us,ax,ay,az or A,t_us,ax,ay,az,gx,gy,gz"
            return None
        clock_ns = 1000 * self._clock.unwrap(int(fields[1]))
        rate = triple(values[3:], 1.0) if len(values) > 3 else None
        return Measurement(triple(values[:3], self._factor), rate, clock_ns)
