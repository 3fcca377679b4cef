"""The same system as first-order equations: for candidates of its poles, and to simulate it in time.

    z = (x, dx/dt, low-pass),      dz/dt = A z + B u,      p = Cp z + Dp u,      u(t) = rho p(t - T)

p is what leaves the low-pass, u what reaches the torque. The reading takes the acceleration as u drives it, so that
without a low-pass p depends on u at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ravengc.stability.sensing import Sensing
    from ravengc.stability.system import System

__all__ = ["StateSpace", "first_order", "pade_poles", "state_space"]

Array = NDArray[np.float64]
PADE_ORDER = 6


@dataclass(frozen=True, slots=True, eq=False)
class StateSpace:
    """A (k, k), B (k, r), Cp (r, k), Dp (r, r) of the module's text."""

    a: Array
    b: Array
    c: Array
    d: Array


def first_order(normal: System) -> Array:
    """(x, dx/dt) of a system of unit mass without its feedback: the matrix (2 N, 2 N) of its derivative."""
    n = normal.size
    return np.block([[np.zeros((n, n)), np.eye(n)], [-normal.stiffness, -normal.damping]])


def state_space(system: System) -> StateSpace:
    """Bring a system, in coordinates of unit mass, into first-order form."""
    normal = system.normal
    n, r = normal.inputs.shape
    own = first_order(normal)
    into = np.vstack([np.zeros((n, r)), normal.inputs])
    read = normal.reads_acceleration @ own[n:] + np.hstack([normal.reads_position, np.zeros((r, n))])
    through = normal.reads_acceleration @ normal.inputs
    if normal.sensing.cutoff_hz is None:
        return StateSpace(own, into, read, through)
    a, b, c = _low_pass(normal.sensing, r)
    return StateSpace(
        np.block([[own, np.zeros((2 * n, len(a)))], [b @ read, a]]),
        np.vstack([into, b @ through]),
        np.hstack([np.zeros((r, 2 * n)), c]),
        np.zeros((r, r)),
    )


def _low_pass(sensing: Sensing, r: int) -> tuple[Array, Array, Array]:
    """State matrices of r channels of the low-pass, its states in units of what it filters."""
    w, one = sensing.corner, np.eye(r)
    if sensing.order == 1:
        return -w * one, w * one, one
    a = np.kron(np.array(((0.0, w), (-w, -np.sqrt(2.0) * w))), one)
    return a, np.kron(np.array(((0.0,), (w,))), one), np.kron(np.array(((1.0, 0.0),)), one)


def pade_poles(system: System) -> NDArray[np.complex128]:
    """Poles with e^(-sT) as a Pade quotient of order 6; exact without a delay or a feedback."""
    space = state_space(system)
    if not system.fed:
        return np.asarray(np.linalg.eigvals(space.a), complex)
    gain, delay = system.sensing.gain, system.sensing.delay_s
    a, b, c, d = _pade(delay, space.b.shape[1])
    # u = gain (c w + d p), p = Cp z + Dp u: solved for u
    inner = np.eye(len(d)) - gain * d @ space.d
    to_u = gain * np.linalg.solve(inner, np.hstack([d @ space.c, c]))
    size = len(space.a)
    to_p = np.hstack([space.c, np.zeros((len(d), len(a)))]) + space.d @ to_u
    closed = np.vstack([space.b @ to_u, b @ to_p])
    closed[:size, :size] += space.a
    closed[size:, size:] += a
    return np.asarray(np.linalg.eigvals(closed), complex)


def _pade(delay: float, r: int) -> tuple[Array, Array, Array, Array]:
    """State matrices of r channels of the delay's quotient; without a delay only d = 1."""
    one = np.eye(r)
    if delay == 0.0:
        return np.zeros((0, 0)), np.zeros((0, r)), np.zeros((r, 0)), one
    k = PADE_ORDER
    weights = [factorial(2 * k - i) / (factorial(i) * factorial(k - i)) for i in range(k + 1)]
    over: Array = np.array(weights) / weights[k]  # denominator in (s delay), its highest coefficient 1
    under = over * (-1.0) ** np.arange(k + 1)
    companion: Array = np.eye(k, k, 1)
    companion[-1] = -over[:k]
    left = under[:k] - under[k] * over[:k]
    parts = (companion / delay, np.eye(k, 1, 1 - k) / delay, left[None], np.full((1, 1), under[k]))
    a, b, c, d = (np.asarray(np.kron(part, one), np.float64) for part in parts)
    return a, b, c, d
