"""Logs of runs: written whole or not at all, read back to the bit, and every entry knows its joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from ravengc.atomic import check_writable, replacing
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.log import read_log, write_log
from ravengc.recordings import read_recording

if TYPE_CHECKING:
    from pathlib import Path

COLUMNS = {"time": np.array((0.0, 0.1, 1 / 3)), "q": np.array([[np.pi, 1e-300], [-0.0, np.nan], [1e22, 7.0]])}


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_log_reads_back_to_the_bit(tmp_path: Path, suffix: str) -> None:
    about = {"robot": "rrbot", "units": {"time": "s"}, "text": 'µ, "quoted"\n'}
    path = write_log(tmp_path / "new" / f"run{suffix}", COLUMNS, about)
    log = read_log(path)
    assert log.metadata == about
    assert log.columns.keys() == COLUMNS.keys()
    for name, column in COLUMNS.items():
        np.testing.assert_array_equal(log.columns[name], column)
    assert [file.name for file in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
@pytest.mark.parametrize(
    "joints",
    [("elbow", "wrist"), ("angle 1", "arm/left_deg"), ("é", "q"), ("joint1", "position_"), ("position 2", "q_desired")],
)
def test_a_log_knows_which_entry_is_which_joint(tmp_path: Path, suffix: str, joints: tuple[str, ...]) -> None:
    columns = {"time": np.arange(3.0), "q": np.arange(6.0).reshape(3, 2), "tau_pd": np.ones((3, 2))}
    columns |= {"tau": -np.ones((3, 2)), "gravity": np.zeros((3, 3))}
    path = write_log(tmp_path / f"run{suffix}", columns, {}, joints=joints)
    log = read_log(path)
    assert (log.joints, log.columns.keys()) == (joints, columns.keys())
    for name, column in columns.items():
        np.testing.assert_array_equal(log.columns[name], column)
    recording = read_recording(path)
    assert recording.names == joints
    np.testing.assert_array_equal(recording.q, columns["q"])
    np.testing.assert_array_equal(recording.tau, columns["tau"])


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_logs_without_names_of_joints_are_read(tmp_path: Path, suffix: str) -> None:
    """As they were written before columns were named by joint."""
    path = tmp_path / f"run{suffix}"
    q = np.array([[1.0, 2.0], [3.0, 4.0]])
    if suffix == ".npz":
        np.savez(path, time=np.arange(2.0), q=q, metadata=np.array('{"robot": "rrbot"}'))
    else:
        path.write_text('# {"robot": "rrbot"}\ntime,q_0,q_1\n0.0,1.0,2.0\n1.0,3.0,4.0\n')
    log = read_log(path)
    assert (log.joints, log.metadata) == ((), {"robot": "rrbot"})
    np.testing.assert_array_equal(log.columns["q"], q)
    np.testing.assert_array_equal(read_recording(path).q, q)


def test_columns_of_a_table_are_named_by_joint(tmp_path: Path) -> None:
    columns = {"time": np.zeros(1), "q": np.zeros((1, 3)), "tau_pd": np.zeros((1, 3)), "gravity": np.zeros((1, 3))}
    path = write_log(tmp_path / "run.csv", columns, {}, joints=("a", "b", "c"))
    named = "time,a/q,b/q,c/q,a/tau_pd,b/tau_pd,c/tau_pd,gravity_0,gravity_1,gravity_2"
    assert path.read_text(encoding="utf-8").splitlines()[1] == named


@pytest.mark.parametrize("joints", [("a,b", "c"), ('"a"', "c"), ("a;", "c"), ("#a", "c"), ("2", "1"), ("a",), ()])
def test_columns_are_numbered_where_names_would_not_do(tmp_path: Path, joints: tuple[str, ...]) -> None:
    path = write_log(tmp_path / "run.csv", {"t": np.zeros(1), "q": np.array([[1.0, 2.0]])}, {}, joints=joints)
    assert path.read_text(encoding="utf-8").splitlines()[1] == "t,q_0,q_1"
    np.testing.assert_array_equal(read_log(path).columns["q"], [[1.0, 2.0]])
    recording = read_recording(path)
    assert recording.names == ()
    np.testing.assert_array_equal(recording.q, [[1.0, 2.0]])


@pytest.mark.parametrize(
    ("columns", "metadata", "problem"),
    [
        ({"q": np.zeros(2), "t": np.zeros(3)}, {}, "different numbers of rows: q 2, t 3"),
        ({"metadata": np.zeros(2)}, {}, "column 'metadata': expected a name of letters"),
        ({"a/b": np.zeros(2)}, {}, "column 'a/b': expected a name of letters"),
        ({"q": np.zeros((2, 2, 2))}, {}, r"column 'q' has shape \(2, 2, 2\)"),
        ({"q": ["a"]}, {}, "column 'q' has dtype <U1"),
        ({"q": np.zeros(2)}, {"a": object()}, "metadata is no JSON object"),
        ({"q": np.zeros(2)}, {1: {2: b"x"}}, "metadata is no JSON object"),
    ],
)
def test_what_is_no_log_is_not_written(tmp_path: Path, columns: dict, metadata: dict, problem: str) -> None:
    with pytest.raises(ArgumentError, match=problem):
        write_log(tmp_path / "run.npz", columns, metadata)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "file.npz"
    path.write_text("old")

    def write() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise OSError(28, "disk full")

    with pytest.raises(ConfigError, match="disk full"):
        write()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_is_followed_and_permissions_stay(tmp_path: Path) -> None:
    path, link = tmp_path / "file.npz", tmp_path / "latest.npz"
    path.write_text("old")
    path.chmod(0o640)
    link.symlink_to(path)
    with replacing(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink()
    assert path.read_text() == "new"
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_name_may_be_as_long_as_the_file_system_allows(tmp_path: Path) -> None:
    path = tmp_path / ("n" * 251 + ".npz")
    check_writable(path)
    with replacing(path) as temporary:
        temporary.write_text("new")
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize(
    ("name", "problem"), [("file/x.npz", "not a folder"), ("folder", "Is a directory"), ("/", "a folder")]
)
def test_where_nothing_can_be_written_is_known_before(tmp_path: Path, name: str, problem: str) -> None:
    (tmp_path / "file").write_text("in the way")
    (tmp_path / "folder").mkdir()
    with pytest.raises(ConfigError, match=f"cannot be written: .*{problem}"):
        check_writable(tmp_path / name)
    check_writable(tmp_path / "new" / "run.npz")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]


@pytest.mark.parametrize("name", ["run.txt", "run", "run.npz.gz"])
def test_unknown_log_formats_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError, match=r"\.npz or \.csv"):
        write_log(tmp_path / name, COLUMNS, {})


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
@pytest.mark.parametrize("content", [b"", b"# {}\n", b"not a log", b"# {}\ntime,q_0\n1,2,3\n", b"PK\x03\x04 cut short"])
def test_damaged_logs_are_refused(tmp_path: Path, suffix: str, content: bytes) -> None:
    path = tmp_path / f"run{suffix}"
    path.write_bytes(content)
    with pytest.raises(ParseError, match=path.name):
        read_log(path)


def test_a_missing_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ParseError, match=r"absent\.npz"):
        read_log(tmp_path / "absent.npz")


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ConfigError, match="cannot be written"):
        write_log(tmp_path / "file" / "run.npz", COLUMNS, {})
