"""What a run amounts to: visits and holds, scored by the truth, as rows and numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.track.result import VERDICTS, Hold, TrackResult, Visits

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from ravengc.track.recording import Recorder
    from ravengc.track.settings import TrackSettings
    from ravengc.track.surface import Surface

__all__ = ["Held", "Visited", "result_of", "rows_of"]

Array = NDArray[np.float64]

SHOWN, *_, NO_DWELL = VERDICTS


class Visited(NamedTuple):
    """A row of the visits without its point, and the true errors of its dwell (m)."""

    outcome: str
    start_s: float
    reached_s: float
    dwell_s: float
    time_s: float
    errors: Array
    direction_max_rad: float


NOT_VISITED = Visited("not visited", *(math.nan,) * 4, np.zeros(0), math.nan)


class Held(NamedTuple):
    """A hold test: its point, when it began and from when on it counts (s), and its true errors (m) since then."""

    point: int
    start_s: float
    scored_s: float
    errors: Array


def result_of(
    surface: Surface,
    settings: TrackSettings,
    record: Recorder,
    rows: Visits,
    *,
    visits: Mapping[int, Visited],
    holds: Sequence[Held],
    robot: str,
    motion: str,
    time_per_point_s: float,
    duration_s: float,
    interrupted: bool,
    predictor_counters: dict[str, int],
) -> TrackResult:
    """Return the result of a run whose record is flushed."""
    dwell_rms, dwell_p95, dwell_max = error_numbers(joined(visit.errors for visit in visits.values()))
    hold_rms, hold_p95, hold_max = error_numbers(joined(hold.errors for hold in holds))
    acceleration_rms, acceleration_max = record.acceleration
    return TrackResult(
        surface=surface,
        settings=settings,
        motion=motion,
        robot=robot,
        visits=rows,
        holds=tuple(Hold(hold.point, hold.start_s, hold.scored_s, *error_numbers(hold.errors)) for hold in holds),
        trace=record.trace(),
        camera=record.pictures,
        coverage=rows.count("covered") / len(rows),
        confirmed=int(np.count_nonzero(rows.verdict == SHOWN)) / len(rows),
        revisits=int(np.maximum(rows.tries - 1, 0).sum()),
        time_per_point_s=time_per_point_s,
        dwell_rms_m=dwell_rms,
        dwell_p95_m=dwell_p95,
        dwell_max_m=dwell_max,
        hold_rms_m=hold_rms,
        hold_p95_m=hold_p95,
        hold_max_m=hold_max,
        prediction_rms_m=record.prediction_rms,
        acceleration_rms=acceleration_rms,
        acceleration_max=acceleration_max,
        limit_violations=dict(record.violations),
        cycle_us=record.cost_us,
        duration_s=duration_s,
        interrupted=interrupted,
        predictor_counters=predictor_counters,
    )


def rows_of(
    visits: Mapping[int, Visited],
    order: NDArray[np.intp],
    tries: NDArray[np.intp],
    verdicts: Mapping[int, str],
) -> Visits:
    """Return the visits as columns, in the order of the tour; those that the run did not come to as such."""
    found = [visits.get(row, NOT_VISITED) for row in range(len(order))]
    names = ("start_s", "reached_s", "dwell_s", "time_s", "direction_max_rad")
    table = np.array([(*(getattr(visit, name) for name in names), *error_numbers(visit.errors)) for visit in found])
    columns = dict(zip((*names, "error_rms_m", "error_p95_m", "error_max_m"), table.T, strict=True))
    return Visits(
        point=order,
        outcome=np.array([visit.outcome for visit in found]),
        tries=tries,
        verdict=np.array([verdicts.get(row, NO_DWELL) for row in range(len(order))]),
        **columns,
    )


def error_numbers(errors: Array) -> tuple[float, float, float]:
    """RMS, 95th percentile and largest; NaN where there are none."""
    if not errors.size:
        return math.nan, math.nan, math.nan
    return math.sqrt(float(np.square(errors).mean())), float(np.percentile(errors, 95.0)), float(errors.max())


def joined(parts: Iterable[Array]) -> Array:
    """All of them in one, empty for none."""
    return np.concatenate([np.zeros(0), *parts])
