"""How far above the surface the tool shall be, from its arrival on: at a stand-off, or pressing by a profile."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ravengc.track.settings import TrackSettings

__all__ = ["Press"]


class Press:
    """Height above the surface (m) and its rate (m/s) over the time since arrival (s).

    Between the times of the profile the depth goes as (1 - cos) / 2, at rest at each of them.
    """

    def __init__(self, settings: TrackSettings) -> None:
        palpating = settings.mode == "palpate"
        self._times = settings.press_times_s if palpating else (0.0,)
        self._heights = tuple(-depth for depth in settings.press_depths_m) if palpating else (settings.stand_off_m,)

    @property
    def start(self) -> tuple[float, float]:
        """At arrival, and on the way."""
        return self._heights[0], 0.0

    def at(self, since: float) -> tuple[float, float]:
        """So many seconds after arrival."""
        piece = bisect_right(self._times, since) - 1
        if piece + 1 >= len(self._times):
            return self._heights[-1], 0.0
        span = self._times[piece + 1] - self._times[piece]
        angle = math.pi * (since - self._times[piece]) / span
        half = (self._heights[piece + 1] - self._heights[piece]) / 2.0
        return self._heights[piece] + half * (1.0 - math.cos(angle)), half * math.sin(angle) * math.pi / span
