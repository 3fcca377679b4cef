"""Estimators of base parameters: ordinary, weighted and robust least squares, on reduced rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ravengc.identify.ranks import triangle
from ravengc.identify.reduction import huber_rows, reduced

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.identify.recording import FloatArray
    from ravengc.identify.reduction import Reduction

    Columns = npt.NDArray[np.intp]

__all__ = ["Estimate", "huber", "least_squares", "ordinary", "spread", "weighted"]

ROUNDS = 3
"""How often weights are taken from the residuals of the fit before; they settle within two."""
HUBER_ROUNDS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """All parameters (p,), zero but for the chosen columns, the formal covariance of those, and how they came about.

    ``weights`` (n,) are those of the joints' rows; ``condition`` is that of the weighted columns scaled to one length.
    """

    parameters: FloatArray
    covariance: FloatArray
    weights: FloatArray
    condition: float


def ordinary(reduction: Reduction, chosen: Columns) -> Estimate:
    """Least squares in which every row counts the same."""
    return least_squares(reduction, chosen, np.ones(reduction.joints))


def weighted(reduction: Reduction, chosen: Columns) -> Estimate:
    """Least squares in which rows count by their joint's residual: 1/sigma of the fit before."""
    estimate = ordinary(reduction, chosen)
    for _ in range(ROUNDS):
        estimate = least_squares(reduction, chosen, joint_weights(reduction, estimate.parameters))
    return estimate


def joint_weights(reduction: Reduction, parameters: FloatArray) -> FloatArray:
    """1/sigma of every joint's residuals, (n,); a joint without residuals or torque counts by the others' scale."""
    samples = np.maximum(reduction.samples, 1)
    sigma = np.sqrt(reduction.squares(parameters) / samples)
    scale = np.sqrt(reduction.energy / samples)
    floor = np.maximum(1e-9 * scale, 1e-12 * max(float(scale.max()), 1e-300))
    weights: FloatArray = 1.0 / np.maximum(sigma, floor)
    return weights


def least_squares(reduction: Reduction, chosen: Columns, weights: FloatArray) -> Estimate:
    """Least squares with these weights of the joints' rows, in columns scaled to unit length.

    Covariance: s² (XᵀX)⁻¹ with s² = |r|²/(rows - b), as if residuals were independent, which they seldom are.
    """
    X, y = reduction.stacked(weights)
    both = triangle(np.column_stack([X[:, chosen], y]))
    R, z = both[:-1, :-1], both[:-1, -1]
    lengths = np.linalg.norm(R, axis=0)
    lengths[lengths == 0.0] = 1.0
    U, sizes, Vt = np.linalg.svd(R / lengths)
    kept = sizes > 1e-13 * sizes.max(initial=0.0)
    inverse = np.where(kept, 1.0 / np.where(kept, sizes, 1.0), 0.0)
    values = Vt.T @ (inverse * (U.T @ z)) / lengths
    freedom = max(int(reduction.samples.sum()) - len(chosen), 1)
    half = (Vt.T * inverse) / lengths[:, np.newaxis]
    covariance = float(both[-1, -1] ** 2) / freedom * (half @ half.T)
    condition = float(sizes[0] / sizes[-1]) if sizes.size and sizes[-1] > 0.0 else np.inf
    return Estimate(spread(values, chosen, X.shape[1]), covariance, weights, condition)


def spread(values: FloatArray, chosen: Columns, columns: int) -> FloatArray:
    """All parameters, with the base parameters in the chosen columns and zero in the others."""
    parameters = np.zeros(columns)
    parameters[chosen] = values
    return parameters


def huber(rows: Sequence[FloatArray], chosen: Columns) -> Estimate:
    """Huber's estimator by reweighted least squares on rows [X y] of every joint: those far from the fit lose weight.

    Sigma of a joint is 1.4826 times the median of |r|, which a share of bad rows does not move.
    """
    estimate = weighted(reduced(rows), chosen)
    for _ in range(HUBER_ROUNDS):
        lighter, sigma = huber_rows(rows, estimate.parameters)
        estimate = least_squares(reduced(lighter), chosen, 1.0 / sigma)
    return estimate
