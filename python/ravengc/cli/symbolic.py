"""``ravengc symbolic``: formulas of a robot as text, LaTeX, C or Python."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, print_json, quantity, waiting

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Sequence

    from ravengc.symbolic import Check, Formulas

__all__ = ["add_parser", "run"]

WHAT = ("gravity", "kinematics", "jacobian", "regressor", "inverse-dynamics", "inverse-dynamics-regressor")
FORMATS = ("text", "latex", "c", "python")
FORMS = ("auto", "closed", "steps")

ABOUT = """\
Print the formulas of a robot: the torques that hold it against gravity, the
pose and Jacobian of a frame, its inverse dynamics, or the regressor of either
(tau = Y pi). Masses, centres of mass and inertias stay symbols. Gravity is any
vector (gx, gy, gz) in base axes, so the formulas hold on a base that tilts.
Whatever is printed was first compared with the compiled core in random states.
Needs SymPy: pip install 'ravengc[symbolic]'"""

EXAMPLES = """\
  ravengc symbolic rrbot --level --lengths
  ravengc symbolic raven2_gold --numbers --format c -o raven2_gravity.c
  ravengc symbolic dvrk_mtmr --level --format latex -o mtm.tex
  ravengc symbolic dvrk_psm_si --level --right-angles 1e-5
  ravengc symbolic ur5 --what regressor --format python -o regressor.py
  ravengc symbolic panda --what inverse-dynamics --moving-base --format c

exit code: 0 printed, 1 not what the core computes (nothing is printed),
2 bad input
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``symbolic`` to the command line."""
    parser = command_parser(subparsers, "symbolic", "formulas of a robot: text, LaTeX, C, Python", ABOUT, EXAMPLES)
    add = parser.add_argument
    add("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file")
    add("--what", choices=WHAT, default="gravity", metavar="WHAT", help=f"{', '.join(WHAT)} (default: gravity)")
    add("--mass-set", metavar="NAME", help="which of the robot's mass sets (default: the file's own)")
    add("--numbers", action="store_true", help="masses, centres of mass and inertias as numbers")
    add("--lengths", action="store_true", help="lengths a and d of Denavit-Hartenberg rows as symbols")
    add(
        "--right-angles",
        metavar="ANGLE",
        default="0",
        help='angles of rows this close to right angles are such: 1e-5 (rad) or "0.01 deg"; files round them',
    )
    add("--frame", metavar="NAME", default="tool", help="frame of kinematics and Jacobian (default: tool)")
    _add_gravity_options(parser.add_argument_group("gravity (default: symbols gx, gy, gz in base axes)"))
    _add_output_options(parser.add_argument_group("output"))
    parser.set_defaults(func=run)


def _add_gravity_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_mutually_exclusive_group().add_argument
    add("--level", action="store_true", help="one symbol g: the base is level")
    add("--gravity", nargs=3, metavar=("GX", "GY", "GZ"), help="numbers, m/s^2")
    add(
        "--moving-base",
        action="store_true",
        help="instead: specific force f, angular velocity w and acceleration dw of the base (inverse dynamics)",
    )


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--format", choices=FORMATS, default="text", help="default: text")
    add(
        "--form",
        choices=FORMS,
        help="closed: each entry in one line; steps: what is used more than once is named first (default: auto for "
        "text and LaTeX, closed where that is short; steps for C and Python)",
    )
    add("-o", "--output", type=Path, metavar="FILE", help="write there, whole or not at all")
    add("--check", type=int, default=5, metavar="N", help="random states of the comparison (default: %(default)s)")
    add("--seed", type=int, default=0, help="of those states (default: %(default)s)")
    add("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Derive, check, print; 1 if the check fails."""
    from ravengc.atomic import check_writable
    from ravengc.symbolic import check, written

    if args.output is not None:
        check_writable(args.output)
    with waiting(f"{args.what} of {args.robot}") as status:
        found = _derived(args, lambda text: status.update(f"{args.what} of {args.robot}: {text}"))
        status.update(f"{args.what} of {args.robot}: comparing with the core")
        result = check(found, args.check, args.seed)
    if not result.holds:
        sys.stderr.write(f"ravengc: the formulas are not what the core computes, {result}\n")
        return 1
    text = written(found, args.format, result)
    if args.output is not None:
        _write(args.output, text)
    _print(args, found, result, text)
    return 0


def _derived(args: argparse.Namespace, on_progress: Callable[[str], None]) -> Formulas:
    import ravengc
    from ravengc.symbolic import formulas

    return formulas(
        ravengc.load(args.robot, mass_set=args.mass_set).spec,
        args.what,
        numbers=args.numbers,
        lengths=args.lengths,
        right_angles=quantity(args.right_angles, "angle", "--right-angles"),
        gravity="level" if args.level else _numbers(args.gravity) if args.gravity else "vector",
        moving_base=args.moving_base,
        frame=args.frame,
        form=args.form or ("steps" if args.format in {"c", "python"} else "auto"),
        on_progress=on_progress,
    )


def _numbers(words: Sequence[str]) -> list[float]:
    return [quantity(word, "acceleration", "--gravity") for word in words]


def _write(path: Path, text: str) -> None:
    from ravengc.atomic import replacing

    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _print(args: argparse.Namespace, found: Formulas, result: Check, text: str) -> None:
    if args.json:
        from ravengc.symbolic import as_data

        compared = {"states": result.states, "largest_difference": result.difference, "largest_entry": result.largest}
        file = None if args.output is None else str(args.output)
        print_json({**as_data(found), "check": compared, "format": args.format, "file": file, "text": text})
    elif args.output is None:
        sys.stdout.write(text)
    else:
        sys.stdout.write(f"{args.output}: {args.what} of {found.spec.name}, checked {result}\n")
