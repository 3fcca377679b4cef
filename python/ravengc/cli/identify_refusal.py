"""Data that do not determine what was asked for: not bad input, but a refusal, with exit code 1."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from ravengc.cli.common import print_json
from ravengc.errors import CalibrationError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

__all__ = ["refusing"]


def refusing(args: argparse.Namespace, work: Callable[[argparse.Namespace], int]) -> int:
    """Do the work; 1 and the reason, on standard error or as JSON, if the recordings do not allow it."""
    try:
        return work(args)
    except CalibrationError as error:
        if args.json:
            print_json({"refused": str(error)})
        else:
            sys.stderr.write(f"ravengc: refused: {error}\n")
        return 1
