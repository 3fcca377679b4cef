"""What a base's gyroscope says, against what its accelerometer sees: gravity turns as the base does, the other way.

On a base that turns by w, in its own axes, the direction d of gravity changes by d x w per second. Over short spans

    d(end) - d(start) = Σ_k gain_k ∫ d x e_k w_k dt + ∫ d x b dt

with a gain of each axis, one if the gyroscope is right, and the bias b that it may have. A gain of 1/57.3 is another
unit, one of -1 a sign, and where no gain explains what gravity does the gyroscope is not believed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ravengc.errors import ConfigError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ravengc.recordings import Recording as Motion
    from ravengc.recordings.recording import FloatArray

__all__ = ["checked_turning"]

SPAN_S, SPARSE, FEWEST = 0.25, 5, 20
"""s; fewer samples in a span than the second are too few, fewer spans than the third."""
SEEN = np.radians(1.0)
"""Gravity that turns by less within a span (RMS) does not turn."""
SPINS, STEADY, PERSISTS = 0.02, 0.2, 0.5
"""rad/s: a spin about the vertical spreads by more, about a mean of less; and this share of it is no noise."""
SURE = 0.1
"""Relative standard error up to which a gain counts."""
EXPLAINED, HALF, AGREES = 0.8, 0.5, 0.95
"""Shares of gravity's turning: with gains, for these to be the cause; without, to be believed; and to be right."""
NEAR = 0.1
TURN, THOUSAND = 180.0 / np.pi, 1000.0


def checked_turning(motion: Motion) -> tuple[Motion, tuple[str, ...]]:
    """The motion with the base's angular velocity if that can be believed, else without it, and notes why.

    Raises ConfigError where gravity turns as the gyroscope says but for a unit or a sign.
    """
    rates, gravity = motion.angular_velocity, motion.gravity
    if rates is None or gravity is None:
        return motion, ()
    down, spans = gravity / np.linalg.norm(gravity, axis=1, keepdims=True), _Spans.of(motion.t)
    why = _useless(rates, down, spans)
    if why:
        return replace(motion, angular_velocity=None), (f"the base's gyroscope is not used: {why}",)
    fastest = f"the base turns at up to {np.linalg.norm(rates, axis=1).max():.3g} rad/s by its gyroscope"
    if _rms(spans.change(down)) < SEEN:
        return motion, (f"{fastest}, about the vertical",)
    found = _Comparison.of(rates, down, spans)
    found.refuse(motion.source)
    if found.plain < HALF:
        return replace(motion, angular_velocity=None), (f"the base's gyroscope is not used: {found.verdict()}",)
    return motion, (fastest, *([f"the base's gyroscope: {found.verdict()}"] if found.plain < AGREES else []))


@dataclass(frozen=True, slots=True)
class _Spans:
    """First and last samples of all short spans in which samples are dense."""

    t: FloatArray
    first: NDArray[np.intp]
    last: NDArray[np.intp]

    @classmethod
    def of(cls, t: FloatArray) -> _Spans:
        last = np.minimum(np.searchsorted(t, t + SPAN_S), t.size - 1)
        first = np.arange(t.size)
        lasts = t[last] - t
        dense = (lasts >= 0.9 * SPAN_S) & (lasts <= 1.5 * SPAN_S) & (last - first >= SPARSE)
        return cls(t, first[dense], last[dense])

    def change(self, values: FloatArray) -> FloatArray:
        """By how much the columns change within each span."""
        return np.asarray(values[self.last] - values[self.first])

    def integral(self, rates: FloatArray) -> FloatArray:
        """Integrals of the columns over each span, by trapezoids."""
        areas = 0.5 * (rates[1:] + rates[:-1]) * np.diff(self.t)[:, np.newaxis]
        return self.change(np.concatenate([np.zeros((1, rates.shape[1])), np.cumsum(areas, axis=0)]))


def _useless(rates: FloatArray, down: FloatArray, spans: _Spans) -> str:
    """Why the gyroscope says nothing that could be compared; empty where it does."""
    if not np.ptp(rates, axis=0).any():
        return "it reads the same in every sample"
    if spans.first.size < FEWEST:
        return "samples are too far apart to follow a base that turns"
    if _rms(spans.change(down)) < SEEN and not _spins((rates * down).sum(axis=1), spans):
        return "the base does not turn while samples are taken"
    return ""


def _spins(rate: FloatArray, spans: _Spans) -> bool:
    """Whether the base turns about the vertical, where the accelerometer is blind; noise averages out over a span."""
    calm = spans.integral(rate[:, np.newaxis])[:, 0] / (spans.t[spans.last] - spans.t[spans.first])
    spread = float(calm.std())
    moves = spread > SPINS and spread > PERSISTS * float(rate.std())
    return moves or (abs(float(calm.mean())) > STEADY and abs(float(calm.mean())) > float(rate.std()))


@dataclass(frozen=True, slots=True)
class _Comparison:
    """``gains`` (3,) of the axes with their standard errors, and the shares of gravity's turning that are explained.

    ``fitted`` with these gains, ``plain`` with gains of one; both with a constant bias.
    """

    gains: FloatArray
    errors: FloatArray
    fitted: float
    plain: float

    @classmethod
    def of(cls, rates: FloatArray, down: FloatArray, spans: _Spans) -> _Comparison:
        seen = spans.change(down)
        about = [np.cross(down, axis) for axis in np.eye(3)]
        said = [spans.integral(across * rates[:, k : k + 1]) for k, across in enumerate(about)]
        drift = np.column_stack([spans.integral(across).ravel() for across in about])
        X = np.column_stack([*(one.ravel() for one in said), drift])
        y, total = seen.ravel(), float((seen**2).sum())
        found, left = _least_squares(X, y)
        per_span = float(np.mean(spans.last - spans.first))
        spread = np.linalg.pinv(X.T @ X).diagonal()[:3] * left / max(y.size - X.shape[1], 1) * per_span
        plain = _least_squares(drift, y - X[:, :3].sum(axis=1))[1]
        return cls(found[:3], np.sqrt(np.maximum(spread, 0.0)), 1.0 - left / total, 1.0 - plain / total)

    @property
    def _factors(self) -> dict[str, float]:
        """How many times the true rate the gyroscope says, about the axes for which that can be told."""
        rows = zip("xyz", self.gains, self.errors, strict=True)
        return {axis: 1.0 / float(gain) for axis, gain, error in rows if error < SURE * abs(gain)}

    def refuse(self, source: str) -> None:
        """Raise ConfigError where a unit or a sign explains what gravity does."""
        factors = self._factors
        if self.fitted < EXPLAINED or not factors:
            return
        if turned := [axis for axis, factor in factors.items() if factor < 0.0]:
            where = "" if len(turned) == len(factors) else f" about {', '.join(turned)}"
            raise ConfigError(
                f"{source}: the angular velocity has the wrong sign{where}: gravity turns the other way; right-handed"
                " about the base's axes is expected"
            )
        size = float(np.exp(np.mean(np.log(list(factors.values())))))
        if not 0.5 < size < 2.0:
            raise ConfigError(
                f"{source}: the angular velocity is {size:.3g} times as fast as gravity turns{_unit(size)}"
            )

    def verdict(self) -> str:
        """What is not right."""
        off = {axis: factor for axis, factor in self._factors.items() if abs(factor - 1.0) > NEAR}
        if off and self.fitted >= AGREES:
            said = ", ".join(f"{factor:.2g} times about {axis}" for axis, factor in off.items())
            return f"it turns faster or slower than gravity does, {said}: is its scale right?"
        return (
            f"it explains {max(self.plain, 0.0):.0%} of how gravity turns: is it late, are its axes the base's, or does"
            " the base accelerate more than it turns?"
        )


def _least_squares(X: FloatArray, y: FloatArray) -> tuple[FloatArray, float]:
    """The solution, and the sum of the squares that it leaves."""
    found: FloatArray = np.asarray(np.linalg.lstsq(X, y, rcond=1e-9)[0], dtype=np.float64)
    return found, float(((y - X @ found) ** 2).sum())


def _unit(factor: float) -> str:
    """What explains an angular velocity that is so many times the true one."""
    causes = {
        TURN: ": it is in deg/s; say --units deg/s, or in a header 'wx [deg/s]'",
        THOUSAND: ": it is in mrad/s; say --units mrad/s, or in a header 'wx [mrad/s]'",
        1.0 / TURN: ": it is in rad/s, and was taken for deg/s",
        1.0 / THOUSAND: ": it is in rad/s, and was taken for mrad/s",
    }
    near = min(causes, key=lambda known: abs(np.log(factor / known)))
    return causes[near] if 0.7 < factor / near < 1.4 else "; expected once, in rad/s"


def _rms(rows: FloatArray) -> float:
    """Of the lengths of the rows."""
    return float(np.sqrt((rows**2).sum(axis=1).mean())) if len(rows) else 0.0
