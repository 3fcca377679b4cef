"""A periodic motion that shows a robot's dynamics: a few harmonics per joint, within limits, of a low condition number.

q(t) = q0 + Σ a_l/(l w) sin(l w t) - b_l/(l w) cos(l w t), l = 1..L (Swevers et al., Optimal Robot Excitation and
Identification, 1997), with Σ a_l = 0 and Σ l b_l = 0, so that it starts and ends at rest without a jerk. A search over
the coefficients lowers the condition number of the rows; whatever it tries is scaled into the limits first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_count, as_double, as_number, check_type
from ravengc.errors import ArgumentError
from ravengc.identify.base_parameters import BaseParameters, base_parameters
from ravengc.identify.model import Model
from ravengc.identify.plan_files import described, write_plan
from ravengc.identify.plan_prediction import NOISE, POSES, SEED, Prediction, per_joint, predicted
from ravengc.identify.plan_space import (
    LEVEL,
    SHORTEST_RISE,
    as_tilt,
    check_progress,
    directions,
    fastest,
    forces,
    joint_ranges,
    poses_within,
    usual_speeds,
)
from ravengc.identify.recording import FloatArray, Recording
from ravengc.messages import shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from os import PathLike

    import numpy.typing as npt

__all__ = ["TrajectoryPlan", "plan_trajectory"]

GRID = 20
"""Samples per period of the highest harmonic at which limits are looked at."""
MOST_SAMPLES = 100
PLAYED = 100.0
"""Hz at which a motion is written."""
FORMULA = "q(t) = centre + sum over l of sines[l]/(l w) sin(l w t) - cosines[l]/(l w) cos(l w t), w = 2 pi/period"
STEP, SHRINK, GROW = 0.5, 0.85, 1.5


@dataclass(frozen=True, slots=True, eq=False)
class TrajectoryPlan:
    """A Fourier motion, repeated on every base tilt of ``attitudes`` (k, 2), roll and pitch in rad.

    ``centre`` (n,), ``sines`` and ``cosines`` (n, L) are q0, a and b; ``period`` s. ``velocity`` and ``acceleration``
    (n,) are the limits that it keeps to beside ``ranges`` (n, 2). ``condition`` is that of the columns at one length,
    ``start_condition`` that of the median of the random motions that the search began with. ``predicted`` and ``level``
    are as in :class:`Plan`, for ``rate`` independent samples per second.
    """

    robot: str
    joints: tuple[str, ...]
    period: float
    centre: FloatArray
    sines: FloatArray
    cosines: FloatArray
    attitudes: FloatArray
    ranges: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    noise: FloatArray
    rate: float
    base: BaseParameters
    condition: float
    start_condition: float
    predicted: Prediction
    level: Prediction

    def at(self, t: npt.ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Positions, velocities and accelerations (N, n) at times (N,) s."""
        stamps = as_double(t, "t")
        if stamps.ndim != 1 or not np.isfinite(stamps).all():
            raise ArgumentError(f"t has shape {stamps.shape}; expected (N,), finite")
        return _Waves(self.period, self.sines.shape[1], stamps).motion(self.centre, self.sines, self.cosines)

    def recording(self, rate: float | None = None) -> Recording:
        """The motion on every attitude, one after the other, at ``rate`` Hz, as a recording without torques."""
        often = self.rate if rate is None else as_number(rate, "rate")
        if not 0.0 < often <= 1e5:
            raise ArgumentError(f"rate is {shown(rate)}; expected more than 0 Hz")
        stamps = np.arange(max(1, round(self.period * often))) / often
        return _on_attitudes(stamps, self.at(stamps), self.attitudes)

    def write(self, path: str | PathLike[str]) -> None:
        """Write a period at 100 Hz to a ``.csv``, or all of the plan to a ``.toml``, whole or not at all."""
        head = ("t", *(f"{part}.{name}" for part in ("q", "qd", "qdd") for name in self.joints))
        write_plan(path, head, self._rows, self.as_dict)

    def as_dict(self) -> dict[str, Any]:
        """The plan as plain data: SI units, angles in rad; ``inf`` where a torque stays open."""
        motion = {name: getattr(self, name).tolist() for name in ("centre", "sines", "cosines")}
        limits = {name: getattr(self, name).tolist() for name in ("ranges", "velocity", "acceleration")}
        more = {"start_condition": self.start_condition, "rate": self.rate, "attitudes": self.attitudes.tolist()}
        return (
            described(self) | more | {"motion": {"formula": FORMULA, "period": self.period, **motion}, "limits": limits}
        )

    def _rows(self) -> FloatArray:
        """A period, with its first sample once more at its end."""
        stamps = np.arange(round(self.period * PLAYED) + 1) / PLAYED
        return np.column_stack([stamps, *self.at(stamps)])


def plan_trajectory(
    robot: Robot,
    model: Model | None = None,
    *,
    period: float = 20.0,
    harmonics: int = 5,
    velocity: float | npt.ArrayLike | None = None,
    acceleration: float | npt.ArrayLike | None = None,
    tilt: float = 0.0,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    noise: float | npt.ArrayLike = NOISE,
    rate: float = 10.0,
    used_to: float | None = None,
    rounds: int = 600,
    seed: int = 0,
    on_progress: Callable[[int, int], object] | None = None,
) -> TrajectoryPlan:
    """Search a motion of a low condition number for ``model`` (default: dynamics with friction).

    ``velocity`` and ``acceleration``, one number or (n,), rad/s, m/s and their rates, narrow the limits of the robot;
    without any a joint gets 1 rad/s or 0.1 m/s, and half a second to reach its velocity. With a ``tilt`` (rad) the
    motion is repeated level and tilted about both axes. ``noise`` is that of one of ``rate`` independent samples per
    second. ``rounds`` is the length of the search. Other arguments as in :func:`plan`.
    """
    check_type(robot, Robot, "robot")
    wanted = Model(kind="dynamics") if model is None else model
    check_type(wanted, Model, "model")
    check_progress(on_progress)
    angle = as_tilt(tilt, "tilt")
    attitudes = np.vstack([LEVEL, directions(angle, 4)]) if angle > 0.0 else LEVEL
    limits = _Limits(robot, ranges, velocity, acceleration)
    length = _positive(period, "period")
    search = _Search(robot, wanted, limits, length, as_count(harmonics, "harmonics", 2, 20), attitudes)
    search.noise = per_joint(noise, robot.n, "noise")
    random = np.random.default_rng(as_count(seed, "seed", 0))
    found, start = search.run(random, as_count(rounds, "rounds", 0, 1_000_000), on_progress)
    reach = max(angle, np.radians(10.0)) if used_to is None else as_tilt(used_to, "used_to")
    often = _positive(rate, "rate")
    return search.plan(found, start, often, reach)


def _positive(value: object, name: str) -> float:
    number = as_number(value, name)
    if not 0.0 < number <= 1e5:
        raise ArgumentError(f"{name} is {shown(value)}; expected a positive number")
    return number


def _even(period: float, count: int) -> FloatArray:
    """As many even times of a period."""
    return np.asarray(period / count * np.arange(count), dtype=np.float64)


class _Waves:
    """sin(l w t) and cos(l w t) on a grid of times."""

    def __init__(self, period: float, harmonics: int, stamps: FloatArray) -> None:
        self.rates = 2.0 * np.pi / period * np.arange(1.0, harmonics + 1.0)
        angles = self.rates[:, np.newaxis] * stamps
        self.sin, self.cos = np.sin(angles), np.cos(angles)

    def motion(self, centre: FloatArray, a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """q, q' and q'' (N, n)."""
        q = centre + ((a / self.rates) @ self.sin - (b / self.rates) @ self.cos).T
        return q, (a @ self.cos + b @ self.sin).T, ((b * self.rates) @ self.cos - (a * self.rates) @ self.sin).T


class _Limits:
    """Ranges (n, 2), velocities and accelerations (n,)."""

    def __init__(self, robot: Robot, ranges: object, velocity: object, acceleration: object) -> None:
        self.ranges = joint_ranges(robot.spec, ranges)  # type: ignore[arg-type] # checked there
        usual, known = usual_speeds(robot.spec), fastest(robot.spec)
        self.velocity = usual if velocity is None else np.minimum(known, per_joint(velocity, robot.n, "velocity"))
        rise = self.velocity / SHORTEST_RISE
        self.acceleration = rise if acceleration is None else per_joint(acceleration, robot.n, "acceleration")


class _Search:
    """Random motions within the limits, the best of them, and small changes of it that are kept if they are better."""

    noise: FloatArray

    def __init__(
        self, robot: Robot, model: Model, limits: _Limits, period: float, harmonics: int, attitudes: FloatArray
    ) -> None:
        self.robot, self.model, self.limits, self.period, self.attitudes = robot, model, limits, period, attitudes
        self.harmonics = harmonics
        samples = GRID * harmonics
        self.fine = _Waves(period, harmonics, _even(period, samples))
        # of a sum of L harmonics, |p| <= max |p(t_k)| / cos(pi L/M) on M even samples (Ehlich and Zeller 1964)
        self.room = float(np.cos(np.pi * harmonics / samples))
        count = min(MOST_SAMPLES, samples)
        self.stamps = _even(period, count)
        self.coarse = _Waves(period, harmonics, self.stamps)
        self.base = base_parameters(robot, model, forces(attitudes))
        self.under = forces(attitudes[np.arange(count) % len(attitudes)])

    def run(
        self, random: np.random.Generator, rounds: int, on_progress: Callable[[int, int], object] | None
    ) -> tuple[FloatArray, float]:
        """Coefficients (n, 2 L + 1), and the median condition of the first tenth of the rounds, random ones."""
        first = max(3, rounds // 10)
        tries = [self._random(random) for _ in range(first)]
        conditions = [self.condition(one) for one in tries]
        place = int(np.argmin(conditions))
        best, lowest, step = tries[place], conditions[place], STEP
        for done in range(rounds):
            other = self._within(best + step * self._random(random))
            condition = self.condition(other)
            if condition < lowest:
                best, lowest, step = other, condition, min(step * GROW, 1.0)
            else:
                step = max(step * SHRINK**0.25, 0.01)
            if on_progress is not None:
                on_progress(done + 1, rounds)
        return best, float(np.median(conditions))

    def _random(self, random: np.random.Generator) -> FloatArray:
        shape = (self.robot.n, self.harmonics)
        a, b = random.normal(size=(2, *shape)) * self.limits.velocity[:, np.newaxis]
        span = self.limits.ranges[:, 1] - self.limits.ranges[:, 0]
        return self._within(np.column_stack([a, b, 0.25 * span * random.uniform(-1.0, 1.0, self.robot.n)]))

    def _within(self, coefficients: FloatArray) -> FloatArray:
        """The same motion, at rest at its ends, its joints each made smaller or larger until one limit is reached.

        The last column is the centre's distance from the middle of the range.
        """
        L, limits = self.harmonics, self.limits
        a, b, off = coefficients[:, :L], coefficients[:, L:-1], coefficients[:, -1]
        numbers = np.arange(1.0, L + 1.0)
        a = a - a.mean(axis=1, keepdims=True)
        b = b - np.outer(b @ numbers, numbers) / (numbers @ numbers)
        half = 0.5 * (limits.ranges[:, 1] - limits.ranges[:, 0])
        off = np.clip(off, -0.7 * half, 0.7 * half)
        swing = [np.abs(part).max(axis=0) / self.room for part in self.fine.motion(np.zeros(len(a)), a, b)]
        allowed = (half - np.abs(off), limits.velocity, limits.acceleration)
        with np.errstate(divide="ignore"):
            factor = np.min([room / size for room, size in zip(allowed, swing, strict=True)], axis=0)
        factor = np.where(np.isfinite(factor), factor, 0.0)[:, np.newaxis]
        return np.column_stack([factor * a, factor * b, off])

    def parts(self, coefficients: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Centre, a and b."""
        L = self.harmonics
        return self.limits.ranges.mean(axis=1) + coefficients[:, -1], coefficients[:, :L], coefficients[:, L:-1]

    def condition(self, coefficients: FloatArray) -> float:
        """Condition of the rows in units of the noise, columns of one length, attitudes in turn."""
        q, qd, qdd = self.coarse.motion(*self.parts(coefficients))
        recording = Recording(stamps=self.stamps, q=q, qd=qd, qdd=qdd, tau=np.zeros_like(q), specific_force=self.under)
        rows = self._rows(recording)[:, self.base.chosen]
        lengths = np.linalg.norm(rows, axis=0)
        if not lengths.all():
            return np.inf
        sizes = np.linalg.eigvalsh((rows / lengths).T @ (rows / lengths))
        return float(np.sqrt(sizes[-1] / sizes[0])) if sizes[0] > 0.0 else np.inf

    def _rows(self, recording: Recording) -> FloatArray:
        return self.model.regressor(self.robot, recording) / np.tile(self.noise, recording.samples)[:, np.newaxis]

    def plan(self, found: FloatArray, start: float, rate: float, reach: float) -> TrajectoryPlan:
        centre, a, b = self.parts(found)
        stamps = np.arange(max(1, round(self.period * rate))) / rate
        motion = _Waves(self.period, self.harmonics, stamps).motion(centre, a, b)
        spec = self.robot.spec
        return TrajectoryPlan(
            robot=spec.name,
            joints=spec.coordinate_names,
            period=self.period,
            centre=centre,
            sines=a,
            cosines=b,
            attitudes=self.attitudes,
            ranges=self.limits.ranges,
            velocity=self.limits.velocity,
            acceleration=self.limits.acceleration,
            noise=self.noise,
            rate=rate,
            base=self.base,
            condition=self.condition(found),
            start_condition=start,
            predicted=self._predicted(_on_attitudes(stamps, motion, self.attitudes), reach),
            level=self._predicted(_on_attitudes(stamps, motion, np.repeat(LEVEL, len(self.attitudes), axis=0)), reach),
        )

    def _predicted(self, recording: Recording, reach: float) -> Prediction:
        chosen = base_parameters(self.robot, self.model, "tilted").chosen
        wanted = poses_within(self.limits.ranges, POSES, np.random.default_rng(SEED))
        return predicted(self.robot, self.model, self._rows(recording)[:, chosen], chosen, wanted, reach)


def _on_attitudes(
    stamps: FloatArray, motion: tuple[FloatArray, FloatArray, FloatArray], attitudes: FloatArray
) -> Recording:
    """The motion on one attitude after the other."""
    count, step = len(attitudes), float(stamps[1] - stamps[0]) if len(stamps) > 1 else 1.0
    q, qd, qdd = (np.tile(part, (count, 1)) for part in motion)
    return Recording(
        stamps=step * np.arange(float(len(q))),
        q=q,
        qd=qd,
        qdd=qdd,
        tau=np.zeros_like(q),
        specific_force=np.repeat(forces(attitudes), len(stamps), axis=0),
        source="plan",
    )
