"""How many poles lie to the right of a line: counted by the argument principle, with a bound on every step.

The poles are the zeros of d(s) = det(s^2 + s C + K - H(s) V(s)), V(s) = U (R2 s^2 + R0), in coordinates of unit mass;
delays stay delays. Where Re s >= sigma and abs(s) >= R, norms show that there are none. Within, their number is the
winding of d around the boundary:

    zeros = (4 N theta + 2 A - 2 D) / 2 pi

D: change of arg d from sigma to sigma + i w_R. The line is cut into pieces, and for each it is shown that the matrix at
s, times its inverse at the centre, stays near 1: the principal value of the ends' ratio then is the change. Arc: on it
d(s) / s^(2N) = det(1 + X) det(1 - L) with norms of X and L below 1, so that the principal values A of the eigenvalues'
arguments at its end count; theta is the argument of that end. The number is an integer up to rounding errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_number, check_type
from ravengc.stability.system import System

__all__ = ["Count", "poles_right_of"]

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]

MOST_PIECES = 400_000
FINEST = 1e-13
"""Narrowest piece, relative to where it is: what needs a narrower one passes through a pole."""
LARGEST_RADIUS = 1e9
INTEGER = 0.02
"""How far from an integer the number of zeros may come out by rounding."""
SCALES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)
SAFETY = 1e-9
"""Norms are raised by this share, for the rounding of what they are the norms of."""


@dataclass(frozen=True, slots=True)
class Count:
    """``number`` of poles right of the line (infinite: a chain of them), how sure it is and what it took.

    ``proven``: every step was bounded; false where a pole lies on the line or too near to it. ``radius`` (rad/s):
    beyond it there are none. ``pieces``: of the line.
    """

    number: float
    proven: bool
    radius: float
    pieces: int
    right_of: float

    @property
    def none(self) -> bool:
        """It is proven that there is no such pole."""
        return self.proven and self.number == 0


def poles_right_of(system: System, sigma: float = 0.0) -> Count:
    """Count the poles with Re s > ``sigma`` (1/s), multiple ones as often as they are.

    Right of the low-pass's own poles only: further left nothing is proven.
    """
    check_type(system, System, "system")
    sigma = as_number(sigma, "sigma")
    normal = system.normal
    if system.fed and sigma <= normal.sensing.rightmost_filter_pole:
        return Count(math.nan, False, math.nan, 0, sigma)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        far = _FarAway(normal, sigma)
        if far.endless:
            return Count(math.inf, True, math.inf, 0, sigma)
        if not math.isfinite(far.radius):
            return Count(math.nan, False, math.inf, 0, sigma)
        change, pieces = _change_along_line(normal, sigma, math.sqrt(far.radius**2 - sigma**2))
    if change is None:
        return Count(math.nan, False, far.radius, pieces, sigma)
    theta = math.acos(sigma / far.radius)
    zeros = (4.0 * system.size * theta + 2.0 * far.argument - 2.0 * change) / (2.0 * math.pi)
    number = round(zeros)
    return Count(number, abs(zeros - number) < INTEGER, far.radius, pieces, sigma)


class _FarAway:
    """Beyond ``radius`` there is no zero; ``argument`` is A at the arc's upper end; ``endless``: no such radius."""

    def __init__(self, normal: System, sigma: float) -> None:
        self.normal, self.sigma = normal, sigma
        through = normal.reads_acceleration @ normal.inputs  # what is read at once of what is fed
        gain = normal.high_frequency_gain * math.exp(-sigma * normal.sensing.delay_s)
        unfiltered = normal.fed and normal.sensing.cutoff_hz is None
        self.endless = normal.sensing.delay_s > 0.0 and gain > 1.0 + 1e-9
        self.radius = self.argument = math.inf
        if not self.endless:
            bases = _bases(through, normal.reads_acceleration) if unfiltered else [np.eye(len(through), dtype=complex)]
            self.radius = min(self._smallest_radius(through, basis) for basis in bases)
        if math.isfinite(self.radius):
            self.argument = self._argument()

    def _smallest_radius(self, through: Array, basis: Complex) -> float:
        """The first of a growing row of radii beyond which the norms, in this basis, stay below one."""
        self.through = _norm(np.linalg.solve(basis, through @ basis))
        self.spread = float(np.linalg.cond(basis)) * _norm(self.normal.inputs)
        radius = max(1.0, 2.0 * abs(self.sigma))
        while radius < LARGEST_RADIUS and not self._holds(radius):
            radius *= 1.5
        return radius if radius < LARGEST_RADIUS else math.inf

    def _holds(self, radius: float) -> bool:
        normal = self.normal
        own = (_norm(normal.damping) + _norm(normal.stiffness) / radius) / radius
        if not own < 0.99:
            return False
        if not normal.fed:
            return True
        rest = (_norm(normal.reads_acceleration) * own + _norm(normal.reads_position) / radius**2) / (1.0 - own)
        return normal.sensing.bound(radius, self.sigma) * (self.through + self.spread * rest) < 1.0 - SAFETY

    def _argument(self) -> float:
        """A: sum of the arguments of the eigenvalues of 1 + X and 1 - L at the end of the arc."""
        s = np.array([complex(self.sigma, math.sqrt(self.radius**2 - self.sigma**2))])
        own = self.normal.without_feedback(s)[0]
        angles = np.angle(np.linalg.eigvals(own / s[0] ** 2)).sum()
        if self.normal.fed:
            loop = self.normal.reading(s)[0] @ np.linalg.solve(own, self.normal.inputs)
            closed = np.eye(len(loop)) - self.normal.sensing.response(s)[0] * loop
            angles += np.angle(np.linalg.eigvals(closed)).sum()
        return float(angles)


def _norm(matrix: NDArray[np.generic]) -> float:
    return (1.0 + SAFETY) * float(np.linalg.norm(matrix, 2))


def _bases(through: Array, reads: Array) -> list[Complex]:
    """Bases in which the norm of the high-frequency gain is little more than its largest eigenvalue.

    Signals that read no acceleration come last: the gain is triangular in blocks. Its first block is brought to its
    eigenvectors, or to a triangle; what is off the diagonal is made small by scaling. Only what is computed with the
    bases counts, so that they need not be exact.
    """
    left, sizes, _ = np.linalg.svd(reads)
    rank = int((sizes > 1e-12 * sizes[0]).sum())
    vectors = np.linalg.eig((left.T @ through @ left)[:rank, :rank].astype(complex))[1]
    found = []
    for block in (vectors, np.linalg.qr(vectors)[0]):
        whole = np.eye(len(through), dtype=complex)
        whole[:rank, :rank] = block
        for scale in SCALES:
            behind = np.where(np.arange(len(through)) < rank, 1.0, scale)
            stairs = scale ** np.arange(len(through))
            found += [(left @ whole) * columns for columns in (behind, stairs)]
    return [basis for basis in found if np.linalg.cond(basis) < 1e12]


def _change_along_line(normal: System, sigma: float, end: float) -> tuple[float | None, int]:
    """Change of arg d from sigma to sigma + i ``end``, None where it could not be bounded, and the number of pieces."""
    edges: Array = np.append(0.0, np.geomspace(min(1e-3, end / 2.0), end, 64)).astype(np.float64)
    low, high = edges[:-1], edges[1:]
    allowed = min(0.5, math.sin(0.95 * math.pi / normal.size))
    change, pieces = 0.0, len(low)
    while len(low):
        half, middle = (high - low) / 2.0, np.asarray(sigma + 0.5j * (low + high), np.complex128)
        fine = _step_bound(normal, middle, half) < allowed
        change += _changes(normal, middle[fine], half[fine])
        low, high = low[~fine], high[~fine]
        pieces += len(low)
        if pieces > MOST_PIECES or np.any(high - low < FINEST * (high + abs(sigma))):
            return None, pieces
        centre = (low + high) / 2.0
        low, high = np.append(low, centre).astype(np.float64), np.append(centre, high).astype(np.float64)
    return change, pieces


def _step_bound(normal: System, s: Complex, half: Array) -> Array:
    """Bound of the norm of F(s)^-1 (F(s + i x) - F(s)) for all abs(x) <= ``half``, for every s (k,)."""
    fed = normal.inputs @ normal.reading(s)
    response = normal.sensing.response(s)
    matrix = normal.without_feedback(s) - response[:, None, None] * fed
    inverse = _inverses(matrix)
    slope = inverse @ (2.0 * s[:, None, None] * np.eye(normal.size) + normal.damping)
    own = half * _norms(slope) + half**2 * _norms(inverse)
    if not normal.fed:
        return (1.0 + SAFETY) * own
    turned = _response_bound(normal, s, half)
    reach = (1.0 + turned) * (2.0 * np.abs(s) + half) * half
    inward = inverse @ normal.inputs
    read = _norms(inward @ normal.reads_acceleration) * reach + turned * _norms(inverse @ fed)
    bound: Array = (1.0 + SAFETY) * (own + np.abs(response) * read)
    return bound


def _response_bound(normal: System, s: Complex, half: Array) -> Array:
    """Bound of abs(H(s + i x) / H(s) - 1) for all abs(x) <= ``half``."""
    sensing = normal.sensing
    delayed = np.minimum(2.0, half * sensing.delay_s)
    p = sensing.polynomial
    value: Complex = np.asarray(np.polynomial.polynomial.polyval(s, p), np.complex128)
    change: Array = np.zeros(len(s))
    for order in range(1, len(p)):
        p = np.asarray(np.polynomial.polynomial.polyder(p), np.float64)
        slope = np.abs(np.polynomial.polynomial.polyval(s, p) / value)
        change = np.asarray(change + slope * half**order / math.factorial(order), np.float64)
    filtered = np.where(change < 1.0, change / (1.0 - change), math.inf)
    bound: Array = (1.0 + filtered) * (1.0 + delayed) - 1.0
    return bound


def _changes(normal: System, middle: Complex, half: Array) -> float:
    """Sum of the changes of arg d over pieces in which it stays near its value in the middle."""
    if not len(middle):
        return 0.0
    points = np.concatenate([middle - 1j * half, middle, middle + 1j * half])
    sign = np.linalg.slogdet(normal.matrix(points))[0].reshape(3, -1)
    return float(np.angle(sign[2] / sign[1]).sum() - np.angle(sign[0] / sign[1]).sum())


def _inverses(matrix: Complex) -> Complex:
    try:
        return np.asarray(np.linalg.inv(matrix), np.complex128)
    except np.linalg.LinAlgError:  # some point is a pole: its piece is never fine
        return np.full_like(matrix, math.inf)


def _norms(matrices: Complex) -> Array:
    """Frobenius norms, no smaller than the spectral ones."""
    found: Array = np.sqrt((matrices.real**2 + matrices.imag**2).sum(axis=(1, 2)))
    return np.where(np.isnan(found), math.inf, found)
