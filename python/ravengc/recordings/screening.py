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
from ravengc.errors import ParseError
from ravengc.recordings.recording import FloatArray, Recording

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["RawTable", "enumerated", "screen"]

NOT_FINITE = "missing or non-finite number"
ABSURD = "number beyond any arm's (above 1e9)"
REPEATED = "repeated time stamp"
SHORTEST_STEP = 1e-12
"""Stamps that are no farther apart (s) are the same."""
LATEST = 1e19
"""No stamp is farther from zero (s)."""


@dataclass(slots=True, kw_only=True)
class RawTable:
    """What a reader found, unchecked: arrays of as many rows, NaN where a number is missing.

    ``row_numbers`` leads from a row to its place in the source, counted in ``row_word`` (line, row, message).
    """

    file: str
    t: FloatArray
    q: FloatArray
    qd: FloatArray | None = None
    qdd: FloatArray | None = None
    tau: FloatArray | None = None
    gravity: FloatArray | None = None
    names: tuple[str, ...] = ()
    row_word: str = "row"
    row_numbers: npt.NDArray[np.int64] | None = None
    skipped: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)

    def place(self, row: int) -> tuple[str, int | None]:
        """The row as words and, in a text file, as a line number for ParseError."""
        number = int(self.row_numbers[row]) if self.row_numbers is not None else row + 1
        return f"{self.row_word} {number}", number if self.row_word == "line" else None

    def arrays(self) -> dict[str, FloatArray]:
        """The per-joint arrays that are present, by name."""
        found = {"q": self.q, "qd": self.qd, "qdd": self.qdd, "tau": self.tau}
        return {name: values for name, values in found.items() if values is not None}


def enumerated(names: Sequence[str]) -> str:
    """The names with commas, for a note: at most thirty of them, at most 80 characters each."""
    return ", ".join([*(name[:80] for name in names[:30]), *(["..."] if len(names) > 30 else [])])


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
    arrays: dict[str, Any] = {name: values[keep] for name, values in table.arrays().items()}
    if table.gravity is not None:
        arrays["gravity"] = table.gravity[keep]
    return Recording(
        t=table.t[keep], names=table.names, source=table.file, skipped=table.skipped, notes=tuple(table.notes), **arrays
    )


def _check_shapes(table: RawTable) -> None:
    if table.t.size == 0:
        raise ParseError(f"no samples{_reasons(table)}", file=table.file)
    expected = (table.t.size, table.q.shape[1] if table.q.ndim == 2 else 0)
    for name, values in table.arrays().items():
        if values.ndim != 2 or values.shape != expected or 0 in values.shape:
            hint = "; it looks transposed" if values.ndim == 2 and values.shape[1] == table.t.size else ""
            wanted = f"({table.t.size}, joints)" if name == "q" else str(expected)
            message = f"{name} has shape {values.shape}, expected {wanted} for {table.t.size} time stamps{hint}"
            raise ParseError(message, file=table.file)
    if table.gravity is not None and table.gravity.shape != (table.t.size, 3):
        raise ParseError(f"gravity has shape {table.gravity.shape}, expected ({table.t.size}, 3)", file=table.file)


def _drop_absent(table: RawTable) -> None:
    """Leave out an optional quantity that is NaN throughout; refuse one joint's column that is."""
    for name, values in table.arrays().items():
        empty = ~np.isfinite(values).any(axis=0)
        if not empty.any():
            continue
        if name != "q" and empty.all():
            setattr(table, name, None)
            table.notes.append(f"{name} holds no number at all and counts as not recorded")
            continue
        joint = int(np.flatnonzero(empty)[0])
        label = table.names[joint] if table.names else f"{joint + 1}"
        raise ParseError(f"{name} of joint {label} holds no finite number in {values.shape[0]} rows", file=table.file)


def _finite_rows(table: RawTable) -> npt.NDArray[np.int64]:
    finite, sensible = np.isfinite(table.t), np.abs(table.t) <= LATEST
    gravity = () if table.gravity is None else (table.gravity,)
    for values in (*table.arrays().values(), *gravity):
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
