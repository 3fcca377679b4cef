"""The rotation between two sets of directions, and how to tell a rotation from a mirror.

W. Kabsch, Acta Crystallographica A32, 1976 (G. Wahba, SIAM Review 7(3), 1965): with H = Σ w f sᵀ = U Σ Vᵀ the rotation
that leads from s to f best is R = U diag(1, 1, d) Vᵀ, d = det(U Vᵀ). Where d = -1 and the third singular value is not
small, the best orthogonal matrix is a mirror: an axis has the wrong sign, two are exchanged, or the sensor gives
gravity where specific force is meant. The rotation that is nearest to a mirror is wrong in every direction, so it is
refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ravengc.calibration.imu import FloatArray, as_rows
from ravengc.calibration.refusal import CalibrationError
from ravengc.calibration.result import as_errors, inflation

__all__ = ["Mounting", "kabsch", "mounting_rotation", "rotation_angle_deg"]

MIRROR_ODDS = 25.0
"""By how much χ² must fall for a mirror instead of a rotation (five standard deviations) before it is taken for one."""
LEAST_SPREAD = 0.02
"""Second singular value over the first, of directions: two directions about 2 degrees apart have it."""

MIRRORS: dict[str, FloatArray] = {
    "all three axes negated (the sensor gives gravity, not specific force)": -np.eye(3),
    "its x axis negated": np.diag([-1.0, 1.0, 1.0]),
    "its y axis negated": np.diag([1.0, -1.0, 1.0]),
    "its z axis negated": np.diag([1.0, 1.0, -1.0]),
    "its x and y axes exchanged": np.eye(3)[[1, 0, 2]],
    "its y and z axes exchanged": np.eye(3)[[0, 2, 1]],
    "its z and x axes exchanged": np.eye(3)[[2, 1, 0]],
}
"""What turns right readings into those of a mirrored sensor; each undoes itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """A mounting ``rotation`` R_BS (base axes <- sensor axes).

    ``rotation_error`` (3,) are standard errors of small turns about base axes, rad; ``residuals`` (n,) are the lengths
    of R s - f, m/s².
    """

    rotation: FloatArray
    rotation_error: FloatArray
    residuals: FloatArray
    noise_ratio: float | None


def mounting_rotation(
    measured: npt.ArrayLike, expected: npt.ArrayLike, errors: npt.ArrayLike, declared: npt.ArrayLike | None = None
) -> Mounting:
    """Return the rotation from calibrated readings (n, 3) in sensor axes to the expected forces (n, 3) in base axes.

    ``errors`` are standard errors of the readings (n,), or one, m/s². ``declared`` is the rotation that the mounting
    was meant to have (none: the sensor's axes are the base's); it serves to name the fault. Raises CalibrationError for
    directions that are all alike and for a mirror.
    """
    s, f = as_rows(measured, "measured"), as_rows(expected, "expected")
    f = as_rows(f, "expected", len(s))
    sigma = as_errors(errors, len(s))
    rotation = kabsch(s, f, sigma, declared)
    residuals = s @ rotation.T - f
    factor, noise_ratio = inflation((residuals / sigma[:, np.newaxis]).ravel(), 3)
    covariance = factor * np.linalg.inv(_information(f, sigma))
    return Mounting(
        rotation=rotation,
        rotation_error=np.sqrt(np.diag(covariance)),
        residuals=np.linalg.norm(residuals, axis=1),
        noise_ratio=noise_ratio,
    )


def kabsch(
    s: FloatArray, f: FloatArray, sigma: FloatArray, declared: npt.ArrayLike | None = None
) -> npt.NDArray[np.float64]:
    """Return the rotation R that makes Σ |R s - f|² / σ² least, for rows of ``s`` and ``f`` (n, 3).

    Raises CalibrationError for a mirror and for vectors along one line, which leave a turn about it open.
    """
    weights = 1.0 / sigma**2
    u, values, vt = np.linalg.svd((f * weights[:, np.newaxis]).T @ s)
    if not values[1] > LEAST_SPREAD**2 * values[0]:
        raise CalibrationError(
            "the positions differ along one line only, which leaves a turn about it open: "
            "add a position that leans to another side"
        )
    handed = float(np.linalg.det(u @ vt))
    if handed < 0.0 and _is_mirror(s @ (u @ vt).T - f, values[2], weights):
        raise CalibrationError(_name_mirror(u @ vt, declared))
    return np.asarray(u @ np.diag([1.0, 1.0, np.sign(handed)]) @ vt)


def rotation_angle_deg(rotation: FloatArray) -> float:
    """Return the angle of a rotation matrix, degrees."""
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    return float(np.degrees(np.arctan2(np.linalg.norm(skew) / 2.0, (np.trace(rotation) - 1.0) / 2.0)))


def _is_mirror(left: FloatArray, third: float, weights: FloatArray) -> bool:
    """A rotation leaves 4 times the third singular value more than the mirror, whose residuals tell what noise is."""
    freedom = max(left.size - 6, 1)
    noise = max(1.0, float((left**2).sum(axis=1) @ weights) / freedom)
    return bool(4.0 * third > MIRROR_ODDS * noise)


def _name_mirror(improper: FloatArray, declared: npt.ArrayLike | None) -> str:
    """The fault that leaves the rotation nearest to the declared one once it is undone."""
    meant = np.eye(3) if declared is None else np.asarray(declared, dtype=np.float64)
    angles = {name: rotation_angle_deg(improper @ mirror @ meant.T) for name, mirror in MIRRORS.items()}
    name = min(angles, key=lambda fault: angles[fault])
    mounting = "sensor and base axes alike" if declared is None else "the declared mounting"
    return (
        f"the readings are a mirror image of the positions: no mounting turns one into the other. Most likely the "
        f"sensor is read with {name}: that would leave a mounting {angles[name]:.1f} degrees from {mounting}"
    )


def _information(f: FloatArray, sigma: FloatArray) -> FloatArray:
    """Σ (|f|² 1 - f fᵀ) / σ², the inverse covariance of a small turn about base axes."""
    weights = 1.0 / sigma**2
    return np.asarray((weights * (f**2).sum(axis=1)).sum() * np.eye(3) - (f * weights[:, np.newaxis]).T @ f)
