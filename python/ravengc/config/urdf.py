"""A robot from a URDF file: its tree of links and joints, mimic joints as a coupling, frames as they stand.

The root link becomes the base, z up. A frame of ours is a frame of the URDF, so COMs and inertias are in link axes.
Only kinematics and inertials are read: no mesh, no package path, no file that the URDF names is opened.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ravengc._convert import as_path
from ravengc.config.files import read_bytes
from ravengc.config.links import unit_axis
from ravengc.config.locate import Place
from ravengc.config.mimic import read_mimic
from ravengc.config.physical import check_angle
from ravengc.config.rotations import rotate_inertia, rotation_from_rpy
from ravengc.config.urdf_xml import Element, parse_xml
from ravengc.config.validate import RESERVED, validate
from ravengc.errors import ModelError, ParseError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.spec import JointKind, JointLimits, JointOrigin, LinkSpec, Pose, RobotSpec, Vector

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable

    from ravengc.config.locate import KeyPath, Where

__all__ = ["spec_from_urdf"]

JOINT_KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}


def spec_from_urdf(path: str | os.PathLike[str], *, tip: str | None = None) -> RobotSpec:
    """Return the robot of a URDF file; its frames are the URDF's, its base frame B the root link.

    ``tip`` is the link that carries the tool frame (by default the last one in tree order). Joints are revolute,
    continuous, prismatic or fixed, about any axis; mimic joints become a coupling. A link without ``<inertial>`` is
    massless; the root's own becomes a fixed link on the base. A link called "base" or "tool" gets "_link" appended, as
    these are frames of every robot. Limits of 0 for effort and velocity, and 0 to 0 for the position, are what
    exporters write for "unknown" and mean none.

    Raises:
        ParseError: no plain XML, too large, nested too deeply, a DOCTYPE or xacro; with file, line and column.
        ConfigError: an attribute that is missing or no number.
        ModelError, LimitError: a tree, joint, angle, mass or limit that no robot has.
    """
    source = as_path(path, "path")
    file = str(source)
    root = parse_xml(read_bytes(source), file)
    _check_root(root)
    tree = _read_tree(root)
    names = _rename(tree)
    links = [*_root_body(tree, names), *(_read_link(tree, name, names) for name in tree.order)]
    first = len(links) - len(tree.order)
    spec = RobotSpec(
        name=root.attributes.get("name", "").strip() or source.stem,
        convention="frames",
        links=tuple(links),
        tip=names.get(tip, tip) if isinstance(tip, str) else tip,
        coupling=read_mimic([tree.joint_of[name] for name in tree.order], links[first:]),
        source=f"URDF file {source.name}",
        file=file,
    )
    validate(spec, _places(tree, file, first))
    return spec


@dataclass(frozen=True, slots=True)
class _Tree:
    """Links by name, the joint that carries each, and all but the root in order, parents first."""

    root: str
    links: dict[str, Element]
    joint_of: dict[str, Element]
    order: tuple[str, ...]


def _check_root(root: Element) -> None:
    if root.tag != "robot":
        hint = " (an SDF, not a URDF)" if root.tag == "sdf" else ""
        raise ParseError(f"the document is <{root.tag}>{hint}, expected <robot>", file=root.file, line=root.line)
    pending = [root]
    while pending:
        element = pending.pop()
        if element.tag.startswith("xacro:"):
            problem = (
                f"<{element.tag}> is xacro that has not been expanded; expand it first: xacro robot.xacro > robot.urdf"
            )
            raise ParseError(problem, file=element.file, line=element.line)
        pending += element.children


def _read_tree(robot: Element) -> _Tree:
    links = _by_name(robot.all("link"))
    joints = _by_name(robot.all("joint"))
    joint_of: dict[str, Element] = {}
    children: dict[str, list[str]] = {name: [] for name in links}
    for name, joint in joints.items():
        parent, child = (_link_name(joint, end, links) for end in ("parent", "child"))
        if child in joint_of:
            other = joint_of[child].get("name")
            raise _model_error(
                joint, f"{name!r}: link {child!r} hangs on joint {other!r} already; a tree has one parent per link"
            )
        joint_of[child] = joint
        children[parent].append(child)
    root = _only_root(robot, links, joint_of)
    order = tuple(_walk(root, children))
    if len(order) != len(links):
        looped = [name for name in links if name not in set(order)]
        raise _model_error(joint_of[looped[0]], f"links {listed(looped)} form a loop that is not connected to {root!r}")
    return _Tree(root, links, joint_of, order[1:])


def _by_name(elements: Iterable[Element]) -> dict[str, Element]:
    named: dict[str, Element] = {}
    for element in elements:
        name = element.get("name")
        if name in named:
            raise _model_error(
                element, f"{shown(name)} stands in line {named[name].line} already; names must be unique"
            )
        named[name] = element
    return named


def _link_name(joint: Element, end: str, links: dict[str, Element]) -> str:
    element = joint.first(end)
    if element is None:
        raise joint.error(f"{joint.get('name')!r} has no <{end} link=...>")
    name = element.get("link")
    if name not in links:
        raise _model_error(
            element, f"there is no link {shown(name)}{did_you_mean(name, links)} (links: {listed(links)})"
        )
    return name


def _only_root(robot: Element, links: dict[str, Element], joint_of: dict[str, Element]) -> str:
    roots = [name for name in links if name not in joint_of]
    if len(roots) == 1:
        return roots[0]
    if not links:
        raise _model_error(robot, "there is no <link>")
    if not roots:
        raise _model_error(robot, "every link hangs on another one: the links form a loop; one must be the root")
    raise _model_error(robot, f"there are {len(roots)} roots, {listed(roots)}; expected one (is a joint missing?)")


def _walk(root: str, children: dict[str, list[str]]) -> Iterable[str]:
    """Depth first, in the order of the joints in the file: a serial chain stays together."""
    pending = [root]
    while pending:
        name = pending.pop()
        yield name
        pending += reversed(children[name])


def _rename(tree: _Tree) -> dict[str, str]:
    """Names of links here: those of the URDF, but for names of frames that every robot has."""
    taken = set(tree.links)
    names = {}
    for name in tree.links:
        free = name
        while free in RESERVED or (free != name and free in taken):
            free += "_link"
        taken.add(free)
        names[name] = free
    return names


def _root_body(tree: _Tree, names: dict[str, str]) -> Iterable[LinkSpec]:
    """The root's own mass, as a link fixed on the base: no joint feels it, the mount does."""
    element = tree.links[tree.root]
    if element.first("inertial") is None:
        return
    mass, com, inertia = _read_inertial(element)
    yield LinkSpec(
        name=names[tree.root],
        joint="fixed",
        placement=JointOrigin(),
        mass=mass,
        com=com,
        inertia=inertia,
        massless=mass == 0.0,
    )


def _read_link(tree: _Tree, name: str, names: dict[str, str]) -> LinkSpec:
    joint = tree.joint_of[name]
    parent = _link_name(joint, "parent", tree.links)
    mass, com, inertia = _read_inertial(tree.links[name])
    return LinkSpec(
        name=names[name],
        joint=_joint_kind(joint),
        joint_name=joint.get("name"),
        parent=None if parent == tree.root else names[parent],
        placement=JointOrigin(pose=_read_origin(joint), axis=_read_axis(joint)),
        mass=mass,
        com=com,
        inertia=inertia,
        massless=mass == 0.0,
        limits=_read_limits(joint),
    )


def _joint_kind(joint: Element) -> JointKind:
    kind = joint.get("type")
    if kind in JOINT_KINDS:
        return JOINT_KINDS[kind]
    label = f"joint {joint.get('name')!r}: type {shown(kind)}"
    if kind == "floating":
        raise _model_error(
            joint, f"{label} is not a joint of an arm; a base that moves is given as base motion, not as a joint"
        )
    if kind == "planar":
        raise _model_error(joint, f"{label} has two coordinates; write it as two prismatic joints")
    raise _model_error(joint, f"{label} is unknown{did_you_mean(kind, JOINT_KINDS)} (known: {listed(JOINT_KINDS)})")


def _read_origin(element: Element) -> Pose:
    origin = element.first("origin")
    if origin is None:
        return Pose()
    x, y, z = origin.numbers("xyz", (0.0, 0.0, 0.0))
    roll, pitch, yaw = origin.numbers("rpy", (0.0, 0.0, 0.0))
    for angle in (roll, pitch, yaw):
        check_angle(angle, Place(f"{origin.file}:{origin.line}: <origin>: rpy"))
    return Pose(rotation_from_rpy(roll, pitch, yaw), (x, y, z))


def _read_axis(joint: Element) -> Vector:
    axis = joint.first("axis")
    if joint.get("type") == "fixed":
        return (0.0, 0.0, 1.0)
    x, y, z = (1.0, 0.0, 0.0) if axis is None else axis.numbers("xyz", (1.0, 0.0, 0.0))
    return unit_axis((x, y, z), Place(f"{joint.file}:{joint.line}: joint {joint.get('name')!r}: axis"))


def _read_inertial(link: Element) -> tuple[float, Vector, tuple[float, float, float, float, float, float]]:
    """Mass, COM and inertia about the COM in link axes; ``rpy`` of the inertial frame turns the inertia."""
    inertial = link.first("inertial")
    if inertial is None:
        return 0.0, (0.0, 0.0, 0.0), (0.0,) * 6
    mass, inertia = inertial.first("mass"), inertial.first("inertia")
    if mass is None or inertia is None:
        raise inertial.error(f"link {link.get('name')!r}: <{'mass' if mass is None else 'inertia'} .../> is missing")
    xx, xy, xz, yy, yz, zz = (inertia.number(key) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    frame = _read_origin(inertial)
    moments = (xx, xy, xz, yy, yz, zz)
    aligned = frame.rotation == Pose().rotation
    return mass.number("value"), frame.translation, moments if aligned else rotate_inertia(frame.rotation, moments)


def _read_limits(joint: Element) -> JointLimits:
    limit = joint.first("limit")
    if limit is None or joint.get("type") == "fixed":
        return JointLimits()
    lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
    bounded = joint.get("type") != "continuous" and (lower, upper) != (0.0, 0.0)
    return JointLimits(
        lower=lower if bounded else None,
        upper=upper if bounded else None,
        velocity=limit.number("velocity", 0.0) or None,
        effort=limit.number("effort", 0.0) or None,
    )


def _places(tree: _Tree, file: str, first: int) -> Where:
    """Lines for messages of the validation: those of the link, or of the joint that carries it."""

    def place(path: KeyPath) -> str:
        if len(path) < 2 or path[0] != "link":
            return f"{file}: "
        index = int(path[1]) - first
        name = tree.order[index] if index >= 0 else tree.root
        of_body = index < 0 or (len(path) > 2 and path[2] in {"mass", "com", "inertia"})
        return f"{file}:{(tree.links if of_body else tree.joint_of)[name].line}: "

    return place


def _model_error(element: Element, problem: str) -> ModelError:
    return ModelError(f"{element.file}:{element.line}: <{element.tag}>: {problem}")
