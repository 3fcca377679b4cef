"""Dynamics on a moving base: Newton and Euler for every link about its centre of mass, in base axes.

The base moves with angular velocity ``w``, angular acceleration ``dw`` and the specific force ``f`` = a - g of its
origin, all (3,) in axes B. Starting the recursion with f makes gravity one of the accelerations, with no other term.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from ravengc.reference.arguments import checked
from ravengc.reference.gravity import (
    derivative,
    first_moment_columns,
    gradient,
    on_coordinates,
    potential_energy,
    with_one_mass,
)
from ravengc.reference.kinematics import (
    Array,
    Inertia,
    Payload,
    PlacedLink,
    Scalar,
    coupling,
    cross,
    moving,
    origin,
    place,
    point_jacobian,
    real_or_complex,
)

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

AT_REST = (0.0, 0.0, 0.0)
UNIT_INERTIAS: tuple[Inertia, ...] = (
    (1.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
    (0.0, 0.0, 1.0, 0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0, 1.0, 0.0, 0.0),
    (0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
    (0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
)


class Motion(NamedTuple):
    """Motion of a rigid body in axes B.

    Angular velocity ``w`` (rad/s), angular acceleration ``dw`` (rad/s²), specific force ``f`` (m/s²) of its ``point``.
    """

    w: Array
    dw: Array
    f: Array
    point: Array

    def at(self, point: Array) -> Array:
        """Specific force of another point of the body: f + dw x r + w x (w x r)."""
        r = point - self.point
        f: Array = self.f + cross(self.dw, r) + cross(self.w, cross(self.w, r))
        return f


class Wrench(NamedTuple):
    """What moves a link: force through its centre of mass ``com`` and moment about it, in axes B."""

    body: PlacedLink
    com: Array
    force: Array
    moment: Array


@checked
def inverse_dynamics(
    spec: RobotSpec,
    q: npt.ArrayLike,
    qd: npt.ArrayLike,
    qdd: npt.ArrayLike,
    f: npt.ArrayLike,
    w: npt.ArrayLike = AT_REST,
    dw: npt.ArrayLike = AT_REST,
    payload: Payload | None = None,
) -> Array:
    """Torques (n,) for the motion ``q, qd, qdd`` on a base that moves with ``f, w, dw``: recursive Newton-Euler."""
    wrenches = link_wrenches(spec, (q, qd, qdd), (f, w, dw), payload)
    joints = moving([wrench.body for wrench in wrenches])
    links = [[wrench for wrench in wrenches if i in wrench.body.joints] for i in range(len(joints))]
    return on_coordinates(spec, [joint_torque(joint, beyond) for joint, beyond in zip(joints, links, strict=True)])


def joint_torque(joint: PlacedLink, wrenches: list[Wrench]) -> Scalar:
    """Component along one joint's axis of all that moves the links it carries."""
    if joint.link.joint == "prismatic":
        return joint.z @ sum(wrench.force for wrench in wrenches)
    return joint.z @ sum(wrench.moment + cross(wrench.com - joint.o, wrench.force) for wrench in wrenches)


@checked
def base_wrench(
    spec: RobotSpec,
    q: npt.ArrayLike,
    qd: npt.ArrayLike,
    qdd: npt.ArrayLike,
    f: npt.ArrayLike,
    w: npt.ArrayLike = AT_REST,
    dw: npt.ArrayLike = AT_REST,
    payload: Payload | None = None,
) -> Array:
    """Force (N), then moment about the origin of B (N·m), that the mount exerts on the arm: (6,) in axes B.

    Links that are fixed to the base hang on the same mount, so they count here.
    """
    wrenches = link_wrenches(spec, (q, qd, qdd), (f, w, dw), payload)
    force = sum(wrench.force for wrench in wrenches)
    moment = sum(wrench.moment + cross(wrench.com, wrench.force) for wrench in wrenches)
    return np.concatenate([force, moment])


def link_wrenches(
    spec: RobotSpec, joint_motion: tuple[npt.ArrayLike, ...], base: tuple[npt.ArrayLike, ...], payload: Payload | None
) -> list[Wrench]:
    """Newton and Euler for every link: F = m a_c, N = I dw + w x I w."""
    dtype = real_or_complex(*joint_motion, *base)
    q, qd, qdd = (np.asarray(values, dtype) for values in joint_motion)
    matrix = coupling(spec, dtype)[0]
    placed = place(spec, q, payload)
    wrenches = []
    for body, motion in zip(placed, link_motions(placed, matrix @ qd, matrix @ qdd, base), strict=True):
        force = body.link.mass * motion.at(body.com)
        moment = body.inertia @ motion.dw + cross(motion.w, body.inertia @ motion.w)
        wrenches.append(Wrench(body, body.com, force, moment))
    return wrenches


def link_motions(placed: list[PlacedLink], qd: Array, qdd: Array, base: tuple[npt.ArrayLike, ...]) -> list[Motion]:
    """Motion of every link, from the base outward; ``qd`` and ``qdd`` are those of the mechanism's joints."""
    f, w, dw = (np.asarray(vector, qd.dtype) for vector in base)
    motions: dict[str | None, Motion] = {None: Motion(w, dw, f, np.zeros(3, qd.dtype))}
    for body in placed:
        parent = motions[body.link.parent]
        if body.link.joint == "fixed":
            motions[body.link.name] = parent
        else:
            motions[body.link.name] = moved(body, parent, qd[body.joints[-1]], qdd[body.joints[-1]])
    return [motions[body.link.name] for body in placed]


def moved(body: PlacedLink, parent: Motion, qd: Scalar, qdd: Scalar) -> Motion:
    """Motion of a link whose joint moves with rate ``qd`` and acceleration ``qdd`` relative to its parent."""
    z = body.z
    if body.link.joint == "revolute":
        w = parent.w + z * qd
        dw = parent.dw + z * qdd + cross(parent.w, z) * qd
        return Motion(w, dw, parent.at(body.o), body.o)  # a point on the axis belongs to both bodies
    point = origin(body.frame)
    f = parent.at(point) + z * qdd + 2 * cross(parent.w, z) * qd  # Coriolis
    return Motion(parent.w, parent.dw, f, point)


@checked
def mass_matrix(spec: RobotSpec, q: npt.ArrayLike, payload: Payload | None = None) -> Array:
    """Mass matrix M (n, n) of the kinetic energy T = ½ qdᵀ M qd: M = Σ m Jvᵀ Jv + Jwᵀ I Jw at the centres of mass."""
    placed = place(spec, q, payload)
    joints = len(spec.moving_links)
    mass = np.zeros((joints, joints), real_or_complex(q))
    for body in placed:
        linear, angular = point_jacobian(placed, body.com, body.joints)
        mass = mass + body.link.mass * linear.T @ linear + angular.T @ body.inertia @ angular
    matrix = coupling(spec, mass.dtype)[0]
    coupled: Array = matrix.T @ mass @ matrix
    return coupled


@checked
def kinetic_energy(
    spec: RobotSpec,
    q: npt.ArrayLike,
    qd: npt.ArrayLike,
    v: npt.ArrayLike = AT_REST,
    w: npt.ArrayLike = AT_REST,
    payload: Payload | None = None,
) -> Scalar:
    """Kinetic energy (J) of all links; the base's origin moves with ``v`` (m/s), its axes turn with ``w`` (rad/s)."""
    dtype = real_or_complex(q, qd, v, w)
    placed = place(spec, np.asarray(q, dtype), payload)
    rates = coupling(spec, dtype)[0] @ np.asarray(qd, dtype)
    energy = dtype.type(0)
    for body in placed:
        linear, angular = point_jacobian(placed, body.com, body.joints)
        velocity = np.asarray(v, dtype) + cross(np.asarray(w, dtype), body.com) + linear @ rates
        spin = np.asarray(w, dtype) + angular @ rates
        energy = energy + (body.link.mass * (velocity @ velocity) + spin @ body.inertia @ spin) / 2
    return energy


@checked
def forward_dynamics(
    spec: RobotSpec,
    q: npt.ArrayLike,
    qd: npt.ArrayLike,
    tau: npt.ArrayLike,
    f: npt.ArrayLike,
    w: npt.ArrayLike = AT_REST,
    dw: npt.ArrayLike = AT_REST,
    payload: Payload | None = None,
) -> Array:
    """Accelerations (n,) under the torques ``tau``: M qdd = tau - tau(q, qd, qdd = 0)."""
    bias = inverse_dynamics(spec, q, qd, np.zeros_like(np.asarray(qd)), f, w, dw, payload)
    return solve(mass_matrix(spec, q, payload), np.asarray(tau) - bias)


@checked
def inverse_dynamics_regressor(
    spec: RobotSpec,
    q: npt.ArrayLike,
    qd: npt.ArrayLike,
    qdd: npt.ArrayLike,
    f: npt.ArrayLike,
    w: npt.ArrayLike = AT_REST,
    dw: npt.ArrayLike = AT_REST,
) -> Array:
    """Matrix Y (n, 10·bodies) with tau = Y π for the π of :func:`inertial_parameters`.

    Every column is what inverse dynamics gives for one link with a unit of one parameter and nothing else.
    """

    def torque(one: RobotSpec) -> Array:
        return inverse_dynamics(one, q, qd, qdd, f, w, dw)

    columns = []
    for link in spec.moving_links:
        columns += first_moment_columns(spec, link, torque)
        columns += [torque(with_one_mass(spec, link, 0.0, AT_REST, unit)) for unit in UNIT_INERTIAS]
    return np.column_stack(columns)


@checked
def lagrangian_torque(
    spec: RobotSpec,
    q: npt.ArrayLike,
    qd: npt.ArrayLike,
    qdd: npt.ArrayLike,
    g: npt.ArrayLike,
    payload: Payload | None = None,
) -> Array:
    """Torques (n,) of the same motion on a base at rest, by Lagrange: d/dt ∂T/∂qd - ∂T/∂q + ∂U/∂q.

    With T = ½ qdᵀ M qd that is M qdd + Ṁ qd - ½ ∂(qdᵀ M qd)/∂q + ∂U/∂q, every derivative by complex step.
    """
    rates, accelerations = np.asarray(qd), np.asarray(qdd)
    rate_of_mass = derivative(lambda x: mass_matrix(spec, x, payload), q, rates)
    slope = gradient(lambda x: rates @ mass_matrix(spec, x, payload) @ rates / 2, q)
    weight = gradient(lambda x: potential_energy(spec, x, g, payload), q)
    torques: Array = mass_matrix(spec, q, payload) @ accelerations + rate_of_mass @ rates - slope + weight
    return torques


def solve(matrix: Array, right: Array) -> Array:
    """Solution of a symmetric positive definite system by elimination, for any element type."""
    rows = np.column_stack([matrix, right])
    size = len(right)
    for k in range(size):
        rows[k] = rows[k] / rows[k, k]
        for i in range(size):
            if i != k:
                rows[i] = rows[i] - rows[i, k] * rows[k]
    return rows[:, -1]
