"""Base parameters: which sums of parameters joint torques show at all, and what would show the others.

Structural: from the robot and how its base stands or moves, at random states, not from what a recording happens to
excite (Gautier, Numerical calculation of the base inertial parameters of robots, 1991).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_double, check_choice, check_type
from ravengc._core import STANDARD_GRAVITY
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError
from ravengc.identify.model import Model
from ravengc.identify.ranks import Independent, independent_columns, triangle, words
from ravengc.identify.recording import BoolArray, FloatArray, Recording
from ravengc.messages import listed, shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["Attitudes", "BaseParameters", "base_parameters"]

Attitudes = Literal["level", "tilted", "rocking"]
ATTITUDES = ("level", "tilted", "rocking")
SEED = 1991
TILT = np.radians(10.0)
REMEDIES = {
    "moving": "record a motion in which every joint moves and speeds up",
    "rocking": "rock the base with its angular velocity recorded",
}


@dataclass(frozen=True, slots=True, eq=False)
class BaseParameters:
    """The sums of parameters on which the joint torques depend: Y p = Y[:, chosen] (K p).

    ``names`` (rank,) are the sums in words, ``columns`` (p,) the parameters, ``chosen`` the columns that stand for the
    sums, ``K`` (rank, p) the sums. ``unidentifiable`` says in sentences what joint torques do not show, and what base
    motion would.
    """

    rank: int
    names: tuple[str, ...]
    columns: tuple[str, ...]
    chosen: npt.NDArray[np.intp]
    K: FloatArray
    unidentifiable: tuple[str, ...]


def base_parameters(
    robot: Robot,
    model: Model,
    attitudes: Attitudes | Recording | npt.ArrayLike = "level",
    *,
    at_rest: bool = False,
    counted: npt.ArrayLike | None = None,
) -> BaseParameters:
    """Find the base parameters of a model for the attitudes that the base takes.

    ``attitudes`` is ``"level"``, ``"tilted"`` (any static tilt), ``"rocking"`` (any motion of the base), a Recording
    for those that it visited, or specific forces (k, 3) in base axes, m/s² (k, 9 with the base's angular velocity and
    acceleration). ``at_rest`` says that the joints stand still in every sample. ``counted`` (n,) marks the joints whose
    torques count; those of which a Recording has any, or all, unless given.
    """
    check_type(robot, Robot, "robot")
    check_type(model, Model, "model")
    check_type(at_rest, bool, "at_rest")
    motions, counts = _motions(attitudes), _counts(robot, attitudes, counted)
    names = model.columns(robot.spec)
    seen = random_triangle(robot, model, motions, at_rest=at_rest, counts=counts)
    independent = independent_columns(seen, model.order(robot.spec))
    return BaseParameters(
        rank=len(independent.chosen),
        names=words(independent, names),
        columns=names,
        chosen=independent.chosen,
        K=independent.K,
        unidentifiable=tuple(_unidentifiable(robot, model, motions, counts, seen, independent)),
    )


def _counts(robot: Robot, attitudes: object, counted: npt.ArrayLike | None) -> BoolArray:
    if counted is not None:
        marks = np.asarray(counted)
        if marks.dtype != np.bool_ or marks.shape != (robot.n,):
            raise ArgumentError(f"counted is {shown(counted)}; expected True or False for each of {robot.n} joints")
        return marks
    if isinstance(attitudes, Recording):
        return np.asarray(attitudes.counts.any(axis=0))
    return np.ones(robot.n, dtype=bool)


def random_triangle(
    robot: Robot, model: Model, motions: FloatArray, *, at_rest: bool = False, counts: BoolArray | None = None
) -> FloatArray:
    """R of the model's regressor at random joint states, under base motions drawn from these (k, 9).

    Of the joints marked in ``counts`` (n,), or of all.
    """
    marks = np.ones(robot.n, dtype=bool) if counts is None else counts
    states = random_states(robot, motions, 40 + 6 * len(model.columns(robot.spec)) // max(1, int(marks.sum())))
    rows = model.regressor(robot, replace(states, qd=None, qdd=None) if at_rest else states)
    return triangle(rows[np.tile(marks, states.samples)])


def random_states(robot: Robot, motions: FloatArray, samples: int) -> Recording:
    """Random positions, velocities and accelerations, within no limits: rank is a property of the mechanism."""
    random = np.random.default_rng(SEED)
    reach = np.where(sliding(robot.spec), 0.5, np.pi)
    q, qd, qdd = (random.uniform(-1.0, 1.0, (samples, robot.n)) for _ in range(3))
    base = motions[random.permutation(np.arange(samples) % len(motions))]
    return Recording(
        stamps=np.arange(float(samples)),
        q=reach * q,
        qd=reach * qd,
        qdd=3.0 * reach * qdd,
        tau=np.zeros_like(q),
        specific_force=base[:, :3],
        angular_velocity=base[:, 3:6],
        angular_acceleration=base[:, 6:],
    )


def _motions(attitudes: object) -> FloatArray:
    if isinstance(attitudes, Recording):
        return np.unique(attitudes.base, axis=0)
    if isinstance(attitudes, str):
        check_choice(attitudes, ATTITUDES, "attitudes", ArgumentError)
        return _assumed(attitudes)
    forces = as_double(attitudes, "attitudes")
    if forces.ndim != 2 or forces.shape[1] not in {3, 9} or not len(forces) or not np.isfinite(forces).all():
        raise ArgumentError(f"attitudes has shape {forces.shape}; expected specific forces (k, 3), finite, or a word")
    return np.hstack([forces, np.zeros((len(forces), 9 - forces.shape[1]))])


def _assumed(attitudes: str) -> FloatArray:
    """Base motions (k, 9) that stand for a word."""
    random = np.random.default_rng(SEED + 1)
    motions = np.zeros((1 if attitudes == "level" else 64, 9))
    motions[:, 2] = STANDARD_GRAVITY
    if attitudes != "level":
        directions = random.normal(size=(len(motions), 3))
        motions[:, :3] = STANDARD_GRAVITY * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    if attitudes == "rocking":
        motions[:, 3:] = random.normal(size=(len(motions), 6))
    return motions


def _tilts(robot: Robot, model: Model, motions: FloatArray, counts: BoolArray, rank: int) -> str:
    """About which axes the base must be tilted from where it stands, so that the torques show this many parameters."""
    tilted = {axis: np.vstack([motions, _turned(motions, place)]) for place, axis in enumerate("xyz")}
    enough = [axis for axis, visited in tilted.items() if _rank(robot, model, visited, counts) == rank]
    if enough:
        return f"tilt the base, once by 10 degrees or more about its {' or '.join(enough)} axis"
    return "tilt the base by 10 degrees or more, about two of its axes in turn"


def _turned(motions: FloatArray, axis: int) -> FloatArray:
    """The mean specific force of base motions (k, 9), seen from a base at rest that is turned about one of its axes."""
    x, y, z = np.roll(motions[:, :3].mean(axis=0), -axis)
    turned = [x, np.cos(TILT) * y + np.sin(TILT) * z, np.cos(TILT) * z - np.sin(TILT) * y]
    return np.concatenate([np.roll(turned, axis), np.zeros(6)])[np.newaxis]


def _rank(robot: Robot, model: Model, motions: FloatArray, counts: BoolArray) -> int:
    seen = random_triangle(robot, model, motions, counts=counts)
    return len(independent_columns(seen, model.order(robot.spec)).chosen)


def _unidentifiable(
    robot: Robot, model: Model, motions: FloatArray, counts: BoolArray, seen: FloatArray, known: Independent
) -> Iterator[str]:
    """What the torques do not show: what moving the joints, tilting and rocking the base would, and what none does.

    Torques that do not count come last: what only these would show.
    """
    names = model.columns(robot.spec)
    stages = {"moving": (motions, counts), "tilted": (_assumed("tilted"), counts)}
    if model.kind == "dynamics":
        stages["rocking"] = (_assumed("rocking"), counts)
    if not counts.all():
        stages["torques"] = (stages[next(reversed(stages))][0], np.ones_like(counts))
    for stage, (under, shown_by) in stages.items():
        seen = triangle(np.vstack([seen, random_triangle(robot, model, under, counts=shown_by)]))
        before = set(known.chosen.tolist())
        known = independent_columns(seen, (*known.chosen.tolist(), *model.order(robot.spec)))
        gained = [word for word, column in zip(words(known, names), known.chosen, strict=True) if column not in before]
        if gained:
            yield f"{'; '.join(gained)}: {_remedy(stage, robot, model, motions, counts, len(known.chosen))}"
    hidden = [name for name, column in zip(names, seen.T, strict=True) if not np.any(np.abs(column) > 1e-9)]
    if hidden:
        yield f"{', '.join(hidden)}: no joint torque depends on them; a force sensor under the base shows some"


def _remedy(stage: str, robot: Robot, model: Model, motions: FloatArray, counts: BoolArray, rank: int) -> str:
    """What to do that shows what a stage does."""
    if stage == "tilted":
        return _tilts(robot, model, motions, counts, rank)
    if stage == "torques":
        silent = [name for name, counts_ in zip(robot.spec.coordinate_names, counts, strict=True) if not counts_]
        return f"measure the torque of {listed(silent)} too"
    return REMEDIES[stage]
