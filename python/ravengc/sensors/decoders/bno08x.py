"""BNO080/085/086 in UART-RVC mode: 115200 baud, 100 frames a second of 19 bytes, nothing to configure.

``AA AA index yaw pitch roll ax ay az 0 0 0 sum``: the angles in 0.01 deg, the accelerations in mg, all 16 bits signed,
little-endian; the last byte is the sum of those between the sync bytes and itself (CEVA BNO08X data sheet, 1.3.5.2).
The accelerations contain gravity and are specific force: +1000 mg along z when the chip lies flat. Axes: those printed
on the chip. There is no angular velocity and no clock; the index counts frames modulo 256. Eight bits of checksum are
few, so a frame must also have angles that exist and an index that continues one of the last two, good or not.
"""

from __future__ import annotations

import struct
from collections import deque

from ravengc.sensors.decoders.base import Decoder
from ravengc.sensors.decoders.framer import INCOMPLETE, NO_FRAME, Framer
from ravengc.sensors.decoders.lines import triple
from ravengc.sensors.sample import Measurement
from ravengc.sensors.units import ACCELERATION_UNITS

__all__ = ["Bno08xDecoder"]

SYNC = b"\xaa\xaa"
LENGTH = 19
HALF_TURN, QUARTER_TURN = 18_000, 9_000
MOST_LOST = 7
"""After a loss of more frames, the first one is taken as garbage."""
_FRAME = struct.Struct("<2xB3h3h3xB")


class Bno08xDecoder(Decoder):
    """Reads UART-RVC frames."""

    def __init__(self) -> None:
        super().__init__()
        self._framer = Framer(SYNC[:1], _length, self._parse, self.statistics, grid=LENGTH)
        self._index: int | None = None
        self._seen: deque[int] = deque(maxlen=2)

    @property
    def held(self) -> int:
        """Bytes kept for frames that are not complete."""
        return self._framer.held

    def feed(self, data: bytes) -> list[Measurement]:
        """Take bytes in and give a measurement for every good frame."""
        return [self._measurement(*frame) for frame in self._framer.frames(data)]

    def _parse(self, frame: bytes) -> tuple[int, ...] | None:
        index, yaw, pitch, roll, *force, checksum = _FRAME.unpack(frame)
        if sum(frame[2:-1]) % 256 != checksum:
            return None
        continues = not self._seen or any(0 < (index - last) % 256 <= 1 + MOST_LOST for last in self._seen)
        self._seen.append(index)
        possible = abs(yaw) <= HALF_TURN and abs(pitch) <= QUARTER_TURN and abs(roll) <= HALF_TURN
        return (index, *force) if continues and possible else None

    def _measurement(self, index: int, *force: int) -> Measurement:
        steps = 1 if self._index is None else (index - self._index) % 256 or 256
        self._index = index
        self.statistics.frames_lost += steps - 1
        return Measurement(triple(force, ACCELERATION_UNITS["mg"]), steps=steps)


def _length(buffer: bytes, start: int) -> int:
    sync = buffer[start : start + 2]
    if len(sync) < 2:
        return INCOMPLETE
    return LENGTH if sync == SYNC else NO_FRAME
