"""Options of commands about an identification's model: what acts in the joints beside the links' masses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc.cli.common import quantity
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse

    from ravengc.identify import Element, Model
    from ravengc.robot import Robot

__all__ = ["add_model_options", "model_from"]

KINDS = ("gravity", "gravity+friction", "dynamics")
CABLE_DEGREES = "0,1,2,3"


def add_model_options(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add ``--model`` and the options of what acts in the joints; their group."""
    group = parser.add_argument_group("model")
    add = group.add_argument
    add("--model", choices=KINDS, default="gravity", help="what is sought (default: %(default)s)")
    add(
        "--friction",
        metavar="TERMS",
        help="terms along every joint with commas between: coulomb, viscous, offset, quadratic, stribeck, cubic_root; "
        "or none (default: coulomb,viscous,offset but for gravity)",
    )
    add("--width", metavar="V", default="0", help="speed over which Coulomb's step is rounded, rad/s or m/s")
    add("--rotor", action="store_true", help="the reflected inertia of every joint's rotor too")
    add(
        "--disturbances",
        action="store_true",
        help="seek the coefficients of the robot file's own [[disturbance]] elements too (otherwise they are known)",
    )
    add(
        "--cable",
        action="append",
        default=[],
        metavar="JOINT[:DEGREES]",
        help="a cable or spring along a joint, a polynomial of its position (default degrees: 0,1,2,3); repeatable",
    )
    add(
        "--hysteresis",
        action="append",
        default=[],
        metavar="JOINT:DISTANCE",
        help="friction that gives over this distance before it slips: elbow:1deg; repeatable",
    )
    return group


def model_from(args: argparse.Namespace, robot: Robot) -> Model:
    """The model that the options describe; ConfigError for joints and terms that there are not."""
    from ravengc import identify

    terms = None if args.friction is None else _words(args.friction)
    elements = (
        *(_cable(text, robot) for text in args.cable),
        *(_hysteresis(text, robot) for text in args.hysteresis),
    )
    model = identify.Model(
        kind=args.model,
        friction=() if terms == ("none",) else terms,
        width=quantity(args.width, "angular velocity", "--width"),
        rotor=args.rotor,
        elements=elements,
        disturbances=args.disturbances,
    )
    model.columns(robot.spec)  # refuses unknown terms
    return model


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip())


def _cable(text: str, robot: Robot) -> Element:
    from ravengc import identify

    joint, _, degrees = text.partition(":")
    _check_joint(joint, robot, "--cable")
    try:
        powers = [int(word) for word in _words(degrees or CABLE_DEGREES)]
    except ValueError:
        raise ConfigError(f"--cable {text!r}: expected degrees with commas between, such as {joint}:0,1,2") from None
    return identify.polynomial(joint, powers)


def _hysteresis(text: str, robot: Robot) -> Element:
    from ravengc import identify
    from ravengc.coordinates import sliding

    joint, colon, distance = text.partition(":")
    place = _check_joint(joint, robot, "--hysteresis")
    if not colon:
        raise ConfigError(f"--hysteresis {text!r}: expected JOINT:DISTANCE, such as {joint}:1deg")
    slides = bool(sliding(robot.spec)[place])
    return identify.hysteresis(joint, (quantity(distance, "length" if slides else "angle", f"--hysteresis {joint}"),))


def _check_joint(joint: str, robot: Robot, option: str) -> int:
    """Its place; ConfigError for a joint that the robot does not have."""
    from ravengc.messages import did_you_mean, listed, shown

    names = robot.spec.coordinate_names
    if joint not in names:
        near = did_you_mean(joint, names)
        raise ConfigError(f"{option}: {robot.name} has no joint {shown(joint)}{near}; it has {listed(names)}")
    return names.index(joint)
