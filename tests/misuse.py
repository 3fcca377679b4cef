"""Things that no caller means, and a function that is given every one of them in the place of every argument."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import ravengc as rg
from ravengc.errors import RavenGCError

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType

__all__ = ["WRONG", "functions_of", "try_everything"]

ROBOT = rg.load("raven2_gold")
WRONG: tuple[Any, ...] = (
    None, "x", "", b"x", 5, -1.5, float("nan"), True, 1j, 10**5000, [], [None], ["a", "b", "c"], [[1.0], [1.0, 2.0]],
    {}, {1: 2}, object(), np.zeros((2, 2, 2)), np.full(3, np.nan), np.full((3, 3), np.nan), np.array(["a"]),
    np.ma.masked_array(np.zeros(3), mask=True), lambda *_: None, ROBOT, ROBOT.spec, Path("nowhere"),
)  # fmt: skip


def try_everything(function: Callable[..., object], good: dict[str, Any]) -> None:
    """The good arguments give a result; with any of them wrong there is a result, or an error of ours in a sentence."""
    assert _complaint(function, good) is None
    for name in good:
        for value in WRONG:
            said = _complaint(function, good | {name: value})
            assert said is None or 10 < len(said) < 500


def functions_of(module: ModuleType) -> set[Any]:
    """The public functions and classes of a module."""
    public = {getattr(module, name) for name in module.__all__ if callable(getattr(module, name))}
    return {one for one in public if inspect.isroutine(one) or inspect.isclass(one)}


def _complaint(function: Callable[..., object], arguments: dict[str, Any]) -> str | None:
    """What the function says against these arguments; errors that are not ours pass."""
    try:
        function(**arguments)
    except RavenGCError as error:
        return str(error)
    return None
