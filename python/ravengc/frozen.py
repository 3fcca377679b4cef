"""Lists and arrays of a frozen dataclass as tuples of plain numbers, which can be compared and hashed."""

from __future__ import annotations

from typing import Any

__all__ = ["freeze"]


def freeze(part: object, *fields: str) -> None:
    """Turn the lists and arrays of a frozen dataclass into tuples."""
    for name in fields:
        object.__setattr__(part, name, _frozen(getattr(part, name)))


def _frozen(value: Any, depth: int = 2) -> Any:
    """A vector or matrix as tuples of plain numbers; anything else as it is."""
    if depth and hasattr(value, "tolist"):
        value = value.tolist()
    if depth and isinstance(value, (list, tuple)):
        return tuple(_frozen(entry, depth - 1) for entry in value)
    return value
