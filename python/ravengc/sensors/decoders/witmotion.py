"""WitMotion modules (WT61, WT901 and kin): frames of 11 bytes, ``55 kind x y z t sum``, values of 16 bits.

Kind 51: specific force, 32768 = 16 g; 52: angular velocity, 32768 = 2000 deg/s; the sum is over all bytes before it
(WitMotion standard protocol). Specific force: +1 g along z when the module lies flat. Axes: those printed on it.
There is no clock. An acceleration waits for the angular velocity that follows it, if this module sends one.
"""

from __future__ import annotations

import struct

from ravengc.sensors.decoders.base import Decoder
from ravengc.sensors.decoders.framer import INCOMPLETE, NO_FRAME, Framer
from ravengc.sensors.decoders.lines import triple
from ravengc.sensors.sample import Measurement, Triple
from ravengc.sensors.units import ACCELERATION_UNITS, RATE_UNITS

__all__ = ["WitMotionDecoder"]

SYNC = 0x55
KINDS = range(0x50, 0x60)
ACCELERATION, RATE = 0x51, 0x52
LENGTH = 11
FORCE_FACTOR = 16 * ACCELERATION_UNITS["g"] / 32768
RATE_FACTOR = 2000 * RATE_UNITS["deg/s"] / 32768
_FRAME = struct.Struct("<xB3h2xB")


class WitMotionDecoder(Decoder):
    """Reads the frames of kind 51 and 52."""

    def __init__(self) -> None:
        super().__init__()
        self._framer = Framer(bytes([SYNC]), _length, _parse, self.statistics, grid=LENGTH)
        self._waiting: Triple | None = None
        self._last = 0
        self._rate_follows = False

    @property
    def held(self) -> int:
        """Bytes kept for frames that are not complete."""
        return self._framer.held

    def feed(self, data: bytes) -> list[Measurement]:
        """Take bytes in and give a measurement for every acceleration, with its angular velocity where it has one."""
        return [found for frame in self._framer.frames(data) for found in self._measurements(*frame)]

    def _measurements(self, kind: int, *values: int) -> list[Measurement]:
        force, self._waiting = self._waiting, None
        follows, self._last = self._last == ACCELERATION and kind == RATE, kind
        if follows:
            self._rate_follows = True
            return [] if force is None else [Measurement(force, triple(values, RATE_FACTOR))]
        self._rate_follows = self._rate_follows and force is None
        left = [] if force is None else [Measurement(force)]
        if kind != ACCELERATION:
            self.statistics.other_frames += 1
            return left
        now = triple(values, FORCE_FACTOR)
        self._waiting = now if self._rate_follows else None
        return left if self._rate_follows else [*left, Measurement(now)]


def _length(buffer: bytes, start: int) -> int:
    if start + 1 >= len(buffer):
        return INCOMPLETE
    return LENGTH if buffer[start + 1] in KINDS else NO_FRAME


def _parse(frame: bytes) -> tuple[int, ...] | None:
    *values, checksum = _FRAME.unpack(frame)
    return tuple(values) if sum(frame[:-1]) % 256 == checksum else None
