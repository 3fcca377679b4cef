"""Recordings: what is written is read back, columns are told by their names, and what is wrong is named in place."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mutations import damaged
from ravengc.errors import ArgumentError, ConfigError, ParseError, RavenGCError
from ravengc.log import write_log
from ravengc.recordings import Recording, example_path, read_recording, reading
from ravengc.recordings.columns import layout_of

HEAD = Path(__file__).parent / "data" / "panda_unisa_head.db3"
TABLE = "t,q1,q2,dq1,dq2,tau1,tau2\n0,1,2,3,4,5,6\n0.1,7,8,9,10,11,12\n"


def written(folder: Path, text: str, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    return path


def archive(folder: Path, **arrays: object) -> Path:
    path = folder / "log.npz"
    np.savez(path, **arrays)
    return path


def assert_read_or_refused(path: Path, **options: float) -> None:
    """Reading gives finite numbers or an error of ours that names the file."""
    try:
        recording = read_recording(path, **options)
    except RavenGCError as caught:
        named = str(path) in str(caught)
    else:
        named = bool(np.isfinite(recording.q).all())
    assert named


# --- the recording itself


def test_bundled_recording_is_whole_and_frozen() -> None:
    recording = read_recording("example:panda")
    assert (recording.samples, recording.joints, recording.skipped, recording.notes) == (727, 7, {}, ())
    assert recording.source == "example:panda"
    with pytest.raises(ValueError, match="read-only"):
        recording.q[0, 0] = 1.0
    assert example_path("panda").with_name("LICENSE").read_text().startswith("BSD 3-Clause")
    assert sum(file.stat().st_size for file in example_path("panda").parent.iterdir()) < 200_000


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"t": [0.0, 0.0]}, "does not increase at row 1"),
        ({"t": [0.0]}, r"expected \(1, joints\)"),
        ({"t": []}, "at least one sample"),
        ({"q": [[0.0], [np.nan]]}, "q is not finite in row 1"),
        ({"tau": [[0.0]]}, "tau has shape \\(1, 1\\); expected \\(2, 1\\)"),
        ({"names": ("a", "b")}, "2 names for 1 joints"),
        ({"gravity": [[0.0, 0.0]] * 2}, "expected \\(2, 3\\)"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(changes: dict, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Recording(**{"t": [0.0, 0.1], "q": [[0.0], [1.0]]} | changes)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
@given(seed=st.integers(0, 2**32 - 1), joints=st.integers(1, 4), samples=st.integers(1, 6))
@settings(max_examples=25)
def test_logs_are_read_back_to_the_last_bit(
    tmp_path_factory, suffix: str, seed: int, joints: int, samples: int
) -> None:
    random = np.random.default_rng(seed)
    arrays = {name: random.normal(size=(samples, joints)) for name in ("q", "qd", "tau")}
    columns = {
        "time": np.cumsum(random.uniform(1e-3, 1.0, samples)),
        **arrays,
        "gravity": random.normal(size=(samples, 3)),
    }
    path = tmp_path_factory.mktemp("log") / f"log{suffix}"
    write_log(path, columns, {"robot": "any", "q": [1, 2], "units": {"tau": "N m"}})
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.t, columns["time"])
    for name in (*arrays, "gravity"):
        np.testing.assert_array_equal(getattr(recording, name), columns[name])


@pytest.mark.parametrize("value", ["1e10", "1e308", "-1e200"])
@pytest.mark.parametrize("column", ["q1", "tau2", "dq1"])
def test_numbers_that_no_arm_has_are_left_out_and_counted(tmp_path: Path, column: str, value: str) -> None:
    cells = TABLE.splitlines()[0].split(",")
    row = ",".join(value if cell == column else "0.2" for cell in cells)
    recording = read_recording(written(tmp_path, f"{TABLE}{row}\n"))
    assert recording.samples == 2
    assert recording.skipped == {"number beyond any arm's (above 1e9)": 1}


def test_stamps_too_close_to_divide_by_are_the_same(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path, "t,q1\n0,1\n1e-320,1\n1e-13,2\n0.1,3\n"))
    assert recording.t.tolist() == [0.0, 0.1]
    assert recording.skipped == {"repeated time stamp": 2}


@pytest.mark.parametrize("cell", ["1_0", "١", "0x10", "1e", "--1"])
def test_what_only_python_reads_is_no_number(tmp_path: Path, cell: str) -> None:
    with pytest.raises(ParseError, match=r"log\.csv:2:2: .* is not a number"):
        read_recording(written(tmp_path, f"t,q1\n0,{cell}\n"))


@pytest.mark.parametrize("names", [["a"], ["a", "a"], ["a", "b", "c"]])
def test_names_that_do_not_fit_are_refused(tmp_path: Path, names: list[str]) -> None:
    path = archive(tmp_path, t=np.arange(3.0), q=np.zeros((3, 2)), names=np.array(names))
    with pytest.raises(ParseError, match="expected 2 different names, one per joint"):
        read_recording(path)


def test_a_single_number_is_no_recording(tmp_path: Path) -> None:
    with pytest.raises(ParseError, match="array 'q' is a single number"):
        read_recording(archive(tmp_path, t=np.arange(3.0), q=np.array(1.0)))


# --- columns


@pytest.mark.parametrize(
    "header",
    [
        "t,q1,q2,dq1,dq2,tau1,tau2",
        "time,q_1,q_2,qd_1,qd_2,effort_1,effort_2",
        '"time","q[0]","q[1]","qd[0]","qd[1]","tau[0]","tau[1]"',
        "stamp,pos0,pos1,vel0,vel1,torque0,torque1",
        "# t,q1,q2,qdot1,qdot2,tau1,tau2",
        "Time [s],Q1 [rad],Q2 [rad],QD1 [rad/s],QD2 [rad/s],TAU1 [Nm],TAU2 (N m)",
        "t,elbow_position,wrist_position,elbow_velocity,wrist_velocity,elbow_effort,wrist_effort",
        "t,position.elbow,position.wrist,velocity.elbow,velocity.wrist,effort.elbow,effort.wrist",
        "__time,/js/elbow/position,/js/wrist/position,/js/elbow/velocity,/js/wrist/velocity,/js/elbow/effort,/js/wrist/effort",
        "t_s,q1_rad,q2_rad,dq1,dq2,tau1,tau2",
    ],
)
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_columns_are_told_by_their_names(tmp_path: Path, header: str, delimiter: str) -> None:
    text = TABLE.replace("t,q1,q2,dq1,dq2,tau1,tau2", header).replace(",", delimiter)
    recording = read_recording(written(tmp_path, text))
    np.testing.assert_array_equal(recording.t, [0.0, 0.1])
    np.testing.assert_array_equal(recording.q, [[1, 2], [7, 8]])
    np.testing.assert_array_equal(recording.qd, [[3, 4], [9, 10]])
    np.testing.assert_array_equal(recording.tau, [[5, 6], [11, 12]])


def test_numbered_columns_are_put_in_order_and_win(tmp_path: Path) -> None:
    recording = read_recording(
        written(tmp_path, "q2,q_desired_1,t,q10,q1,q3,q4,q5,q6,q7,q8,q9\n2,0,0,10,1,3,4,5,6,7,8,9\n")
    )
    np.testing.assert_array_equal(recording.q, [np.arange(1, 11)])
    assert recording.names == ()
    assert recording.notes == ("columns not used: q_desired_1",)


def test_units_in_the_header_become_si(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path, "t [ms],q1 [deg],q2_mm,tau1,tau2\n0,180,250,1,2\n500,-90,0,3,4\n"))
    np.testing.assert_allclose(recording.t, [0.0, 0.5], rtol=1e-15)
    np.testing.assert_allclose(recording.q, [[np.pi, 0.25], [-np.pi / 2, 0.0]], rtol=1e-15)


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_comma_is_understood_where_commas_do_not_separate(tmp_path: Path, delimiter: str) -> None:
    text = "t|q1|tau1\n0|1|-2,5\n0,5|1,25|3\n".replace("|", delimiter)
    recording = read_recording(written(tmp_path, text))
    np.testing.assert_array_equal(recording.t, [0.0, 0.5])
    np.testing.assert_array_equal(recording.q, [[1.0], [1.25]])
    np.testing.assert_array_equal(recording.tau, [[-2.5], [3.0]])


def test_one_joint_needs_no_number() -> None:
    layout = layout_of(["t", "q", "tau"], file="x")
    assert [column.place for column in layout.used] == [0, 1, 2]


def test_gravity_columns_are_read(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path, "t,q1,gz,gx,gy\n0,1,-9.8,0.5,0.25\n"))
    np.testing.assert_array_equal(recording.gravity, [[0.5, 0.25, -9.8]])


GRAVITY, RATE = [[0.5, 0.25, -9.8]], [[0.1, 0.2, 0.3]]


@pytest.mark.parametrize(
    ("header", "numbers", "gravity", "rate"),
    [
        ("ax,ay,az", "-0.5,-0.25,9.8", GRAVITY, None),
        ("gx,gy,gz,ax,ay,az", "0.1,0.2,0.3,-0.5,-0.25,9.8", GRAVITY, RATE),
        ("ax,ay,az,gravity_x,gravity_y,gravity_z", "1,2,3,0.5,0.25,-9.8", GRAVITY, None),
        ("gx,gy,gz,wz,wx,wy", "0.5,0.25,-9.8,0.3,0.1,0.2", GRAVITY, RATE),
        ("gravity[0],gravity[1],gravity[2],omega_0,omega_1,omega_2", "0.5,0.25,-9.8,0.1,0.2,0.3", GRAVITY, RATE),
        ("linear_acceleration.x,linear_acceleration.y,linear_acceleration.z", "-0.5,-0.25,9.8", GRAVITY, None),
        ("angular_velocity.x,angular_velocity.y,angular_velocity.z", "0.1,0.2,0.3", None, RATE),
        ("gyro_x [mrad/s],gyro_y [mrad/s],gyro_z [mrad/s]", "100,200,300", None, RATE),
        ("gx (deg/s),gy (dps),gz (°/s)", "90,180,-180", None, [[np.pi / 2, np.pi, -np.pi]]),
        ("ax [mg],ay [mg],az [mg]", "0,0,1000", [[0.0, 0.0, -9.80665]], None),
        ("acc_x,acc_y,acc_z,gx,gy,gz", "-0.5,-0.25,9.8,0.1,0.2,0.3", GRAVITY, RATE),
        ("wx,q_ref", "1,2", None, None),
    ],
)
def test_columns_of_the_base_are_its_gravity_and_its_angular_velocity(
    header: str, numbers: str, gravity: list[list[float]] | None, rate: list[list[float]] | None, tmp_path: Path
) -> None:
    recording = read_recording(written(tmp_path, f"t,q1,{header}\n0,1,{numbers}\n"))
    for found, expected in ((recording.gravity, gravity), (recording.angular_velocity, rate)):
        assert (found is None) == (expected is None)
        if found is not None and expected is not None:
            np.testing.assert_allclose(found, expected, rtol=1e-15, atol=1e-15)
    named = recording.base_arrays()
    assert set(named) == {n for n, e in (("gravity", gravity), ("angular_velocity", rate)) if e is not None}


def test_joints_may_be_called_as_axes_are(tmp_path: Path) -> None:
    text = "t,x_pos,y_pos,z_pos,acc_x,acc_y,acc_z\n0,1,2,3,4,5,6\n"
    recording = read_recording(written(tmp_path, text))
    np.testing.assert_array_equal(recording.qdd, [[4.0, 5.0, 6.0]])
    assert recording.gravity is None
    recording = read_recording(written(tmp_path, text.replace("x_pos,y_pos,z_pos", "a_pos,b_pos,c_pos")))
    np.testing.assert_array_equal(recording.gravity, [[-4.0, -5.0, -6.0]])


def test_the_base_in_an_archive(tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    np.savez(path, t=[0.0, 1.0], q=[[1.0], [2.0]], gravity=[GRAVITY[0]] * 2, angular_velocity=[RATE[0]] * 2)
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.angular_velocity, RATE * 2)
    force, plain = [[-x for x in GRAVITY[0]]] * 2, {"t": [0.0, 1.0], "q": [[1.0], [2.0]]}
    for names in ({"specific_force": force, "gyro": RATE * 2}, {"accelerometer": force, "w": RATE * 2}):
        np.savez(path, **plain, **names)
        found = read_recording(path)
        np.testing.assert_array_equal(found.gravity, GRAVITY * 2)
        np.testing.assert_array_equal(found.angular_velocity, RATE * 2)
        assert found.notes == ()
    np.savez(path, **plain, **{f"a{axis}": np.array(force)[:, k] for k, axis in enumerate("xyz")}, wx=[0.0, 0.0])
    found = read_recording(path)
    np.testing.assert_array_equal(found.gravity, GRAVITY * 2)
    assert found.notes == ("arrays not used: wx",)
    np.savez(path, **plain, ax=[0.0, 1.0], ay=[0.0, 1.0], az=[9.8])
    with pytest.raises(ParseError, match="arrays 'ax', 'ay', 'az' differ in length"):
        read_recording(path)
    np.savez(path, **plain, ax=[0.0, 1.0], ay=[0.0, 1.0])
    with pytest.raises(ParseError, match="ax, ay without the third axis"):
        read_recording(path)
    np.savez(path, t=[0.0, 1.0], q=[[1.0], [2.0]], angular_velocity=[[0.1, 0.2]] * 2)
    with pytest.raises(ParseError, match=r"angular_velocity has shape \(2, 2\), expected \(2, 3\)"):
        read_recording(path)


# --- what is wrong is named, with its place


@pytest.mark.parametrize(
    ("text", "message", "line", "column"),
    [
        ("", "empty", None, None),
        ("\n\n", "no header", None, None),
        ("0,1,2\n", "the first line holds numbers", 1, 1),
        ("t,a,b\n0,1,2\n", "no position columns among 't, a, b'", 1, None),
        ("t,q1,ax,ay\n0,1,2,3\n", "ax, ay without the third axis", 1, 3),
        ("t,q1,wz,wx\n0,1,2,3\n", "wz, wx without the third axis", 1, 3),
        ("t,q1,ax,ay,az [ft/s2]\n0,1,2,3,4\n", r"unknown unit 'ft/s2' in column 'az", 1, 5),
        ("t,q1,q3\n0,1,2\n", r"numbered \[1, 3\]", 1, None),
        ("t,q2,q3\n0,1,2\n", r"numbered \[2, 3\]", 1, None),
        ("t,q1,q2,tau1\n0,1,2,3\n", "tau has no column for joint 2", 1, None),
        ("t,q1,tau1,tau2\n0,1,2,3\n", "tau has columns for 2, but q has none", 1, None),
        ("t,q1,position_1\n0,1,2\n", "two columns for the same quantity: 'q1' and 'position_1'", 1, 3),
        ("t,q1 [furlong]\n0,1\n", "unknown unit 'furlong'", 1, 2),
        ("t,q1\n", "no samples", None, None),
        ("t,q1\n0,1\n0.1\n0.2,3\n", "1 cells, expected 2", 3, 2),
        ("t,q1\n0,1\n0.1,2,3\n", "3 cells, expected 2 as in the header; if the numbers have a decimal comma", 3, 3),
        ("t,q1\n0,1\n\n0.1,1.x\n", "'1.x' is not a number", 4, 2),
        ("t;q1\n0;1\n0,1;2\n0.2;3\n", "decimal comma here, decimal point in line 4", 3, None),
        ("t;q1\n0;1.000,5\n", "'1.000,5' is not a number", 2, 2),
        ("t,q1\n0,1\n0.2,2\n0.1,3\n", "time runs backwards at line 4: 0.1 s after 0.2 s", 4, None),
        ("t,q1\nnan,1\n0.1,inf\n", r"no usable sample in 2 rows \(2 x missing or non-finite number\)", None, None),
        ("t,q1,q2\n0,1,nan\n0.1,1,\n", "q of joint 2 holds no finite number in 2 rows", None, None),
        ("t,q1\n0,1\n0.1,caf\udce9\n", "not UTF-8 text", 1, None),
    ],
)
def test_a_wrong_table_is_an_error_with_its_place(
    tmp_path: Path, text: str, message: str, line: int | None, column: int | None
) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ParseError, match=message) as error:
        read_recording(path)
    assert (error.value.file, error.value.line, error.value.column) == (str(path), line, column)


def test_rows_left_out_are_counted_never_silent(tmp_path: Path) -> None:
    text = "t,q1,tau1\n0,1,5\n0.1,,5\n0.2,nan,5\n0.2,2,6\n0.2,3,7\n# remark\n0.3,4,-1e999\n0.4,5,8\n0.5,6,1"
    path = written(tmp_path, text)
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.t, [0.0, 0.2, 0.4])
    np.testing.assert_array_equal(recording.q[:, 0], [1.0, 2.0, 5.0])
    assert recording.skipped == {
        "missing or non-finite number": 3, "repeated time stamp": 1, "last line without a line end": 1,
    }  # fmt: skip
    with pytest.raises(ParseError, match="3 x missing or non-finite number"):
        read_recording(path, strict=True)


def test_a_quantity_without_any_number_counts_as_not_recorded(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path, "t,q1,tau1\n0,1,nan\n0.1,2,\n"))
    assert (recording.samples, recording.tau) == (2, None)
    assert "tau holds no number" in recording.notes[0]


def test_missing_time_needs_a_rate(tmp_path: Path) -> None:
    for path in (written(tmp_path, "q1\n1\n2\n"), archive(tmp_path, q=np.ones((2, 1)))):
        with pytest.raises(ConfigError, match=r"--rate HZ"):
            read_recording(path)
        np.testing.assert_array_equal(read_recording(path, rate_hz=200.0).t, [0.0, 0.005])
        with pytest.raises(ConfigError, match="sample rate is -1"):
            read_recording(path, rate_hz=-1.0)


@pytest.mark.parametrize(("name", "where"), [("csv", "column 2"), ("npz", "array 'time'"), ("db3", "in the messages")])
def test_a_rate_beside_time_stamps_is_refused(tmp_path: Path, name: str, where: str) -> None:
    path = {
        "csv": written(tmp_path, "q1,t\n1,0\n2,0.1\n"),
        "npz": archive(tmp_path, q=np.ones((2, 1)), time=np.arange(2.0)),
        "db3": HEAD,
    }[name]
    with pytest.raises(ConfigError) as caught:
        read_recording(path, rate_hz=200.0)
    for words in (str(path), f"has time stamps ({where})", "200 Hz", "leave out --rate"):
        assert words in str(caught.value)
    assert read_recording(path).samples > 1


def test_a_gravity_without_any_number_counts_as_not_recorded(tmp_path: Path) -> None:
    recording = read_recording(written(tmp_path, "t,q1,gx,gy,gz\n0,1,,,\n0.1,2,,,\n"))
    assert (recording.samples, recording.gravity) == (2, None)
    with pytest.raises(ParseError, match="gravity along z holds no finite number in 2 rows"):
        read_recording(written(tmp_path, "t,q1,gx,gy,gz\n0,1,0,0,\n0.1,2,0,0,\n"))


def test_paths_that_lead_nowhere(tmp_path: Path) -> None:
    written(tmp_path, TABLE)
    with pytest.raises(ParseError, match=r"no such file; did you mean 'log\.csv'"):
        read_recording(tmp_path / "lgo.csv")
    with pytest.raises(ConfigError, match="did you mean 'panda'"):
        read_recording("example:pandda")
    with pytest.raises(ConfigError, match=r"unknown kind of recording '\.pdf'"):
        read_recording(written(tmp_path, TABLE, "log.pdf"))
    with pytest.raises(ParseError, match="cannot be read"):
        read_recording("x" * 5000 + ".csv")


def test_oversized_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table, zeros = written(tmp_path, TABLE), archive(tmp_path, t=np.arange(9999.0), q=np.zeros((9999, 2)))
    packed = tmp_path / "packed.npz"
    np.savez_compressed(packed, t=np.arange(99.0), q=np.zeros((99, 1000)))
    monkeypatch.setattr(reading, "LARGEST_BYTES", 50_000)
    assert read_recording(table).samples == 2
    with pytest.raises(ParseError, match="at most"):
        read_recording(zeros)
    assert packed.stat().st_size < 50_000
    with pytest.raises(ParseError, match="unpacks to"):
        read_recording(packed)


@given(text=damaged(TABLE + "0.2,1,2,3,4,5,6\n0.3,1.5,2.5,3,4,5e-1,6\n"), suffix=st.sampled_from([".csv", ".tsv"]))
def test_a_damaged_table_gives_a_recording_or_an_error_of_ours(tmp_path_factory, text: str, suffix: str) -> None:
    path = written(tmp_path_factory.mktemp("damaged"), text, f"log{suffix}")
    assert_read_or_refused(path)
    assert_read_or_refused(path, rate_hz=10.0)


# --- NumPy archives


@pytest.mark.parametrize(
    ("arrays", "error", "message"),
    [
        (
            {"t": np.arange(3.0), "tau": np.ones((3, 2))},
            ConfigError,
            "no joint positions; the archive holds 't', 'tau'",
        ),
        (
            {"t": np.arange(3.0), "q": np.ones((2, 3))},
            ParseError,
            r"q has shape \(2, 3\), expected \(3, joints\).*transposed",
        ),
        (
            {"t": np.arange(3.0), "q": np.ones((3, 2)), "tau": np.ones((3, 3))},
            ParseError,
            r"tau has shape \(3, 3\), expected \(3, 2\)",
        ),
        (
            {"t": np.arange(3.0), "time": np.arange(3.0), "q": np.ones((3, 2))},
            ParseError,
            "several arrays for t: t, time",
        ),
        ({"t": np.arange(3.0), "q": np.array([["a"]] * 3)}, ParseError, "array 'q' has type <U1"),
        ({"t": np.arange(3.0), "q": np.array([[None]] * 3)}, ParseError, "not a readable NumPy archive"),
        ({"t": np.ones((3, 1)), "q": np.ones((3, 1))}, ParseError, r"t has shape \(3, 1\)"),
        ({"t": np.arange(3.0)[::-1], "q": np.ones((3, 1))}, ParseError, "time runs backwards at row 2"),
        ({"t": np.arange(2.0), "q": np.ones((2, 1)), "names": np.array([1])}, ParseError, "expected a list of text"),
        ({"t": np.arange(2.0), "q": np.ones((2, 1)), "gravity": np.ones(3)}, ParseError, r"gravity has shape \(3,\)"),
        ({"t": np.arange(0.0), "q": np.ones((0, 1))}, ParseError, "no samples"),
    ],
)
def test_a_wrong_archive_is_an_error(tmp_path: Path, arrays: dict, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        read_recording(archive(tmp_path, **arrays))


def test_archives_may_name_their_joints(tmp_path: Path) -> None:
    recording = read_recording(archive(tmp_path, time=[0.0, 1.0], q=np.ones((2, 2)), names=["a", "b"], extra=[1]))
    assert recording.names == ("a", "b")
    assert recording.notes == ("arrays not used: extra",)


@given(cut=st.integers(0, 2000), flip=st.integers(0, 255))
def test_a_damaged_archive_gives_a_recording_or_an_error_of_ours(tmp_path_factory, cut: int, flip: int) -> None:
    path = archive(tmp_path_factory.mktemp("damaged"), t=np.arange(20.0), q=np.ones((20, 3)), tau=np.ones((20, 3)))
    content = bytearray(path.read_bytes())
    place = cut % len(content)
    content[place] = flip
    path.write_bytes(content if flip % 2 else content[:place])
    assert_read_or_refused(path)


def test_an_archive_that_claims_a_huge_array_is_refused(tmp_path: Path) -> None:
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999, 7), }".ljust(117) + b"\n"
    path = tmp_path / "huge.npz"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("q.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(ParseError, match="not a readable NumPy archive"):
        read_recording(path)
