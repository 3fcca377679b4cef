"""The decoders against other people's encoders and decoders, over real descriptors, where those are installed."""

from __future__ import annotations

import math
import socket
from typing import TYPE_CHECKING

import pytest

from ravengc.sensors import open_sensor
from ravengc.sensors.decoders import make_decoder
from ravengc.sensors.links import UdpLink
from ravengc.sensors.stream import StreamSensor
from sensor_frames import DEGREE, G, bno08x, samples, vectornav, witmotion
from sensor_hosts import Board, Sender, read_samples, wait_for

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from types import ModuleType


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    made = Board(tmp_path / "ttyBOARD")
    yield made
    made.unplug()


def peer(name: str) -> ModuleType:
    return pytest.importorskip(name, reason=f"{name} is not installed (a test peer: pip install --group peers)")


# BNO08x: Adafruit's reader on pyserial


def test_bno08x_reads_what_adafruit_reads(board: Board) -> None:
    serial, adafruit = peer("serial"), peer("adafruit_bno08x_rvc")
    with serial.Serial(str(board.path), 115200, timeout=1.0) as port, Sender(lambda _: board.send(bno08x(11).data)):
        theirs = adafruit.BNO08x_RVC(port).heading[3:]
    sensor = open_sensor(f"serial:{board.path}?format=bno08x")
    board.send(bno08x(11).data)
    (ours,) = read_samples(sensor, 1)
    assert ours.specific_force == pytest.approx(theirs, rel=1e-5)
    assert ours.specific_force != pytest.approx(theirs, rel=1e-8), "they take g for 9.8067, we 9.80665"


# WitMotion: the package witmotion on pyserial


def test_witmotion_reads_what_witmotion_reads(board: Board) -> None:
    peer("serial")
    theirs = peer("witmotion").IMU(str(board.path), 9600)
    try:
        with Sender(lambda _: board.send(witmotion(5).data)):
            wait_for(lambda: theirs.get_acceleration() and theirs.get_angular_velocity())
        force, rate = theirs.get_acceleration(), theirs.get_angular_velocity()
    finally:
        theirs.close()
        theirs.ser.close()
    sensor = open_sensor(f"serial:{board.path}?format=witmotion")
    board.send(witmotion(5).data * 3)
    ours = read_samples(sensor, 2)[1]
    assert [value / G for value in ours.specific_force] == pytest.approx([value / 9.8 for value in force], rel=1e-12)
    assert [value / DEGREE for value in ours.angular_velocity or ()] == pytest.approx(rate, rel=1e-12)


# MAVLink: pymavlink's encoder


@pytest.fixture
def mavlink() -> ModuleType:
    return peer("pymavlink.dialects.v20.ardupilotmega")


class Wire:
    """A file that collects what pymavlink sends."""

    def __init__(self) -> None:
        self.data = b""

    def write(self, data: bytes) -> None:
        self.data += bytes(data)


def test_mavlink_comes_over_udp(mavlink: ModuleType) -> None:
    link = UdpLink(0)
    sensor = StreamSensor(link, make_decoder("mavlink"))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.connect(("127.0.0.1", link.port))
        wire = type("Socket", (), {"write": lambda _, data: sender.send(bytes(data))})()
        autopilot = mavlink.MAVLink(wire, srcSystem=7, srcComponent=1)
        for number in range(300):
            autopilot.heartbeat_send(2, 3, 0, 0, 0)
            autopilot.highres_imu_send(
                4000 * number, 0.5, -0.25, -9.75 + number / 128, 0.125, 0, 0, 0, 0, 0, 0, 0, 0, 0, 63
            )
            if number % 50 == 49:
                found = read_samples(sensor, 50)
    assert [sample.specific_force[2] for sample in found] == [-9.75 + number / 128 for number in range(250, 300)]
    assert found[-1].angular_velocity == (0.125, 0.0, 0.0)
    assert sensor.statistics.samples == sensor.statistics.other_frames == 300
    assert sensor.statistics.frames_lost == sensor.statistics.bytes_skipped == 0
    sensor.close()


@pytest.mark.parametrize("version", [1, 2])
def test_mavlink_messages_in_their_units(mavlink: ModuleType, version: int) -> None:
    """Level and at rest: one g upwards, which is -z in an autopilot's axes; 1000 mrad/s about x."""
    for name, fields in (("scaled_imu", (250,)), ("raw_imu", (250_000,))):
        wire = Wire()
        autopilot = mavlink.MAVLink(wire)
        message = getattr(autopilot, f"{name}_encode")(*fields, 0, 0, -1000, 1000, 0, 0, 0, 0, 0)
        autopilot.send(message, force_mavlink1=version == 1)
        assert wire.data[0] == {1: 0xFE, 2: 0xFD}[version]
        (found,) = make_decoder("mavlink", message=name.upper()).feed(wire.data)
        assert found == ((0.0, 0.0, pytest.approx(-G)), (1.0, 0.0, 0.0), 250_000_000, 1)


def test_mavlink_reads_one_kind_of_one_autopilot(mavlink: ModuleType) -> None:
    """An ArduPilot sends RAW_IMU and SCALED_IMU of one reading; another autopilot may share the line."""
    wire = Wire()
    first, second = mavlink.MAVLink(wire, srcSystem=1), mavlink.MAVLink(wire, srcSystem=2)
    for number in range(4):
        first.raw_imu_send(1000 * number + 1, 1, 0, 0, 0, 0, 0, 0, 0, 0)
        first.scaled_imu_send(number + 1, 2, 0, 0, 0, 0, 0, 0, 0, 0)
        second.raw_imu_send(5000 * number + 1, 3, 0, 0, 0, 0, 0, 0, 0, 0)
    decoder = make_decoder("mavlink")
    assert {found.specific_force[0] for found in decoder.feed(wire.data)} == {0.001 * G}
    assert decoder.statistics.other_frames == 8
    chosen = make_decoder("mavlink", message="SCALED_IMU").feed(wire.data)
    assert {found.specific_force[0] for found in chosen} == {0.002 * G}


def test_mavlink_fields_that_are_not_new_make_no_sample(mavlink: ModuleType) -> None:
    wire = Wire()
    autopilot = mavlink.MAVLink(wire)
    for fields in (0b000111, 0b000011, 0b111000, 0b111111, 0):
        autopilot.highres_imu_send(1000, 1, 2, 3, 4, 5, 6, 0, 0, 0, 0, 0, 0, 0, fields)
    rates = [found.angular_velocity for found in make_decoder("mavlink").feed(wire.data)]
    assert rates == [None, (4.0, 5.0, 6.0), (4.0, 5.0, 6.0)]


def test_mavlink_not_a_number_reaches_the_gate(mavlink: ModuleType) -> None:
    wire = Wire()
    mavlink.MAVLink(wire).highres_imu_send(1, math.nan, math.inf, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 63)
    (found,) = make_decoder("mavlink").feed(wire.data)
    assert math.isnan(found.specific_force[0])
    assert math.isinf(found.specific_force[1])


def test_mavlink_lost_messages_are_counted(mavlink: ModuleType) -> None:
    encoded = samples("mavlink", 20)
    decoder = make_decoder("mavlink")
    decoder.feed(b"".join(sample.data for sample in encoded[:10] + encoded[13:]))
    assert decoder.statistics.frames_lost == 3
    assert mavlink.MAVLink(None).seq == 0


def test_mavlink_signed_frames_are_read(mavlink: ModuleType) -> None:
    wire = Wire()
    autopilot = mavlink.MAVLink(wire)
    autopilot.signing.secret_key, autopilot.signing.sign_outgoing = b"0" * 32, True
    autopilot.highres_imu_send(1, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 63)
    autopilot.highres_imu_send(2, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 63)
    assert len(make_decoder("mavlink").feed(wire.data)) == 2


def test_a_false_start_does_not_swallow_what_pymavlink_swallows(mavlink: ModuleType) -> None:
    """FD with a long length in front: pymavlink's parser loses the frames that this length covers, ours loses none."""
    encoded = samples("mavlink", 4)
    stream = b"\xfd\xff\x00" + b"".join(sample.data for sample in encoded)
    theirs = mavlink.MAVLink(None)
    theirs.robust_parsing = True
    their_names = [message.get_type() for message in theirs.parse_buffer(bytearray(stream)) or []]
    assert their_names.count("HIGHRES_IMU") < 4
    assert len(make_decoder("mavlink").feed(stream)) == 4


# A port that pyserial has set up otherwise


def test_a_port_is_set_up_anew(board: Board) -> None:
    """Seven bits, parity and flow control, left by pyserial, are undone."""
    serial = peer("serial")
    serial.Serial(str(board.path), 9600, bytesize=7, parity="E", xonxoff=True).close()
    sensor = open_sensor(f"serial:{board.path}?format=vectornav")
    board.send(vectornav(1).data)
    assert read_samples(sensor, 1)[0].specific_force == pytest.approx(vectornav(1).force)
