"""dynibo: a URDF file; gravity is built in, so another vector is an acceleration of a floating base with a mass."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, SubElement, tostring

import dynibo
import numpy as np

from comparison.arm import LEVEL, Arm, dh_row
from comparison.call import Call

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from ravengc.spec import LinkSpec


def urdf(arm: Arm) -> str:
    """The arm on a root with mass, as text; a turn about x is all that its frames need."""
    root = Element("robot", name="panda")
    add_link(root, "base", 1.0, np.zeros(3), (1.0, 0.0, 0.0, 1.0, 0.0, 1.0))
    parent = "base"
    for link in arm.spec.links:
        add_link(root, link.name, link.mass, link.com, link.inertia)
        add_joint(root, parent, link, arm.placement(link)[:3, 3])
        parent = link.name
    SubElement(root, "link", name="tool")
    joint = SubElement(root, "joint", name="to tool", type="fixed")
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link="tool")
    SubElement(joint, "origin", xyz=text(arm.tool))
    return tostring(root, encoding="unicode")


def add_link(root: Element, name: str, mass: float, com: Any, inertia: Any) -> None:
    inertial = SubElement(SubElement(root, "link", name=name), "inertial")
    SubElement(inertial, "origin", xyz=text(com))
    SubElement(inertial, "mass", value=repr(mass))
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    SubElement(inertial, "inertia", dict(zip(names, map(repr, inertia), strict=True)))


def add_joint(root: Element, parent: str, link: LinkSpec, place: Any) -> None:
    joint = SubElement(root, "joint", name=f"to {link.name}", type="revolute")
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=link.name)
    SubElement(joint, "origin", xyz=text(place), rpy=text([dh_row(link).alpha, 0.0, 0.0]))
    SubElement(joint, "axis", xyz="0 0 1")
    SubElement(joint, "limit", lower="-10", upper="10", effort="100", velocity="10")


def text(numbers: Any) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def calls(arm: Arm) -> Iterator[Call]:
    """All but the regressor; a pose comes as translation and quaternion."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "panda.urdf")
        path.write_text(urdf(arm))
        robot, floating = dynibo.Robot.from_urdf(path), dynibo.FloatingRobot.from_urdf(path)
    tool, out = robot.link_id("tool"), np.empty(arm.n)
    columns, square = np.empty(6 * arm.n), np.empty(arm.n * arm.n)
    Q, V, A = arm.q, arm.qd, arm.qdd
    fk, jacobian, torque, mass = (
        robot.forward_kinematics,
        robot.jacobian,
        robot.inverse_dynamics,
        robot.mass_matrix,
    )

    def call(operation: str, way: str, run: Callable[[int], Any], fetches: int, value: Any = np.asarray) -> Call:
        return Call("dynibo", operation, way, run, fetches, value)

    yield call("gravity", "floating base accelerates, out=", gravity(floating, arm), 2, lambda tau: tau[6:])
    yield call("kinematics", "pose object, no matrix", lambda k: fk(Q[k], tool), 1, homogeneous)
    yield call("jacobian", "out=, flat, angular rows first", lambda k: jacobian(Q[k], tool, columns), 1, linear_first)
    yield call("inverse_dynamics", "out=", lambda k: torque(Q[k], V[k], A[k], out=out), 3)
    yield call("moving_base", "floating base, out=", moving_base(floating, arm), 6, lambda tau: tau[6:])
    yield call("mass_matrix", "out=, flat", lambda k: mass(Q[k], square), 1, lambda flat: flat.reshape(arm.n, arm.n))


def accelerations(arm: Arm) -> list[tuple[float, ...]]:
    """a = f + g for the gravity that is built in."""
    return [tuple(map(float, f + LEVEL)) for f in arm.f]


def gravity(robot: dynibo.FloatingRobot, arm: Arm) -> Callable[[int], Any]:
    A, Q, still, out = accelerations(arm), arm.q, np.zeros(arm.n), np.empty(arm.n + 6)
    state, twist, torque = dynibo.BaseState, dynibo.Twist, robot.inverse_dynamics
    return lambda k: torque(state(acceleration=twist(linear=A[k])), Q[k], still, still, out=out)


def moving_base(robot: dynibo.FloatingRobot, arm: Arm) -> Callable[[int], Any]:
    A, W, D, out = accelerations(arm), arm.w, arm.dw, np.empty(arm.n + 6)
    Q, V, QDD, state, twist, torque = arm.q, arm.qd, arm.qdd, dynibo.BaseState, dynibo.Twist, robot.inverse_dynamics

    def run(k: int) -> Any:
        base = state(velocity=twist(angular=W[k]), acceleration=twist(angular=D[k], linear=A[k]))
        return torque(base, Q[k], V[k], QDD[k], out=out)

    return run


def linear_first(flat: Any) -> Any:
    columns = flat.reshape(6, -1, order="F")
    return np.vstack([columns[3:], columns[:3]])


def homogeneous(pose: dynibo.Pose) -> Any:
    x, y, z, w = pose.rotation_xyzw
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, 3] = pose.translation
    return matrix
