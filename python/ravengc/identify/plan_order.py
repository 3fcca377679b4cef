"""In which order to take poses: short moves, measured by the joint that moves farthest in shares of its range."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from ravengc.identify.recording import FloatArray

__all__ = ["short_moves", "travel"]


def travel(q: FloatArray, ranges: FloatArray) -> float:
    """Sum of the moves from pose to pose (N, n), each the largest of its joints' in shares of their ranges."""
    span = ranges[:, 1] - ranges[:, 0]
    return float((np.abs(np.diff(q, axis=0)) / span).max(axis=1, initial=0.0).sum())


def short_moves(q: FloatArray, ranges: FloatArray, start: FloatArray) -> npt.NDArray[np.intp]:
    """An order of the poses (N, n) from ``start``: the nearest next, then pieces turned round while that helps."""
    span = ranges[:, 1] - ranges[:, 0]
    places = np.vstack([start, q]) / span
    moves = np.abs(places[:, np.newaxis] - places[np.newaxis]).max(axis=2)
    path = _untangled(_nearest(moves), moves)
    return np.array(path[1:], dtype=np.intp) - 1


def _nearest(moves: FloatArray) -> list[int]:
    path, left = [0], set(range(1, len(moves)))
    while left:
        nearest = min(left, key=lambda place: (moves[path[-1], place], place))
        path.append(nearest)
        left.remove(nearest)
    return path


def _untangled(path: list[int], moves: FloatArray) -> list[int]:
    """Turn pieces of the path round as long as one becomes shorter by it (2-opt); the start stays."""
    shorter = True
    while shorter:
        shorter = False
        for first in range(1, len(path) - 1):
            for last in range(first + 1, len(path)):
                if _gain(path, moves, first, last) > 1e-12:
                    path[first : last + 1] = path[first : last + 1][::-1]
                    shorter = True
    return path


def _gain(path: list[int], moves: FloatArray, first: int, last: int) -> float:
    """How much shorter the path is with the piece from ``first`` to ``last`` turned round."""
    before, after = moves[path[first - 1], path[first]], moves[path[first - 1], path[last]]
    if last + 1 < len(path):
        before, after = before + moves[path[last], path[last + 1]], after + moves[path[first], path[last + 1]]
    return float(before - after)
