"""alpha: how stiff gravity can be, the largest spectral norm of dg/dq, found by search and bounded by proof."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ravengc import _core
from ravengc._convert import as_count, as_number, check_choice, check_type
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import listed
from ravengc.robot import Robot

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["StiffestGravity", "Tilt", "proven_alpha", "stiffest_gravity"]

Tilt = Literal["level", "any"]

ROUNDING = 1e-12
"""The proof is about real numbers; its evaluation may be off by this much, relative."""

SAMPLES, STEPS, ROUNDS = 2048, 17, 16
"""Poses drawn to start the search from, points on a line, and how often each line is searched."""

STRONGEST = 1e4
"""No base feels more, m/s^2."""


@dataclass(frozen=True, slots=True)
class StiffestGravity:
    """The largest ``|dg/dq|`` over all poses and gravities: at least ``found``, at most ``proven`` (N m/rad, N/m, N).

    ``q`` (n,) and ``gravity`` (3,) m/s^2 are where ``found`` is attained.
    """

    found: float
    proven: float
    q: Array
    gravity: Array


def stiffest_gravity(
    robot: Robot, *, tilt: Tilt = "any", field: float = _core.STANDARD_GRAVITY, searches: int = 32, seed: int = 0
) -> StiffestGravity:
    """Find and bound alpha, the largest spectral norm of dg/dq, for the robot as it is (base pose, payload).

    All angles count, joint limits or not; shifts stay within their limits. ``tilt`` says how the base may stand:
    "level" or "any". ``field`` is the largest gravity that it feels, m/s^2: |a - g| where it accelerates.

    ``proven`` is the spectral norm of bounds on every entry of dg/dq, from masses and lengths: never too small, exact
    for arms that move in one vertical plane, and up to about twice too large for others (more for parallelograms).
    ``found`` comes from so many searches: never too large, repeatable by its ``seed``, but no search proves that
    nothing larger was missed. Rely on ``proven``. Raises ConfigError if a shift that matters has no limits.
    """
    searches, seed = as_count(searches, "searches", 1, SAMPLES), as_count(seed, "seed", 0)
    proven = proven_alpha(robot, tilt=tilt, field=field)
    found, q, gravity = _search(robot, tilt, field, searches, seed)
    return StiffestGravity(found, max(proven, found), q, gravity)


def proven_alpha(robot: Robot, *, tilt: Tilt = "any", field: float = _core.STANDARD_GRAVITY) -> float:
    """Bound alpha from above: a matrix is no longer, as its spectral norm goes, than one of larger entries."""
    check_type(robot, Robot, "robot")
    check_choice(tilt, ("level", "any"), "tilt")
    if not 0.0 <= as_number(field, "field") <= STRONGEST:
        raise ArgumentError(f"field is {field}; expected the largest gravity that occurs, 0 to {STRONGEST:g} m/s^2")
    lower, upper = _limits(robot)
    along = np.array((0.0, 0.0, -1.0)) if tilt == "level" else None
    entries = _core.gravity_stiffness_bound(robot, lower, upper, along)
    if not np.isfinite(entries).all():
        endless = listed(_without_limits(robot))
        raise ConfigError(f"gravity's stiffness has no bound: {endless} can slide without limits; give lower and upper")
    return float(np.linalg.norm(entries, 2)) * field * (1.0 + ROUNDING)


def _limits(robot: Robot) -> tuple[Array, Array]:
    limits = robot.spec.coordinate_limits
    lower = np.array([-np.inf if limit.lower is None else limit.lower for limit in limits])
    upper = np.array([np.inf if limit.upper is None else limit.upper for limit in limits])
    return lower, upper


def _without_limits(robot: Robot) -> list[str]:
    """Names of the coordinates without limits that slide, or, where joints are coupled, may make one slide."""
    lower, upper = _limits(robot)
    suspect = np.isinf(lower) | np.isinf(upper)
    if robot.spec.coupling is None:
        suspect &= sliding(robot.spec)
    return [name for name, endless in zip(robot.joint_names, suspect, strict=True) if endless]


def _search(robot: Robot, tilt: Tilt, field: float, searches: int, seed: int) -> tuple[float, Array, Array]:
    """Climb from the best of many random poses, one coordinate at a time, then in the direction of gravity."""
    draw, slides = np.random.default_rng(seed), sliding(robot.spec)
    lower, upper = _limits(robot)
    low, high = np.where(slides, lower, -np.pi), np.where(slides, upper, np.pi)
    low, high = np.nan_to_num(low, neginf=-1.0), np.nan_to_num(high, posinf=1.0)  # such a shift has no effect
    q = draw.uniform(low, high, (SAMPLES, robot.n))
    down = draw.normal(size=(SAMPLES, 3)) if tilt == "any" else np.tile((0.0, 0.0, -1.0), (SAMPLES, 1))
    gravity = field * down / np.linalg.norm(down, axis=1, keepdims=True)
    size, along = _stiffest(robot, q, gravity)
    best = np.argsort(size)[-searches:]
    q, gravity, along, width = q[best], gravity[best], along[best], 0.5 * (high - low)
    for _ in range(ROUNDS):
        for k in range(robot.n):
            q = _along_coordinate(robot, q, gravity, along, k, width[k], (low[k], high[k]) if slides[k] else None)
        if tilt == "any":
            gravity = _turned(robot, q, gravity, along, field)
        size, along = _stiffest(robot, q, gravity)
        width = 0.5 * width
    winner = int(np.argmax(size))
    return float(size[winner]), q[winner], gravity[winner]


def _stiffest(robot: Robot, q: Array, gravity: Array) -> tuple[Array, Array]:
    """Return the largest |eigenvalue| of dg/dq for each sample, and its eigenvector."""
    values, vectors = np.linalg.eigh(robot.gravity_stiffness_batch(q, gravity))
    largest, samples = np.argmax(np.abs(values), axis=1), np.arange(len(q))
    return np.abs(values[samples, largest]), vectors[samples, :, largest]


def _along_coordinate(
    robot: Robot, q: Array, gravity: Array, along: Array, k: int, width: float, limits: tuple[float, float] | None
) -> Array:
    """Move coordinate k of every sample to where |v . dg/dq v| is largest, of some points around it."""
    tries = np.repeat(q[:, None, :], STEPS, axis=1)
    tries[:, :, k] += width * np.linspace(-1.0, 1.0, STEPS)
    if limits is not None:
        tries[:, :, k] = np.clip(tries[:, :, k], *limits)
    flat = tries.reshape(-1, robot.n)
    entries = robot.gravity_stiffness_batch(flat, np.repeat(gravity, STEPS, axis=0))
    v = np.repeat(along, STEPS, axis=0)
    size = np.abs(np.einsum("si,sij,sj->s", v, entries, v)).reshape(len(q), STEPS)
    chosen: Array = tries[np.arange(len(q)), np.argmax(size, axis=1)]
    return chosen


def _turned(robot: Robot, q: Array, gravity: Array, along: Array, field: float) -> Array:
    """Gravity in the direction in which v . dg/dq v is largest: it is linear in gravity."""
    slope = np.empty_like(gravity)
    for axis, unit in enumerate(np.eye(3)):
        slope[:, axis] = np.einsum("si,sij,sj->s", along, robot.gravity_stiffness_batch(q, unit), along)
    size = np.linalg.norm(slope, axis=1, keepdims=True)
    return np.where(size > 0.0, field * slope / np.where(size > 0.0, size, 1.0), gravity)
