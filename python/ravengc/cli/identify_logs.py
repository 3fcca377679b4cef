"""Options of ``ravengc identify`` about logs: what they are in, and how the base stood meanwhile; reading them."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, TypeVar

from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from ravengc.identify import Recording
    from ravengc.robot import Robot

T = TypeVar("T")

__all__ = ["ABOUT_LOGS", "add_count_option", "add_log_options", "check_output", "for_each", "logs_from"]

ABOUT_LOGS = """\
A LOG is a .csv, .txt or .tsv table, a NumPy .npz, a rosbag2 (.db3, .mcap or its
folder), a ROS 1 .bag, or example:NAME; torques are what the drives exert.
columns of a table:  t; q1 q2 ... or NAME_position; tau1 or NAME_effort; where
                     recorded dq1 or NAME_velocity; units: "q1 [deg]"
of the base:         gx gy gz (gravity, base axes) or ax ay az (what its
                     accelerometer reads); without them it stands level;
                     wx wy wz (its gyroscope, rad/s) where it turns quickly"""


def add_log_options(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add ``--units``, ``--joints``, ``--topic``, ``--rate`` and ``--strict``; their group."""
    group = parser.add_argument_group("logs")
    add = group.add_argument
    add(
        "--units",
        metavar="WORDS",
        default="",
        help="of the logs, with commas between: deg, mm, mNm, g, mg, deg/s, motor ... (default: SI, joints; checked)",
    )
    add("--joints", nargs="+", metavar="NAME", help="columns to take, in the robot's order (names, or numbers from 1)")
    add("--topic", help="JointState topic of a bag that has several")
    add("--rate", type=float, metavar="HZ", help="sample rate of a log without time stamps")
    add("--strict", action="store_true", help="refuse a log with a row that would be left out")
    return group


def add_count_option(group: argparse._ArgumentGroup) -> None:
    """Add ``--at``."""
    group.add_argument(
        "--at",
        action="append",
        nargs="+",
        default=[],
        metavar="JOINT",
        help="joints whose torques count (default: all); repeated: one --at for every log",
    )


def logs_from(
    args: argparse.Namespace,
    robot: Robot,
    sources: Sequence[str],
    tilts: Sequence[str] = (),
    advance: Callable[[str], None] = lambda _: None,
    *,
    counted: Sequence[Sequence[str]] = (),
    sensor_axes: bool = False,
) -> list[Recording]:
    """The logs, read and checked; ``tilts`` are texts, and ``counted`` joints, for all of them, one for each, or none.

    ``advance`` is called with each log's name when it is read; ``sensor_axes`` as in ``read_log``.
    """
    stood, joints = for_each(tilts, len(sources), "--tilt"), for_each(counted, len(sources), "--at")
    found = []
    for source, tilt, names in zip(sources, stood, joints, strict=True):
        found.append(_log(args, robot, source, tilt, names, sensor_axes=sensor_axes))
        advance(source)
    return found


def for_each(given: Sequence[T], count: int, option: str) -> list[T | None]:
    """What was said once for all logs, once for each, or not at all; ConfigError for another number."""
    if len(given) not in {0, 1, count}:
        raise ConfigError(f"{len(given)} x {option} for {count} logs; expected one for all, or one for each")
    return list(given) if len(given) == count else [given[0] if given else None] * count


def _log(
    args: argparse.Namespace,
    robot: Robot,
    source: str,
    tilt: str | None,
    counted: Sequence[str] | None,
    *,
    sensor_axes: bool,
) -> Recording:
    from ravengc.identify import read_log

    return read_log(
        robot,
        source,
        tuple(word.strip() for word in args.units.split(",") if word.strip()),
        topic=args.topic,
        joints=args.joints,
        rate_hz=args.rate,
        gravity=None if tilt is None else _field(tilt),
        counted=counted,
        sensor_axes=sensor_axes,
        strict=args.strict,
    )


def _field(text: str) -> tuple[float, float, float]:
    """The gravity field on a base with this tilt: ``level`` or ``15 deg about x``."""
    from ravengc.cli.robot_options import tilted_gravity

    return tilted_gravity("0 about x" if text.strip() == "level" else text)


def check_output(path: Path, option: str, sources: Sequence[str]) -> None:
    """Raise ConfigError if a file cannot be written there, or would overwrite a log."""
    from ravengc.atomic import check_writable

    check_writable(path)
    for source in sources:
        if os.path.realpath(path) == os.path.realpath(source):
            raise ConfigError(f"{option} {path} would overwrite a log; choose another name")
