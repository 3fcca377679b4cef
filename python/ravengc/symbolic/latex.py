r"""Formulas as LaTeX (amsmath): align for lines, a matrix where one fits the page."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from ravengc.symbolic.infix import ordered, signed

if TYPE_CHECKING:
    from ravengc.symbolic.algebra import Expr
    from ravengc.symbolic.formulas import Formulas

__all__ = ["latex", "symbol", "to_latex"]

NARROW = 60
PAGE = 35
"""Lines from which an align is let break across pages, which it does not by itself."""
AMSMATH_COLUMNS = 10
SYMBOLS = (
    (r"q(\d+)", r"q_{\1}"),
    (r"qd(\d+)", r"\\dot q_{\1}"),
    (r"qdd(\d+)", r"\\ddot q_{\1}"),
    (r"([gf])([xyz])", r"\1_\2"),
    (r"w([xyz])", r"\\omega_\1"),
    (r"dw([xyz])", r"\\dot\\omega_\1"),
    (r"([ch])([xyz])(\d+)", r"\1_{\2,\3}"),
    (r"I(..)(\d+)", r"I_{\1,\2}"),
    (r"([a-z])(\d+)", r"\1_{\2}"),
)


def symbol(name: str) -> str:
    """A name with its index below and its dots above."""
    for pattern, replacement in SYMBOLS:
        if re.fullmatch(pattern, name):
            return re.sub(pattern, replacement, name)
    return name


def latex(expression: Expr) -> str:
    """An expression for a formula."""
    if expression.is_Add:
        return " ".join(_terms(expression))
    if expression.is_Mul:
        negative, size = signed(expression)
        factors = ordered(size) if size.is_Mul else [size]
        return ("-" if negative else "") + r" \, ".join(map(_inside, factors))
    if expression.is_Pow:
        return f"{_powered(expression.args[0])}^{{{expression.args[1]}}}"
    if expression.is_Function:
        return rf"\{expression.func.__name__}({latex(expression.args[0])})"
    return _number(expression) if expression.is_number else symbol(expression.name)


def _terms(expression: Expr) -> list[str]:
    """The summands with their signs."""
    texts: list[str] = []
    for term in ordered(expression) if expression.is_Add else [expression]:
        negative, size = signed(term) if expression.is_Add else (False, term)
        sign = ("- " if negative else "+ ") if texts else "-" if negative else ""
        texts.append(sign + _inside(size))
    return texts


def _over_lines(expression: Expr) -> str:
    """A sum that is broken before summands that would not fit the line."""
    text, length = "", 0
    for term in _terms(expression):
        width = len(re.sub(r"\\[a-z]+|[\\{}_^, ]", "", term))
        if text and length + width > NARROW:
            text, length = f"{text} \\\\\n&\\quad", 0
        text, length = f"{text} {term}", length + width
    return text.strip()


def _inside(expression: Expr) -> str:
    text = latex(expression)
    return rf"\left({text}\right)" if expression.is_Add else text


def _powered(base: Expr) -> str:
    """The base of a power: in brackets, unless it is a symbol without dots."""
    text = latex(base)
    return text if base.is_Symbol and "dot" not in text else rf"\left({text}\right)"


def _number(number: Expr) -> str:
    text = str(number) if number.is_Integer else repr(float(number))
    digits, _, power = text.partition("e")
    return rf"{digits} \times 10^{{{int(power)}}}" if power else digits


def to_latex(formulas: Formulas, heading: list[str]) -> str:
    """Comments, then the lines of an ``align*`` environment, or one matrix."""
    comment = [f"% {line}".rstrip() for line in (*heading, "needs the package amsmath")]
    entries = {place: latex(entry) for place, entry in formulas.places().items()}
    if len(formulas.shape) == 2 and not formulas.steps and max(map(len, entries.values())) <= NARROW:
        return "\n".join([*comment, *_matrix(formulas, entries), ""])
    lines = [f"{symbol(step.name)} &= {_over_lines(value)}" for step, value in formulas.steps.items()]
    for place, text in entries.items():
        if text != "0" or len(formulas.shape) == 1:
            index = ",".join(str(k + 1) for k in place)
            lines.append(f"{_result(formulas)}_{{{index}}} &= {_over_lines(formulas.places()[place])}")
    body = [r"\begin{align*}", *(f"{line} \\\\" for line in lines[:-1]), lines[-1], r"\end{align*}"]
    if "\n".join(lines).count("\n") >= PAGE:
        body = [r"\begingroup", r"\allowdisplaybreaks", *body, r"\endgroup"]
    return "\n".join([*comment, *body, ""])


def _result(formulas: Formulas) -> str:
    return r"\tau" if formulas.name == "tau" else formulas.name


def _matrix(formulas: Formulas, entries: dict[tuple[int, ...], str]) -> list[str]:
    rows: dict[int, list[str]] = {}
    for place, text in entries.items():
        rows.setdefault(place[0], []).append(text)
    columns = formulas.shape[1]
    body = [rf"\setcounter{{MaxMatrixCols}}{{{columns}}}"] if columns > AMSMATH_COLUMNS else []
    body += [r"\[", rf"{_result(formulas)} = \begin{{pmatrix}}"]
    body += [" & ".join(row) + r" \\" for row in rows.values()]
    return [*body, r"\end{pmatrix}", r"\]"]
