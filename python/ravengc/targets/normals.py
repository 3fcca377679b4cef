"""Normals where a file has none: the direction in which a point's neighbours spread least, turned consistently.

H. Hoppe, T. DeRose, T. Duchamp, J. McDonald, W. Stuetzle, "Surface reconstruction from unorganized points", SIGGRAPH
1992: the normal of the plane fitted to a neighbourhood. It has two ends: the one nearer to what the file says about
neighbours is taken, or, where it says nothing, the one nearer to a given direction.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["NEIGHBOURS", "estimated_normals"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NEIGHBOURS = 12
CHUNK = 128
ROUNDING = 1e-9
FLAT = 1e-9
"""Neighbours whose second spread is so small beside the first (squares of lengths) lie on a line: it has no normal."""


def estimated_normals(points: Array, support: Array, known: Array, facing: Array) -> Array:
    """Return unit normals (k, 3) at ``points`` (k, 3) from the cloud ``support`` (n, 3); NaN where there is none.

    ``known`` (n, 3) are the normals of ``support`` as far as the file has them, zeros elsewhere; ``facing`` (3,) is the
    side on which a normal without known neighbours ends.
    """
    found = np.full(points.shape, np.nan)
    if len(support) < 3:
        return found
    for rows in _clusters(points, np.arange(len(points))):
        near = _nearest(points[rows], support)
        found[rows] = _turned(_across(support[near]), known[near].sum(axis=1), facing)
    return found


def _clusters(points: Array, rows: Indices) -> Iterator[Indices]:
    """Rows of points that lie close together, no more than CHUNK: halves of halves across the longest side."""
    if len(rows) <= CHUNK:
        yield rows
        return
    places = points[rows]
    along = places[:, int(np.ptp(places, axis=0).argmax())]
    order, half = np.argpartition(along, len(rows) // 2), len(rows) // 2
    yield from _clusters(points, rows[order[:half]])
    yield from _clusters(points, rows[order[half:]])


def _nearest(points: Array, support: Array) -> Indices:
    """Indices (k, m) of the nearest neighbours in the cloud, in no order.

    With the points within r of their centre c, and m of the cloud within d of c, none is farther than d + 2 r from c.
    """
    count = min(NEIGHBOURS, len(support))
    centre = points.mean(axis=0)
    away = np.linalg.norm(support - centre, axis=1)
    radius = float(np.linalg.norm(points - centre, axis=1).max())
    within = np.flatnonzero(away <= (np.partition(away, count - 1)[count - 1] + 2.0 * radius) * (1.0 + ROUNDING))
    a, b = points - centre, support[within] - centre
    squares = (b * b).sum(axis=1)[None, :] - 2.0 * (a @ b.T)  # but for |a|², the same for a whole row
    near: Indices = within[np.argpartition(squares, count - 1, axis=1)[:, :count]]
    return near


def _across(clouds: Array) -> Array:
    """The direction of least spread of each small cloud (k, m, 3); NaN for one that lies on a line."""
    spread = clouds - clouds.mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.einsum("kmi,kmj->kij", spread, spread))
    across: Array = np.where((values[:, 1] > FLAT * values[:, 2])[:, None], vectors[:, :, 0], np.nan)
    return across


def _turned(normals: Array, known: Array, facing: Array) -> Array:
    side = np.where(known.any(axis=1, keepdims=True), known, facing)
    flipped: Array = np.where(((normals * side).sum(axis=1) < 0.0)[:, None], -normals, normals)
    return flipped
