"""Where every link is: 4x4 matrices, frame by frame, in the convention the robot was written in.

Every vector is in base axes B unless its name says otherwise. The element type follows the joint coordinates:
``float64``, ``longdouble`` (an 80-bit yardstick on x86-64) or complex (derivatives by complex step), so nothing here
takes an absolute value, a conjugate or a comparison of a coordinate.
"""

from __future__ import annotations

from functools import reduce
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ravengc.reference.arguments import checked
from ravengc.spec import DhRow, JointOrigin, LinkSpec, Pose, RobotSpec, Vector

Array = npt.NDArray[Any]
Scalar = Any
"""One number of the element type in use: ``float64``, ``longdouble`` or complex."""

Inertia = tuple[float, float, float, float, float, float]
"""Inertia, kg·m²: xx xy xz yy yz zz."""

Payload = tuple[float, Vector, Inertia]
"""Mass (kg), COM (m) and inertia about the COM in the tool frame."""

Z_AXIS: Vector = (0.0, 0.0, 1.0)
NO_INERTIA: Inertia = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class PlacedLink(NamedTuple):
    """A link where the pose puts it.

    ``frame`` is B <- link frame (4x4). ``joint_frame`` is the frame in which the joint's ``axis`` is a constant
    vector and on whose origin it passes: frame i-1 for standard DH, frame i otherwise. ``joints`` are the indices of
    the moving joints between the base and this link, its own included.
    """

    link: LinkSpec
    frame: Array
    joint_frame: Array
    axis: Array
    joints: tuple[int, ...]

    @property
    def z(self) -> Array:
        """Direction of the joint's axis, in B."""
        direction: Array = rotation(self.joint_frame) @ self.axis
        return direction

    @property
    def o(self) -> Array:
        """A point on the joint's axis, in B (m)."""
        return origin(self.joint_frame)

    @property
    def com(self) -> Array:
        """Centre of mass, in B (m)."""
        return transform(self.frame, np.asarray(self.link.com, self.frame.dtype))

    @property
    def inertia(self) -> Array:
        """Rotational inertia about the centre of mass, in axes B (kg·m²)."""
        turn = rotation(self.frame)
        turned: Array = turn @ inertia_matrix(self.link, self.frame.dtype) @ turn.T
        return turned


@checked
def link_frames(spec: RobotSpec, q: npt.ArrayLike) -> dict[str, Array]:
    """All frames of the robot, B <- frame (4x4), by name: ``base`` (B itself), the links, ``tool``.

    ``q`` are the user's coordinates (n,), rad or m; the coupling is applied.
    """
    placed = place(spec, q)
    return {"base": np.eye(4, dtype=real_or_complex(q)), **{body.link.name: body.frame for body in placed}}


@checked
def forward_kinematics(spec: RobotSpec, q: npt.ArrayLike, frame: str = "tool") -> Array:
    """Pose of one frame, B <- ``frame`` (4x4, homogeneous)."""
    return link_frames(spec, q)[frame]


@checked
def joint_axes(spec: RobotSpec, q: npt.ArrayLike) -> list[tuple[Array, Array]]:
    """Axis of every moving joint of the mechanism, in link order: unit direction and a point on it, both in B."""
    return [(joint.z, joint.o) for joint in moving(place(spec, q))]


@checked
def jacobian(spec: RobotSpec, q: npt.ArrayLike, frame: str = "tool", axes: Literal["base", "frame"] = "base") -> Array:
    """Geometric Jacobian (6, n) of a frame's origin relative to the base: linear rows first, then angular.

    Rows are in axes B (``axes="base"``) or in the frame's own axes (``axes="frame"``).
    """
    placed = place(spec, q)
    pose = forward_kinematics(spec, q, frame)
    carriers = next((body.joints for body in placed if body.link.name == frame), ())
    linear, angular = point_jacobian(placed, origin(pose), carriers)
    turn = rotation(pose).T if axes == "frame" else np.eye(3, dtype=pose.dtype)
    rows: Array = np.vstack([turn @ linear, turn @ angular]) @ coupling(spec, pose.dtype)[0]
    return rows


def point_jacobian(placed: list[PlacedLink], point: Array, carriers: tuple[int, ...]) -> tuple[Array, Array]:
    """Linear and angular Jacobian (3, joints) of a point that the joints ``carriers`` move, before the coupling."""
    joints = moving(placed)
    linear = np.zeros((3, len(joints)), point.dtype)
    angular = np.zeros_like(linear)
    for i in carriers:
        if joints[i].link.joint == "revolute":
            linear[:, i] = cross(joints[i].z, point - joints[i].o)  # v = z x (p - o)
            angular[:, i] = joints[i].z
        else:
            linear[:, i] = joints[i].z
    return linear, angular


def place(spec: RobotSpec, q: npt.ArrayLike, payload: Payload | None = None) -> list[PlacedLink]:
    """All links of the robot at ``q``, parents first; at the end the tool, a fixed link with the payload's mass."""
    values = iter(joint_values(spec, q))
    dtype = real_or_complex(q)
    placed: dict[str | None, PlacedLink] = {}
    frame_0 = pose_matrix(spec.base, dtype)
    index = 0
    for link in (*spec.links, tool_link(spec, payload)):
        parent = placed.get(link.parent)
        before, joints = (parent.frame, parent.joints) if parent else (frame_0, ())
        value = dtype.type(0)
        if link.joint != "fixed":
            value, joints, index = next(values), (*joints, index), index + 1
        after = before @ link_transform(spec, link, value)
        proximal = spec.convention == "standard" and isinstance(link.placement, DhRow)
        axis = link.placement.axis if isinstance(link.placement, JointOrigin) else Z_AXIS
        placed[link.name] = PlacedLink(link, after, before if proximal else after, np.asarray(axis, dtype), joints)
    return list(placed.values())


def moving(placed: list[PlacedLink]) -> list[PlacedLink]:
    """The links whose own joint moves, in order: entry i belongs to moving joint i."""
    return [body for body in placed if body.link.joint != "fixed"]


def carried(placed: list[PlacedLink]) -> list[PlacedLink]:
    """The links that some joint moves. The others are part of the base: no joint holds their weight."""
    return [body for body in placed if body.joints]


def tool_link(spec: RobotSpec, payload: Payload | None) -> LinkSpec:
    """The tool as a fixed link on the tip; the payload is its mass."""
    mass, com, inertia = payload or (0.0, (0.0, 0.0, 0.0), NO_INERTIA)
    return LinkSpec(
        name="tool",
        placement=JointOrigin(pose=spec.tool),
        joint="fixed",
        parent=spec.tip or spec.links[-1].name,
        mass=mass,
        com=com,
        inertia=inertia,
    )


def link_transform(spec: RobotSpec, link: LinkSpec, value: Scalar) -> Array:
    """Parent frame <- link frame (4x4), with the joint at ``value``."""
    number = type(value)
    turn, slide = (value, number(0)) if link.joint == "revolute" else (number(0), value)
    if isinstance(link.placement, JointOrigin):
        axis = np.asarray(link.placement.axis, number)
        at_zero = pose_matrix(link.placement.pose, np.dtype(number))
        return chained(at_zero, rotate(axis, turn), translate(axis * slide))
    row = link.placement
    x, z = np.eye(3, dtype=number)[0], np.eye(3, dtype=number)[2]
    rz, tz = rotate(z, number(row.theta) + turn), translate(z * (number(row.d) + slide))
    rx, tx = rotate(x, number(row.alpha)), translate(x * number(row.a))
    return chained(rz, tz, tx, rx) if spec.convention == "standard" else chained(rx, tx, rz, tz)


def chained(*steps: Array) -> Array:
    """Product of 4x4 matrices, outermost first."""
    return reduce(np.matmul, steps)


def joint_values(spec: RobotSpec, q: npt.ArrayLike) -> Array:
    """Coordinates of the mechanism's moving joints: q_mechanism = C q + c0."""
    dtype = real_or_complex(q)
    matrix, offset = coupling(spec, dtype)
    values: Array = matrix @ np.asarray(q, dtype) + offset
    return values


def coupling(spec: RobotSpec, dtype: np.dtype[Any]) -> tuple[Array, Array]:
    """C and c0 of q_mechanism = C q + c0; the identity and zero where the robot has no coupling."""
    if spec.coupling is None:
        joints = len(spec.moving_links)
        return np.eye(joints, dtype=dtype), np.zeros(joints, dtype)
    return np.asarray(spec.coupling.matrix, dtype), np.asarray(spec.coupling.offset, dtype)


def real_or_complex(*values: npt.ArrayLike) -> np.dtype[Any]:
    """The element type for a computation with these values: at least ``float64``."""
    return np.result_type(np.float64, *(np.asarray(value).dtype for value in values))


def pose_matrix(pose: Pose, dtype: np.dtype[Any]) -> Array:
    """A :class:`Pose` as a 4x4 matrix."""
    matrix = np.eye(4, dtype=dtype)
    matrix[:3, :3] = pose.rotation
    matrix[:3, 3] = pose.translation
    return matrix


def rotate(axis: Array, angle: Scalar) -> Array:
    """Rotation by ``angle`` about the unit vector ``axis`` (4x4), by Rodrigues' formula: c 1 + s S(u) + (1-c) u uᵀ."""
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.eye(4, dtype=axis.dtype)
    matrix[:3, :3] = c * np.eye(3, dtype=axis.dtype) + s * skew(axis) + (1 - c) * np.outer(axis, axis)
    return matrix


def translate(displacement: Array) -> Array:
    """Translation (4x4)."""
    matrix = np.eye(4, dtype=displacement.dtype)
    matrix[:3, 3] = displacement
    return matrix


def rotation(frame: Array) -> Array:
    """Rotation part (3, 3) of a frame."""
    return frame[:3, :3]


def origin(frame: Array) -> Array:
    """Origin (3,) of a frame."""
    return frame[:3, 3]


def transform(frame: Array, point: Array) -> Array:
    """A point of the frame, in the coordinates that the frame is given in."""
    moved: Array = rotation(frame) @ point + origin(frame)
    return moved


def skew(v: Array) -> Array:
    """S(v) (3, 3) with S(v) u = v x u."""
    zero = v[0] * 0
    return np.array([[zero, -v[2], v[1]], [v[2], zero, -v[0]], [-v[1], v[0], zero]])


def cross(a: Array, b: Array) -> Array:
    """The vector product a x b of two 3-vectors."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def inertia_matrix(link: LinkSpec, dtype: np.dtype[Any]) -> Array:
    """The link's inertia about its COM as a symmetric matrix (3, 3), in link axes."""
    xx, xy, xz, yy, yz, zz = link.inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype)
