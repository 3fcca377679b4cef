"""The control software's JSON: with comments, numbers plain and in SI; a question is answered or the place is named."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any

from ravengc.config.fields import Table
from ravengc.config.files import decode, read_bytes
from ravengc.config.locate import Place
from ravengc.errors import ConfigError, ParseError, UnitsError

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.units import Dimension

__all__ = ["number", "numbers", "optional_number", "read_json", "square", "table_of"]

COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*"|//[^\n]*|/\*.*?\*/', re.DOTALL)


def read_json(path: Path) -> dict[str, Any]:
    """The object in a JSON file with comments; ParseError with line and column where it cannot be read."""
    file = str(path)
    text = COMMENT.sub(_blank, decode(read_bytes(path), file))
    try:
        found = json.loads(text, parse_constant=_refuse)
    except json.JSONDecodeError as error:
        raise ParseError(f"is not JSON: {error.msg}", file=file, line=error.lineno, column=error.colno) from error
    except (ValueError, RecursionError) as error:  # NaN, an endless integer, a thousand brackets
        raise ParseError(f"is not JSON: {error}", file=file) from error
    if not isinstance(found, dict):
        raise ParseError(f"holds a {type(found).__name__}, expected an object {{...}}", file=file)
    return found


def _blank(match: re.Match[str]) -> str:
    """A comment as blanks, so that lines and columns stay; a string as it is."""
    text = match.group()
    return text if text.startswith('"') else re.sub(r"[^\n]", " ", text)


def _refuse(word: str) -> Any:
    raise ValueError(f"{word} is not a number")


def table_of(data: object, file: str, label: str) -> Table:
    """The object as a table with whatever keys it has, called by ``label`` in errors."""
    keys = tuple(data) if isinstance(data, dict) else ()
    return Table(data, Place(label, (), lambda _: f"{file}: "), keys)


def numbers(table: Table, key: str, count: int) -> tuple[float, ...]:
    """A list of this many finite numbers; ConfigError otherwise."""
    dimensions: list[Dimension] = ["number"] * count
    try:
        return table.vector(key, dimensions)
    except UnitsError as error:  # an entry in quotes
        raise table.complaint(key, f"{count} numbers without quotes") from error


def number(table: Table, key: str, default: float = 0.0) -> float:
    """One finite number; ConfigError for anything else."""
    found = optional_number(table, key)
    return default if found is None else found


def optional_number(table: Table, key: str) -> float | None:
    """One finite number, or ``None`` where the key is not there; ConfigError for anything else."""
    if table.is_text(key):
        raise table.complaint(key, "a number without quotes")
    return table.optional_number(key, "number")


def square(table: Table, key: str, size: int) -> tuple[tuple[float, ...], ...]:
    """A square matrix of this size; ConfigError otherwise."""
    rows = table.matrix(key)
    if [len(row) for row in rows] != [size] * size:
        shape = f"{len(rows)} rows of {sorted({len(row) for row in rows})} numbers"
        raise ConfigError(f"{table.place.at(key)}: got {shape}, expected {size} rows of {size}")
    return rows
