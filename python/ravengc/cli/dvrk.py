"""``ravengc dvrk``: what concerns the da Vinci Research Kit, one command below it for each thing to do."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser

if TYPE_CHECKING:
    import argparse

__all__ = ["add_parser"]

ABOUT = """\
The da Vinci Research Kit's published models and files: checked against other
libraries, translated into robot files, held and let go in simulation."""

EXAMPLES = """\
  ravengc dvrk table  # RRBot in both DH conventions, asked of every library
  ravengc dvrk convert MTMR.json gc-MTMR-28247.json -o mtmr.toml
  ravengc dvrk terms dvrk_mtmr -o mtmr_page.toml
  ravengc dvrk hold dvrk_mtmr --tilt "20 deg"
  ravengc dvrk passive --seconds 5

ravengc dvrk WHAT --help has more.
"""

PARTS = ("table", "convert", "terms", "hold", "passive")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``dvrk``, with its commands below it, to the command line."""
    parser = command_parser(subparsers, "dvrk", "the da Vinci Research Kit's models and files", ABOUT, EXAMPLES)
    inner = parser.add_subparsers(metavar="WHAT", required=True)
    for name in PARTS:
        importlib.import_module(f"ravengc.cli.dvrk_{name}").add_parser(inner)
