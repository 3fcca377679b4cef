"""Fewer points, evenly: a grid of cubes over the cloud, and in each the point nearest to the middle of those in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["evenly"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

HALVINGS = 18
FINEST = 1 << 20
"""As many cubes along the longest side at most; three such numbers fit one of 64 bits."""


def evenly(points: Array, most: int) -> Indices:
    """Return the indices, ascending, of at most ``most`` points that cover the cloud (n, 3) evenly."""
    if len(points) <= most:
        return np.arange(len(points))
    low, high = 0.0, float(np.log2(FINEST))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        fits = len(np.unique(_cubes(points, 2.0**middle))) <= most
        low, high = (middle, high) if fits else (low, middle)
    return _middles(points, _cubes(points, 2.0**low))


def _cubes(points: Array, along: float) -> Indices:
    """The number of the cube that each point is in; ``along`` (real) of them fit the longest side."""
    least = points.min(axis=0)
    size = float((points.max(axis=0) - least).max()) or 1.0
    cells = np.floor((points - least) / size * along).clip(0, FINEST).astype(np.int64)
    numbers: Indices = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    return numbers


def _middles(points: Array, cubes: Indices) -> Indices:
    _, of_cube, counts = np.unique(cubes, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(of_cube, weights=column) for column in points.T], axis=1)
    away = np.square(points - (sums / counts[:, None])[of_cube]).sum(axis=1)
    order = np.lexsort((away, of_cube))
    starts = np.cumsum(counts) - counts
    return np.sort(order[starts])
