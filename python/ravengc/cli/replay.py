"""``ravengc replay``: computed torques along a recorded motion, against the measured ones."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, print_json, waiting
from ravengc.cli.robot_options import add_gravity_options, add_robot_options, gravity_from, robot_from

if TYPE_CHECKING:
    import argparse

    import numpy.typing as npt

    import ravengc
    from ravengc.recordings import Recording
    from ravengc.replay import Replay

__all__ = ["add_parser", "run"]

ABOUT = """\
Compute the gravity torque (or the full inverse dynamics) along a recorded
motion, with the robot's cables, springs and friction where its file has such
elements, and compare it with what was measured. LOG is a .csv, .txt or .tsv
table, a NumPy .npz, a rosbag2 (.db3, .mcap or its folder), a ROS 1 .bag, or a
bundled recording: example:panda, example:mtmr_level, example:mtmr_tilts,
example:ur5_unloaded, example:ur5_loaded.

columns of a table:  t or time; q1 q2 ... or NAME_position; dq1 or
                     NAME_velocity; tau1 or NAME_effort; units: "q1 [deg]"
arrays of an .npz:   t, q and, where recorded, qd, qdd, tau, gravity
Rows with missing numbers and repeated time stamps are left out and counted."""

EXAMPLES = """\
  ravengc replay panda example:panda
  ravengc replay panda example:panda --model full --plot out/panda.png
  ravengc replay my_arm.toml motion.csv --angle-unit deg --out torques.csv
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``replay`` to the command line."""
    parser = command_parser(subparsers, "replay", "computed against measured torques of a recording", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file")
    parser.add_argument("log", metavar="LOG", help="recording, or example:NAME")
    _add_model_options(parser.add_argument_group("model"))
    add_robot_options(parser)
    add_gravity_options(parser).add_argument(
        "--recorded-gravity", action="store_true", help="the gravity vector of every sample, as the recording has it"
    )
    _add_log_options(parser.add_argument_group("recording"))
    _add_output_options(parser.add_argument_group("output"))
    parser.set_defaults(func=run)


def _add_model_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--model",
        choices=("gravity", "full"),
        default="gravity",
        help="gravity alone, or inverse dynamics (default: gravity)",
    )
    group.add_argument(
        "--window", type=float, metavar="S", help="seconds over which accelerations are fitted (full; default: 0.25)"
    )
    group.add_argument("--threads", type=int, default=1, metavar="N", help="threads for the computation (default: 1)")


def _add_log_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--joints", nargs="+", metavar="NAME", help="columns to take, in the robot's order (names, or numbers from 1)"
    )
    group.add_argument("--topic", help="JointState topic of a bag that has several")
    group.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="sample rate of a recording without time stamps (an error where it has some)",
    )
    group.add_argument(
        "--angle-unit",
        choices=("auto", "rad", "deg"),
        default="auto",
        help="unit of turning joints (default: rad, checked)",
    )
    group.add_argument(
        "--length-unit",
        choices=("auto", "m", "mm"),
        default="auto",
        help="unit of sliding joints (default: m, checked)",
    )
    group.add_argument(
        "--shaft",
        choices=("joint", "motor"),
        default="joint",
        help="where it was measured: motor goes through the robot's transmission",
    )
    group.add_argument("--strict", action="store_true", help="refuse a recording with a row that would be left out")


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw measured, predicted and residual torques (.png, .svg, .pdf)"
    )
    group.add_argument("--out", type=Path, metavar="FILE", help="write the predicted torques (.csv, .npz)")
    group.add_argument(
        "--fail-above", type=float, metavar="E", help="exit with 1 if the overall relative error is above E"
    )
    group.add_argument("--json", action="store_true", help="print one JSON object instead of the table")


def run(args: argparse.Namespace) -> int:
    """Replay, print, and write what was asked for; 1 if the error is above ``--fail-above``."""
    from ravengc.cli.replay_tables import describe, show

    _check_outputs(args)
    robot = robot_from(args)
    replayed = _replay(args, robot)
    failed = args.fail_above is not None and _overall_error(args, replayed) > args.fail_above
    about = describe(args, robot, replayed)
    _write_files(args, replayed, about)
    print_json(about) if args.json else show(about, replayed)
    if failed:
        sys.stderr.write(f"the overall relative error is above --fail-above {args.fail_above:g}\n")
    return 1 if failed else 0


def _check_outputs(args: argparse.Namespace) -> None:
    """Refuse what could not be written or judged, before anything is read."""
    from ravengc.atomic import check_writable
    from ravengc.errors import ConfigError
    from ravengc.log import check_log_path
    from ravengc.reports.figures import check_picture

    if args.out is not None:
        check_writable(check_log_path(args.out))
        if os.path.realpath(args.out) == os.path.realpath(args.log):
            raise ConfigError(f"--out {args.out} would overwrite the recording; choose another name")
    if args.plot is not None:
        check_picture(args.plot, "a picture of the replay")
    if args.fail_above is not None and not args.fail_above >= 0.0:
        raise ConfigError(f"--fail-above {args.fail_above}: expected a relative error, 0 or more")


def _replay(args: argparse.Namespace, robot: ravengc.Robot) -> Replay:
    from ravengc.cli.level_only import level_only_notes
    from ravengc.errors import ConfigError
    from ravengc.replay import DEFAULT_SPAN, replay

    gravity: npt.ArrayLike = gravity_from(args)
    recording = _recording(args, robot)
    if args.recorded_gravity:
        if recording.gravity is None:
            raise ConfigError(f"{args.log} has no gravity columns (gx gy gz or gravity_0 gravity_1 gravity_2)")
        gravity = recording.gravity
    elif recording.gravity is not None:
        recording = recording.with_notes("every sample has a gravity vector of its own: --recorded-gravity uses it")
    recording = recording.with_notes(*level_only_notes(robot.spec, gravity))
    span = DEFAULT_SPAN if args.window is None else args.window
    return replay(robot, recording, model=args.model, gravity=gravity, span=span, threads=args.threads)


def _overall_error(args: argparse.Namespace, replayed: Replay) -> float:
    from ravengc.errors import ConfigError

    if replayed.overall_error is None:
        raise ConfigError(f"{args.log} has no measured torques other than zero: --fail-above has nothing to judge")
    return replayed.overall_error


def _recording(args: argparse.Namespace, robot: ravengc.Robot) -> Recording:
    from ravengc.recordings import fit_to_robot, joint_side, read_recording

    names = args.joints or robot.joint_names
    with waiting(f"reading {args.log}"):
        recording = read_recording(args.log, topic=args.topic, joints=names, rate_hz=args.rate, strict=args.strict)
    if args.shaft == "motor":
        return joint_side(recording, robot, joints=args.joints)
    units = {"angle_unit": args.angle_unit, "length_unit": args.length_unit}
    return fit_to_robot(recording, robot.spec, joints=args.joints, **units)


def _write_files(args: argparse.Namespace, replayed: Replay, about: dict[str, Any]) -> None:
    if args.out is not None:
        from ravengc.log import write_log

        recording = replayed.recording
        measured = {} if recording.tau is None else {"tau": recording.tau}
        columns = {"t": recording.t, "q": recording.q, **measured, "tau_predicted": replayed.predicted}
        write_log(args.out, columns, about, joints=replayed.names)
    if args.plot is not None:
        from ravengc.reports.replay_plot import plot_replay

        plot_replay(args.plot, replayed)
