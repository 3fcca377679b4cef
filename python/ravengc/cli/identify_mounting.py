"""``ravengc identify mounting``: how the base's accelerometer is turned, and its bias, from the arm's own torques."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, console, fixed, new_table, plain, print_json, quantity, right
from ravengc.cli.identify_logs import ABOUT_LOGS, add_log_options, logs_from
from ravengc.cli.identify_refusal import refusing
from ravengc.cli.progress import steps
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse

    from rich.table import Table

    from ravengc.identify import MountingFit

__all__ = ["add_parser", "run"]

ABOUT = f"""\
Find how the base's accelerometer is turned against the base, and its bias, from
the torques that hold the arm in poses on a tilted base: no inclinometer needed.
The columns ax ay az are the sensor's own readings in its own axes. A sensor
that was tilted too little, or about one axis only, is refused.

{ABOUT_LOGS}"""

EXAMPLES = """\
  ravengc identify mounting dvrk_mtmr example:mtmr_tilts
  ravengc identify mounting arm.toml poses.csv --write arm.toml

exit code: 0 good, 1 refused, 2 bad input
"""
SOUGHT = ("rotation", "bias")
SCALE = (
    "--find scale: torques do not show the scale of the sensor (twice the force and half of all masses are the same"
    " torques); turn every axis of the sensor once up and once down, at rest, and calibrate it from that:"
    " ravengc calibrate accelerometer LOG --method six"
)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``identify mounting`` to the command line."""
    parser = command_parser(subparsers, "mounting", "rotation and bias of the base's accelerometer", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file")
    parser.add_argument("log", metavar="LOG", help="poses at rest with torques and the sensor's readings")
    group = parser.add_argument_group("fit")
    group.add_argument(
        "--find", metavar="WHAT", default="rotation,bias", help="what is sought (default: %(default)s, which is all)"
    )
    group.add_argument("--noise", metavar="A", default="0.02", help="of a reading, m/s^2 (default: %(default)s)")
    add_log_options(parser)
    output = parser.add_argument_group("output")
    output.add_argument(
        "--write", type=Path, metavar="FILE", help="robot file (.toml) whose table [accelerometer] is set"
    )
    output.add_argument("--json", action="store_true", help="print one JSON object instead")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Find, print, and write what was asked for; 1 if the tilts do not show it."""
    return refusing(args, _run)


def _run(args: argparse.Namespace) -> int:
    import ravengc
    from ravengc import identify

    _check(args)
    robot = ravengc.load(args.robot)
    noise = quantity(args.noise, "acceleration", "--noise")
    with steps("finding the mounting", 2) as advance:
        log = logs_from(args, robot, [args.log], (), advance, sensor_axes=True)[0]
        poses = identify.prepared(log, identify.Model())
        found = identify.mounting(robot, poses, noise=noise)
        advance("found")
    about = _describe(args, found, poses.notes)
    if args.write is not None and not found.warnings:
        from ravengc.calibration import write_block

        write_block(args.write, {"rotation": found.rotation, "bias": found.bias})
        about["written"] = str(args.write)
    print_json(about) if args.json else _show(about)
    return 1 if found.warnings else 0


def _check(args: argparse.Namespace) -> None:
    words = [word.strip() for word in args.find.split(",")]
    if "scale" in words:
        raise ConfigError(SCALE)
    if sorted(words) != sorted(SOUGHT):
        raise ConfigError(f"--find {args.find}: expected {','.join(SOUGHT)}; they are found together")
    if args.write is not None:
        from ravengc.atomic import check_writable

        check_writable(args.write)


def _describe(args: argparse.Namespace, found: MountingFit, notes: tuple[str, ...]) -> dict[str, Any]:
    described: dict[str, Any] = plain(
        {
            "robot": args.robot,
            "log": args.log,
            "notes": notes,
            "rotation": found.rotation,
            "rotation_sd": found.rotation_sd,
            "bias": found.bias,
            "bias_sd": found.bias_sd,
            "scale": found.scale,
            "condition": found.condition,
            "rms": found.rms,
            "refused": "; ".join(found.warnings) or None,
            "written": None,
        }
    )
    return described


def _show(about: dict[str, Any]) -> None:
    out = console()
    out.print(f"{about['robot']}: mounting of the sensor in {about['log']}", style="bold", soft_wrap=True, markup=False)
    for note in about["notes"]:
        out.print(f"note: {note}", markup=False)
    out.print(_rotation_table(about))
    table = new_table("bias", *map(right, ("m/s²", "±")))
    for axis, bias, sd in zip("xyz", about["bias"], about["bias_sd"], strict=True):
        table.add_row(f"sensor {axis}", fixed(bias, 4), fixed(sd, 4))
    table.caption = f"condition {about['condition']:.3g}; readings without it over g: {about['scale']:.4f}"
    out.print(table)
    if about["refused"] is not None:
        out.print(f"refused: {about['refused']}", style="bold red", soft_wrap=True, markup=False)
    if about["written"] is not None:
        out.print(f"written: {about['written']}", soft_wrap=True, markup=False)


def _rotation_table(about: dict[str, Any]) -> Table:
    """Columns of the rotation as rows: where the sensor's axes point in the base."""
    table = new_table("rotation", *map(right, ("base x", "base y", "base z")))
    for column, axis in enumerate("xyz"):
        table.add_row(f"sensor {axis}", *(fixed(row[column], 5) for row in about["rotation"]))
    table.add_section()
    table.add_row("± about it, deg", *(fixed(math.degrees(sd), 3) for sd in about["rotation_sd"]))
    return table
