"""What a run meets, cycle by cycle, kept small: blocks of cycles become sums, counts and rows of the trace."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.track.result import PHASES, Trace

if TYPE_CHECKING:
    from ravengc.robot import Robot
    from ravengc.track.approach import Triple
    from ravengc.track.settings import TrackSettings

__all__ = ["Recorder", "limits_of"]

Array = NDArray[np.float64]

BLOCK = 1024
BEYOND = 1e-9
"""rad, m, or their rates: what rounding may add to a limit."""
TOURING = (PHASES.index("approach"), PHASES.index("dwell"))


class Recorder:
    """Collects a run; ``phase`` (its place in PHASES) and ``visit`` label the cycles to come."""

    def __init__(self, robot: Robot, settings: TrackSettings) -> None:
        lower, upper, fastest = limits_of(robot)
        self._lower, self._upper, self._fastest = lower - BEYOND, upper + BEYOND, fastest + BEYOND
        self._rate_hz = settings.rate_hz
        self._every = max(1, round(settings.rate_hz / settings.trace_hz))
        self.phase = self.visit = 0
        width = {"t": 1, "label": 2, "q": robot.n, "qd": robot.n, "points": 15, "rate": 2}
        self._block = {name: np.zeros((BLOCK, columns)) for name, columns in width.items()}
        self._filled = self._done = 0
        self._rows: list[dict[str, Array]] = []
        self._pictures: list[tuple[float, ...]] = []
        self._costs: list[int] = []
        self._last_places = np.zeros((0, 3))
        self.violations = {"position": 0, "velocity": 0}
        self._accelerations = _Sum()
        self._misses = _Sum()

    def picture(self, stamp: float, seen: Triple) -> None:
        """Keep a measurement."""
        self._pictures.append((stamp, *seen))

    def cost(self, nanoseconds: int) -> None:
        """Keep what a control cycle cost."""
        self._costs.append(nanoseconds)

    def cycle(self, t: float, q: Array, qd: Array, points: tuple[float, ...], scale: float, sigma_min: float) -> None:
        """Keep a cycle. ``points`` (15,): tool, its axis, the way to the aim, true and believed displacement."""
        block, i = self._block, self._filled
        block["t"][i] = t
        block["label"][i] = self.phase, self.visit
        block["q"][i] = q
        block["qd"][i] = qd
        block["points"][i] = points
        block["rate"][i] = scale, sigma_min
        self._filled += 1
        if self._filled == BLOCK:
            self.flush()

    def flush(self) -> None:
        """Turn the cycles that wait into sums, counts and rows."""
        filled, self._filled = self._filled, 0  # so that no cycle counts twice if Ctrl-C comes
        block = {name: rows[:filled] for name, rows in self._block.items()}
        q, points = block["q"], block["points"]
        self.violations["position"] += int(((q < self._lower) | (q > self._upper)).any(axis=1).sum())
        self.violations["velocity"] += int((np.abs(block["qd"]) > self._fastest).any(axis=1).sum())
        self._misses.add(np.square(points[:, 9:12] - points[:, 12:15]).sum(axis=1))
        self._accelerate(points[:, :3], np.isin(block["label"][:, 0], TOURING))
        first = -self._done % self._every
        self._rows.append({name: rows[first :: self._every].copy() for name, rows in block.items()})
        self._done += filled

    def _accelerate(self, places: Array, touring: NDArray[np.bool_]) -> None:
        """Add the tool's second differences that end in cycles of the tour."""
        path = np.vstack((self._last_places, places))
        second = np.diff(path, n=2, axis=0) * self._rate_hz**2
        self._accelerations.add(np.square(second).sum(axis=1)[touring[len(touring) - len(second) :]])
        self._last_places = path[-2:].copy()

    @property
    def acceleration(self) -> tuple[float, float]:
        """RMS and largest acceleration of the tool during the tour, m/s^2."""
        return self._accelerations.rms, math.sqrt(self._accelerations.most)

    @property
    def prediction_rms(self) -> float:
        """RMS distance of the believed from the true displacement, m."""
        return self._misses.rms

    @property
    def cost_us(self) -> dict[str, float]:
        """Median and 99th percentile of a control cycle's cost, µs."""
        if not self._costs:
            return {"median": math.nan, "p99": math.nan}
        median, p99 = np.percentile(np.array(self._costs) / 1e3, (50.0, 99.0)).tolist()
        return {"median": median, "p99": p99}

    @property
    def pictures(self) -> Array:
        """Measurements (k, 4): stamp and displacement."""
        return np.array(self._pictures, dtype=float).reshape(-1, 4)

    def trace(self) -> Trace:
        """The rows that were kept; call :meth:`flush` before."""
        kept = {name: np.concatenate([rows[name] for rows in self._rows]) for name in self._block}
        tool, axis, off, truth, taken = np.split(kept["points"], 5, axis=1)
        return Trace(
            stamps=kept["t"][:, 0],
            phase=np.array(PHASES)[kept["label"][:, 0].astype(int)],
            visit=kept["label"][:, 1].astype(np.intp),
            q=kept["q"],
            tool=tool,
            axis=axis,
            target=tool + off,
            displacement=truth,
            predicted=taken,
            error_m=np.linalg.norm(off, axis=1),
            scale=kept["rate"][:, 0],
            sigma_min=kept["rate"][:, 1],
        )


class _Sum:
    """Root mean square and largest of squares that come in pieces."""

    def __init__(self) -> None:
        self._total, self._count, self.most = 0.0, 0, 0.0

    def add(self, squares: Array) -> None:
        self._total += float(squares.sum())
        self._count += len(squares)
        self.most = max(self.most, float(squares.max(initial=0.0)))

    @property
    def rms(self) -> float:
        return math.sqrt(self._total / self._count) if self._count else math.nan


def limits_of(robot: Robot) -> tuple[Array, Array, Array]:
    """Lower, upper and velocity limits of the coordinates, (n,); infinite where the robot has none."""
    limits: list[Any] = [(each.lower, each.upper, each.velocity) for each in robot.spec.coordinate_limits]
    open_ended = (-math.inf, math.inf, math.inf)
    rows = [[end if value is None else value for value, end in zip(row, open_ended, strict=True)] for row in limits]
    lower, upper, fastest = np.array(rows, dtype=float).T
    return lower, upper, fastest
