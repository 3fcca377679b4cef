"""What a formula takes, what it gives, and what it is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec
    from ravengc.symbolic.algebra import Expr

__all__ = ["FORMS", "QUANTITIES", "Form", "Formulas", "Input", "Quantity"]

Quantity = Literal["gravity", "kinematics", "jacobian", "regressor", "inverse-dynamics", "inverse-dynamics-regressor"]
Form = Literal["auto", "closed", "steps"]
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
FORMS: tuple[Form, ...] = get_args(Form)


@dataclass(frozen=True, slots=True)
class Input:
    """An argument: its name, the symbols of its entries, and for each of them, or for all, what it is with its unit."""

    name: str
    symbols: tuple[Expr, ...]
    meaning: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Formulas:
    """Formulas of one quantity of a robot.

    ``inputs`` stand in the order in which code takes them, ``parameters`` with the values of the robot file. ``steps``
    are computed first, in their order; a closed form has none. ``entries`` are those of the result, called ``name``, of
    this ``shape``, row by row. ``columns`` are the parameters that the columns of a regressor multiply. In ``spec``,
    angles of rows within ``right_angles`` (rad) of right angles are such. ``gravity`` is the field (m/s²) if it was
    given in numbers.
    """

    spec: RobotSpec
    what: Quantity
    frame: str
    inputs: tuple[Input, ...]
    parameters: dict[Expr, float]
    steps: dict[Expr, Expr]
    name: str
    shape: tuple[int, ...]
    entries: tuple[Expr, ...]
    columns: tuple[str, ...] = ()
    right_angles: float = 0.0
    gravity: tuple[float, ...] | None = None

    def places(self) -> dict[tuple[int, ...], Expr]:
        """The entries by their indices, from 0."""
        return dict(zip(np.ndindex(self.shape), self.entries, strict=True))

    def used(self) -> set[Expr]:
        """The symbols in steps and entries."""
        return set().union(*(expression.free_symbols for expression in (*self.steps.values(), *self.entries)))
