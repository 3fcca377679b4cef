"""``ravengc calibrate``: bias, scale, mounting and place of a base accelerometer, written into the robot's file."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, print_json, quantity
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse

    from ravengc.calibration import ImuRecording, StillLimits
    from ravengc.calibration.block import AccelerometerBlock
    from ravengc.calibration.imu import FloatArray
    from ravengc.cli.calibrate_source import Ask, OpenSensor

__all__ = ["add_parser", "run"]

SUMMARY = "bias, scale, mounting and place of a base accelerometer"

ABOUT = """\
Calibrate a base accelerometer from positions in which it lies still. SOURCE is
a recording (.csv, .npz, replay:FILE?key=value, example:xio), or a live sensor,
KIND:ADDRESS, for which you are asked to show one position after the other.

methods
  six        every axis once up and once down: bias and scale
  ellipsoid  12 or more free positions, 60 degrees or more around: bias, scale
             and misalignment; with --tilts the mounting rotation too
  tilts      the base at known tilts: bias and mounting rotation
  lever-arm  the base rocked about a fixed point, with a gyroscope: the place
             of the sensor. Takes bias, scale and mounting from --robot
  auto       six, ellipsoid or tilts, as the positions allow (the default)

A tilt is ROLL,PITCH: the base turned about its x axis, then about the
horizontal that is y when level; "10deg,0deg 0deg,10deg", or a file with one
per line. Exit code 1 means that the result is too poor to be written."""

EXAMPLES = """\
  ravengc calibrate accelerometer positions.csv --robot arm.toml --write
  ravengc calibrate accelerometer log.csv --unit g --columns t ax ay az
  ravengc calibrate accelerometer tilted.csv --tilts 0,0 15deg,0 0,15deg
  ravengc calibrate accelerometer rocked.npz --method lever-arm --robot arm.toml
  ravengc calibrate accelerometer "serial:/dev/ttyUSB0?format=line"
"""

METHODS = ("auto", "six", "ellipsoid", "tilts", "lever-arm")
UNITS = ("m/s^2", "g", "mg", "cm/s^2")
RATE_UNITS = ("rad/s", "mrad/s", "deg/s")
HALF_TURN = 3.1416


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``calibrate``, with what can be calibrated below it, to the command line."""
    parser = command_parser(subparsers, "calibrate", f"calibrate a sensor: {SUMMARY}", SUMMARY, EXAMPLES)
    inner = parser.add_subparsers(metavar="WHAT", required=True)
    accelerometer = command_parser(inner, "accelerometer", SUMMARY, ABOUT, EXAMPLES)
    accelerometer.add_argument("source", metavar="SOURCE", help="recording, example:xio, or a sensor KIND:ADDRESS")
    _add_method_options(accelerometer.add_argument_group("method"))
    _add_recording_options(accelerometer.add_argument_group("recording"))
    _add_still_options(accelerometer.add_argument_group("what counts as still"))
    _add_output_options(accelerometer.add_argument_group("output"))
    accelerometer.set_defaults(func=run)


def _add_method_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--method", choices=METHODS, metavar="M", default="auto", help="one of those above (default: auto)")
    add("--tilts", nargs="+", metavar="T", help="ROLL,PITCH of every position in order, or a file of them")
    add("--pivot", nargs=3, metavar=("X", "Y", "Z"), help="point that stays put, base axes (lever-arm; default 0 0 0)")
    add("--local-gravity", metavar="G", default="9.80665", help="g where you are (m/s^2; default: %(default)s)")


def _add_recording_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--unit", choices=UNITS, help="unit of the accelerometer (default: as the header says, else m/s^2; checked)")
    add("--gyro-unit", choices=RATE_UNITS, help="unit of the gyroscope (default: as the header says, else rad/s)")
    add(
        "--columns",
        nargs="+",
        metavar="C",
        help="names, or numbers from 1, of [time] x y z [gyro x y z] (default: by their names)",
    )
    add("--rate", type=float, metavar="HZ", help="sample rate of a recording without time stamps")
    add(
        "--sends",
        choices=("specific_force", "gravity"),
        help="what the sensor gives: +1 g along up at rest, or -1 g (default: specific_force)",
    )


def _add_still_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--still-force", metavar="A", default="0.05", help="largest standard deviation (m/s^2; default: %(default)s)")
    add("--still-rate", metavar="W", default="0.02", help="largest turning rate (rad/s; default: %(default)s)")
    add("--still-time", metavar="T", default="1", help="shortest rest (s; default: %(default)s)")


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--robot", type=Path, metavar="FILE", help="robot file (.toml) whose table [accelerometer] is meant")
    add("--write", action="store_true", help="write the result into that table; the rest of the file stays as it is")
    add("--plot", type=Path, metavar="FILE", help="draw positions, fit and residuals (.png, .svg, .pdf)")
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace, open_sensor: OpenSensor | None = None, ask: Ask | None = None) -> int:
    """Calibrate, print, draw and write; 1 if the result is too poor.

    ``open_sensor`` opens the sensor of an address and ``ask`` puts a question to the user and returns the answer.
    """
    from ravengc.calibration import read_block
    from ravengc.calibration.block import AccelerometerBlock

    _check_outputs(args)
    has_file = args.robot is not None and args.robot.exists()
    block = (read_block(args.robot) if has_file else None) or AccelerometerBlock()
    if args.method == "lever-arm":
        return _lever_arm(args, block, open_sensor, ask or _ask)
    return _positions(args, block, open_sensor, ask or _ask)


def _check_outputs(args: argparse.Namespace) -> None:
    """Refuse what could not be written, before anything is read."""
    from ravengc.atomic import check_writable
    from ravengc.reports.figures import check_picture

    if args.write and args.robot is None:
        raise ConfigError("--write needs --robot FILE: the file to write to")
    if args.robot is not None:
        _check_robot(args.robot, is_written=args.write)
    if args.write:
        check_writable(args.robot)
    if args.plot is not None:
        check_picture(args.plot, "a picture of the calibration")
    if args.method == "lever-arm" and args.tilts:
        raise ConfigError("--tilts say how the base lay still; the method lever-arm takes none")
    if args.method != "lever-arm" and args.pivot:
        raise ConfigError("--pivot belongs to the method lever-arm")


def _check_robot(path: Path, *, is_written: bool) -> None:
    from ravengc.config import bundled_names

    if path.suffix.lower() == ".toml":
        if is_written or os.path.exists(path):  # noqa: PTH110 -- false also for a name that is too long
            return
        raise ConfigError(f"--robot {path}: no such file; with --write it would be made")
    name = str(path)
    copy = (
        f"; copy the bundled robot first: ravengc info {name} --toml > {name}.toml" if name in bundled_names() else ""
    )
    raise ConfigError(f"--robot {name}: expected a file ending in .toml{copy}")


def _positions(args: argparse.Namespace, block: AccelerometerBlock, open_sensor: OpenSensor | None, ask: Ask) -> int:
    from ravengc.calibration import calibrate_accelerometer
    from ravengc.cli.calibrate_source import measured
    from ravengc.cli.calibrate_tables import describe, show
    from ravengc.reports.calibration_plot import plot_calibration

    gravity = quantity(args.local_gravity, "acceleration", "--local-gravity")
    tilts = _tilts(args.tilts, gravity) if args.tilts else None
    limits = _limits(args)
    outcome = calibrate_accelerometer(
        measured(args, block, limits, 0 if tilts is None else len(tilts), open_sensor, ask),
        args.method,
        tilts=tilts,
        correction=block.correction,
        declared=block.rotation if "rotation" in block.given else None,
        limits=limits,
        gravity=gravity,
    )
    good = outcome.calibration.good
    if args.plot is not None:
        plot_calibration(args.plot, outcome, gravity)
    about = describe(args, outcome) | _written(args, outcome.block(), good=good)
    print_json(about) if args.json else show(about, outcome)
    return 0 if good else 1


def _lever_arm(args: argparse.Namespace, block: AccelerometerBlock, open_sensor: OpenSensor | None, ask: Ask) -> int:
    from ravengc.calibration import fit_lever_arm
    from ravengc.cli.calibrate_source import rocked
    from ravengc.cli.calibrate_tables import describe_lever_arm, show_lever_arm
    from ravengc.reports.calibration_plot import plot_lever_arm

    recording = rocked(args, block, open_sensor, ask)
    if recording.angular_velocity is None:
        raise ConfigError(f"{recording.source}: no angular velocity; the method lever-arm takes a gyroscope")
    force, rate = _in_base_axes(recording, block)
    found = fit_lever_arm(
        recording.t,
        force,
        rate,
        pivot=[quantity(word, "length", "--pivot") for word in args.pivot or ("0", "0", "0")],
        gravity=quantity(args.local_gravity, "acceleration", "--local-gravity"),
    )
    if args.plot is not None:
        plot_lever_arm(args.plot, found)
    about = describe_lever_arm(args, recording, found) | _written(
        args, {"position": found.position.tolist()}, good=found.good
    )
    print_json(about) if args.json else show_lever_arm(about, found)
    return 0 if found.good else 1


def _in_base_axes(recording: ImuRecording, block: AccelerometerBlock) -> tuple[FloatArray, FloatArray]:
    """R S (s - bias) and R (w - gyro bias), checked against g first."""
    import numpy as np

    from ravengc.calibration.imu import check_unit

    check_unit(recording)
    rotation, correction = np.array(block.rotation), np.array(block.correction)
    rates = recording.angular_velocity
    force = (recording.specific_force - np.array(block.bias)) @ (rotation @ correction).T
    return force, (np.zeros_like(force) if rates is None else rates - np.array(block.gyro_bias)) @ rotation.T


def _written(args: argparse.Namespace, values: dict[str, Any], *, good: bool) -> dict[str, Any]:
    """Write what was found if that was asked for and it is good, and say so."""
    from ravengc.calibration import write_block

    if args.write and good:
        write_block(args.robot, values)
    return {"accelerometer": values, "written": str(args.robot) if args.write and good else None}


def _limits(args: argparse.Namespace) -> StillLimits:
    from ravengc.calibration import StillLimits

    return StillLimits(
        force=quantity(args.still_force, "acceleration", "--still-force"),
        rate=quantity(args.still_rate, "angular velocity", "--still-rate"),
        shortest_s=quantity(args.still_time, "time", "--still-time"),
    )


def _tilts(words: list[str], gravity: float) -> list[FloatArray]:
    """The specific forces of the tilts on the command line, or in a file."""
    from ravengc.calibration import tilted_force

    lines = words if len(words) > 1 or "," in words[0] else _lines(Path(words[0]))
    found = []
    for number, line in enumerate(lines, start=1):
        angles = [quantity(word.strip(), "angle", f"tilt {number}") for word in line.split(",")]
        if len(angles) != 2:
            raise ConfigError(f"tilt {number}: {line!r} is not ROLL,PITCH, such as 10deg,0deg")
        if max(map(abs, angles)) > HALF_TURN:
            raise ConfigError(f"tilt {number}: {line!r} is more than half a turn; degrees carry their unit: 15deg")
        found.append(tilted_force(angles[0], angles[1], gravity))
    return found


def _lines(path: Path) -> list[str]:
    """Lines of a text file that are neither empty nor comments."""
    from ravengc.config.files import decode, read_bytes

    text = decode(read_bytes(path), str(path))
    return [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]


def _ask(question: str) -> str:
    """Put a question on standard error and wait for a line; ConfigError where nobody can answer."""
    sys.stderr.write(f"{question}: ")
    sys.stderr.flush()
    answer = sys.stdin.readline() if sys.stdin is not None else ""
    if not answer:
        raise ConfigError("nobody answers: the input ended; run it in a terminal, or calibrate from a recording")
    return answer.strip()
