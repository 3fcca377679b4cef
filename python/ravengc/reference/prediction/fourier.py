"""Sines of fixed frequencies over the band, their amplitudes followed by a Kalman filter (Veluvolu & Ang 2011)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Fourier"]

LINES = 12
MISTRUST = 2.0
START = 0.01
WALK = 1e-5


class Fourier:
    """Weights of a constant and of the cosines and sines of 12 frequencies evenly over ``band`` (Hz)."""

    def __init__(self, band: tuple[float, float], noise: float) -> None:
        self.w = 2 * np.pi * np.linspace(*band, LINES)
        self.noise = (MISTRUST * noise) ** 2
        self.time = np.nan

    def basis(self, t: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The sines at ``t``, and their rates."""
        c, s = np.cos(self.w * (t - self.zero)), np.sin(self.w * (t - self.zero))
        return np.concatenate([[1.0], c, s]), np.concatenate([[0.0], -self.w * s, self.w * c])

    def update(self, t: float, y: NDArray[np.float64]) -> None:
        """Take a sample."""
        if np.isnan(self.time):
            self.zero = self.time = t
            self.weights = np.zeros((1 + 2 * LINES, len(y)))
            self.weights[0] = y
            self.P = START**2 * np.eye(1 + 2 * LINES)
        self.P = self.P + WALK * (t - self.time) * np.eye(len(self.P))
        self.time = t
        h, _ = self.basis(t)
        gain = self.P @ h / (h @ self.P @ h + self.noise)
        self.weights = self.weights + np.outer(gain, y - h @ self.weights)
        self.P = self.P - np.outer(gain, self.P @ h)

    def at(self, t: float) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Position and velocity at ``t``."""
        if np.isnan(self.time):
            return None
        basis, rates = self.basis(t)
        return basis @ self.weights, rates @ self.weights
