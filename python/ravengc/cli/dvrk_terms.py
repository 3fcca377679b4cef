"""``ravengc dvrk terms``: the page's special terms for the MTM as named elements, with their jumps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, console, fixed, new_table, print_json, right
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse

    from ravengc.dvrk import SpecialTerm

__all__ = ["add_parser", "run"]

ABOUT = """\
What the dVRK wiki's page 'Control Gravity Compensation' adds to the torques of
the MTM's masses: parallel mechanism, cable offsets and cables, damping, and the
spring of the wrist's pitch, each as a named element of the robot, with the
places at which its torque jumps. -o writes the robot with them."""

EXAMPLES = """\
  ravengc dvrk terms
  ravengc dvrk terms dvrk_mtml -o mtml_page.toml
  ravengc torque mtml_page.toml --q 0 0 0 0 1.57 0 0
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``dvrk terms`` to the command line."""
    parser = command_parser(
        subparsers, "terms", "the page's special terms for the MTM, and their jumps", ABOUT, EXAMPLES
    )
    add = parser.add_argument
    add("robot", metavar="ROBOT", nargs="?", default="dvrk_mtmr", help="dvrk_mtml or dvrk_mtmr (default: %(default)s)")
    add("-o", "--output", metavar="FILE", type=Path, help="write the robot with its terms (.toml)")
    add("--json", action="store_true", help="print one JSON object instead of the table")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Print the terms, write the robot."""
    from ravengc.config import write_toml
    from ravengc.dvrk import mtm_with_special_terms, special_terms

    terms = special_terms(args.robot)
    if args.output is not None:
        if args.output.suffix.lower() != ".toml":
            raise ConfigError(f"{args.output}: expected a name ending in .toml")
        write_toml(mtm_with_special_terms(args.robot), args.output)
    print_json({"robot": args.robot, "terms": [describe(term) for term in terms]}) if args.json else _show(
        args.robot, terms, args.output
    )
    return 0


def describe(term: SpecialTerm) -> dict[str, Any]:
    """A term as plain data."""
    return {
        "name": term.element.name,
        "kind": term.element.kind,
        "joint": getattr(term.element, "joint", None),
        "says": term.says,
        "remark": term.remark,
        "jumps": [{"at": jump.at, "size": jump.size} for jump in term.jumps],
    }


def _show(robot: str, terms: tuple[SpecialTerm, ...], output: Path | None) -> None:
    from rich.markup import escape

    out = console()
    out.print(f"{robot}: the page's special terms as elements", style="bold")
    table = new_table("element", "kind", "the page", right("jumps at rad"), right("by N m"), "remark")
    for term in terms:
        places = ", ".join(fixed(jump.at, 2) for jump in term.jumps)
        sizes = ", ".join(fixed(jump.size, 2, "+") for jump in term.jumps)
        table.add_row(term.element.name, term.element.kind, escape(term.says), places, sizes, escape(term.remark))
    out.print(table)
    jumping = sum(bool(term.jumps) for term in terms)
    out.print(
        f"{jumping} of {len(terms)} jump: an arm that is moved across kicks there, and one at rest there chatters"
    )
    if output is not None:
        out.print(f"written: {output}", soft_wrap=True, markup=False)
