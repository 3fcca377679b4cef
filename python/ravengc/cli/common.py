"""What the commands share: where they print, and how they read numbers with units."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
from typing import TYPE_CHECKING, Any

from ravengc.config.physical import LARGEST
from ravengc.errors import ConfigError
from ravengc.units import Dimension, to_si

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress
    from rich.status import Status
    from rich.table import Column, Table

__all__ = [
    "command_parser",
    "console",
    "fixed",
    "new_table",
    "plain",
    "print_json",
    "progress_bar",
    "quantity",
    "right",
    "waiting",
]

PIPE_WIDTH = 140
NEGATIVE_VALUE = re.compile(r"-[0-9.]")


def command_parser(
    subparsers: argparse._SubParsersAction[argparse.ArgumentParser], name: str, summary: str, about: str, examples: str
) -> argparse.ArgumentParser:
    """Add a command with a description and examples; values such as ``-30deg`` and ``-1e-3`` are not options of it."""
    parser = subparsers.add_parser(
        name,
        help=summary,
        description=about,
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser._negative_number_matcher = NEGATIVE_VALUE  # noqa: SLF001
    return parser


def console() -> Console:
    """A console on standard output, wide enough for the tables where that is no terminal (and COLUMNS is not set)."""
    from rich.console import Console

    class Printer(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError

    has_width = sys.stdout.isatty() or "COLUMNS" in os.environ
    return Printer(highlight=False, width=None if has_width else PIPE_WIDTH)


def waiting(text: str) -> Status:
    """What the command is busy with, on standard error while the ``with`` lasts, if that is a terminal."""
    from rich.console import Console
    from rich.markup import escape

    return Console(stderr=True).status(escape(text))


def progress_bar(*, remaining: bool = False) -> Progress:
    """A bar on standard error, if that is a terminal, and how much time there is left if wanted."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    left = (TimeRemainingColumn(),) if remaining else ()
    return Progress(*columns, *left, console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty())


def new_table(*headings: Column | str) -> Table:
    """A table, close enough set for 80 columns, that folds what is too long and cuts nothing off."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(*headings, box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for column in table.columns:
        column.overflow = "fold"
    return table


def right(heading: str) -> Column:
    """A column of numbers."""
    from rich.table import Column

    return Column(heading, justify="right")


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON object to standard output."""
    sys.stdout.write(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def plain(value: Any) -> Any:
    """Data as JSON has it: arrays as lists, and null for a number that is not finite."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def fixed(value: float, digits: int, sign: str = "") -> str:
    """A number for a table: this many digits after the point, or in powers of ten where that would be endless."""
    value = 0.0 if abs(value) < 0.5 * 10.0**-digits else value  # and not -0.0
    return f"{value:{sign}.{digits}f}" if abs(value) < 1e7 else f"{value:{sign}.6g}"


def quantity(text: str, dimension: Dimension, what: str) -> float:
    """A number as typed, SI without a unit and converted with one; raises UnitsError, ConfigError for a huge one."""
    try:
        value: object = float(text) if text.isascii() and "_" not in text else text
    except ValueError:
        value = text
    number = to_si(value, dimension, what)
    if abs(number) > LARGEST:
        raise ConfigError(f"{what}: {text} is {number:g} in SI; expected at most {LARGEST:g}")
    return number
