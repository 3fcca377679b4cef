"""Which columns of a regressor are independent: QR with column pivoting (Gautier 1991), and sums in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.identify.recording import FloatArray

__all__ = ["Independent", "independent_columns", "triangle", "words"]

TOLERANCE = 1e-8
"""Share of a column of unit length below which what is left of it is rounding."""


def triangle(matrix: FloatArray) -> FloatArray:
    """R of the QR factorisation, square: all that least squares needs of a tall matrix."""
    columns = matrix.shape[1]
    reduced = np.asarray(np.linalg.qr(matrix, mode="r"))
    return np.concatenate([reduced, np.zeros((columns - len(reduced), columns))]) if len(reduced) < columns else reduced


@dataclass(frozen=True, slots=True, eq=False)
class Independent:
    """Columns W1 that span all of W: W = W1 K with K (rank, p), K = 1 at the chosen columns."""

    chosen: npt.NDArray[np.intp]
    K: FloatArray


def independent_columns(matrix: FloatArray, order: Sequence[int], tolerance: float = TOLERANCE) -> Independent:
    """Choose independent columns, the first ones in ``order`` where that is as many, and write all as their sums."""
    R = triangle(matrix)
    pivots = _pivots(R, tolerance)
    chosen = np.asarray(order, dtype=np.intp)[_in_order(R[:, order], tolerance)]
    if len(chosen) != len(pivots):
        chosen = pivots
    chosen = np.sort(chosen)
    K = np.zeros((chosen.size, R.shape[1]))
    if chosen.size:
        K[:] = np.linalg.lstsq(R[:, chosen], R, rcond=None)[0]
    K[np.abs(K) < 1e-9] = 0.0
    K[:, chosen] = np.eye(chosen.size)
    return Independent(chosen, K)


def _unit(R: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(R, axis=0)
    largest = lengths.max(initial=0.0)
    seen = lengths > 1e-12 * largest
    unit: FloatArray = np.where(seen, R / np.where(seen, lengths, 1.0), 0.0)
    return unit


def _pivots(R: FloatArray, tolerance: float) -> npt.NDArray[np.intp]:
    """The columns in the order of what is left of them, until nothing is."""
    left, found = _unit(R), []
    for _ in range(R.shape[1]):
        lengths = np.linalg.norm(left, axis=0)
        pivot = int(lengths.argmax())
        if lengths[pivot] <= tolerance:
            break
        found.append(pivot)
        left = _without(left, left[:, pivot] / lengths[pivot])
    return np.array(found, dtype=np.intp)


def _in_order(R: FloatArray, tolerance: float) -> npt.NDArray[np.intp]:
    """The columns from the left that are no sum of those before them."""
    left, found = _unit(R), []
    for column in range(R.shape[1]):
        length = float(np.linalg.norm(left[:, column]))
        if length > 1e3 * tolerance:
            found.append(column)
            left = _without(left, left[:, column] / length)
    return np.array(found, dtype=np.intp)


def _without(left: FloatArray, direction: FloatArray) -> FloatArray:
    """What is left of the columns across a direction; twice, which keeps it across in floating point."""
    for _ in range(2):
        left = left - np.outer(direction, direction @ left)
    return left


def words(independent: Independent, names: tuple[str, ...]) -> tuple[str, ...]:
    """Every base parameter as a sum of parameters: ``link1.hx + 0.279 link2.m``."""
    return tuple(_sum(row, int(chosen), names) for row, chosen in zip(independent.K, independent.chosen, strict=True))


def _sum(row: FloatArray, chosen: int, names: tuple[str, ...]) -> str:
    others = [place for place in np.flatnonzero(np.abs(row) > 1e-7) if place != chosen]
    return names[chosen] + "".join(_summand(row[place], names[place]) for place in others)


def _summand(factor: float, name: str) -> str:
    sign, size = ("-" if factor < 0.0 else "+"), abs(factor)
    return f" {sign} {name}" if abs(size - 1.0) < 1e-7 else f" {sign} {size:.4g} {name}"
