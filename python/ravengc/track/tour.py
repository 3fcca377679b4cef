"""The order of visits: a short way over all points.

Distances are those of a tool that must turn as well as go: of (p, rho n), where rho (m/rad) is its acceleration over
its angular acceleration, so that the two sides of a thin plate are far apart. A Hilbert curve (Skilling, AIP Conference
Proceedings 707, 2004), which needs a sort, is shortened by 2-opt moves over a window while the cloud is small enough.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_number, check_choice, check_type
from ravengc.errors import ConfigError
from ravengc.track.surface import Surface

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["tour"]

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

ORDERS = ("tour", "given", "strips")
BITS = 16
"""Cells of the Hilbert curve per axis: 2^16."""
MOST_SHORTENED = 4000
WINDOW = 400
"""How far along the way a 2-opt move may reach."""
PASSES = 30


def tour(surface: Surface, order: str = "tour", *, strip: float = 0.006, turning: float = 0.1) -> Rows:
    """Return the rows of the points in the order in which they are visited, (k,).

    ``order``: "given"; "strips", of this width (m) in x, up and down in y by turns; or "tour", a short way, where
    ``turning`` (m/rad) is how far a tool goes while it turns by a radian. ConfigError for another order.
    """
    check_type(surface, Surface, "surface")
    check_choice(order, ORDERS, "order")
    width, rho = as_number(strip, "strip"), as_number(turning, "turning")
    if not (1e-6 <= width <= 1e3 and 0.0 <= rho <= 1e3):
        raise ConfigError(f"strip is {width:g} and turning {rho:g}; expected 1e-6 to 1000 m and 0 to 1000 m/rad")
    if order == "given":
        return np.arange(len(surface))
    if order == "strips":
        return _strips(surface.points, width)
    rows = _hilbert(surface.points)
    places = np.hstack((surface.points, rho * surface.normals))
    return _shortened(places, rows) if len(rows) <= MOST_SHORTENED else rows


def _strips(points: Array, width: float) -> Rows:
    """Every other strip is walked backwards; strips without points do not count."""
    strip = np.floor((points[:, 0] - points[:, 0].min()) / width)
    _, number = np.unique(strip, return_inverse=True)
    along = np.where(number % 2 == 0, points[:, 1], -points[:, 1])
    return np.lexsort((along, number))


def _hilbert(points: Array) -> Rows:
    """Rows sorted along a Hilbert curve through the box around the cloud."""
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    scale = (2**BITS - 1) / size if size > 0.0 else 0.0
    x = ((points - low) * scale).astype(np.uint64).T.copy()
    _to_transpose(x)
    index = np.zeros(x.shape[1], dtype=np.uint64)
    for bit in range(BITS - 1, -1, -1):
        for axis in x:
            index = (index << np.uint64(1)) | ((axis >> np.uint64(bit)) & np.uint64(1))
    return np.argsort(index, kind="stable")


def _to_transpose(x: NDArray[np.uint64]) -> None:
    """Skilling's AxestoTranspose, for all points at once: coordinates (3, k) become the bits of the index, in place."""
    one = np.uint64(1)
    for bit in range(BITS - 1, 0, -1):
        q = one << np.uint64(bit)
        for i in range(len(x)):
            inverted = (x[i] & q) != 0
            swapped = np.where(inverted, np.uint64(0), (x[0] ^ x[i]) & (q - one))
            x[0] ^= np.where(inverted, q - one, swapped)
            x[i] ^= swapped
    for i in range(1, len(x)):
        x[i] ^= x[i - 1]
    t = np.zeros(x.shape[1], dtype=np.uint64)
    for bit in range(BITS - 1, 0, -1):
        q = one << np.uint64(bit)
        t ^= np.where((x[-1] & q) != 0, q - one, np.uint64(0))
    x ^= t


def _shortened(places: Array, rows: Rows) -> Rows:
    """Turn pieces of the way round wherever that shortens it, until nothing does or after a number of passes."""
    way = rows.copy()
    for _ in range(PASSES):
        if not sum(_turn_best(places, way, i) for i in range(len(way) - 2)):
            break
    return way


def _turn_best(places: Array, way: Rows, i: int) -> bool:
    """Turn the piece after the i-th point round that shortens the way most; say whether one does.

    The piece from i + 1 to j leaves hops (i, i + 1) and (j, j + 1) for (i, j) and (i + 1, j + 1); the last has no next.
    """
    ends = way[i + 1 : i + 2 + WINDOW]
    here, first, last = places[way[i]], places[ends[0]], places[ends]
    gain = _norms(first - here) - _norms(last - here)
    after = way[i + 2 : i + 2 + len(ends)]
    hop = places[after]
    gain[: len(after)] += _norms(hop - last[: len(after)]) - _norms(hop - first)
    best = int(np.argmax(gain))
    if gain[best] <= 1e-12:
        return False
    way[i + 1 : i + 2 + best] = way[i + 1 : i + 2 + best][::-1].copy()
    return True


def _norms(differences: ArrayLike) -> Array:
    lengths: Array = np.sqrt(np.square(differences).sum(axis=-1))
    return lengths
