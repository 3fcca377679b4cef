"""The linear system in time, many cases at once: the check of the certificate that knows nothing of poles.

Each case is z' = A z + B u, p = Cp z + Dp u, u(t) = rho p(t - T) (:mod:`state_space`), stepped by the exact solution
for an input that runs straight from sample to sample; the delay is a whole number of steps of a ring buffer. Cases of
one size go together; each has its own step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_count, as_double
from ravengc.errors import ArgumentError
from ravengc.stability.state_space import state_space
from ravengc.stability.system import System

__all__ = ["Growth", "simulate"]

Array = NDArray[np.float64]

MOST_STEPS = 10_000_000
TERMS = 14
"""Of the exponential's series, after scaling to norms of at most a half."""
HUGE = 1e200


@dataclass(frozen=True, slots=True)
class Growth:
    """How a case's motion grew: ``rate`` (1/s) between the third and the last quarter, over ``duration_s``."""

    rate: float
    duration_s: float

    @property
    def grows(self) -> bool:
        """The last quarter swings further than the third."""
        return self.rate > 0.0


def simulate(systems: Sequence[System], longest_step_s: Sequence[float], steps: int) -> list[Growth]:
    """Simulate systems that have the same numbers of coordinates, signals and filter states, from a shove of all.

    Each must have a delay; ArgumentError for one without.

    ``longest_step_s``: for each; shortened so that the delay is a whole number of steps, at least one.
    """
    if not isinstance(systems, Sequence) or not systems or not all(isinstance(one, System) for one in systems):
        raise ArgumentError("systems: expected a list of one System or more")
    steps, longest = as_count(steps, "steps", 4, MOST_STEPS), as_double(longest_step_s, "longest_step_s")
    if longest.shape not in {(), (len(systems),)} or not (longest > 0.0).all():
        raise ArgumentError(f"longest_step_s must be positive, one or {len(systems)}")
    delays = np.array([system.sensing.delay_s for system in systems])
    if not (delays > 0.0).all():
        raise ArgumentError(f"systems[{int(np.argmin(delays))}] has no delay; expected one above zero, which sets the step")
    lags = np.maximum(1, np.ceil(delays / longest - 1e-9)).astype(int)
    step = delays / lags
    forward, out = _transitions(systems, step)
    z = np.zeros((len(systems), out.shape[2] - out.shape[1], 1))
    z[:, systems[0].size : 2 * systems[0].size] = 1.0  # every coordinate moves, at speed 1 in units of unit mass
    with np.errstate(all="ignore"):
        peaks = _quarters(forward, out, z, lags, steps, systems[0].size)
        rates = np.log(peaks[3] / peaks[2]) / (0.25 * steps * step)
    rates = np.where(np.isfinite(rates), rates, math.inf)
    return [Growth(float(rate), float(steps * h)) for rate, h in zip(rates, step, strict=True)]


def _transitions(systems: Sequence[System], step: Array) -> tuple[Array, Array]:
    """For every case (z, u, u next) -> z next, and (z, u) -> rho p."""
    spaces = [state_space(system) for system in systems]
    gains = np.array([system.sensing.gain for system in systems])[:, None, None]
    a, b, c, d = (np.stack([getattr(space, name) for space in spaces]) for name in "abcd")
    k, r = b.shape[1:]
    whole = np.zeros((len(systems), k + 2 * r, k + 2 * r))
    whole[:, :k, :k], whole[:, :k, k : k + r] = a, b
    whole *= step[:, None, None]
    whole[:, k : k + r, k + r :] = np.eye(r)  # u runs to its next value within the step
    exact = _exponential(whole)
    start = exact[:, :k, k : k + r] - exact[:, :k, k + r :]
    return np.concatenate([exact[:, :k, :k], start, exact[:, :k, k + r :]], axis=2), gains * np.concatenate([c, d], 2)


def _quarters(forward: Array, out: Array, z: Array, lags: NDArray[np.int_], steps: int, n: int) -> Array:
    """Largest speed in each quarter of the time, (4, cases)."""
    cases, r = len(z), out.shape[1]
    ring = np.zeros((int(lags.max()) + 1, cases, r, 1))
    each, peaks = np.arange(cases), np.zeros((4, cases))
    u = np.zeros((cases, r, 1))
    for i in range(steps):
        ring[i % len(ring)] = out @ np.concatenate([z, u], axis=1)
        upcoming = ring[(i + 1 - lags) % len(ring), each]
        z = forward @ np.concatenate([z, u, upcoming], axis=1)
        u = upcoming
        speed = np.abs(z[:, n : 2 * n, 0]).max(axis=1)
        quarter = peaks[4 * i // steps]
        np.maximum(quarter, speed, out=quarter)
        if i % 256 == 0:
            z[speed > HUGE] = math.inf
    return peaks


def _exponential(matrices: Array) -> Array:
    """e^A for every matrix: scaling, series, squaring."""
    largest = float(np.abs(matrices).sum(axis=2).max())
    halvings = max(0, math.ceil(math.log2(max(largest, 1e-300))) + 1)
    small = matrices / 2.0**halvings
    found = term = np.broadcast_to(np.eye(matrices.shape[1]), matrices.shape)
    for k in range(1, TERMS + 1):
        term = term @ small / k
        found = found + term
    for _ in range(halvings):
        found = found @ found
    return np.array(found)
