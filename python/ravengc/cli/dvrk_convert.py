"""``ravengc dvrk convert``: files of the control software to a robot file, and a robot file to them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, console, fixed, new_table, print_json, quantity, right
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse

    from ravengc.dvrk import Conversion
    from ravengc.spec import RobotSpec

__all__ = ["add_parser", "run"]

ABOUT = """\
Make one robot file (.toml) from the files of an arm of the dVRK's control
software (sawIntuitiveResearchKit): its kinematic file, the physical chain with
masses (kinematic_gc), the arm's own file with its mounting pitch, and for an
MTM the gravity compensation file (dvrk-gravity-compensation, version 2).
Files are told apart by what is in them.

A gravity compensation file was identified on a level base and must not be used
on any other: the command says what it would do when tilted, and writes nothing
if the arm is mounted at a pitch, or if the file is of the other MTM (--anyway
writes it all the same). The robot file is marked level_only.

Backwards: a robot file or the name of a bundled robot, and an output that ends
in .json, as a kinematic file or (--to gc) a gravity compensation file."""

EXAMPLES = """\
  ravengc dvrk convert MTMR.json gc-MTMR-28247.json -o mtmr.toml
  ravengc dvrk convert PSM1.json PSM_Si.json PSM_Si_physical.json -o psm1.toml
  ravengc dvrk convert PSM_Si_physical.json --mounting-pitch "-45 deg" -o a.toml
  ravengc dvrk convert dvrk_mtmr --to gc -o gc-MTMR.json

exit code: 0 written, 1 flagged and not written, 2 bad input
"""

TILTS = (1.0, 5.0, 10.0, 20.0)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``dvrk convert`` to the command line."""
    summary = "files of the control software to a robot file, and back"
    parser = command_parser(subparsers, "convert", summary, ABOUT, EXAMPLES)
    add = parser.add_argument
    add("files", metavar="FILE", nargs="+", help="files of one arm (.json), or one robot (.toml, bundled name)")
    add("-o", "--output", metavar="FILE", type=Path, required=True, help="robot file (.toml), or .json backwards")
    add("--name", metavar="NAME", help="of the robot (default: the kinematic file's)")
    add("--mounting-pitch", metavar="ANGLE", help='about x of frame 0: -0.785 (rad) or "-45 deg" (default: arm file)')
    add("--to", choices=("kinematic", "gc"), help="backwards: which file (default: kinematic)")
    add("--anyway", action="store_true", help="write what is flagged: for a tilted base, of the other MTM")
    add("--json", action="store_true", help="print one JSON object instead of the text")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Convert, say what to know, write; 1 without writing what is flagged."""
    suffix = args.output.suffix.lower()
    if suffix == ".json":
        return _backwards(args)
    if suffix != ".toml":
        raise ConfigError(f"{args.output}: expected a name ending in .toml (a robot), or .json backwards")
    if args.to is not None:
        raise ConfigError("--to is for an output that ends in .json")
    return _forwards(args)


def _forwards(args: argparse.Namespace) -> int:
    from ravengc.config import write_toml
    from ravengc.dvrk import convert

    pitch = None if args.mounting_pitch is None else quantity(args.mounting_pitch, "angle", "--mounting-pitch")
    found = convert(args.files, name=args.name, mounting_pitch=pitch)
    refused = bool(found.flag) and not args.anyway
    if not refused:
        write_toml(found.spec, args.output)
    about = _describe(found, args.output, written=not refused)
    print_json(about) if args.json else _show(found, about)
    return 1 if refused else 0


def _backwards(args: argparse.Namespace) -> int:
    from ravengc.config.bundled import spec_for
    from ravengc.dvrk import published_from_robot, write_kinematic, write_published

    forwards = ("--mounting-pitch", args.mounting_pitch), ("--name", args.name), ("--anyway", args.anyway or None)
    for option, given in forwards:
        if given is not None:
            raise ConfigError(f"{option} is for an output that ends in .toml")
    if len(args.files) != 1:
        raise ConfigError(f"backwards takes one robot (.toml or a bundled name); got {len(args.files)}")
    spec: RobotSpec = spec_for(args.files[0])
    left_out: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    if args.to == "gc":
        write_published(published_from_robot(spec), args.output)
        notes = ("clips at the joints' largest efforts: a robot file has no torques seen in training",)
    else:
        left_out = write_kinematic(spec, args.output)
    about = {"robot": spec.name, "output": str(args.output), "left_out": list(left_out), "notes": list(notes)}
    if args.json:
        print_json(about)
        return 0
    out = console()
    out.print(f"{args.output}: {spec.name}", soft_wrap=True, markup=False)
    for text in (*(f"left out, the format has no place for it: {what}" for what in left_out), *notes):
        out.print(text, soft_wrap=True, markup=False)
    return 0


def _describe(found: Conversion, output: Path, *, written: bool) -> dict[str, Any]:
    """Everything as plain data."""
    spec = found.spec
    about: dict[str, Any] = {
        "robot": spec.name,
        "output": str(output),
        "written": written,
        "coordinates": list(spec.coordinate_names),
        "mass": sum(link.mass for link in spec.links),
        "elements": [element.name for element in spec.disturbances],
        "notes": list(found.notes),
        "flag": found.flag,
    }
    if found.published is not None:
        reports = [found.published.on_tilt(degrees) for degrees in TILTS]
        about["on_tilt"] = [
            {"tilt_deg": one.tilt_deg, "level": one.level, "change": one.change, "limit": one.limit} for one in reports
        ]
        about["level_only"] = found.published.on_tilt().sentence
    return about


def _show(found: Conversion, about: dict[str, Any]) -> None:
    from rich.markup import escape

    out = console()
    spec = found.spec
    out.print(f"{spec.name}: {len(spec.links)} links, {about['mass']:.4g} kg, {len(spec.disturbances)} elements",
              style="bold", soft_wrap=True, markup=False)  # fmt: skip
    for note in found.notes:
        out.print(note, soft_wrap=True, markup=False)
    if found.published is not None:
        out.print(f"\nLEVEL BASE ONLY: {about['level_only']}\n", soft_wrap=True, markup=False)
        headings = ("tilt deg", "level N m", "change N m", "limit N m")
        table = new_table("joint 2, tilted about the shoulder axis", *map(right, headings))
        for row in about["on_tilt"]:
            table.add_row("", f"{row['tilt_deg']:g}", *(fixed(row[key], 3) for key in ("level", "change", "limit")))
        out.print(table)
    if found.flag:
        out.print(f"[bold red]FLAGGED[/bold red]: {escape(found.flag)}", soft_wrap=True)
    out.print(f"written: {about['output']}" if about["written"] else "nothing written; --anyway writes it all the same",
              soft_wrap=True, markup=False)  # fmt: skip
