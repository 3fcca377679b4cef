"""The programme of a step alone, H and c ready: 7 variables in a box, solved by each library from nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from comparison.call import Call
from ravengc._core import _box_minimum

if TYPE_CHECKING:
    from collections.abc import Iterator

    from comparison.stepping.scene import Scene


def ours(scene: Scene) -> Iterator[Call]:
    """H is formed in the call: the others are given it."""
    P = scene.programme
    yield Call("ravengc", "solve", "J, v", lambda k: _box_minimum(*P[k], (0, 0))[0], 1)


def daqp(scene: Scene) -> Iterator[Call]:
    solve = __import__("daqp").solve
    H, c = matrices(scene)
    P, n = scene.programme, len(scene.rate)
    none, sense = np.zeros((0, n)), np.zeros(n, np.int32)
    yield Call("daqp", "solve", "solve", lambda k: solve(H[k], c[k], none, P[k].upper, P[k].lower, sense)[0], 3)


def quadprog(scene: Scene) -> Iterator[Call]:
    solve = __import__("quadprog").solve_qp
    H, c = matrices(scene)
    minus = [-x for x in c]
    eye = np.eye(len(scene.rate))
    sides, bounds = np.hstack([eye, -eye]), np.concatenate([-scene.rate, -scene.rate])
    yield Call("quadprog", "solve", "solve_qp", lambda k: solve(H[k], minus[k], sides, bounds)[0], 2)


def osqp(scene: Scene) -> Iterator[Call]:
    """Set up once, matrices and vectors updated."""
    sparse = __import__("scipy.sparse").sparse
    H, c = matrices(scene)
    solver = __import__("osqp").OSQP()
    upper = [np.ascontiguousarray(sparse.triu(matrix, format="csc").data) for matrix in H]
    eye = sparse.eye(len(scene.rate), format="csc")
    solver.setup(sparse.csc_matrix(H[0]), c[0], eye, -scene.rate, scene.rate, verbose=False, eps_abs=1e-6, eps_rel=1e-6)

    def solve(k: int) -> Any:
        solver.update(Px=upper[k], q=c[k])
        return solver.solve(raise_error=False).x

    yield Call("osqp", "solve", "update, solve (1e-6)", solve, 2)


def matrices(scene: Scene) -> tuple[list[Any], list[Any]]:
    return [one.H for one in scene.programme], [one.c for one in scene.programme]


SOLVERS = {"ravengc": ours, "daqp": daqp, "quadprog": quadprog, "osqp": osqp}
