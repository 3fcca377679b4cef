"""VectorNav VN-100/200/300, ASCII messages: ``$VNYMR,...*XX`` with the 8-bit checksum or ``*XXXX`` with the 16-bit CRC.

Read: VNYMR, VNQMR, VNMAR, VNIMU, VNACC (asynchronous data output types 14, 8, 12, 19, 4 of the VN-100 user manual).
Specific force in m/s^2, angular velocity in rad/s, axes x forward, y right, **z down**: level and at rest the manual's
sample reads -9.801 along z. VNYBA and VNYIA have gravity removed and are refused. There is no clock. The checksum is
the exclusive or of the bytes between ``$`` and ``*``, the CRC is CRC-16/XMODEM of the same.
"""

from __future__ import annotations

from binascii import crc_hqx
from typing import NamedTuple

from ravengc.sensors.decoders.lines import TextDecoder, marked, numbers, triple, xor
from ravengc.sensors.sample import Measurement

__all__ = ["VectorNavDecoder"]


class Layout(NamedTuple):
    """How many numbers a message has, and where the vectors start."""

    numbers: int
    force: int
    rate: int | None


MESSAGES = {
    b"VNYMR": Layout(12, 6, 9),
    b"VNQMR": Layout(13, 7, 10),
    b"VNMAR": Layout(9, 3, 6),
    b"VNIMU": Layout(11, 3, 6),
    b"VNACC": Layout(3, 0, None),
}
WITHOUT_GRAVITY = (b"VNYBA", b"VNYIA")
REFUSED = "have gravity removed: set asynchronous data output to VNYMR (14) or VNIMU (19)"


class VectorNavDecoder(TextDecoder):
    """Reads ASCII messages; whatever else the sensor says is counted as other frames."""

    def _measurement(self, line: bytes) -> Measurement | None:
        if (parts := marked(line, b"$", self.statistics)) is None:
            return None
        body, checksum = parts[0][1:], parts[1].upper()
        if checksum not in (b"%02X" % xor(body), b"%04X" % crc_hqx(body, 0)):
            self.statistics.bad_checksum += 1
            return None
        name, *fields = body.split(b",")
        return self._from_fields(name, fields)

    def _from_fields(self, name: bytes, fields: list[bytes]) -> Measurement | None:
        if (layout := MESSAGES.get(name)) is None:
            self.statistics.other_frames += 1
            self.remark = f"{name.decode('ascii')} messages {REFUSED}" if name in WITHOUT_GRAVITY else self.remark
            return None
        values = numbers(fields[: layout.numbers])  # behind them, the sensor may have been told to append its status
        if values is None or len(values) != layout.numbers:
            self.statistics.bad_content += 1
            return None
        rate = None if layout.rate is None else triple(values[layout.rate : layout.rate + 3], 1.0)
        return Measurement(triple(values[layout.force : layout.force + 3], 1.0), rate)
