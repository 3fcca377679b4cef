"""Orientations as angles of three hinges in a row, many at once: R = rot(u1, a1) rot(u2, a2) rot(u3, a3).

With the axes u as rows of U, U R U^T is Rx(a1) Ry(a2) Rz(a3), whose angles can be read off unless a2 is +-90 deg,
where the first and the third axis are parallel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ravengc.errors import ConfigError

__all__ = ["hinge_angles", "hinge_rates", "orientations", "rotations"]

Array = NDArray[np.float64]

FURTHEST = np.deg2rad(80.0)
"""Largest angle of the middle hinge: beyond it the others turn ever faster."""
TRIPLES = tuple(
    np.array(rows, dtype=np.float64)
    for rows in (
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
        ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
        ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        ((0, 1, 0), (1, 0, 0), (0, 0, -1)),
        ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    )
)
"""Hinge axes to choose from: x, y, z in all orders, right-handed."""


def rotations(vectors: Array) -> Array:
    """Rotations (k, 3, 3) about vectors (k, 3) by their lengths (rad)."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.array(((zero, -z, y), (z, zero, -x), (-y, x, zero))).transpose(2, 0, 1)
    half = np.sinc(angle / (2.0 * np.pi))
    turned: Array = np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * half * half * (cross @ cross)
    return turned


def orientations(times: Array, rates: Array, middle: Array, start: Array) -> Array:
    """R_WB (k + 1, 3, 3) of a base that turns with these rates (body axes) at the times and amid them, from ``start``.

    Fourth order in the time between: each step turns about h (w0 + 4 wm + w1) / 6 + h^2 (w0 x w1) / 12.
    """
    h = np.diff(times)[:, None]
    turns = h / 6.0 * (rates[:-1] + 4.0 * middle + rates[1:]) + h**2 / 12.0 * np.cross(rates[:-1], rates[1:])
    found = [start]
    for step in rotations(turns):
        found.append(found[-1] @ step)
    return np.array(found)


def hinge_angles(orientation: Array) -> tuple[Array, Array]:
    """Axes (3, 3) and continuous angles (k, 3) for orientations (k, 3, 3); ConfigError if no order of axes serves."""
    bent = [float(np.abs(np.arcsin(np.clip(_element(orientation, axes, 0, 2), -1.0, 1.0))).max()) for axes in TRIPLES]
    axes = TRIPLES[int(np.argmin(bent))]
    if min(bent) > FURTHEST:
        raise ConfigError(
            f"the base turns by up to {np.rad2deg(min(bent)):.0f} deg about all its axes; expected a motion that, with "
            f"hinges in the best order, keeps the middle one within {np.rad2deg(FURTHEST):.0f} deg"
        )
    first = np.arctan2(-_element(orientation, axes, 1, 2), _element(orientation, axes, 2, 2))
    second = np.arcsin(np.clip(_element(orientation, axes, 0, 2), -1.0, 1.0))
    third = np.arctan2(-_element(orientation, axes, 0, 1), _element(orientation, axes, 0, 0))
    return axes, np.unwrap(np.stack((first, second, third), axis=1), axis=0)


def hinge_rates(axes: Array, angles: Array, rates: Array, accelerations: Array) -> tuple[Array, Array]:
    """First and second derivatives of the angles, (k, 3) each, from angular velocity and acceleration in base axes.

    w = E a' with the columns R3^T R2^T u1, R3^T u2, u3 of E; w' = E a'' and what turning axes add.
    """
    third = rotations(angles[:, 2:] * axes[2]).transpose(0, 2, 1)
    second = rotations(angles[:, 1:2] * axes[1]).transpose(0, 2, 1)
    turning = np.stack((third @ second @ axes[0], third @ axes[1], np.tile(axes[2], (len(angles), 1))), axis=2)
    first: Array = np.linalg.solve(turning, rates[..., None])[..., 0]
    one, two, three = (turning[:, :, i] * first[:, i : i + 1] for i in range(3))
    added = np.cross(one, two) + np.cross(one + two, three)
    return first, np.linalg.solve(turning, (accelerations - added)[..., None])[..., 0]


def _element(orientation: Array, axes: Array, row: int, column: int) -> Array:
    """One element of U R U^T."""
    element: Array = axes[row] @ orientation @ axes[column]
    return element
