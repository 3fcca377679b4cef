"""Which poses on which base tilts to record, and how well the torques will be known, before anyone moves the robot.

>>> planned = identify.plan(robot, identify.Model(), poses=30, tilt=np.radians(10))
>>> planned.predicted.worst, planned.level.worst  # N·m per joint at the worst tilt: with tilts, and level only
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_count, as_double, check_type
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.identify.base_parameters import BaseParameters, base_parameters
from ravengc.identify.model import Model
from ravengc.identify.plan_choice import Choice, choose
from ravengc.identify.plan_files import described, write_plan
from ravengc.identify.plan_order import short_moves
from ravengc.identify.plan_prediction import NOISE, POSES, SEED, Prediction, Seen, per_joint, predicted
from ravengc.identify.plan_space import (
    LEVEL,
    as_tilt,
    bearable,
    check_progress,
    forces,
    joint_ranges,
    poses_within,
    standing,
    tilt_candidates,
)
from ravengc.identify.ranks import triangle
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from os import PathLike

    import numpy.typing as npt

    from ravengc.identify.recording import FloatArray, Recording

__all__ = ["Plan", "plan"]


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Static poses in the order in which to take them, and what they will be worth.

    ``q`` (N, n) rad or m on base tilts ``tilts`` (N, 2), roll and pitch in rad of a base turned by Ry(p) Rx(r) from
    level; poses on one tilt follow each other. ``base`` are the parameters that these show, ``base.unidentifiable``
    what stays open, ``condition`` that of their columns at one length. ``history`` is log det of the information after
    the greedy choice and after every exchange. ``predicted`` is the uncertainty of the holding torques at base tilts,
    ``level`` the same for as many poses on the level base alone. ``noise`` (n,) N·m or N is that of one pose's torque.
    """

    robot: str
    joints: tuple[str, ...]
    q: FloatArray
    tilts: FloatArray
    ranges: FloatArray
    noise: FloatArray
    base: BaseParameters
    condition: float
    history: tuple[float, ...]
    predicted: Prediction
    level: Prediction

    @property
    def attitudes(self) -> FloatArray:
        """The base's roll and pitch (k, 2) in the order in which it takes them, rad."""
        changes = np.flatnonzero(np.abs(np.diff(self.tilts, axis=0)).max(axis=1) > 0.0) + 1
        return np.asarray(self.tilts[np.concatenate([[0], changes])])

    def recording(self) -> Recording:
        """The plan as a recording whose torques are zero: to simulate them, or to predict from."""
        return standing(self.q, self.tilts)

    def write(self, path: str | PathLike[str]) -> None:
        """Write the poses to a ``.csv``, or all of the plan to a ``.toml``, whole or not at all."""
        head = ("pose", "roll", "pitch", "gx", "gy", "gz", *(f"q.{name}" for name in self.joints))
        write_plan(path, head, self._rows, self.as_dict)

    def as_dict(self) -> dict[str, Any]:
        """The plan as plain data: SI units, angles in rad; ``inf`` where a torque stays open."""
        rows = zip(self.tilts.tolist(), self.q.tolist(), strict=True)
        return described(self) | {"pose": [{"roll": roll, "pitch": pitch, "q": q} for (roll, pitch), q in rows]}

    def _rows(self) -> FloatArray:
        numbers = np.arange(1.0, len(self.q) + 1.0)
        return np.column_stack([numbers, self.tilts, -forces(self.tilts), self.q])


def plan(
    robot: Robot,
    model: Model | None = None,
    *,
    poses: int = 30,
    tilt: float = np.radians(10.0),
    attitudes: int = 5,
    tilts: npt.ArrayLike | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    candidates: int | npt.ArrayLike = 200,
    noise: float | npt.ArrayLike = NOISE,
    used_to: float | None = None,
    seed: int = 0,
    on_progress: Callable[[int, int], object] | None = None,
) -> Plan:
    """Choose ``poses`` static poses on at most ``attitudes`` base tilts: D-optimal, with exchanges.

    The base can stand level, tilted by ``tilt`` rad to eight sides, or by ``tilts`` (k, 2), roll and pitch in rad; a
    tilt of 0 keeps it level. Poses are chosen from random ``candidates``, or from these (c, n), within the joints'
    limits and ``ranges`` (rad or m by joint name) and, by the masses that the robot has, within its efforts; whether
    they are free of collisions is not known here. ``noise`` is the standard deviation of the torque of one pose, N·m or
    N, one number or (n,). The uncertainty is predicted for base tilts up to ``used_to`` rad (default: ``tilt``, at
    least 10 degrees). ``on_progress(done, total)`` is called on the way.
    """
    check_type(robot, Robot, "robot")
    asked = _Asked(robot, Model() if model is None else model, noise, ranges, seed)
    check_progress(on_progress)
    count, sides = as_count(poses, "poses", 1, 10_000), as_count(attitudes, "attitudes", 1, 1000)
    angle = as_tilt(tilt, "tilt")
    reach = max(angle, np.radians(10.0)) if used_to is None else as_tilt(used_to, "used_to")
    offered = tilt_candidates(tilts, angle)
    at = asked.poses(candidates, offered)
    taken = asked.attitudes(at, offered, sides, count)
    tilted, level = asked.choose(at, taken, count, on_progress), asked.choose(at, LEVEL, count, None)
    q, tilted_by, choice = asked.ordered(at, taken, tilted)
    base, rows = asked.shown(q, tilted_by)
    return Plan(
        robot=robot.spec.name,
        joints=robot.spec.coordinate_names,
        q=q,
        tilts=tilted_by,
        ranges=asked.ranges,
        noise=asked.noise,
        base=base,
        condition=Seen(rows, np.zeros(rows.shape[1])).condition,
        history=choice.history,
        predicted=asked.predicted(q, tilted_by, reach),
        level=asked.predicted(*asked.ordered(at, LEVEL, level)[:2], reach),
    )


class _Asked:
    """The robot, its model and the steps of a plan for them."""

    def __init__(self, robot: Robot, model: Model, noise: object, ranges: object, seed: int) -> None:
        check_type(model, Model, "model")
        self.robot, self.model, self.noise = robot, model, per_joint(noise, robot.n, "noise")
        self.ranges = joint_ranges(robot.spec, ranges)  # type: ignore[arg-type] # checked there
        self.random = np.random.default_rng(as_count(seed, "seed", 0))
        # at rest, on any tilt: friction and inertia show nothing and are not planned for
        self.chosen = base_parameters(robot, model, "tilted", at_rest=True).chosen
        if not self.chosen.size:
            raise ArgumentError(f"the model has no parameter that poses of {robot.name} at rest could show")
        self.scale = np.ones(self.chosen.size)

    def poses(self, candidates: object, attitudes: FloatArray) -> FloatArray:
        """The poses to choose from, (c, n)."""
        if isinstance(candidates, int):
            at = poses_within(self.ranges, as_count(candidates, "candidates", 1, 100_000), self.random)
        else:
            at = as_double(candidates, "candidates")
            if at.ndim != 2 or at.shape[1] != self.robot.n or not np.isfinite(at).all():
                raise ArgumentError(f"candidates has shape {at.shape}; expected (c, {self.robot.n}), finite")
            at = np.asarray(at[((at >= self.ranges[:, 0]) & (at <= self.ranges[:, 1])).all(axis=1)])
        held = bearable(self.robot, at, attitudes) if len(at) else at
        if not len(held):
            raise CalibrationError(
                f"no pose of {self.robot.name} is left to choose from: none lies within the ranges and can be held by "
                "the drives on every tilt; widen the ranges, or tilt less"
            )
        return held

    def attitudes(self, at: FloatArray, offered: FloatArray, sides: int, count: int) -> FloatArray:
        """The attitudes that show most on the average of all poses, in turn around the vertical."""
        blocks = self._blocks(at, offered)
        self.scale = np.sqrt((blocks**2).mean(axis=(0, 1, 2)))
        self.scale[self.scale == 0.0] = 1.0
        share = np.sqrt(count / (sides * len(at)))
        triangles = np.array([share * triangle(block.reshape(-1, len(self.chosen)) / self.scale) for block in blocks])
        chosen = sorted(choose(triangles, min(sides, count, len(offered))).chosen)
        return np.asarray(offered[chosen])

    def choose(
        self, at: FloatArray, attitudes: FloatArray, count: int, on_step: Callable[[int, int], object] | None
    ) -> Choice:
        """Pairs of an attitude and a pose: place a (c,) + pose."""
        if count > len(at) * len(attitudes):
            most = len(at) * len(attitudes)
            raise ArgumentError(f"poses is {count}; there are {most} candidates: {len(at)} on {len(attitudes)} tilts")
        blocks = self._blocks(at, attitudes) / self.scale
        return choose(blocks.reshape(-1, *blocks.shape[2:]), count, on_step)

    def _blocks(self, at: FloatArray, attitudes: FloatArray) -> FloatArray:
        """Rows of every candidate in units of the noise, (k, c, n, b)."""
        every = standing(np.tile(at, (len(attitudes), 1)), np.repeat(attitudes, len(at), axis=0))
        rows = self.model.regressor(self.robot, every)[:, self.chosen].reshape(-1, self.robot.n, len(self.chosen))
        rows = rows / self.noise[:, np.newaxis]
        return np.asarray(rows.reshape(len(attitudes), len(at), *rows.shape[1:]))

    def ordered(self, at: FloatArray, attitudes: FloatArray, choice: Choice) -> tuple[FloatArray, FloatArray, Choice]:
        """Poses and tilts in their order: tilt by tilt, short moves from pose to pose."""
        sides, places = np.divmod(np.array(choice.chosen), len(at))
        q, tilts = [], []
        last = self.ranges.mean(axis=1)
        for side in np.unique(sides):
            here = at[places[sides == side]]
            here = here[short_moves(here, self.ranges, last)]
            last = here[-1]
            q.append(here)
            tilts.append(np.repeat(attitudes[side : side + 1], len(here), axis=0))
        return np.concatenate(q), np.concatenate(tilts), choice

    def shown(self, q: FloatArray, tilts: FloatArray) -> tuple[BaseParameters, FloatArray]:
        """Base parameters of the plan's attitudes, and the plan's rows for them."""
        base = base_parameters(self.robot, self.model, np.unique(forces(tilts), axis=0), at_rest=True)
        rows = self.model.regressor(self.robot, standing(q, tilts))[:, base.chosen]
        return base, rows / np.tile(self.noise, len(q))[:, np.newaxis]

    def predicted(self, q: FloatArray, tilts: FloatArray, reach: float) -> Prediction:
        rows = self.model.regressor(self.robot, standing(q, tilts))[:, self.chosen]
        rows = rows / np.tile(self.noise, len(q))[:, np.newaxis]
        wanted = poses_within(self.ranges, POSES, np.random.default_rng(SEED))
        return predicted(self.robot, self.model, rows, self.chosen, wanted, reach)
