"""Notes to the reader of a result: sentences about what was left out or changed."""

from __future__ import annotations

__all__ = ["left_out", "left_unused"]


def left_out(count: int, noun: str, which: str) -> str:
    """Return ``3 points without a normal are left out``, or the same of a single one."""
    return f"1 {noun} {which} is left out" if count == 1 else f"{count} {noun}s {which} are left out"


def left_unused(columns: int) -> str:
    """Return ``2 columns behind x y z are not used``, or the same of a single one."""
    which = "behind x y z"
    return f"1 column {which} is not used" if columns == 1 else f"{columns} columns {which} are not used"
