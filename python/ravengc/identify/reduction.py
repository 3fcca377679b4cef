"""Tall data in small triangles: all that least squares needs of a block of rows, one triangle per joint and fold.

For rows [X y] = Q R the sum of squares of X b - y is |R (b, -1)|². Fits without columns, with weights per joint, or
without a fold, and all their errors come from the triangles; the rows are gone through once.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ravengc.identify.ranks import triangle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.identify.model import Model
    from ravengc.identify.recording import FloatArray, Recording
    from ravengc.robot import Robot

__all__ = ["Reduction", "huber_shares", "joined", "reduce_rows", "reduced", "rows_of"]

BLOCK = 20_000
"""Samples whose regressor is held at a time."""
MARGIN = 500
HUBER = 1.345
"""Residuals beyond this many sigma count by their size, not its square: 95 % efficient under normal noise."""
MAD_TO_SIGMA = 1.4826


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """Triangles (n, p + 1, p + 1) of [X y] for every joint, and the number of ``samples`` behind them."""

    triangles: FloatArray
    samples: int

    @property
    def joints(self) -> int:
        """Number of joints, n."""
        return len(self.triangles)

    def squares(self, parameters: FloatArray) -> FloatArray:
        """Sum of squared errors of every joint, (n,)."""
        errors = self.triangles[:, :, :-1] @ parameters - self.triangles[:, :, -1]
        return np.asarray((errors**2).sum(axis=1))

    @property
    def energy(self) -> FloatArray:
        """Sum of squared torques of every joint, (n,)."""
        return np.asarray((self.triangles[:, :, -1] ** 2).sum(axis=1))

    def stacked(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rows X and y of one weighted least-squares problem, (n (p + 1), p) and (n (p + 1),)."""
        rows = (weights[:, np.newaxis, np.newaxis] * self.triangles).reshape(-1, self.triangles.shape[2])
        return rows[:, :-1], rows[:, -1]


def joined(parts: Sequence[Reduction]) -> Reduction:
    """The reduction of all rows together."""
    stacks = np.concatenate([part.triangles for part in parts], axis=1)
    return Reduction(np.array([triangle(stack) for stack in stacks]), sum(part.samples for part in parts))


def reduce_rows(
    robot: Robot, model: Model, recording: Recording, parts: int = 1, robust: FloatArray | None = None
) -> list[Reduction]:
    """The rows of a recording, reduced in this many parts of equal length, or more of them if it is long.

    Every part is computed with a margin at both ends, so that filters and hysteresis know what came before. With
    parameters in ``robust`` rows far from them count less, as Huber has it.
    """
    count = min(max(parts, -(-recording.samples // BLOCK)), recording.samples)
    edges = np.linspace(0, recording.samples, count + 1).astype(int).tolist()
    blocks = (_part(robot, model, recording, first, last) for first, last in pairwise(edges))
    return [
        reduced(rows if robust is None else huber_shares(rows, robust)[0][:, :, np.newaxis] * rows) for rows in blocks
    ]


def _part(robot: Robot, model: Model, recording: Recording, first: int, last: int) -> FloatArray:
    start = max(first - MARGIN, 0)
    return rows_of(robot, model, recording.take(slice(start, last + MARGIN)))[first - start : last - start]


def rows_of(robot: Robot, model: Model, recording: Recording) -> FloatArray:
    """[X y] of every sample and joint, (N, n, p + 1); y is the torque without what the model takes as known."""
    regressor = model.regressor(robot, recording).reshape(recording.samples, robot.n, -1)
    sought = recording.tau - model.known(robot, recording)
    return np.concatenate([regressor, sought[:, :, np.newaxis]], axis=2)


def reduced(rows: FloatArray) -> Reduction:
    """The reduction of rows [X y], (N, n, p + 1)."""
    return Reduction(np.array([triangle(rows[:, joint]) for joint in range(rows.shape[1])]), len(rows))


def huber_shares(rows: FloatArray, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Roots of the weights (N, n) of rows [X y] at these parameters, as Huber has them, and sigma (n,) of joints."""
    errors = np.abs(rows[:, :, :-1] @ parameters - rows[:, :, -1])
    middle = np.median(errors, axis=0)
    sigma = np.maximum(MAD_TO_SIGMA * middle, 1e-12 * max(float(middle.max()), 1e-300))
    return np.sqrt(np.minimum(1.0, HUBER * sigma / np.maximum(errors, 1e-300))), sigma
