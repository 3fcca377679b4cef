"""Cycles of one learnt shape whose rate and size vary from cycle to cycle: an extended Kalman filter.

y = e + g Σ_k [a_k (cos kθ - 1) + b_k sin kθ], θ' = ω. Where the cycle rests (θ = 0), and only there, a breath forgets the rate
and size of the last one and takes new ones from their spread. After Yuen et al. 2009, with the shape of Lujan et al. 1999.
"""

from __future__ import annotations

from math import exp, floor
from typing import TYPE_CHECKING

import numpy as np

from ravengc.reference.prediction.spectrum import Cycles

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Cycles", "Periodic"]

SPREAD = 0.15
FORGETTING = 4.0
SHARPNESS = 6
WINDOW_MEAN = 924 / 4096
RESTING_DRIFT, SHAPE_DRIFT, RATE_DRIFT, SIZE_DRIFT, PHASE_DRIFT = 5e-4, 1e-5, 5e-4, 5e-4, 1e-4
ADAPTATION, LARGEST_SURPRISE, LOOSEST = 0.05, 6.0, 1e4
RATE_TIME = 20.0
MISTRUST = 2.0
LONGEST_STEP, MOST_STEPS = 0.05, 40
SIZES = (0.3, 3.0)
TURN = 2 * np.pi


class Periodic:
    """States: θ, ω, g, then per axis e, a_1…a_m, b_1…b_m."""

    def __init__(self, band: tuple[float, float], harmonics: int, noise: float) -> None:
        self.band = (TURN * band[0], TURN * band[1])
        self.orders = np.arange(1, harmonics + 1)
        self.noise = (MISTRUST * noise) ** 2
        self.time = np.nan

    def begin(self, t: float, cycles: Cycles) -> None:
        """Begin with the cycles that were found in a record, at its end."""
        self.axes, width = len(cycles.rest), 1 + 2 * len(self.orders)
        self.time, self.mean_rate, self.size, self.looseness = t, cycles.rate, cycles.size, 1.0
        doubt = 0.02 * self.size + self.noise
        own = np.concatenate([cycles.rest[None], cycles.cosines, cycles.sines]).T
        self.x = np.concatenate([[cycles.phase, cycles.rate, 1.0], own.ravel()])
        variances = doubt / np.concatenate([[1], self.orders, self.orders]) ** 2
        self.P = np.diag([0.3, (SPREAD * cycles.rate) ** 2, SPREAD**2, *np.tile(variances, self.axes)])
        shape = np.tile([RESTING_DRIFT] + [SHAPE_DRIFT] * (width - 1), self.axes) * self.size
        self.drift = np.array([PHASE_DRIFT, np.nan, SIZE_DRIFT, *shape])

    def update(self, t: float, y: NDArray[np.float64]) -> None:
        """Take a sample."""
        if np.isnan(self.time):
            return
        self.advance(t - self.time)
        self.time = t
        self.correct(y)
        self.x[1] = np.clip(self.x[1], *self.band)
        self.x[2] = np.clip(self.x[2], *SIZES)

    def advance(self, time: float) -> None:
        """In steps of a twentieth of a cycle, so that no rest is stepped over; but not in too many."""
        step, left = max(LONGEST_STEP * TURN / self.mean_rate, time / MOST_STEPS), time
        while left > 0:
            self.step(min(left, step))
            left -= step

    def step(self, dt: float) -> None:
        """Move the cycle on, let rate and size go where it rests, and let everything drift."""
        x, window = self.x, ((1 + np.cos(self.x[0])) / 2) ** SHARPNESS
        kept = exp(-FORGETTING * window / WINDOW_MEAN * self.mean_rate / TURN * dt)
        F = np.eye(len(x))
        F[0, 1], F[1, 1], F[2, 2] = dt, kept, kept
        theta = x[0] + x[1] * dt
        x[0] = theta - TURN * floor((theta + np.pi) / TURN)
        x[1] = self.mean_rate + kept * (x[1] - self.mean_rate)
        x[2] = 1 + kept * (x[2] - 1)
        taken = (1 - kept**2) * SPREAD**2
        drift = self.drift * self.looseness * dt
        drift[1] = (taken + RATE_DRIFT * self.looseness * dt) * self.mean_rate**2
        drift[2] += taken
        self.P = F @ self.P @ F.T + np.diag(drift)
        self.mean_rate += (x[1] - self.mean_rate) * min(dt / RATE_TIME, 1)

    def correct(self, y: NDArray[np.float64]) -> None:
        """All axes at once."""
        places, H = self.model(self.x[0])
        S = H @ self.P @ H.T + self.noise * np.eye(self.axes)
        gain = np.linalg.solve(S, H @ self.P).T
        innovation = y - places
        surprise = float(innovation @ np.linalg.solve(S, innovation)) / self.axes
        self.x = self.x + gain @ innovation
        self.P = self.P - gain @ S @ gain.T
        change = exp(ADAPTATION * (min(surprise, LARGEST_SURPRISE) - 1))
        self.looseness = float(np.clip(self.looseness * change, 1, LOOSEST))

    def model(self, theta: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Places at a phase (axes,), and how they depend on the states (axes, states)."""
        m, x = len(self.orders), self.x
        c, s = np.cos(self.orders * theta), np.sin(self.orders * theta)
        basis = np.concatenate([c - 1, s])
        own = x[3:].reshape(self.axes, 1 + 2 * m)
        a, b = own[:, 1 : 1 + m], own[:, 1 + m :]
        H = np.zeros((self.axes, len(x)))
        H[:, 0] = x[2] * (b * c - a * s) @ self.orders
        H[:, 2] = own[:, 1:] @ basis
        for axis in range(self.axes):
            j = 3 + axis * (1 + 2 * m)
            H[axis, j] = 1
            H[axis, j + 1 : j + 1 + 2 * m] = x[2] * basis
        return own[:, 0] + x[2] * H[:, 2], H

    def at(self, t: float) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Position and velocity at ``t``."""
        if np.isnan(self.time):
            return None
        places, H = self.model(self.x[0] + self.x[1] * (t - self.time))
        return places, H[:, 0] * self.x[1]
