"""What a run over a moving surface has done: every visit, the holds, a trace, and one table of numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ravengc.track.settings import TrackSettings
    from ravengc.track.surface import Surface

__all__ = ["OUTCOMES", "PHASES", "VERDICTS", "Hold", "Trace", "TrackResult", "Visits"]

Array = NDArray[np.float64]

OUTCOMES = ("covered", "missed", "timeout", "unreachable", "not visited")
"""Covered; dwelt, but too far off; not reached in time; out of the arm's reach; the run ended before."""

PHASES = ("settle", "approach", "dwell", "hold", "wait")

VERDICTS = ("shown", "contradicted", "missing", "untold", "")
"""What pictures taken around a dwell say of it: that the tool was within what a covered point may be off, surely; that
it was not, or hardly; too few of them; too noisy or too slow for what moves; there was no dwell."""


@dataclass(frozen=True, slots=True)
class Visits:
    """One row per point in the order of the tour, with the last visit to it; NaN for what did not happen.

    ``point`` is its row in the surface, ``tries`` how often the tool set out for it, ``verdict`` what pictures said of
    the dwell, one of VERDICTS; ``start_s`` and ``reached_s`` are when the tool set out and when its dwell began;
    ``time_s`` is from setting out to the end of the dwell; errors are true distances (m) from the moving point during
    the dwell, ``direction_max_rad`` the largest angle between tool axis and inward normal.
    """

    point: NDArray[np.intp]
    outcome: NDArray[np.str_]
    start_s: Array
    reached_s: Array
    dwell_s: Array
    time_s: Array
    error_rms_m: Array
    error_p95_m: Array
    error_max_m: Array
    direction_max_rad: Array
    tries: NDArray[np.intp]
    verdict: NDArray[np.str_]

    def __len__(self) -> int:
        """How many points the tour has."""
        return len(self.point)

    def count(self, outcome: str) -> int:
        """How many visits ended so."""
        return int(np.count_nonzero(self.outcome == outcome))


@dataclass(frozen=True, slots=True)
class Hold:
    """One hold test: the point and the true distances (m) from it after the way there, from ``scored_s`` on.

    NaN where the tool never came there.
    """

    point: int
    start_s: float
    scored_s: float
    error_rms_m: float
    error_p95_m: float
    error_max_m: float


@dataclass(frozen=True, slots=True)
class Trace:
    """Rows at ``trace_hz`` of the settings. All positions are in base axes, m; (k,) or (k, columns).

    ``visit`` is the row in the visits, -1 - i in hold test i, and ``phase`` one of PHASES, "wait" being at the last
    point for pictures of it. ``displacement`` is that of the surface, ``predicted`` what it was taken for; ``target``
    is where the tool should have been, ``axis`` where it pointed.
    """

    stamps: Array
    phase: NDArray[np.str_]
    visit: NDArray[np.intp]
    q: Array
    tool: Array
    axis: Array
    target: Array
    displacement: Array
    predicted: Array
    error_m: Array
    scale: Array
    sigma_min: Array


@dataclass(frozen=True, slots=True)
class TrackResult:
    """A run: its visits, holds and trace, what they amount to, and what it was run on.

    ``coverage`` is the share of the surface's points that were covered, in truth and at the last visit; ``confirmed``
    the share that pictures show so; ``revisits`` counts visits to points that had been visited before.
    ``time_per_point_s`` is that of the tour, revisits and waiting included, over the points set out for;
    ``acceleration_rms`` (m/s^2) that of the tool during the tour; ``limit_violations`` counts cycles
    beyond a joint's position or velocity limit; ``cycle_us`` is the cost of a control cycle. ``camera`` (k, 4) are
    the pictures that arrived: when taken (s), displacement seen (m). ``predictor_counters`` says with how many of them
    the predictor noted what, "received" being all; nothing where none predicts. ``interrupted`` runs were ended by
    Ctrl-C.
    """

    surface: Surface
    settings: TrackSettings
    motion: str
    robot: str
    visits: Visits
    holds: tuple[Hold, ...]
    trace: Trace
    camera: Array
    coverage: float
    confirmed: float
    revisits: int
    time_per_point_s: float
    dwell_rms_m: float
    dwell_p95_m: float
    dwell_max_m: float
    hold_rms_m: float
    hold_p95_m: float
    hold_max_m: float
    prediction_rms_m: float
    acceleration_rms: float
    acceleration_max: float
    limit_violations: dict[str, int]
    cycle_us: dict[str, float]
    duration_s: float
    interrupted: bool = False
    predictor_counters: dict[str, int] = field(default_factory=dict)

    def summary(self) -> dict[str, Any]:
        """The numbers as JSON knows them (None for those that do not exist), without trace and visits."""
        names = [
            "coverage", "confirmed", "time_per_point_s", "dwell_rms_m", "dwell_p95_m", "dwell_max_m",
            "hold_rms_m", "hold_p95_m", "hold_max_m", "prediction_rms_m", "acceleration_rms", "acceleration_max",
            "duration_s",
        ]  # fmt: skip
        return {
            "robot": self.robot,
            "surface": self.surface.name,
            "points": len(self.surface),
            "dropped": dict(self.surface.dropped),
            "motion": self.motion,
            "mode": self.settings.mode,
            "method": self.settings.method,
            "approach": self.settings.approach,
            "predictor": self.settings.predictor,
            "predictor_counters": dict(self.predictor_counters),
            "outcomes": {outcome: self.visits.count(outcome) for outcome in OUTCOMES},
            "verdicts": {name: int(np.count_nonzero(self.visits.verdict == name)) for name in VERDICTS if name},
            **{name: _plain(getattr(self, name)) for name in names},
            "revisits": self.revisits,
            "interrupted": self.interrupted,
            "limit_violations": dict(self.limit_violations),
            "cycle_us": {name: _plain(value) for name, value in self.cycle_us.items()},
        }


def _plain(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None
