"""Notes to the reader of a result: sentences about what was left out or changed."""

from __future__ import annotations

__all__ = ["left_out"]


def left_out(count: int, noun: str, which: str) -> str:
    """Return ``3 points without a normal are left out``, or the same of a single one."""
    return f"1 {noun} {which} is left out" if count == 1 else f"{count} {noun}s {which} are left out"
