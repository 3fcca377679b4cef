"""``ravengc info``: what was understood of a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, console, print_json
from ravengc.cli.robot_options import coordinates_from

if TYPE_CHECKING:
    import argparse

    import ravengc

__all__ = ["add_parser", "run"]

ABOUT = """\
Print what was understood of a robot: its joints and limits, frames, masses,
coupling and transmission, and the source of every number. Without a robot, list
those that come with the package."""

EXAMPLES = """\
  ravengc info
  ravengc info raven2_gold --mass-set cad
  ravengc info my_arm.urdf --toml > my_arm.toml
  ravengc info rrbot --plot out/rrbot.png --q "30 deg" "-45 deg"
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``info`` to the command line."""
    parser = command_parser(subparsers, "info", "what was understood of a robot", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", nargs="?", help="bundled robot, or a .toml or .urdf file")
    parser.add_argument("--mass-set", metavar="NAME", help="which of the robot's mass sets (default: the file's own)")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the frames (.png, .svg, .pdf)")
    parser.add_argument(
        "--q",
        nargs="+",
        metavar="Q",
        help='pose of the picture: 0.3, "30 deg", "0.4 m" (default: zero, or mid-range where zero is out of range)',
    )
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print one JSON object instead of the tables")
    form.add_argument("--toml", action="store_true", help="print the robot as a robot file")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Print one robot, or the list of the bundled ones."""
    if args.robot is None:
        return _list(args)
    import ravengc

    robot = ravengc.load(args.robot, mass_set=args.mass_set)
    if args.plot is not None or args.q is not None:
        _plot(args, robot)
    _print(args, robot)
    return 0


def _list(args: argparse.Namespace) -> int:
    from ravengc.config import bundled_names, spec_for
    from ravengc.errors import ConfigError

    needing = {"--plot": args.plot, "--q": args.q, "--mass-set": args.mass_set, "--toml": args.toml}
    if given := [option for option, value in needing.items() if value]:
        raise ConfigError(
            f"{', '.join(given)} needs a robot: ravengc info ROBOT (bundled: {', '.join(bundled_names())})"
        )
    robots = [spec_for(name) for name in bundled_names()]
    if args.json:
        print_json({"robots": [{"name": robot.name, "description": robot.description.strip()} for robot in robots]})
        return 0
    from ravengc.cli.info_tables import list_table

    console().print(list_table(robots))
    return 0


def _plot(args: argparse.Namespace, robot: ravengc.Robot) -> None:
    from ravengc.errors import ConfigError
    from ravengc.reports.robot_facts import default_pose
    from ravengc.reports.robot_plot import plot_robot

    if args.plot is None:
        raise ConfigError("--q is the pose of the picture: give --plot FILE with it")
    q = coordinates_from(args.q, robot.spec) if args.q is not None else default_pose(robot.spec)
    plot_robot(args.plot, robot, q)


def _print(args: argparse.Namespace, robot: ravengc.Robot) -> None:
    import sys

    if args.toml:
        sys.stdout.write(robot.to_toml())
    elif args.json:
        from ravengc.reports.robot_facts import as_data

        print_json({**as_data(robot), "plot": None if args.plot is None else str(args.plot)})
    else:
        from ravengc.cli.info_tables import show_robot

        show_robot(console(), robot)
        if args.plot is not None:
            console().print(f"plot: {args.plot}", soft_wrap=True, markup=False)
