"""A robot on a carried base as a MuJoCo model (MJCF text), with an accelerometer and a gyro on the base.

The base is a body with three slide and three hinge joints (never a mocap body: that has no velocity, so its
accelerometer sees the tilt alone). Contacts are off: links that touch the base would push on it. Every link keeps its
own body, so MuJoCo merges fixed links by its own means. Motors are not in here: inertia, friction and coupling act on
the robot's coordinates and belong to :class:`ravengc.sim.Plant`.

MuJoCo refuses a moving body without mass or inertia. Point masses and massless links are real in robot tables, so
every body gets at least 1e-14 kg and 1e-14 kg m^2: twelve orders below what a torque in N m can show.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_number, as_vector, check_members
from ravengc.config.physical import LARGEST
from ravengc.config.validate import validate
from ravengc.errors import ArgumentError, ModelError
from ravengc.sim.base_motion import WORLD_GRAVITY, PrescribedBase, orthonormal
from ravengc.spec import DhRow, LinkSpec, Pose, RobotSpec

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["to_mjcf"]

Array = NDArray[np.float64]

SMALLEST_MASS = 1e-14
BASE_MEMBERS = ("axes", "pivot", "state")
JOINT_TYPES = {"revolute": "hinge", "prismatic": "slide"}


def to_mjcf(
    robot: RobotSpec, base: PrescribedBase, *, step_s: float = 0.0005, sensor: Sequence[float] | Array = (0.0, 0.0, 0.0)
) -> str:
    """The robot on a base that can move as ``base`` does, as MJCF text.

    ``sensor`` (m, base axes) is where the accelerometer and the gyro sit, their axes along the base's. The first six
    joints are the base's coordinates; the mechanism's moving joints follow, named as their links. Raises ModelError and
    LimitError for a robot that cannot exist, ArgumentError for anything else of the wrong kind or size.
    """
    validate(robot)
    check_members(base, BASE_MEMBERS, "base")
    step, place = positive(step_s, "step_s"), as_vector(sensor, "sensor", 3, LARGEST)
    root = Element("mujoco", model=robot.name)
    SubElement(
        root,
        "compiler",
        angle="radian",
        autolimits="false",
        boundmass=_text(SMALLEST_MASS),
        boundinertia=_text(SMALLEST_MASS),
    )
    option = SubElement(root, "option", timestep=_text(step), gravity=_text(WORLD_GRAVITY), integrator="implicitfast")
    SubElement(option, "flag", contact="disable")
    carrier = _add_base(SubElement(root, "worldbody"), base, place)
    _add_links(carrier, robot)
    sensors = SubElement(root, "sensor")
    SubElement(sensors, "accelerometer", name="accelerometer", site="imu")
    SubElement(sensors, "gyro", name="gyro", site="imu")
    indent(root)
    return tostring(root, encoding="unicode")


def positive(value: float, name: str) -> float:
    """Return one positive, finite number; ArgumentError for anything else."""
    number = as_number(value, name)
    if not 0.0 < number < np.inf:
        raise ArgumentError(f"{name} must be a positive number, not {number:g}")
    return number


def _add_base(world: Element, base: PrescribedBase, sensor: Array) -> Element:
    """The base body; its mass plays no part, because its motion is prescribed."""
    body = SubElement(world, "body", name="base")
    SubElement(body, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
    for letter, axis in zip("xyz", np.eye(3), strict=True):
        SubElement(body, "joint", name=f"base slide {letter}", type="slide", axis=_text(axis))
    pivot = _text(as_vector(base.pivot, "pivot", 3, LARGEST))
    for number, axis in enumerate(orthonormal(base.axes), start=1):
        SubElement(body, "joint", name=f"base hinge {number}", type="hinge", axis=_text(axis), pos=pivot)
    SubElement(body, "site", name="imu", pos=_text(sensor))
    return body


def _add_links(carrier: Element, robot: RobotSpec) -> None:
    bodies: dict[str | None, Element] = {None: carrier}
    for link in robot.links:
        pose, axis, anchor = _placement(link, robot.convention)
        if link.parent is None:
            pose = _homogeneous(robot.base) @ pose
        body = SubElement(
            bodies[link.parent],
            "body",
            name=f"link {link.name}",
            pos=_text(pose[:3, 3]),
            quat=_text(_quaternion(pose[:3, :3])),
        )
        _add_inertial(body, link)
        if link.joint != "fixed":
            SubElement(body, "joint", name=link.name, type=JOINT_TYPES[link.joint], axis=_text(axis), pos=_text(anchor))
        bodies[link.name] = body


def _placement(link: LinkSpec, convention: str) -> tuple[Array, Array, Array]:
    """Pose of the link in its parent at coordinate zero, then the joint's axis and a point on it, in the link's frame.

    Standard DH turns about the parent's z axis, which the link, at the far end of the row, sees from its own frame.
    """
    placement = link.placement
    if not isinstance(placement, DhRow):
        return _homogeneous(placement.pose), np.array(placement.axis), np.zeros(3)
    about_x = _screw_x(placement.alpha, placement.a)
    about_z = _screw_z(placement.theta, placement.d)
    if convention == "modified":
        return about_x @ about_z, np.array((0.0, 0.0, 1.0)), np.zeros(3)
    pose = about_z @ about_x
    return pose, pose[2, :3], -pose[:3, :3].T @ pose[:3, 3]


def _add_inertial(body: Element, link: LinkSpec) -> None:
    if link.mass == 0.0:
        return
    xx, xy, xz, yy, yz, zz = link.inertia
    moments, axes = np.linalg.eigh(np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))))
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    SubElement(
        body,
        "inertial",
        pos=_text(link.com),
        quat=_text(_quaternion(axes)),
        mass=_text(link.mass),
        diaginertia=_text(_possible_moments(link.name, moments)),
    )


def _possible_moments(name: str, moments: Array) -> Array:
    """Principal moments (ascending) that meet A + B >= C, which a thin rod misses by a rounding error."""
    smallest, middle, largest = np.maximum(moments, 0.0)
    lacking = largest - (smallest + middle)
    if lacking > 1e-9 * largest or moments[0] < -1e-9 * largest:
        raise ModelError(
            f"link '{name}': no body has the principal moments of inertia {moments} kg m^2; "
            "each must be at least 0 and at most the sum of the other two"
        )
    return np.array((smallest + max(lacking + 1e-15 * largest, 0.0), middle, largest))


def _homogeneous(pose: Pose) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.translation
    return matrix


def _screw_x(angle: float, distance: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array(((1.0, 0.0, 0.0, distance), (0.0, c, -s, 0.0), (0.0, s, c, 0.0), (0.0, 0.0, 0.0, 1.0)))


def _screw_z(angle: float, distance: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array(((c, -s, 0.0, 0.0), (s, c, 0.0, 0.0), (0.0, 0.0, 1.0, distance), (0.0, 0.0, 0.0, 1.0)))


def _quaternion(rotation: Array) -> Array:
    """Unit quaternion (w, x, y, z): the eigenvector of Bar-Itzhack's 4x4 matrix, exact for every rotation angle."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = rotation.ravel()
    matrix = np.array(
        (
            (xx + yy + zz, zy - yz, xz - zx, yx - xy),
            (zy - yz, xx - yy - zz, xy + yx, xz + zx),
            (xz - zx, xy + yx, yy - xx - zz, yz + zy),
            (yx - xy, xz + zx, yz + zy, zz - xx - yy),
        )
    )
    quaternion: Array = np.linalg.eigh(matrix)[1][:, -1]
    return quaternion


def _text(value: float | Sequence[float] | Array) -> str:
    return " ".join(repr(float(number)) for number in np.atleast_1d(np.asarray(value, dtype=np.float64)))
