"""How far from instability: distance of the loop from -1, critical gains, and the damping that each base mode keeps.

The loop is open at the fed signals: L(iw) = -H (R2 s^2 + R0) (M s^2 + C s + K)^-1 U, r x r, and its eigenvalues are its
loci. Static gravity leaves the base stable, so instability begins where a locus passes through -1: at the gains
1 / abs(locus) where it crosses the negative real axis. The distance alone does not tell the side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_double, check_type
from ravengc.errors import ArgumentError
from ravengc.messages import shown
from ravengc.stability.state_space import first_order
from ravengc.stability.system import System

__all__ = ["Margins", "Mode", "base_eigenvalues", "base_modes", "frequency_grid", "loci", "margins"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

POINTS = 1200
FINE = 60
"""Points around every resonance, on either side."""
ZOOMS = 4
REACH = (0.3, 3.0)
"""How far from its frequencies without the arm's motion a base's swings are sought, as factors."""
SWING_POINTS = 600
BISECTIONS = 44
GAINS = (0.01, 100.0)
"""Critical gains from -40 to 40 dB are told; nobody's model is that far off."""


@dataclass(frozen=True, slots=True)
class Margins:
    """Smallest distance of a locus from -1 and where (Hz), and the gains, relative, at which a pole is on the axis.

    ``critical_gains`` ascend; empty: none.
    """

    distance: float
    worst_hz: float
    critical_gains: tuple[float, ...]

    def decibel(self, *, stable: bool) -> float:
        """Gain margin: how far to the nearest critical gain; negative: the gain must fall by that much."""
        if not self.critical_gains:
            return math.inf if stable else -math.inf
        levels = 20.0 * np.log10(self.critical_gains)
        return float(np.abs(levels).min()) if stable else float(min(levels[0], 0.0))


@dataclass(frozen=True, slots=True)
class Mode:
    """A swing of the base: ``shape`` (its largest part is 1), frequency, and damping without and with the feedback.

    ``damping`` is c, ``effective_damping`` c_eff = c + Im Z / w: N s/m (N m s/rad).
    """

    shape: tuple[float, ...]
    frequency_hz: float
    damping: float
    effective_damping: float
    inertia: float

    @property
    def share(self) -> float:
        """c_eff / c."""
        effective = self.effective_damping
        return effective / self.damping if self.damping else math.copysign(math.inf, effective)

    @property
    def own_ratio(self) -> float:
        """Damping ratio that the base would have of its own, c / (2 m w)."""
        return self.damping / (4.0 * math.pi * self.frequency_hz * self.inertia)

    @property
    def effective_ratio(self) -> float:
        """Damping ratio of the mode, c_eff / (2 m w)."""
        return self.effective_damping / (4.0 * math.pi * self.frequency_hz * self.inertia)


def loci(system: System, w: Array) -> Complex:
    """Eigenvalues of L(iw) for every ``w`` (rad/s): (k, r)."""
    check_type(system, System, "system")
    frequencies = np.atleast_1d(as_double(w, "w"))
    if frequencies.ndim != 1 or not np.isfinite(frequencies).all():
        raise ArgumentError(f"w must be finite frequencies (k,), not {shown(w)}")
    normal, s = system.normal, on_axis(frequencies)
    own: Complex = normal.inputs.astype(np.complex128)
    loop = normal.reading(s) @ np.linalg.solve(normal.without_feedback(s), own[None])
    found: Complex = np.linalg.eigvals(-normal.sensing.response(s)[:, None, None] * loop)
    return found


def frequency_grid(system: System) -> Array:
    """Frequencies (rad/s) from far below to far above all that happens, denser at the resonances."""
    values = np.linalg.eigvals(first_order(system.normal))
    sizes = np.abs(values[values != 0.0])
    sensing = system.sensing
    corners = [rate for rate in (sensing.corner, 10.0 / sensing.delay_s if sensing.delay_s else math.inf)
               if math.isfinite(rate)]  # fmt: skip
    ends = np.concatenate([sizes, corners])
    w = [np.geomspace(0.02 * ends.min(), 20.0 * ends.max(), POINTS)]
    if sensing.delay_s and sensing.cutoff_hz is None:
        w.append(np.arange(1, 400) * (0.25 / sensing.delay_s))
    around = np.geomspace(1e-6, 0.5, FINE)
    for value in values[values.imag > 0.0]:
        near = value.imag + np.concatenate([-around, [0.0], around]) * abs(value)
        w.append(near[near > 0.0])
    return np.unique(np.concatenate(w))


def margins(system: System) -> Margins:
    """Work out the margins of the feedback; without one, the distance is 1 and nothing is critical."""
    check_type(system, System, "system")
    if not system.fed:
        return Margins(1.0, math.nan, ())
    w = frequency_grid(system)
    with np.errstate(all="ignore"):
        distance, where = _nearest(system, w)
        gains = _critical_gains(system, w)
    told = sorted(gain for gain in gains if GAINS[0] <= gain <= GAINS[1])
    return Margins(distance, where / (2.0 * math.pi), tuple(told))


def base_modes(system: System) -> tuple[Mode, ...]:
    """Every swing of the base near those it has without the arm's motion, slowest first.

    At iw the base's own matrix with the arm's reaction, K + iwC + Z(iw), has eigenvalues lambda in units of its mass
    matrix M. It swings at the w with Re lambda = w^2, with damping Im lambda / w per unit of mass: for one coordinate,
    k + Re Z = M w^2 and c_eff = c + Im Z / w.
    """
    check_type(system, System, "system")
    m = system.base
    alone = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(system.mass[:m, :m], system.stiffness[:m, :m]))))
    w = np.geomspace(REACH[0] * alone.min(), REACH[1] * alone.max(), SWING_POINTS)
    with np.errstate(all="ignore"):
        return tuple(_mode(system, *swing) for swing in _swings(system, w))


def base_eigenvalues(system: System, w: Array) -> tuple[Complex, Complex]:
    """Eigenvalues (k, m) and vectors (k, m, m) of M^-1 (K + iwC + Z(iw)) of the base for every ``w`` (rad/s)."""
    m, s = system.base, on_axis(w)
    matrix = system.matrix(s)
    through = matrix[:, :m, m:] @ np.linalg.solve(matrix[:, m:, m:], matrix[:, m:, :m])
    mass = system.mass[:m, :m]
    restoring = matrix[:, :m, :m] - through - mass * (s * s)[:, None, None]
    own: Complex = mass.astype(np.complex128)
    values, vectors = np.linalg.eig(np.linalg.solve(own[None], restoring))
    return values, vectors


def _swings(system: System, w: Array) -> list[tuple[float, complex]]:
    """Frequencies, ascending, and eigenvalues with Re lambda = w^2, where it falls below."""
    values = base_eigenvalues(system, w)[0]
    found = []
    for i in range(len(w) - 1):
        for value in values[i]:
            after = values[i + 1][np.argmin(np.abs(values[i + 1] - value))]
            if value.real > w[i] ** 2 and after.real <= w[i + 1] ** 2:
                found.append(_swing_between(system, float(w[i]), float(w[i + 1]), value))
    return found


def _swing_between(system: System, low: float, high: float, value: complex) -> tuple[float, complex]:
    """Bisect, following one eigenvalue."""
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        values = base_eigenvalues(system, np.array([middle]))[0][0]
        here = values[np.argmin(np.abs(values - value))]
        if here.real > middle**2:
            low, value = middle, here
        else:
            high = middle
    return low, value


def _mode(system: System, w: float, value: complex) -> Mode:
    m = system.base
    values, vectors = base_eigenvalues(system, np.array([w]))
    shape = vectors[0][:, np.argmin(np.abs(values[0] - value))]
    shape = shape / shape[np.argmax(np.abs(shape))]
    inertia, damping = (float((shape.conj() @ matrix[:m, :m] @ shape).real) for matrix in (system.mass, system.damping))
    return Mode(tuple(map(float, shape.real)), w / (2.0 * math.pi), damping, value.imag / w * inertia, inertia)


def on_axis(w: Array) -> Complex:
    """The numbers iw."""
    return np.asarray(1j * w, np.complex128)


def _nearest(system: System, w: Array) -> tuple[float, float]:
    """Smallest abs(1 + locus), and where; the grid is refined around the smallest."""
    for _ in range(ZOOMS):
        distance = np.abs(1.0 + loci(system, w)).min(axis=1)
        distance = np.where(np.isfinite(distance), distance, math.inf)
        i = int(np.argmin(distance))
        best, where = float(distance[i]), float(w[i])
        w = np.linspace(w[max(i - 1, 0)], w[min(i + 1, len(w) - 1)], 101)
    return best, where


def _critical_gains(system: System, w: Array) -> list[float]:
    """1 / abs(locus) wherever a locus crosses the negative real axis, and at the end of all frequencies."""
    values = loci(system, w)
    gains = [gain for i in range(len(w) - 1) for gain in _crossings(system, w[i : i + 2], values[i : i + 2])]
    endless = system.high_frequency_gain
    if system.sensing.delay_s > 0.0 and endless > 0.0:
        gains = [gain for gain in gains if gain < 1.0 / endless] + [1.0 / endless]
    return gains


def _crossings(system: System, ends: Array, values: Complex) -> list[float]:
    """Gains of the crossings between two neighbouring frequencies."""
    found = []
    for start in values[0]:
        end = values[1][np.argmin(np.abs(values[1] - start))]
        if start.imag * end.imag <= 0.0 and start.real + end.real < 0.0 and abs(start - end) < abs(start + end):
            found.append(_gain_between(system, ends, start))
    return found


def _gain_between(system: System, ends: Array, start: complex) -> float:
    """Follow one locus between two frequencies to where it is real."""
    for _ in range(3):
        w = np.linspace(ends[0], ends[1], 12)
        path: list[complex] = []
        for row in loci(system, w):
            path.append(row[np.argmin(np.abs(row - (path[-1] if path else start)))])
        sides = np.sign(np.imag(path))
        i = int(np.argmax(sides[:-1] * sides[1:] <= 0.0))
        ends, start = w[i : i + 2], path[i]
    along = abs(path[i].imag) / (abs(path[i].imag) + abs(path[i + 1].imag) + 1e-300)
    return float(1.0 / abs(path[i] + along * (path[i + 1] - path[i])))
