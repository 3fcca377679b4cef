"""What a calibration is: its numbers, how sure they are, and whether they are good enough, in a sentence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_double
from ravengc.calibration.imu import STANDARD_GRAVITY, FloatArray, as_rows
from ravengc.errors import ArgumentError, CalibrationError

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["Calibration", "as_errors", "check_plausible", "inflation", "seen_from", "suspect"]

LARGEST_BIAS = 3.0
"""m/s², 0.3 g per axis: more than any working sensor has (ADXL345 data sheet, rev. G: up to 0.25 g)."""
SCALE_WINDOW = (0.8, 1.25)
GOOD_DIRECTION_DEG = 0.5
"""Standard error of the direction of gravity; 0.5 degrees are 0.9 % of g across."""
GOOD_RESIDUAL = 0.1
"""m/s², RMS over the positions; more is no noise of a sensor at rest but a position that was not still, or wrong."""
SMALLEST_LEFT = 1e-9
"""The share of a position's own error in its residual below which the others say nothing about it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """f = S (s - bias), S = ``correction``, from the reading s; and R f in base axes, R = ``rotation``.

    ``bias`` (3,) m/s², ``correction`` (3, 3), ``rotation`` (3, 3) R_BS or None. ``bias_error``, ``correction_error``
    and ``rotation_error`` (3,), rad about base axes, are standard errors. ``covariance`` is that of ``parameters``.
    ``residuals`` (n,), m/s², tell for every position how far the calibrated force is from what it should be;
    ``direction_error`` (rad) is the largest standard error of a calibrated direction among the positions.
    ``noise_ratio`` is what is left over what noise explains: about 1, more where positions moved or the model is short,
    None where nothing is left over to tell. ``suspect`` is the position, from 0, that disagrees most with the others,
    and by how much, m/s².
    """

    method: str
    bias: FloatArray
    bias_error: FloatArray
    correction: FloatArray
    correction_error: FloatArray
    rotation: FloatArray | None = None
    rotation_error: FloatArray | None = None
    parameters: tuple[str, ...]
    covariance: FloatArray
    residuals: FloatArray
    direction_error: float
    condition: float
    coverage_deg: float
    noise_ratio: float | None
    suspect: tuple[int, float]
    notes: tuple[str, ...] = ()

    @property
    def residual(self) -> float:
        """RMS of the residuals, m/s²."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    @property
    def good(self) -> bool:
        """Whether directions are known to half a degree and no position disagrees."""
        return math.degrees(self.direction_error) <= GOOD_DIRECTION_DEG and self.residual <= GOOD_RESIDUAL

    @property
    def verdict(self) -> str:
        """A sentence for people."""
        degrees = math.degrees(self.direction_error)
        ratio = "" if self.noise_ratio is None else f", {self.noise_ratio:.3g} times what noise explains"
        facts = (
            f"{self.method}, {len(self.residuals)} positions: directions to {degrees:.2g} deg, "
            f"residual {self.residual:.2g} m/s²{ratio}"
        )
        if self.good:
            return f"Good: {facts}."
        if self.residual > GOOD_RESIDUAL:
            position, distance = self.suspect
            why = f"position {position + 1} is off by {distance:.2g} m/s²: was it still, and as declared?"
        else:
            why = "take more positions, farther apart, and hold each longer."
        return f"Poor: {facts}; {why}"

    def apply(self, readings: npt.ArrayLike) -> FloatArray:
        """Return S (s - bias) for readings (n, 3), m/s², in sensor axes."""
        return np.asarray((as_rows(readings, "readings") - self.bias) @ self.correction.T)


def as_errors(errors: npt.ArrayLike, count: int) -> FloatArray:
    """Return standard errors (count,), m/s², all positive, from as many or one for all; ArgumentError otherwise."""
    array = as_double(errors, "errors")
    if array.shape not in {(), (count,)} or not (np.isfinite(array) & (array > 0.0)).all():
        raise ArgumentError(f"errors must be one or {count} positive numbers (m/s²)")
    return np.asarray(np.broadcast_to(array, (count,)))


def inflation(residuals: FloatArray, unknowns: int) -> tuple[float, float | None]:
    """Return what to multiply the covariance with, from 1, and √(χ²/ν) itself, for residuals over standard errors.

    The errors of the positions are known from their noise; what the model leaves beyond that makes all errors larger.
    """
    freedom = residuals.size - unknowns
    if freedom <= 0:
        return 1.0, None
    chi = float(residuals @ residuals) / freedom
    return max(1.0, chi), math.sqrt(chi)


def suspect(residuals: FloatArray, jacobian: FloatArray, errors: FloatArray) -> tuple[int, float]:
    """Return which position the others contradict most, and by how much, m/s².

    ``residuals`` (n, k) are over the standard ``errors`` (n,), with their Jacobian (n k, p). Without position i the sum
    of their squares is smaller by rᵢᵀ dᵢ, where dᵢ = (1 - Hᵢ)⁻¹ rᵢ is how far it is from what the others predict and
    Hᵢ its block of J (JᵀJ)⁻¹ Jᵀ (R. D. Cook, Technometrics 19, 1977). The largest residual itself may be another's: a
    position that few others watch draws the fit to itself.
    """
    count, size = residuals.shape
    basis = np.linalg.qr(jacobian)[0].reshape(count, size, -1)
    left = np.eye(size) - basis @ basis.swapaxes(1, 2)
    distances = np.einsum("nij,nj->ni", np.linalg.pinv(left, rcond=SMALLEST_LEFT, hermitian=True), residuals)
    found = int((residuals * distances).sum(axis=1).argmax())
    return found, float(np.linalg.norm(distances[found]) * errors[found])


def check_plausible(bias: FloatArray, correction: FloatArray) -> None:
    """Raise CalibrationError for a bias or scale that no working sensor has."""
    axis = int(np.abs(bias).argmax())
    if not np.abs(bias[axis]) <= LARGEST_BIAS:
        raise CalibrationError(
            f"the bias along {'xyz'[axis]} would be {bias[axis]:.3g} m/s², more than working sensors have "
            f"(at most {LARGEST_BIAS:g}): is the unit right, the sign (at rest +9.81 upwards), and no axis exchanged?"
        )
    scales = np.linalg.svd(correction, compute_uv=False)
    if not (scales.min() >= SCALE_WINDOW[0] and scales.max() <= SCALE_WINDOW[1]):
        low, high = SCALE_WINDOW
        raise CalibrationError(
            f"the scale would be {scales.min():.3g} to {scales.max():.3g}; expected {low:g} to {high:g}: is the unit "
            f"right, or was the sensor's range set otherwise than declared? (g is taken as {STANDARD_GRAVITY} m/s²)"
        )


def seen_from(force: FloatArray, spread: FloatArray) -> float:
    """Return the standard error (rad) of the direction of ``force`` (3,) whose covariance is ``spread`` (3, 3)."""
    unit = force / np.linalg.norm(force)
    across = np.eye(3) - np.outer(unit, unit)
    return float(np.sqrt(max(np.trace(across @ spread @ across), 0.0)) / np.linalg.norm(force))
