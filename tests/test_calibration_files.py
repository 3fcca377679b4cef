"""Recordings of an accelerometer from tables, archives and samples; what cannot be used is left out and counted."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ravengc import calibration
from ravengc.calibration import ReadOptions, from_samples, read_imu
from ravengc.errors import ConfigError, ParseError, RavenGCError
from ravengc.sensors.sample import Sample

G = 9.80665
ROWS = np.array(
    [
        [0.00, 0.1, 0.2, 1.0, 10.0, 20.0, 30.0],
        [0.01, 0.1, 0.3, 0.9, 11.0, 21.0, 31.0],
        [0.02, 0.0, 0.2, 1.1, 0.0, 0.0, 0.0],
    ]
)
HEADER = ",".join(
    ["Time (s)", *(f"Accelerometer {axis} (g)" for axis in "XYZ"), *(f"Gyroscope {axis} (deg/s)" for axis in "XYZ")]
)


def table(path: Path, header: str = HEADER, rows: np.ndarray = ROWS) -> str:
    path.write_text(header + "\n" + "".join(",".join(map(str, row)) + "\n" for row in rows.tolist()))
    return str(path)


def test_units_of_the_header_become_si(tmp_path: Path) -> None:
    recording = read_imu(table(tmp_path / "log.csv"))
    np.testing.assert_allclose(recording.t, [0.0, 0.01, 0.02])
    np.testing.assert_allclose(recording.specific_force, G * ROWS[:, 1:4])
    assert recording.angular_velocity is not None
    np.testing.assert_allclose(recording.angular_velocity, np.radians(ROWS[:, 4:]))
    assert recording.notes == ()


def test_columns_and_units_can_be_named(tmp_path: Path) -> None:
    path = table(tmp_path / "log.csv", "clock,p,q,r,u,v,w")
    wanted = G * ROWS[:, 1:4]
    for columns in (["clock", "p", "q", "r"], ["1", "2", "3", "4"]):
        recording = read_imu(path, ReadOptions(columns=columns, unit="g"))
        np.testing.assert_allclose(recording.specific_force, wanted)
        assert recording.angular_velocity is None
    both = read_imu(path, ReadOptions(columns=["clock", *"pqruvw"], unit="mg", rate_unit="deg/s"))
    assert both.angular_velocity is not None
    np.testing.assert_allclose(both.specific_force, wanted / 1000.0)
    np.testing.assert_allclose(both.angular_velocity, np.radians(ROWS[:, 4:]))
    turned = read_imu(path, ReadOptions(columns=["clock", "p", "q", "r"], unit="g", sends="gravity"))
    np.testing.assert_allclose(turned.specific_force, -wanted)


def test_a_rate_stands_in_for_stamps(tmp_path: Path) -> None:
    path = table(tmp_path / "log.csv", "ax,ay,az", ROWS[:, 1:4])
    np.testing.assert_allclose(read_imu(path, ReadOptions(rate_hz=50.0)).t, [0.0, 0.02, 0.04])
    with pytest.raises(ConfigError, match="times"):
        read_imu(path)


def test_an_archive_is_read_like_a_table(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=ROWS[:, 0], specific_force=ROWS[:, 1:4], angular_velocity=ROWS[:, 4:])
    recording = read_imu(tmp_path / "a.npz", ReadOptions(unit="g", rate_unit="deg/s"))
    from_table = read_imu(table(tmp_path / "log.csv"))
    np.testing.assert_allclose(recording.specific_force, from_table.specific_force)
    np.testing.assert_allclose(recording.angular_velocity, from_table.angular_velocity)
    np.savez(tmp_path / "b.npz", Acc=ROWS[:, 1:4])
    np.testing.assert_allclose(read_imu(tmp_path / "b.npz", ReadOptions(rate_hz=100.0)).t, ROWS[:, 0])


def test_rows_that_cannot_be_used_are_left_out_and_counted(tmp_path: Path) -> None:
    rows = np.vstack(
        [ROWS, [0.02, *ROWS[0, 1:]], [0.03, np.nan, *ROWS[0, 2:]], [0.04, 1e300, *ROWS[0, 2:]], [0.05, *ROWS[0, 1:]]]
    )
    path = table(tmp_path / "log.csv", rows=rows)
    Path(path).write_text(Path(path).read_text() + "0.06,x,y,z,a,b,c\n0.07,1\n")
    recording = read_imu(path)
    assert recording.samples == 4
    assert recording.notes == (
        "left out: 2 x row that is no row of numbers",
        "left out: 2 x missing, non-finite or huge number",
        "left out: 1 x repeated stamp",
    )


def test_a_first_stamp_that_is_missing_costs_one_row(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=[np.nan, 5.0, 5.01], acc=ROWS[:, 1:4])
    np.testing.assert_allclose(read_imu(tmp_path / "a.npz").t, [0.0, 0.01])
    np.savez(tmp_path / "b.npz", t=[np.nan] * 3, acc=ROWS[:, 1:4])
    assert read_imu(tmp_path / "b.npz").samples == 0


def test_time_that_runs_backwards_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParseError, match="time runs backwards at sample 3"):
        read_imu(table(tmp_path / "log.csv", rows=ROWS[[1, 2, 0]]))


ARRAYS: list[tuple[dict[str, Any], str]] = [
    ({"t": ROWS[:, 0]}, "no specific force; .* holds 't'"),
    ({"t": ROWS[:, 0], "acc": ROWS[:, 1:3]}, r"arrays of shape \(3,\), \(3, 2\)"),
    ({"t": ROWS[:2, 0], "acc": ROWS[:, 1:4]}, r"arrays of shape \(2,\), \(3, 3\)"),
    ({"t": ROWS[:, 0], "acc": ROWS[:, 1:4], "gyro": ROWS[:2, 4:]}, r"\(2, 3\)"),
    ({"acc": ROWS[:, 1:4]}, "no stamps t"),
    ({"t": ROWS[:, 0], "acc": np.array(["a", "b", "c"])}, "no specific force"),
    ({"t": ROWS[:, 0], "acc": np.array(5.0)}, "no specific force"),
]


@pytest.mark.parametrize(("arrays", "message"), ARRAYS)
def test_archives_of_another_shape_are_refused(tmp_path: Path, arrays: dict[str, Any], message: str) -> None:
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises((ConfigError, ParseError), match=message):
        read_imu(tmp_path / "a.npz")


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"not an archive", b"\x93NUMPY"])
def test_what_is_no_archive_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.npz").write_bytes(content)
    with pytest.raises(ParseError, match="not a readable NumPy archive"):
        read_imu(tmp_path / "a.npz")


def test_pickled_objects_are_not_loaded(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=ROWS[:, 0], acc=np.array([print] * 3, dtype=object))
    with pytest.raises(ParseError, match="not a readable NumPy archive"):
        read_imu(tmp_path / "a.npz")


@pytest.mark.parametrize(
    "name", ["none.csv", "none.npz", "a\0b.csv", "x" * 5000, "x" * 300 + ".npz", "example:no", ".", ""]
)
def test_what_is_not_there_is_refused(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RavenGCError):
        read_imu(name)


def test_the_name_that_was_meant_is_suggested(tmp_path: Path) -> None:
    table(tmp_path / "positions.csv")
    with pytest.raises(ParseError, match=r"no such file; did you mean 'positions\.csv'\?"):
        read_imu(tmp_path / "position.csv")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"unit": "G"}, "did you mean 'g'"),
        ({"rate_unit": "degs"}, "rate_unit 'degs' is unknown"),
        ({"sends": "force"}, "sends 'force' is unknown"),
        ({"columns": ["a", "b"]}, "2 columns are named; expected 3"),
        ({"rate_hz": 0.0}, "positive"),
        ({"rate_hz": np.nan}, "positive"),
    ],
)
def test_options_that_fit_no_file_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        ReadOptions(**options)


# Samples


def sample(seq: int, ns: int, force: tuple[float, ...] = (0.0, 0.0, G), rate: Any = (0.0, 0.0, 0.1)) -> Sample:
    return Sample(seq, ns, force, rate)


def test_samples_become_a_recording() -> None:
    recording = from_samples(sample(k, 10**18 + k * 10**7) for k in range(5))
    np.testing.assert_allclose(recording.t, np.arange(5) / 100.0, atol=1e-12)
    np.testing.assert_array_equal(recording.specific_force, [[0.0, 0.0, G]] * 5)
    np.testing.assert_array_equal(recording.angular_velocity, [[0.0, 0.0, 0.1]] * 5)


def test_samples_that_are_none_are_left_out() -> None:
    good, nan = sample(0, 0), (np.nan, 0.0, G)
    samples = [good, sample(1, 0), sample(2, 5, nan), sample(3, 6, rate=(0.0, np.inf, 0.0)), sample(4, 7)]
    assert from_samples([good, sample(1, 1, (1e12, 0.0, 0.0)), sample(2, 2, rate=(0.0, -1e300, 0.0))]).samples == 1
    recording = from_samples(samples)
    assert recording.samples == 2
    assert recording.notes == ("3 samples not finite, huge or not in order: left out",)


def test_one_sample_without_angular_velocity_leaves_it_out() -> None:
    assert from_samples([sample(0, 0), sample(1, 1, rate=None)]).angular_velocity is None
    assert from_samples([]).samples == 0


def loaded_by(program: str) -> set[str]:
    """The modules of calibration that a program leaves imported, and those of sensors."""
    program += "; import sys; print(*(n for n in sys.modules if n.startswith(('ravengc.cal', 'ravengc.sensors'))))"
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)  # noqa: S603
    return set(done.stdout.split())


def test_the_package_imports_no_calibration() -> None:
    assert loaded_by("import ravengc") == set()


def test_a_robot_file_is_read_for_its_table_without_the_fits(tmp_path: Path) -> None:
    """As every run does; without a table nothing of the sensors is wanted either."""
    (tmp_path / "none.toml").write_text("[tool]\n")
    (tmp_path / "some.toml").write_text("[accelerometer]\nrange = 20\n")
    program = f"import os; os.chdir({str(tmp_path)!r}); from ravengc.calibration import read_block; read_block"
    needed = {"ravengc.calibration", "ravengc.calibration.block"}
    assert loaded_by(f"{program}('none.toml')") == needed
    assert {name for name in loaded_by(f"{program}('some.toml')") if "calibration" in name} == needed


def test_every_public_name_is_there_when_it_is_asked_for() -> None:
    for name in calibration.__all__:
        assert getattr(calibration, name).__name__ == name
        assert name in dir(calibration)
    with pytest.raises(AttributeError, match="has no attribute 'calibrate_gyroscope'"):
        _ = calibration.calibrate_gyroscope
