"""What recordings hardly tell apart although they show it, and what to record instead.

The condition of the columns, each of unit length, is how much larger the error of some sum of parameters is than that
of the best one. Where it is high, the weakest direction names the parameters; what would help is tried: as many samples
more over the joints' whole ranges, on a base that is tilted about both axes, or both. Where nothing helps the condition
is that of the mechanism, and no fault of the recordings.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ravengc.coordinates import sliding
from ravengc.identify.base_parameters import random_triangle
from ravengc.identify.plan_space import SHORTEST_RISE, directions, forces, joint_ranges, poses_within, usual_speeds
from ravengc.identify.ranks import independent_columns, triangle
from ravengc.identify.recording import FloatArray, Recording
from ravengc.messages import listed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.identify.base_parameters import BaseParameters
    from ravengc.identify.estimators import Estimate
    from ravengc.identify.model import Model
    from ravengc.identify.reduction import Reduction
    from ravengc.robot import Robot

__all__ = ["ONE_AXIS", "WEAK_CONDITION", "about_one_axis", "weakness"]

WEAK_CONDITION = 50.0
"""Beyond it a fit is good for torques like those it saw, and poor for others."""
ONE_AXIS = 0.2
"""Ratio of the second to the first spread of tilts below which they count as about one axis."""
LARGE = 0.3
"""Share of the largest part of the weakest direction from which on a parameter is named."""
MOST_NAMES, MOST_SAMPLES = 4, 200
TILT = np.radians(10.0)
SHORT = 0.5
"""Share of its range that a joint has to move through, or its name is said."""
HELPS = 0.5
"""Share of the condition down to which a remedy has to bring it."""


def about_one_axis(forces_seen: FloatArray) -> bool:
    """Whether specific forces (k, 3) turn about one axis of the base only, if at all."""
    spread = np.linalg.svd(forces_seen - forces_seen.mean(axis=0), compute_uv=False)
    return bool(spread[1] < ONE_AXIS * spread[0])


def weakness(
    robot: Robot,
    model: Model,
    base: BaseParameters,
    recordings: Sequence[Recording],
    rows: Reduction,
    estimate: Estimate,
) -> tuple[str, ...]:
    """What the rows of these recordings hardly tell apart, with what to record instead; nothing if they do."""
    if estimate.condition <= WEAK_CONDITION:
        return ()
    X = triangle(rows.stacked(estimate.weights)[0])
    weakest = np.abs(np.linalg.svd(_unit(X[:, base.chosen]))[2][-1])
    order = np.argsort(-weakest)[:MOST_NAMES]
    alike = [base.columns[base.chosen[place]] for place in order if weakest[place] >= LARGE * weakest[order[0]]]
    remedy = _remedy(robot, model, recordings, X, replace(estimate, weights=estimate.weights * (rows.samples > 0)))
    if remedy is None and set(alike) <= set(model.link_columns(robot.spec)):
        return ()
    said = f"the condition is {estimate.condition:.3g}, more than {WEAK_CONDITION:g}: hardly told apart are"
    other = "leave some of them out: neither other poses nor tilts of the base tell them apart"
    return (f"{said} {', '.join(alike)}; {remedy or other}",)


def _unit(R: FloatArray) -> FloatArray:
    """Columns of unit length."""
    lengths = np.linalg.norm(R, axis=0)
    return np.asarray(R / np.where(lengths > 0.0, lengths, 1.0))


def _remedy(
    robot: Robot, model: Model, recordings: Sequence[Recording], X: FloatArray, estimate: Estimate
) -> str | None:
    """The first of what could be recorded beside that mends the condition, or the best if it helps by half.

    ``X`` is the triangle of all columns of the recorded rows; joints without rows have no weight. Tilts show more
    parameters: the condition is that of all.
    """
    seen = _some(recordings)
    farther = _over_ranges(robot, seen)
    moving, tilting = _moving(robot, model, recordings), _tilting(recordings)
    tries = {moving: farther, tilting: _on_tilts(seen), f"{moving}, and {tilting}": _on_tilts(farther)}
    weights = np.sqrt(sum(one.samples for one in recordings) / seen.samples) * np.tile(estimate.weights, seen.samples)
    after, counts = {}, estimate.weights > 0.0
    for words, more in tries.items():
        shown = random_triangle(robot, model, np.unique(np.vstack([seen.base, more.base]), axis=0), counts=counts)
        chosen = independent_columns(shown, model.order(robot.spec)).chosen
        both = np.vstack([X, weights[:, np.newaxis] * model.regressor(robot, more)])
        after[words] = _condition(both[:, chosen])
    enough = [words for words, condition in after.items() if condition <= WEAK_CONDITION]
    best = enough[0] if enough else min(after, key=lambda words: after[words])
    return f"{best} (condition then about {after[best]:.2g})" if after[best] <= HELPS * estimate.condition else None


def _condition(R: FloatArray) -> float:
    sizes = np.linalg.svd(_unit(triangle(R)), compute_uv=False)
    return float(sizes[0] / sizes[-1]) if sizes[-1] > 0.0 else np.inf


def _some(recordings: Sequence[Recording]) -> Recording:
    """Samples of all recordings, spread evenly, as one."""
    step = -(-sum(one.samples for one in recordings) // MOST_SAMPLES)
    parts = [one.take(slice(None, None, step)) for one in recordings]
    q, qd, qdd, base = (
        np.vstack([getattr(part, name) for part in parts]) for name in ("q", "velocity", "acceleration", "base")
    )
    return Recording(
        stamps=np.arange(float(len(q))),
        q=q,
        qd=qd,
        qdd=qdd,
        tau=np.zeros_like(q),
        specific_force=base[:, :3],
        angular_velocity=base[:, 3:6],
        angular_acceleration=base[:, 6:],
    )


def _over_ranges(robot: Robot, seen: Recording) -> Recording:
    """As many samples with every joint anywhere within its limits, as fast as they allow, or as it was."""
    random = np.random.default_rng(0)
    speed = np.maximum(usual_speeds(robot.spec), np.abs(seen.velocity).max(axis=0))
    rise = np.maximum(speed / SHORTEST_RISE, np.abs(seen.acceleration).max(axis=0))
    q = poses_within(_ranges(robot), seen.samples, random)
    qd, qdd = (most * random.uniform(-1.0, 1.0, q.shape) for most in (speed, rise))
    return replace(seen, q=q, qd=qd, qdd=qdd)


def _ranges(robot: Robot) -> FloatArray:
    """Least and most of every coordinate, (n, 2): a metre for a slide of which one is not known."""
    rows = zip(robot.spec.coordinate_names, sliding(robot.spec), robot.spec.coordinate_limits, strict=True)
    unknown = {name: limit for name, slides, limit in rows if slides and None in {limit.lower, limit.upper}}
    return joint_ranges(robot.spec, {name: _a_metre(limit.lower, limit.upper) for name, limit in unknown.items()})


def _a_metre(lower: float | None, upper: float | None) -> tuple[float, float]:
    """A metre from the limit that is known, or about zero."""
    least = lower if lower is not None else -0.5 if upper is None else upper - 1.0
    return least, least + 1.0


def _on_tilts(seen: Recording) -> Recording:
    """The same samples on a base that stands still, tilted to four sides in turn."""
    sides = directions(TILT, 4)[np.arange(seen.samples) % 4]
    return replace(seen, specific_force=forces(sides), angular_velocity=None, angular_acceleration=None)


def _moving(robot: Robot, model: Model, recordings: Sequence[Recording]) -> str:
    """Poses or a motion over whole ranges, with the joints that went through less than half of theirs."""
    least, most = (np.array([f(one.q, axis=0) for one in recordings]) for f in (np.min, np.max))
    ranges = _ranges(robot)
    share = (most.max(axis=0) - least.min(axis=0)) / np.maximum(ranges[:, 1] - ranges[:, 0], 1e-12)
    short = [name for name, part in zip(robot.spec.coordinate_names, share, strict=True) if part < SHORT]
    what = "poses" if model.kind == "gravity" else "a faster motion"
    return f"record {what} over the whole range of {listed(short) if 0 < len(short) < robot.n else 'every joint'}"


def _tilting(recordings: Sequence[Recording]) -> str:
    """To tilt the base, or to tilt it about another axis."""
    seen = np.concatenate([one.base[:, :3] for one in recordings])
    still = bool(np.ptp(seen, axis=0).max() < 1e-6 * np.abs(seen).max())
    if still or not about_one_axis(seen):
        return "tilt the base by 10 degrees or more to four sides"
    return "tilt the base about a second axis too: it was tilted about one only"
