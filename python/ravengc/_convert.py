"""Conversion of array-likes for the compiled core: only what loses nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.errors import ArgumentError

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["as_double"]


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
