"""Formulas as a list of short steps, each equal expression named once.

A recursion over the links names what it computes, so an arm of seven joints costs hundreds of short expressions where
the formula written out would have millions of terms. Numbers, symbols and their multiples are not worth a name.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import Expr, Triple, engine

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["Steps", "needed", "pruned"]


class Steps:
    """Names for expressions: ``defined`` maps each symbol to what it stands for, in the order of computation.

    ``atoms`` are those that a formula written out keeps as one: sums of parameters, such as a length plus a COM.
    """

    def __init__(self) -> None:
        self.defined: dict[Expr, Expr] = {}
        self.atoms: set[Expr] = set()
        self._names: dict[Expr, Expr] = {}

    def name(self, expression: Expr) -> Expr:
        """A symbol for the expression: that of an equal one, or of its negative, where there is one."""
        if _is_short(expression):
            return expression
        if (known := self._names.get(expression)) is not None:
            return known
        if (known := self._names.get(-expression)) is not None:
            return -known
        symbol = engine().Symbol(f"x{len(self.defined) + 1}")
        self.defined[symbol] = expression
        self._names[expression] = symbol
        return symbol

    def names(self, vector: Triple) -> Triple:
        """Symbols for the components of a vector."""
        x, y, z = (self.name(component) for component in vector)
        return x, y, z

    def atom(self, expression: Expr) -> Expr:
        """A symbol that also a formula written out keeps until its last line."""
        symbol = self.name(expression)
        self.atoms |= symbol.free_symbols & self.defined.keys()
        return symbol


def _is_short(expression: Expr) -> bool:
    """A number, a symbol, or a number times a symbol."""
    return expression.is_Atom or (
        expression.is_Mul and len(expression.args) == 2 and expression.args[0].is_Number and expression.args[1].is_Atom
    )


def pruned(defined: Mapping[Expr, Expr], outputs: Iterable[Expr]) -> tuple[dict[Expr, Expr], list[Expr]]:
    """The steps that the outputs need, numbered anew, and the outputs in them; what is used once stands where it is."""
    outputs = list(outputs)
    wanted = needed(defined, outputs)
    uses: Counter[Expr] = Counter()
    for expression in (*wanted.values(), *outputs):
        _count(expression, uses)
    places: dict[Expr, Expr] = {}
    kept: dict[Expr, Expr] = {}
    for symbol, expression in wanted.items():
        written = expression.xreplace(places)
        if uses[symbol] == 1:
            places[symbol] = written
        else:
            places[symbol] = engine().Symbol(f"x{len(kept) + 1}")
            kept[places[symbol]] = written
    return kept, [output.xreplace(places) for output in outputs]


def needed(defined: Mapping[Expr, Expr], outputs: Iterable[Expr]) -> dict[Expr, Expr]:
    """The steps on which the outputs depend, in order."""
    wanted = set().union(*(output.free_symbols for output in outputs))
    for symbol in reversed(defined):
        if symbol in wanted:
            wanted |= defined[symbol].free_symbols
    return {symbol: expression for symbol, expression in defined.items() if symbol in wanted}


def _count(expression: Expr, uses: Counter[Expr], weight: int = 1) -> None:
    """Count how often each symbol would be computed: twice under a square."""
    if expression.is_Symbol:
        uses[expression] += weight
    for part in expression.args:
        _count(part, uses, weight * (2 if expression.is_Pow else 1))
