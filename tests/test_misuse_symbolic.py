"""Every public function of the formulas with every argument of the wrong kind: a result, or an error of ours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

import ravengc as rg
from misuse import functions_of, try_everything
from ravengc import symbolic

if TYPE_CHECKING:
    from collections.abc import Callable

pytest.importorskip("sympy")

SPEC = rg.load("rrbot").spec
FOUND = symbolic.formulas(SPEC)
OPTIONS = {
    "numbers": False,
    "lengths": False,
    "right_angles": 0.0,
    "gravity": "vector",
    "moving_base": False,
    "frame": "tool",
}

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (symbolic.formulas, {"spec": SPEC, "what": "gravity", **OPTIONS, "form": "auto", "on_progress": None}),
    (symbolic.check, {"formulas": FOUND, "states": 2, "seed": 0}),
    (symbolic.function, {"formulas": FOUND}),
    (symbolic.as_data, {"formulas": FOUND}),
    (symbolic.written, {"formulas": FOUND, "format": "c", "check": symbolic.check(FOUND)}),
]

DATA = {symbolic.Check, symbolic.Formulas, symbolic.Input}
"""Data that the package makes itself."""


@pytest.mark.parametrize(("function", "good"), CALLS, ids=lambda part: getattr(part, "__qualname__", ""))
def test_a_wrong_argument_is_an_error_of_ours(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


def test_every_public_function_is_tried() -> None:
    assert functions_of(symbolic) - {function for function, _ in CALLS} - DATA == set()
