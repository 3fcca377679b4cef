"""The target some time ahead as a weighted sum of where it was (direct multi-step prediction, e.g. Ernst 2012)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Autoregressive"]

PIECES = (1,) * 19 + (3, 4, 6, 8)
NODES = (0.5, 1.0, 1.5)
MEMORY = 30.0
RIDGE = 1e-4
FEWEST = 36
ROWS = 4
STRAIGHT, STANDING = 1.75, 3.0
RING = 160



class Autoregressive:
    """Weights of the means of the target's place over 23 pieces of the past, learnt for half of, one and one and a half ``horizon``.

    The weights come from the normal equations as they were some samples before: the core solves them a few rows per sample.
    """

    def __init__(self, rate_hz: float, horizon: float) -> None:
        self.step = max(1.0 / rate_hz, horizon / 16.0)
        self.horizon = horizon
        self.times: list[float] = []
        self.places: list[NDArray[np.float64]] = []
        self.A = np.zeros((len(PIECES), len(PIECES)))
        self.b = np.zeros((len(PIECES), len(NODES)))
        self.learnt, self.taught = 0, -np.inf
        self.row = 0
        self.weights: NDArray[np.float64] | None = None
        self.curve: NDArray[np.float64] | None = None
        ends = np.cumsum((0, *PIECES))
        self.means = np.zeros((len(PIECES), ends[-1]))
        for b, length in enumerate(PIECES):
            self.means[b, ends[b] : ends[b + 1]] = 1.0 / length

    def between(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places at ``times``, on straight lines between the samples."""
        places = np.array(self.places)
        return np.stack([np.interp(times, self.times, axis) for axis in places.T], axis=1)

    def differences(self, i: int) -> NDArray[np.float64] | None:
        """Means of the pieces before the i-th sample, less its place: (pieces, axes)."""
        times = self.times[i] - self.step * np.arange(1, self.means.shape[1] + 1)
        if times[-1] < self.times[0]:
            return None
        return np.asarray(self.means @ self.between(times) - self.places[i])

    def update(self, t: float, y: NDArray[np.float64]) -> None:
        """Take a sample; those much closer than a step are left out."""
        if self.times and t - self.times[-1] < 0.6 * self.step:
            return
        self.times, self.places = [*self.times, t][-RING:], [*self.places, y][-RING:]
        self.learn(t)
        self.solve()
        self.curve = None
        rows = self.differences(len(self.times) - 1)
        if self.weights is not None and rows is not None:
            self.curve = y + self.weights.T @ rows

    def learn(self, t: float) -> None:
        """Let the newest sample whose future is known teach."""
        i = int(np.searchsorted(self.times, t - NODES[-1] * self.horizon, side="right")) - 1
        rows = self.differences(i) if i >= 0 and self.times[i] > self.taught else None
        if rows is None:
            return
        targets = self.between(self.times[i] + self.horizon * np.array(NODES)) - self.places[i]
        kept = np.exp(-min(self.times[i] - self.taught, MEMORY) / MEMORY)
        self.taught = self.times[i]
        self.A, self.b = kept * self.A + rows @ rows.T, kept * self.b + rows @ targets.T
        self.learnt += 1

    def solve(self) -> None:
        """Go on with the solution: equations are taken at its first sample, weights are there at its last."""
        if self.row == 0:
            if self.learnt < FEWEST:
                return
            ridge = RIDGE * np.mean(np.diag(self.A)) + np.finfo(float).tiny
            self.equations = self.A + ridge * np.eye(len(self.A)), self.b
        self.row += ROWS
        if self.row >= len(PIECES):
            self.row = 0
            self.weights = np.linalg.solve(*self.equations)

    def at(self, t: float) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Position and velocity at ``t``: on a parabola through the nodes, then on a straight line, then standing."""
        if self.curve is None:
            return None
        first, second, third = self.curve
        ahead = (t - self.times[-1]) / self.horizon
        slope, bend = (third - first) / 2, (third + first) / 2 - second
        u = 2 * (np.clip(ahead, 0, STRAIGHT) - 1)
        beyond = 2 * max(np.clip(ahead, 0, STANDING) - STRAIGHT, 0.0)
        tangent = slope + 2 * bend * u
        velocity = tangent * (2 / self.horizon) if 0 <= ahead < STANDING else np.zeros_like(tangent)
        return second + slope * u + bend * u**2 + tangent * beyond, velocity
