"""Rows of numbers in text: blanks, commas, semicolons or tabs between them, names above them or not.

Lines that start with ``#``, ``//`` or ``%`` are comments; the last one before the numbers may hold the names. With a
semicolon or a tab between the cells a decimal comma is understood. An empty cell is NaN. Every row must have as many
cells as the first; the error says in which line one has not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ravengc.errors import ParseError
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray

__all__ = ["Table", "read_table", "unquoted"]

COMMENTS = ("#", "//", "%")
DELIMITERS = (";", "\t", ",")
LONGEST_CELL = 40
QUOTES = "\"'"
DECIMAL_COMMAS = "numbers with a decimal comma need a semicolon or a tab between them"


class Table(NamedTuple):
    """``numbers`` (rows, columns) with the line of each row, the columns' names (none: ()), and all the comments."""

    numbers: NDArray[np.float64]
    lines: NDArray[np.int64]
    names: tuple[str, ...]
    comments: str


def read_table(data: bytes, path: Path, expected: str = "a table of numbers") -> Table:
    """Return the table in a text; ParseError (file, line, column) for what is none, with what was ``expected``."""
    text = _text(data, path, expected)
    texts = text.split("\n" if "\n" in text else "\r")
    comments = [text for text in texts if text.lstrip().startswith(COMMENTS)]
    numbered = [(i, text) for i, text in enumerate(texts, start=1) if _is_row(text)]
    delimiter = _delimiter([text for _, text in numbered[:2]])
    names, numbered = _names(numbered, comments, delimiter)
    if not numbered:
        raise ParseError("no row of numbers", file=str(path))
    numbered = _without_count(numbered, delimiter)
    lines = np.array([i for i, _ in numbered], dtype=np.int64)
    rows = _decimal_points([text for _, text in numbered], delimiter)
    width = len(names) or len(_cells(rows[0], delimiter))
    return Table(_numbers(rows, lines, delimiter, width, path), lines, names, "\n".join(comments))


def unquoted(text: str) -> str:
    """Return a cell without blanks and quotes around it."""
    return text.strip().strip(QUOTES).strip()


def _text(data: bytes, path: Path, expected: str) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        message = f"byte 0x{data[error.start]:02x} is not UTF-8 text; expected {expected}"
        raise ParseError(message, file=str(path), line=line) from error


def _is_row(text: str) -> bool:
    return bool(text.strip()) and not text.lstrip().startswith(COMMENTS)


def _delimiter(first: Sequence[str]) -> str:
    """The mark that the first rows have between their cells; "" for blanks."""
    return next((mark for mark in DELIMITERS if any(mark in text.strip() for text in first)), "")


def _cells(text: str, delimiter: str) -> list[str]:
    cells = text.split(delimiter) if delimiter else text.split()
    return cells[:-1] if delimiter and len(cells) > 1 and not cells[-1].strip() else cells


def _names(
    numbered: list[tuple[int, str]], comments: list[str], delimiter: str
) -> tuple[tuple[str, ...], list[tuple[int, str]]]:
    """The names above the numbers, or in the last comment if it holds as many, and the rows that are left."""
    if numbered and not any(map(_is_number, _cells(numbered[0][1], delimiter))):
        return tuple(unquoted(cell) for cell in _cells(numbered[0][1], delimiter)), numbered[1:]
    width = len(_cells(numbered[0][1], delimiter)) if numbered else 0
    last = comments[-1].strip().lstrip("#/% ") if comments else ""
    words = [unquoted(cell) for cell in _cells(last, delimiter)]
    fits = len(words) == width and len(set(words)) == width and not any(map(_is_number, words))
    return (tuple(words) if fits and width > 1 else ()), numbered


def _is_number(cell: str) -> bool:
    try:
        float(unquoted(cell).replace(",", "."))
    except ValueError:
        return False
    return True


def _without_count(numbered: list[tuple[int, str]], delimiter: str) -> list[tuple[int, str]]:
    """Leave out a first line that only says how many rows follow."""
    first = numbered[0][1].strip()
    is_count = len(numbered) > 1 and first.isdecimal() and len(_cells(numbered[1][1], delimiter)) > 1
    return numbered[1:] if is_count and int(first) == len(numbered) - 1 else numbered


def _decimal_points(rows: list[str], delimiter: str) -> list[str]:
    has_commas = delimiter in {";", "\t"} and any("," in text for text in rows)
    if not has_commas or any("." in text for text in rows):
        return rows
    return [text.replace(",", ".") for text in rows]


def _numbers(rows: list[str], lines: NDArray[np.int64], delimiter: str, width: int, path: Path) -> NDArray[np.float64]:
    """All numbers at once, or, where that fails, one by one: to find the cell, or to allow for quotes and gaps."""
    try:
        table = np.loadtxt(rows, delimiter=delimiter or None, comments=None, ndmin=2)
    except ValueError:
        numbered = zip(rows, lines.tolist(), strict=True)
        table = np.array([_row(text, delimiter, width, path, line) for text, line in numbered])
    if table.shape[1] != width:
        message = f"{table.shape[1]} cells; expected {width}, as many as names above them"
        raise ParseError(message, file=str(path), line=int(lines[0]))
    return table


def _row(text: str, delimiter: str, width: int, path: Path, line: int) -> list[float]:
    cells = _cells(text, delimiter)
    if len(cells) != width and delimiter:
        cells = text.split(delimiter)
    if len(cells) != width:
        raise ParseError(f"{len(cells)} cells; expected {width}, as in the first row", file=str(path), line=line)
    for column, cell in enumerate(cells, start=1):
        if any(cell.count(quote) % 2 for quote in QUOTES):
            message = f"{shown(cell[:LONGEST_CELL])} has a quote without its second; {DECIMAL_COMMAS}"
            raise ParseError(message, file=str(path), line=line, column=column)
    return [_number(unquoted(cell), path, line, column) for column, cell in enumerate(cells, start=1)]


def _number(cell: str, path: Path, line: int, column: int) -> float:
    if not cell:
        return float("nan")
    try:
        return float(cell if cell.isascii() and "_" not in cell else "")
    except ValueError:
        message = f"{shown(cell[:LONGEST_CELL])} is not a number (expected one such as 0.25)"
        raise ParseError(message, file=str(path), line=line, column=column) from None
