"""``ravengc identify payload``: what a load weighs and where it sits, from one motion with it and without."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.markup import escape

from ravengc.cli.common import command_parser, console, fixed, new_table, plain, print_json, quantity, right
from ravengc.cli.identify_logs import ABOUT_LOGS, add_log_options, logs_from
from ravengc.cli.identify_refusal import refusing
from ravengc.cli.progress import steps

if TYPE_CHECKING:
    import argparse

    from ravengc.identify import Payload
    from ravengc.robot import Robot

__all__ = ["add_parser", "run"]

ABOUT = f"""\
Find the mass and the centre of mass of a load from two logs of the same motion
(or the same poses), without it and with it. The difference of the torques is
that of the load alone: friction and errors of the robot's file cancel.

{ABOUT_LOGS}

Errors of the drives' gains scale the mass, and nothing here shows them."""

EXAMPLES = """\
  ravengc identify payload ur5 example:ur5_unloaded example:ur5_loaded
  ravengc identify payload arm.toml empty.csv full.csv --lever 0.12 --json

exit code: 0 good, 1 refused, 2 bad input
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``identify payload`` to the command line."""
    parser = command_parser(subparsers, "payload", "mass and place of a load", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file")
    parser.add_argument("unloaded", metavar="UNLOADED", help="log of the motion without the load")
    parser.add_argument("loaded", metavar="LOADED", help="log of the same motion with it")
    _add_load_options(parser.add_argument_group("load"))
    add_log_options(parser)
    parser.add_argument_group("output").add_argument(
        "--json", action="store_true", help="print one JSON object instead"
    )
    parser.set_defaults(func=run)


def _add_load_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--link", metavar="NAME", help="link that carries it (default: the one with the tool)")
    place = group.add_mutually_exclusive_group()
    place.add_argument(
        "--com", nargs=3, metavar=("X", "Y", "Z"), help="where it sits, link frame, m: only its mass is sought"
    )
    place.add_argument("--lever", metavar="D", help="how far it is from the link frame's origin, m")
    add("--at", nargs="+", metavar="JOINT", help="joints whose torques count (default: all)")
    add("--tilt", action="append", default=[], metavar="TILT", help='how the base stood: level, "10 deg about x"')


def run(args: argparse.Namespace) -> int:
    """Identify the load and print it; 1 if the logs do not show it."""
    return refusing(args, _run)


def _run(args: argparse.Namespace) -> int:
    import ravengc
    from ravengc import identify

    robot = ravengc.load(args.robot)
    com = None if args.com is None else [quantity(word, "length", "--com") for word in args.com]
    lever = None if args.lever is None else quantity(args.lever, "length", "--lever")
    with steps("identifying the load", 3) as advance:
        logs = logs_from(args, robot, [args.unloaded, args.loaded], args.tilt, advance)
        motion = identify.Model(kind="dynamics")
        unloaded, loaded = (identify.prepared(one, motion) for one in logs)
        load = identify.payload(robot, unloaded, loaded, link=args.link, com=com, lever=lever, joints=args.at)
        advance("identified")
    about = _describe(args, robot, load, [f"{one.source}: {note}" for one in (unloaded, loaded) for note in one.notes])
    print_json(about) if args.json else _show(about)
    return 0


def _describe(args: argparse.Namespace, robot: Robot, load: Payload, notes: list[str]) -> dict[str, Any]:
    """The load as plain data, SI; its place also in the tool frame where the link carries that."""
    from ravengc.coordinates import sliding

    names, slides = robot.spec.coordinate_names, sliding(robot.spec)
    counted = [place for place, name in enumerate(names) if args.at is None or name in args.at]
    joints = [
        {
            "name": names[place],
            "unit": "N" if slides[place] else "N·m",
            "rms_difference": load.difference[row],
            "rms_left": load.rms[row],
        }
        for row, place in enumerate(counted)
    ]
    described: dict[str, Any] = plain(
        {
            "robot": robot.name,
            "logs": [args.unloaded, args.loaded],
            "notes": notes,
            "link": load.link,
            "mass": load.mass,
            "mass_sd": load.mass_sd,
            "com": load.com,
            "com_sd": load.com_sd,
            "com_in_tool": _in_tool(robot, load) if load.link == robot.tip else None,
            "condition": load.condition,
            "joints": joints,
        }
    )
    return described


def _in_tool(robot: Robot, load: Payload) -> Any:
    """The place of the load in the tool frame: Rᵀ (c - t)."""
    import numpy as np

    return np.array(robot.tool.rotation).T @ (load.com - np.array(robot.tool.translation))


def _show(about: dict[str, Any]) -> None:
    out = console()
    head = f"{about['robot']}: load on {about['link']} from {about['logs'][0]} and {about['logs'][1]}"
    out.print(head, style="bold", soft_wrap=True, markup=False)
    for note in about["notes"]:
        out.print(f"note: {note}", markup=False)
    table = new_table("", *map(right, ("found", "± formal")), "unit")
    table.add_row("mass", fixed(about["mass"], 4), fixed(about["mass_sd"], 4), "kg")
    for axis, place, sd in zip("xyz", about["com"], about["com_sd"], strict=True):
        table.add_row(f"centre of mass, {axis}", fixed(place, 4), fixed(sd, 4), "m")
    frame = f"in the frame of {escape(about['link'])}; condition {about['condition']:.3g}"
    table.caption = f"{frame}; an error of the drives' gains adds"
    out.print(table)
    joints = new_table("joint", "unit", *map(right, ("torque of the load, RMS", "left of it, RMS")))
    for joint in about["joints"]:
        joints.add_row(
            escape(joint["name"]), joint["unit"], fixed(joint["rms_difference"], 4), fixed(joint["rms_left"], 4)
        )
    out.print(joints)
    if about["com_in_tool"] is not None:
        place = " ".join(f"{value:.5g}" for value in about["com_in_tool"])
        out.print(f"for other commands: --payload {about['mass']:.5g} --payload-com {place}", soft_wrap=True)
