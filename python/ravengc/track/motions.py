"""How a surface moves: as a rigid body that shifts without turning, by a displacement that depends on time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_array, as_count, as_double, as_number, as_vector, check_type
from ravengc.errors import ArgumentError, ConfigError
from ravengc.sim.splines import natural_cubic
from ravengc.targets.motion import GAP

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Breathing", "Drifting", "Motion", "Playback", "drifting", "lujan", "recorded", "still"]

Array = NDArray[np.float64]

RESPIRATION = (0.95, 0.15, 0.27)
"""Directions of a liver's motion: superior-inferior, left-right, anterior-posterior."""
MOST_SAMPLES = 1_000_000
WIDEST = 2.5
"""Standard deviations to which breaths are cut."""


class Motion(Protocol):
    """What moves a surface. ``description`` says it in a few words."""

    @property
    def description(self) -> str:
        """The motion in a few words."""

    def positions(self, t: Array) -> Array:
        """Displacements (k, 3), m, base axes, at times ``t`` (k,), s."""

    def velocities(self, t: Array) -> Array:
        """Their rates (k, 3), m/s."""


@dataclass(frozen=True, slots=True)
class Breathing:
    """Breath k lasts from ``starts[k]`` for ``periods[k]`` (s) and moves ``amplitudes[k]`` (m) along ``direction``.

    The displacement is A sin^4(pi (t - t_k) / T_k); the first breath goes on before, the last one after.
    """

    starts: Array
    periods: Array
    amplitudes: Array
    direction: Array
    description: str = "breathing"

    def positions(self, t: Array) -> Array:
        """Displacements (k, 3), m, base axes, at times ``t`` (k,), s."""
        angle, amplitude, _ = self._breaths(t)
        shift: Array = (amplitude * np.sin(angle) ** 4)[:, None] * self.direction
        return shift

    def velocities(self, t: Array) -> Array:
        """Their rates (k, 3), m/s."""
        angle, amplitude, rate = self._breaths(t)
        speed: Array = 4.0 * amplitude * rate * np.sin(angle) ** 3 * np.cos(angle)
        return speed[:, None] * self.direction

    def _breaths(self, t: Array) -> tuple[Array, Array, Array]:
        """Phase (rad), amplitude (m) and rate of the phase (rad/s) at each time."""
        breath = np.clip(np.searchsorted(self.starts, t, side="right") - 1, 0, len(self.starts) - 1)
        rate = math.pi / self.periods[breath]
        return rate * (t - self.starts[breath]), self.amplitudes[breath], rate


def lujan(
    *,
    amplitude: float = 0.015,
    period_s: float = 4.0,
    variation: float = 0.1,
    seed: int = 0,
    direction: ArrayLike = RESPIRATION,
    duration_s: float = 3600.0,
) -> Breathing:
    """Breathe as Lujan et al. (Medical Physics 26(5), 1999): x = A sin^4(pi t / T), each breath a little different.

    Amplitude (m) and period of each breath are the mean times 1 + ``variation`` z with z normal, cut to 2.5 standard
    deviations. After ``duration_s`` the last breath repeats itself. ConfigError for numbers outside their range.
    """
    mean, span = _ranged(amplitude, "amplitude", 0.0, 10.0, " m"), _ranged(period_s, "period_s", 0.05, 1e3, " s")
    spread, length = _ranged(variation, "variation", 0.0, 0.35), _ranged(duration_s, "duration_s", 0.0, 1e6, " s")
    along = as_vector(direction, "direction", 3)
    if not np.linalg.norm(along) > 0.0:
        raise ArgumentError("direction is zero; expected a vector with a length")
    shortest = span * (1.0 - WIDEST * spread)
    draws = np.random.default_rng(as_count(seed, "seed", 0)).standard_normal((math.ceil(length / shortest) + 1, 2))
    factors = 1.0 + spread * np.clip(draws, -WIDEST, WIDEST)
    periods = span * factors[:, 1]
    starts = np.concatenate(([0.0], np.cumsum(periods)[:-1]))
    text = f"respiration {1e3 * mean:g} mm, {span:g} s, {100.0 * spread:g} % variation"
    return Breathing(starts, periods, mean * factors[:, 0], along / np.linalg.norm(along), text)


@dataclass(frozen=True, slots=True)
class Drifting:
    """Go at a steady ``velocity`` (3,), m/s, from ``start_s`` on; zero velocity is a surface at rest."""

    velocity: Array
    start_s: float = 0.0
    description: str = "still"

    def positions(self, t: Array) -> Array:
        """Displacements (k, 3), m, base axes, at times ``t`` (k,), s."""
        return np.maximum(t - self.start_s, 0.0)[:, None] * self.velocity

    def velocities(self, t: Array) -> Array:
        """Their rates (k, 3), m/s."""
        return (t >= self.start_s)[:, None] * self.velocity


def still() -> Drifting:
    """Do not move."""
    return Drifting(np.zeros(3))


def drifting(velocity: ArrayLike, *, start_s: float = 0.0) -> Drifting:
    """Go away at a steady ``velocity`` (3,), m/s, at most 10, from ``start_s`` (s) on."""
    rate = as_vector(velocity, "velocity", 3, 10.0).copy()
    begin = _ranged(start_s, "start_s", 0.0, 1e6, " s")
    return Drifting(rate, begin, f"drifting {1e3 * float(np.linalg.norm(rate)):g} mm/s from {begin:g} s on")


@dataclass(frozen=True, slots=True)
class Playback:
    """A recording, smooth between its samples, played forwards and backwards without end."""

    stamps: Array
    pieces: Array
    description: str = "recorded"

    def positions(self, t: Array) -> Array:
        """Displacements (k, 3), m, base axes, at times ``t`` (k,), s."""
        piece, s, _ = self._places(t)
        shift: Array = np.einsum("kcp,kp->kc", self.pieces[piece, :, :4], s[:, None] ** np.arange(4))
        return shift

    def velocities(self, t: Array) -> Array:
        """Their rates (k, 3), m/s."""
        piece, s, sense = self._places(t)
        powers = np.arange(1, 4) * s[:, None] ** np.arange(3)
        rate: Array = np.einsum("kcp,kp->kc", self.pieces[piece, :, 1:4], powers)
        return sense[:, None] * rate

    def _places(self, t: Array) -> tuple[NDArray[np.intp], Array, Array]:
        """Piece, time within it, and whether it is played forwards (1) or backwards (-1)."""
        length = self.stamps[-1] - self.stamps[0]
        lap, into = np.divmod(t, length)
        back = lap % 2.0 == 1.0
        time = self.stamps[0] + np.where(back, length - into, into)
        piece = np.clip(np.searchsorted(self.stamps, time, side="right") - 1, 0, len(self.pieces) - 1)
        return piece, time - self.stamps[piece], np.where(back, -1.0, 1.0)


def recorded(stamps: ArrayLike, displacement: ArrayLike, *, description: str = "recorded") -> Playback:
    """Move as recorded: ``displacement`` (k, 3), m, base axes, at ``stamps`` (k,), s; taken from its mean.

    Natural cubic splines lead from sample to sample; across a gap of more than five usual intervals it slows down, and
    goes from side to side without overshooting. At its end the recording is played backwards, then again.
    ArgumentError for stamps that do not increase and for numbers that are not finite.
    """
    check_type(description, str, "description")
    times, shifts = as_double(stamps, "stamps"), as_double(displacement, "displacement")
    increasing = times.ndim == 1 and np.isfinite(times).all() and bool((np.diff(times) > 0.0).all())
    if not increasing or not 3 <= len(times) <= MOST_SAMPLES:
        raise ArgumentError(f"stamps must be 3 to {MOST_SAMPLES} finite numbers that increase")
    if shifts.shape != (len(times), 3):
        raise ArgumentError(f"displacement has shape {shifts.shape}; expected {(len(times), 3)}, a row for each stamp")
    if not (np.abs(shifts) <= 1e3).all():
        raise ArgumentError("displacement holds a number that is not finite, or above 1000 m")
    stamps, places = _bridged(times, shifts - shifts.mean(axis=0))
    return Playback(stamps, natural_cubic(stamps, places), description)


def _bridged(times: Array, places: Array) -> tuple[Array, Array]:
    """Samples that lead from one side of each gap to the other at rest: a cubic with the speeds there swings far out.

    They stand twice as far from the gap's sides as the ones before, the first of them by the usual interval.
    """
    steps = np.diff(times)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    inside = [_from_both_sides(step, usual) for step in steps[gaps].tolist()]
    shares = [(0.5 - 0.5 * np.cos(np.pi * at / step))[:, None] for at, step in zip(inside, steps[gaps], strict=True)]
    rows = np.repeat(gaps + 1, [len(at) for at in inside])
    stamps = np.concatenate([np.empty(0), *(times[i] + at for i, at in zip(gaps, inside, strict=True))])
    between = [places[i] + share * (places[i + 1] - places[i]) for i, share in zip(gaps, shares, strict=True)]
    return np.insert(times, rows, stamps), np.insert(places, rows, np.concatenate([np.empty((0, 3)), *between]), axis=0)


def _from_both_sides(length: float, first: float) -> Array:
    """Times into a gap of this length: ``first``, twice, four times that from either side, up to its middle."""
    away = first * 2.0 ** np.arange(math.ceil(math.log2(0.5 * length / first)))
    return np.concatenate((away, length - away[::-1]))


def sampled(motion: Motion, t: Array) -> tuple[Array, Array]:
    """Positions and velocities (k, 3) of a motion that may be the caller's; ArgumentError unless they are numbers."""
    found = []
    for name in ("positions", "velocities"):
        rows = as_array(getattr(motion, name)(t), f"motion.{name}(t)")
        if rows.shape != (len(t), 3) or not np.isfinite(rows).all():
            raise ArgumentError(f"motion.{name}(t) must be {(len(t), 3)} finite numbers, a row for each time")
        found.append(rows.astype(np.float64, copy=False))
    return found[0], found[1]


def _ranged(x: float, name: str, low: float, high: float, unit: str = "") -> float:
    number = as_number(x, name)
    if not low <= number <= high:
        raise ConfigError(f"{name} is {number:g}{unit}; expected {low:g} to {high:g}{unit}")
    return number
