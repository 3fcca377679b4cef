"""Where on the base the sensor sits, from its own readings while the base rocks about a fixed point.

A sensor at r from the pivot reads f_s = f + ω̇ × r + ω × (ω × r), all in base axes; at the pivot the specific force f is
gravity alone, which stays put in the world: with C the rotation from present base axes to those at the start, C f = f0.
Both turning terms are the derivative of C (ω × r), so over an interval from t1 to t2

    mean of C f_s = f0 + (C2 [ω2]× - C1 [ω1]×) r / (t2 - t1),

linear in f0 and r, with no angular acceleration to be differentiated from a noisy gyroscope. C comes from the
gyroscope, whose constant bias is estimated beside them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_double, as_vector
from ravengc.calibration.imu import STANDARD_GRAVITY, FloatArray, as_gravity, as_rows
from ravengc.calibration.kabsch import cross_matrices
from ravengc.calibration.least_squares import condition_of
from ravengc.errors import ArgumentError, CalibrationError, UnitsError

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["LeverArm", "fit_lever_arm"]

INTERVALS_S = (0.05, 0.1, 0.2, 0.4)
"""Tried in turn: the shortest over which the gyroscope's noise is small against what its rate changes."""
NOISE_SHARE = 0.005
"""Largest share of noise in the power of ω̇; the lever arm would come out too short by this share."""
LEAST_TURN = 0.05
"""rad/s RMS; slower motion moves no sensor measurably."""
WORST_CONDITION = 100.0
LEAST_SIGNAL = 20.0
"""How far the turning terms of every component of r must stand above the gyroscope's noise, in power."""
LARGEST_ERROR = 0.01
"""m; a component that is known worse is undetermined."""
RATE_BIAS = 0.05
"""rad/s; how large the gyroscope's bias may be that was not taken off before."""
GOOD_RESIDUAL = 0.2
"""m/s² RMS of the interval means."""
UNEXPLAINED = (
    "the turning does not explain the readings: did the pivot stay at rest? Are axes, signs and time of gyroscope and "
    "accelerometer alike?"
)
GRAVITY_TOLERANCE = 0.03
ROUNDS = 6
SHORTEST_S, FEWEST_SAMPLES = 0.5, 50
LONGEST_GAP = 10.0
"""In sample periods; how the base turned in a longer pause is not known."""
UNITS = {"deg/s": np.pi / 180.0, "mrad/s": 1e-3, "rad/s taken for deg/s": 180.0 / np.pi}
"""What an angular velocity may be that does not explain the readings as rad/s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LeverArm:
    """The sensor's ``position`` (3,) and its standard errors, m, base axes.

    ``gyro_bias`` (3,), rad/s, is what the fit took off the angular velocity; about the vertical it is known worse.
    ``gravity`` is the length of f0, m/s², g if the accelerometer is calibrated and the pivot at rest. ``measured`` and
    ``predicted`` are C f_s - f0 and the turning terms, (n, 3), m/s², in base axes of the start, at ``t`` (n,), s.
    """

    position: FloatArray
    position_error: FloatArray
    gyro_bias: FloatArray
    gravity: float
    condition: float
    t: FloatArray
    measured: FloatArray
    predicted: FloatArray
    good: bool
    verdict: str

    @property
    def residual(self) -> float:
        """RMS of measured - predicted, m/s²."""
        return _rms(self.measured - self.predicted)


@dataclass(frozen=True, slots=True)
class _Intervals:
    """Per interval: middle (s), mean of C f_s, matrix D of r, and the derivative of C f_s - D r by the gyro's bias."""

    t: FloatArray
    force: FloatArray
    arm: FloatArray
    by_bias: FloatArray


def fit_lever_arm(
    t: npt.ArrayLike,
    specific_force: npt.ArrayLike,
    angular_velocity: npt.ArrayLike,
    *,
    pivot: npt.ArrayLike = (0.0, 0.0, 0.0),
    gravity: float = STANDARD_GRAVITY,
) -> LeverArm:
    """Return the sensor's place from calibrated readings (n, 3), m/s² and rad/s, in base axes, at stamps ``t`` (n,), s.

    ``pivot`` (m, base axes) is the point that stays at rest while the base rocks. Raises CalibrationError for a motion
    that leaves a component open, naming it: rocking about one axis says nothing about the place along it. UnitsError
    where the angular velocity explains the readings in another unit only.
    """
    stamps, force, rate, place = _arguments(t, specific_force, angular_velocity, pivot)
    g = as_gravity(gravity)
    try:
        found = _fit(stamps, force, rate, place, g)
    except CalibrationError:
        _check_unit(stamps, force, rate, g)
        raise
    if not found.good:
        _check_unit(stamps, force, rate, g)
    return found


def _check_unit(stamps: FloatArray, force: FloatArray, rate: FloatArray, gravity: float) -> None:
    """Name the unit in which the angular velocity would explain what it does not as it is."""
    for unit, factor in UNITS.items():
        try:
            is_good = _fit(stamps, force, factor * rate, np.zeros(3), gravity).good
        except CalibrationError:
            continue
        if is_good:
            raise UnitsError(f"the angular velocity looks like {unit}, in which it explains the readings: set its unit")


def _fit(stamps: FloatArray, force: FloatArray, rate: FloatArray, pivot: FloatArray, gravity: float) -> LeverArm:
    _check_turning(rate)
    length, spurious = _interval(stamps, rate)
    x, bias = np.zeros(6), np.zeros(3)
    for _ in range(ROUNDS):
        intervals = _intervals(stamps, force, rate - bias, length, x[3:])
        x, change, jacobian = _solve(intervals, x[3:], bias)
        bias = bias + change
    intervals = _intervals(stamps, force, rate - bias, length, x[3:])
    measured, predicted = intervals.force - x[:3], intervals.arm @ x[3:]
    spurious *= len(intervals.t)
    error = _check_determined(jacobian, _rms(measured - predicted), _rms(predicted), spurious)
    good, verdict = _judge(x, error, _rms(measured - predicted), gravity)
    return LeverArm(
        position=pivot + _lengthened(x[3:], jacobian, spurious),
        position_error=error,
        gyro_bias=bias,
        gravity=float(np.linalg.norm(x[:3])),
        condition=condition_of(jacobian[:, :3]),
        t=intervals.t,
        measured=measured,
        predicted=predicted,
        good=good,
        verdict=verdict,
    )


def _arguments(
    t: npt.ArrayLike, force: npt.ArrayLike, rate: npt.ArrayLike, pivot: npt.ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    stamps = as_double(t, "t")
    if stamps.ndim != 1 or not np.isfinite(stamps).all() or not (np.diff(stamps) > 0.0).all():
        raise ArgumentError("t must be finite stamps (n,) that increase")
    if stamps.size < FEWEST_SAMPLES or stamps[-1] - stamps[0] < SHORTEST_S:
        raise CalibrationError(f"{stamps.size} samples are too short for a lever arm; rock the base for ten seconds")
    _check_gaps(stamps)
    f, w = (as_rows(x, name, stamps.size) for x, name in ((force, "specific_force"), (rate, "angular_velocity")))
    return stamps, f, w, as_vector(pivot, "pivot", 3)


def _check_gaps(stamps: FloatArray) -> None:
    gaps = np.diff(stamps)
    longest = int(gaps.argmax())
    if gaps[longest] > LONGEST_GAP * np.median(gaps):
        raise CalibrationError(
            f"no samples for {gaps[longest]:.2g} s after {stamps[longest]:.1f} s: how the base turned meanwhile is not "
            "known; record without a pause, or cut the recording there"
        )


def _check_turning(w: FloatArray) -> None:
    turning = _rms(w - np.median(w, axis=0))
    if turning < LEAST_TURN:
        raise CalibrationError(
            f"the base turns by {turning:.2g} rad/s RMS only (at least {LEAST_TURN:g}): nothing tells where the sensor "
            "is; rock it by 10 degrees or more, about once a second, about two axes in turn"
        )


def _rms(rows: FloatArray) -> float:
    """Root of the mean squared length of the rows."""
    return float(np.sqrt((rows**2).sum(axis=1).mean()))


def _interval(t: FloatArray, rate: FloatArray) -> tuple[int, float]:
    """Samples per interval, and how much of it the gyroscope's noise adds to every diagonal element of Σ DᵀD.

    D is the matrix of r, [ω2 - ω1]× / Δt but for turns within an interval; with white noise σ of the rates, which is
    read from their third differences of variance 20 σ², that is 2 · 2σ² / Δt².
    """
    noise = float((np.diff(rate, n=3, axis=0) ** 2).mean()) / 20.0
    period = float(np.median(np.diff(t)))
    for seconds in INTERVALS_S:
        step = max(1, round(seconds / period))
        change = float(((rate[step:] - rate[:-step]) ** 2).mean())
        if 2.0 * noise <= NOISE_SHARE * change:
            break
    return step, 4.0 * noise / (step * period) ** 2


def _intervals(t: FloatArray, force: FloatArray, rate: FloatArray, step: int, arm: FloatArray) -> _Intervals:
    """Means over every ``step`` samples.

    A bias δ more turns C by -G δ, G = ∫ C dt, and takes δ off ω: C f_s changes by [C f_s]× G δ, and C (ω × r), whose
    differences are D r, by [C (ω × r)]× G δ + C [r]× δ.
    """
    turn = _attitudes(t, rate)
    turned, fixed = _integral(t, turn), np.einsum("nij,nj->ni", turn, force)
    ends = np.arange(0, t.size, step)
    span = np.diff(t[ends])
    moving = turn[ends] @ cross_matrices(rate[ends])
    change = cross_matrices(moving @ arm) @ turned[ends] + turn[ends] @ cross_matrices(arm[np.newaxis])
    by_bias = np.diff(_integral(t, cross_matrices(fixed) @ turned)[ends] - change, axis=0)
    return _Intervals(
        t=(t[ends[:-1]] + t[ends[1:]]) / 2.0,
        force=np.diff(_integral(t, fixed)[ends], axis=0) / span[:, np.newaxis],
        arm=np.diff(moving, axis=0) / span[:, np.newaxis, np.newaxis],
        by_bias=by_bias / span[:, np.newaxis, np.newaxis],
    )


def _attitudes(t: FloatArray, rate: FloatArray) -> FloatArray:
    """C (n, 3, 3), base axes at the start <- base axes: all products of the turns between samples, by doubling.

    A turn about an axis that itself turns is ∫ω + h²/12 ω1 × ω2 (W. Magnus, Comm. Pure Appl. Math. 7, 1954, to fourth
    order). Without the second term C of a base that rocks about two axes drifts, which looks like a longer arm.
    """
    coning = np.diff(t)[:, np.newaxis] ** 2 / 12.0 * np.cross(rate[:-1], rate[1:])
    turns = np.concatenate([np.eye(3)[np.newaxis], _exponentials(np.diff(_integral(t, rate), axis=0) + coning)])
    reach = 1
    while reach < len(turns):
        turns[reach:] = turns[:-reach] @ turns[reach:]
        reach *= 2
    return turns


def _exponentials(angles: FloatArray) -> FloatArray:
    """Rotation matrices (n, 3, 3) of rotation vectors (n, 3), rad, by Rodrigues."""
    size = np.linalg.norm(angles, axis=1)[:, np.newaxis, np.newaxis]
    k = cross_matrices(angles)
    return np.asarray(np.eye(3) + np.sinc(size / np.pi) * k + 0.5 * np.sinc(size / (2.0 * np.pi)) ** 2 * (k @ k))


def _integral(t: FloatArray, values: FloatArray) -> FloatArray:
    """Running integral from the start: of cubics through the values with the slopes there, h mean(y) - h²/12 Δy'."""
    steps = np.diff(t).reshape(-1, *[1] * (values.ndim - 1))
    slopes = np.gradient(values, t, axis=0)
    areas = steps * (values[1:] + values[:-1]) / 2.0 - steps**2 / 12.0 * np.diff(slopes, axis=0)
    return np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(areas, axis=0)])


def _solve(intervals: _Intervals, arm: FloatArray, bias: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """f0 and r, the change of the gyro's bias, and the columns of r with those of the others taken out.

    Small biases are likelier than large ones, which decides about the turn around the vertical where only noise could:
    it leaves no trace in gravity.
    """
    count = len(intervals.t)
    left = intervals.force - intervals.arm @ arm
    noise = max(_rms(left - left.mean(axis=0)), 1e-6)
    prior = np.eye(3) * noise / RATE_BIAS
    others = np.hstack([np.tile(np.eye(3), (count, 1)), -intervals.by_bias.reshape(-1, 3)])
    others = np.vstack([others, np.hstack([np.zeros((3, 3)), prior])])
    arms = np.vstack([intervals.arm.reshape(-1, 3), np.zeros((3, 3))])
    wanted = np.concatenate([intervals.force.ravel(), -prior @ bias])
    solution = np.linalg.lstsq(np.hstack([others, arms]), wanted)[0]
    basis = np.linalg.qr(others)[0]
    return np.concatenate([solution[:3], solution[6:]]), solution[3:6], arms - basis @ (basis.T @ arms)


def _lengthened(arm: FloatArray, jacobian: FloatArray, spurious: float) -> FloatArray:
    """Undo what noise in D does to a least-squares solution: (DᵀD - noise)⁻¹ DᵀD r, a little longer."""
    square = jacobian.T @ jacobian
    return np.asarray(np.linalg.solve(square - spurious * np.eye(3), square @ arm))


def _check_determined(jacobian: FloatArray, noise: float, moved: float, spurious: float) -> FloatArray:
    """Standard errors of r (3,), m; CalibrationError naming the component that the motion leaves open.

    The gyroscope's part of the noise is as large again with the other sign in the next interval, which is not counted:
    the errors are rather too large.
    """
    _, values, directions = np.linalg.svd(jacobian, full_matrices=False)
    errors = noise / np.sqrt(3.0) / np.maximum(values, 1e-300)
    is_moved = values[-1] ** 2 >= LEAST_SIGNAL * spurious and values[0] <= WORST_CONDITION * values[-1]
    if is_moved and errors[-1] <= LARGEST_ERROR:
        return np.asarray(np.sqrt(((errors[:, np.newaxis] * directions) ** 2).sum(axis=0)))
    if is_moved and noise > GOOD_RESIDUAL:
        raise CalibrationError(f"{UNEXPLAINED} (turning terms: {moved:.2g} m/s² RMS, unexplained: {noise:.2g})")
    known = "no more than noise"
    if is_moved:
        known = f"known to {errors[-1]:.2g} m, at most {LARGEST_ERROR:g}"
    raise CalibrationError(
        f"the motion leaves the place of the sensor {_along(directions[-1])} undetermined ({known}): rock about a "
        f"second axis too, across the first (turning terms: {moved:.2g} m/s² RMS, unexplained: {noise:.2g})"
    )


def _along(direction: FloatArray) -> str:
    axis = int(np.abs(direction).argmax())
    if abs(direction[axis]) > 0.95:
        return f"along {'xyz'[axis]}"
    return f"along ({', '.join(f'{value:.2f}' for value in direction)})"


def _judge(x: FloatArray, error: FloatArray, residual: float, gravity: float) -> tuple[bool, str]:
    length = float(np.linalg.norm(x[:3]))
    facts = f"place to {1000.0 * error.max():.1f} mm, residual {residual:.2g} m/s², gravity {length:.4g} m/s²"
    faults = []
    if abs(length / gravity - 1.0) > GRAVITY_TOLERANCE:
        faults.append(f"gravity should be {gravity:.4g}: calibrate bias and scale first")
    if residual > GOOD_RESIDUAL:
        faults.append(UNEXPLAINED)
    if faults:
        return False, f"Poor: {facts}; {'; '.join(faults)}"
    if x[2] < -0.5 * length:
        return (
            True,
            f"Good: {facts}; up is -z: unless the base hangs, the sensor gives gravity and all signs are wrong.",
        )
    return True, f"Good: {facts}."
