"""Bias and mounting rotation from known tilts of the base, where it cannot be turned over.

At rest the reading is s = Rᵀ f + b, with f the specific force in base axes that the tilt gives. The centred vectors
s - mean(s) and f - mean(f) are free of b; the rotation between them is Kabsch's, and b = mean(s) - Rᵀ mean(f). Small
tilts do not tell scale and misalignment from bias: S is taken as known, 1 or what an earlier calibration found.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_number
from ravengc.calibration.imu import STANDARD_GRAVITY, FloatArray, as_gravity, as_rows
from ravengc.calibration.kabsch import cross_matrices, kabsch
from ravengc.calibration.least_squares import condition_of, inverse_normal
from ravengc.calibration.positions import coverage_deg
from ravengc.calibration.result import (
    LARGEST_BIAS,
    Calibration,
    as_errors,
    check_plausible,
    inflation,
    seen_from,
    suspect,
)
from ravengc.errors import CalibrationError

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["FEWEST_TILTS", "fit_tilts", "tilted_force"]

FEWEST_TILTS = 3
WORST_CONDITION = 1000.0
"""Six tilts of up to 20 degrees to all sides have about 90, about one axis 400; 3 degrees about one axis 18,000."""
PARAMETERS = ("turn_x", "turn_y", "turn_z", "bias_x", "bias_y", "bias_z")


def tilted_force(roll: float, pitch: float, gravity: float = STANDARD_GRAVITY) -> FloatArray:
    """Return the specific force (3,), m/s², in axes of a base at rest that is turned from level by Ry(pitch) Rx(roll).

    Angles in rad; f = Rᵀ (0, 0, g) = g (-sin p, cos p sin r, cos p cos r). A turn about the vertical changes nothing.
    """
    r, p = as_number(roll, "roll"), as_number(pitch, "pitch")
    return np.array([-np.sin(p), np.cos(p) * np.sin(r), np.cos(p) * np.cos(r)]) * as_gravity(gravity)


def fit_tilts(
    forces: npt.ArrayLike,
    expected: npt.ArrayLike,
    errors: npt.ArrayLike,
    *,
    correction: npt.ArrayLike | None = None,
    declared: npt.ArrayLike | None = None,
) -> Calibration:
    """Return bias and mounting rotation from mean readings (n, 3) at rest and the forces expected in base axes (n, 3).

    All in m/s²; ``errors`` are standard errors of the readings (n,), or one. ``correction`` is S (3, 3), None for 1.
    ``declared`` is the mounting as it was meant, (3, 3) or None (sensor and base axes alike): if the readings are
    mirrored, it serves to name the fault. Raises CalibrationError for fewer than three positions, tilts along one line
    or hardly different, a mirror, and a bias that no sensor has.
    """
    s, f, sigma, known = _arguments(forces, expected, errors, correction)
    weights = 1.0 / sigma**2
    mean_s, mean_f = (np.average(rows, axis=0, weights=weights) for rows in (s, f))
    condition = condition_of(_jacobian(f, np.eye(3)) / STANDARD_GRAVITY)
    _check_spread(f, condition)
    rotation, mirror = kabsch(s - mean_s, f - mean_f, sigma, declared)
    offset = mean_s - mean_f @ rotation
    bias = np.asarray(np.linalg.solve(known, offset), dtype=np.float64)
    check_plausible(bias, known)
    residuals = (s - offset) @ rotation.T - f
    scaled, jacobian = residuals / sigma[:, np.newaxis], _jacobian(f, rotation @ known)
    jacobian /= np.repeat(sigma, 3)[:, np.newaxis]
    factor, noise_ratio = inflation(scaled.ravel(), len(PARAMETERS))
    covariance = factor * inverse_normal(jacobian)
    error = np.sqrt(np.diag(covariance))
    return Calibration(
        method="known tilts",
        bias=bias,
        bias_error=error[3:],
        correction=known,
        correction_error=np.zeros((3, 3)),
        rotation=rotation,
        rotation_error=error[:3],
        parameters=PARAMETERS,
        covariance=covariance,
        residuals=np.linalg.norm(residuals, axis=1),
        direction_error=max(seen_from(row, d @ covariance @ d.T) for row, d in _sensitivities(f, rotation @ known)),
        condition=condition,
        coverage_deg=coverage_deg(s),
        noise_ratio=noise_ratio,
        suspect=suspect(scaled, jacobian, sigma),
        notes=_mirror_note(mirror, mean_s, mean_f, known),
    )


def _arguments(
    forces: npt.ArrayLike, expected: npt.ArrayLike, errors: npt.ArrayLike, correction: npt.ArrayLike | None
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """S s, the forces expected, the standard errors and S, all checked."""
    known = np.eye(3) if correction is None else as_rows(correction, "correction", 3)
    check_plausible(np.zeros(3), known)
    s, f = as_rows(forces, "forces") @ known.T, as_rows(expected, "expected")
    f, sigma = as_rows(f, "expected", len(s)), as_errors(errors, len(s))
    if len(s) < FEWEST_TILTS:
        raise CalibrationError(
            f"{len(s)} positions; bias and rotation take at least {FEWEST_TILTS} that lean to different sides"
        )
    return s, f, sigma, known


def _mirror_note(
    mirror: FloatArray | None, mean_s: FloatArray, mean_f: FloatArray, known: FloatArray
) -> tuple[str, ...]:
    """What to say of a mirror that fits as well, unless it takes a bias that no sensor has."""
    if mirror is None or np.abs(np.linalg.solve(known, mean_s - mean_f @ mirror)).max() > LARGEST_BIAS:
        return ()
    note = "the tilts lie in a plane: a sensor with an axis mirrored would fit as well; one more, across it, would tell"
    return (note,)


def _sensitivities(f: FloatArray, turned: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """For every force its derivative by a small turn θ of the mounting and by the bias: θ × f - R S b."""
    return [(row, np.hstack([-cross, -turned])) for row, cross in zip(f, cross_matrices(f), strict=True)]


def _jacobian(f: FloatArray, turned: FloatArray) -> FloatArray:
    return np.vstack([d for _, d in _sensitivities(f, turned)])


def _check_spread(f: FloatArray, condition: float) -> None:
    if condition <= WORST_CONDITION:
        return
    raise CalibrationError(
        f"the tilts do not tell bias from rotation (condition {condition:.3g}, at most {WORST_CONDITION:g}; they reach "
        f"{coverage_deg(f):.1f} degrees to a side): tilt farther, and about a second axis"
    )
