"""Normals where a file has none: the direction in which a point's neighbours spread least, turned consistently.

H. Hoppe, T. DeRose, T. Duchamp, J. McDonald, W. Stuetzle, "Surface reconstruction from unorganized points", SIGGRAPH
1992: the normal of the plane fitted to a neighbourhood. It has two ends: the one nearer to what the file says about
neighbours is taken, or, where it says nothing, the one nearer to a given direction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["NEIGHBOURS", "estimated_normals"]

Array = NDArray[np.float64]

NEIGHBOURS = 12
CHUNK = 256
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
    for start in range(0, len(points), CHUNK):
        part = slice(start, start + CHUNK)
        near = _nearest(points[part], support)
        found[part] = _turned(_across(support[near]), known[near].sum(axis=1), facing)
    return found


def _nearest(points: Array, support: Array) -> NDArray[np.int64]:
    """Indices (k, m) of the nearest neighbours in the cloud, in no order."""
    count = min(NEIGHBOURS, len(support))
    centre = support.mean(axis=0)
    a, b = points - centre, support - centre
    squares = (b * b).sum(axis=1)[None, :] - 2.0 * (a @ b.T)  # but for |a|², the same for a whole row
    near: NDArray[np.int64] = np.argpartition(squares, count - 1, axis=1)[:, :count]
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
