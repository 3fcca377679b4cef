"""Tall data in small triangles: everything that least squares needs of a block of rows, one triangle per joint and fold.

For rows [X y] = Q R the sum of squares of X b - y is |R (b, -1)|². Fits without columns, with weights per joint, without
a fold, and all their errors come from the triangles; the rows are gone through once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc.identify.ranks import triangle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.identify.model import Model
    from ravengc.identify.recording import FloatArray, Recording
    from ravengc.robot import Robot

__all__ = ["Reduction", "reduce_rows"]

BLOCK = 2000
"""Samples whose regressor is held at a time."""


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


def reduce_rows(robot: Robot, model: Model, recording: Recording, weights: FloatArray | None = None) -> Reduction:
    """Reduce the rows of a recording, a block of samples at a time; ``weights`` (N, n) multiply the rows."""
    blocks = [slice(first, first + BLOCK) for first in range(0, recording.samples, BLOCK)]
    given = np.ones_like(recording.q) if weights is None else weights
    return joined([_reduced(robot, model, recording.take(block), given[block]) for block in blocks])


def _reduced(robot: Robot, model: Model, block: Recording, weights: FloatArray) -> Reduction:
    regressor = model.regressor(robot, block).reshape(block.samples, robot.n, -1)
    rows = np.concatenate([regressor, block.tau[:, :, np.newaxis]], axis=2) * weights[:, :, np.newaxis]
    return Reduction(np.array([triangle(rows[:, joint]) for joint in range(robot.n)]), block.samples)
