"""Parameters that bodies can have: least squares over positive definite pseudo-inertias, solved as one conic problem.

A rigid body's mass, first moment h and inertia I about the frame's origin come from a density that is nowhere negative
if and only if P = [[tr(I)/2 1 - I, h], [hᵀ, m]] is positive semidefinite (Wensing, Kim, Slotine, Linear Matrix
Inequalities for Physically Consistent Inertial Parameter Identification, 2018). The rows enter as the triangle of their
QR factorisation, so the size of the problem does not depend on the recording.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ravengc.errors import CalibrationError, MissingExtraError
from ravengc.identify.ranks import triangle

if TYPE_CHECKING:
    import numpy.typing as npt

    from ravengc.identify.bounds import Bounds
    from ravengc.identify.model import Model
    from ravengc.identify.recording import FloatArray
    from ravengc.identify.reduction import Reduction
    from ravengc.robot import Robot

__all__ = ["consistent", "pseudo_inertia"]

INERTIA_PLACES = {"Ixx": (0, 0), "Ixy": (0, 1), "Ixz": (0, 2), "Iyy": (1, 1), "Iyz": (1, 2), "Izz": (2, 2)}
LEAST = np.diag([1e-8, 1e-8, 1e-8, 1e-6])
"""P of every link exceeds this (kg·m², kg): 1 mg·m²/100 and 1 mg, which no torque shows."""
PRIOR = 1e-6
"""Weight of the robot's file beside the rows: it decides what these leave open, and nothing that they show."""
UPPER = [(row, column) for column in range(4) for row in range(column + 1)]
SOLVED = ("Solved", "AlmostSolved")


def consistent(
    robot: Robot,
    model: Model,
    reduction: Reduction,
    weights: FloatArray,
    bounds: Bounds,
    without: npt.NDArray[np.bool_] | None = None,
) -> FloatArray:
    """The parameters (p,) of least squared error, in weights of the joints' rows, that bodies can have.

    The columns marked in ``without`` stay zero. Raises MissingExtraError without the conic solver, and
    CalibrationError when no robot lies within the bounds.
    """
    left_out = np.zeros(len(model.columns(robot.spec)), dtype=bool) if without is None else without
    X, y = reduction.stacked(weights)
    X = np.where(left_out, 0.0, X)
    reduced = triangle(np.column_stack([X, y]))
    R, z = reduced[:-1, :-1], reduced[:-1, -1]
    scale = _scales(R)
    prior = model.prior(robot)
    pull = np.sqrt(PRIOR) * np.eye(len(scale))
    rows = np.vstack([R * scale, pull])
    aims = np.concatenate([z, pull @ (prior / scale)])
    size = max(float(np.linalg.norm(aims)), 1e-300)
    free = _solve(rows, aims / size, *_constraints(robot, model, bounds, scale * size))
    return np.where(left_out, 0.0, free * scale * size)


def pseudo_inertia(parameters: FloatArray) -> FloatArray:
    """P (4, 4) of the ten parameters of a link: m, hx, hy, hz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz."""
    return np.asarray(np.tensordot(parameters, _UNITS, axes=1))


def _units() -> FloatArray:
    """P of each of the ten parameters alone, (10, 4, 4)."""
    units = np.zeros((10, 4, 4))
    units[0, 3, 3] = 1.0
    for axis in range(3):
        units[1 + axis, axis, 3] = units[1 + axis, 3, axis] = 1.0
    for number, (row, column) in enumerate(INERTIA_PLACES.values(), start=4):
        units[number, row, column] = units[number, column, row] = -1.0
        if row == column:
            units[number, :3, :3] += 0.5 * np.eye(3)
    return units


_UNITS = _units()


def _scales(R: FloatArray) -> FloatArray:
    """Units of the parameters in which the columns have one length; those that do not matter get a middling unit."""
    lengths = np.linalg.norm(R, axis=0)
    seen = lengths > 1e-9 * lengths.max(initial=1e-300)
    middle = float(np.median(lengths[seen])) if seen.any() else 1.0
    return 1.0 / np.where(seen, lengths, middle)


def _constraints(
    robot: Robot, model: Model, bounds: Bounds, scale: FloatArray
) -> tuple[list[FloatArray], list[float], list[FloatArray], list[FloatArray]]:
    """G x <= h as rows, and F_k x >= L_k as blocks of ten rows, in parameters p = scale x."""
    columns = model.columns(robot.spec)
    links = tuple(robot.spec.moving_links[place].name for place in model.bodies(robot.spec))
    bounds.check_names(links, columns)
    inequalities = _Rows(len(columns))
    blocks: list[FloatArray] = []
    per_link = len(model.per_link)
    for number, link in enumerate(links):
        first = per_link * number
        _bound_link(inequalities, bounds, link, first)
        if per_link == 10:
            block = np.zeros((len(UPPER), len(columns)))
            block[:, first : first + 10] = [[_svec(_UNITS[k])[entry] for k in range(10)] for entry in range(10)]
            blocks.append(block * scale)
    for place in range(per_link * len(links), len(columns)):
        inequalities.between({place: 1.0}, *bounds.of_parameter(columns[place]))
    if bounds.total_mass is not None:
        masses = dict.fromkeys(range(0, per_link * len(links), per_link), 1.0)
        inequalities.between(masses, -np.inf, bounds.total_mass)
    return [row * scale for row in inequalities.rows], inequalities.limits, blocks, [_svec(LEAST)] * len(blocks)


def _bound_link(rows: _Rows, bounds: Bounds, link: str, first: int) -> None:
    """Mass within its bounds, and least m <= h <= most m along every axis."""
    least, most = bounds.of_mass(link)
    rows.between({first: 1.0}, max(least, float(LEAST[3, 3])), most)
    box = bounds.of_com(link)
    for axis in range(3):
        moment = first + 1 + axis
        rows.between({moment: 1.0, first: -box[2 * axis + 1]}, -np.inf, 0.0)
        rows.between({moment: 1.0, first: -box[2 * axis]}, 0.0, np.inf)


class _Rows:
    """Linear inequalities, collected: rows @ p <= limits."""

    def __init__(self, columns: int) -> None:
        self.columns = columns
        self.rows: list[FloatArray] = []
        self.limits: list[float] = []

    def between(self, factors: dict[int, float], least: float, most: float) -> None:
        row = np.zeros(self.columns)
        row[list(factors)] = list(factors.values())
        for sign, limit in ((1.0, most), (-1.0, -least)):
            if np.isfinite(limit):
                self.rows.append(sign * row)
                self.limits.append(limit)


def _svec(matrix: FloatArray) -> FloatArray:
    """Upper triangle by columns, off the diagonal times the root of two: the solver's form of a symmetric matrix."""
    return np.array([matrix[row, column] * (1.0 if row == column else np.sqrt(2.0)) for row, column in UPPER])


def _solve(
    rows: FloatArray,
    aims: FloatArray,
    inequalities: list[FloatArray],
    limits: list[float],
    blocks: list[FloatArray],
    least: list[FloatArray],
) -> FloatArray:
    """Min |e|²/2 with e = rows x - aims, as cones: A (x, e) + s = b, s = 0, s >= 0, or s a semidefinite triangle."""
    clarabel, sparse = _solver()
    unknowns, errors = rows.shape[1], rows.shape[0]
    bounded = np.array(inequalities).reshape(-1, unknowns)
    parts = [np.hstack([rows, -np.eye(errors)])]
    parts += [np.hstack([part, np.zeros((len(part), errors))]) for part in (bounded, *(-block for block in blocks))]
    b = np.concatenate([aims, np.array(limits), *(-one for one in least)])
    cones = [clarabel.ZeroConeT(errors), clarabel.NonnegativeConeT(len(bounded))]
    cones += [clarabel.PSDTriangleConeT(4) for _ in blocks]
    weight = sparse.diags(np.concatenate([np.zeros(unknowns), np.ones(errors)]), format="csc")
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    matrix = sparse.csc_matrix(np.vstack(parts))
    solution = clarabel.DefaultSolver(weight, np.zeros(unknowns + errors), matrix, b, cones, settings).solve()
    if str(solution.status).rpartition(".")[2] not in SOLVED:
        raise CalibrationError(
            f"no robot within the bounds fits the recording (the solver says {solution.status}); widen them"
        )
    return cast("FloatArray", np.array(solution.x)[:unknowns])


def _solver() -> tuple[Any, Any]:
    try:
        import clarabel
        from scipy import sparse
    except ImportError as error:
        raise MissingExtraError(error.name or "clarabel", "identify", "estimator='consistent'") from error
    return clarabel, sparse
