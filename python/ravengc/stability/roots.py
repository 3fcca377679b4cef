"""The poles themselves: candidates with the delay approximated, Newton's method with the delay exact, and the proof.

Newton on d(s) = det F(s): s <- s - 1 / tr(F^-1 F'). Candidates are the poles with the delay as a Pade quotient. That
none was overlooked is shown by counting: no pole lies further right than the rightmost one found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_array, check_type
from ravengc.stability.counting import poles_right_of
from ravengc.stability.state_space import pade_poles
from ravengc.stability.system import System

__all__ = ["Pole", "poles", "rightmost_pole"]

Complex = NDArray[np.complex128]

STEPS = 60
CONVERGED = 1e-10
"""Last step of Newton's method, relative."""
LARGEST_RESPONSE = 1e10
"""Far to the left a late sensor's response drowns the mass and the stiffness: what Newton finds there is rounding."""
SAME = 1e-6
"""Poles that are nearer, relative, are one."""
BESIDE = 1e-4
"""How far right of the rightmost pole, relative, it is proven that there is none."""


@dataclass(frozen=True, slots=True)
class Pole:
    """The rightmost pole ``s`` (1/s + i rad/s); ``proven``: none lies right of Re s + 1e-4 abs(s)."""

    s: complex
    proven: bool

    @property
    def frequency_hz(self) -> float:
        """How fast it swings."""
        return abs(self.s.imag) / (2.0 * math.pi)

    @property
    def growth(self) -> float:
        """How fast it grows, 1/s; negative: decays."""
        return self.s.real


def rightmost_pole(system: System) -> Pole:
    """Find the pole with the largest real part, that with positive imaginary part of a pair.

    Not proven where it lies left of the low-pass's own poles, or where an endless chain of poles comes near the axis.
    """
    found = poles(system)
    if not len(found):
        return Pole(complex(math.nan, math.nan), False)
    best = found[0]
    for _ in range(3):
        beside = best.real + BESIDE * max(abs(best), 1e-3)
        count = poles_right_of(system, beside)
        if count.none or not math.isfinite(count.radius):
            return Pole(complex(best), count.none)
        more = poles(system, _on_line(beside, count.radius))
        if not len(more) or more[0].real <= best.real:
            return Pole(complex(best), False)
        best = more[0]
    return Pole(complex(best), False)


def poles(system: System, candidates: Complex | None = None) -> Complex:
    """Poles that Newton's method finds from ``candidates`` (default: those of a Pade quotient), rightmost first.

    Of a pair, the one with positive imaginary part.
    """
    check_type(system, System, "system")
    start = pade_poles(system) if candidates is None else np.ravel(as_array(candidates, "candidates", "iufc"))
    start = start[(start.imag >= 0.0) & np.isfinite(start)]
    with np.errstate(all="ignore"):
        found = _newton(system, start.astype(complex))
    found = np.where(found.imag < 0.0, found.conj(), found)
    found = found[np.argsort(-found.real, kind="stable")]
    kept: list[complex] = []
    for s in found:
        if all(abs(s - other) > SAME * (abs(s) + 1e-6) for other in kept):
            kept.append(complex(s))
    return np.array(kept, complex)


def _newton(system: System, s: Complex) -> Complex:
    """Every start's limit; those that did not settle are left out."""
    normal = system.normal
    last = np.full(len(s), math.inf)
    for _ in range(STEPS):
        step = _newton_step(normal, s)
        going = np.isfinite(step) & (last > CONVERGED * (np.abs(s) + 1e-9))
        if not going.any():
            break
        last = np.where(going, np.abs(step), np.where(np.isfinite(step), last, math.inf))
        s = np.where(going, s - step, s)
    settled = last <= CONVERGED * (np.abs(s) + 1e-9)
    settled &= np.abs(normal.sensing.response(s)) < LARGEST_RESPONSE
    return s[settled]


def _newton_step(normal: System, s: Complex) -> Complex:
    """1 / tr(F^-1 F'); 0 on a pole."""
    each = s[:, None, None]
    response = normal.sensing.response(s)[:, None, None]
    reading, steeper = normal.reading(s), 2.0 * each * normal.reads_acceleration
    slope = 2.0 * each * np.eye(normal.size) + normal.damping
    slope = slope - response * (normal.inputs @ (steeper + normal.sensing.slope(s)[:, None, None] * reading))
    matrix = normal.matrix(s)
    on_pole = np.linalg.slogdet(matrix)[0] == 0.0
    matrix[on_pole] = np.eye(normal.size)
    step: Complex = 1.0 / np.trace(np.linalg.solve(matrix, slope), axis1=1, axis2=2)
    return np.where(on_pole, 0.0, step)


def _on_line(sigma: float, radius: float) -> Complex:
    """Starts along and right of a line, for what the quotient did not see."""
    heights = np.concatenate([[0.0], np.geomspace(1e-2, radius, 200)])
    return np.concatenate([sigma + 1j * heights, sigma + (0.05 + 1j) * heights])
