"""Expressions as text, as C and as Python: sums of products, each number as the shortest decimal that is it."""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import Expr, engine

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["GLUE", "PYTHON", "TEXT", "WIDTH", "C", "Notation", "ordered", "signed", "wrapped"]

WIDTH, GLUE = 110, "\0"
"""Of a line, and what stands for a space at which no line is broken."""

SUM, PRODUCT, POWER, ATOM = range(4)


def _plain(number: Expr) -> str:
    """A number: 2 and 0.9; 1e-05 where that is shorter."""
    return str(number) if number.is_Integer and abs(number) < 10**15 else repr(float(number))


def _double(number: Expr) -> str:
    """A number that is a double in C and a float in Python."""
    return repr(float(number))


def _caret(base: str, power: int) -> str:
    return f"{base}^{power}"


def _repeated(base: str, power: int) -> str:
    return "*".join([base] * power)


def _stars(base: str, power: int) -> str:
    return f"{base}**{power}"


@dataclass(frozen=True, slots=True)
class Notation:
    """How a language writes numbers and whole powers; the rest is alike."""

    number: Callable[[Expr], str]
    power: Callable[[str, int], str]
    power_rank: int = POWER

    def __call__(self, expression: Expr) -> str:
        """The expression in this notation."""
        return self._written(expression)[0]

    def _written(self, expression: Expr) -> tuple[str, int]:
        """The text, and how tightly it holds together."""
        if expression.is_Add:
            return self._sum(expression), SUM
        if expression.is_Mul:
            return self._product(expression), PRODUCT
        if expression.is_Pow:
            base = self._inside(expression.args[0], ATOM)
            return self.power(base, int(expression.args[1])), self.power_rank
        if expression.is_Function:
            return f"{expression.func.__name__}({self(expression.args[0])})", ATOM
        if expression.is_number:
            return self.number(expression), SUM if expression.is_negative else ATOM
        return expression.name, ATOM

    def _inside(self, expression: Expr, rank: int) -> str:
        text, own = self._written(expression)
        return text if own >= rank else f"({text})"

    def _sum(self, expression: Expr) -> str:
        text = ""
        for term in ordered(expression):
            negative, size = signed(term)
            sign = " - " if negative else " + "
            text += (sign if text else "-" if negative else "") + self._inside(size, PRODUCT)
        return text

    def _product(self, expression: Expr) -> str:
        negative, size = signed(expression)
        if not size.is_Mul:
            return f"-{self._inside(size, PRODUCT)}"
        return ("-" if negative else "") + "*".join(self._inside(factor, PRODUCT) for factor in ordered(size))


def signed(term: Expr) -> tuple[bool, Expr]:
    """Whether a term has a minus sign, and the term without it."""
    number, rest = term.as_coeff_Mul()
    return bool(number < 0), -number * rest if number < 0 and not rest.is_Add else _positive(number, rest)


def _positive(number: Expr, rest: Expr) -> Expr:
    """A number times a sum, which SymPy would multiply out."""
    if not rest.is_Add or abs(number) == 1:
        return abs(number) * rest
    return engine().Mul(abs(number), rest, evaluate=False)


def ordered(expression: Expr) -> list[Expr]:
    """Summands or factors in the order in which they are written: numbers, symbols, brackets, waves."""
    if expression.is_Add:
        return list(expression.as_ordered_terms())
    return sorted(expression.args, key=_place_in_product)


def _place_in_product(factor: Expr) -> tuple[int, Expr]:
    base = factor.args[0] if factor.is_Pow else factor
    waves = engine().sin, engine().cos
    kinds = (base.is_number, base.is_Symbol, base.is_Add and not base.has(*waves), base.is_Add)
    return kinds.index(True) if True in kinds else len(kinds), engine().default_sort_key(factor)


TEXT = Notation(_plain, _caret)
C = Notation(_double, _repeated, PRODUCT)
PYTHON = Notation(_double, _stars)


def wrapped(line: str, indent: str) -> str:
    """A long line broken at its spaces, but not within a sine or cosine."""
    if len(line) <= WIDTH:
        return line
    own = line[: len(line) - len(line.lstrip())]
    glued = re.sub(r"(?:sin|cos)\([^()]*\)", lambda wave: wave[0].replace(" ", GLUE), line.lstrip())
    broken = textwrap.fill(
        glued, WIDTH, initial_indent=own, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )
    return broken.replace(GLUE, " ")
