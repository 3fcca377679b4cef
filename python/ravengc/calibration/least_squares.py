"""Nonlinear least squares by Levenberg and Marquardt, for problems of a dozen unknowns near 1.

D. Marquardt, Journal of the SIAM 11(2), 1963: the normal equations with their diagonal enlarged by a factor that falls
after a step that helped and rises after one that did not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.calibration.imu import FloatArray

    Model = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

__all__ = ["Solution", "condition_of", "inverse_normal", "minimise"]

MOST_STEPS = 200
SMALLEST_STEP = 1e-11
SMALLEST_DAMPING, LARGEST_DAMPING = 1e-12, 1e12


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """The unknowns ``x`` (p,), residuals (m,) and their Jacobian (m, p) there, and whether the search came to rest."""

    x: FloatArray
    residuals: FloatArray
    jacobian: FloatArray
    converged: bool


def minimise(model: Model, start: FloatArray) -> Solution:
    """Return the least-squares solution near ``start``; ``model(x)`` is residuals (m,) and their Jacobian (m, p)."""
    x, damping = start.astype(np.float64), 1e-3
    residuals, jacobian = model(x)
    for _ in range(MOST_STEPS):
        step = _step(residuals, jacobian, damping)
        small = bool(np.abs(step).max() <= SMALLEST_STEP)
        new_residuals, new_jacobian = model(x + step)
        if new_residuals @ new_residuals <= residuals @ residuals:
            x, residuals, jacobian = x + step, new_residuals, new_jacobian
            damping = max(damping / 10.0, SMALLEST_DAMPING)
        else:
            damping *= 10.0
        if small or damping > LARGEST_DAMPING:
            return Solution(x=x, residuals=residuals, jacobian=jacobian, converged=True)
    return Solution(x=x, residuals=residuals, jacobian=jacobian, converged=False)


def _step(residuals: FloatArray, jacobian: FloatArray, damping: float) -> FloatArray:
    """The solution of (JᵀJ + λ diag JᵀJ) dx = -Jᵀr, from the rows of J and of the damping below it."""
    scale = np.sqrt(damping) * np.linalg.norm(jacobian, axis=0)
    rows = np.vstack([jacobian, np.diag(scale)])
    return np.asarray(-np.linalg.lstsq(rows, np.concatenate([residuals, np.zeros(len(scale))]))[0])


def condition_of(jacobian: FloatArray) -> float:
    """Return the ratio of the largest to the smallest singular value; infinite where a combination has no effect."""
    values = np.linalg.svd(jacobian, compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > 1e-14 * values[0] else float("inf")


def inverse_normal(jacobian: FloatArray) -> FloatArray:
    """Return (JᵀJ)⁻¹, the covariance of the unknowns for residuals of variance 1."""
    return np.asarray(np.linalg.pinv(jacobian.T @ jacobian, hermitian=True))
