"""When a law for elastic joints is proven stable: the condition with its numbers, and what would satisfy it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_double, as_number, check_choice
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import shown

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

__all__ = [
    "VARIANTS",
    "WITH_GAINS",
    "Condition",
    "condition_for",
    "inverse_of",
    "least_gain",
    "least_spring",
    "positive_matrix",
]

VARIANTS = ("desired", "motor", "biased", "quasi_static", "link")
"""Where gravity is taken; see :mod:`ravengc.elastic`."""

WITH_GAINS = ("desired", "motor", "biased")
"""Variants whose condition is about K_P too."""

SOFTEST = 1e-9
"""No joint or gain is softer (SI); what is, is a slip, and could overflow."""

SYMMETRY = 1e-9
"""How far (relative) a matrix may be from symmetric: rounding, no more."""

DOUBLINGS, HALVINGS = 1000, 60
"""How far and how finely a factor on K_P is looked for."""


@dataclass(frozen=True, slots=True)
class Condition:
    """``least > alpha``: the least eigenvalue of K_E (or of K: variants "quasi_static", "link") against gravity.

    ``spring`` is the least eigenvalue of K. All in N m/rad (N/m). ``says`` is a sentence with the numbers and, where it
    does not hold, with what would satisfy it.
    """

    variant: str
    least: float
    spring: float
    alpha: float
    says: str

    @property
    def holds(self) -> bool:
        """The law is proven to have one pose at rest, and (but for variant "link") to come to it."""
        return self.least > self.alpha

    @property
    def contraction(self) -> float:
        """By which each step of the fixed point shrinks its error, at most: ``|K^-1| alpha``."""
        return self.alpha / self.spring


def condition_for(variant: str, stiffness: ArrayLike, alpha: float, kp: ArrayLike | None = None) -> Condition:
    """Weigh springs ``stiffness`` and motor gains ``kp`` ((n,) or (n, n), in joint units) against gravity's ``alpha``.

    ``kp`` is needed for the variants "desired", "motor" and "biased" alone. Raises ConfigError for what is none.
    """
    check_choice(variant, VARIANTS, "variant")
    if not as_number(alpha, "alpha") >= 0.0:
        raise ArgumentError(f"alpha is {alpha}; expected gravity's stiffness, N m/rad, zero or more")
    compliance = inverse_of(positive_matrix(stiffness, "stiffness"))
    softness = None if kp is None else inverse_of(positive_matrix(kp, "kp", len(compliance)))
    spring = _reciprocal(np.linalg.norm(compliance, 2))
    if variant not in WITH_GAINS:
        return Condition(variant, spring, spring, alpha, _of_springs(variant, spring, alpha))
    if softness is None:
        raise ConfigError(f"variant {variant!r} is proven stable for strong enough gains only: give kp, (n,) N m/rad")
    least = least_of_both(compliance, softness)
    return Condition(variant, least, spring, alpha, _of_gains(variant, least, spring, alpha, compliance, softness))


def least_of_both(compliance: Array, softness: Array) -> float:
    """Return the least eigenvalue of K_E = [[K, -K], [-K, K + K_P]] from K^-1 and K_P^-1.

    K_E^-1 = [[K^-1 + K_P^-1, K_P^-1], [K_P^-1, K_P^-1]] keeps its digits however stiff the joints are.
    """
    both = np.block([[compliance + softness, softness], [softness, softness]])
    return _reciprocal(np.linalg.norm(both, 2))


def least_gain(alpha: float, spring: float) -> float:
    """Return the K_P that satisfies ``K_P > alpha (2 k - alpha) / (k - alpha)`` with equality; inf if none does.

    ``spring`` is k, or the least eigenvalue of K: the same gain on every joint suffices for any K that is no softer.
    """
    alpha, spring = as_number(alpha, "alpha"), as_number(spring, "spring")
    if math.isinf(spring):
        return 2.0 * alpha
    return alpha * (2.0 * spring - alpha) / (spring - alpha) if spring > alpha else math.inf


def least_spring(alpha: float, gain: float) -> float:
    """Return the K that satisfies the same condition with K_P = ``gain``; inf if none does (K_P <= 2 alpha)."""
    alpha, gain = as_number(alpha, "alpha"), as_number(gain, "gain")
    return alpha * (gain - alpha) / (gain - 2.0 * alpha) if gain > 2.0 * alpha else math.inf


def positive_matrix(x: ArrayLike, name: str, n: int | None = None) -> Array:
    """Return positive numbers (n,), some perhaps infinite, as a diagonal, or a symmetric positive definite (n, n)."""
    numbers = as_double(x, name)
    size = n or (numbers.shape[0] if numbers.ndim else 0)
    if numbers.shape not in {(size,), (size, size)} or not size:
        of = f"{n} numbers or ({n}, {n})" if n else "one number per joint, or a square matrix"
        raise ConfigError(f"{name} has shape {numbers.shape}; expected {of}")
    if numbers.ndim == 1:
        if not (numbers >= SOFTEST).all():
            raise ConfigError(f"{name} is {shown(x)}; expected positive numbers (infinite for a rigid joint)")
        return np.diag(numbers)
    largest = np.abs(numbers).max()
    if not (np.isfinite(largest) and np.abs(numbers - numbers.T).max() <= SYMMETRY * largest):
        raise ConfigError(f"{name} is no symmetric matrix of finite numbers")
    if not (least := np.linalg.eigvalsh(numbers)[0]) > 0.0:
        raise ConfigError(f"{name} is not positive definite: its least eigenvalue is {least:g}")
    return numbers


def inverse_of(matrix: Array) -> Array:
    """Return the inverse of a :func:`positive_matrix`."""
    diagonal = np.diag(matrix)
    if np.isinf(diagonal).any() or not np.count_nonzero(matrix - np.diag(diagonal)):
        return np.diag(1.0 / diagonal)
    return np.asarray(np.linalg.inv(matrix), np.float64)


def _reciprocal(x: Any) -> float:
    return 1.0 / float(x) if x > 0.0 else math.inf


def _enough(least: float) -> str:
    """Six digits, rounded so that what is written suffices."""
    return f"{least * (1.0 + 1e-5):.6g}"


def _of_springs(variant: str, spring: float, alpha: float) -> str:
    numbers = f"the least eigenvalue of K is {spring:.6g} N m/rad, gravity's stiffness is up to {alpha:.6g}"
    return f"variant {variant!r}: {numbers}" + ("" if spring > alpha else f"; springs of {_enough(alpha)} would do")


def _of_gains(variant: str, least: float, spring: float, alpha: float, compliance: Array, softness: Array) -> str:
    matrix = "[[K, -K], [-K, K + K_P]]"
    numbers = f"the least eigenvalue of {matrix} is {least:.6g} N m/rad, gravity's stiffness is up to {alpha:.6g}"
    if least > alpha:
        return f"variant {variant!r}: {numbers}"
    if spring <= alpha:
        cure = f"no K_P helps: the least eigenvalue of K, {spring:.6g}, must itself exceed {alpha:.6g}"
    else:
        factor = _enough(_factor(compliance, softness, alpha))
        cure = f"K_P of {_enough(least_gain(alpha, spring))} on every joint would do, or {factor} times the given K_P"
        gain = _reciprocal(np.linalg.norm(softness, 2))
        if math.isfinite(stiffer := least_spring(alpha, gain)):
            cure += f", or springs of {_enough(stiffer)}"
    return f"variant {variant!r}: {numbers}; {cure}"


def _factor(compliance: Array, softness: Array, alpha: float) -> float:
    """Least factor on K_P with which the least eigenvalue of K_E reaches alpha: it grows with the factor."""
    high = 1.0
    for _ in range(DOUBLINGS):
        if least_of_both(compliance, softness / high) > alpha:
            break
        high *= 2.0
    low = 0.5 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if least_of_both(compliance, softness / middle) > alpha else (middle, high)
    return high
