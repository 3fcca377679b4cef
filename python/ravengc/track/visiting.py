"""The phases of a run: to the first point, every point of the tour, the holds; and what they amount to."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.track.follower import Aim
from ravengc.track.press import Press
from ravengc.track.result import PHASES, Hold, TrackResult, Visits

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.track.follower import Follower, Miss
    from ravengc.track.settings import TrackSettings
    from ravengc.track.surface import Surface

__all__ = ["Visiting"]

Array = NDArray[np.float64]

SETTLE, APPROACH, DWELL, HOLD = range(len(PHASES))
STALLED = 0.9
"""A tool whose distance at the time-out is still this share of that half-way cannot get there."""
FAR = 5.0
"""Tolerances off at the time-out; nearer, it was only late."""


class Visited(NamedTuple):
    """A row of the visits without its point, and the true errors of its dwell (m)."""

    outcome: str
    start_s: float
    reached_s: float
    dwell_s: float
    time_s: float
    errors: Array
    direction_max_rad: float


class _Watch:
    """A visit that is not over: since when it dwells, its errors, and how far off it was half-way to the time-out."""

    def __init__(self, settings: TrackSettings) -> None:
        self._near, self._straight = settings.tolerance_m, settings.tolerance_rad
        self._presses = settings.mode == "palpate"
        self.reached_s = math.nan
        self.errors: list[float] = []
        self.turn = 0.0
        self.distances: list[float] = []

    def see(self, miss: Miss, now: float) -> None:
        """Count a cycle: of the dwell, if the tool believes to be there; a press that has begun goes on whatever."""
        self.distances.append(miss.believed)
        there = miss.believed <= self._near and miss.turn <= self._straight
        if there or (self._presses and self.errors):
            if not self.errors:
                self.reached_s, self.turn = now, 0.0
            self.errors.append(miss.true)
            self.turn = max(self.turn, miss.turn)
        else:
            self.reached_s, self.errors = math.nan, []

    def given_up(self) -> str:
        """Why a point was not reached: the tool was late, or it no longer came nearer."""
        half, end = self.distances[len(self.distances) // 2], self.distances[-1]
        return "unreachable" if end > FAR * self._near and end > STALLED * half else "timeout"


class Visiting:
    """The phases of a run over a surface, with a follower that has looked already."""

    def __init__(self, surface: Surface, settings: TrackSettings, follower: Follower, order: NDArray[np.intp]) -> None:
        self._surface, self._settings, self._follower, self._order = surface, settings, follower, order
        self._press = Press(settings)
        self._record = follower.record
        self._presses = settings.mode == "palpate"
        self._dwell = max(1, round(settings.visit_s * settings.rate_hz))
        self._patience = max(1, round(settings.timeout_s * settings.rate_hz))
        self._end = settings.lead_in_s + settings.most_s

    def run(self, on_progress: Callable[[int, int], None]) -> TrackResult:
        """Do it all, and say after every point how many of all are done."""
        steps = len(self._order) + self._settings.hold_points
        self._settle()
        visits: list[Visited] = []
        for row, point in enumerate(self._order.tolist()):
            if self._follower.now >= self._end:
                break
            visits.append(self._visit(row, point))
            on_progress(row + 1, steps)
        holds: list[tuple[int, float, Array]] = []
        for number in range(self._settings.hold_points):
            if self._follower.now >= self._end:
                break
            holds.append(self._hold(number))
            on_progress(len(self._order) + number + 1, steps)
        return self._result(visits, holds)

    def _settle(self) -> None:
        """Go to the first point before anything counts."""
        self._label(SETTLE, 0)
        aim = self._aim(int(self._order[0]), 0.0)
        for _ in range(round(self._settings.settle_s * self._settings.rate_hz)):
            self._follower.follow(aim)

    def _label(self, phase: int, visit: int) -> None:
        self._record.phase, self._record.visit = phase, visit

    def _aim(self, point: int, since: float) -> Aim:
        """A point of the surface, so many seconds after arrival."""
        x, y, z = self._surface.points[point].tolist()
        a, b, c = self._surface.normals[point].tolist()
        return Aim((x, y, z), (a, b, c), *self._press.at(since))

    def _visit(self, row: int, point: int) -> Visited:
        """Close in on a point until the dwell is over or time is up."""
        start, watch, aim = self._follower.now, _Watch(self._settings), self._aim(point, 0.0)
        if not self._follower.within_reach(aim):
            return Visited("unreachable", start, math.nan, math.nan, 0.0, np.zeros(0), math.nan)
        last = self._patience
        while len(watch.errors) < self._dwell:
            if len(watch.distances) >= last and not (self._presses and watch.errors):
                time = self._follower.now - start
                return Visited(watch.given_up(), start, math.nan, math.nan, time, np.zeros(0), math.nan)
            self._label(DWELL if watch.errors else APPROACH, row)
            now = self._follower.now
            watch.see(self._follower.follow(self._pressed(aim, len(watch.errors))), now)
        return self._dwelt(start, watch)

    def _pressed(self, aim: Aim, cycles: int) -> Aim:
        """The aim so many cycles after arrival."""
        if not self._presses or cycles == 0:
            return aim
        above, rising = self._press.at(cycles * self._follower.dt)
        return aim._replace(above=above, rising=rising)

    def _dwelt(self, start: float, watch: _Watch) -> Visited:
        errors, now = np.array(watch.errors), self._follower.now
        inside = errors.max() <= self._settings.covered_m and watch.turn <= self._settings.covered_rad
        outcome = "covered" if inside else "missed"
        return Visited(outcome, start, watch.reached_s, now - watch.reached_s, now - start, errors, watch.turn)

    def _hold(self, number: int) -> tuple[int, float, Array]:
        """Hold one of the points, evenly spread over the tour; return it, the begin, and its errors once there."""
        point = int(self._order[number * len(self._order) // self._settings.hold_points])
        start, aim = self._follower.now, self._aim(point, 0.0)
        self._label(HOLD, -1 - number)
        cycles = round(self._settings.hold_s * self._settings.rate_hz)
        ignored = round(self._settings.hold_after_s * self._settings.rate_hz)
        errors = [self._follower.follow(aim).true for _ in range(cycles)]
        return point, start, np.array(errors[ignored:])

    def _result(self, visits: list[Visited], holds: list[tuple[int, float, Array]]) -> TrackResult:
        self._record.flush()
        rms, p95, most = error_numbers(np.concatenate([np.zeros(0), *(visit.errors for visit in visits)]))
        hold_rms, hold_p95, hold_most = error_numbers(
            np.concatenate([np.zeros(0), *(errors for _, _, errors in holds)])
        )
        outcomes = [visit.outcome for visit in visits]
        acceleration_rms, acceleration_max = self._record.acceleration
        return TrackResult(
            surface=self._surface,
            settings=self._settings,
            motion=self._follower.motion.description,
            robot=self._follower.robot.name,
            visits=rows_of(visits, self._order),
            holds=tuple(Hold(point, start, *error_numbers(errors)) for point, start, errors in holds),
            trace=self._record.trace(),
            camera=self._record.pictures,
            coverage=outcomes.count("covered") / len(self._order),
            time_per_point_s=float(np.mean([visit.time_s for visit in visits])) if visits else math.nan,
            dwell_rms_m=rms,
            dwell_p95_m=p95,
            dwell_max_m=most,
            hold_rms_m=hold_rms,
            hold_p95_m=hold_p95,
            hold_max_m=hold_most,
            prediction_rms_m=self._record.prediction_rms,
            acceleration_rms=acceleration_rms,
            acceleration_max=acceleration_max,
            limit_violations=dict(self._record.violations),
            cycle_us=self._record.cost_us,
            duration_s=self._follower.now,
        )


def error_numbers(errors: Array) -> tuple[float, float, float]:
    """RMS, 95th percentile and largest; NaN where there are none."""
    if not errors.size:
        return math.nan, math.nan, math.nan
    return math.sqrt(float(np.square(errors).mean())), float(np.percentile(errors, 95.0)), float(errors.max())


def rows_of(visits: list[Visited], order: NDArray[np.intp]) -> Visits:
    """The visits as columns, in the order of the tour; those that the run did not come to at the end."""
    left = len(order) - len(visits)
    names = ("start_s", "reached_s", "dwell_s", "time_s", "direction_max_rad")
    numbers = [(*(getattr(visit, name) for name in names), *error_numbers(visit.errors)) for visit in visits]
    table = np.vstack((np.array(numbers, dtype=float).reshape(-1, 8), np.full((left, 8), math.nan)))
    columns = dict(zip((*names, "error_rms_m", "error_p95_m", "error_max_m"), table.T, strict=True))
    outcome = np.array([*(visit.outcome for visit in visits), *["not visited"] * left])
    return Visits(point=order, outcome=outcome, **columns)
