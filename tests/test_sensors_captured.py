"""Bytes kept in a file come again at the pace of the sensor that sent them, not as fast as a disk gives them."""

from __future__ import annotations

import itertools
import time
from typing import TYPE_CHECKING

import pytest

from ravengc.errors import ConfigError, SensorError
from ravengc.sensors import open_sensor, parse_address
from ravengc.sensors.captured import read_capture
from ravengc.sensors.decoders import make_decoder
from sensor_frames import bno08x, line, samples, witmotion

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.sensors import Sample, Sensor

MS = 1_000_000


def everything(sensor: Sensor) -> list[Sample]:
    found = []
    while (sample := sensor.read(0.0)) is not None:
        found.append(sample)
    return found


def kept(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("form", ["line", "csv", "rosserial", "bno08x", "vectornav", "witmotion", "mavlink"])
def test_every_format_may_be_kept_in_a_file(form: str, tmp_path: Path) -> None:
    encoded = samples(form, 40)
    path = kept(tmp_path / "imu.bin", b"".join(sample.data for sample in encoded))
    found = everything(open_sensor(f"file:{path}?format={form}&speed=inf"))
    forces = [sample.force for sample in encoded]
    assert len(found) >= 38
    assert all(sample.specific_force in [pytest.approx(force) for force in forces] for sample in found[:3])
    steps = {later.stamp_ns - sooner.stamp_ns for sooner, later in itertools.pairwise(found)}
    assert steps == {10 * MS}, "by the sensor's clock or at 100 Hz"


def test_times_are_the_sensors_own_or_a_period_apart(tmp_path: Path) -> None:
    gap = [line(number) for number in (0, 1, 2, 50, 51)]
    clocked = read_capture(str(kept(tmp_path / "a", b"".join(one.data for one in gap))), make_decoder("line"))
    assert clocked.recording.time_ns.tolist() == [0, 10 * MS, 20 * MS, 500 * MS, 510 * MS]
    lost = [bno08x(number) for number in (0, 1, 4, 5)]
    path = str(kept(tmp_path / "b", b"".join(one.data for one in lost)))
    assert read_capture(path, make_decoder("bno08x"), 50.0).recording.time_ns.tolist() == [
        0,
        20 * MS,
        80 * MS,
        100 * MS,
    ]


def test_a_declared_rate_is_that_of_a_file_which_does_not_say_another(tmp_path: Path) -> None:
    path = kept(tmp_path / "a", b"".join(bno08x(number).data for number in range(3)))
    for query, step in (("", 20 * MS), ("&rate=200", 5 * MS)):
        first, second, _ = everything(open_sensor(f"file:{path}?format=bno08x{query}", speed=float("inf"), rate=50.0))
        assert second.stamp_ns - first.stamp_ns == step


def test_a_board_that_restarted_goes_on_a_period_later(tmp_path: Path) -> None:
    lines = [line(number).data for number in (0, 1, 2, 0, 1)]
    capture = read_capture(str(kept(tmp_path / "a", b"".join(lines))), make_decoder("line"))
    assert capture.recording.time_ns.tolist() == [0, 10 * MS, 20 * MS, 30 * MS, 40 * MS]


def test_an_angular_velocity_that_is_missing_stays_so(tmp_path: Path) -> None:
    """The first acceleration of a WitMotion comes before it is known that a gyroscope follows."""
    path = kept(tmp_path / "imu.bin", b"".join(witmotion(number).data for number in range(5)))
    rates = [sample.angular_velocity for sample in everything(open_sensor(f"file:{path}?format=witmotion&speed=inf"))]
    assert rates[0] is None
    assert all(rate is not None for rate in rates[1:])


def test_a_file_keeps_the_pace_and_may_repeat(tmp_path: Path) -> None:
    path = kept(tmp_path / "imu.bin", b"".join(bno08x(number).data for number in range(3)))
    start = time.monotonic_ns()
    sensor = open_sensor(f"file:{path}?format=bno08x&speed=2&repeat=yes")
    found = [sensor.read(5.0) for _ in range(7)]
    assert [sample.specific_force for sample in found[3:6] if sample] == [
        pytest.approx(bno08x(n).force) for n in range(3)
    ]
    assert [sample.seq for sample in found if sample] == list(range(7))
    assert time.monotonic_ns() - start >= 30 * MS
    assert not sensor.finished


def test_axes_and_counts_are_those_of_the_stream(tmp_path: Path) -> None:
    path = kept(tmp_path / "imu.bin", line(1).data + b"A,1,2,3,4*00\n" + line(2).data)
    sensor = open_sensor(f"file:{path}?format=line&speed=inf&axes=x,-y,-z")
    (x, y, z) = line(1).force
    assert everything(sensor)[0].specific_force == (x, -y, -z)
    assert sensor.statistics.bad_checksum == 1
    assert sensor.statistics.samples == 2
    assert sensor.statistics.bytes_received == path.stat().st_size
    assert sensor.name == f"file:{path}"


def test_an_opening_does_not_see_what_another_counted(tmp_path: Path) -> None:
    path = kept(tmp_path / "imu.bin", line(1).data * 3)
    again = parse_address(f"file:{path}?speed=inf").prepare()
    first, second = again(), again()
    everything(first)
    assert (first.statistics.samples, second.statistics.samples) == (3, 0)


@pytest.mark.parametrize("repeat", ["yes", "no"])
def test_a_file_without_a_frame_is_at_its_end(tmp_path: Path, repeat: str) -> None:
    path = kept(tmp_path / "imu.bin", bytes(1000))
    sensor = open_sensor(f"file:{path}?format=bno08x&repeat={repeat}")
    assert sensor.finished
    assert sensor.read(5.0) is None
    assert sensor.statistics.bytes_received == 1000


def test_a_file_that_is_too_large_or_a_rate_that_is_none_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ravengc.sensors.captured.LARGEST", 2**16)
    path = kept(tmp_path / "imu.bin", bytes(2**18))
    with pytest.raises(SensorError, match="cut it into parts"):
        open_sensor(f"file:{path}?format=bno08x")
    for rate in (0.0, -1.0, 1e9, float("nan")):
        with pytest.raises(ConfigError, match="rate"):
            read_capture(str(path), make_decoder("bno08x"), rate)


def test_clocks_that_jump_for_ever_do_not_overflow(tmp_path: Path) -> None:
    """Ahead by almost an hour, back, and so on: the times stay whole numbers of 64 bits, in order."""
    lines = b"".join(f"{3500 * (number % 2)}.0,0,0,{9.8 + number % 7}\n".encode() for number in range(4000))
    path = str(kept(tmp_path / "imu.csv", b"x\n" + lines))
    monotonic = read_capture(path, make_decoder("csv", columns="t_s,ax,ay,az")).recording.time_ns
    assert (monotonic[1:] >= monotonic[:-1]).all()
