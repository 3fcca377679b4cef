"""The log of a run as a file: ``.npz`` (exact, fast) or ``.csv`` (for people), with what it is about.

Columns are arrays with one row per cycle, (cycles,) or (cycles, k). The metadata is a JSON object: in ``.npz`` the
text array ``metadata``, in ``.csv`` the first line after ``# ``. In ``.csv`` a column ``q`` of three joints becomes
``q_0, q_1, q_2``.
"""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ravengc.atomic import replacing
from ravengc.errors import ConfigError, ParseError

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

__all__ = ["FORMATS", "Log", "check_log_path", "read_log", "write_log"]

Column = NDArray[np.generic]

FORMATS = (".npz", ".csv")


@dataclass(frozen=True, slots=True)
class Log:
    """Columns by name, and what they are about."""

    columns: dict[str, Column]
    metadata: dict[str, Any]


def check_log_path(path: str | os.PathLike[str]) -> Path:
    """Return ``path`` if a log can have that name; ConfigError for an unknown suffix."""
    checked = Path(path)
    if checked.suffix.lower() not in FORMATS:
        raise ConfigError(f"log file '{path}': the suffix must be {' or '.join(FORMATS)}")
    return checked


def write_log(path: str | os.PathLike[str], columns: Mapping[str, Column], metadata: Mapping[str, Any]) -> Path:
    """Write a log, whole or not at all, making its folder if needed; return its path.

    ConfigError if it cannot be written.
    """
    target = check_log_path(path)
    write = _write_npz if target.suffix.lower() == ".npz" else _write_csv
    with replacing(target) as temporary, temporary.open("wb") as file:
        write(file, columns, metadata)
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


def _write_npz(file: BinaryIO, columns: Mapping[str, Column], metadata: Mapping[str, Any]) -> None:
    arrays: dict[str, Any] = {**columns, "metadata": np.array(json.dumps(metadata))}
    np.savez(file, **arrays)


def _read_npz(path: Path) -> Log:
    with path.open("rb") as file, warnings.catch_warnings(action="ignore"):
        archive = np.load(file, allow_pickle=False)
        columns = {name: archive[name] for name in archive.files}
    metadata = json.loads(str(columns.pop("metadata")))
    return Log(columns, metadata)


def _write_csv(file: BinaryIO, columns: Mapping[str, Column], metadata: Mapping[str, Any]) -> None:
    names = [name for key, column in columns.items() for name in _flat_names(key, column)]
    blocks = [column.reshape(len(column), -1).T for column in columns.values()]
    rows = zip(*(values.tolist() for block in blocks for values in block), strict=True)
    file.write(f"# {json.dumps(metadata)}\n{','.join(names)}\n".encode())
    file.writelines(f"{','.join(map(_number, row))}\n".encode() for row in rows)


def _flat_names(key: str, column: Column) -> list[str]:
    return [key] if column.ndim == 1 else [f"{key}_{i}" for i in range(column.shape[1])]


def _number(value: float | bool) -> str:
    return repr(int(value) if isinstance(value, bool) else value)


def _read_csv(path: Path) -> Log:
    with path.open(encoding="utf-8") as file:
        metadata = json.loads(file.readline().removeprefix("# "))
        names = file.readline().split()[0].split(",")
        rows = [[float(cell) for cell in line.split(",")] for line in file]
    table = np.array(rows).reshape(len(rows), len(names))
    groups: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        stem, _, number = name.rpartition("_")
        groups.setdefault(stem if number.isdigit() else name, []).append(place)
    columns: dict[str, Column] = {
        key: table[:, places[0]] if names[places[0]] == key else table[:, places] for key, places in groups.items()
    }
    return Log(columns, metadata)
