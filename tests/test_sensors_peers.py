"""The decoders against other people's encoders and decoders, over real descriptors, where those are installed."""

from __future__ import annotations

import importlib.util
import json
import math
import shutil
import socket
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ravengc.sensors import open_sensor
from ravengc.sensors.decoders import make_decoder
from ravengc.sensors.links import UdpLink
from ravengc.sensors.stream import StreamSensor
from sensor_frames import DEGREE, G, bno08x, samples, vectornav, witmotion
from sensor_hosts import Board, Sender, read_samples, wait_for
from test_sensors_iio import ADXL345, LSM6DSL_GYRO, device

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
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


# VectorNav: the package vectornav-vn200, which asks for registers on pyserial


def answers(board: Board, registers: dict[str, str], checksum: Callable[[str], str]) -> Callable[[int], None]:
    """A VN-200 that is asked for registers; the checksums are the peer's."""
    heard = bytearray()

    def step(_: int) -> None:
        heard.extend(board.receive(0.001))
        *commands, rest = bytes(heard).split(b"\r\n")
        heard[:] = rest
        for command in commands:
            body, theirs = command.decode()[1:].split("*")
            assert theirs == checksum(body)
            body = registers.get(body, body)
            board.send(f"${body}*{checksum(body)}\r\n".encode())

    return step


def test_vectornav_reads_what_vectornav_vn200_reads(board: Board) -> None:
    """Registers 18 and 19 hold what VNIMU sends: the same numbers, under the peer's checksum, on the same port."""
    peer("serial")
    theirs = peer("vectornav").VN200
    force, rate = "-01.258,-00.100,-09.701", "-00.000018,+00.001122,-00.000551"
    registers = {"VNRRG,18": f"VNRRG,18,{force}", "VNRRG,19": f"VNRRG,19,{rate}"}
    with Sender(answers(board, registers, theirs._checksum)), theirs(str(board.path)) as sensor:
        their_force, their_rate = sensor.read_accel(), sensor.read_gyro()
    body = f"VNIMU,-00.0049,-00.2449,+00.5397,{force},{rate},+20.7,+084.322"
    with_ours = open_sensor(f"serial:{board.path}?format=vectornav")
    board.send(f"${body}*{theirs._checksum(body)}\r\n".encode())
    (ours,) = read_samples(with_ours, 1)
    assert ours.specific_force == tuple(their_force.values())
    assert ours.angular_velocity == tuple(their_rate.values())


@given(body=st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters="$*"), max_size=80))
@settings(deadline=None)
def test_vectornav_checksums_are_vectornav_vn200s(body: str) -> None:
    checksum = peer("vectornav").VN200._checksum(body)
    decoder = make_decoder("vectornav")
    decoder.feed(f"${body}*{checksum}\r\n".encode())
    assert decoder.statistics.bad_checksum == 0


# Linux IIO: libiio through pylibiio, on folders that stand in for the kernel's in a mount namespace of its own


LIBIIO = """
import json, os, sys
try:
    import iio
    context = iio.LocalContext()
except Exception as error:
    sys.exit(f"no libiio: {error}")
found = {}
for device in context.devices:
    for channel in device.channels:
        found[channel.id] = {name: attribute.value for name, attribute in channel.attrs.items()}
print(json.dumps(found), flush=True)
os._exit(0)  # pylibiio 0.25 raises when it is taken down
"""


def as_libiio_reads(system: Path) -> dict[str, dict[str, str]]:
    """Channels and their attributes, as libiio finds them in ``system``, which it takes for /sys."""
    if importlib.util.find_spec("iio") is None or shutil.which("unshare") is None:
        pytest.skip("pylibiio or unshare is not installed (a test peer: pip install --group peers, and libiio0)")
    mounted = f'mount --bind "{system}" /sys && exec "{sys.executable}" -c "$0"'
    command = ["unshare", "--mount", "--map-root-user", "sh", "-c", mounted, LIBIIO]
    run = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if run.returncode:
        pytest.skip(f"libiio cannot be asked here: {run.stderr.strip()[-200:]}")
    found: dict[str, dict[str, str]] = json.loads(run.stdout)
    return found


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"in_accel_x_scale": "2", "in_accel_y_scale": "3", "in_accel_z_scale": "4", "in_accel_z_offset": "-6"},
        {"in_accel_offset": "10", **LSM6DSL_GYRO},
    ],
)
def test_iio_finds_the_files_that_libiio_finds(tmp_path: Path, changes: dict[str, str]) -> None:
    """Which scale and offset belong to which axis: (raw + offset) * scale by its files is what we read."""
    root = tmp_path / "bus" / "iio" / "devices"
    root.mkdir(parents=True)
    device(root, 0, {**changes, **ADXL345})
    theirs = as_libiio_reads(tmp_path)
    sample = open_sensor(f"iio:adxl345?root={root}").read(5.0)
    assert sample is not None
    for kind, ours in (("accel", sample.specific_force), ("anglvel", sample.angular_velocity)):
        files = [theirs[f"{kind}_{axis}"] for axis in "xyz" if f"{kind}_{axis}" in theirs]
        values = [(float(one["raw"]) + float(one.get("offset", 0))) * float(one["scale"]) for one in files]
        assert values == pytest.approx(list(ours or ()))
