"""What the commands share: where they print, and how they read numbers with units."""

from __future__ import annotations

import argparse
import json
import re
import sys
from typing import TYPE_CHECKING, Any

from ravengc.units import Dimension, to_si

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["command_parser", "console", "print_json", "quantity"]

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
    """A console on standard output, wide enough for the tables where that is no terminal."""
    from rich.console import Console

    return Console(highlight=False, width=None if sys.stdout.isatty() else PIPE_WIDTH)


def print_json(value: dict[str, Any]) -> None:
    """Print one JSON object to standard output."""
    sys.stdout.write(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def quantity(text: str, dimension: Dimension, what: str) -> float:
    """A number as typed, SI without a unit and converted with one; raises UnitsError."""
    try:
        number = float(text)
    except ValueError:
        return to_si(text, dimension, what)
    return to_si(number, dimension, what)
