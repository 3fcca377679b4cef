"""Fewer points: each only once, or evenly.

For the latter a grid of cubes lies over the cloud, and in each the point nearest to the middle of those in it is kept.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["evenly", "first_of_each"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

HALVINGS = 16
FINEST = 1 << 20
"""As many cubes along the longest side at most; three such numbers fit one of 64 bits."""
SAMPLE = 50_000
"""The width of the cubes is found with about so many of the points."""
COARSER = 0.97


def first_of_each(points: Array) -> Indices:
    """Return the indices, ascending, of the first of all equal points (n, 3)."""
    order = np.lexsort(points.T)
    in_order = points[order]
    is_first = np.ones(len(points), dtype=bool)
    is_first[1:] = (in_order[1:] != in_order[:-1]).any(axis=1)
    return np.sort(order[is_first])


def evenly(points: Array, most: int) -> Indices:
    """Return the indices, ascending, of at most ``most`` points that cover the cloud (n, 3) evenly."""
    if len(points) <= most:
        return np.arange(len(points))
    least = points.min(axis=0)
    scaled = (points - least) / (float((points.max(axis=0) - least).max()) or 1.0)
    along = _fineness(scaled[:: max(1, len(points) // max(SAMPLE, 4 * most))], most)
    cubes, of_cube = np.unique(_cubes(scaled, along), return_inverse=True)
    while len(cubes) > most:
        along *= COARSER
        cubes, of_cube = np.unique(_cubes(scaled, along), return_inverse=True)
    return _middles(scaled, of_cube)


def _fineness(scaled: Array, most: int) -> float:
    """How many cubes fit the longest side so that at most ``most`` have points in them."""
    low, high = 0.0, float(np.log2(FINEST))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        fits = len(np.unique(_cubes(scaled, 2.0**middle))) <= most
        low, high = (middle, high) if fits else (low, middle)
    return float(2.0**low)


def _cubes(scaled: Array, along: float) -> Indices:
    """The number of the cube that each point is in, of coordinates from 0 to 1; ``along`` need not be whole."""
    cells = (scaled * along).astype(np.int64).clip(0, int(np.ceil(along)) - 1)
    numbers: Indices = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    return numbers


def _middles(points: Array, of_cube: Indices) -> Indices:
    counts = np.bincount(of_cube)
    sums = np.stack([np.bincount(of_cube, weights=column) for column in points.T], axis=1)
    away = np.square(points - (sums / counts[:, None])[of_cube]).sum(axis=1)
    order = np.lexsort((away, of_cube))
    return np.sort(order[np.cumsum(counts) - counts])
