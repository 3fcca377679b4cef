"""Bias, scale and misalignment from free positions: at rest every calibrated reading has the length g.

The readings of a sensor at rest lie on an ellipsoid, |S (s - b)| = g. S is upper triangular: any rotation of it fits as
well, and belongs to the mounting. Nine unknowns need twelve or more positions, and readings from all around: a patch of
an ellipsoid does not tell its centre. With noise of 0.003 m/s² the largest error of a direction within 30 degrees is
0.07 degrees from 12 positions and 0.03 from 24, if these are all around; from tilts of up to 30 degrees it is 1 degree,
with the bias wrong by 0.6 m/s².
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from ravengc.calibration.imu import STANDARD_GRAVITY, FloatArray, as_gravity, as_rows
from ravengc.calibration.least_squares import condition_of, inverse_normal, minimise
from ravengc.calibration.positions import coverage_deg, different, missing_faces
from ravengc.calibration.result import (
    GOOD_DIRECTION_DEG,
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

    from ravengc.calibration.least_squares import Solution

__all__ = ["FEWEST_POSITIONS", "LEAST_COVERAGE_DEG", "check_ellipsoid_positions", "fit_ellipsoid", "sensitivities"]

FEWEST_POSITIONS = 12
LEAST_COVERAGE_DEG = 60.0
WORST_CONDITION = 1000.0
"""24 positions of 60 degrees coverage have about 200, of 45 degrees 700, of 30 degrees 4000; all around 5."""
AROUND = np.array([row for row in product((-1.0, 0.0, 1.0), repeat=3) if any(row)])
AROUND /= np.linalg.norm(AROUND, axis=1, keepdims=True)
"""Directions to all sides: faces, edges and corners of a cube."""

ROWS, COLUMNS = np.triu_indices(3)
PARAMETERS = ("S_xx", "S_xy", "S_xz", "S_yy", "S_yz", "S_zz", "bias_x", "bias_y", "bias_z")


def fit_ellipsoid(forces: npt.ArrayLike, errors: npt.ArrayLike, gravity: float = STANDARD_GRAVITY) -> Calibration:
    """Return the calibration from the mean readings (n, 3), m/s², of n >= 12 positions at rest.

    ``errors`` are their standard errors (n,) or one for all, m/s²; ``gravity`` is the local g. Raises CalibrationError
    below 12 different positions or 60 degrees of coverage, for positions that leave a direction out, and for a bias or
    scale that no sensor has; each says what was found and what is missing.
    """
    s, g = as_rows(forces, "forces"), as_gravity(gravity)
    sigma = as_errors(errors, len(s)) / g
    coverage = check_ellipsoid_positions(s)
    solution = minimise(lambda x: _model(x, s / g, sigma), _sphere(s / g))
    correction, bias = _matrix(solution.x), solution.x[6:] * g
    condition = condition_of(solution.jacobian * sigma[:, np.newaxis])
    _check_solution(solution, condition, s)
    check_plausible(bias, correction)
    factor, noise_ratio = inflation(solution.residuals, len(PARAMETERS))
    covariance = factor * inverse_normal(solution.jacobian) * np.outer(_scales(g), _scales(g))
    error = np.sqrt(np.diag(covariance))
    correction_error = np.zeros((3, 3))
    correction_error[ROWS, COLUMNS] = error[:6]
    return Calibration(
        method="ellipsoid",
        bias=bias,
        bias_error=error[6:],
        correction=correction,
        correction_error=correction_error,
        parameters=PARAMETERS,
        covariance=covariance,
        residuals=solution.residuals * sigma * g,
        direction_error=_direction_errors(s, correction, bias, covariance).max(),
        condition=condition,
        coverage_deg=coverage,
        noise_ratio=noise_ratio,
        suspect=suspect(solution.residuals[:, np.newaxis], solution.jacobian, sigma * g),
        notes=_elsewhere(correction, bias, covariance, g),
    )


def check_ellipsoid_positions(forces: npt.ArrayLike) -> float:
    """Return the coverage (degrees) of 12 or more positions; CalibrationError saying what is missing if it is small."""
    count = different(forces)
    covered = coverage_deg(forces)
    missing = missing_faces(forces)
    wanted = f"; no position is near {', '.join(missing)} up" if missing else ""
    if covered < LEAST_COVERAGE_DEG:
        raise CalibrationError(
            f"{_counted(count)} cover {covered:.1f} degrees; bias and scale take at least "
            f"{LEAST_COVERAGE_DEG:g}: turn the sensor farther over{wanted}. Where it cannot be turned, "
            "bias and rotation follow from known tilts (method tilts)"
        )
    if count < FEWEST_POSITIONS:
        raise CalibrationError(
            f"{_counted(count)}; bias, scale and misalignment take at least "
            f"{FEWEST_POSITIONS}: {FEWEST_POSITIONS - count} more{wanted}"
        )
    return covered


def _counted(count: int) -> str:
    return f"{count} different position{'s' * (count != 1)}"


def _scales(g: float) -> FloatArray:
    """The unknowns of the search are S and b / g."""
    return np.array([1.0] * 6 + [g] * 3)


def _matrix(x: FloatArray) -> FloatArray:
    correction = np.zeros((3, 3))
    correction[ROWS, COLUMNS] = x[:6]
    return correction


def _sphere(s: FloatArray) -> FloatArray:
    """Where the search starts: the sphere nearest to the readings, |s|² = 2 c·s + r² - |c|², which is linear."""
    c0, c1, c2, rest = np.linalg.lstsq(np.column_stack([2.0 * s, np.ones(len(s))]), (s**2).sum(axis=1))[0]
    centre = np.array([c0, c1, c2])
    radius = np.sqrt(max(rest + centre @ centre, 0.0))
    if not (np.linalg.norm(centre) <= 0.5 and 0.5 <= radius <= 2.0):  # no sphere that a sensor has: start without
        centre, radius = np.zeros(3), 1.0
    return np.array([1.0 / radius, 0.0, 0.0, 1.0 / radius, 0.0, 1.0 / radius, *centre])


def _model(x: FloatArray, s: FloatArray, sigma: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(|f| - 1) / σ, f = S u, u = s - b, in g; with e = f/|f| its derivatives are e_i u_j by S_ij and -Sᵀe by b."""
    correction, u = _matrix(x), s - x[6:]
    f = u @ correction.T
    length = np.linalg.norm(f, axis=1)
    e = f / length[:, np.newaxis]
    jacobian = np.hstack([e[:, ROWS] * u[:, COLUMNS], -e @ correction])
    return (length - 1.0) / sigma, jacobian / sigma[:, np.newaxis]


def _check_solution(solution: Solution, condition: float, s: FloatArray) -> None:
    if solution.converged and condition <= WORST_CONDITION and (solution.x[[0, 3, 5]] > 0.0).all():
        return
    missing = missing_faces(s)
    wanted = f"add positions near {', '.join(missing)} up" if missing else "spread them evenly over all directions"
    raise CalibrationError(
        f"the positions do not determine bias and scale (condition {condition:.3g}, at most {WORST_CONDITION:g}): "
        f"they lie near a plane or a cone; {wanted}"
    )


def _direction_errors(s: FloatArray, correction: FloatArray, bias: FloatArray, covariance: FloatArray) -> FloatArray:
    """Standard errors of the directions of calibrated forces, rad."""
    return np.array([seen_from(f, d @ covariance @ d.T) for f, d in sensitivities(s, correction, bias)])


def _elsewhere(correction: FloatArray, bias: FloatArray, covariance: FloatArray, g: float) -> tuple[str, ...]:
    """A warning of directions that the positions leave badly known, if there are any."""
    readings = g * np.linalg.solve(correction, AROUND.T).T + bias
    errors = np.degrees(_direction_errors(readings, correction, bias, covariance))
    worst = int(errors.argmax())
    if errors[worst] <= GOOD_DIRECTION_DEG:
        return ()
    x, y, z = AROUND[worst]
    where = f"with ({x:.1f}, {y:.1f}, {z:.1f}) up"
    return (f"far from the positions directions are known worse: to {errors[worst]:.2g} deg {where}",)


def sensitivities(s: FloatArray, correction: FloatArray, bias: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Return for every position f = S (s - b) and its derivative (3, 9) by the parameters."""
    found = []
    for u in s - bias:
        by_correction = np.zeros((3, 6))
        by_correction[ROWS, range(6)] = u[COLUMNS]
        found.append((correction @ u, np.hstack([by_correction, -correction])))
    return found
