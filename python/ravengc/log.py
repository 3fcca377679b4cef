"""The log of a run as a file: ``.npz`` (exact, fast) or ``.csv`` (for people), with what it is about.

Columns are arrays with one row per cycle, (cycles,) or (cycles, k). The metadata is a JSON object: in ``.npz`` the
text array ``metadata``, in ``.csv`` the first line after ``# ``; its ``units`` say the unit of every column, one for
each joint where they differ. The joints' names are the text array ``joint_names``, or part of the names in ``.csv``:
a column ``q`` of shoulder and elbow becomes ``shoulder/q, elbow/q``. Other columns of several numbers are numbered from
0, as are those of joints whose names a comma or quote would tear apart: ``gravity_0, gravity_1, gravity_2``.
:func:`ravengc.recordings.read_recording` reads both forms too.
"""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_array, as_path, as_texts, check_type
from ravengc.atomic import replacing
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.messages import listed, shown

if TYPE_CHECKING:
    import os
    from collections.abc import Sequence
    from pathlib import Path

__all__ = ["FORMATS", "Log", "check_log_path", "read_log", "write_log"]

Column = npt.NDArray[np.generic]

FORMATS = (".npz", ".csv")
KEPT = ("metadata", "joint_names")
"""Names in an archive that are no columns."""
NAME = re.compile(r"\w+")
JOINT = re.compile(r"(?!\d+$)[^\s,;\"#][^\t,;\"]*")
"""Names of joints that a line of names can hold, and that no number in it could be taken for."""


@dataclass(frozen=True, slots=True)
class Log:
    """Columns by name, what they are about, and the names of the joints, in the order of the columns' entries."""

    columns: dict[str, Column]
    metadata: dict[str, Any]
    joints: tuple[str, ...] = ()


def check_log_path(path: str | os.PathLike[str]) -> Path:
    """Return ``path`` if a log can have that name; ConfigError for an unknown suffix."""
    checked = as_path(path, "path")
    if checked.suffix.lower() not in FORMATS:
        raise ConfigError(f"log file '{path}': the suffix must be {' or '.join(FORMATS)}")
    return checked


def write_log(
    path: str | os.PathLike[str],
    columns: Mapping[str, npt.ArrayLike],
    metadata: Mapping[str, Any],
    *,
    joints: Sequence[str] = (),
) -> Path:
    """Write a log, whole or not at all, making its folder if needed; return its path.

    ``joints`` names the entries of every column that has as many, but for gravity's. ArgumentError for what is no log:
    columns of different lengths, or metadata that JSON has not; ConfigError if it cannot be written.
    """
    target = check_log_path(path)
    log = Log(_checked_columns(columns), _checked_metadata(metadata), as_texts(joints, "joints"))
    write = _write_npz if target.suffix.lower() == ".npz" else _write_csv
    with replacing(target) as temporary, temporary.open("wb") as file:
        write(file, log)
    return target


def read_log(path: str | os.PathLike[str]) -> Log:
    """Read what :func:`write_log` wrote; ParseError if it is not such a file."""
    source = check_log_path(path)
    try:
        _refuse_pipe(source)
        return _read_npz(source) if source.suffix.lower() == ".npz" else _read_csv(source)
    except ParseError:
        raise
    except Exception as error:  # damage surfaces as any error of the archive, NumPy's header, JSON or the numbers
        raise ParseError(f"not a log of a run: {error or type(error).__name__}", file=str(path)) from error


def _refuse_pipe(path: Path) -> None:
    """A pipe could keep the reader waiting for ever."""
    if path.exists() and not path.is_file():
        raise ParseError("a folder, a pipe or a device; expected a file", file=str(path))


def _checked_columns(columns: Mapping[str, npt.ArrayLike]) -> dict[str, Column]:
    check_type(columns, Mapping, "columns")
    checked: dict[str, Column] = {}
    for name, column in columns.items():
        array = as_array(column, f"column {shown(name)}", kinds="biuf")
        if not isinstance(name, str) or not NAME.fullmatch(name) or name in KEPT:
            raise ArgumentError(
                f"column {shown(name)}: expected a name of letters, digits and _, and not {listed(KEPT)}"
            )
        if array.ndim not in {1, 2} or 0 in array.shape[1:]:
            raise ArgumentError(f"column '{name}' has shape {array.shape}; expected (cycles,) or (cycles, k)")
        checked[name] = array
    if len({len(column) for column in checked.values()}) > 1:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in checked.items())
        raise ArgumentError(f"columns have different numbers of rows: {lengths}")
    return checked


def _checked_metadata(metadata: Mapping[str, Any]) -> dict[str, Any]:
    check_type(metadata, Mapping, "metadata")
    try:
        json.dumps(dict(metadata))
    except (TypeError, ValueError, RecursionError) as error:
        raise ArgumentError(f"metadata is no JSON object: {error}") from error
    return dict(metadata)


def _write_npz(file: BinaryIO, log: Log) -> None:
    names = {"joint_names": np.array(log.joints)} if log.joints else {}
    arrays: dict[str, Any] = {**log.columns, **names, "metadata": np.array(json.dumps(log.metadata))}
    np.savez(file, **arrays)


def _read_npz(path: Path) -> Log:
    with path.open("rb") as file, warnings.catch_warnings(action="ignore"):
        archive = np.load(file, allow_pickle=False)
        columns = {name: archive[name] for name in archive.files}
    metadata = json.loads(str(columns.pop("metadata")))
    joints = columns.pop("joint_names", np.array(()))
    return Log(columns, metadata, tuple(map(str, joints)))


def _write_csv(file: BinaryIO, log: Log) -> None:
    joints = log.joints if all(map(JOINT.fullmatch, log.joints)) else ()
    names = [name for key, column in log.columns.items() for name in _flat_names(key, column, joints)]
    blocks = [np.atleast_2d(column.T) for column in log.columns.values()]
    rows = zip(*(values.tolist() for block in blocks for values in block), strict=True)
    file.write(f"# {json.dumps(log.metadata)}\n{','.join(names)}\n".encode())
    file.writelines(f"{','.join(map(_number, row))}\n".encode() for row in rows)


def _flat_names(key: str, column: Column, joints: Sequence[str]) -> list[str]:
    if column.ndim == 1:
        return [key]
    if len(joints) == column.shape[1] and key != "gravity":
        return [f"{joint}/{key}" for joint in joints]
    return [f"{key}_{i}" for i in range(column.shape[1])]


def _number(value: float | bool) -> str:
    return repr(int(value) if isinstance(value, bool) else value)


def _read_csv(path: Path) -> Log:
    with path.open(encoding="utf-8") as file:
        metadata = json.loads(file.readline().removeprefix("# "))
        names = file.readline().rstrip("\r\n").split(",")
        rows = [[float(cell) for cell in line.split(",")] for line in file]
    table = np.array(rows).reshape(len(rows), len(names))
    groups: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        groups.setdefault(_column_of(name), []).append(place)
    columns: dict[str, Column] = {
        key: table[:, places[0]] if names[places[0]] == key else table[:, places] for key, places in groups.items()
    }
    joints = dict.fromkeys(name.rpartition("/")[0] for name in names if "/" in name)
    return Log(columns, metadata, tuple(joints))


def _column_of(name: str) -> str:
    """The column that ``shoulder/q``, ``q_0`` or ``time`` is of; ValueError for no name."""
    key = name.rpartition("/")[2]
    stem, _, number = key.rpartition("_")
    if not NAME.fullmatch(key):
        raise ValueError(f"{shown(name)} is no name of a column")
    return stem if number.isdigit() else key
