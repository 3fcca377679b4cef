"""A surface to visit: points with unit normals, as they lie while nothing moves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_double, as_number, check_type
from ravengc.errors import ArgumentError
from ravengc.targets.thinning import first_of_each

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["MOST_POINTS", "Surface"]

Array = NDArray[np.float64]

MOST_POINTS = 2_000_000
FARTHEST = 1e3
"""m; a cloud in millimetres, read as metres, is beyond it."""


@dataclass(frozen=True, slots=True)
class Surface:
    """Points (k, 3), m, and their outward normals (k, 3), both in base axes, at rest.

    ``dropped`` counts what was left out of a cloud, by reason. The normals are made unit length. Raises ArgumentError,
    with the number of such rows and the first of them, for numbers that are not finite, points farther than 1 km, and
    normals of no length; for no point at all and for more than two million. :meth:`cleaned` leaves such rows out.
    """

    points: Array
    normals: Array
    name: str = "surface"
    dropped: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check every row, and keep own arrays that nobody writes to."""
        check_type(self.name, str, "name")
        check_type(self.dropped, dict, "dropped")
        points, normals = _rows(self.points, "points"), _rows(self.normals, "normals")
        if points.shape != normals.shape:
            raise ArgumentError(f"normals has shape {normals.shape}; expected that of points, {points.shape}")
        if not 1 <= len(points) <= MOST_POINTS:
            raise ArgumentError(f"points has {len(points)} rows; expected 1 to {MOST_POINTS}")
        for problem, rows in _faults(points, normals).items():
            if rows.any():
                which = f"{int(rows.sum())} of {len(rows)} rows, the first is row {int(np.argmax(rows))}"
                raise ArgumentError(f"points and normals: {problem} in {which}; Surface.cleaned leaves them out")
        object.__setattr__(self, "points", _kept(points))
        object.__setattr__(self, "normals", _kept(normals / np.linalg.norm(normals, axis=1, keepdims=True)))

    def __len__(self) -> int:
        """How many points there are."""
        return len(self.points)

    @classmethod
    def cleaned(cls, points: ArrayLike, normals: ArrayLike, name: str = "surface", *, apart: float = 1e-6) -> Surface:
        """Leave out rows that no tool can visit, and points within about ``apart`` (m) of an earlier one.

        ``dropped`` then counts them by reason. Raises ArgumentError for arrays of other shapes, and where none is left.
        """
        places, directions, apart = _rows(points, "points"), _rows(normals, "normals"), as_number(apart, "apart")
        if places.shape != directions.shape:
            raise ArgumentError(f"normals has shape {directions.shape}; expected that of points, {places.shape}")
        if not 0.0 <= apart <= 1.0:
            raise ArgumentError(f"apart is {apart:g}; expected 0 to 1 m")
        kept, dropped = np.ones(len(places), dtype=bool), {}
        for problem, rows in _faults(places, directions).items():
            dropped[problem] = int((rows & kept).sum())
            kept &= ~rows
        usable = np.flatnonzero(kept)
        cells = np.round(places[usable] / apart) if apart > 0.0 else places[usable]
        first = usable[first_of_each(cells)]
        dropped["duplicate point"] = int(len(usable) - len(first))
        if not len(first):
            raise ArgumentError(f"no point is left of {len(places)}: {dropped}")
        counted = {problem: count for problem, count in dropped.items() if count}
        return cls(places[first], directions[first], name, counted)


def _faults(points: Array, normals: Array) -> dict[str, NDArray[np.bool_]]:
    """Rows that are no places with a direction, by what is wrong with them."""
    with np.errstate(invalid="ignore", over="ignore"):
        lengths = np.linalg.norm(normals, axis=1)
        return {
            "a number that is not finite": ~(np.isfinite(points) & np.isfinite(normals)).all(axis=1),
            f"a point farther than {FARTHEST:g} m": (np.abs(points) > FARTHEST).any(axis=1),
            "a normal without length": ~(lengths > 1e-9) | ~np.isfinite(lengths),
        }


def _rows(values: ArrayLike, name: str) -> Array:
    array = as_double(values, name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ArgumentError(f"{name} has shape {array.shape}; expected (k, 3)")
    return array


def _kept(array: Array) -> Array:
    own = array.copy()
    own.flags.writeable = False
    return own
