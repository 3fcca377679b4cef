"""An Arduino that speaks rosserial, protocol revision 1 (ROS hydro and later), without any ROS here.

A frame is ``FF FE``, the payload's length (u16), 255 less the sum of the length's bytes, the topic's number (u16), the
payload, 255 less the sum of number and payload; all little-endian (ros-drivers/rosserial, node_handle.h). The host asks
for the topics with an empty frame of topic 0; the device answers with a TopicInfo each, and asks for the time (topic
10) every few seconds. Without an answer it falls silent after 11 s, so it is answered, with CLOCK_MONOTONIC.

Read: geometry_msgs Vector3, Vector3Stamped, Accel, AccelStamped, sensor_msgs/Imu, std_msgs Float32MultiArray,
Int16MultiArray (3 numbers, or 6 with angular velocities in rad/s), and three std_msgs/Float32 topics together. Stamps
are arrivals: the device's clock is set by messages that are as late as its data. Axes: the sensor's own.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from ravengc.errors import ConfigError
from ravengc.messages import listed, shown
from ravengc.sensors.decoders.base import Decoder, quoted
from ravengc.sensors.decoders.framer import INCOMPLETE, NO_FRAME, Framer
from ravengc.sensors.decoders.lines import triple
from ravengc.sensors.decoders.ros_messages import READERS, SCALAR, TopicInfo, read_scalar, read_topic_info
from ravengc.sensors.sample import Measurement
from ravengc.sensors.units import acceleration_factor

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["RosserialDecoder", "frame"]

SYNC, OLD_SYNC = b"\xff\xfe", b"\xff\xff"
HEAD, FOOT = 7, 1
LONGEST_PAYLOAD = 1024
"""Devices have buffers of 512 bytes, or less."""
PUBLISHER, LOG, TIME, STOP = 0, 7, 10, 11
FIRST_TOPIC = 100
MOST_TOPICS = 64
SECOND_NS = 1_000_000_000
OLD_PROTOCOL = "the device speaks rosserial of ROS groovy or before (FF FF); rebuild its sketch with a later ros_lib"


def frame(topic: int, payload: bytes = b"") -> bytes:
    """One frame."""
    length, body = struct.pack("<H", len(payload)), struct.pack("<H", topic) + payload
    return SYNC + length + _complement(length) + body + _complement(body)


class RosserialDecoder(Decoder):
    """Reads one topic, the first that carries an acceleration, or ``topic``; or three Float32 topics ``ax,ay,az``."""

    def __init__(self, *, topic: str = "", unit: str = "m/s^2", sends: str = "specific_force") -> None:
        super().__init__()
        self._factor = acceleration_factor(unit, sends)
        self._wanted = tuple(name.strip().lstrip("/") for name in topic.split(",")) if topic else ()
        if len(self._wanted) not in (0, 1, 3):
            raise ConfigError(f"topic {shown(topic)}: give one name, or three of Float32 topics (x, y, z)")
        self._framer = Framer(SYNC[:1], self._length, _parse, self.statistics)
        self._topics: dict[int, TopicInfo] = {}
        self._chosen: int | None = None
        self._scalars: dict[str, float] = {}
        self._time_wanted = False
        self._delivered = self._seen = 0
        self._quiet_since_ns: int | None = None

    @property
    def held(self) -> int:
        """Bytes kept for frames that are not complete."""
        return self._framer.held

    def feed(self, data: bytes) -> list[Measurement]:
        """Take bytes in and give a measurement for every message of the topic that is read."""
        found = (self._measurement(topic, payload) for topic, payload in self._framer.frames(data))
        measurements = [measurement for measurement in found if measurement is not None]
        self._delivered += len(measurements)
        return measurements

    def outgoing(self, now_ns: int) -> bytes:
        """The time if the device asked for it; the question for its topics after every second without a measurement.

        A device that was reset says nothing until it is asked again.
        """
        answer = frame(TIME, struct.pack("<II", *divmod(now_ns, SECOND_NS))) if self._time_wanted else b""
        self._time_wanted = False
        if self._delivered != self._seen:
            self._seen, self._quiet_since_ns = self._delivered, now_ns
        if self._quiet_since_ns is not None and now_ns - self._quiet_since_ns < SECOND_NS:
            return answer
        self._quiet_since_ns = now_ns
        return answer + frame(PUBLISHER)

    def farewell(self) -> bytes:
        """Ask the device to stop sending."""
        return frame(STOP)

    def _measurement(self, topic: int, payload: bytes) -> Measurement | None:
        try:
            if topic >= FIRST_TOPIC:
                return self._message(topic, payload)
            self._control(topic, payload)
        except (struct.error, ValueError) as error:
            self.statistics.bad_content += 1
            self.remark = f"topic {topic}: {error}"
        return None

    def _control(self, topic: int, payload: bytes) -> None:
        self.statistics.other_frames += 1
        if topic == PUBLISHER:
            self._add(read_topic_info(payload))
        elif topic == TIME:
            self._time_wanted = True
        elif topic == LOG and len(payload) > 5:
            self.remark = quoted(payload[5:])

    def _add(self, info: TopicInfo) -> None:
        if len(self._topics) >= MOST_TOPICS:
            self._topics.clear()
        self._topics[info.number] = info._replace(name=info.name.lstrip("/"))
        fitting = [number for number, topic in self._topics.items() if self._fits(topic)]
        if self._chosen not in fitting:
            self._chosen = next(iter(fitting), None)
        offered = listed(f"{topic.name} ({topic.kind})" for topic in self._topics.values())
        self.remark = "" if fitting else f"no topic with an acceleration to read yet; the device has {offered}"

    def _fits(self, topic: TopicInfo) -> bool:
        if len(self._wanted) == 3:
            return topic.kind == SCALAR and topic.name in self._wanted
        return topic.kind in READERS and self._wanted in ((), (topic.name,))

    def _message(self, number: int, payload: bytes) -> Measurement | None:
        topic = self._topics.get(number)
        if topic is not None and len(self._wanted) == 3 and self._fits(topic):
            return self._from_scalar(topic.name, read_scalar(payload))
        if topic is not None and number == self._chosen:
            return self._from_values(READERS[topic.kind](payload))
        self.statistics.other_frames += 1
        return None

    def _from_values(self, values: Sequence[float]) -> Measurement:
        return Measurement(triple(values[:3], self._factor), triple(values[3:], 1.0) if len(values) == 6 else None)

    def _from_scalar(self, name: str, value: float) -> Measurement | None:
        """The three together, once each has come since they were last complete."""
        self._scalars[name] = value
        if len(self._scalars) < 3:
            return None
        values = [self._scalars.pop(wanted) for wanted in self._wanted]
        return self._from_values(values)

    def _length(self, buffer: bytes, start: int) -> int:
        sync = buffer[start : start + 2]
        if sync == OLD_SYNC and not self.statistics.samples:
            self.remark = OLD_PROTOCOL
        if sync not in (SYNC, SYNC[:1]):
            return NO_FRAME
        if len(buffer) < start + HEAD:
            return INCOMPLETE
        length = int.from_bytes(buffer[start + 2 : start + 4], "little")
        good = buffer[start + 4 : start + 5] == _complement(buffer[start + 2 : start + 4])
        return HEAD + length + FOOT if good and length <= LONGEST_PAYLOAD else NO_FRAME


def _parse(found: bytes) -> tuple[int, bytes] | None:
    if found[-1:] != _complement(found[5:-1]):
        return None
    return int.from_bytes(found[5:7], "little"), found[7:-1]


def _complement(data: bytes) -> bytes:
    return bytes([255 - sum(data) % 256])
