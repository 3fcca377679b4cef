"""What a robot must satisfy, whichever file or list it came from: names, tree, bodies, frames, limits and couplings.

Every check is on the data of a :class:`~ravengc.spec.RobotSpec` alone and raises at the first fault. A ``where`` that
knows the file adds the line to the message.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc.config.disturbance_rules import check_capacity, check_element
from ravengc.config.kinds import check_kind
from ravengc.config.locate import Place, Where, nowhere
from ravengc.config.physical import (
    check_angle,
    check_axis,
    check_body,
    check_numbers,
    check_pose,
    has_full_column_rank,
    inverse,
)
from ravengc.errors import LimitError, ModelError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.spec import DhRow, JointLimits, JointOrigin, LinkSpec, RobotSpec

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.config.locate import KeyPath
    from ravengc.spec import CouplingSpec, TransmissionSpec

__all__ = ["CONVENTIONS", "JOINTS", "MAX_BODIES", "RESERVED", "check_coupling_matrix", "validate"]

LONGEST_NAME = 100
MAX_BODIES = 16
"""Most moving bodies of a robot."""

RESERVED = ("base", "tool")
"""Frames that every robot has; no link may be called so."""

CONVENTIONS = ("standard", "modified", "frames")
JOINTS = ("revolute", "prismatic", "fixed")


def validate(spec: RobotSpec, where: Where = nowhere) -> None:
    """Raise ModelError or LimitError at the first thing that no robot can have; return nothing when all is well.

    ``where`` turns a key path such as ``("link", 1, "mass")`` into ``"arm.toml:12: "`` for the message.
    """
    robot = Place("robot", (), where)
    check_kind(spec, RobotSpec, robot)
    _check_choice(spec.convention, CONVENTIONS, robot.at("convention"))
    _check_name(spec.name, robot.at("name"))
    _check_tree(spec.links, where)
    _check_body_count(spec, robot)
    for link, place in zip(spec.links, _link_places(spec.links, where), strict=True):
        _check_link(spec, link, place)
    check_pose(spec.base, Place("[base]", ("base",), where))
    check_pose(spec.tool, Place("[tool]", ("tool",), where))
    _check_tip(spec, Place("[tool]", ("tool",), where))
    if spec.coupling is not None:
        _check_coupling(spec.coupling, len(spec.moving_links), Place("[coupling]", ("coupling",), where))
    _check_coordinates(spec, where)
    if spec.transmission is not None:
        place = Place("[transmission]", ("transmission",), where)
        _check_transmission(spec.transmission, len(spec.coordinate_names), place)
    _check_disturbances(spec, where)


def _check_choice(value: object, options: Sequence[str], place: Place) -> None:
    if value not in options:
        raise ModelError(f"{place}: got {shown(value)}, expected one of {listed(options)}")


def _check_name(name: object, place: Place) -> None:
    if not isinstance(name, str) or not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        expected = f"a name of at most {LONGEST_NAME} visible characters on one line"
        raise ModelError(f"{place}: got {shown(name)}, expected {expected}")


def _link_places(links: Sequence[LinkSpec], where: Where) -> list[Place]:
    return [Place(f"link {i + 1} {shown(link.name)}", ("link", i), where) for i, link in enumerate(links)]


def _check_tree(links: Sequence[LinkSpec], where: Where) -> None:
    """Names are unique, and a parent is an earlier link, so that there is no loop."""
    before: dict[str, int] = {}
    all_names = {link.name for link in links}
    for index, (link, place) in enumerate(zip(links, _link_places(links, where), strict=True)):
        _check_name(link.name, place.at("name"))
        if link.name in RESERVED:
            raise ModelError(f"{place.at('name')}: every robot has a frame of this name; choose another")
        if link.name in before:
            raise ModelError(f"{place.at('name')}: link {before[link.name] + 1} has it already; names must be unique")
        if link.parent is not None and link.parent not in before:
            raise ModelError(f"{place.at('parent')}: {_parent_problem(link, before, all_names)}")
        before[link.name] = index


def _parent_problem(link: LinkSpec, before: dict[str, int], all_names: set[str]) -> str:
    if link.parent == link.name:
        return f"{shown(link.parent)} cannot carry itself; the parent is an earlier link, or 'base'"
    if link.parent in all_names:
        return f"{shown(link.parent)} comes later, or the links form a loop; parents come before their children"
    known = ["base", *before]
    return f"there is no link {shown(link.parent)}{did_you_mean(link.parent, known)} (before it: {listed(known)})"


def _check_body_count(spec: RobotSpec, robot: Place) -> None:
    count = len(spec.moving_links)
    if not 1 <= count <= MAX_BODIES:
        expected = f"expected 1 to {MAX_BODIES}"
        raise ModelError(f"{robot.on_line_of('link')}: {count} moving links (revolute or prismatic), {expected}")


def _check_link(spec: RobotSpec, link: LinkSpec, place: Place) -> None:
    _check_choice(link.joint, JOINTS, place.at("joint"))
    if isinstance(link.placement, JointOrigin):
        check_pose(link.placement.pose, place)
        check_axis(link.placement.axis, place.at("axis"))
    else:
        _check_row(spec, link.placement, place)
    check_body(link, place)
    _check_limits(link.limits, place)


def _check_row(spec: RobotSpec, row: DhRow, place: Place) -> None:
    if spec.convention == "frames":
        instead = "give translation, rotation and axis, or the convention 'standard' or 'modified'"
        raise ModelError(f"{place}: a Denavit-Hartenberg row in a robot of convention 'frames'; {instead}")
    for key in ("alpha", "a", "d", "theta"):
        check_numbers((getattr(row, key),), 1, place.at(key))
    for key in ("alpha", "theta"):
        check_angle(getattr(row, key), place.at(key))


def _check_limits(limits: JointLimits, place: Place) -> None:
    given = {key: getattr(limits, key) for key in ("lower", "upper", "velocity", "effort")}
    for key, value in given.items():
        if value is None:
            continue
        check_numbers((value,), 1, place.at("limits", key))
        if key in {"velocity", "effort"} and value <= 0.0:
            raise LimitError(f"{place.at('limits', key)}: got {value!r}, expected more than 0 (leave it out for none)")
    if limits.lower is not None and limits.upper is not None and not limits.lower < limits.upper:
        raise LimitError(f"{place.at('limits', 'lower')}: {limits.lower!r} is not below upper, {limits.upper!r}")


def _check_tip(spec: RobotSpec, place: Place) -> None:
    names = [link.name for link in spec.links]
    if spec.tip is not None and spec.tip not in names:
        near = did_you_mean(spec.tip, names)
        raise ModelError(f"{place.at('tip')}: there is no link {shown(spec.tip)}{near} (links: {listed(names)})")


def _check_coordinates(spec: RobotSpec, where: Where) -> None:
    """Coordinates have different names, whether a coupling or the joints name them."""
    moving = [index for index, link in enumerate(spec.links) if link.joint != "fixed"]
    paths: list[KeyPath] = [("link", index, "joint_name") for index in moving]
    if spec.coupling is not None:
        paths = [("coupling", "coordinates", index) for index in range(len(spec.coupling.coordinates))]
    seen: set[str] = set()
    for name, path in zip(spec.coordinate_names, paths, strict=True):
        place = Place("coordinate", path, where)
        _check_name(name, place)
        if name in seen:
            raise ModelError(f"{place}: {shown(name)} stands twice; names of joints must be unique")
        seen.add(name)


def _check_coupling(coupling: CouplingSpec, rows: int, place: Place) -> None:
    """Joints: q_mechanism = matrix @ q + offset, a row per moving link; no two coordinates move the links alike."""
    columns = len(coupling.coordinates)
    check_coupling_matrix(coupling.matrix, rows, columns, place)
    check_numbers(coupling.offset, rows, place.at("offset"))
    if len(coupling.limits) not in {0, columns}:
        raise ModelError(f"{place.at('limits')}: got {len(coupling.limits)}, expected {columns}, one per coordinate")
    for index, limits in enumerate(coupling.limits):
        entry = Place(f"[coupling]: coordinate {shown(coupling.coordinates[index])}", place.path, place.where)
        _check_limits(limits, entry)


def check_coupling_matrix(matrix: Sequence[Sequence[float]], rows: int, columns: int, place: Place) -> None:
    """Raise ModelError unless the matrix of the coupling at ``place`` has this shape and independent columns."""
    if not 1 <= columns <= rows:
        raise ModelError(f"{place.at('coordinates')}: got {columns} names, expected 1 to {rows}")
    _check_shape(matrix, rows, columns, place.at("matrix"))
    if not has_full_column_rank(matrix):
        problem = "columns are linearly dependent: some coordinates move the links alike, or not at all"
        raise ModelError(f"{place.at('matrix')}: {problem}")


def _check_transmission(transmission: TransmissionSpec, count: int, place: Place) -> None:
    """Motors: q = joint_per_motor @ m + offset, a row per coordinate, a column per motor, with an inverse."""
    matrix = place.at("joint_per_motor")
    for index, name in enumerate(transmission.motors):
        _check_name(name, place.at("motors", index))
    if len(set(transmission.motors)) != len(transmission.motors) or len(transmission.motors) != count:
        expected = f"expected {count} different names, as many as coordinates"
        raise ModelError(f"{place.at('motors')}: got {listed(transmission.motors)}, {expected}")
    _check_shape(transmission.joint_per_motor, count, count, matrix)
    check_numbers(transmission.offset, count, place.at("offset"))
    if inverse(transmission.joint_per_motor) is None:
        raise ModelError(f"{matrix}: has no inverse: some motors move the joints alike, or not at all")


def _check_disturbances(spec: RobotSpec, where: Where) -> None:
    """Elements have different names, which are also those of their parameters, and act on what the robot has."""
    check_capacity(spec.disturbances, Place("robot", ("disturbance",), where))
    seen: set[str] = set()
    for index, element in enumerate(spec.disturbances):
        place = Place(f"disturbance {index + 1} {shown(element.name)}", ("disturbance", index), where)
        _check_name(element.name, place.at("name"))
        if element.name in seen:
            raise ModelError(f"{place.at('name')}: stands twice; names of disturbance elements must be unique")
        seen.add(element.name)
        check_element(element, spec, place)


def _check_shape(matrix: Sequence[Sequence[float]], rows: int, columns: int, place: Place) -> None:
    lengths = sorted({len(row) for row in matrix})
    if len(matrix) != rows or lengths != [columns]:
        found = f"{len(matrix)} rows of {' or '.join(map(str, lengths)) or 'no'} numbers"
        raise ModelError(f"{place}: got {found}, expected {rows} rows of {columns}")
    for index, row in enumerate(matrix):
        check_numbers(row, columns, place.at(index))
