"""What sensors send, written a second time from the protocols' descriptions, for the decoders to be held against.

``ENCODERS[format](number)`` gives the bytes of one sample and what they mean; numbers count from 0 and make every
sample different. Values are ones that each protocol holds exactly, so that decoded ones can be compared.
"""

from __future__ import annotations

import functools
import operator
import struct
from typing import TYPE_CHECKING, NamedTuple

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

G = 9.80665
DEGREE = 0.017453292519943295


class Encoded(NamedTuple):
    """Bytes of one sample, and its specific force and angular velocity."""

    data: bytes
    force: tuple[float, ...]
    rate: tuple[float, ...] | None


def values(number: int) -> tuple[int, int, int]:
    """Three small whole numbers that differ from sample to sample."""
    return (number % 97 - 48, 100 - number % 53, 980 + number % 41)


def line(number: int) -> Encoded:
    x, y, z = (value / 100 for value in values(number))
    body = f"A,{10_000 * number},{x},{y},{z},{x / 10},{y / 10},{z / 10}"
    check = functools.reduce(operator.xor, body.encode())
    return Encoded(f"{body}*{check:02X}\r\n".encode(), (x, y, z), (x / 10, y / 10, z / 10))


def csv(number: int) -> Encoded:
    x, y, z = (value / 100 for value in values(number))
    return Encoded(f"{x},{y},{z}\n".encode(), (x, y, z), None)


def rosserial_frame(topic: int, payload: bytes) -> bytes:
    low, high = len(payload) & 255, len(payload) >> 8
    body = bytes([topic & 255, topic >> 8]) + payload
    return bytes([0xFF, 0xFE, low, high, 255 - (low + high) % 256]) + body + bytes([255 - sum(body) % 256])


def ros_text(text: str) -> bytes:
    return struct.pack("<I", len(text)) + text.encode()


def topic_info(number: int, name: str, kind: str) -> bytes:
    payload = struct.pack("<H", number) + ros_text(name) + ros_text(kind) + ros_text("0" * 32) + struct.pack("<i", 512)
    return rosserial_frame(0, payload)


def rosserial(number: int) -> Encoded:
    """A Vector3 in m/s^2 on topic 125, where an Arduino's first publisher is; the first sample tells of the topic."""
    x, y, z = (value / 128 for value in values(number))
    announcement = topic_info(125, "gravity", "geometry_msgs/Vector3") if number == 0 else b""
    return Encoded(announcement + rosserial_frame(125, struct.pack("<3d", x, y, z)), (x, y, z), None)


def bno08x(number: int) -> Encoded:
    x, y, z = values(number)
    body = bytes([number % 256]) + struct.pack("<6h", 4500, -200, number % 1000, x, y, z) + bytes(3)
    return Encoded(b"\xaa\xaa" + body + bytes([sum(body) % 256]), tuple(0.001 * G * v for v in (x, y, z)), None)


def witmotion_frame(kind: int, numbers: Sequence[int]) -> bytes:
    body = bytes([0x55, kind]) + struct.pack("<4h", *numbers)
    return body + bytes([sum(body) % 256])


def witmotion(number: int) -> Encoded:
    x, y, z = values(number)
    data = witmotion_frame(0x51, (x, y, z, 2500)) + witmotion_frame(0x52, (z, x, y, 2500))
    data += witmotion_frame(0x53, (1, 2, 3, 0))
    rate = tuple(value * 2000 * DEGREE / 32768 for value in (z, x, y))
    return Encoded(data, tuple(value * 16 * G / 32768 for value in (x, y, z)), rate)


def vectornav(number: int) -> Encoded:
    x, y, z = (value / 100 for value in values(number))
    body = f"VNYMR,+100.949,+005.500,-000.466,+01.0620,-00.2433,+02.5754,{x:+08.3f},{y:+08.3f},{-z:+08.3f},"
    body += f"{y:+09.6f},{z:+09.6f},{x:+09.6f}"
    check = functools.reduce(operator.xor, body.encode())
    return Encoded(f"${body}*{check:02X}\r\n".encode(), (x, y, -z), (y, z, x))


@functools.cache
def mavlink_sender() -> object:
    dialect = pytest.importorskip("pymavlink.dialects.v20.ardupilotmega", reason="pymavlink is not installed")
    return dialect.MAVLink(None, srcSystem=1, srcComponent=1)


def mavlink(number: int) -> Encoded:
    sender = mavlink_sender()
    x, y, z = (value / 128 for value in values(number))
    message = sender.highres_imu_encode(10_000 * (number + 1), x, y, -z, z, x, y, 0, 0, 0, 0, 0, 0, 0, 63)
    sender.seq = number % 256
    return Encoded(bytes(message.pack(sender)), (x, y, -z), (z, x, y))


ENCODERS: dict[str, Callable[[int], Encoded]] = {
    "line": line,
    "csv": csv,
    "rosserial": rosserial,
    "bno08x": bno08x,
    "vectornav": vectornav,
    "witmotion": witmotion,
    "mavlink": mavlink,
}


def samples(form: str, count: int) -> list[Encoded]:
    """The first samples of a format."""
    if form == "mavlink":
        mavlink_sender()
    return [ENCODERS[form](number) for number in range(count)]
