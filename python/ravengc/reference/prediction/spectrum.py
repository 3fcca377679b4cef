"""The first guess of the cycles: the frequency whose harmonics fit best, and their shape from where it rests."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Cycles", "Spectrum"]

BINS = 64
CANDIDATES = 48
REFINEMENTS = 10
AS_GOOD = 0.2
MULTIPLE = 1.7
SHARE = 0.6
PHASES = 64


@dataclass(frozen=True)
class Cycles:
    """Cycles of one shape.

    ``rate`` in rad/s; ``phase`` from the rest at the end of the record, rad; ``rest`` (axes,) m; cosines and sines
    (harmonics, axes) m.
    """

    rate: float
    phase: float
    rest: NDArray[np.float64]
    cosines: NDArray[np.float64]
    sines: NDArray[np.float64]

    @property
    def size(self) -> float:
        """Sum of the squares of the shape's numbers, m²."""
        return float((self.cosines**2).sum() + (self.sines**2).sum())


class Spectrum:
    """A record of ``start`` seconds as means over short bins, and the search in it: one frequency per sample."""

    def __init__(self, band: tuple[float, float], harmonics: int, start: float) -> None:
        self.low, self.high = 2 * np.pi * band[0], 2 * np.pi * band[1]
        self.orders = np.arange(1, harmonics + 1)
        self.width = start / BINS
        self.samples: list[tuple[int, float, NDArray[np.float64]]] = []
        self.zero = np.nan
        self.trial = 0
        self.misfits = np.zeros(CANDIDATES)
        self.variance = 0.0
        self.best = (np.inf, 0.0)

    def record(self, t: float, y: NDArray[np.float64]) -> None:
        """Take a sample."""
        if np.isnan(self.zero):
            self.zero = t
        number = floor((t - self.zero) / self.width)
        self.samples = [sample for sample in self.samples if sample[0] > number - BINS]
        self.samples.append((number, t - self.zero, y))

    def search(self, t: float) -> Cycles | None:
        """Try the next frequency on a full record; the cycles at ``t`` when all were tried and one stands out."""
        if not self.samples or self.samples[-1][0] < BINS:
            return None
        rate = self.candidate()
        _, misfit, self.variance = self.fit(t, rate)
        if self.trial < CANDIDATES:
            self.misfits[self.trial] = misfit
        elif misfit < self.best[0]:
            self.best = (misfit, rate)
        self.trial += 1
        if self.trial == CANDIDATES:
            self.best = (np.inf, self.grid(self.coarse()))
        if self.trial < CANDIDATES + REFINEMENTS:
            return None
        self.trial = 0
        return self.cycles(t, self.best[1])

    def candidate(self) -> float:
        """The rate to try next, rad/s."""
        if self.trial < CANDIDATES:
            return self.grid(self.trial)
        step = 2 * (self.trial - CANDIDATES) / (REFINEMENTS - 1) - 1
        return self.grid(min(max(self.coarse() + step, 0), CANDIDATES - 1))

    def grid(self, number: float) -> float:
        """Rates in a geometric sequence over the band."""
        return float(self.low * (self.high / self.low) ** (number / (CANDIDATES - 1)))

    def coarse(self) -> int:
        """The candidate that fits best, or the highest multiple that fits well and better than its neighbours."""
        padded = np.concatenate([[np.inf], self.misfits, [np.inf]])
        best = int(np.argmin(self.misfits))
        fits = (self.misfits <= padded[:-2]) & (self.misfits <= padded[2:])
        fits &= self.misfits <= self.misfits[best] + AS_GOOD * self.variance
        fits &= np.array([self.grid(i) >= MULTIPLE * self.grid(best) for i in range(CANDIDATES)])
        return int(np.flatnonzero(fits)[-1]) if fits.any() else best

    def binned(self) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """Mean times since the first sample and mean places of the bins, and the sum of the variances within them."""
        numbers = np.array([sample[0] for sample in self.samples])
        times = np.array([sample[1] for sample in self.samples])
        places = np.array([sample[2] for sample in self.samples])
        groups = [numbers == number for number in np.unique(numbers)]
        within = sum(float(places[g].var(axis=0).sum()) for g in groups)
        return np.array([times[g].mean() for g in groups]), np.array([places[g].mean(axis=0) for g in groups]), within

    def fit(self, t: float, rate: float) -> tuple[NDArray[np.float64], float, float]:
        """Least squares of mean and harmonics: the numbers, the squares left, those about the mean."""
        times, places, _ = self.binned()
        angles = np.outer(rate * (times + self.zero - t), self.orders[: floor(np.pi / (rate * self.width))])
        rows = np.concatenate([np.ones((len(times), 1)), np.cos(angles), np.sin(angles)], axis=1)
        ridge = 1e-9 * (1 + (rows**2).sum())
        shift = places[-1]
        right = rows.T @ (places - shift)
        numbers = np.linalg.solve(rows.T @ rows + ridge * np.eye(rows.shape[1]), right)
        energy = float(((places - shift) ** 2).sum())
        left, about_mean = energy - float((numbers * right).sum()), energy - float((right[0] ** 2).sum()) / len(times)
        numbers[0] += shift
        return numbers, max(left, 0.0), about_mean

    def cycles(self, t: float, rate: float) -> Cycles | None:
        """The cycles of a rate, if they are most of the motion."""
        numbers, left, about_mean = self.fit(t, rate)
        within = self.binned()[2]
        if left + within > SHARE * (about_mean + within):
            return None
        seen, a = len(numbers) // 2, np.zeros((len(self.orders), numbers.shape[1]))
        b = np.zeros_like(a)
        a[:seen], b[:seen] = numbers[1 : 1 + seen], numbers[1 + seen :]
        rest = self.rest(a, b)
        c, s = np.cos(self.orders * rest)[:, None], np.sin(self.orders * rest)[:, None]
        cosines, sines = a * c + b * s, b * c - a * s
        return Cycles(rate, -rest, numbers[0] + cosines.sum(axis=0), cosines, sines)

    def rest(self, a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
        """The phase at which the shape moves and turns least."""
        phases = 2 * np.pi * np.arange(PHASES) / PHASES
        c, s = np.cos(np.outer(phases, self.orders)), np.sin(np.outer(phases, self.orders))
        speed = (c * self.orders) @ b - (s * self.orders) @ a
        turn = (c * self.orders**2) @ a + (s * self.orders**2) @ b
        return float(phases[np.argmin((speed**2).sum(axis=1) + 0.3 * (turn**2).sum(axis=1))])
