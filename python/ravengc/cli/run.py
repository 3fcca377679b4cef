"""``ravengc run``: a control loop against a simulated robot on a moving base."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, print_json, waiting
from ravengc.cli.robot_options import add_gain_options

if TYPE_CHECKING:
    from ravengc.cli.run_setup import Setup

__all__ = ["add_parser", "run"]

DESCRIPTION = """\
Run a control loop at a fixed rate against a simulated robot (MuJoCo) whose base
tilts, rocks or rides, with gravity from an accelerometer on the base. Prints
how punctual the loop was, how well the joints followed, and how much of the
torque the PD term had to give: with a good gravity term, little."""

EXAMPLES = """\
  ravengc run  # RAVEN II on a base that rocks 10 to 20 degrees at 1 Hz
  ravengc run --controller pd+sg --base tilt:20 --fast  # gravity taken as level
  ravengc run --robot panda --base rocking:-5:5:0.5 --plot out/panda.png
  ravengc run --base ship --duration 60 --fast  # roll, pitch and heave
  ravengc run --sensor 'serial:/dev/ttyUSB0?format=line' --policy strict
  ravengc run --robot my_arm.toml  # the sensor of its [accelerometer] table
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``run`` to the command line."""
    parser = command_parser(subparsers, "run", "control a simulated robot on a moving base", DESCRIPTION, EXAMPLES)
    parser.set_defaults(func=run)
    _add_robot_options(parser.add_argument_group("robot and controller"))
    _add_base_options(parser.add_argument_group("base and accelerometer"))
    _add_loop_options(parser.add_argument_group("loop and output"))


def _add_robot_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--robot", metavar="NAME|FILE", default="raven2_gold", help="bundled robot or robot file (default: %(default)s)"
    )
    add("--mass-set", metavar="NAME", help="which of the robot's mass sets (default: the file's own default)")
    add(
        "--controller",
        metavar="LAW",
        default="pd+dg",
        help="pd, pd+sg (static gravity), pd+dg (dynamic gravity), pd+bm (full motion of the base, by a gyro), "
        "passive (gravity alone); default: %(default)s",
    )
    add(
        "--motion",
        choices=("swing", "hold"),
        default="swing",
        help="slow swings about the middle of each joint's range, or hold that middle (passive always holds)",
    )
    add_gain_options(group)
    add(
        "--coulomb",
        metavar="F[,F...]",
        type=_numbers,
        default=0.0,
        help="Coulomb friction of the plant's joints, N m or N (default: none)",
    )
    add(
        "--viscous",
        metavar="D[,D...]",
        type=_numbers,
        default=0.0,
        help="viscous friction of the plant's joints, N m s or N s (default: none)",
    )


def _add_base_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--base",
        metavar="MOTION",
        default="rocking:10:20:1",
        help="level, tilt:DEG, rocking:LOW:HIGH:HZ (deg), ship or ship:ROLL:HZ:PITCH:HZ:HEAVE:HZ (deg, m), "
        "elevator:TRAVEL[:SPEED[:ACCELERATION[:JERK]]] (m), step:ACCELERATION:START:END (m/s^2 along --axis, s), "
        "recorded:FILE, a table of poses or of an inertial sensor (default: %(default)s)",
    )
    add(
        "--axis",
        metavar="x|y|z|X,Y,Z",
        type=_axis,
        help="axis of tilt, rocking and step, base axes (default: z of frame 0 where it is horizontal, else x)",
    )
    add(
        "--pivot",
        metavar="X,Y,Z",
        type=_vector,
        default=(0.0, 0.0, -0.3),
        help="point it rocks about, m, base axes (default: 0,0,-0.3)",
    )
    add(
        "--mount",
        metavar="MASS:HZ:ZETA[:D]",
        help="what the base stands on: its mass (kg), the frequency at which it swings with the arm on it, its damping "
        "ratio, directions such as y or x,ry (default: x,y,z); warns before the run if the arm could shake it, see "
        "ravengc stability --help",
    )
    add(
        "--sensor",
        metavar="KIND:ADDRESS",
        help="sim (the plant's own accelerometer), or a real or recorded one, such as serial:/dev/ttyUSB0?format=line, "
        "udp:14550?format=mavlink, replay:example:xio; see ravengc sensor --help (default: the one that the robot's "
        "file names in its [accelerometer] table, else sim)",
    )
    add(
        "--policy",
        choices=("paper", "strict"),
        help="what to do without a sensor that can be trusted: nominal or last value, or refuse, bleed and stop "
        "(default: the robot file's, else paper)",
    )
    add(
        "--cutoff",
        metavar="HZ",
        type=float,
        help="low-pass of the specific force (default: the robot file's, else none)",
    )
    add(
        "--sensor-place",
        metavar="X,Y,Z",
        type=_vector,
        help="sim: place of the accelerometer, m, base axes (default: the base origin)",
    )
    add(
        "--sensor-rate",
        metavar="HZ",
        type=float,
        help="sim: accelerometer samples per second (default: 100)",
    )
    add(
        "--noise",
        metavar="M/S2",
        type=float,
        help="sim: standard deviation of the accelerometer's noise (default: 0.02)",
    )
    add("--seed", metavar="N", type=_seed, help="sim: seed of the noise (default: 0)")


def _add_loop_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--duration", metavar="S", type=float, default=10.0, help="seconds of plant time (default: %(default)g)")
    add("--rate", metavar="HZ", type=float, default=1000.0, help="control cycles per second (default: %(default)g)")
    add("--fast", action="store_true", help="do not keep to the clock")
    add(
        "--log",
        metavar="FILE",
        type=Path,
        default=Path("out/run.npz"),
        help="record of every cycle, its columns named by joint, .npz or .csv (default: %(default)s)",
    )
    add("--plot", metavar="FILE", type=Path, help="draw base, gravity, torques and errors (.png, .svg, .pdf)")
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace) -> int:
    """Run the loop, write the log and the picture, print the summary.

    1 if the arm ran away, a fault was latched, or the law never had the base sensor that it takes gravity from.
    """
    with waiting(f"loading MuJoCo, the simulator, and {args.robot}"):
        setup = _prepared(args)

    from contextlib import closing

    import numpy as np

    from ravengc.cli.level_only import level_only_notes
    from ravengc.cli.run_mount import gravity_along, mount_warnings, warn
    from ravengc.cli.run_sensor import judge, wait_until_armable
    from ravengc.cli.run_tables import describe, show
    from ravengc.control import LAWS
    from ravengc.log import write_log
    from ravengc.reports.run_plot import plot_run
    from ravengc.reports.run_summary import summarise

    with np.errstate(all="ignore"), closing(setup.sensor):  # an arm that runs away is reported below, not warned about
        warnings = mount_warnings(args, setup)
        warn(warnings)
        notes = level_only_notes(setup.robot.spec, gravity_along(setup.base, args.duration))
        warn(notes)
        wait_until_armable(setup.sensor)
        record = setup.loop.run()
        remark = setup.sensor.remark
        setup.bar.close()
        summary = summarise(record, setup.sliding)
        is_used = LAWS[args.controller].gravity == "dynamic"
        verdicts, useless = judge(setup.sensor, summary.sensor_seconds, is_used=is_used)
    said = {"level_only_notes": list(notes), "sensor_remark": remark, "sensor_verdicts": verdicts}
    about = describe(args, setup, summary) | {"mount_warnings": list(warnings)} | said
    write_log(args.log, record.columns(), about, joints=setup.robot.joint_names)
    if args.plot is not None:
        plot_run(
            args.plot,
            record,
            setup.plant.base,
            title=about["title"],
            joints=setup.robot.joint_names,
            slides=setup.sliding,
        )
    if args.json:
        print_json(about)
    else:
        show(about, setup, summary)
    return 0 if summary.finite and not useless and not about["controller_counters"]["fault"] else 1


def _prepared(args: argparse.Namespace) -> Setup:
    """Everything that a run takes, after a look at whether its files can be written."""
    from ravengc.atomic import check_writable
    from ravengc.cli.run_setup import build
    from ravengc.log import check_log_path
    from ravengc.reports.figures import check_picture

    check_writable(check_log_path(args.log))
    if args.plot is not None:
        check_picture(args.plot, "a picture of the run")
    return build(args)


def _numbers(text: str) -> float | list[float]:
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number or numbers with commas between") from None
    return values[0] if len(values) == 1 else values


def _vector(text: str) -> list[float]:
    values = _numbers(text)
    if isinstance(values, float) or len(values) != 3:
        raise argparse.ArgumentTypeError(f"'{text}' is not three numbers with commas between, such as 0,0,-0.3")
    return values


def _seed(text: str) -> int:
    try:
        seed = int(text)
    except ValueError:
        seed = -1
    if seed < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 0")
    return seed


def _axis(text: str) -> str | list[float]:
    if text in {"x", "y", "z"}:
        return text
    try:
        return _vector(text)
    except argparse.ArgumentTypeError:
        raise argparse.ArgumentTypeError(f"'{text}' is not x, y, z or three numbers such as 0,0,1") from None
