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

    import numpy.typing as npt

    from ravengc.identify.model import Model
    from ravengc.identify.recording import FloatArray, Recording
    from ravengc.robot import Robot

    IntArray = npt.NDArray[np.int64]

__all__ = ["Reduction", "huber_rows", "joined", "reduce_rows", "reduced", "rows_of"]

BLOCK = 20_000
"""Samples whose regressor is held at a time."""
MARGIN = 500
HUBER = 1.345
"""Residuals beyond this many sigma count by their size, not its square: 95 % efficient under normal noise."""
MAD_TO_SIGMA = 1.4826


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """Triangles (n, p + 1, p + 1) of [X y] for every joint, and the numbers ``samples`` (n,) of rows behind them."""

    triangles: FloatArray
    samples: IntArray

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
    samples = np.array([part.samples for part in parts]).sum(axis=0)
    return Reduction(np.array([triangle(stack) for stack in stacks]), samples)


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
    return [reduced(rows if robust is None else huber_rows(rows, robust)[0]) for rows in blocks]


def _part(robot: Robot, model: Model, recording: Recording, first: int, last: int) -> list[FloatArray]:
    start = max(first - MARGIN, 0)
    return rows_of(robot, model, recording.take(slice(start, last + MARGIN)), slice(first - start, last - start))


def rows_of(robot: Robot, model: Model, recording: Recording, samples: slice = slice(None)) -> list[FloatArray]:
    """[X y] of every joint, (N_j, p + 1), from those of the samples whose torque counts.

    y is the torque without what the model takes as known.
    """
    regressor = model.regressor(robot, recording).reshape(recording.samples, robot.n, -1)[samples]
    sought = (recording.tau - model.known(robot, recording))[samples]
    rows = np.concatenate([regressor, sought[:, :, np.newaxis]], axis=2)
    return [rows[counts, joint] for joint, counts in enumerate(recording.counts[samples].T)]


def reduced(rows: Sequence[FloatArray]) -> Reduction:
    """The reduction of rows [X y] of every joint, (N_j, p + 1)."""
    return Reduction(np.array([triangle(one) for one in rows]), np.array([len(one) for one in rows]))


def huber_rows(rows: Sequence[FloatArray], parameters: FloatArray) -> tuple[list[FloatArray], FloatArray]:
    """Rows [X y] of every joint in roots of their weights at these parameters, as Huber has them, and sigma (n,)."""
    errors = [np.abs(one[:, :-1] @ parameters - one[:, -1]) for one in rows]
    middle = np.array([np.median(one) if one.size else 0.0 for one in errors])
    sigma = np.maximum(MAD_TO_SIGMA * middle, 1e-12 * max(float(middle.max()), 1e-300))
    shares = [np.sqrt(np.minimum(1.0, HUBER * s / np.maximum(e, 1e-300))) for e, s in zip(errors, sigma, strict=True)]
    return [share[:, np.newaxis] * one for share, one in zip(shares, rows, strict=True)], sigma
