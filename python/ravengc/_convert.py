"""Arguments of public functions: converted where that loses nothing, refused with their name where it would."""

from __future__ import annotations

import operator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import did_you_mean, kind_of, listed, shown, with_article

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.typing import NDArray

__all__ = [
    "as_array",
    "as_count",
    "as_double",
    "as_number",
    "as_path",
    "as_texts",
    "as_vector",
    "check_choice",
    "check_members",
    "check_type",
]


def as_array(x: Any, name: str, kinds: str = "iuf") -> NDArray[Any]:
    """Return ``x`` as an array whose dtype is of one of these kinds (NumPy's letters), itself if it is one.

    Raises ArgumentError for anything else: text, objects, ragged lists, masked entries.
    """
    try:
        array = np.asarray(x)
    except (ValueError, RecursionError) as error:
        raise ArgumentError(f"{name} is not an array of numbers: {error}") from error
    if array.dtype.kind not in kinds:
        raise ArgumentError(f"{name} has dtype {array.dtype}; expected {'' if 'c' in kinds else 'real '}numbers")
    if type(x) is not np.ndarray and isinstance(x, np.ndarray) and np.ma.is_masked(x):
        raise ArgumentError(f"{name} has masked entries; expected a number everywhere")
    return array


def as_double(x: Any, name: str) -> NDArray[np.float64]:
    """Return ``x`` as a C-contiguous float64 array, itself if it is one; ArgumentError for what is no real numbers."""
    array = as_array(x, name)
    with np.errstate(over="ignore"):  # a longer float beyond the range of float64 becomes infinite
        return np.require(array, dtype=np.float64, requirements=["C", "A"])


def as_number(x: Any, name: str) -> float:
    """Return one real number as a float; ArgumentError for anything else."""
    number = as_double(x, name)
    if number.ndim:
        raise ArgumentError(f"{name} has shape {number.shape}; expected one number")
    return float(number)


def as_vector(x: Any, name: str, n: int, most: float = np.inf) -> NDArray[np.float64]:
    """Return ``n`` finite numbers, none larger than ``most``; ArgumentError for anything else."""
    vector = as_double(x, name)
    if vector.shape != (n,) or not (np.isfinite(vector) & (np.abs(vector) <= most)).all():
        limit = f" of at most {most:g}" if np.isfinite(most) else ""
        raise ArgumentError(f"{name} must be {n} finite numbers{limit}, not {shown(x)}")
    return vector


def as_count(x: Any, name: str, least: int, most: int | None = None) -> int:
    """Return a whole number of at least, and at most, this much; ArgumentError for anything else, also True and 3.0."""
    try:
        number = least - 1 if isinstance(x, bool) else operator.index(x)
    except TypeError:
        number = least - 1
    if number < least or (most is not None and number > most):
        up_to = "" if most is None else f" to {most}"
        raise ArgumentError(f"{name} is {shown(x)}; expected a whole number from {least}{up_to}")
    return number


def as_path(x: Any, name: str) -> Path:
    """Return a path; ArgumentError for anything but a text or a path."""
    try:
        return Path(x)
    except TypeError:
        raise ArgumentError(f"{name} is {kind_of(x)}; expected a path: a text or a pathlib.Path") from None


def as_texts(x: Any, name: str) -> tuple[str, ...]:
    """Return a list or tuple of texts as a tuple; ArgumentError for anything else, also for a single text."""
    if not isinstance(x, (list, tuple)) or not all(isinstance(entry, str) for entry in x):
        raise ArgumentError(f"{name} is {shown(x)}; expected a list of texts")
    return tuple(x)


def check_type(x: object, kind: type, name: str) -> None:
    """Raise ArgumentError unless ``x`` is a ``kind``."""
    if not isinstance(x, kind):
        raise ArgumentError(f"{name} is {kind_of(x)}; expected {with_article(kind.__name__)}")


def check_members(x: object, members: Collection[str], name: str) -> None:
    """Raise ArgumentError unless ``x`` has these attributes, whatever it is."""
    if missing := [member for member in members if not hasattr(x, member)]:
        has = f"expected an object with {listed(members)}"
        raise ArgumentError(f"{name} is {kind_of(x)} without {listed(missing)}; {has}")


def check_choice(
    x: object, options: Collection[str], name: str, error: type[ArgumentError | ConfigError] = ConfigError
) -> None:
    """Raise ConfigError, or the error given, unless ``x`` is one of these texts."""
    if not isinstance(x, str) or x not in options:
        raise error(f"{name} {shown(x)} is unknown: choose {listed(options)}{did_you_mean(x, options)}")
