"""Gravity torque as the paper writes it, and the same from the potential energy.

A. Lewis, B. Hannaford, "Dynamically Evaluated Gravity Compensation for the RAVEN Surgical Robot", equations (1)-(3).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ravengc.reference.arguments import checked
from ravengc.reference.kinematics import (
    NO_INERTIA,
    Array,
    Inertia,
    Payload,
    PlacedLink,
    Scalar,
    carried,
    coupling,
    cross,
    inertia_matrix,
    moving,
    origin,
    place,
    real_or_complex,
    rotation,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.spec import LinkSpec, RobotSpec, Vector

STEP = 1e-30
"""Step of the complex-step derivative, f'(x) = Im f(x + ih)/h: without subtraction it has no rounding to trade."""


@checked
def gravity_torque(spec: RobotSpec, q: npt.ArrayLike, g: npt.ArrayLike, payload: Payload | None = None) -> Array:
    """Torques (n,) that hold the robot at ``q`` against the gravity field ``g`` (3,) in base axes: eqs (1)-(3)."""
    dtype = real_or_complex(q, g)
    placed = place(spec, np.asarray(q, dtype), payload)
    links = [[body for body in placed if i in body.joints] for i in range(len(spec.moving_links))]
    tau = [hold(joint, beyond, np.asarray(g, dtype)) for joint, beyond in zip(moving(placed), links, strict=True)]
    return on_coordinates(spec, tau)


def hold(joint: PlacedLink, links: list[PlacedLink], g: Array) -> Scalar:
    """Torque or force of one joint that carries ``links``, everything expressed in the frame i of its axis ẑ."""
    z = joint.axis
    to_joint = rotation(joint.joint_frame).T
    g_i = to_joint @ g  # (2)  ⁱg = ⁱTs ˢg
    if joint.link.joint == "prismatic":
        return -z @ sum(g_i * body.link.mass for body in links)  # (3)  f_i = -ẑ · Σ ⁱg m_k
    r = [to_joint @ (body.com - origin(joint.joint_frame)) for body in links]
    return -z @ sum(cross(r_k, g_i * body.link.mass) for r_k, body in zip(r, links, strict=True))  # (1)


def on_coordinates(spec: RobotSpec, tau: list[Scalar]) -> Array:
    """Torques on the user's coordinates (n,) from those of the mechanism's joints: Cᵀ tau."""
    mechanism = np.array(tau)
    torques: Array = coupling(spec, mechanism.dtype)[0].T @ mechanism
    return torques


@checked
def potential_energy(spec: RobotSpec, q: npt.ArrayLike, g: npt.ArrayLike, payload: Payload | None = None) -> Scalar:
    """Potential energy U = -Σ m g·p (J) of the moving links, zero at the origin of B."""
    dtype = real_or_complex(q, g)
    bodies = carried(place(spec, np.asarray(q, dtype), payload))
    return -sum((body.link.mass * (np.asarray(g, dtype) @ body.com) for body in bodies), dtype.type(0))


@checked
def gravity_torque_from_energy(
    spec: RobotSpec, q: npt.ArrayLike, g: npt.ArrayLike, payload: Payload | None = None
) -> Array:
    """The same torques (n,) as :func:`gravity_torque`, as the gradient tau = +∂U/∂q by complex step."""
    return gradient(lambda x: potential_energy(spec, x, g, payload), q)


@checked
def gravity_stiffness(spec: RobotSpec, q: npt.ArrayLike, g: npt.ArrayLike, payload: Payload | None = None) -> Array:
    """Derivative ∂tau_g/∂q (n, n) of eqs (1)-(3) by complex step: row i is joint i, column j the coordinate moved."""
    return gradient(lambda x: gravity_torque(spec, x, g, payload), q)


@checked
def center_of_mass(spec: RobotSpec, q: npt.ArrayLike, payload: Payload | None = None) -> Array:
    """Centre of mass (3,) of the moving links, in B (m)."""
    bodies = carried(place(spec, q, payload))
    mass = sum(body.link.mass for body in bodies)
    moment = sum((body.link.mass * body.com for body in bodies), np.zeros(3, real_or_complex(q)))
    center: Array = moment / mass
    return center


@checked
def gravity_regressor(spec: RobotSpec, q: npt.ArrayLike, g: npt.ArrayLike) -> Array:
    """Matrix Y (n, 4·bodies) with tau = Y π, π = [m, m·cx, m·cy, m·cz] of each moving link in its link frame.

    Each column is a difference of two evaluations of eqs (1)-(3), a unit mass at one place minus one at another.
    """
    columns = [
        column
        for link in spec.moving_links
        for column in first_moment_columns(spec, link, lambda one: gravity_torque(one, q, g))
    ]
    return np.column_stack(columns)


def first_moment_columns(spec: RobotSpec, link: LinkSpec, torque: Callable[[RobotSpec], Array]) -> list[Array]:
    """Columns m, hx, hy, hz: a unit mass at the link's origin, and what moving it by 1 m along x, y, z adds."""
    at_origin = torque(with_one_mass(spec, link, 1.0, (0.0, 0.0, 0.0)))
    steps: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    return [at_origin, *(torque(with_one_mass(spec, link, 1.0, step)) - at_origin for step in steps)]


def with_one_mass(
    spec: RobotSpec, only: LinkSpec, mass: float, com: Vector, origin_inertia: Inertia = NO_INERTIA
) -> RobotSpec:
    """The robot with all links massless but one, whose inertia about the LINK-FRAME ORIGIN is given (any numbers)."""
    body = replace(only, mass=mass, com=com, inertia=inertia_about_com(mass, com, origin_inertia))
    empty = [replace(link, mass=0.0, com=(0.0, 0.0, 0.0), inertia=NO_INERTIA) for link in spec.links]
    return replace(spec, links=tuple(body if link.name == only.name else link for link in empty))


def inertia_about_com(mass: float, com: Vector, inertia: Inertia) -> Inertia:
    """Parallel axes: I_com = I_origin - m (c·c 1 - c cᵀ), both as xx xy xz yy yz zz."""
    (x, y, z), (xx, xy, xz, yy, yz, zz) = com, inertia
    return (
        xx - mass * (y * y + z * z),
        xy + mass * x * y,
        xz + mass * x * z,
        yy - mass * (x * x + z * z),
        yz + mass * y * z,
        zz - mass * (x * x + y * y),
    )


@checked
def inertial_parameters(spec: RobotSpec, payload: Payload | None = None) -> Array:
    """Parameters (10·bodies,) of the moving links: m, m·c (3), inertia about the link-frame origin xx xy xz yy yz zz.

    The links (and payload) fixed to a moving link, directly or through others, are part of it.
    """
    placed = place(spec, np.zeros(len(spec.coordinate_names)), payload)
    parts = [[body for body in placed if body.joints[-1:] == (i,)] for i in range(len(spec.moving_links))]
    return np.concatenate([merged(joint, bodies) for joint, bodies in zip(moving(placed), parts, strict=True)])


def merged(joint: PlacedLink, bodies: list[PlacedLink]) -> Array:
    """Sum of the ten parameters of ``bodies`` in the link frame of ``joint``."""
    total = np.zeros(10)
    for body in bodies:
        turn = rotation(joint.frame).T @ rotation(body.frame)
        c = rotation(joint.frame).T @ (body.com - origin(joint.frame))
        parallel = body.link.mass * (c @ c * np.eye(3) - np.outer(c, c))
        about_origin = turn @ inertia_matrix(body.link, np.dtype(float)) @ turn.T + parallel
        total += np.array([body.link.mass, *(body.link.mass * c), *about_origin[np.triu_indices(3)]])
    return total


def gradient(function: Callable[[Array], Any], q: npt.ArrayLike) -> Array:
    """Derivative of a scalar or vector function of the coordinates by complex step; the last axis is the coordinate."""
    units = np.eye(len(np.asarray(q)), dtype=real_or_complex(q))
    return np.stack([derivative(function, q, unit) for unit in units], axis=-1)


def derivative(function: Callable[[Array], Any], q: npt.ArrayLike, direction: npt.ArrayLike) -> Array:
    """Derivative of a function of the coordinates along ``direction`` by complex step."""
    return np.asarray(function(np.asarray(q) + 1j * STEP * np.asarray(direction))).imag / STEP
