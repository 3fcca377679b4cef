"""The rotation between two sets of directions, and how to tell a rotation from a mirror.

W. Kabsch, Acta Crystallographica A32, 1976 (G. Wahba, SIAM Review 7(3), 1965): with H = Σ w f sᵀ = U Σ Vᵀ the rotation
that leads from s to f best is R = U diag(1, 1, d) Vᵀ, d = det(U Vᵀ). Where d = -1 and the third singular value is not
small, the best orthogonal matrix is a mirror: an axis has the wrong sign, two are exchanged, or the sensor gives
gravity where specific force is meant. The rotation that is nearest to a mirror is wrong in every direction, so it is
refused. Where the third singular value is small the vectors hardly leave a plane, and the mirror across it fits as well
as the rotation: sensors are right-handed, so the rotation is taken, and the other told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ravengc.calibration.imu import FloatArray, as_rows
from ravengc.calibration.result import as_errors, inflation
from ravengc.errors import CalibrationError

__all__ = ["Mounting", "cross_matrices", "kabsch", "mounting_rotation", "rotation_angle_deg"]

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
    of R s - f, m/s². ``handed`` tells whether a mirror is excluded: not by directions that lie in a plane.
    """

    rotation: FloatArray
    rotation_error: FloatArray
    residuals: FloatArray
    noise_ratio: float | None
    handed: bool


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
    rotation, mirror = kabsch(s, f, sigma, declared)
    residuals = s @ rotation.T - f
    factor, noise_ratio = inflation((residuals / sigma[:, np.newaxis]).ravel(), 3)
    turns = cross_matrices(f) / sigma[:, np.newaxis, np.newaxis]
    covariance = factor * np.linalg.inv((turns.swapaxes(1, 2) @ turns).sum(axis=0))
    return Mounting(
        rotation=rotation,
        rotation_error=np.sqrt(np.diag(covariance)),
        residuals=np.linalg.norm(residuals, axis=1),
        noise_ratio=noise_ratio,
        handed=mirror is None,
    )


def kabsch(
    s: FloatArray, f: FloatArray, sigma: FloatArray, declared: npt.ArrayLike | None = None
) -> tuple[FloatArray, FloatArray | None]:
    """Return the rotation R that makes Σ |R s - f|² / σ² least, for rows of ``s`` and ``f`` (n, 3).

    With it comes the mirror that fits as well, where there is one. Raises CalibrationError for a mirror that fits
    better, and for vectors along one line, which leave a turn about it open.
    """
    meant = np.eye(3) if declared is None else as_rows(declared, "declared", 3)
    weights = 1.0 / sigma**2
    u, values, vt = np.linalg.svd((f * weights[:, np.newaxis]).T @ s)
    if not values[1] > LEAST_SPREAD**2 * values[0]:
        raise CalibrationError(
            "the positions differ along one line only, which leaves a turn about it open: "
            "add a position that leans to another side"
        )
    handed = np.sign(np.linalg.det(u @ vt))
    rotation, mirror = (np.asarray(u @ np.diag([1.0, 1.0, sign]) @ vt) for sign in (handed, -handed))
    if not _told_apart(s @ (u @ vt).T - f, values[2], weights):
        return rotation, mirror
    if handed < 0.0:
        mounting = "sensor and base axes alike" if declared is None else "the declared mounting"
        raise CalibrationError(_name_mirror(mirror, meant, mounting))
    return rotation, None


def rotation_angle_deg(rotation: FloatArray) -> float:
    """Return the angle of a rotation matrix, degrees."""
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    return float(np.degrees(np.arctan2(np.linalg.norm(skew) / 2.0, (np.trace(rotation) - 1.0) / 2.0)))


def cross_matrices(vectors: FloatArray) -> FloatArray:
    """Return [v]× (n, 3, 3), with [v]× u = v × u, of vectors (n, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)


def _told_apart(left: FloatArray, third: float, weights: FloatArray) -> bool:
    """The worse of rotation and mirror leaves 4 times the third singular value more than the better, whose is noise."""
    freedom = max(left.size - 6, 1)
    noise = max(1.0, float((left**2).sum(axis=1) @ weights) / freedom)
    return bool(4.0 * third > MIRROR_ODDS * noise)


def _name_mirror(improper: FloatArray, meant: FloatArray, mounting: str) -> str:
    """The fault that leaves the rotation nearest to the one that was meant once it is undone."""
    angles = {name: rotation_angle_deg(improper @ mirror @ meant.T) for name, mirror in MIRRORS.items()}
    name = min(angles, key=lambda fault: angles[fault])
    return (
        f"the readings are a mirror image of the positions: no mounting turns one into the other. Most likely the "
        f"sensor is read with {name}: that would leave a mounting {angles[name]:.1f} degrees from "
        f"{mounting}. A roll or pitch that was given with the other sign looks alike"
    )
