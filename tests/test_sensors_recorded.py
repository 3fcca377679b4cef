"""Recordings given again: columns and units, the recorded pace, the shipped example; and simulated sensors."""

from __future__ import annotations

import gzip
import itertools
import math
import time
from typing import TYPE_CHECKING

import numpy as np
import pytest

from ravengc import sim
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.sensors import open_sensor
from ravengc.sensors.recorded import example_path, read_recording
from ravengc.sensors.simulated import SimulatedSensor, from_base

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.sensors import Sample, Sensor

G = 9.80665


def everything(sensor: Sensor) -> list[Sample]:
    found = []
    while (sample := sensor.read(1.0)) is not None:
        found.append(sample)
    return found


# The shipped recording


def test_the_shipped_recording_is_what_its_readme_says() -> None:
    recording = read_recording("example:xio")
    norm = np.linalg.norm(recording.force, axis=1) / G
    assert len(norm) == 13_514
    assert recording.skipped == 0
    assert recording.time_ns[-1] == pytest.approx(135.326642e9)
    assert norm.min() == pytest.approx(0.4286, abs=1e-4)
    assert norm.max() == pytest.approx(1.5470, abs=1e-4)
    assert norm[:100].mean() == pytest.approx(1.0, abs=0.01)
    assert recording.rate is not None
    assert np.rad2deg(recording.rate[0]) == pytest.approx((0.01644619, -0.1517251, 0.1080897))
    assert example_path("xio").with_name("LICENSE").read_text(encoding="utf-8").count("x-io Technologies") == 1


def test_a_replay_without_waiting_gives_all_of_it() -> None:
    sensor = open_sensor("replay:example:xio?speed=inf", unit="m/s^2")
    found = everything(sensor)
    assert sensor.finished
    assert sensor.read(0.0) is None
    recording = read_recording("example:xio")
    assert np.array([sample.specific_force for sample in found]) == pytest.approx(recording.force)
    assert [sample.seq for sample in found] == list(range(13_514))
    stamps = np.array([sample.stamp_ns for sample in found])
    assert (stamps - stamps[0] == recording.time_ns).all()


def written(path: Path, text: str) -> str:
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_replay_keeps_the_recorded_pace(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t,ax,ay,az\n" + "".join(f"{n / 50},{n},0,9.8\n" for n in range(5)))
    start = time.monotonic_ns()
    sensor = open_sensor(f"replay:{file}?speed=2")
    found = [sensor.read(5.0) for _ in range(5)]
    assert [sample.specific_force[0] for sample in found if sample] == [0, 1, 2, 3, 4]
    assert found[-1] is not None
    assert found[-1].stamp_ns >= start + 40_000_000
    assert time.monotonic_ns() >= found[-1].stamp_ns


def test_a_replay_does_not_run_ahead(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t,ax,ay,az\n0,1,2,3\n900,1,2,3\n")
    sensor = open_sensor(f"replay:{file}")
    assert sensor.read(0.0) is not None
    assert sensor.read(0.0) is None
    assert sensor.read(0.01) is None
    assert not sensor.finished


def test_a_replay_can_start_again(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t,ax,ay,az\n5,1,0,0\n5.01,2,0,0\n5.02,3,0,0\n")
    sensor = open_sensor(f"replay:{file}?speed=inf&repeat=yes&axes=x,-y,-z")
    found = [sensor.read(0.0) for _ in range(7)]
    assert [sample.specific_force[0] for sample in found if sample] == [1, 2, 3, 1, 2, 3, 1]
    stamps = [sample.stamp_ns for sample in found if sample]
    assert [later - sooner for sooner, later in itertools.pairwise(stamps)] == [10_000_000] * 6
    assert not sensor.finished


# Columns and units


@pytest.mark.parametrize(
    ("header", "force", "rate"),
    [
        ("t,ax,ay,az", 1.0, None),
        ("Time (s),Accelerometer X (g),Accelerometer Y (g),Accelerometer Z (g)", G, None),
        ("timestamp [s];acc_x [mg];acc_y [mg];acc_z [mg]", G / 1000, None),
        ("t\tf_x\tf_y\tf_z", 1.0, None),
        ('"t","imu/linear_acceleration.x","imu/linear_acceleration.y","imu/linear_acceleration.z"', 1.0, None),
        ("gx [dps],gy [dps],gz [dps],t,ax [m/s2],ay [m/s2],az [m/s2]", 1.0, math.pi / 180),
        ("t,ax,ay,az,gyro x,gyro y,gyro z,temperature", 1.0, 1.0),
    ],
)
def test_columns_and_units_are_found(tmp_path: Path, header: str, force: float, rate: float | None) -> None:
    mark = next((mark for mark in ";\t" if mark in header), ",")
    cells = {"x": "1", "y": "2", "z": "3"}
    row = mark.join(
        cells.get(cell.split("[")[0].split("(")[0].strip().strip('"').lower()[-1:], "7") for cell in header.split(mark)
    )
    recording = read_recording(written(tmp_path / "a.csv", f"# about\n{header}\n{row}\n\n{row}\n"))
    assert recording.force == pytest.approx(force * np.array([[1, 2, 3]] * 2))
    if rate is None:
        assert recording.rate is None
    else:
        assert recording.rate == pytest.approx(rate * np.array([[1, 2, 3]] * 2))


@pytest.mark.parametrize(("unit", "ticks"), [("_s", 1e9), ("_ms", 1e6), (" (us)", 1e3), ("_ns", 1)])
def test_times_may_have_any_unit(tmp_path: Path, unit: str, ticks: float) -> None:
    recording = read_recording(written(tmp_path / "a.csv", f"time{unit},ax,ay,az\n40,0,0,1\n90,0,0,1\n"))
    assert recording.time_ns.tolist() == [0, 50 * ticks]


def test_columns_may_be_named_or_numbered(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "clock,p,q,r (mg),u,v,w\n1,0,0,1000,4,5,6\n2,0,0,1000,4,5,6\n")
    by_name = read_recording(file, time="clock", accelerometer="p,q,r", gyroscope="u, v, w", unit="mg", sends="gravity")
    by_number = read_recording(file, time="1", accelerometer="2,3,4", gyroscope="5,6,7", unit="mg", sends="gravity")
    assert (by_name.force == by_number.force).all()
    assert by_name.force[0].tolist() == [0, 0, pytest.approx(-G)]
    assert by_name.rate is not None
    assert by_name.rate[0].tolist() == [4, 5, 6]


def test_rows_that_cannot_be_read_are_counted_and_holes_are_no_numbers(tmp_path: Path) -> None:
    text = "t,ax,ay,az\n0,1,2,3\n1,x,2,3\n2,1,2\n3,,2,nan\n4,1,2,3,4\n5,1,2,3"
    recording = read_recording(written(tmp_path / "a.csv", text))
    assert recording.skipped == 3
    assert recording.time_ns.tolist() == [0, 3_000_000_000, 5_000_000_000]
    assert np.isnan(recording.force[1]).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("text", "settings", "words"),
    [
        ("", {}, "empty"),
        ("t,ax,ay,az\n", {}, "no row of numbers"),
        ("t,u,v\n1,2,3\n", {}, "no columns force x, y, z"),
        ("t,ax,ay\n1,2,3\n", {}, "no columns force x, y, z"),
        ("ax,ay,az\n1,2,3\n", {}, "give time=COLUMN or rate=HZ"),
        ("t,ax (g),ay (g),az (g)\n1,2,3,4\n", {"unit": "mg"}, "in g by its header, not in mg"),
        ("t,ax (ft),ay (ft),az (ft)\n1,2,3,4\n", {}, "unit of column 2: 'ft' is unknown"),
        ("t,ax,ay,az\n1,2,3,4\n", {"accelerometer": "ax,ay,a"}, "no column 'a'"),
        ("t,ax,ay,az\n1,2,3,4\n", {"accelerometer": "ax,ay"}, "names 2 columns"),
        ("t,ax,ay,az\n1,2,3,4\n", {"time": "9"}, "no column '9'"),
        ("t,ax,ay,az\nnan,2,3,4\n", {}, "a time that is missing"),
        ("t,ax,ay,az\n0,2,3,4\n1e300,2,3,4\n", {}, "a time that is missing"),
    ],
)
def test_what_is_wrong_with_a_recording_is_said(
    tmp_path: Path, text: str, settings: dict[str, str], words: str
) -> None:
    with pytest.raises((ParseError, ConfigError)) as caught:
        read_recording(written(tmp_path / "a.csv", text), **settings)
    assert words in str(caught.value)


@pytest.mark.parametrize("cell", ["a" + " " * 60_000 + "b", "a(" * 30_000, "((" * 30_000 + ")", "a [" * 20_000 + "]"])
def test_a_header_from_hell_is_read_like_any_other(tmp_path: Path, cell: str) -> None:
    """Work in proportion to its length: a pattern that tries every bracket against every other would take minutes."""
    recording = read_recording(written(tmp_path / "a.csv", f"t,ax,ay,az,{cell}\n1,2,3,4,5\n"))
    assert recording.force.tolist() == [[2, 3, 4]]


def test_a_recording_that_is_too_large_is_refused_not_cut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ravengc.sensors.recorded.LARGEST_TEXT", 2**20)
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(b"t,ax,ay,az\n" + b"1,2,3,4\n" * 200_000))
    with pytest.raises(ParseError, match="more than 1 MiB of text"):
        read_recording(str(tmp_path / "a.csv.gz"))


def test_a_tilde_that_the_shell_left_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    with pytest.raises(ParseError, match=f"did you mean '{tmp_path}/imu.csv'"):
        open_sensor("replay:~/imu.csv")
    with pytest.raises(ParseError, match="no such file"):
        open_sensor("replay:~nobody_of_this_name/imu.csv")


def test_files_that_are_none_are_parse_errors(tmp_path: Path) -> None:
    written(tmp_path / "recording.csv", "t\n")
    with pytest.raises(ParseError, match=r"did you mean 'recording\.csv'"):
        read_recording(str(tmp_path / "recordin.csv"))
    with pytest.raises(ParseError, match="not a file"):
        read_recording(str(tmp_path))
    (tmp_path / "cut.csv.gz").write_bytes(gzip.compress(b"t,ax,ay,az\n" * 100)[:-20])
    with pytest.raises(ParseError):
        read_recording(str(tmp_path / "cut.csv.gz"))
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)) * 100)
    with pytest.raises(ParseError):
        read_recording(str(tmp_path / "binary.csv"))


def test_a_rate_stands_in_for_times(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path / "a.csv", "ax,ay,az\n1,2,3\n1,2,3\n"), rate_hz=50.0)
    assert recording.time_ns.tolist() == [0, 20_000_000]


@pytest.mark.parametrize("speed", ["0", "-1", "1e9"])
def test_a_speed_that_is_none_is_refused(speed: str) -> None:
    with pytest.raises(ConfigError, match="speed"):
        open_sensor(f"replay:example:xio?speed={speed}")


# Simulated sensors


def test_a_simulated_sensor_feels_its_base() -> None:
    """Tilted by 20 deg about x, at rest: R^T (0, 0, g), and turned into the sensor's axes."""
    turned = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    sensor = from_base(sim.tilted(20.0), rotation=turned, paced=False)
    sample = sensor.read(0.0)
    assert sample is not None
    y, z = G * math.sin(math.radians(20.0)), G * math.cos(math.radians(20.0))
    assert sample.specific_force == pytest.approx((y, 0.0, z))
    assert sample.angular_velocity == pytest.approx((0.0, 0.0, 0.0))


def test_a_simulated_sensor_away_from_the_pivot_feels_the_lever_arm() -> None:
    base, place = sim.rocking(-10, 20, hz=1.5), (0.3, -0.2, 0.1)
    sensor = from_base(base, position=place, rate_hz=50.0, paced=False)
    for number in range(20):
        sample = sensor.read(0.0)
        force, rate, _ = base.motion_at(number / 50.0, place)
        assert sample is not None
        assert sample.specific_force == pytest.approx(tuple(force))
        assert sample.angular_velocity == pytest.approx(tuple(rate))


def still(_: float) -> tuple[tuple[float, float, float], None]:
    return (0.123, -30.0, G), None


def test_noise_quantisation_and_range() -> None:
    sensor = SimulatedSensor(still, quantisation=0.05, full_scale=19.6, paced=False)
    sample = sensor.read(0.0)
    assert sample is not None
    assert sample.specific_force == pytest.approx((0.1, -19.6, 9.8))
    noisy = SimulatedSensor(still, noise=0.2, seed=3, paced=False)
    found = np.array([sample.specific_force for sample in (noisy.read(0.0) for _ in range(4000)) if sample])
    assert found.std(axis=0) == pytest.approx(0.2, rel=0.05)
    again = SimulatedSensor(still, noise=0.2, seed=3, paced=False).read(0.0)
    assert again is not None
    assert again.specific_force == tuple(found[0])


def test_a_late_sample_has_the_stamp_of_when_it_was_taken() -> None:
    assert SimulatedSensor(still, latency_s=10.0).read(0.0) is None
    sensor = SimulatedSensor(still, rate_hz=100.0, latency_s=0.05)
    opened = time.monotonic_ns()
    sample = sensor.read(5.0)
    assert sample is not None
    assert sample.stamp_ns <= opened
    assert time.monotonic_ns() - sample.stamp_ns >= 50_000_000


@pytest.mark.parametrize(
    "settings", [{"rate_hz": 0}, {"rate_hz": 1e6}, {"noise": -1}, {"latency_s": 60}, {"quantisation": math.nan}]
)
def test_a_simulated_sensor_refuses_what_cannot_be(settings: dict[str, float]) -> None:
    with pytest.raises(ConfigError):
        SimulatedSensor(still, **settings)
    with pytest.raises(ArgumentError):
        SimulatedSensor(3)
    with pytest.raises(ArgumentError):
        from_base(3)


def test_a_simulated_sensor_has_noise_unless_it_is_told_not_to() -> None:
    """Without any it repeats itself, which is a fault: what is computed from an address should not have one."""
    noisy, bare = open_sensor("sim:level"), open_sensor("sim:level?noise=0")
    found = [sensor.read(5.0) for sensor in (noisy, noisy, bare, bare)]
    forces = [sample.specific_force for sample in found if sample]
    assert forces[0] != forces[1]
    assert forces[2] == forces[3]
