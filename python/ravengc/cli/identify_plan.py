"""``ravengc identify plan``: what to record, and how well the torques will be known, before anyone moves the robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, print_json
from ravengc.cli.identify_logs import add_count_option
from ravengc.cli.identify_model import add_model_options
from ravengc.cli.identify_refusal import refusing
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse

__all__ = ["add_parser", "run"]

ABOUT = """\
Plan what to record for an identification, and predict from the plan alone how
uncertain the torques will be that hold the robot on a tilted base: poses and
tilts of the base for masses, springs and cables, or a motion within limits for
friction and inertia. Beside it stands what as much would give on a level base.

With --predict FILE nothing is chosen: the poses of your own protocol are judged
(.csv, .npz: columns q1 q2 ..., and gx gy gz if the base tilts). A protocol that
trusts the torque of one joint in each file says so with --at.
Whether poses are free of collisions is not known here: try them slowly."""

EXAMPLES = """\
  ravengc identify plan dvrk_mtmr -o poses.csv --plot out/plan.png
  ravengc identify plan dvrk_mtmr --cable shoulder_pitch:0,1 --tilt 10deg \\
      --range shoulder_pitch=-11deg:16deg --poses 40
  ravengc identify plan panda --motion --model dynamics -o motion.csv
  ravengc identify plan arm.toml --predict our_protocol.csv
  ravengc identify plan arm.toml --predict j2.csv --at j2 \
      --predict j1.csv --at j1

exit code: 0 good, 1 no such plan, 2 bad input
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``identify plan`` to the command line."""
    parser = command_parser(subparsers, "plan", "what to record, and what it will be worth", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file")
    add_model_options(parser)
    _add_space_options(parser.add_argument_group("robot and base"))
    _add_choice_options(parser.add_argument_group("what is chosen"))
    _add_output_options(parser.add_argument_group("output"))
    parser.set_defaults(func=run)


def _add_space_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--tilt", metavar="ANGLE", default="10deg", help="how far the base can be tilted; 0: not (default: %(default)s)"
    )
    add("--attitudes", metavar="K", type=int, default=5, help="on how many tilts at most (default: %(default)s)")
    add("--used-to", metavar="ANGLE", help="tilt up to which it is predicted (default: that of --tilt, 10deg at least)")
    add(
        "--range",
        action="append",
        default=[],
        metavar="JOINT=LEAST:MOST",
        help="narrower than the joint's limits: elbow=-10deg:40deg; repeatable",
    )
    add(
        "--noise",
        metavar="TAU",
        default="0.01",
        help="standard deviation of the torque of a pose, or of a sample, N·m or N: one number, or one for every joint "
        "with commas between (default: %(default)s)",
    )


def _add_choice_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    kind = group.add_mutually_exclusive_group()
    kind.add_argument("--motion", action="store_true", help="a motion of a few harmonics, not poses")
    kind.add_argument(
        "--predict", metavar="FILE", action="append", help="choose nothing, judge these poses; repeatable"
    )
    add_count_option(group)
    add("--poses", metavar="N", type=int, default=30, help="on all tilts together (default: %(default)s)")
    add("--candidates", metavar="N", type=int, default=200, help="poses to choose from (default: %(default)s)")
    add("--period", metavar="T", default="20", help="of the motion (s; default: %(default)s)")
    add("--harmonics", metavar="L", type=int, default=5, help="of the motion (default: %(default)s)")
    add("--velocity", metavar="V", type=float, help="rad/s or m/s no joint exceeds (default: the robot's limits)")
    add("--acceleration", metavar="A", type=float, help="rad/s^2 or m/s^2 no joint exceeds")
    add("--rounds", metavar="N", type=int, default=600, help="length of the motion's search (default: %(default)s)")
    add("--seed", type=int, default=0, help="(default: %(default)s)")


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument("-o", "--out", type=Path, metavar="FILE", help="write it: what to play (.csv), or all (.toml)")
    group.add_argument("--plot", type=Path, metavar="FILE", help="draw uncertainty against tilt (.png, .svg, .pdf)")
    group.add_argument("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace) -> int:
    """Plan, print, write, draw; 1 if there is no such plan."""
    return refusing(args, _run)


def _run(args: argparse.Namespace) -> int:
    from ravengc.cli.identify_plan_setup import planned
    from ravengc.cli.identify_plan_tables import describe, show

    _check_outputs(args)
    found = planned(args)
    about = describe(args, found)
    if args.out is not None and found.plan is not None:
        found.plan.write(args.out)
    if args.plot is not None:
        from ravengc.reports.identify_plan_plot import plot_plan

        plot_plan(args.plot, found.curves, found.robot.spec, title=about["title"])
    print_json(about) if args.json else show(about)
    return 0


def _check_outputs(args: argparse.Namespace) -> None:
    """Refuse what could not be written, or counts for nothing, before anything is worked out."""
    if args.at and args.predict is None:
        raise ConfigError("--at is about torques of --predict FILE; a plan is for the torques of all joints")
    if args.plot is not None:
        from ravengc.reports.figures import check_picture

        check_picture(args.plot, "the picture of a plan")
    if args.out is None:
        return
    from ravengc.atomic import check_writable

    if args.predict is not None:
        raise ConfigError("--out has nothing to write: --predict judges poses that there are")
    if args.out.suffix.lower() not in {".csv", ".toml"}:
        raise ConfigError(f"--out {args.out}: expected a name ending in .csv or .toml")
    check_writable(args.out)
