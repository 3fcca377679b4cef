"""From the table that a file holds to a recording: rows that cannot be used are left out, counted and named.

A row with a missing or non-finite number is skipped, as is a row that repeats the stamp before it. Time that runs
backwards is an error, because nothing tells which part of such a file is right.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ravengc.config.physical import LARGEST
from ravengc.errors import ConfigError, ParseError
from ravengc.recordings.recording import BASE, FloatArray, Recording

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["RawTable", "check_time", "enumerated", "screen"]

NOT_FINITE = "missing or non-finite number"
ABSURD = "number beyond any arm's (above 1e9)"
REPEATED = "repeated time stamp"
SHORTEST_STEP = 1e-12
"""Stamps that are no farther apart (s) are the same."""
LATEST = 1e19
"""No stamp is farther from zero (s)."""


@dataclass(slots=True, kw_only=True)
class RawTable:
    """What a reader found, unchecked: as many rows as stamps ``t``, NaN where a number is missing.

    ``arrays`` are q and, where recorded, qd, qdd, tau, gravity and angular_velocity, as in :class:`Recording`.
    ``row_numbers`` leads from a row to its place in the source, counted in ``row_word`` (line, row, message).
    """

    file: str
    t: FloatArray
    arrays: dict[str, FloatArray]
    names: tuple[str, ...] = ()
    row_word: str = "row"
    row_numbers: npt.NDArray[np.int64] | None = None
    skipped: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)

    def place(self, row: int) -> tuple[str, int | None]:
        """The row as words and, in a text file, as a line number for ParseError."""
        number = int(self.row_numbers[row]) if self.row_numbers is not None else row + 1
        return f"{self.row_word} {number}", number if self.row_word == "line" else None

    def column(self, name: str, place: int) -> str:
        """A column of an array as words: ``tau of joint elbow``, ``gravity along z``."""
        if name in BASE:
            return f"{name} along {'xyz'[place]}"
        return f"{name} of joint {self.names[place] if self.names else place + 1}"


def enumerated(names: Sequence[str]) -> str:
    """The names with commas, for a note: at most thirty of them, at most 80 characters each."""
    return ", ".join([*(name[:80] for name in names[:30]), *(["..."] if len(names) > 30 else [])])


def check_time(stamps: str | None, rate_hz: float | None, file: str) -> None:
    """Raise ConfigError unless a recording has either time stamps, which ``stamps`` says where, or a sample rate."""
    if stamps is None and rate_hz is None:
        raise ConfigError(
            f"{file}: no time stamps; call a column or array 't' (s), or give the sample rate (--rate HZ)"
        )
    if stamps is not None and rate_hz is not None:
        raise ConfigError(
            f"{file}: has time stamps ({stamps}), which a sample rate of {rate_hz:g} Hz would contradict or repeat;"
            " leave out --rate, or if the stamps are wrong take them out of the file"
        )


def screen(table: RawTable, *, strict: bool = False) -> Recording:
    """A recording of the table's usable rows; ``strict`` makes a skipped row an error.

    Raises ParseError for no rows, time that runs backwards, a column without a single number, and shapes that disagree.
    """
    _check_shapes(table)
    _drop_absent(table)
    keep = _finite_rows(table)
    keep = _increasing_rows(table, keep)
    if keep.size == 0:
        raise ParseError(f"no usable sample in {table.t.size} rows{_reasons(table)}", file=table.file)
    if strict and table.skipped:
        raise ParseError(f"rows would be skipped{_reasons(table)}, and strict reading was asked for", file=table.file)
    arrays: dict[str, Any] = {name: values[keep] for name, values in table.arrays.items()}
    return Recording(
        t=table.t[keep], names=table.names, source=table.file, skipped=table.skipped, notes=tuple(table.notes), **arrays
    )


def _check_shapes(table: RawTable) -> None:
    rows, q = table.t.size, table.arrays["q"]
    if rows == 0:
        raise ParseError(f"no samples{_reasons(table)}", file=table.file)
    joints = q.shape[1] if q.ndim == 2 else 0
    for name, values in table.arrays.items():
        columns = 3 if name in BASE else joints
        if columns == 0 or values.shape != (rows, columns):
            hint = "; it looks transposed" if values.ndim == 2 and values.shape[1] == rows else ""
            wanted = "joints" if name == "q" else columns
            message = f"{name} has shape {values.shape}, expected ({rows}, {wanted}) for {rows} time stamps{hint}"
            raise ParseError(message, file=table.file)


def _drop_absent(table: RawTable) -> None:
    """Leave out an optional quantity that is NaN throughout; refuse one column that is."""
    for name, values in list(table.arrays.items()):
        empty = ~np.isfinite(values).any(axis=0)
        if not empty.any():
            continue
        if name != "q" and empty.all():
            del table.arrays[name]
            table.notes.append(f"{name} holds no number at all and counts as not recorded")
            continue
        column = table.column(name, int(np.flatnonzero(empty)[0]))
        raise ParseError(f"{column} holds no finite number in {values.shape[0]} rows", file=table.file)


def _finite_rows(table: RawTable) -> npt.NDArray[np.int64]:
    finite, sensible = np.isfinite(table.t), np.abs(table.t) <= LATEST
    for values in table.arrays.values():
        finite &= np.isfinite(values).all(axis=1)
        sensible &= (np.abs(values) <= LARGEST).all(axis=1)
    _count(table, NOT_FINITE, int(np.count_nonzero(~finite)))
    _count(table, ABSURD, int(np.count_nonzero(finite & ~sensible)))
    rows: npt.NDArray[np.int64] = np.flatnonzero(finite & sensible)
    return rows


def _increasing_rows(table: RawTable, rows: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    step = np.diff(table.t[rows])
    backwards = np.flatnonzero(step < 0.0)
    if backwards.size:
        before, after = rows[backwards[0]], rows[backwards[0] + 1]
        words, line = table.place(int(after))
        message = (
            f"time runs backwards at {words}: {table.t[after]:.9g} s after {table.t[before]:.9g} s"
            " (expected increasing stamps: sort the rows, or cut the recording there)"
        )
        raise ParseError(message, file=table.file, line=line)
    fresh = np.concatenate([np.ones(min(rows.size, 1), dtype=bool), step > SHORTEST_STEP])
    _count(table, REPEATED, int(np.count_nonzero(~fresh)))
    kept: npt.NDArray[np.int64] = rows[fresh]
    return kept


def _count(table: RawTable, reason: str, rows: int) -> None:
    if rows:
        table.skipped[reason] += rows


def _reasons(table: RawTable) -> str:
    listed = ", ".join(f"{count} x {reason}" for reason, count in table.skipped.items())
    return f" ({listed})" if listed else ""
