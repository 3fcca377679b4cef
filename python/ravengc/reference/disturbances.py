"""What acts beside the masses: cables, springs, friction, offsets, each as its formula says, column by column."""

from __future__ import annotations

from typing import TYPE_CHECKING, assert_never

import numpy as np

from ravengc.disturbances import (
    Constant,
    Friction,
    Harmonic,
    LinearSpring,
    PiecewiseCable,
    Polynomial,
    SpringBetween,
)
from ravengc.reference.arguments import checked
from ravengc.reference.gravity import gradient
from ravengc.reference.kinematics import Array, Scalar, place, pose_matrix, real_or_complex, transform

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from ravengc.disturbances import Along, Disturbance, Vector
    from ravengc.spec import RobotSpec

    AlongJoint = Polynomial | PiecewiseCable | LinearSpring | Friction | Harmonic


@checked
def disturbance_torque(spec: RobotSpec, q: npt.ArrayLike, qd: npt.ArrayLike | None = None) -> Array:
    """Torques (n,) that hold or move the robot against its disturbance elements; at rest without ``qd``."""
    torque = np.zeros(len(spec.coordinate_names), real_or_complex(q))
    for element in spec.disturbances:
        columns = element_columns(spec, element, q, qd)
        torque += sum(c * column for c, column in zip(element.parameters, columns, strict=True))
    return torque


@checked
def disturbance_regressor(spec: RobotSpec, q: npt.ArrayLike, qd: npt.ArrayLike | None = None) -> Array:
    """Matrix Y (n, columns) with disturbance torque = Y p, a column for each parameter of each element, in order."""
    columns = [column for element in spec.disturbances for column in element_columns(spec, element, q, qd)]
    return np.column_stack(columns) if columns else np.zeros((len(spec.coordinate_names), 0))


@checked
def disturbance_parameters(spec: RobotSpec) -> Array:
    """Parameters p (columns,) of all elements, in order."""
    return np.array([parameter for element in spec.disturbances for parameter in element.parameters])


@checked
def spring_energy(spec: RobotSpec, q: npt.ArrayLike) -> Scalar:
    """Energy in the springs (J), linear and between bodies: their share of the torque is its gradient."""
    energy = real_or_complex(q).type(0)
    for element in spec.disturbances:
        if isinstance(element, LinearSpring):
            stretch = along(spec, element.of or element.joint) @ np.asarray(q) - element.rest
            energy += element.stiffness * stretch**2 / 2
        elif isinstance(element, SpringBetween):
            energy += element.stiffness * unit_energy(spec, element, q)
    return energy


def element_columns(spec: RobotSpec, element: Disturbance, q: npt.ArrayLike, qd: npt.ArrayLike | None) -> list[Array]:
    """What a unit of each parameter gives: columns (n,)."""
    if isinstance(element, SpringBetween):
        return [spring_column(spec, element, q)]
    w = along(spec, element.joint)
    if isinstance(element, Constant):
        return [w]
    v = along(spec, element.of or element.joint)
    rate = 0.0 if qd is None else v @ np.asarray(qd)
    return [w * value for value in values(element, v @ np.asarray(q), rate)]


def along(spec: RobotSpec, direction: Along) -> Array:
    """A direction in the coordinates (n,): the unit vector of a name, or the numbers given."""
    if isinstance(direction, str):
        return np.array([float(name == direction) for name in spec.coordinate_names])
    return np.array(direction)


def values(element: AlongJoint, s: Scalar, sd: Scalar) -> list[Scalar]:
    """φ of a unit of each parameter."""
    match element:
        case Polynomial():
            weight = {"both": 1.0, "positive": alpha(element, sd), "negative": 1.0 - alpha(element, sd)}
            x = clamped(s, element.range)
            return [weight[element.direction] * power for power in powers(x, len(element.coefficients))]
        case PiecewiseCable():
            return cable_values(element, clamped(s, element.range))
        case LinearSpring():
            return [s - element.rest]
        case Friction():
            return friction_values(element, sd)
        case Harmonic():
            return [np.cos(element.order * s), np.sin(element.order * s)]
        case _:
            assert_never(element)


def cable_values(element: PiecewiseCable, s: Scalar) -> list[Scalar]:
    """Powers of s minus the knot on the left in the piece that holds, zeros in the others."""
    holds = sum(s.real >= knot for knot in element.knots)
    origin = element.knots[max(holds - 1, 0)]
    pieces = [powers(s - origin, len(piece)) for piece in element.pieces]
    return [power if i == holds else 0.0 for i, piece in enumerate(pieces) for power in piece]


def powers(x: Scalar, count: int) -> list[Scalar]:
    """1, x, x², ...; what is no number has no power 1 either."""
    return [x**k if k else 1.0 + 0.0 * x for k in range(count)]


def friction_values(element: Friction, v: Scalar) -> list[Scalar]:
    """Columns Coulomb, viscous and, where its velocity is given, Stribeck."""
    sign = blend(element, v)
    columns = [sign, v]
    if element.stribeck_velocity is not None:
        columns.append(sign * np.exp(-((v / element.stribeck_velocity) ** 2)))
    return columns


def clamped(s: Scalar, interval: Sequence[float] | None) -> Scalar:
    """``s``, or the end of the interval that it is beyond."""
    if interval is None:
        return s
    low, high = interval
    return low if s.real < low else high if s.real > high else s


def blend(element: Polynomial | Friction, v: Scalar) -> Scalar:
    """How surely the motion goes which way, -ratio to ratio."""
    beyond, width = np.abs(v) - element.dead_band, element.saturation - element.dead_band
    if not beyond > 0.0:
        return 0.0 * v
    if element.blend == "tanh":
        return np.sign(v) * element.ratio * np.tanh(beyond / width)
    return np.sign(v) * (element.ratio if np.abs(v) >= element.saturation else element.ratio * beyond / width)


def alpha(element: Polynomial, v: Scalar) -> Scalar:
    """Weight of what holds in positive direction: 1/2 at rest."""
    return 0.5 + 0.5 * blend(element, v)


def spring_column(spec: RobotSpec, spring: SpringBetween, q: npt.ArrayLike) -> Array:
    """Torques (n,) of a unit of stiffness: the gradient of the energy by complex step; none where the points meet."""
    if spring.rest_length > 0.0 and not distance(spec, spring, np.asarray(q)).any():
        return np.zeros(len(spec.coordinate_names))
    return gradient(lambda x: unit_energy(spec, spring, x), q)


def unit_energy(spec: RobotSpec, spring: SpringBetween, q: npt.ArrayLike) -> Scalar:
    """Energy of a unit of stiffness: (l - l0)²/2."""
    d = distance(spec, spring, q)
    if spring.rest_length == 0.0:
        return d @ d / 2
    return (np.sqrt(d @ d) - spring.rest_length) ** 2 / 2


def distance(spec: RobotSpec, spring: SpringBetween, q: npt.ArrayLike) -> Array:
    """From one point to the other, in B (m)."""
    frames = {body.link.name: body.frame for body in place(spec, q)}
    frames["base"] = pose_matrix(spec.base, real_or_complex(q))

    def at(body: str, point: Vector) -> Array:
        return transform(frames[body], np.asarray(point, frames[body].dtype))

    return at(spring.body_b, spring.point_b) - at(spring.body_a, spring.point_a)
