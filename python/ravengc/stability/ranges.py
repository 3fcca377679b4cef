"""Numbers of a stability question within their ranges: the error says which, its value and what is allowed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_double, as_number
from ravengc.errors import ConfigError
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

__all__ = ["optional", "square", "within"]


def within(value: Any, name: str, low: float, high: float, unit: str) -> float:
    """Return a number from ``low`` to ``high``; ConfigError with the range for any other."""
    number = as_number(value, name)
    if not low <= number <= high:
        text = f" {unit}" if unit else ""
        raise ConfigError(f"{name} is {shown(value)}; expected a number from {low:g} to {high:g}{text}")
    return number


def optional(check: Callable[..., float], value: Any, *args: Any) -> float | None:
    """Return what ``check`` makes of a value, or None for None."""
    return None if value is None else check(value, *args)


def square(value: Any, name: str, n: int, *, positive: bool, high: float = 1e12) -> NDArray[np.float64]:
    """Return a symmetric (n, n) matrix, from n numbers its diagonal, positive definite or at least semidefinite.

    One number stands for n. Raises ConfigError for a matrix that is not, with the smallest eigenvalue, and for numbers
    that are not, with those.
    """
    given = as_double(value, name)
    matrix = np.diag(np.broadcast_to(given, (n,))) if given.ndim < 2 and given.size in {1, n} else given
    if matrix.shape != (n, n) or not (np.abs(matrix) <= high).all():
        raise ConfigError(f"{name} is {shown(value)}; expected one, {n} or {n} x {n} numbers of at most {high:g}")
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        raise ConfigError(f"{name} must be symmetric, not {shown(value)}")
    least = float(np.linalg.eigvalsh(matrix).min())
    slack = 0.0 if positive else -1e-12 * float(np.abs(matrix).max())
    if least < slack or (positive and least == 0.0):
        wanted = "above zero" if positive else "zero or more"
        if given.ndim < 2:
            raise ConfigError(f"{name} is {shown(value)}; expected {wanted}")
        raise ConfigError(f"{name}: smallest eigenvalue {least:.6g}; expected all {wanted}")
    return np.array((matrix + matrix.T) / 2.0)
