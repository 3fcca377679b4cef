"""``ravengc sensor``: what it says of healthy, wrong, recorded and missing sensors."""

from __future__ import annotations

import contextlib
import json
import math
import os
import socket
import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from ravengc.calibration.block import KEYS
from ravengc.cli import main
from ravengc.sensors.decoders import FORMATS
from ravengc.sensors.decoders.lines import xor
from ravengc.sensors.kinds import KINDS as KIND_TABLE
from sensor_hosts import Board, Sender

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


LOOKS = 4


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict]:
    code = main(["sensor", *arguments, "--json"])
    return code, json.loads(capsys.readouterr().out)


def live_in_one(look: Callable[[int], tuple[int, dict]], live_s: float) -> tuple[int, dict]:
    """The first look in which the sensor was live for long; where a machine stalls, every sensor on it falls silent."""
    for number in range(LOOKS):
        code, found = look(number)
        if found["seconds"]["live"] > live_s:
            return code, found
    pytest.fail(f"never live for {live_s} s in {LOOKS} looks: {found}")


def recording(path: Path, forces: np.ndarray, rate_hz: float = 100.0) -> Path:
    lines = ["time_s,ax,ay,az"]
    lines += [f"{k / rate_hz:.4f}," + ",".join(f"{x:.6f}" for x in f) for k, f in enumerate(forces)]
    path.write_text("\n".join(lines) + "\n")
    return path


def level(count: int, size: float = rg.STANDARD_GRAVITY, noise: float = 0.02) -> np.ndarray:
    random = np.random.default_rng(5)
    return size * np.array((0.0, 0.0, 1.0)) + noise * random.standard_normal((count, 3))


def address(path: Path) -> str:
    return f"replay:{path}?time=time_s&acc=ax,ay,az&unit=m/s^2"


def test_the_shipped_recording_runs_through_and_every_alarm_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = said(capsys, "replay:example:xio")
    assert code == 0
    assert found["samples"] == 13514
    assert 4.0 < found["norm_m_s2"]["lowest"] < 4.4
    assert 15.0 < found["norm_m_s2"]["highest"] < 15.3
    assert found["gyroscope"]
    assert found["seconds"]["live"] > 10.0
    assert found["alarms"]
    for alarm in found["alarms"]:
        assert set(alarm["alarms"]) <= set(rg.FAULTS)
        assert all(rg.FAULTS[name] in alarm["explained"] for name in alarm["alarms"])
    in_alarm = sum(alarm["end_s"] - alarm["begin_s"] for alarm in found["alarms"])
    assert in_alarm == pytest.approx(found["seconds"]["held"], abs=0.2)


def test_a_healthy_sensor_is_called_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = said(capsys, address(recording(tmp_path / "a.csv", level(500))))
    assert code == 0
    assert found["verdicts"] == ["nothing wrong was seen"]
    assert found["tilt_deg"] == pytest.approx(0.0, abs=0.3)
    assert not found["alarms"]


def test_another_unit_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = said(capsys, address(recording(tmp_path / "a.csv", level(500, size=0.98, noise=0.002))))
    assert code == 1
    assert "looks like g, not m/s²: set unit = g" in found["verdicts"][0]


def test_another_rate_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, found = said(capsys, address(recording(tmp_path / "a.csv", level(300), rate_hz=50.0)))
    assert any("50 samples per second, declared are 100" in verdict for verdict in found["verdicts"])
    code, found = said(capsys, address(recording(tmp_path / "a.csv", level(300), rate_hz=50.0)), "--rate", "50")
    assert code == 0
    assert found["verdicts"] == ["nothing wrong was seen"]


def test_a_jump_of_the_recorded_clock_is_not_sat_through(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Stamps that jump by thirty years: the chain goes through the seconds that matter, not through the years."""
    path = recording(tmp_path / "a.csv", level(300))
    rows = path.read_text().splitlines()
    path.write_text(
        "\n".join([*rows[:150], *(f"1{int(9e8 + k)}.{row.split('.', 1)[1]}" for k, row in enumerate(rows[150:]))])
    )
    _, found = said(capsys, address(path))
    assert found["samples"] == 300
    assert found["seconds"]["held"] > 9e8
    assert any("age" in alarm["alarms"] for alarm in found["alarms"])


def test_a_recording_that_repeats_is_watched_like_a_live_sensor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It has no end to be read to."""
    path = recording(tmp_path / "a.csv", level(30))
    _, found = said(capsys, f"{address(path)}&repeat=yes", "--seconds", "1")
    assert 40 < found["samples"] <= 110


def test_gravity_reported_upside_down_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, found = said(capsys, address(recording(tmp_path / "a.csv", -level(500))))
    assert "sign" in found["alarms"][0]["alarms"]
    assert any("up is along -z of the sensor: axes=x,-y,-z makes it z" in verdict for verdict in found["verdicts"])
    assert rg.FAULTS["sign"] in found["alarms"][0]["explained"]


def test_a_simulated_sensor_lives_in_real_time(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = live_in_one(lambda _: said(capsys, "sim:tilt:10?noise=0.02", "--seconds", "2"), live_s=0.5)
    assert code == (0 if found["state"] == "live" else 1)
    assert found["tilt_deg"] == pytest.approx(10.0, abs=0.5)


def test_a_missing_sensor_is_an_answer_not_a_crash(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sensor", "serial:/dev/nosuch?format=line", "--seconds", "0.3"]) == 1
    said = capsys.readouterr().out
    assert "no sample came" in said
    assert "/dev/nosuch" in said


def test_tables_and_help_are_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    main(["sensor", "replay:example:xio", "--seconds", "20"])
    table = capsys.readouterr().out
    assert "jitter" in table
    assert table.count("the specific force jumped") > 1  # of the counter and of the alarms
    assert "samples that passed every check" in table
    with pytest.raises(SystemExit):
        main(["sensor", "--help"])
    text = capsys.readouterr().out
    assert all(kind.example in text for kind in KIND_TABLE.values())
    assert all(name in text for name in FORMATS)
    assert 'sensor = "serial:/dev/ttyUSB0?format=line"' in text
    assert all(key in text for key in KEYS)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (["nonsense"], "known: 'sim', 'replay', 'serial'"),
        (["serail:/dev/x"], "did you mean 'serial'"),
        (["replay:nosuch.csv"], "no such file"),
        (["file:nosuch.bin"], "no such file"),
        (["udp:99999999"], "a port from 1 to 65535"),
        (["my_arm.toml"], "did you mean --robot my_arm.toml?"),
        ([], "Give KIND:ADDRESS, or --robot FILE"),
        (["--robot", "panda"], "panda names no sensor"),
        (["sim:level", "--seconds", "nan"], "not a positive number"),
        (["sim:level", "--seconds", "inf"], "not a positive number"),
        (["sim:level", "--seconds", "-1"], "not a positive number"),
        (["sim:level", "--rate", "0"], "not a positive number"),
        (["sim:level", "--rate", "many"], "not a positive number"),
    ],
)
def test_what_cannot_be_meant(wrong: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        code = main(["sensor", *wrong])
    except SystemExit as stopped:
        code = stopped.code
    assert code == 2
    assert words in capsys.readouterr().err


# Every kind that the help lists, fed by a real descriptor


def still_line(number: int) -> bytes:
    """A line of a sensor that lies flat, and is a little noisy."""
    x, y, z = (0.03 * math.sin(number + k) for k in (1, 2, 3))
    body = f"A,{10_000 * number},{x:.5f},{y:.5f},{rg.STANDARD_GRAVITY + z:.5f}".encode()
    return body + b"*%02X\r\n" % xor(body)


@contextlib.contextmanager
def serial_feed(folder: Path, _: pytest.MonkeyPatch) -> Iterator[str]:
    board = Board(folder / "ttyBOARD")
    with Sender(lambda number: board.send(still_line(number)), period_s=0.01):
        yield f"serial:{board.path}?format=line&baud=115200"
    board.unplug()


@contextlib.contextmanager
def udp_feed(_: Path, __: pytest.MonkeyPatch) -> Iterator[str]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
        Sender(lambda number: sender.sendto(still_line(number), ("127.0.0.1", port)), period_s=0.01),
    ):
        yield f"udp:{port}?format=line"


@contextlib.contextmanager
def stdin_feed(_: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    ours, theirs = os.pipe()
    with os.fdopen(ours, "r") as readable, Sender(lambda number: os.write(theirs, still_line(number)), period_s=0.01):
        monkeypatch.setattr(sys, "stdin", readable)
        yield "stdin:?format=line"
    os.close(theirs)


@contextlib.contextmanager
def iio_feed(folder: Path, _: pytest.MonkeyPatch) -> Iterator[str]:
    device = folder / "iio:device0"
    device.mkdir()
    for name, text in {"name": "adxl345", "in_accel_scale": "0.000598", "sampling_frequency": "100"}.items():
        (device / name).write_text(text)

    def measure(number: int) -> None:
        for k, (axis, mean) in enumerate((("x", 0), ("y", 0), ("z", 16399))):
            new = device / f"{axis}.new"
            new.write_text(str(mean + round(30 * math.sin(number + k))))
            new.replace(device / f"in_accel_{axis}_raw")

    measure(0)
    with Sender(measure, period_s=0.007):
        yield f"iio:adxl345?root={folder}"


@contextlib.contextmanager
def file_feed(folder: Path, _: pytest.MonkeyPatch) -> Iterator[str]:
    (folder / "imu.bin").write_bytes(b"".join(still_line(number) for number in range(200)))
    yield f"file:{folder}/imu.bin?format=line"


@contextlib.contextmanager
def pipe_feed(folder: Path, _: pytest.MonkeyPatch) -> Iterator[str]:
    os.mkfifo(folder / "pipe")
    ours = os.open(folder / "pipe", os.O_RDWR)
    with Sender(lambda number: os.write(ours, still_line(number)), period_s=0.01):
        yield f"file:{folder}/pipe?format=line"
    os.close(ours)


@contextlib.contextmanager
def example(kind: str) -> Iterator[str]:
    """The example in the help, as it stands there."""
    yield KIND_TABLE[kind].example


FEEDS = {
    "serial": serial_feed,
    "udp": udp_feed,
    "stdin": stdin_feed,
    "iio": iio_feed,
    "file": file_feed,
    "named pipe": pipe_feed,
    "sim": lambda *_: example("sim"),
    "replay": lambda *_: example("replay"),
}


def test_no_kind_is_left_out() -> None:
    assert set(KIND_TABLE) <= set(FEEDS)


@pytest.mark.parametrize("kind", FEEDS)
def test_every_kind_in_the_help_works(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The declared rate is lower than that of most feeds: then a busy machine may be late by 400 ms."""

    def look(number: int) -> tuple[int, dict]:
        folder = tmp_path / str(number)
        folder.mkdir()
        with FEEDS[kind](folder, monkeypatch) as given:
            return said(capsys, given, "--seconds", "4", "--rate", "10")

    code, found = live_in_one(look, live_s=0.3)
    assert found["samples"] > 30
    assert found["norm_m_s2"]["median"] == pytest.approx(9.8, abs=0.3)
    assert code == (0 if found["state"] == "live" else 1)


# The robot's own table


TABLE = """
[accelerometer]
sensor = "{sensor}"
rate_hz = 50
unit = "g"
rotation = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
policy = "strict"
"""


def robot_with(folder: Path, sensor: str) -> str:
    """A robot's file whose table names a sensor that hangs upside down, sends g, and does so at 50 Hz."""
    path = folder / "arm.toml"
    rg.load("panda").to_toml(path)
    path.write_text(path.read_text() + TABLE.format(sensor=sensor))
    return str(path)


def hanging(path: Path) -> Path:
    return recording(path, -level(300) / rg.STANDARD_GRAVITY, rate_hz=50.0)


def test_the_table_of_a_robot_names_sensor_and_chain(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = robot_with(tmp_path, f"replay:{hanging(tmp_path / 'a.csv')}")
    code, found = said(capsys, "--robot", robot)
    assert code == 0
    assert found["verdicts"] == ["nothing wrong was seen"]
    assert found["seconds"]["no_data"] > 0.0
    assert found["tilt_deg"] == pytest.approx(0.0, abs=0.5)


def test_an_address_comes_before_that_of_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = robot_with(tmp_path, "serial:/dev/nosuch?format=line")
    code, found = said(capsys, f"replay:{hanging(tmp_path / 'a.csv')}", "--robot", robot, "--policy", "paper")
    assert code == 0
    assert found["seconds"]["no_data"] == 0.0
