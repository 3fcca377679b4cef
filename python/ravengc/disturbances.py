"""What acts on a robot's coordinates beside its masses: cables, springs, friction, offsets; plain immutable data.

Each element says which torque (N·m, N) the actuators must exert against it, as gravity torque does: a spring gives
+∂U/∂q, friction +F sign(v). It depends on the coordinates q and their rates alone: it is fixed to the base and does not
turn with gravity. What does turn with gravity belongs to the masses.

Elements along a joint give τ = w φ(s, ṡ) with s = vᵀq: ``joint`` is w and ``of`` is v, each the name of a coordinate or
a number for every coordinate (the forearm of a parallelogram moves with q₂ + q₃); without ``of`` they are the same.
Units are those of the joint: rad and N·m, or m and N. Every torque is linear in the element's ``parameters``, one for
each of its ``labels``.
"""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003 - types of a description are looked up at run time
from dataclasses import dataclass, fields
from typing import Literal, NamedTuple

from ravengc.frozen import freeze

__all__ = [
    "KINDS",
    "Constant",
    "Disturbance",
    "Friction",
    "Harmonic",
    "Jump",
    "LinearSpring",
    "PiecewiseCable",
    "Polynomial",
    "SpringBetween",
]

Vector = tuple[float, float, float]
Along = str | tuple[float, ...]
"""A coordinate by name, or a number for every coordinate."""

CONTINUOUS = 1e-9
"""Steps below this share of the torques on both sides are rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Element:
    name: str
    source: str = ""

    def __post_init__(self) -> None:
        """Freeze what was given as lists or arrays."""
        freeze(self, *(field.name for field in fields(self)))

    @property
    def kind(self) -> str:
        """What a robot file calls elements of this kind."""
        return next(kind for kind, of_kind in KINDS.items() if type(self) is of_kind)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters: fields in which the torque is linear."""
        return LINEAR[self.kind]

    @property
    def parameters(self) -> tuple[float, ...]:
        """The numbers of the parameters, in the order of the labels."""
        return tuple(getattr(self, label) for label in self.labels)


@dataclass(frozen=True, slots=True, kw_only=True)
class _AlongJoint(_Element):
    joint: Along
    of: Along | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Directed(_AlongJoint):
    """An element that knows the direction of motion, as the published controller of the dVRK blends it.

    blend(v) is 0 within ±``dead_band``, then rises to ±``ratio`` at ±``saturation`` (rad/s, m/s) and stays there:
    on a straight line, or with "tanh" as ratio · tanh((abs(v) - dead_band)/(saturation - dead_band)).
    """

    dead_band: float = 0.0
    saturation: float = 0.05
    ratio: float = 1.0
    blend: Literal["linear", "tanh"] = "linear"


@dataclass(frozen=True, slots=True, kw_only=True)
class Polynomial(_Directed):
    """A polynomial of the position: φ = weight · Σ c_k s^k, ``coefficients`` c_k from k = 0.

    ``range`` (low, high) is where the coefficients were found: s is clamped into it, so that the torque stays constant
    beyond. ``direction`` is that of the motion for which they hold: the weight of "positive" ones is
    α = (1 + blend(ṡ))/2, that of "negative" ones 1 - α, and "both" have weight 1. A pair of the first two is what
    the gravity compensation of the dVRK fits to each joint.
    """

    coefficients: tuple[float, ...]
    direction: Literal["both", "positive", "negative"] = "both"
    range: tuple[float, float] | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters: p0, p1, ..."""
        return _powers(self.coefficients)

    @property
    def parameters(self) -> tuple[float, ...]:
        """The coefficients."""
        return self.coefficients


class Jump(NamedTuple):
    """A step of a torque: where (rad, m), and how much higher it is to the right (N·m, N)."""

    at: float
    size: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PiecewiseCable(_AlongJoint):
    """A polynomial between each two ``knots``, as of a cable that pulls in a part of the range.

    ``pieces`` has one polynomial more than there are knots, from the left; its powers are those of s minus the knot on
    its left, of the first piece of s minus the first knot. At a knot the right piece holds. ``range`` clamps s.
    """

    knots: tuple[float, ...]
    pieces: tuple[tuple[float, ...], ...]
    range: tuple[float, float] | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters: piece0.p0, ..."""
        return tuple(f"piece{i}.{power}" for i, piece in enumerate(self.pieces) for power in _powers(piece))

    @property
    def parameters(self) -> tuple[float, ...]:
        """The coefficients of all pieces, one after the other."""
        return tuple(coefficient for piece in self.pieces for coefficient in piece)

    def jumps(self) -> tuple[Jump, ...]:
        """Return the knots at which the torque steps; a motor that follows it there kicks the arm."""
        origins = (self.knots[0], *self.knots)
        steps = []
        for knot, origin, left, right in zip(self.knots, origins, self.pieces, self.pieces[1:], strict=False):
            before, after = _value(left, knot - origin), _value(right, 0.0)
            if abs(after - before) > CONTINUOUS * max(abs(before), abs(after)):
                steps.append(Jump(knot, after - before))
        return tuple(steps)


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearSpring(_AlongJoint):
    """A spring along the coordinate: φ = stiffness · (s - rest); N·m/rad or N/m."""

    stiffness: float
    rest: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SpringBetween(_Element):
    """A coil spring between points of two bodies: τ = ∂U/∂q with U = stiffness (l - rest_length)²/2, l their distance.

    It acts on every joint between the two. A body is a link by name, its point (m) in that link's frame, or "base" with
    its point in frame 0 of the links, which a new base pose carries along. Where both points meet, a spring with a rest
    length has no direction and no torque.
    """

    body_a: str
    point_a: Vector
    body_b: str
    point_b: Vector
    stiffness: float
    rest_length: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Friction(_Directed):
    """Friction: φ = blend(ṡ) (coulomb + stribeck exp(-(ṡ/stribeck_velocity)²)) + viscous ṡ.

    ``stribeck`` is what breaking loose takes beyond sliding. A negative ``viscous`` is damping that the actuators add.
    """

    coulomb: float = 0.0
    viscous: float = 0.0
    stribeck: float = 0.0
    stribeck_velocity: float | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters; stribeck where its velocity is given."""
        return LINEAR[self.kind][: 2 if self.stribeck_velocity is None else 3]


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant(_Element):
    """A constant torque (N·m, N) along ``joint``."""

    joint: Along
    torque: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic(_AlongJoint):
    """A wave: φ = cosine · cos(order s) + sine · sin(order s), as cogging, or a counterweight on a level base.

    A counterweight turns with gravity and this does not: on a base that tilts, make it a mass.
    """

    cosine: float = 0.0
    sine: float = 0.0
    order: float = 1.0


Disturbance = Polynomial | PiecewiseCable | LinearSpring | SpringBetween | Friction | Constant | Harmonic
"""An element of any kind."""

KINDS: Mapping[str, type[Disturbance]] = {
    "polynomial": Polynomial,
    "cable": PiecewiseCable,
    "linear_spring": LinearSpring,
    "spring": SpringBetween,
    "friction": Friction,
    "constant": Constant,
    "harmonic": Harmonic,
}
"""What a robot file calls each kind."""

LINEAR: Mapping[str, tuple[str, ...]] = {
    "linear_spring": ("stiffness",),
    "spring": ("stiffness",),
    "friction": ("coulomb", "viscous", "stribeck"),
    "constant": ("torque",),
    "harmonic": ("cosine", "sine"),
}
"""Fields in which an element's torque is linear, where they are not the coefficients of polynomials."""


def _powers(coefficients: tuple[float, ...]) -> tuple[str, ...]:
    return tuple(f"p{power}" for power in range(len(coefficients)))


def _value(coefficients: tuple[float, ...], x: float) -> float:
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value
