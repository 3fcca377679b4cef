"""Exact numbers and vectors of three for SymPy: decimals as fractions, right angles as right angles.

A number of a robot file is taken as the decimal that it is, so that 0.9 - 0.45 - 0.45 is 0 and not 5e-17, and a
direction cosine within its own rounding of 0, 1/2 or 1 is that: what vanishes on paper vanishes here.
"""

from __future__ import annotations

import math
from functools import cache
from importlib import import_module
from typing import Any

from ravengc.errors import MissingExtraError

__all__ = [
    "Expr",
    "Matrix",
    "Triple",
    "added",
    "angle",
    "cosine",
    "cross",
    "dot",
    "engine",
    "exact",
    "product",
    "scaled",
    "transposed",
    "turned",
    "units",
]

Expr = Any
"""An expression of SymPy."""

Triple = tuple[Expr, Expr, Expr]
Matrix = tuple[Triple, Triple, Triple]

ROUNDING = 4.0 * 2.0**-53
"""How far the sine or cosine of a rounded right angle, or a product of two such matrices, is from what is meant."""


@cache
def engine() -> Any:
    """The module ``sympy``; raises MissingExtraError where it is not installed."""
    try:
        return import_module("sympy")
    except ImportError as error:
        raise MissingExtraError("sympy", "symbolic", "symbolic formulas") from error


def exact(number: float) -> Expr:
    """The fraction that the shortest decimal of a float is: 0.9 is 9/10."""
    return engine().Rational(repr(float(number)))


def cosine(number: float) -> float:
    """An entry of a rotation matrix without the rounding that hides a short decimal: 6e-17 is 0."""
    short = round(number, 12)
    return short + 0.0 if abs(number - short) <= ROUNDING else number


def angle(number: float) -> Expr:
    """An angle (rad): a multiple of a right angle as that multiple of pi / 2, any other as its decimal."""
    quarters = round(number / (math.pi / 2.0))
    if abs(number - quarters * (math.pi / 2.0)) <= ROUNDING * max(1.0, abs(number)):
        return quarters * engine().pi / 2
    return exact(number)


def units() -> Matrix:
    """The unit vectors along x, y and z."""
    one, zero = engine().Integer(1), engine().Integer(0)
    return (one, zero, zero), (zero, one, zero), (zero, zero, one)


def added(a: Triple, b: Triple) -> Triple:
    """The sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def scaled(a: Triple, factor: Expr) -> Triple:
    """A vector times a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor


def dot(a: Triple, b: Triple) -> Expr:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Triple, b: Triple) -> Triple:
    """The vector product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def turned(matrix: Matrix, v: Triple) -> Triple:
    """A matrix times a vector."""
    x, y, z = (dot(row, v) for row in matrix)
    return x, y, z


def transposed(matrix: Matrix) -> Matrix:
    """Rows as columns: the inverse of a rotation."""
    x, y, z = zip(*matrix, strict=True)
    return x, y, z


def product(a: Matrix, b: Matrix) -> Matrix:
    """The product of two matrices."""
    x, y, z = (turned(transposed(b), row) for row in a)
    return x, y, z
