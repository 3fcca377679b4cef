"""Recordings of motion from files: what was written comes back, units are told or guessed, flaws are said."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ravengc.errors import ConfigError, ParseError, RavenGCError
from ravengc.targets import Recording, read_motion

if TYPE_CHECKING:
    from pathlib import Path

COUNT = 200
STAMPS = np.arange(COUNT) / 25.0
SHIFTS = 0.008 * np.column_stack((np.sin(STAMPS), 0.5 * np.cos(1.3 * STAMPS), 0.2 * np.sin(2.0 * STAMPS)))
ROWS = np.column_stack((STAMPS, SHIFTS))


def table(rows: np.ndarray, header: str = "t,x,y,z", mark: str = ",") -> str:
    lines = [mark.join(f"{value:.17g}" for value in row) for row in rows]
    return "\n".join([header.replace(",", mark), *lines]) + "\n"


def read(folder: Path, data: bytes | str, name: str = "motion.csv", **options: Any) -> Recording:
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_motion(path, **options)


def refused(folder: Path, data: bytes | str, name: str = "motion.csv", **options: Any) -> ParseError:
    with pytest.raises(ParseError) as caught:
        read(folder, data, name, **options)
    return caught.value


def archive(folder: Path, **arrays: Any) -> bytes:
    np.savez(folder / "written.npz", **arrays)
    return (folder / "written.npz").read_bytes()


@pytest.mark.parametrize(
    "text",
    [
        table(ROWS),
        table(ROWS, "Time [s],x [m],y [m],z [m]", ";"),
        table(ROWS, mark=";").replace(".", ","),
        table(ROWS[:, [3, 1, 0, 2]], "pos_z,pos_x,timestamp,pos_y", "\t"),
        table(ROWS * (1e3, 1.0, 1.0, 1.0), "t_ms,x,y,z"),
        table(ROWS * (1e9, 1e3, 1e3, 1e3), "stamp_ns,x_mm,y_mm,z_mm"),
        table(ROWS * (1.0, 100.0, 100.0, 100.0), "t,x_cm,y_cm,z_cm"),
        table(ROWS * (1e6, 1e3, 1e3, 1e3)),
        table(np.add(ROWS, (1.7e9, 5.0, -3.0, 2.0))),
        table(ROWS, "# no names", " "),
        table(ROWS, "# t x y z", " "),
        table(np.column_stack((ROWS, np.ones(COUNT))), "t,x,y,z,quality"),
    ],
)
def test_every_way_to_write_a_table_gives_the_same_motion(tmp_path: Path, text: str) -> None:
    motion = read(tmp_path, text)
    np.testing.assert_allclose(motion.stamps, STAMPS, atol=1e-6)
    np.testing.assert_allclose(motion.displacement, SHIFTS - SHIFTS.mean(axis=0), atol=1e-12)
    assert motion.duration_s == pytest.approx(STAMPS[-1])
    assert motion.rate_hz == pytest.approx(25.0)
    assert len(motion) == COUNT
    assert 0.015 < motion.span_m < 0.02


@pytest.mark.parametrize("names", [("t", "displacement"), ("time", "position"), ("stamps", "xyz")])
def test_archives(tmp_path: Path, names: tuple[str, str]) -> None:
    data = archive(tmp_path, **dict(zip(names, (STAMPS, SHIFTS), strict=True)))
    motion = read(tmp_path, data, "motion.npz")
    np.testing.assert_allclose(motion.displacement, SHIFTS - SHIFTS.mean(axis=0), atol=1e-12)
    assert not motion.notes
    with pytest.raises(ConfigError, match="samples per second"):
        read(tmp_path, archive(tmp_path, position=SHIFTS), "motion.npz")
    assert len(read(tmp_path, archive(tmp_path, position=SHIFTS), "motion.npz", rate_hz=25.0)) == COUNT
    for wrong in ({"t": STAMPS, "position": SHIFTS.T}, {"t": STAMPS[1:], "position": SHIFTS}):
        assert "expected (k, 3) and (k,)" in str(refused(tmp_path, archive(tmp_path, **wrong), "a.npz"))
    assert len(read(tmp_path, archive(tmp_path, t=STAMPS, position=1e3 * SHIFTS), "a.npz", units="mm")) == COUNT
    with pytest.raises(ConfigError, match=r"the motion measures 18\.17 m, taken as m; .*say the unit"):
        read(tmp_path, archive(tmp_path, t=STAMPS, position=1e3 * SHIFTS), "a.npz")
    nanoseconds = (1e9 * STAMPS).astype(np.int64)
    assert "check the unit of its times" in str(
        refused(tmp_path, archive(tmp_path, t=nanoseconds, xyz=SHIFTS), "a.npz")
    )
    assert "(arrays: 't')" in str(refused(tmp_path, archive(tmp_path, t=STAMPS), "a.npz"))
    assert "not a readable NumPy archive" in str(refused(tmp_path, data[:200], "a.npz"))
    forged = archive(tmp_path, t=np.array([None] * 9, dtype=object), position=SHIFTS)
    assert "not a readable NumPy archive" in str(refused(tmp_path, forged, "a.npz"))


def test_what_was_guessed_is_said(tmp_path: Path) -> None:
    notes = read(tmp_path, table(ROWS * (1e3, 1e3, 1e3, 1e3))).notes
    assert notes == (
        "times are taken as ms: 25 samples per second",
        "lengths are taken as mm: it moves within 18.2 mm",
    )
    assert read(tmp_path, table(ROWS[:, :2], "t_s,x_m")).notes == ("no column y, z: nothing moves along it",)
    with pytest.raises(ConfigError, match="can be metres or millimetres"):
        read(tmp_path, table(ROWS * (1.0, 30.0, 30.0, 30.0)))
    with pytest.raises(ConfigError, match="the file says mm"):
        read(tmp_path, table(ROWS, "t,x_mm,y_mm,z_mm"), units="m")
    slow = read(tmp_path, table(ROWS * (1.0, 30.0, 30.0, 30.0)), units="mm")
    assert slow.span_m < 1e-3


def test_flaws_are_left_out_and_said_or_refused(tmp_path: Path) -> None:
    rows = ROWS.copy()
    rows[10, 1], rows[11, 0], rows[12, 3] = np.nan, np.inf, 1e12
    rows[20, 0] = rows[19, 0]
    rows = np.vstack((np.delete(rows, slice(100, 140), axis=0), np.zeros((2, 4))))
    motion = read(tmp_path, table(rows, "t_s,x_m,y_m,z_m"))
    assert len(motion) == COUNT - 44
    assert motion.notes == (
        "2 rows of zeros at the end are left out",
        "3 rows with a number that is missing, not finite or beyond 1e9 are left out",
        "1 row repeating the stamp before is left out",
        "the longest gap is 1.64 s, filled by a smooth curve",
    )
    assert "strict reading" in str(refused(tmp_path, table(rows, "t_s,x_m,y_m,z_m"), strict=True))


def test_single_stamps_out_of_order_are_left_out_and_counted(tmp_path: Path) -> None:
    """Recorders of markers now and then write a stamp in another unit, behind or ahead of its neighbours."""
    rows = ROWS.copy()
    rows[50:52, 0] /= 500.0
    rows[120, 0] *= 500.0
    text = table(rows, "t_s,x_m,y_m,z_m")
    motion = read(tmp_path, text)
    np.testing.assert_allclose(motion.stamps, np.delete(STAMPS, (50, 51, 120)), atol=1e-12)
    shifts = np.delete(SHIFTS, (50, 51, 120), axis=0)
    np.testing.assert_allclose(motion.displacement, shifts - shifts.mean(axis=0), atol=1e-12)
    assert motion.notes == ("3 rows out of order in time are left out",)
    error = refused(tmp_path, text, strict=True)
    assert "3 rows out of order in time are left out, and strict reading was asked for" in str(error)
    assert error.line == 52


def test_two_recordings_one_after_the_other_are_not_taken_for_one(tmp_path: Path) -> None:
    error = refused(tmp_path, table(np.vstack((ROWS, ROWS[:20])), "t_s,x_m,y_m,z_m"))
    assert "time runs backwards: 0 after 7.96; sort the rows, or cut there" in str(error)
    assert error.line == COUNT + 2


def test_a_binary_file_is_told_what_is_read(tmp_path: Path) -> None:
    error = refused(tmp_path, b"MATLAB 5.0 MAT-file\x00\x9c", "heart.mat")
    assert "expected a table of numbers (CSV, TXT, TSV) or an archive (.npz)" in str(error)


def test_a_file_that_was_meant_is_of_the_same_kind_or_name(tmp_path: Path) -> None:
    for name in ("sing.txt", "marker.csv", "heart.npz"):
        (tmp_path / name).touch()
    for name, meant in (("missing.csv", ""), ("markers.csv", "marker.csv"), ("heart.csv", "heart.npz")):
        with pytest.raises(ParseError) as caught:
            read_motion(tmp_path / name)
        assert ("did you mean" in str(caught.value)) == bool(meant)
        assert meant in str(caught.value)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (table(ROWS[::-1]), 3, "time runs backwards: 7.92 after 7.96; sort the rows"),
        (
            table(ROWS * (0.0, 1.0, 1.0, 1.0)),
            None,
            "1 usable samples (199 rows repeating the stamp before are left out); e",
        ),
        (table(ROWS[:5]), None, "5 usable samples; expected 10 at least"),
        (table(ROWS * (1e-9, 1.0, 1.0, 1.0)), None, "in no likely unit; name the column t_s, t_ms"),
        (
            table(ROWS * (1e9, 1.0, 1.0, 1.0), "t_s,x,y,z"),
            None,
            "samples are 4e+07 s apart, taken as s; expected 1e-05 to",
        ),
        (table(ROWS, "a,b,c,d"), None, "no column x, y or z (columns: 'a', 'b', 'c', 'd')"),
        (table(ROWS, "t,x,x,z"), None, "two columns for x"),
        (table(ROWS, "t,x [feet],y,z"), None, "'feet'; expected one of"),
        (table(np.ones((20, 6)), "# six"), 2, "6 columns without names"),
        ("t,x,y,z\n0,1,2\n", 2, "3 cells; expected 4"),
        ("", None, "empty"),
    ],
)
def test_what_is_no_motion_is_refused_with_its_line(tmp_path: Path, text: str, line: int | None, words: str) -> None:
    error = refused(tmp_path, text)
    assert words in str(error)
    assert error.line == line


def test_rates(tmp_path: Path) -> None:
    text = table(ROWS[:, 1:], "x_m,y_m,z_m")
    np.testing.assert_allclose(read(tmp_path, text, rate_hz=25.0).stamps, STAMPS)
    with pytest.raises(ConfigError, match="no column of times"):
        read(tmp_path, text)
    with pytest.raises(ConfigError, match="leave the rate out"):
        read(tmp_path, table(ROWS), rate_hz=25.0)
    for rate in (0.0, -1.0, float("nan"), 1e9):
        with pytest.raises(ConfigError, match=r"expected 0\.02 to 100000"):
            read(tmp_path, text, rate_hz=rate)


def test_the_bundled_motions() -> None:
    breathing, heart = read_motion("example:breathing"), read_motion("example:heart")
    assert len(breathing) == 1383
    assert breathing.rate_hz == pytest.approx(10.0, rel=1e-2)
    assert breathing.span_m == pytest.approx(0.0206, abs=1e-4)
    assert len(heart) == 750
    spectrum = np.abs(np.fft.rfft(heart.displacement[:, 0]))
    beat = np.fft.rfftfreq(750, 1.0 / heart.rate_hz)[spectrum.argmax()]
    assert 0.1 < beat < 1.5
    with pytest.raises(ConfigError, match="did you mean 'heart'"):
        read_motion("example:hart")


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_files_are_read_or_refused_in_a_sentence(tmp_path: Path, data: st.DataObject) -> None:
    npz = data.draw(st.booleans())
    whole = bytearray(archive(tmp_path, t=STAMPS, position=SHIFTS) if npz else table(ROWS[:30]).encode())
    for _ in range(data.draw(st.integers(0, 3))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    found = read_or_complaint(tmp_path, bytes(whole), "m.npz" if npz else "m.csv")
    if isinstance(found, str):
        assert 10 < len(found) < 500
    else:
        assert np.isfinite(found.displacement).all()
        assert (np.diff(found.stamps) > 0.0).all()


def read_or_complaint(folder: Path, data: bytes, name: str) -> Recording | str:
    try:
        return read(folder, data, name)
    except RavenGCError as error:
        return str(error)
