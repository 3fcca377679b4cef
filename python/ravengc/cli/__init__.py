"""The command line: ``ravengc COMMAND``, one module per command.

Exit codes: 0 good, 1 a check failed, 2 bad input.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from typing import TYPE_CHECKING

from ravengc.errors import RavenGCError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]

COMMANDS = ("info", "torque", "run", "replay")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command that ``argv`` (default: the process's arguments) names, and return the exit code."""
    arguments = _parser().parse_args(argv)
    try:
        return int(arguments.func(arguments))
    except RavenGCError as error:
        sys.stderr.write(f"ravengc: error: {error}\n")
        return 2


class _ShowVersion(argparse.Action):
    """Look the version up only when it is asked for: that takes longer than all other imports together."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"ravengc {version('ravengc')}\n")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="ravengc", description="Gravity compensation for robot arms on bases that tilt, rock or accelerate."
    )
    parser.add_argument("--version", action=_ShowVersion, nargs=0, help="show the version and exit")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for name in COMMANDS:
        importlib.import_module(f"ravengc.cli.{name}").add_parser(subparsers)
    return parser
