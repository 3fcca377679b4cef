"""``ravengc torque``: the gravity torque of a robot in one pose."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, console, fixed, new_table, print_json, right
from ravengc.cli.robot_options import (
    add_gravity_options,
    add_robot_options,
    coordinates_from,
    gravity_from,
    robot_from,
)

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator

    from ravengc.spec import JointLimits, RobotSpec

__all__ = ["add_parser", "run"]

MOST_TURNED = 4.0 * math.pi
"""rad; hardly a pose, rather degrees."""

ABOUT = """\
Print what every joint must exert to hold a robot still in one pose against
gravity and against its cables and springs, where its file has such elements
(positive: along the coordinate). Numbers without a unit are SI: rad for turning
joints, m for sliding ones."""

EXAMPLES = """\
  ravengc torque panda --q 0 "-45 deg" 0 "-135 deg" 0 "90 deg" "45 deg"
  ravengc torque raven2_gold --q "20 deg" "75 deg" "0.4 m" --tilt 15deg about x
  ravengc torque rrbot --q 0.1,0.3 --gravity 0 1.7 -9.65 --payload 500g --json
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``torque`` to the command line."""
    parser = command_parser(subparsers, "torque", "gravity torque in one pose", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file")
    parser.add_argument("--q", nargs="+", required=True, metavar="Q", help='coordinates: 0.3, "30 deg", "0.4 m"')
    add_robot_options(parser)
    add_gravity_options(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of the table")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Compute and print the torques."""
    robot = robot_from(args)
    q, gravity = coordinates_from(args.q, robot.spec), gravity_from(args)
    joints = _joints(robot.spec, q, robot.gravity_torque(q, gravity).tolist(), robot.disturbance_torque(q).tolist())
    remarks = list(_remarks(robot.spec, q, gravity))
    if args.json:
        about = {"robot": robot.name, "mass_set": robot.spec.mass_set, "gravity": gravity, "joints": joints}
        print_json(about | {"remarks": remarks})
        return 0
    _show(robot.spec, gravity, joints)
    for remark in remarks:
        console().print(remark, style="yellow", soft_wrap=True, markup=False)
    return 0


def _joints(robot: RobotSpec, q: list[float], gravity: list[float], beside: list[float]) -> list[dict[str, Any]]:
    """One row per coordinate: the torque that holds it, and its parts where the robot has disturbance elements."""
    from ravengc.coordinates import sliding

    rows = zip(robot.coordinate_names, sliding(robot), q, gravity, beside, robot.coordinate_limits, strict=True)
    return [
        {
            "name": name,
            "q": position,
            "q_unit": "m" if slides else "rad",
            "torque": weight + held,
            "torque_unit": "N" if slides else "N·m",
            **({"gravity": weight, "disturbance": held} if robot.disturbances else {}),
            "beyond": _beyond(limits, position, weight + held),
        }
        for name, slides, position, weight, held, limits in rows
    ]


def _remarks(robot: RobotSpec, q: list[float], gravity: tuple[float, float, float]) -> Iterator[str]:
    """What was probably not meant."""
    from ravengc.cli.level_only import level_only_notes
    from ravengc.coordinates import sliding

    yield from level_only_notes(robot, gravity)
    if not any(link.mass for link in robot.links):
        yield f"robot '{robot.name}' has no masses: nothing of it weighs"
    for name, slides, position in zip(robot.coordinate_names, sliding(robot), q, strict=True):
        if not slides and abs(position) > MOST_TURNED:
            turns = position / (2.0 * math.pi)
            yield f"{name} is turned {turns:.1f} times round; degrees are written '{position:g} deg'"
    if gravity[2] > 0.0:
        yield "gravity has a part along +z: the base hangs; on a level base it is 0 0 -9.81"


def _beyond(limits: JointLimits, position: float, torque: float) -> list[str]:
    """Which limits of the joint this pose and torque are beyond."""
    checks = {
        "lower": limits.lower is not None and position < limits.lower,
        "upper": limits.upper is not None and position > limits.upper,
        "effort": limits.effort is not None and abs(torque) > limits.effort,
    }
    return [name for name, is_beyond in checks.items() if is_beyond]


def _show(robot: RobotSpec, gravity: tuple[float, float, float], joints: list[dict[str, Any]]) -> None:
    from rich.markup import escape

    field = ", ".join(f"{value:.6g}" for value in gravity)
    any_beyond = any(joint["beyond"] for joint in joints)
    parts = ["gravity", "disturbance"] if robot.disturbances else []
    beyond_limits = ["beyond its limits"] if any_beyond else []
    table = new_table("joint", right("position"), right("torque"), *map(right, parts), *beyond_limits)
    for joint in joints:
        sliding = joint["q_unit"] == "m"
        position = f"{fixed(joint['q'], 4)} m" if sliding else f"{fixed(math.degrees(joint['q']), 2)} deg"
        torques = [f"{fixed(joint[part], 4, '+')} {joint['torque_unit']}" for part in ("torque", *parts)]
        beyond = [", ".join(joint["beyond"])] if any_beyond else []
        table.add_row(escape(joint["name"]), position, *torques, *beyond)
    out = console()
    out.print(f"[bold]{escape(robot.name)}: torque to hold[/bold], gravity ({field}) m/s²", soft_wrap=True)
    out.print(table)
