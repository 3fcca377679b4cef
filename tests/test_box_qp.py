"""The programme behind limited rates: the core against the reference, the optimality conditions, and other solvers."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import ravengc
from ravengc import _core
from ravengc.errors import ArgumentError
from ravengc.reference.box_qp import Programme, ascend, box_minimum, manipulability, velocity_box

if TYPE_CHECKING:
    from collections.abc import Callable

SOLVED = 0
NUMBER = st.floats(-2.0, 2.0).map(lambda x: round(x, 6))
ROBOTS = {name: ravengc.load(name) for name in ("panda", "ur5", "raven2_gold", "dvrk_psm")}


def drawn(shape: tuple[int, ...], elements: st.SearchStrategy[float] = NUMBER) -> st.SearchStrategy[np.ndarray]:
    return arrays.arrays(np.float64, shape, elements=elements)


@st.composite
def programmes(draw: st.DrawFn, most: int = 16) -> Programme:
    """1 to ``most`` variables; rows without weight; weights down to 1e-6; bounds that are equal or absent."""
    n = draw(st.integers(1, most))
    middle, width = draw(drawn((n,))), draw(drawn((n,), st.floats(0.0, 1.5).map(lambda x: round(x, 6))))
    sides = draw(arrays.arrays(np.bool_, (2, n), elements=st.sampled_from([False, False, False, True])))
    return Programme(
        rows=draw(drawn((6, n))),
        target=draw(drawn((6,))),
        row_weight=draw(drawn((6,), st.sampled_from([0.0, 1.0, 1.0, 1.0, 0.3]))),
        wish=draw(drawn((n,))),
        weight=draw(drawn((n,), st.sampled_from([1.0, 1e-2, 1e-4, 1e-6]))),
        lower=np.where(sides[0], -np.inf, middle - width),
        upper=np.where(sides[1], np.inf, middle + width),
    )


def solved(programme: Programme, warm: tuple[int, int] = (0, 0)) -> tuple[Any, ...]:
    found: tuple[Any, ...] = _core._box_minimum(*programme, warm)
    return found


def assert_optimal(programme: Programme, x: np.ndarray, within: float) -> None:
    """In the box, and downhill only where the box ends."""
    slope = programme.H @ x + programme.c
    assert np.all((programme.lower <= x) & (x <= programme.upper))
    assert np.all((slope < within) | (x == programme.lower))
    assert np.all((slope > -within) | (x == programme.upper))


@given(programme=programmes(), warm=st.tuples(st.integers(0, 65535), st.integers(0, 65535)))
def test_the_core_finds_the_minimum_from_any_bounds(programme: Programme, warm: tuple[int, int]) -> None:
    x, active, residual, _, outcome = solved(programme)
    assert outcome == SOLVED
    assert_optimal(programme, x, 1e-10)
    assert residual < 1e-9
    warmly, _, _, _, outcome = solved(programme, warm)
    assert outcome == SOLVED
    assert programme.cost(warmly) == pytest.approx(programme.cost(x), rel=1e-9, abs=1e-12)
    assert solved(programme, active)[3] == 1


@settings(deadline=None)
@given(programme=programmes())
def test_the_reference_finds_it_too(programme: Programme) -> None:
    x = box_minimum(programme)
    assert_optimal(programme, x, 1e-8)
    assert programme.cost(solved(programme)[0]) == pytest.approx(programme.cost(x), rel=1e-8, abs=1e-11)


def by_scipy(programme: Programme) -> Any:
    """Bounded least squares of the stacked rows."""
    own, task = np.sqrt(programme.weight), np.sqrt(programme.row_weight)
    stacked = np.vstack([np.diag(own), task[:, None] * programme.rows])
    right = np.concatenate([own * programme.wish, task * programme.target])
    same = programme.lower == programme.upper
    upper = np.where(same, programme.upper + 1e-9, programme.upper)
    found = import_module("scipy.optimize").lsq_linear(
        stacked, right, (programme.lower, upper), method="bvls", tol=1e-14
    )
    return np.clip(found.x, programme.lower, programme.upper)


def by_daqp(programme: Programme) -> Any:
    daqp, n = import_module("daqp"), len(programme.wish)
    high, low = np.clip(programme.upper, None, 1e30), np.clip(programme.lower, -1e30, None)
    x, _, status, _ = daqp.solve(
        programme.H, programme.c, np.zeros((0, n)), high, low, np.zeros(n, np.int32), primal_tol=1e-11, dual_tol=1e-11
    )
    assert status == 1
    return np.clip(x, programme.lower, programme.upper)


def by_quadprog(programme: Programme) -> Any:
    eye = np.eye(len(programme.wish))
    sides = np.concatenate([programme.lower, -programme.upper])
    known = np.isfinite(sides)
    matrix = np.vstack([eye, -eye])[known].T
    x = import_module("quadprog").solve_qp(programme.H, -programme.c, np.ascontiguousarray(matrix), sides[known])[0]
    return np.clip(x, programme.lower, programme.upper)


def by_osqp(programme: Programme) -> Any:
    osqp, sparse = import_module("osqp"), import_module("scipy.sparse")
    eye = sparse.eye(len(programme.wish), format="csc")
    solver = osqp.OSQP()
    solver.setup(
        sparse.csc_matrix(programme.H), programme.c, eye, programme.lower, programme.upper,
        verbose=False, eps_abs=1e-9, eps_rel=1e-9, max_iter=100_000, polishing=True,
    )  # fmt: skip
    return np.clip(solver.solve(raise_error=True).x, programme.lower, programme.upper)


OTHERS: dict[str, Callable[[Programme], np.ndarray]] = {
    "scipy": by_scipy,
    "daqp": by_daqp,
    "quadprog": by_quadprog,
    "osqp": by_osqp,
}


@pytest.mark.parametrize("name", OTHERS)
def test_no_other_solver_finds_less(name: str) -> None:
    """Each on the same problems of seven joints with limits; what it costs is the referee, as minima may be flat."""
    pytest.importorskip(name)
    generator = np.random.default_rng(5)
    for _ in range(60):
        programme = Programme(
            rows=generator.normal(size=(6, 7)),
            target=generator.normal(size=6),
            row_weight=np.full(6, 1.0),
            wish=generator.normal(size=7),
            weight=np.full(7, 1e-2),
            lower=-generator.uniform(0.05, 1.0, 7),
            upper=generator.uniform(0.05, 1.0, 7),
        )
        ours, theirs = programme.cost(solved(programme)[0]), programme.cost(OTHERS[name](programme))
        assert ours <= theirs * (1.0 + 1e-12)
        assert theirs == pytest.approx(ours, rel=1e-5)


@pytest.mark.parametrize("field", Programme._fields)
def test_what_is_no_number_is_refused_and_stays_in_the_box(field: str) -> None:
    programme = Programme(np.ones((6, 3)), np.ones(6), np.ones(6), np.zeros(3), np.ones(3), np.full(3, 0.1), np.ones(3))
    spoilt = getattr(programme, field).copy()
    spoilt.flat[0] = np.nan
    x, _, residual, _, outcome = solved(programme._replace(**{field: spoilt}))
    assert outcome == 2
    assert np.isnan(residual)
    assert np.isfinite(x).all()
    assert x[1:] == pytest.approx(0.1)


def test_the_reference_says_what_it_cannot_solve() -> None:
    programme = Programme(np.ones((6, 2)), np.ones(6), np.ones(6), np.zeros(2), np.ones(2), np.zeros(2), np.ones(2))
    with pytest.raises(ArgumentError, match="expected positive"):
        box_minimum(programme._replace(weight=np.zeros(2)))
    with pytest.raises(ArgumentError, match="lower <= upper"):
        box_minimum(programme._replace(lower=np.full(2, 2.0)))


@pytest.mark.parametrize("name", ["panda", "ur5", "dvrk_psm"])
@settings(deadline=None)
@given(data=st.data())
def test_manipulability_and_its_gradient_are_the_references(name: str, data: st.DataObject) -> None:
    robot = ROBOTS[name]
    q = data.draw(drawn((len(robot.spec.coordinate_names),), st.floats(-2.5, 2.5).map(lambda x: round(x, 4))))
    m, gradient = _core._manipulability(robot, q)
    if m > 1e-4:
        expected, slope = manipulability(robot.spec, q)
        rounding = np.finfo(float).eps * np.linalg.cond(robot.jacobian(q)) ** 2  # both take the determinant of J J'
        assert m == pytest.approx(expected, rel=1e-9 + rounding)
        np.testing.assert_allclose(gradient, slope, atol=1e-10 / m)


def test_an_arm_of_three_joints_has_no_manipulability() -> None:
    m, gradient = _core._manipulability(ROBOTS["raven2_gold"], np.array([0.5, 1.2, 0.4]))
    assert m == 0.0
    assert not gradient.any()


@given(
    programme=programmes(7),
    gradient=drawn((7,), st.floats(-0.1, 0.1).map(lambda x: round(x, 6))),
    progress=st.sampled_from([0.0, 0.3, 0.9]),
)
def test_the_ascent_is_the_references_and_keeps_its_floor(
    programme: Programme, gradient: np.ndarray, progress: float
) -> None:
    n = len(programme.wish)
    task = programme._replace(row_weight=np.full(6, 2.0), wish=np.zeros(n), weight=np.full(n, 0.01))
    limits = task.lower, task.upper
    x, _, outcome = _core._ascend(task.rows, task.target, gradient[:n], (0.01, 2.0, progress), *limits)
    assert outcome == SOLVED
    np.testing.assert_allclose(x, ascend(task, gradient[:n], progress), atol=1e-7)
    assert np.all((task.lower <= x) & (x <= task.upper))
    along = task.rows.T @ task.target
    alone = along @ box_minimum(task)
    assert along @ x >= min(progress * alone, alone) - 1e-7


@given(seed=st.integers(0, 2**32 - 1), dt=st.sampled_from([1e-3, 0.05]))
def test_no_rate_of_the_box_passes_a_limit(seed: int, dt: float) -> None:
    """However the joints go in the box of each cycle, they stay within their limits; from outside they come back."""
    draw = np.random.default_rng(seed)
    low, rate, q = draw.uniform(-2.0, 2.0, 3), draw.uniform(0.1, 3.0, 3), draw.uniform(-4.0, 6.0, 3)
    high = low + draw.uniform(0.2, 3.0, 3)
    for _ in range(30):
        down, up = velocity_box(q, (low, high, rate), (0.3, 0.01, 1.0), dt)
        assert np.all((down <= up) & (down >= -rate) & (up <= rate))
        beyond = np.maximum(np.maximum(low - q, q - high), 0.0)
        q = q + dt * np.where(draw.random(3) < 0.5, up, down)
        assert np.all(np.maximum(np.maximum(low - q, q - high), 0.0) <= beyond + 1e-12)
