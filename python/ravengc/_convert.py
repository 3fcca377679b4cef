"""Conversion of array-likes for the compiled core: only what loses nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.errors import ArgumentError

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["as_double", "as_number", "check_type"]


def as_double(x: Any, name: str) -> NDArray[np.float64]:
    """Return ``x`` as a C-contiguous float64 array, itself if it is one.

    Raises ArgumentError for anything but an array of real numbers: text, objects, complex numbers, ragged lists, masked
    entries.
    """
    try:
        array = np.asarray(x)
    except (ValueError, RecursionError) as error:
        raise ArgumentError(f"{name} is not an array of numbers: {error}") from error
    if array.dtype.kind not in "iuf":
        raise ArgumentError(f"{name} has dtype {array.dtype}; expected real numbers")
    if type(x) is not np.ndarray and isinstance(x, np.ndarray) and np.ma.is_masked(x):
        raise ArgumentError(f"{name} has masked entries; expected a number everywhere")
    with np.errstate(over="ignore"):  # a longer float beyond the range of float64 becomes infinite
        return np.require(array, dtype=np.float64, requirements=["C", "A"])


def as_number(x: Any, name: str) -> float:
    """Return one real number as a float; ArgumentError for anything else."""
    number = as_double(x, name)
    if number.ndim:
        raise ArgumentError(f"{name} has shape {number.shape}; expected one number")
    return float(number)


def check_type(x: object, kind: type, name: str) -> None:
    """Raise ArgumentError unless ``x`` is a ``kind``."""
    if not isinstance(x, kind):
        raise ArgumentError(f"{name} is a {type(x).__name__}; expected a {kind.__name__}")
