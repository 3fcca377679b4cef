"""``ravengc dvrk table``: RRBot's kinematics and gravity in both DH conventions, asked of every library."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, console, fixed, new_table, print_json, right, waiting

if TYPE_CHECKING:
    import argparse

    from rich.console import Console

    from ravengc.dvrk import Cell, Table

__all__ = ["add_parser", "run"]

ABOUT = """\
Regenerate the table of the dVRK wiki's page 'Control Gravity Compensation':
kinematics and gravity of RRBot in standard and modified DH. Each cell is a
library's answer against the core's: YES if they agree up to rounding, and the
largest difference (m; N m). Then why the page says NO for gravity in modified
DH, and whether the MTM's two tables describe the same axes.

PyKDL and the Robotics Toolbox are asked where they are installed, PyKDL also
in the system's own Python (Debian: python3-pykdl)."""

EXAMPLES = """\
  ravengc dvrk table
  ravengc dvrk table --pykdl /usr/bin/python3 --json

exit code: 0 every cell is YES, 1 a NO, 2 bad input
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``dvrk table`` to the command line."""
    parser = command_parser(subparsers, "table", "RRBot in both DH conventions, by every library", ABOUT, EXAMPLES)
    parser.add_argument("--poses", metavar="N", type=int, default=100, help="random poses (default: %(default)s)")
    parser.add_argument(
        "--pykdl", metavar="PYTHON", help="interpreter that has PyKDL (default: this one, the system's)"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the poses (default: %(default)s)")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of the tables")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Ask, print; 1 if a cell is NO."""
    from ravengc.dvrk import agreement_table

    with waiting("asking the libraries"):
        table = agreement_table(args.poses, pykdl=args.pykdl, seed=args.seed)
    print_json(describe(table)) if args.json else _show(table)
    return 0 if table.complete else 1


def describe(table: Table) -> dict[str, Any]:
    """Everything as plain data."""
    from ravengc.dvrk.table import OTHERS, PAGE, ROWS, WHERE

    rows = []
    for place, (subject, convention) in enumerate(ROWS):
        cells = {column.name: _plain(column.cells, place) for column in table.columns}
        page = dict(zip(("cisst", "KDL", "Matlab"), PAGE[subject, convention], strict=True))
        rows.append({"subject": subject, "convention": convention, "cells": cells, "page": page})
    return {
        "poses": table.poses,
        "complete": table.complete,
        "verdict": _verdict(table),
        "libraries": [
            {"name": column.name, "version": column.version, "why_not": column.why_not} for column in table.columns
        ],
        "rows": rows,
        "others": [
            {
                "subject": subject,
                "model": model,
                "cells": {column.name: _plain(column.others, place) for column in table.columns},
            }
            for place, (subject, model) in enumerate(OTHERS)
        ],
        "standard_against_modified": {
            "agrees": table.conventions.agrees,
            "difference": table.conventions.difference,
        },
        "mistakes": {
            "q": list(WHERE),
            "torques": [{"what": one.what, "torque": list(one.torque)} for one in table.mistakes],
        },
        "mtm": [
            {
                "robot": arm.robot,
                "agrees": arm.agrees,
                "axis_direction": arm.direction,
                "axis_distance": arm.distance,
                "wrist_point": arm.wrist,
                "torque": arm.torque,
                "last_frame": arm.tip,
            }
            for arm in table.mtm
        ],
    }


def _verdict(table: Table) -> str:
    """Whether all that was asked agrees, and which libraries were not asked."""
    silent = [column.name for column in table.columns if not column.cells]
    asked = "every cell that was asked is YES" if table.complete else "not every cell that was asked is YES"
    return f"{asked}; not asked: {', '.join(silent)}" if silent else f"{asked}; every library was asked"


def _plain(cells: tuple[Cell, ...], place: int) -> dict[str, Any] | None:
    return {"agrees": cells[place].agrees, "difference": cells[place].difference} if cells else None


def _show(table: Table) -> None:
    from ravengc.dvrk.table import OTHERS, PAGE, ROWS

    out = console()
    out.print(f"{table.poses} poses, RRBot unless another model is named: the core against", style="bold")
    names = [f"{column.name} {column.version}".strip() for column in table.columns]
    shown = new_table("", *names, "the page: cisst, KDL, Matlab")
    for place, row in enumerate(ROWS):
        shown.add_row(", ".join(row), *(_text(column.cells, place) for column in table.columns), ", ".join(PAGE[row]))
    for place, row in enumerate(OTHERS):
        shown.add_row(", ".join(row), *(_text(column.others, place) for column in table.columns), "")
    out.print(shown)
    for column in table.columns:
        if column.why_not:
            out.print(f"{column.name}: {column.why_not}", markup=False)
    verdict = "YES" if table.conventions.agrees else "NO"
    out.print(f"gravity, standard against modified table: {verdict}, {table.conventions.difference:.1e} N m\n")
    _show_mistakes(out, table)
    _show_arms(out, table)
    out.print(_verdict(table), soft_wrap=True, markup=False)


def _text(cells: tuple[Cell, ...], place: int) -> str:
    if not cells:
        return "not asked"
    cell = cells[place]
    return f"{'YES' if cell.agrees else '[bold red]NO[/bold red]'} {cell.difference:.1e}"


def _show_mistakes(out: Console, table: Table) -> None:
    from ravengc.dvrk.table import FIELD, WHERE

    out.print("Why the page says NO for gravity in modified DH", style="bold")
    out.print(
        "A standard row lies behind its joint, and the centre of mass is given in the distal frame: (-0.45, 0, 0). A\n"
        "modified row lies before its joint, and the centre of mass is in the proximal frame: (+0.45, 0, 0). What is\n"
        "written for one convention, or copied from its table, is wrong in the other:"
    )
    headings = (right(f"tau{i} N m") for i in (1, 2))
    shown = new_table(f"q = ({WHERE[0]}, {WHERE[1]}), g = (-{FIELD}, 0, 0) in frame 0", *headings)
    for one in table.mistakes:
        shown.add_row(one.what, *(fixed(value, 6) for value in one.torque))
    out.print(shown)


def _show_arms(out: Console, table: Table) -> None:
    out.print("The MTM in standard and modified DH", style="bold")
    shown = new_table(
        "", "same axes", *map(right, ("direction", "distance m", "wrist point m", "torque N m", "last frame"))
    )
    for arm in table.mtm:
        numbers = (f"{value:.1e}" for value in (arm.direction, arm.distance, arm.wrist, arm.torque, arm.tip))
        shown.add_row(arm.robot, "YES" if arm.agrees else "NO", *numbers)
    out.print(shown)
