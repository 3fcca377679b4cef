"""Read a recording from delimited text: a header, then a row per sample; comma, semicolon or tab between the cells.

Lines that start with ``#`` are comments, except that the first may be the header (as ``numpy.savetxt`` writes it).
With a semicolon or a tab as delimiter a decimal comma is understood; a file that uses both marks is refused. A last
line without a line end is left out and counted: a recorder that was stopped may have cut its last number.
"""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.errors import ParseError
from ravengc.recordings.columns import EXPECTED, Layout, layout_of
from ravengc.recordings.screening import RawTable, check_time, enumerated

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

__all__ = ["read_csv"]

DELIMITERS = (";", "\t", ",")
CUT_OFF = "last line without a line end"
NumberedLine = tuple[int, str]


def read_csv(path: Path, *, rate_hz: float | None = None) -> RawTable:
    """The table in a text file; ``rate_hz`` stands in for a missing time column.

    Raises ParseError with line and column for what cannot be read, ConfigError for neither a time column nor a rate,
    or both.
    """
    lines = _lines(path)
    layout, delimiter, width = _header(lines, str(path))
    check_time(None if layout.time is None else f"column {layout.time.place + 1}", rate_hz, str(path))
    rows = _Rows(file=str(path), layout=layout, delimiter=delimiter, width=width)
    for number, line in lines:
        rows.add(number, line)
    return _table(rows, rate_hz)


def _lines(path: Path) -> Iterator[NumberedLine]:
    """Numbered lines with their line ends, empty lines left out."""
    number = 0
    try:
        with path.open(encoding="utf-8-sig") as handle:
            for number, line in enumerate(handle, start=1):
                if line.strip():
                    yield number, line
    except UnicodeDecodeError as error:
        message = f"not UTF-8 text near byte {error.start} of this part (expected a text table)"
        raise ParseError(message, file=str(path), line=number + 1) from error


def _header(lines: Iterator[NumberedLine], file: str) -> tuple[Layout, str, int]:
    for number, line in lines:
        comment, text = line.lstrip().startswith("#"), line.strip().lstrip("#").strip()
        delimiter = next((mark for mark in DELIMITERS if mark in text), ",")
        cells = text.split(delimiter)
        if comment and not _looks_like_names(cells, file):
            continue
        if all(_is_number(cell) for cell in cells):
            message = f"no header: the first line holds numbers; expected {EXPECTED}"
            raise ParseError(message, file=file, line=number, column=1)
        return layout_of(cells, file=file, line=number), delimiter, len(cells)
    raise ParseError(f"no header; expected {EXPECTED}", file=file)


def _looks_like_names(cells: Sequence[str], file: str) -> bool:
    try:
        return len(layout_of(cells, file=file).used) > 1
    except ParseError:
        return False


def _is_plain(text: str) -> bool:
    """Whether Python reads no more numbers in the text than other programs do: not 1_0, nor digits of other scripts."""
    return text.isascii() and "_" not in text


def _is_number(cell: str) -> bool:
    try:
        float(cell.strip().replace(",", "."))
    except ValueError:
        return False
    return True


@dataclass(slots=True, kw_only=True)
class _Rows:
    """The numbers read so far, row after row, and where each row stood."""

    file: str
    layout: Layout
    delimiter: str
    width: int
    values: array[float] = field(default_factory=lambda: array("d"))
    numbers: array[int] = field(default_factory=lambda: array("q"))
    cut_off: int = 0
    comma_at: int | None = None
    point_at: int | None = None
    pick: itemgetter[Any] = field(init=False)

    def __post_init__(self) -> None:
        self.pick = itemgetter(*(column.place for column in self.layout.used), 0)

    def add(self, number: int, line: str) -> None:
        """Read one line, or leave it out if it is a comment or cut off."""
        if line.startswith("#"):
            return
        if not line.endswith("\n"):
            self.cut_off += 1
            return
        cells = self._cells(number, line)
        picked = self.pick(cells)[:-1]
        if not (_is_plain(line) and self._extended_by(picked)):
            self.values.extend([self._number(number, cells, column.place) for column in self.layout.used])
        if self.point_at is None and any("." in cell for cell in picked):
            self.point_at = number
        self.numbers.append(number)

    def _extended_by(self, cells: Sequence[str]) -> bool:
        """Append a row of which every cell is a number, or nothing."""
        try:
            self.values.extend([float(cell) for cell in cells])
        except ValueError:
            del self.values[len(self.numbers) * len(cells) :]
            return False
        return True

    def _cells(self, number: int, line: str) -> list[str]:
        cells = line.rstrip("\r\n").replace('"', "").split(self.delimiter)
        if len(cells) == self.width + 1 and not cells[-1].strip():
            cells.pop()
        if len(cells) == self.width:
            return cells
        hint = ""
        if self.delimiter == "," and len(cells) > self.width:
            hint = "; if the numbers have a decimal comma, use ';' or a tab between the cells"
        message = f"{len(cells)} cells, expected {self.width} as in the header{hint}"
        raise ParseError(message, file=self.file, line=number, column=min(len(cells), self.width) + 1)

    def _number(self, number: int, cells: Sequence[str], place: int) -> float:
        text = cells[place].strip()
        if not text:
            return float("nan")
        try:
            if self.delimiter != "," and text.count(",") == 1 and "." not in text:
                self.comma_at = self.comma_at or number
                text = text.replace(",", ".")
            return float(text if _is_plain(text) else "")
        except ValueError:
            message = f"'{text[:40]}' is not a number (expected one such as 0.25)"
            raise ParseError(message, file=self.file, line=number, column=place + 1) from None


def _table(rows: _Rows, rate_hz: float | None) -> RawTable:
    if rows.comma_at is not None and rows.point_at is not None:
        message = f"decimal comma here, decimal point in line {rows.point_at}; expected one of the two throughout"
        raise ParseError(message, file=rows.file, line=rows.comma_at)
    used = rows.layout.used
    data = np.frombuffer(rows.values, dtype=np.float64).reshape(-1, len(used)) * [column.scale for column in used]
    of_place = {column.place: data[:, index] for index, column in enumerate(used)}
    arrays = {
        role: np.column_stack([of_place[column.place] for column in columns])
        for role, columns in rows.layout.roles.items()
    }
    time = rows.layout.time
    t = of_place[time.place] if time else np.arange(data.shape[0]) / (rate_hz or 1.0)
    table = RawTable(
        file=rows.file,
        t=t,
        arrays=arrays,
        names=rows.layout.names,
        row_word="line",
        row_numbers=np.frombuffer(rows.numbers, dtype=np.int64),
    )
    _report(table, rows, rate_hz)
    return table


def _report(table: RawTable, rows: _Rows, rate_hz: float | None) -> None:
    if rows.cut_off:
        table.skipped[CUT_OFF] = rows.cut_off
    if rows.layout.ignored:
        table.notes.append(f"columns not used: {enumerated(rows.layout.ignored)}")
    if rows.layout.time is None:
        table.notes.append(f"no time column: stamps made from the given rate, {rate_hz:g} Hz")
