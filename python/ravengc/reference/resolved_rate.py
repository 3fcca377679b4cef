"""Resolved-rate motion as its literature writes it, by singular values, one step at a time.

    qd = J⁺ v                                              D. Whitney, IEEE Trans. Man-Machine Systems 10(2), 1969

Tasks are some linear and some further rows of the frame's motion; a base that moves takes its own twist off them. Near
singularities the inverse 1/σ becomes σ/(σ² + λ²) (C. Wampler; Y. Nakamura, H. Hanafusa, both 1986), with λ from one
of the laws of :func:`damped_inverse`. All vectors are in base axes B.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from ravengc.reference.arguments import checked
from ravengc.reference.kinematics import Array, cross, forward_kinematics, jacobian, origin, rotation

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec, Vector

NEGLIGIBLE = 1e-7
"""Singular values below this share of the largest one are zero: what is left of them in J Jᵀ is rounding."""


class Task(NamedTuple):
    """Rows of a task: ``J`` (k, n) and the velocity ``v`` (k,) that J qd should have."""

    J: Array
    v: Array


class Inverse(NamedTuple):
    """A damped inverse (n, k), the smallest singular value of J, and λ."""

    matrix: Array
    sigma_min: float
    damping: float


@checked
def task(
    spec: RobotSpec,
    q: npt.ArrayLike,
    twist: npt.ArrayLike,
    kind: str = "twist",
    frame: str = "tool",
    base_twist: npt.ArrayLike | None = None,
    pointing_axis: Vector = (0.0, 0.0, 1.0),
    remote_centre: Vector | None = None,
    characteristic_length: float = 1.0,
) -> Task:
    """The rows of a task at ``q`` (n,) and their velocity.

    ``twist`` is, by ``kind``: "twist" (6,) linear and angular velocity of the frame; "position" (3,) linear velocity;
    "pointing" (6,) as the twist, of which the turn about the frame's ``pointing_axis`` is free; "remote_centre" (6,)
    linear velocity of the frame's origin and of the trocar at ``remote_centre``, m. They are velocities in the world;
    ``base_twist`` (6,) is that of the base, linear first, of its origin. Lengths are measured in units of
    ``characteristic_length``, m.
    """
    given = np.asarray(twist, float)
    pose, rows = forward_kinematics(spec, q, frame), jacobian(spec, q, frame)
    tip, axis = origin(pose), rotation(pose) @ unit(np.asarray(pointing_axis))
    linear, angular = rows[:3], rows[3:]
    v = given[:3] - carried_by_base(base_twist, tip)
    if kind == "position":
        return Task(linear / characteristic_length, v / characteristic_length)
    if kind == "remote_centre":
        trocar = np.asarray(remote_centre, float)
        # The point of the shaft nearest the trocar, p + h z, moves with J_v - h z x J_w; across the shaft it has to
        # move as the trocar does.
        across = np.array(perpendicular(axis))
        beside = linear - np.cross(axis * ((trocar - tip) @ axis), angular, axisb=0, axisc=0)
        u = given[3:] - carried_by_base(base_twist, trocar)
        return Task(
            np.vstack([linear, across @ beside]) / characteristic_length,
            np.concatenate([v, across @ u]) / characteristic_length,
        )
    w = given[3:] - (0.0 if base_twist is None else np.asarray(base_twist, float)[3:])
    turns = np.eye(3) if kind == "twist" else np.array(perpendicular(axis))
    return Task(
        np.vstack([linear / characteristic_length, turns @ angular]),
        np.concatenate([v / characteristic_length, turns @ w]),
    )


def carried_by_base(base_twist: npt.ArrayLike | None, point: Array) -> Array:
    """How a point that is fixed to the base moves in the world: v + w x p."""
    if base_twist is None:
        return np.zeros(3)
    given = np.asarray(base_twist, float)
    return given[:3] + cross(given[3:], point)


def damped_inverse(J: Array, law: str = "adaptive", eps: float = 0.04, lambda_max: float = 0.04) -> Inverse:
    """A damped inverse of J (k, n), σ/(σ² + λ²) along each of its singular directions.

    "constant": λ = λ_max. "manipulability": λ² = λ_max² (1 - w/ε)² where w = sqrt(det J Jᵀ) < ε (Nakamura). "adaptive":
    λ² = λ_max² (1 - σ²/ε²) where the smallest singular value σ < ε (S. Chiaverini, B. Siciliano, O. Egeland 1994).
    "filtered": the same λ along that one direction alone (A. Maciejewski, C. Klein 1988; numerical filtering).
    """
    U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
    least, w = float(sigma[-1]), float(np.prod(sigma))
    squared = {
        "constant": lambda_max**2,
        "manipulability": lambda_max**2 * max(0.0, 1.0 - w / eps) ** 2,
        "adaptive": lambda_max**2 * max(0.0, 1.0 - (least / eps) ** 2),
        "filtered": lambda_max**2 * max(0.0, 1.0 - (least / eps) ** 2),
    }[law]
    along = np.full(len(sigma), squared)
    if law == "filtered":
        along[:-1] = 0.0
    gain = np.where(sigma > NEGLIGIBLE * max(sigma[0], 1e-300), sigma / (sigma**2 + along + 1e-300), 0.0)
    return Inverse(Vt.T @ (gain[:, None] * U.T), least, math.sqrt(squared))


def selectively_damped(J: Array, v: Array, rate_max: float) -> Array:
    """The rates (n,) of selectively damped least squares, S. Buss and J. Kim, J. Graphics Tools 10(3), 2005.

    The step along each singular direction alone is cut to γ = rate_max min(1, N/M), where M says how far the joints
    would move the tool if all they do added up, and N = 1 how far the tool should move; their sum to rate_max.
    """
    U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
    reach = np.linalg.norm(J, axis=0)
    rates = np.zeros(J.shape[1])
    for u, s, row in zip(U.T, sigma, Vt, strict=True):
        if s > NEGLIGIBLE * sigma[0]:
            most = rate_max * min(1.0, s / (np.abs(row) @ reach))
            rates += shortened(row * (u @ v) / s, most)
    return shortened(rates, rate_max)


def shortened(rates: Array, most: float) -> Array:
    """The same direction, no number of which is larger than ``most``."""
    return rates * min(1.0, most / max(float(np.max(np.abs(rates))), 1e-300))


def with_null_motion(J: Array, inverse: Array, v: Array, wish: Array) -> Array:
    """J⁺ v + (1 - J⁺ J) z, A. Liégeois, IEEE Trans. SMC 7(12), 1977: what is left of z does not move the task."""
    return inverse @ (v - J @ wish) + wish


def uniform_scale(rates: Array, lower: Array, upper: Array) -> float:
    """The largest s in [0, 1] for which s times the rates is between the bounds, which hold zero between them."""
    bound = np.where(rates > 0.0, upper, lower)
    moving = rates != 0.0
    return float(min(1.0, np.min(bound[moving] / rates[moving], initial=1.0)))


def towards(rates: Array, goal: Array, acceleration_max: Array, dt: float) -> Array:
    """On from the rates of the last step straight to the goal, as far as the accelerations let every joint go."""
    change = goal - rates
    moving = change != 0.0
    return rates + change * min(1.0, np.min(acceleration_max[moving] * dt / np.abs(change[moving]), initial=1.0))


def rotation_vector(R: Array) -> Array:
    """The logarithm (3,) of a rotation: axis times angle, 0 to π."""
    # R - Rᵀ is sin(angle) S(2 axis); towards π it vanishes, and R + Rᵀ shows the axis up to its sign.
    twice = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    s, c = float(np.linalg.norm(twice)), float(np.trace(R)) - 1.0
    angle = math.atan2(s, c)
    if c > -1.9:
        return twice * (angle / s if s > 1e-12 else 0.5)
    outer = (R + R.T) / 2.0 - np.eye(3) * (c / 2.0)
    column = outer[:, int(np.argmax(np.diag(outer)))]
    axis = unit(column)
    return axis * (-angle if axis @ twice < 0.0 else angle)


def pointing_error(axis: Array, wanted: Array) -> Array:
    """The shortest turn (3,), rad, that lays ``axis`` on ``wanted``; about any perpendicular where they are opposed."""
    a, d = unit(axis), unit(wanted)
    turn = cross(a, d)
    s = float(np.linalg.norm(turn))
    if s > 1e-12:
        return turn * (math.atan2(s, float(a @ d)) / s)
    return np.zeros(3) if a @ d > 0.0 else np.asarray(perpendicular(a)[0]) * math.pi


def unit(v: Array) -> Array:
    """The same direction, of length 1."""
    scaled: Array = np.asarray(v, float) / np.linalg.norm(v)
    return scaled


def perpendicular(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors across a unit vector and each other."""
    least = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = unit(cross(axis, least))
    return first, cross(axis, first)
