"""The command line: ``ravengc COMMAND``, one module per command.

Exit codes: 0 good, 1 a check failed, 2 bad input; 130 after Ctrl-C, 141 when whoever read the output went away.
"""

from __future__ import annotations

import argparse
import importlib
import io
import os
import sys
from typing import TYPE_CHECKING

from ravengc.errors import RavenGCError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]

COMMANDS = (
    "info",
    "torque",
    "run",
    "replay",
    "sensor",
    "calibrate",
    "identify",
    "symbolic",
    "stability",
    "dvrk",
    "track",
    "reproduce",
    "sweep",
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command that ``argv`` (default: the process's arguments) names, and return the exit code."""
    try:
        _make_streams_safe()
        return _run(argv)
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        _drop_output()
        return 141
    except OSError as error:  # standard output itself: errors of files are ravengc's own
        _drop_output()
        return _complain(f"cannot print: {error.strerror or error}")


def _run(argv: Sequence[str] | None) -> int:
    parser = _parser()
    try:
        if not (sys.argv[1:] if argv is None else argv):
            parser.print_help(sys.stderr)
            return 2
        arguments = parser.parse_args(argv)
        return int(arguments.func(arguments))
    except RavenGCError as error:
        return _complain(str(error))
    except MemoryError:
        return _complain("not enough memory for a computation of this size")
    finally:
        sys.stdout.flush()


def _complain(message: str) -> int:
    sys.stderr.write(f"ravengc: error: {message}\n")
    return 2


def _make_streams_safe() -> None:
    """Closed streams swallow what is printed; characters that the terminal's encoding lacks are written as escapes."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115 -- open to the end
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Let what is still buffered go nowhere, so that the interpreter's last flush does not fail once more."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _ShowVersion(argparse.Action):
    """Look the version up only when it is asked for: that takes longer than all other imports together."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"ravengc {version('ravengc')}\n")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="ravengc",
        description="Gravity compensation for robot arms on bases that tilt, rock or accelerate.",
        epilog="ravengc COMMAND --help has examples.",
    )
    parser.add_argument("--version", action=_ShowVersion, nargs=0, help="show the version and exit")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for name in COMMANDS:
        importlib.import_module(f"ravengc.cli.{name}").add_parser(subparsers)
    return parser
