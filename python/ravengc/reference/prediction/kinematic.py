"""A target that keeps its velocity, or its acceleration, until it is pushed (Kalman; density by Mehra 1970)."""

from __future__ import annotations

from math import exp, factorial
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Kinematic"]

ADAPTATION = 0.02
START = 0.1
DENSITIES = (1e-9, 1e3)


class Kinematic:
    """Constant velocity (``order`` 1) or acceleration (2), pushed by white noise of a density that follows the innovations."""

    def __init__(self, order: int, noise: float) -> None:
        self.n = order + 1
        self.noise = noise**2
        self.density = 1e-4 if order == 1 else 1e-3
        self.time = np.nan

    def update(self, t: float, y: NDArray[np.float64]) -> None:
        """Take a sample."""
        n = self.n
        if np.isnan(self.time):
            self.x = np.zeros((n, len(y)))
            self.x[0] = y
            self.P = np.diag([self.noise] + [START**2] * (n - 1))
            self.time = t
            return
        dt, self.time = t - self.time, t
        F = np.array([[dt ** (j - i) / factorial(j - i) if j >= i else 0.0 for j in range(n)] for i in range(n)])
        G = np.array([dt ** (n - i) / factorial(n - i) for i in range(n)]) / np.sqrt(dt)
        self.x = F @ self.x
        self.P = F @ self.P @ F.T + self.density * np.outer(G, G)
        s = self.P[0, 0] + self.noise
        innovation, gain = y - self.x[0], self.P[:, 0] / s
        self.x = self.x + np.outer(gain, innovation)
        self.P = self.P - np.outer(gain, self.P[0])
        surprise = min(innovation @ innovation / (len(y) * s), 9.0)
        self.density = float(np.clip(self.density * exp(ADAPTATION * (surprise - 1.0)), *DENSITIES))

    def at(self, t: float) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Position and velocity at ``t``."""
        if np.isnan(self.time):
            return None
        powers = [(t - self.time) ** k / factorial(k) for k in range(self.n)]
        return np.array(powers) @ self.x, np.array(powers[:-1]) @ self.x[1:]
