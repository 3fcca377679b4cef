"""``ravengc identify``: masses, friction, payload and sensor mounting from recorded torques."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser

if TYPE_CHECKING:
    import argparse

__all__ = ["add_parser"]

SUMMARY = "masses, friction and payload from recorded torques"

ABOUT = """\
Identify what torques show of a robot, from recordings on a base that may stand
tilted, and say how far to believe it: what is held out, what the motion does
not show, and which motion or tilt would."""

EXAMPLES = """\
  ravengc identify fit dvrk_mtmr example:mtmr_tilts -o my_mtmr.toml
  ravengc identify payload ur5 example:ur5_unloaded example:ur5_loaded
  ravengc identify fit --help
"""

SUBCOMMANDS = ("fit", "payload", "mounting", "plan")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``identify``, with what can be identified below it, to the command line."""
    parser = command_parser(subparsers, "identify", SUMMARY, ABOUT, EXAMPLES)
    inner = parser.add_subparsers(metavar="WHAT", required=True)
    for name in SUBCOMMANDS:
        importlib.import_module(f"ravengc.cli.identify_{name}").add_parser(inner)
