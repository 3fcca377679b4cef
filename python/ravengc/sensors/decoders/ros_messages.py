"""The ROS 1 messages that carry an acceleration, from their bytes: little-endian, texts and lists with their length.

Each reader returns the values or raises struct.error or ValueError for bytes that are no such message, which
:mod:`ravengc.sensors.decoders.rosserial` counts.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["READERS", "SCALAR", "TopicInfo", "read_scalar", "read_topic_info"]

Values = tuple[float, ...]

SCALAR = "std_msgs/Float32"
MOST_ENTRIES = 6
IMU_DOUBLES = 37
"""orientation 4, its covariance 9, angular velocity 3, covariance 9, linear acceleration 3, covariance 9."""


class TopicInfo(NamedTuple):
    """What a device says about one of its topics (rosserial_msgs/TopicInfo), but for md5 sum and buffer size."""

    number: int
    name: str
    kind: str


def read_topic_info(data: bytes) -> TopicInfo:
    """Number, name and message type of a topic."""
    (number,) = struct.unpack_from("<H", data)
    name, position = _text(data, 2)
    kind, _ = _text(data, position)
    return TopicInfo(number, name.decode("utf-8", "replace"), kind.decode("utf-8", "replace"))


def read_scalar(data: bytes) -> float:
    """std_msgs/Float32."""
    (value,) = struct.unpack("<f", data)
    return float(value)


def _text(data: bytes, position: int) -> tuple[bytes, int]:
    (length,) = struct.unpack_from("<I", data, position)
    end = position + 4 + length
    if end > len(data):
        raise ValueError("a text that is longer than its message")
    return data[position + 4 : end], end


def _vector(data: bytes) -> Values:
    return struct.unpack("<3d", data)


def _stamped_vector(data: bytes) -> Values:
    return _vector(data[_header_end(data) :])


def _imu(data: bytes) -> Values:
    """Linear acceleration, then angular velocity; a first covariance of -1 says that the message lacks a quantity."""
    values = struct.unpack(f"<{IMU_DOUBLES}d", data[_header_end(data) :])
    if values[28] == -1.0:
        raise ValueError("an Imu message without linear acceleration")
    rate = () if values[16] == -1.0 else values[13:16]
    return (*values[25:28], *rate)


def _header_end(data: bytes) -> int:
    """Behind std_msgs/Header: a number, a time, the frame's name."""
    return _text(data, 12)[1]


def _floats(data: bytes) -> Values:
    return _array(data, "f")


def _shorts(data: bytes) -> Values:
    return _array(data, "h")


def _array(data: bytes, kind: str) -> Values:
    """Three or six numbers behind a MultiArrayLayout: a list of dimensions (label, size, stride), the data's offset."""
    (dimensions,) = struct.unpack_from("<I", data)
    position = 4
    for _ in range(min(dimensions, MOST_ENTRIES)):
        position = _text(data, position)[1] + 8
    (count,) = struct.unpack_from("<I", data, position + 4)
    if count not in (3, 6):
        raise ValueError(f"an array of {count} numbers")
    return struct.unpack(f"<{count}{kind}", data[position + 8 :])


def _accel(data: bytes) -> Values:
    """The linear part; the angular part is an angular acceleration."""
    return struct.unpack("<6d", data)[:3]


def _stamped_accel(data: bytes) -> Values:
    return _accel(data[_header_end(data) :])


READERS: dict[str, Callable[[bytes], Values]] = {
    "geometry_msgs/Vector3": _vector,
    "geometry_msgs/Vector3Stamped": _stamped_vector,
    "geometry_msgs/AccelStamped": _stamped_accel,
    "geometry_msgs/Accel": _accel,
    "sensor_msgs/Imu": _imu,
    "std_msgs/Float32MultiArray": _floats,
    "std_msgs/Int16MultiArray": _shorts,
}
"""By message type: three accelerations, and behind them three angular velocities where the message has them."""
