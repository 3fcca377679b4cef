"""Rotations as files write them: roll, pitch and yaw to a matrix, and an inertia turned from one frame into another."""

from __future__ import annotations

from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ravengc.spec import Matrix

__all__ = ["Inertia", "inertia_from_matrix", "matrix_from_inertia", "rotate_inertia", "rotation_from_rpy"]

Inertia = tuple[float, float, float, float, float, float]
"""kg·m², order xx xy xz yy yz zz."""


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Matrix:
    """Return Rz(yaw) Ry(pitch) Rx(roll): rad, about the fixed axes x, y, z in turn, as URDF has them."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def matrix_from_inertia(inertia: Inertia) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Return the symmetric 3x3 matrix of the six numbers."""
    xx, xy, xz, yy, yz, zz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64)


def inertia_from_matrix(matrix: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> Inertia:
    """Return the six numbers of a symmetric 3x3 matrix, its upper triangle row by row."""
    xx, xy, xz, yy, yz, zz = matrix[np.triu_indices(3)].tolist()
    return (xx, xy, xz, yy, yz, zz)


def rotate_inertia(rotation: Matrix, inertia: Inertia) -> Inertia:
    """Return R I Rᵀ, the inertia in outer axes, where R = ``rotation`` leads from the inertia's axes to outer ones."""
    r = np.array(rotation)
    return inertia_from_matrix(r @ matrix_from_inertia(inertia) @ r.T)
