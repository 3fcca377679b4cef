"""What later pictures show of a dwell: where the surface was while the tool took itself to be on it.

A quadratic through the pictures before and after a moment tells the displacement then with a third of their noise
(Savitzky and Golay, Analytical Chemistry 36(8), 1964), from what has been seen alone. Where the surface turns faster
than that, fewer pictures are taken.

    sigma^2 = noise^2 w (V^T V)^-1 w^T        V: rows 1, s, s^2 of the pictures; w: the same of the moment
    contradicted:  |tool - aim| > covered - 2 sigma
"""

from __future__ import annotations

import bisect
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.track.result import VERDICTS

if TYPE_CHECKING:
    from ravengc.track.approach import Triple
    from ravengc.track.camera import Camera
    from ravengc.track.settings import TrackSettings

__all__ = ["Hindsight"]

Array = NDArray[np.float64]

SIDE = 10
"""Pictures before a moment, and after it."""
SHORTEST_S, LONGEST_S = 0.1, 1.0
"""No less and no more time than this on either side."""
SHARES = (1.0, 0.67, 0.45, 0.3)
"""Of that time, as long as the pictures are off the quadratic by more than their noise."""
LEAST_SEEN = 3
"""Pictures on either side; with fewer it was not looked at."""
GATE = 1.6
"""Mean square of what the quadratic leaves, over the noise's."""
NEGLIGIBLE = 0.1
"""Share of the error that is allowed, down to which it does not matter what the quadratic leaves."""
SIGMAS = 2.0
SHOWN, CONTRADICTED, MISSING, UNTOLD, _ = VERDICTS
WORST_FIRST = (CONTRADICTED, MISSING, UNTOLD, SHOWN)


class _Dwell(NamedTuple):
    """A dwell to be judged at ``due_s``: when (k,), and the displacements (k, 3) at which the tool was on its aim."""

    row: int
    due_s: float
    times: Array
    places: Array


class Hindsight:
    """Keeps pictures and dwells until the pictures after a dwell have arrived, then judges it."""

    def __init__(self, settings: TrackSettings, camera: Camera) -> None:
        arriving = camera.rate_hz * (1.0 - camera.drop_fraction)
        self._side_s = min(max(SIDE / arriving, SHORTEST_S), LONGEST_S) if arriving > 0.0 else LONGEST_S
        self.wait_s = self._side_s + camera.latency_s + camera.jitter_s
        self._noise, self._covered = max(camera.noise_m, 1e-9), settings.covered_m
        self._left = GATE * max(camera.noise_m, NEGLIGIBLE * settings.covered_m) ** 2
        self._piece_s = 2.0 * self._side_s / SIDE
        self._pictures: list[tuple[float, Triple]] = []
        self._waiting: list[_Dwell] = []

    @property
    def due_s(self) -> float | None:
        """When the next dwell can be judged, s; None if there is none to judge."""
        return self._waiting[0].due_s if self._waiting else None

    def saw(self, stamp_s: float, seen: Triple) -> None:
        """Keep a picture, which may be late or before the last one."""
        bisect.insort(self._pictures, (stamp_s, seen))

    def dwelt(self, row: int, times: Array, places: Array) -> None:
        """Keep a dwell that is over."""
        self._waiting.append(_Dwell(row, float(times[-1]) + self.wait_s, times, places))

    def verdicts(self, now: float) -> dict[int, str]:
        """Return, and forget, the dwells whose pictures have arrived by ``now``: one of VERDICTS for their rows."""
        ripe = [dwell for dwell in self._waiting if dwell.due_s <= now]
        if not ripe:
            return {}
        stamps = np.array([stamp for stamp, _ in self._pictures])
        seen = np.array([place for _, place in self._pictures]).reshape(-1, 3)
        found = {dwell.row: self._verdict(dwell, stamps, seen) for dwell in ripe}
        self._waiting = self._waiting[len(ripe) :]
        begin = self._waiting[0].times[0] if self._waiting else now
        del self._pictures[: int(np.searchsorted(stamps, begin - self.wait_s))]
        return found

    def _verdict(self, dwell: _Dwell, stamps: Array, seen: Array) -> str:
        """The worst of the pieces of a dwell, none of them longer than two pictures."""
        count = max(1, math.ceil((dwell.times[-1] - dwell.times[0]) / self._piece_s))
        pieces = zip(np.array_split(dwell.times, count), np.array_split(dwell.places, count), strict=True)
        found = {self._of_piece(times, places, stamps, seen) for times, places in pieces if len(times)}
        return next(verdict for verdict in WORST_FIRST if verdict in found)

    def _of_piece(self, times: Array, places: Array, stamps: Array, seen: Array) -> str:
        middle = 0.5 * (times[0] + times[-1])
        away = stamps - middle
        near = np.abs(away) <= self._side_s
        if min(np.count_nonzero(near & (away < 0.0)), np.count_nonzero(near & (away >= 0.0))) < LEAST_SEEN:
            return MISSING
        for share in SHARES:
            near = np.abs(away) <= share * self._side_s
            if np.count_nonzero(near) <= 2 * LEAST_SEEN:
                break
            fitted, sigma, left = _quadratic(away[near], seen[near], times - middle)
            margin = SIGMAS * self._noise * sigma
            if left <= self._left and margin <= 0.5 * self._covered:
                off = float(np.linalg.norm(places - fitted, axis=1).max())
                return CONTRADICTED if off > self._covered - margin else SHOWN
        return UNTOLD


def _quadratic(s: Array, seen: Array, at: Array) -> tuple[Array, float, float]:
    """The quadratic through ``seen`` (k, 3) at ``at`` (m, 3), its sigma there per noise, what it leaves of a number."""
    size = float(np.abs(s).max())
    v, w = np.vander(s / size, 3), np.vander(at / size, 3)
    inverse = np.linalg.pinv(v)
    terms = inverse @ seen
    left = float(np.square(seen - v @ terms).sum()) / (3 * (len(s) - 3))
    return w @ terms, float(np.linalg.norm(w @ inverse, axis=1).max()), left
