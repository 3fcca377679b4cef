"""Which point comes next: that of the tour, or one to be visited again, when the tool is near it or at the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Itinerary"]

NEAR = 1.5
"""A point is visited again when it is no farther than so many times the next point of the tour."""


class Itinerary:
    """Rows of a tour over ``places`` (k, 3), m, in its order; each may be visited again ``most`` times."""

    def __init__(self, places: NDArray[np.float64], most: int) -> None:
        self._places, self._most = places, most
        self._following, self._row = 0, 0
        self._again: list[int] = []
        self.tries = np.zeros(len(places), dtype=np.intp)

    @property
    def visited(self) -> int:
        """How many rows have been set out for."""
        return self._following

    def again(self, row: int) -> None:
        """Visit a row again, unless that has been done as often as it may be."""
        if self.tries[row] <= self._most:
            self._again.append(row)

    def next(self) -> int | None:
        """The row to set out for now; None if there is none left."""
        row = self._take()
        if row is not None:
            self.tries[row] += 1
            self._row = row
        return row

    def _take(self) -> int | None:
        left = self._following < len(self._places)
        if self._again:
            away = self._distances(self._again)
            nearest = int(np.argmin(away))
            if not left or away[nearest] <= NEAR * self._distances([self._following])[0]:
                return self._again.pop(nearest)
        if not left:
            return None
        self._following += 1
        return self._following - 1

    def _distances(self, rows: list[int]) -> NDArray[np.float64]:
        """From the row of now, m."""
        away: NDArray[np.float64] = np.linalg.norm(self._places[rows] - self._places[self._row], axis=1)
        return away
