"""The phases of a run: to the first point, every point of the tour, the holds; and what they amount to.

A visit is over when the tool believes to have stayed long enough. Pictures that arrive later may show that it was
elsewhere: such points are visited again.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc.track.follower import Aim
from ravengc.track.itinerary import Itinerary
from ravengc.track.press import Press
from ravengc.track.result import PHASES, VERDICTS
from ravengc.track.scoring import Held, Visited, result_of, rows_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.track.approach import Triple
    from ravengc.track.follower import Follower, Miss
    from ravengc.track.result import TrackResult
    from ravengc.track.settings import TrackSettings
    from ravengc.track.surface import Surface

__all__ = ["Visiting"]

Array = NDArray[np.float64]

SHOWN, CONTRADICTED, MISSING, UNTOLD, NO_DWELL = VERDICTS
SETTLE, APPROACH, DWELL, HOLD, WAIT = range(len(PHASES))
STALLED = 0.9
"""A tool whose distance at the time-out is still this share of that half-way cannot get there."""
FAR = 5.0
"""Tolerances off at the time-out; nearer, it was only late. Tools that stay as far off do not hold a point."""
JUDGED_S = 0.005
"""Pictures judge the tool's place once in so long."""
TRUSTED = 4
"""So many dwells of which pictures cannot tell do not yet mean that they never can."""


class _Watch:
    """A visit that is not over: since when it dwells, its errors, and how far off it was half-way to the time-out."""

    def __init__(self, settings: TrackSettings) -> None:
        self._near, self._straight = settings.tolerance_m, settings.tolerance_rad
        self._presses = settings.mode == "palpate"
        self.reached_s = math.nan
        self.errors: list[float] = []
        self.places: list[Triple] = []
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
            self.places.append(miss.place)
            self.turn = max(self.turn, miss.turn)
        else:
            self.reached_s, self.errors, self.places = math.nan, [], []

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
        self._revisiting = settings.method == "resolved" and settings.revisits > 0
        self._plan = Itinerary(surface.points[order], settings.revisits if self._revisiting else 0)
        self._row = 0
        self._visits: dict[int, Visited] = {}
        self._verdicts: dict[int, str] = {}
        self._holds: list[Held] = []
        self._told = self._untold = 0
        self._begin_s = self._end
        self._toured_s = math.nan

    def run(self, on_progress: Callable[[int, int], None]) -> TrackResult:
        """Do it all, and say after every new point how many of all are done."""
        steps = len(self._order) + self._settings.hold_points
        interrupted = True
        with suppress(KeyboardInterrupt):
            self._settle()
            self._begin_s = self._follower.now
            self._tour(lambda: on_progress(self._plan.visited, steps))
            self._toured_s = self._follower.now - self._begin_s
            for number in range(self._settings.hold_points):
                if self._follower.now >= self._end:
                    break
                self._holds.append(self._hold(number))
                on_progress(len(self._order) + number + 1, steps)
            self._look_back()
            interrupted = False
        if not self._visits and interrupted:
            raise KeyboardInterrupt
        return self._result(interrupted=interrupted)

    def _tour(self, tell: Callable[[], None]) -> None:
        """Visit every point, and those again that pictures do not show covered."""
        while self._follower.now < self._end:
            row = self._plan.next()
            if row is None and not self._waited():
                break
            if row is not None:
                self._verdicts[row] = NO_DWELL
                self._visits[row] = self._visit(row)
                if self._plan.tries[row] == 1:
                    tell()
            self._judge(self._follower.now)

    def _waited(self) -> bool:
        """Stay at the last point until a dwell can be judged; False where nothing would come of it."""
        due = self._follower.hindsight.due_s
        if due is None or not self._revisiting:
            return False
        self._label(WAIT, self._row)
        aim = self._aim(int(self._order[self._row]), 0.0)
        while self._follower.now < min(due, self._end):
            self._follower.follow(aim)
        return True

    def _judge(self, now: float) -> None:
        """Take the verdicts on the dwells whose pictures have arrived."""
        for row, verdict in self._follower.hindsight.verdicts(now).items():
            self._verdicts[row] = verdict
            self._told += 1 if verdict in {SHOWN, CONTRADICTED} else 0
            self._untold += 1 if verdict == UNTOLD else 0
            if self._doubted(verdict):
                self._plan.again(row)

    def _doubted(self, verdict: str) -> bool:
        """Whether another visit may show more: not where pictures cannot tell of most points."""
        if verdict == UNTOLD:
            return self._told + TRUSTED > self._untold
        return verdict in {CONTRADICTED, MISSING}

    def _look_back(self) -> None:
        """Judge what is left by the pictures that arrive after the run."""
        end = self._follower.now + self._follower.hindsight.wait_s
        self._follower.look_until(end)
        self._judge(end)

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

    def _visit(self, row: int) -> Visited:
        """Close in on a point until the dwell is over or time is up."""
        self._row = row
        start, watch, aim = self._follower.now, _Watch(self._settings), self._aim(int(self._order[row]), 0.0)
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
        """Keep the dwell for pictures to judge, and for the truth to score."""
        times = watch.reached_s + self._follower.dt * np.arange(len(watch.places), dtype=np.float64)
        every = max(1, round(JUDGED_S * self._settings.rate_hz))
        self._follower.hindsight.dwelt(self._row, times[::every], np.array(watch.places[::every]))
        errors, now = np.array(watch.errors), self._follower.now
        inside = errors.max() <= self._settings.covered_m and watch.turn <= self._settings.covered_rad
        outcome = "covered" if inside else "missed"
        return Visited(outcome, start, watch.reached_s, now - watch.reached_s, now - start, errors, watch.turn)

    def _hold(self, number: int) -> Held:
        """Hold one of the points, evenly spread over the tour, and return its errors once there."""
        settings = self._settings
        point = int(self._order[number * len(self._order) // settings.hold_points])
        start, aim = self._follower.now, self._aim(point, 0.0)
        if not self._follower.within_reach(aim):
            return Held(point, start, math.nan, np.zeros(0))
        self._label(HOLD, -1 - number)
        self._go_to_hold(aim)
        scored = self._follower.now
        cycles = round(settings.hold_s * settings.rate_hz) - round(settings.hold_after_s * settings.rate_hz)
        misses = [self._follower.follow(aim) for _ in range(cycles)]
        if min(miss.believed for miss in misses) > FAR * settings.tolerance_m:
            return Held(point, start, math.nan, np.zeros(0))
        return Held(point, start, scored, np.array([miss.true for miss in misses]))

    def _go_to_hold(self, aim: Aim) -> None:
        """The way that does not count: the time for it and, where holds count from arrival, what a long way needs."""
        settings = self._settings
        miss, cycles = self._follower.follow(aim), 1
        least = latest = round(settings.hold_after_s * settings.rate_hz)
        if settings.hold_from_arrival:
            speed = settings.step_speed if settings.approach == "step" else settings.speed_max
            latest += round(miss.believed / speed * settings.rate_hz)
        while cycles < least or (cycles < latest and miss.believed > settings.tolerance_m):
            miss = self._follower.follow(aim)
            cycles += 1

    def _result(self, *, interrupted: bool) -> TrackResult:
        self._record.flush()
        follower, rows = self._follower, len(self._visits)
        toured_s = self._toured_s if math.isfinite(self._toured_s) else max(0.0, follower.now - self._begin_s)
        return result_of(
            self._surface,
            self._settings,
            self._record,
            rows_of(self._visits, self._order, self._plan.tries, self._verdicts),
            visits=self._visits,
            holds=self._holds,
            robot=follower.robot.name,
            motion=follower.motion.description,
            time_per_point_s=toured_s / rows if rows else math.nan,
            duration_s=follower.now,
            interrupted=interrupted,
            predictor_counters=dict(follower.belief.counters),
        )
