"""The mounting rotation of a sensor that was calibrated from the same positions, with what both fits leave open.

With θ a small turn about base axes, and δf = D δp the change of the calibrated forces with the parameters p of the
calibration, Kabsch's rotation turns by M⁻¹ Σ w [F]×ᵀ R δf, M = Σ w [F]×ᵀ [F]×. Noise along F goes into p alone, noise
across F into the rotation alone, so their covariances add: M⁻¹ + K cov(p) Kᵀ, K = M⁻¹ Σ w [F]×ᵀ R D.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ravengc.calibration.ellipsoid import sensitivities
from ravengc.calibration.kabsch import cross_matrices, mounting_rotation
from ravengc.calibration.result import suspect

if TYPE_CHECKING:
    import numpy.typing as npt

    from ravengc.calibration.imu import FloatArray
    from ravengc.calibration.result import Calibration

__all__ = ["mounted"]


def mounted(
    found: Calibration,
    forces: FloatArray,
    expected: FloatArray,
    errors: FloatArray,
    declared: npt.ArrayLike | None = None,
) -> Calibration:
    """Return an ellipsoid's calibration with the rotation from ``forces`` (n, 3) to those ``expected`` in base axes.

    ``errors`` (n,), m/s², are standard errors of the forces. Residuals become those of the directions too: a tilt that
    was not as declared shows there. Raises CalibrationError as :func:`mounting_rotation` does.
    """
    calibrated = found.apply(forces)
    mounting = mounting_rotation(calibrated, expected, errors, declared)
    turns = cross_matrices(expected).swapaxes(1, 2) / errors[:, np.newaxis, np.newaxis] ** 2
    by_parameters = np.array([d for _, d in sensitivities(forces, found.correction, found.bias)])
    inverse = np.linalg.inv((turns @ cross_matrices(expected)).sum(axis=0))
    gain = inverse @ (turns @ mounting.rotation @ by_parameters).sum(axis=0)
    variance = mounting.rotation_error**2 + np.diag(gain @ found.covariance @ gain.T)
    scaled = (calibrated @ mounting.rotation.T - expected) / errors[:, np.newaxis]
    jacobian = (cross_matrices(expected) / errors[:, np.newaxis, np.newaxis]).reshape(-1, 3)
    return replace(
        found,
        rotation=mounting.rotation,
        rotation_error=np.sqrt(variance),
        residuals=mounting.residuals,
        noise_ratio=mounting.noise_ratio,
        suspect=suspect(scaled, jacobian, errors),
    )
