"""Sensors on real descriptors: pseudo terminals, pipes, files and standard input."""

from __future__ import annotations

import errno
import io
import itertools
import os
import subprocess
import sys
import termios
import time
from typing import TYPE_CHECKING

import pytest

from ravengc.errors import ConfigError, ParseError, SensorError
from ravengc.sensors import open_sensor
from ravengc.sensors.links import BAUD_RATES, open_serial
from sensor_frames import bno08x, line, rosserial_frame, samples, topic_info
from sensor_hosts import Board, Sender, read_samples, wait_for

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    made = Board(tmp_path / "ttyBOARD")
    yield made
    made.unplug()


# Serial ports


def test_samples_come_through_a_serial_port(board: Board) -> None:
    sensor = open_sensor(f"serial:{board.path}?format=bno08x")
    for number in range(20):
        board.send(bno08x(number).data)
    found = read_samples(sensor, 20)
    assert [sample.specific_force for sample in found] == [pytest.approx(bno08x(n).force) for n in range(20)]
    assert [sample.seq for sample in found] == list(range(20))
    assert all(later.stamp_ns > sooner.stamp_ns for sooner, later in itertools.pairwise(found))
    assert sensor.statistics.samples == 20
    assert sensor.statistics.bytes_received == 20 * 19
    sensor.close()
    sensor.close()


def test_the_port_is_raw_and_has_the_rate_asked_for(board: Board) -> None:
    link = open_serial(str(board.path), 57600)
    assert board.speed() == termios.B57600
    board.send(b"\x00\x03\x04\r\n\x11\x13\xff")
    received = b""
    while len(received) < 8:
        received += link.receive(1.0)
    assert received == b"\x00\x03\x04\r\n\x11\x13\xff"
    link.send(b"\n\x00\xff")
    assert board.receive(5.0) == b"\n\x00\xff"
    link.close()


def test_a_port_has_one_reader(board: Board) -> None:
    link = open_serial(str(board.path))
    with pytest.raises(SensorError, match="busy: another program has it"):
        open_serial(str(board.path))
    link.close()
    open_serial(str(board.path)).close()


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("/dev/ttyRAVENGC", "not there"),
        ("/dev/null", "no serial port"),
        ("/", "no serial port"),
        ("a\0b", "serial port"),
    ],
)
def test_what_is_no_port_is_a_sensor_error(path: str, words: str) -> None:
    with pytest.raises(SensorError, match=words):
        open_serial(path)


def test_a_false_wake_up_is_no_lost_port(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was announced may have been flushed before it is read."""
    link = open_serial(str(board.path))
    monkeypatch.setattr("ravengc.sensors.links.descriptor.wait_readable", lambda *_: True)
    assert link.receive(0.0) == b""
    link.close()


def test_a_rate_that_the_port_does_not_take_is_said(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    """tcsetattr succeeds if any of the settings could be made."""
    real = termios.tcsetattr

    def without_rate(descriptor: int, when: int, modes: list) -> None:
        real(descriptor, when, [*modes[:4], termios.B9600, termios.B9600, modes[6]])

    monkeypatch.setattr(termios, "tcsetattr", without_rate)
    with pytest.raises(SensorError, match="cannot run at this baud rate"):
        open_serial(str(board.path), 4_000_000)
    open_serial(str(board.path), 9600).close()


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.EACCES, "not permitted; members of the group 'dialout'"),
        (errno.EIO, "no device behind it"),
        (errno.EBUSY, "busy: another program has it"),
        (errno.ENOMEM, "Cannot allocate memory"),
    ],
)
def test_why_a_port_cannot_be_opened_is_said(number: int, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: str, _: int) -> int:
        raise OSError(number, os.strerror(number), path)

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(SensorError) as caught:
        open_serial("/dev/ttyUSB0")
    monkeypatch.undo()
    assert words in str(caught.value)
    assert "Errno" not in str(caught.value)


@pytest.mark.parametrize("baud", sorted({*BAUD_RATES} & {9600, 57600, 115200, 230400, 460800, 921600, 4_000_000}))
def test_every_usual_rate_is_set(board: Board, baud: int) -> None:
    sensor = open_sensor(f"serial:{board.path}?baud={baud}")
    assert board.speed() == BAUD_RATES[baud]
    sensor.close()


def test_unplugging_is_a_sensor_error(board: Board) -> None:
    sensor = open_sensor(f"serial:{board.path}")
    board.send(line(0).data)
    read_samples(sensor, 1)
    board.unplug()
    with pytest.raises(SensorError, match=r"unplugged|lost"):
        read_samples(sensor, 1)
    with pytest.raises(SensorError):
        sensor.read(0.0)
    sensor.close()
    with pytest.raises(SensorError, match="closed"):
        sensor.read(0.0)


def test_silence_is_no_error(board: Board) -> None:
    sensor = open_sensor(f"serial:{board.path}")
    assert sensor.read(0.0) is None
    assert sensor.read(0.01) is None
    assert not sensor.finished


def test_axes_are_turned_on_request(board: Board) -> None:
    sensor = open_sensor(f"serial:{board.path}?format=line&axes=-z,x,-y")
    board.send(line(3).data)
    (sample,) = read_samples(sensor, 1)
    (x, y, z), (p, q, r) = line(3).force, line(3).rate
    assert sample.specific_force == (-z, x, -y)
    assert sample.angular_velocity == (-r, p, -q)


# The host's clock


def test_a_sensor_clock_gives_stamps_a_period_apart_though_frames_come_together(board: Board) -> None:
    sensor = open_sensor(f"serial:{board.path}?format=line")
    board.send(line(0).data)
    read_samples(sensor, 1)
    time.sleep(0.05)
    board.send(b"".join(line(number).data for number in range(1, 5)))
    found = read_samples(sensor, 4)
    steps = [later.stamp_ns - sooner.stamp_ns for sooner, later in itertools.pairwise(found)]
    assert steps == [10_000_000] * 3
    assert found[-1].stamp_ns <= time.monotonic_ns()


def test_arrivals_that_come_together_are_spread(board: Board) -> None:
    sensor = open_sensor(f"serial:{board.path}?format=bno08x")
    start = time.monotonic_ns()
    board.send(b"".join(bno08x(number).data for number in range(5)))
    found = read_samples(sensor, 5)
    stamps = [sample.stamp_ns for sample in found]
    assert stamps == sorted(set(stamps))
    assert stamps[-1] >= start
    gaps = [later - sooner for sooner, later in itertools.pairwise(stamps)]
    assert max(gaps) - min(gaps) <= 1


# rosserial: a device that behaves as ros_lib does


class RosserialDevice:
    """Tells its topics when asked, asks for the time, and publishes only while its question was answered."""

    def __init__(self, board: Board, *, kind: str = "geometry_msgs/Vector3") -> None:
        self.board, self.kind = board, kind
        self.heard = bytearray()
        self.configured = self.synchronised = self.stopped = False
        self.times: list[tuple[int, int]] = []

    def step(self, _: int) -> None:
        self.heard += self.board.receive(0.001)
        if rosserial_frame(0, b"") in self.heard:
            self.configured = True
            self.board.send(topic_info(130, "/chatter", "std_msgs/String") + topic_info(125, "/gravity", self.kind))
            self.board.send(rosserial_frame(10, bytes(8)))
            self.heard.clear()
        self._hear_time()
        self.stopped = self.stopped or rosserial_frame(11, b"") in self.heard
        if self.configured and self.synchronised and not self.stopped:
            self.board.send(samples("rosserial", 2)[1].data)

    def _hear_time(self) -> None:
        head = b"\xff\xfe\x08\x00\xf7\x0a\x00"
        place = self.heard.find(head)
        if place >= 0 and len(self.heard) >= place + 16:
            found = bytes(self.heard[place : place + 16])
            assert found == rosserial_frame(10, found[7:15])
            self.times.append((int.from_bytes(found[7:11], "little"), int.from_bytes(found[11:15], "little")))
            self.synchronised = True
            del self.heard[: place + 16]


def test_rosserial_is_asked_for_topics_answered_the_time_and_stopped(board: Board) -> None:
    device = RosserialDevice(board)
    with Sender(device.step):
        sensor = open_sensor(f"serial:{board.path}?format=rosserial")
        found = read_samples(sensor, 3)
        sensor.close()
        wait_for(lambda: device.stopped)
    assert found[0].specific_force == samples("rosserial", 2)[1].force
    seconds, nanoseconds = device.times[0]
    assert abs(seconds - time.monotonic()) < 60
    assert nanoseconds < 10**9
    assert sensor.statistics.other_frames >= 3


def test_a_rosserial_device_that_was_reset_is_asked_again(board: Board) -> None:
    first, second = RosserialDevice(board), RosserialDevice(board)
    sensor = open_sensor(f"serial:{board.path}?format=rosserial&topic=gravity")
    with Sender(first.step):
        read_samples(sensor, 2)
    while board.receive(0.0):
        pass
    with Sender(second.step):
        wait_for(lambda: sensor.read(0.05) is None)  # what the first had sent is used up
        read_samples(sensor, 2)
    assert second.configured


def test_a_rosserial_device_without_an_acceleration_is_described(board: Board) -> None:
    device = RosserialDevice(board, kind="std_msgs/Int32")
    with Sender(device.step):
        sensor = open_sensor(f"serial:{board.path}?format=rosserial")
        wait_for(lambda: sensor.read(0.02) or "gravity (std_msgs/Int32)" in sensor.remark)
    assert "chatter (std_msgs/String)" in sensor.remark


# Files, pipes, standard input


def test_a_file_of_bytes_ends(tmp_path: Path) -> None:
    path = tmp_path / "recorded.bin"
    path.write_bytes(b"".join(bno08x(number).data for number in range(600)))
    sensor = open_sensor(f"file:{path}?format=bno08x&speed=inf")
    assert len(read_samples(sensor, 600)) == 600
    assert sensor.read(1.0) is None
    assert sensor.finished


def test_a_named_pipe_outlives_its_writers(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    sensor = open_sensor(f"file:{path}?format=line")
    assert sensor.read(0.0) is None
    for number in range(2):
        with path.open("wb") as writer:
            writer.write(line(number).data)
        assert read_samples(sensor, 1)[0].specific_force == line(number).force
    assert not sensor.finished
    sensor.close()
    with pytest.raises(ConfigError, match="comes at its own pace; leave out 'rate', 'speed'"):
        open_sensor(f"file:{path}?format=line&speed=2&rate=50")
    open_sensor(f"file:{path}?format=line", rate=50.0, unit="g").close()


def test_standard_input_is_read_to_its_end() -> None:
    program = (
        "from ravengc.sensors import open_sensor\n"
        "s = open_sensor('stdin:?format=csv')\n"
        "while not s.finished:\n"
        "    x = s.read(1.0)\n"
        "    if x: print(x.specific_force)\n"
    )
    run = subprocess.run([sys.executable, "-c", program], input=b"x\n1,2,3\n4,5,6\n", capture_output=True, check=True)  # noqa: S603
    assert run.stdout.decode().splitlines() == ["(1.0, 2.0, 3.0)", "(4.0, 5.0, 6.0)"]


def test_standard_input_that_is_none_is_a_sensor_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with pytest.raises(SensorError, match="standard input"):
        open_sensor("stdin:")


def test_a_folder_is_no_file_of_bytes() -> None:
    with pytest.raises(SensorError, match="is a folder"):
        open_sensor("file:/")


def test_a_file_that_is_not_there_is_an_error_that_names_the_near_one(tmp_path: Path) -> None:
    (tmp_path / "imu.bin").touch()
    with pytest.raises(ParseError, match=r"no such file; did you mean 'imu\.bin'"):
        open_sensor(f"file:{tmp_path}/imu.bni")


def test_an_unknown_rate_is_refused_before_the_port_is_opened() -> None:
    with pytest.raises(ConfigError, match="250000"):
        open_serial("/dev/ttyRAVENGC", 250000)
