"""How sure the torque of a pose is once the base stands otherwise than it did while it was identified."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_double, as_number, check_type
from ravengc._core import STANDARD_GRAVITY
from ravengc.errors import ArgumentError
from ravengc.identify.identification import Identification
from ravengc.identify.recording import FloatArray, Recording
from ravengc.messages import shown

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["tilted_sd"]

DIRECTIONS = 8
UNSEEN = 1e-6
"""Share of a joint's largest torque per parameter beyond which what is not identified matters to it."""


def tilted_sd(found: Identification, poses: npt.ArrayLike, tilt: float) -> FloatArray:
    """Standard deviation of every joint's holding torque (n,), N·m or N, on a base tilted from level by ``tilt`` rad.

    RMS over the poses (N, n), in the worst of eight directions of tilt; the larger of what noise (formal) and what
    leaving out fifths of the recordings (cross-validated) make of it. Infinite where the torque depends on a parameter
    that was not identified.
    """
    check_type(found, Identification, "found")
    q, angle = as_double(poses, "poses"), as_number(tilt, "tilt")
    if q.ndim != 2 or q.shape[1] != found.given.n or not len(q) or not np.isfinite(q).all():
        raise ArgumentError(f"poses has shape {q.shape}; expected (N, {found.given.n}), finite")
    if not 0.0 <= angle <= np.pi:
        raise ArgumentError(f"tilt is {shown(tilt)}; expected an angle from 0 to pi rad")
    worst = np.zeros(found.given.n)
    for way in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
        force = STANDARD_GRAVITY * np.array([np.sin(angle) * np.cos(way), np.sin(angle) * np.sin(way), np.cos(angle)])
        worst = np.maximum(worst, _sd(found, q, force))
    return worst


def _sd(found: Identification, q: FloatArray, force: FloatArray) -> FloatArray:
    stand = Recording(
        stamps=np.arange(float(len(q))), q=q, tau=np.zeros_like(q), specific_force=np.tile(force, (len(q), 1))
    )
    Y = found.model.regressor(found.given, stand).reshape(*q.shape, -1)
    known = Y[:, :, found.base.chosen]
    unseen = np.abs(Y - known @ found.base.K).max(axis=(0, 2)) > UNSEEN * np.maximum(np.abs(Y).max(axis=(0, 2)), 1e-12)
    variances = [
        np.einsum("inj,jk,ink->in", known, one, known).mean(axis=0)
        for one in (found.formal_covariance, found.cross_covariance)
    ]
    sd: FloatArray = np.sqrt(np.maximum(np.max(variances, axis=0), 0.0))
    return np.where(unseen, np.inf, sd)
