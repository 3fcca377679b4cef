"""``ravengc dvrk hold``: an arm held in MuJoCo by its computed gravity torques alone."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, console, fixed, new_table, print_json, right, waiting

if TYPE_CHECKING:
    import argparse

    from ravengc.dvrk import Holding

__all__ = ["add_parser", "run"]

ABOUT = """\
The dVRK page's check with a simulator: put an arm at any pose in MuJoCo and
send it the computed gravity torques, nothing else. No controller, no friction,
no damping: it stays if the torques are right. Beside it the same arm without
torques. On a tilted base gravity is what the base's accelerometer gives.

Coordinates that move no inertia (the page's masses are points) get rotors of
0.001 kg m^2, which no gravity torque feels."""

EXAMPLES = """\
  ravengc dvrk hold rrbot
  ravengc dvrk hold dvrk_mtmr --tilt "20 deg" --plot out/mtm.png
  ravengc dvrk hold rrbot_modified --q 0.3 0.5 --seconds 60 --json

exit code: 0 every pose held within 0.01 mm, 1 not, 2 bad input
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``dvrk hold`` to the command line."""
    parser = command_parser(subparsers, "hold", "an arm held in MuJoCo by computed torques alone", ABOUT, EXAMPLES)
    add = parser.add_argument
    add("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file")
    add("--mass-set", metavar="NAME", help="which of the robot's mass sets (default: the file's own)")
    add("--q", nargs="+", metavar="Q", help='one pose: 0.3, "30 deg" (default: random ones within the limits)')
    add("--poses", metavar="N", type=int, default=8, help="how many random poses (default: %(default)s)")
    add("--seconds", metavar="T", type=float, default=5.0, help="how long each is held (default: %(default)g)")
    add("--tilt", metavar="ANGLE", default="0 deg", help='of the base: "20 deg" (default: level)')
    add("--axis", choices=("x", "y", "z"), default="x", help="axis of the tilt, base axes (default: x)")
    add("--seed", type=int, default=0, help="seed of the poses (default: %(default)s)")
    add("--plot", type=Path, metavar="FILE", help="draw how far the tools moved (.png, .svg, .pdf)")
    add("--json", action="store_true", help="print one JSON object instead of the table")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Hold, print, draw; 1 if a pose was not held."""
    import ravengc
    from ravengc.cli.level_only import level_only_notes
    from ravengc.cli.robot_options import coordinates_from, tilt_angle
    from ravengc.dvrk import hold

    if args.plot is not None:
        from ravengc.reports.figures import check_picture

        check_picture(args.plot, "a picture of the arm that is held")
    robot = ravengc.load(args.robot, mass_set=args.mass_set)
    poses = None if args.q is None else [coordinates_from(args.q, robot.spec)]
    tilt = tilt_angle(args.tilt)
    notes = level_only_notes(robot.spec, tuple(ravengc.Gravity.tilted(tilt, args.axis)))
    with waiting("holding"):
        found = hold(
            robot,
            poses,
            count=args.poses,
            seconds=args.seconds,
            tilt_deg=math.degrees(tilt),
            axis=args.axis,
            seed=args.seed,
        )
    if args.plot is not None:
        from ravengc.reports.dvrk_hold_plot import plot_holding

        plot_holding(args.plot, found, robot.joint_names)
    print_json(describe(found) | {"notes": list(notes)}) if args.json else _show(found, notes, args.plot)
    return 0 if found.holds_all else 1


def describe(found: Holding) -> dict[str, Any]:
    """Everything as plain data, SI."""
    return {
        "robot": found.robot,
        "base": found.base,
        "seconds": found.seconds,
        "rotor_inertia": found.rotor_inertia,
        "held": found.holds_all,
        "poses": [
            {"q": one.q, "tau": one.tau, "drift": one.drift, "joint_drift": one.joint, "without_torques": one.fall}
            for one in found.holds
        ],
    }


def _show(found: Holding, notes: tuple[str, ...], plot: Path | None) -> None:
    out = console()
    out.print(f"{found.robot}, base {found.base}, {found.seconds:g} s a pose", style="bold", soft_wrap=True)
    if found.rotor_inertia:
        out.print(f"rotors of {found.rotor_inertia:g} kg m^2: the links alone have no inertia about every joint")
    table = new_table("q, rad or m", "torques, N m or N", *map(right, ("tool moved mm", "without torques mm")))
    for one in found.holds:
        q, tau = (" ".join(fixed(float(value), 3) for value in values) for values in (one.q, one.tau))
        table.add_row(q, tau, f"{1e3 * one.drift:.1e}", f"{1e3 * one.fall:.0f}")
    out.print(table)
    for note in notes:
        out.print(note, style="yellow", soft_wrap=True, markup=False)
    held = sum(one.stays for one in found.holds)
    out.print(f"{held} of {len(found.holds)} poses held within 0.01 mm by computed torques alone")
    if plot is not None:
        out.print(f"plot: {plot}", soft_wrap=True, markup=False)
