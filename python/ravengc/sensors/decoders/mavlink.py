"""MAVLink 1 and 2, as autopilots send it; the messages are read by pymavlink (extra ``mavlink``).

Read: HIGHRES_IMU (m/s^2, rad/s, clock in us), SCALED_IMU (mg, mrad/s, clock in ms), RAW_IMU (taken as mg and mrad/s,
as ArduPilot sends it; clock in us). All are specific force in the autopilot's body axes: x forward, y right,
**z down**, so level and at rest -9.81 along z (mavlink/mavlink, common.xml). The first of these kinds that comes, and
the autopilot it comes from, is read; ``message`` chooses the kind. How often it comes is the autopilot's own setting.

Frames are found here and not by pymavlink, whose parser believes the length behind any false start and swallows what
follows (up to 280 bytes); checksum and contents are pymavlink's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from ravengc._convert import check_choice
from ravengc.errors import MissingExtraError
from ravengc.sensors.clock import Unwrapper
from ravengc.sensors.decoders.base import Decoder
from ravengc.sensors.decoders.framer import INCOMPLETE, NO_FRAME, Framer
from ravengc.sensors.decoders.lines import triple
from ravengc.sensors.sample import Measurement
from ravengc.sensors.units import ACCELERATION_UNITS, RATE_UNITS

if TYPE_CHECKING:
    from types import ModuleType

__all__ = ["MESSAGES", "MavlinkDecoder"]

VERSION_1, VERSION_2 = 0xFE, 0xFD
SIGNED = 0x01
SIGNATURE = 13
CHECKSUM = 2


class Header(NamedTuple):
    """Where the parts of a frame stand."""

    length: int
    sequence: int
    number: slice
    sender: slice


HEADERS = {
    VERSION_1: Header(6, 2, slice(5, 6), slice(3, 5)),
    VERSION_2: Header(10, 4, slice(7, 10), slice(5, 7)),
}


class Layout(NamedTuple):
    """A message's number, factors to SI, and its clock: field, bits, nanoseconds in its unit."""

    number: int
    force: float
    rate: float
    clock: str
    bits: int
    tick_ns: int


MESSAGES = {
    "HIGHRES_IMU": Layout(105, 1.0, 1.0, "time_usec", 64, 1000),
    "SCALED_IMU": Layout(26, ACCELERATION_UNITS["mg"], RATE_UNITS["mrad/s"], "time_boot_ms", 32, 1_000_000),
    "RAW_IMU": Layout(27, ACCELERATION_UNITS["mg"], RATE_UNITS["mrad/s"], "time_usec", 64, 1000),
}
_NAMES = {layout.number: name for name, layout in MESSAGES.items()}
_FORCE_FIELDS, _RATE_FIELDS = 0b000111, 0b111000
"""Bits of HIGHRES_IMU.fields_updated."""


class Frame(NamedTuple):
    """A frame with a good checksum; ``message`` is None for those that are not read."""

    sender: bytes
    sequence: int
    name: str
    message: Any


class MavlinkDecoder(Decoder):
    """Reads one kind of IMU message of one autopilot."""

    def __init__(self, *, message: str = "") -> None:
        super().__init__()
        if message:
            check_choice(message, MESSAGES, "message")
        self._dialect = _dialect()
        self._reader = self._dialect.MAVLink(None)
        self._name = message
        self._sender: bytes | None = None
        self._sequence: int | None = None
        self._clock: Unwrapper | None = None
        starts = bytes([VERSION_1, VERSION_2])
        self._framer = Framer(starts, self._length, self._parse, self.statistics)

    @property
    def held(self) -> int:
        """Bytes kept for frames that are not complete."""
        return self._framer.held

    def feed(self, data: bytes) -> list[Measurement]:
        """Take bytes in and give a measurement for every message that is read."""
        found = (self._measurement(frame) for frame in self._framer.frames(data))
        return [measurement for measurement in found if measurement is not None]

    def _measurement(self, frame: Frame) -> Measurement | None:
        if self._sender is None and frame.message is not None and self._name in ("", frame.name):
            self._sender, self._name = frame.sender, frame.name
            self._clock = Unwrapper(MESSAGES[frame.name].bits)
        if frame.sender == self._sender:
            self._count_lost(frame.sequence)
        if frame.sender != self._sender or frame.name != self._name or not _has_force(frame.message):
            self.statistics.other_frames += 1
            return None
        return self._from_message(frame.message, MESSAGES[frame.name])

    def _count_lost(self, sequence: int) -> None:
        if self._sequence is not None:
            self.statistics.frames_lost += (sequence - self._sequence - 1) % 256
        self._sequence = sequence

    def _from_message(self, message: Any, layout: Layout) -> Measurement:
        force = triple((message.xacc, message.yacc, message.zacc), layout.force)
        rate = triple((message.xgyro, message.ygyro, message.zgyro), layout.rate)
        return Measurement(force, rate if _has_rate(message) else None, self._clock_ns(message, layout))

    def _clock_ns(self, message: Any, layout: Layout) -> int | None:
        """The autopilot's clock; some simulators leave it at zero."""
        ticks = getattr(message, layout.clock)
        return layout.tick_ns * self._clock.unwrap(ticks) if ticks and self._clock else None

    def _length(self, buffer: bytes, start: int) -> int:
        header = HEADERS[buffer[start]]
        if len(buffer) < start + header.length:
            return INCOMPLETE
        payload, flags = buffer[start + 1], buffer[start + 2] if header.length > 6 else 0
        known = self._dialect.mavlink_map.get(_number(buffer[start : start + header.length], header))
        if known is None or payload > known.unpacker.size or flags & ~SIGNED:
            return NO_FRAME
        return header.length + payload + CHECKSUM + (SIGNATURE if flags & SIGNED else 0)

    def _parse(self, frame: bytes) -> Frame | None:
        header = HEADERS[frame[0]]
        number = _number(frame, header)
        name = _NAMES.get(number, "")
        message = None
        if name:
            try:
                message = self._reader.decode(bytearray(frame))
            except self._dialect.MAVError:
                return None
        elif not self._checksum_is_good(frame, header, number):
            return None
        return Frame(frame[header.sender], frame[header.sequence], name, message)

    def _checksum_is_good(self, frame: bytes, header: Header, number: int) -> bool:
        end = header.length + frame[1]
        covered = frame[1:end] + bytes([self._dialect.mavlink_map[number].crc_extra])
        good: bool = self._dialect.x25crc(covered).crc == int.from_bytes(frame[end : end + CHECKSUM], "little")
        return good


def _dialect() -> ModuleType:
    try:
        from pymavlink.dialects.v20 import ardupilotmega
    except ImportError as error:
        raise MissingExtraError("pymavlink", "mavlink", "reading MAVLink") from error
    dialect: ModuleType = ardupilotmega
    return dialect


def _number(frame: bytes, header: Header) -> int:
    return int.from_bytes(frame[header.number], "little")


def _has_force(message: Any) -> bool:
    """Whether the accelerations are new; a HIGHRES_IMU that says nothing about its fields has all of them new."""
    updated: int = getattr(message, "fields_updated", 0)
    return updated == 0 or updated & _FORCE_FIELDS == _FORCE_FIELDS


def _has_rate(message: Any) -> bool:
    updated: int = getattr(message, "fields_updated", 0)
    return updated == 0 or updated & _RATE_FIELDS == _RATE_FIELDS
