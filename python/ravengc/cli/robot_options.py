"""Options of commands that compute torques: which robot, what it carries, and which way gravity points."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from ravengc.cli.common import quantity
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    import ravengc
    from ravengc.spec import RobotSpec
    from ravengc.units import Dimension

__all__ = [
    "Vector",
    "add_gain_options",
    "add_gravity_options",
    "add_robot_options",
    "coordinates_from",
    "gravity_from",
    "robot_from",
    "tilt_angle",
    "tilted_gravity",
]

Vector = tuple[float, float, float]
TILT = re.compile(r"(?P<angle>.+?)\s+about\s+(?P<axis>[xyz])")


def add_robot_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--mass-set``, ``--payload``, ``--payload-com`` and ``--tool``."""
    group = parser.add_argument_group("robot")
    group.add_argument("--mass-set", metavar="NAME", help="which of the robot's mass sets (default: the file's own)")
    group.add_argument("--payload", metavar="MASS", help='what the tool carries: 0.7 (kg) or "700 g"')
    group.add_argument(
        "--payload-com",
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="its centre of mass in the tool frame (m; default 0 0 0)",
    )
    group.add_argument(
        "--tool",
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="move the tool frame's origin there, in the tip link's frame (m)",
    )


def robot_from(args: argparse.Namespace) -> ravengc.Robot:
    """The robot that the options describe; raises ConfigError and the errors of its file."""
    import ravengc

    robot = ravengc.load(args.robot, mass_set=args.mass_set)
    if args.tool:
        robot.set_tool(robot.spec.tool.rotation, _vector(args.tool, "length", "--tool"))
    if args.payload is not None:
        com = _vector(args.payload_com, "length", "--payload-com") if args.payload_com else (0.0, 0.0, 0.0)
        robot.set_payload(quantity(args.payload, "mass", "--payload"), com)
    elif args.payload_com:
        raise ConfigError("--payload-com needs --payload MASS")
    return robot


def add_gain_options(group: argparse._ArgumentGroup) -> None:
    """Add how PD gains are derived where they are not given."""
    add = group.add_argument
    add(
        "--natural-frequency",
        metavar="HZ",
        type=float,
        help="derive the PD gains from the mass matrix (default: published gains where known, else 5 Hz)",
    )
    add("--damping-ratio", metavar="ZETA", type=float, help="damping ratio of derived gains (default: 0.7)")


def add_gravity_options(parser: argparse.ArgumentParser) -> argparse._MutuallyExclusiveGroup:
    """Add ``--gravity`` and ``--tilt``, of which one may be given; returns their group for more of the kind."""
    group = parser.add_argument_group("gravity").add_mutually_exclusive_group()
    group.add_argument(
        "--gravity",
        nargs=3,
        metavar=("GX", "GY", "GZ"),
        help="gravity field in base axes (m/s^2; default: 0 0 -9.80665)",
    )
    group.add_argument(
        "--tilt", nargs="+", metavar="ANGLE", help='the base turned from level about one of its axes: "15 deg" about x'
    )
    return group


def gravity_from(args: argparse.Namespace) -> Vector:
    """The gravity field in base axes (m/s²); raises ConfigError and UnitsError.

    A base turned by R from level sees the level field g as Rᵀ g.
    """
    from ravengc import STANDARD_GRAVITY

    if args.gravity:
        return _vector(args.gravity, "acceleration", "--gravity")
    if not args.tilt:
        return (0.0, 0.0, -STANDARD_GRAVITY)
    return tilted_gravity(" ".join(args.tilt))


def tilted_gravity(text: str) -> Vector:
    """The gravity field in base axes (m/s²) on a base with a tilt such as ``15 deg about x``."""
    from ravengc import Gravity

    match = TILT.fullmatch(text.strip())
    if match is None:
        raise ConfigError(f'--tilt {text!r}: expected an angle and an axis, such as "15 deg" about x')
    x, y, z = Gravity.tilted(tilt_angle(match["angle"]), match["axis"])
    return x, y, z


def tilt_angle(text: str) -> float:
    """The tilt (rad); ConfigError for more than a turn, and for a number without a unit that is more than a quarter."""
    angle = quantity(text, "angle", "--tilt")
    most, words = (90.0, "90 degrees, in rad") if _is_number(text) else (360.0, "a turn")
    if abs(angle) > math.radians(most) + 1e-9:
        raise ConfigError(f'--tilt {text}: expected at most {words}; degrees carry their unit, such as "10deg"')
    return angle


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def coordinates_from(words: Sequence[str], robot: RobotSpec) -> list[float]:
    """Coordinates (rad, m) from the words of ``--q``, one per coordinate; commas may stand between them.

    Raises ConfigError for another number of values and UnitsError for a unit of the wrong kind.
    """
    from ravengc.coordinates import sliding
    from ravengc.messages import listed

    values = [value.strip() for word in words for value in word.split(",") if value.strip()]
    names = robot.coordinate_names
    if len(values) != len(names):
        raise ConfigError(
            f"--q has {len(values)} values, but {robot.name} has {len(names)} coordinates: {listed(names)}"
        )
    rows = zip(values, sliding(robot), names, strict=True)
    return [quantity(value, "length" if slides else "angle", f"--q {name}") for value, slides, name in rows]


def _vector(words: Sequence[str], dimension: Dimension, what: str) -> Vector:
    x, y, z = (quantity(word, dimension, what) for word in words)
    return x, y, z
