"""A robot as symbols: every moving link in the frame of its joint, whose axis is z, with exact constants.

Frame J of a moving link turns about (or slides along) its z axis by ``motion``. Standard and modified
Denavit-Hartenberg rows and explicit frames all become the same three things: a constant pose of J in the frame J of
the link that carries it, the motion, and a constant pose of the link's own frame in J. Fixed links are part of the
constant poses, and their masses part of the link that carries them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from ravengc.spec import IDENTITY, DhRow
from ravengc.symbolic.algebra import (
    Expr,
    Matrix,
    Triple,
    added,
    angle,
    cosine,
    engine,
    exact,
    product,
    transposed,
    turned,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from ravengc.spec import JointOrigin, LinkSpec, Pose, RobotSpec

__all__ = ["Body", "Frame", "Mechanism", "coordinates", "numbers", "place", "vector", "with_right_angles"]


@dataclass(frozen=True, slots=True)
class Frame:
    """A constant pose: p_outer = rotation p_inner + translation."""

    rotation: Matrix
    translation: Triple

    def __matmul__(self, inner: Frame) -> Frame:
        """The pose of a frame in the inner one."""
        return Frame(numbers(product(self.rotation, inner.rotation)), self.point(inner.translation))

    def point(self, p: Triple) -> Triple:
        """A point of the inner frame, in the outer one."""
        return added(turned(self.rotation, p), self.translation)


@dataclass(frozen=True, slots=True)
class Body:
    """A moving link.

    ``joint`` is the pose of its frame J at motion 0 in the frame J of body ``parent`` (in B for ``None``); ``link`` is
    that of the link's own frame in J.
    """

    name: str
    parent: int | None
    turns: bool
    motion: Expr
    joint: Frame
    link: Frame


@dataclass(frozen=True, slots=True)
class Mechanism:
    """The moving links, the pose of every frame in J of a body (in B for ``None``), the coupling, the lengths."""

    bodies: tuple[Body, ...]
    frames: dict[str, tuple[int | None, Frame]]
    coupling: tuple[tuple[Expr, ...], ...]
    lengths: dict[Expr, float]

    def on_coordinates(self, rows: Sequence[Expr]) -> list[Expr]:
        """Torques on the user's coordinates from those of the joints, or one column of anything like it: Cᵀ tau."""
        columns = zip(*self.coupling, strict=True)
        return [sum((c * row for c, row in zip(column, rows, strict=True)), engine().Integer(0)) for column in columns]


@dataclass(slots=True)
class _Placing:
    """What is known of the links placed so far."""

    spec: RobotSpec
    symbolic_lengths: bool
    motions: list[tuple[Expr, float]]
    bodies: list[Body] = field(default_factory=list)
    frames: dict[str, tuple[int | None, Frame]] = field(default_factory=dict)
    lengths: dict[Expr, float] = field(default_factory=dict)

    def length(self, name: str, value: float) -> Expr:
        """A length of a DH row: a symbol where that is wanted and it is not zero."""
        if not self.symbolic_lengths or value == 0.0:
            return exact(value)
        symbol = engine().Symbol(name)
        self.lengths[symbol] = value
        return symbol


def place(spec: RobotSpec, *, symbolic_lengths: bool = False) -> Mechanism:
    """Lower a robot; ``symbolic_lengths`` keeps the lengths a and d of Denavit-Hartenberg rows as symbols."""
    placing = _Placing(spec, symbolic_lengths, _motions(spec))
    placing.frames["base"] = (None, _constant(IDENTITY))
    for number, link in enumerate(spec.links, 1):
        _place_link(placing, number, link)
    index, tip = placing.frames[spec.tip or spec.links[-1].name]
    placing.frames["tool"] = (index, tip @ _pose(spec.tool))
    coupling = tuple(tuple(map(exact, row)) for row in _coupling(spec)[0])
    return Mechanism(tuple(placing.bodies), placing.frames, coupling, placing.lengths)


def with_right_angles(spec: RobotSpec, tolerance: float) -> RobotSpec:
    """The robot with angles of its rows that are this close (rad) to a multiple of a right angle as that multiple."""
    return replace(spec, links=tuple(_squared(link, tolerance) for link in spec.links))


def _squared(link: LinkSpec, tolerance: float) -> LinkSpec:
    row = link.placement
    if not isinstance(row, DhRow):
        return link
    alpha, theta = (_near_right(value, tolerance) for value in (row.alpha, row.theta))
    return replace(link, placement=replace(row, alpha=alpha, theta=theta))


def _near_right(value: float, tolerance: float) -> float:
    square = round(value / (pi / 2.0)) * (pi / 2.0)
    return square if abs(value - square) <= tolerance else value


def _place_link(placing: _Placing, number: int, link: LinkSpec) -> None:
    parent, outer = (None, _pose(placing.spec.base)) if link.parent is None else placing.frames[link.parent]
    before, after = _around(placing, number, link)
    if link.joint == "fixed":
        placing.frames[link.name] = (parent, outer @ before @ after)
        return
    index = len(placing.bodies)
    motion = _motion(placing, number, link, *placing.motions[index])
    placing.bodies.append(Body(link.name, parent, link.joint == "revolute", motion, outer @ before, after))
    placing.frames[link.name] = (index, after)


def _motion(placing: _Placing, number: int, link: LinkSpec, joint: Expr, offset: float) -> Expr:
    """Angle about z or way along it: the joint's coordinate, the coupling's offset, and theta or d of a row."""
    row = link.placement if isinstance(link.placement, DhRow) else DhRow()
    if link.joint == "revolute":
        return joint + angle(offset + row.theta)
    return joint + exact(offset) + placing.length(f"d{number}", row.d)


def _around(placing: _Placing, number: int, link: LinkSpec) -> tuple[Frame, Frame]:
    """Constant poses before and after the motion. What a row adds to the coordinate is part of the motion."""
    if not isinstance(link.placement, DhRow):
        return _around_axis(link.placement)
    row = link.placement
    a, d = placing.length(f"a{number}", row.a), placing.length(f"d{number}", row.d)
    zero = engine().Integer(0)
    turn_x, along_x = _about_x(row.alpha), _constant(IDENTITY, (a, zero, zero))
    turn_z = _constant(IDENTITY) if link.joint == "revolute" else _about_z(row.theta)
    along_z = _constant(IDENTITY, (zero, zero, zero if link.joint == "prismatic" else d))
    if placing.spec.convention == "standard":
        return turn_z, along_z @ along_x @ turn_x
    return turn_x @ along_x @ turn_z @ along_z, _constant(IDENTITY)


def _around_axis(origin: JointOrigin) -> tuple[Frame, Frame]:
    """A frame whose z is the joint's axis, and back."""
    upright = _upright(np.array(origin.axis))
    back = _constant(IDENTITY).translation
    return _pose(origin.pose) @ Frame(upright, back), Frame(transposed(upright), back)


def _upright(axis: np.ndarray) -> Matrix:
    """A rotation that takes z to a unit vector; along an axis of the frame it only swaps axes and turns them round."""
    main = int(np.argmax(np.abs(axis)))
    x = np.roll(np.eye(3)[0], main - 2)
    x = x - axis * (axis @ x)
    x /= np.linalg.norm(x)
    return numbers(np.column_stack([x, np.cross(axis, x), axis]))


def _about_x(turn: float) -> Frame:
    c, s = cos(turn), sin(turn)
    return _constant([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _about_z(turn: float) -> Frame:
    c, s = cos(turn), sin(turn)
    return _constant([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _pose(pose: Pose) -> Frame:
    return _constant(pose.rotation, vector(pose.translation))


def _constant(rotation: Iterable[Iterable[float]], translation: Triple | None = None) -> Frame:
    return Frame(numbers(rotation), translation or vector((0.0, 0.0, 0.0)))


def numbers(rotation: Iterable[Iterable[float]]) -> Matrix:
    """A rotation matrix of exact numbers."""
    x, y, z = (tuple(exact(cosine(float(entry))) for entry in row) for row in rotation)
    return x, y, z


def vector(values: Iterable[float]) -> Triple:
    """A vector of exact numbers."""
    x, y, z = (exact(float(value)) for value in values)
    return x, y, z


def coordinates(spec: RobotSpec, letter: str = "q") -> tuple[Expr, ...]:
    """The symbols q1, q2, ... of the user's coordinates (or of their rates)."""
    return tuple(engine().Symbol(f"{letter}{i}") for i in range(1, len(spec.coordinate_names) + 1))


def _motions(spec: RobotSpec) -> list[tuple[Expr, float]]:
    """Coordinates of the mechanism's joints, C q + c0, as the two summands."""
    q, zero = coordinates(spec), engine().Integer(0)
    matrix, offsets = _coupling(spec)
    rows = [sum((exact(c) * symbol for c, symbol in zip(row, q, strict=True)), zero) for row in matrix]
    return list(zip(rows, offsets, strict=True))


def _coupling(spec: RobotSpec) -> tuple[Sequence[Sequence[float]], Sequence[float]]:
    if spec.coupling is not None:
        return spec.coupling.matrix, spec.coupling.offset
    joints = len(spec.moving_links)
    return np.eye(joints).tolist(), [0.0] * joints
