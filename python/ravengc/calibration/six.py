"""Bias and scale from six positions, each axis up once and down once.

With axis i up the reading is s+ = g / k + b, down it is s- = -g / k + b, so b = (s+ + s-) / 2 and k = 2 g / (s+ - s-).
An axis that leans by θ reads g cos θ: k becomes too large by 1 / cos θ, 0.4 % at 5 degrees.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ravengc.calibration.imu import STANDARD_GRAVITY, FloatArray, as_gravity, as_rows
from ravengc.calibration.positions import FACES, angle_between, coverage_deg
from ravengc.calibration.result import Calibration, as_errors, check_plausible
from ravengc.errors import CalibrationError

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["LARGEST_LEAN_DEG", "fit_six_positions", "nearest_face"]

LARGEST_LEAN_DEG = 10.0
SLIGHT_LEAN_DEG = 1.0
"""Up to here the scale is too large by 0.015 % at most, of which nothing is said."""
PARAMETERS = ("k_x", "k_y", "k_z", "bias_x", "bias_y", "bias_z")


def fit_six_positions(forces: npt.ArrayLike, errors: npt.ArrayLike, gravity: float = STANDARD_GRAVITY) -> Calibration:
    """Return bias and diagonal scale from the mean readings (n, 3), m/s², of positions that show all six faces.

    ``errors`` are standard errors (n,) or one for all, m/s²; several positions of one face are averaged. Raises
    CalibrationError for a face that is missing, one that leans by more than 10 degrees, and for a bias or scale that no
    sensor has.
    """
    s, g = as_rows(forces, "forces"), as_gravity(gravity)
    sigma = as_errors(errors, len(s))
    faces = np.array([nearest_face(force) for force in s])
    _check_all_there(faces)
    along = {face: _mean(s[faces == face, _axis(face)], sigma[faces == face]) for face in FACES}
    up, down = (np.array([along[sign + axis] for axis in "xyz"]) for sign in "+-")
    if not (up[:, 0] > down[:, 0]).all():
        raise CalibrationError("a reading is not larger with its axis up than with it down: is the sign right?")
    bias, k = (up[:, 0] + down[:, 0]) / 2.0, 2.0 * g / (up[:, 0] - down[:, 0])
    check_plausible(bias, np.diag(k))
    f = (s - bias) * k
    leans = _leans(f, faces)
    spread = (up[:, 1] ** 2 + down[:, 1] ** 2) / 4.0
    covariance = _covariance(k, g, spread, (up[:, 1] ** 2 - down[:, 1] ** 2) / 4.0)
    error = np.sqrt(np.diag(covariance))
    residuals = np.linalg.norm(f, axis=1) - g
    worst = int(np.abs(residuals).argmax())
    return Calibration(
        method="six positions",
        bias=bias,
        bias_error=error[3:],
        correction=np.diag(k),
        correction_error=np.diag(error[:3]),
        parameters=PARAMETERS,
        covariance=covariance,
        residuals=residuals,
        direction_error=_direction_error(error, leans.max(), g),
        condition=float(k.max() / k.min()),
        coverage_deg=coverage_deg(s),
        noise_ratio=None,
        suspect=(worst, float(abs(residuals[worst]))),
        notes=_lean_note(leans.max()),
    )


def nearest_face(force: npt.ArrayLike) -> str:
    """Return the axis (``"+x"``) that is nearest to up in this reading (3,)."""
    values = np.asarray(force, dtype=np.float64)
    axis = int(np.abs(values).argmax())
    return ("+" if values[axis] > 0.0 else "-") + "xyz"[axis]


def _axis(face: str) -> int:
    return "xyz".index(face[1])


def _check_all_there(faces: npt.NDArray[np.str_]) -> None:
    missing = [face for face in FACES if face not in faces]
    if missing:
        seen = ", ".join(face for face in FACES if face in faces) or "none"
        raise CalibrationError(
            f"six positions show every axis up once and down once; missing: {', '.join(missing)} up (seen: {seen})"
        )


def _mean(values: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Weighted mean and its standard error."""
    weights = 1.0 / errors**2
    return float(np.average(values, weights=weights)), float(1.0 / np.sqrt(weights.sum()))


def _leans(f: FloatArray, faces: npt.NDArray[np.str_]) -> FloatArray:
    leans = np.array([angle_between(force, FACES[face]) for force, face in zip(f, faces, strict=True)])
    worst = int(leans.argmax())
    if leans[worst] > LARGEST_LEAN_DEG:
        raise CalibrationError(
            f"position {worst + 1} ({faces[worst]} up) leans by {leans[worst]:.1f} degrees; six positions must show "
            f"the axes to {LARGEST_LEAN_DEG:g} degrees: set it on its face, or take 12 free ones (method ellipsoid)"
        )
    return leans


def _covariance(k: FloatArray, g: float, spread: FloatArray, mixed: FloatArray) -> FloatArray:
    """Of k = g / h and b, with h = (s+ - s-) / 2: var h = var b = ``spread``, cov(h, b) = ``mixed``, dk/dh = -k²/g."""
    slope = -(k**2) / g
    return np.block([[np.diag(slope**2 * spread), np.diag(slope * mixed)], [np.diag(slope * mixed), np.diag(spread)]])


def _lean_note(lean_deg: float) -> tuple[str, ...]:
    if lean_deg < SLIGHT_LEAN_DEG:
        return ()
    return (f"faces lean by up to {lean_deg:.1f} deg: scale up to {100 * _excess(lean_deg):.2g} % too large",)


def _excess(lean_deg: float) -> float:
    return 1.0 / math.cos(math.radians(lean_deg)) - 1.0


def _direction_error(error: FloatArray, lean_deg: float, g: float) -> float:
    """Largest standard error of a direction: the bias across it, and half a difference of two scales at 45 degrees."""
    largest_bias, largest_scale = np.sqrt(2.0) * error[3:].max() / g, error[:3].max() / np.sqrt(2.0)
    return float(np.sqrt(largest_bias**2 + largest_scale**2 + (_excess(lean_deg) / 2.0) ** 2))
