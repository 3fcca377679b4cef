"""Quantities with units, as files and command lines write them, to SI: ``"75 deg"``, ``"494 g"``, ``"0.5 N*m"``.

A plain number is SI already. A text needs a unit. An angle is a dimension of its own here, so that degrees never pass
for metres, nor N·m/rad for N·m.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from numbers import Real
from typing import Literal, NamedTuple

from ravengc.errors import UnitsError
from ravengc.messages import did_you_mean, listed, shown

__all__ = ["Dimension", "to_si", "to_si_vector"]

Dimension = Literal[
    "number", "length", "angle", "mass", "inertia", "time", "frequency", "velocity", "angular velocity",
    "acceleration", "angular acceleration", "force", "torque", "stiffness", "angular stiffness", "damping",
    "angular damping",
]  # fmt: skip

Powers = tuple[int, int, int, int]
"""Powers of m, kg, s, rad."""


class _Unit(NamedTuple):
    """A unit: SI = value * numerator / denominator. Two integers keep "494 g" exactly 0.494."""

    numerator: float
    denominator: float
    powers: Powers


_DIMENSIONS: dict[Dimension, tuple[Powers, str]] = {
    "number": ((0, 0, 0, 0), "a number without unit"),
    "length": ((1, 0, 0, 0), "m"),
    "angle": ((0, 0, 0, 1), "rad"),
    "mass": ((0, 1, 0, 0), "kg"),
    "inertia": ((2, 1, 0, 0), "kg*m^2"),
    "time": ((0, 0, 1, 0), "s"),
    "frequency": ((0, 0, -1, 0), "Hz"),
    "velocity": ((1, 0, -1, 0), "m/s"),
    "angular velocity": ((0, 0, -1, 1), "rad/s"),
    "acceleration": ((1, 0, -2, 0), "m/s^2"),
    "angular acceleration": ((0, 0, -2, 1), "rad/s^2"),
    "force": ((1, 1, -2, 0), "N"),
    "torque": ((2, 1, -2, 0), "N*m"),
    "stiffness": ((0, 1, -2, 0), "N/m"),
    "angular stiffness": ((2, 1, -2, -1), "N*m/rad"),
    "damping": ((0, 1, -1, 0), "N*s/m"),
    "angular damping": ((2, 1, -1, -1), "N*m*s/rad"),
}

_LENGTH, _ANGLE, _MASS, _TIME = (1, 0, 0, 0), (0, 0, 0, 1), (0, 1, 0, 0), (0, 0, 1, 0)
_FORCE, _TORQUE, _FREQUENCY = (1, 1, -2, 0), (2, 1, -2, 0), (0, 0, -1, 0)

_UNITS = {
    "m": _Unit(1, 1, _LENGTH),
    "cm": _Unit(1, 100, _LENGTH),
    "mm": _Unit(1, 1000, _LENGTH),
    "um": _Unit(1, 10**6, _LENGTH),
    "in": _Unit(254, 10**4, _LENGTH),
    "rad": _Unit(1, 1, _ANGLE),
    "mrad": _Unit(1, 1000, _ANGLE),
    "deg": _Unit(math.pi, 180, _ANGLE),
    "°": _Unit(math.pi, 180, _ANGLE),
    "rev": _Unit(2 * math.pi, 1, _ANGLE),
    "kg": _Unit(1, 1, _MASS),
    "g": _Unit(1, 1000, _MASS),
    "lb": _Unit(45359237, 10**8, _MASS),
    "s": _Unit(1, 1, _TIME),
    "ms": _Unit(1, 1000, _TIME),
    "us": _Unit(1, 10**6, _TIME),
    "min": _Unit(60, 1, _TIME),
    "Hz": _Unit(1, 1, _FREQUENCY),
    "kHz": _Unit(1000, 1, _FREQUENCY),
    "rpm": _Unit(math.pi, 30, (0, 0, -1, 1)),
    "gn": _Unit(980665, 10**5, (1, 0, -2, 0)),
    "N": _Unit(1, 1, _FORCE),
    "mN": _Unit(1, 1000, _FORCE),
    "kN": _Unit(1000, 1, _FORCE),
    "Nm": _Unit(1, 1, _TORQUE),
    "mNm": _Unit(1, 1000, _TORQUE),
}

_WORDS = {
    "meter": "m",
    "metre": "m",
    "millimeter": "mm",
    "millimetre": "mm",
    "inche": "in",
    "inch": "in",
    "radian": "rad",
    "degree": "deg",
    "kilogram": "kg",
    "gram": "g",
    "sec": "s",
    "second": "s",
    "hertz": "Hz",
    "newton": "N",
}
"""Names that are not read, for the suggestion of the symbol that is."""

_QUANTITY = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*", re.DOTALL)
_FACTOR = re.compile(r"\s*([*·./]?)\s*(°|[A-Za-zµμ]+)(?:(?:\^|\*\*)(-?[1-9])|([²³]))?\s*")
_SUPERSCRIPT = {"²": 2, "³": 3}
_LONGEST_UNIT = 32
_LONGEST_TEXT = 200


class _Entry(NamedTuple):
    """One entry of a vector, named only when there is a message to write."""

    vector: object
    number: int

    def __str__(self) -> str:
        return f"{self.vector}[{self.number}]"


def to_si(value: object, dimension: Dimension, what: object = "value") -> float:
    """Return one quantity in SI: a number as it is, a text such as ``"13 mm"`` converted.

    ``str(what)`` names the quantity in messages. Raises UnitsError for anything that is neither, for an unknown unit or
    dimension, for a unit of another dimension and for a number that is not finite.
    """
    _check_dimension(dimension, what)
    number = _convert(value, dimension, what) if isinstance(value, str) else _plain(value, dimension, what)
    if not math.isfinite(number):
        raise UnitsError(f"{what}: {shown(value)} is not finite")
    return number


def to_si_vector(
    values: Sequence[object], dimensions: Sequence[Dimension], what: object = "vector"
) -> tuple[float, ...]:
    """Return the entries of one vector in SI, entry i of ``dimensions[i]``; all entries carry a unit, or none does."""
    _check_lists(values, dimensions, what)
    with_unit = [isinstance(value, str) for value in values]
    if any(with_unit) and not all(with_unit):
        raise UnitsError(
            f"{what}: {shown(list(values))} mixes entries with and without a unit; "
            f"give every entry a unit or none (then SI: {_DIMENSIONS[dimensions[0]][1]})"
        )
    if len(values) == 1:
        return (to_si(values[0], dimensions[0], what),)
    entries = (_Entry(what, index) for index in range(len(values)))
    return tuple(to_si(*entry) for entry in zip(values, dimensions, entries, strict=True))


def _check_lists(values: object, dimensions: object, what: object) -> None:
    if isinstance(dimensions, str) or not isinstance(dimensions, Sequence):
        raise UnitsError(f"{what}: got dimensions {shown(dimensions)}, expected a list of them")
    for dimension in dimensions:
        _check_dimension(dimension, what)
    if isinstance(values, str) or not isinstance(values, Sequence) or len(values) != len(dimensions):
        raise UnitsError(f"{what}: got {shown(values)}, expected a list of {len(dimensions)} quantities")


def _check_dimension(dimension: object, what: object) -> None:
    if not isinstance(dimension, str) or dimension not in _DIMENSIONS:
        near = did_you_mean(dimension, _DIMENSIONS)
        raise UnitsError(f"{what}: dimension {shown(dimension)} is unknown{near} (known: {listed(_DIMENSIONS)})")


def _plain(value: object, dimension: Dimension, what: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        example = (
            ""
            if dimension == "number"
            else f' in {_DIMENSIONS[dimension][1]}, or a text such as "{_example(dimension)}"'
        )
        raise UnitsError(f"{what}: got {shown(value)}, expected a number{example}")
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _convert(text: str, dimension: Dimension, what: object) -> float:
    quantity = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST_TEXT else None
    if quantity is None:
        raise UnitsError(
            f'{what}: {shown(text)} is no quantity; expected a number and a unit, such as "{_example(dimension)}"'
        )
    number, name = quantity.groups()
    powers, si_name = _DIMENSIONS[dimension]
    if not name:
        raise UnitsError(f"{what}: {shown(text)} has no unit; write {number} without quotes ({si_name}) or add a unit")
    unit = _parse_unit(name, text, what)
    if unit.powers != powers:
        raise UnitsError(f"{what}: {shown(text)} is {_kind(unit.powers)}, expected {_article(dimension)} ({si_name})")
    return float(number) * unit.numerator / unit.denominator


def _parse_unit(name: str, text: str, what: object) -> _Unit:
    """Multiply the factors of ``kg*m^2``, ``N·m`` or ``rad/s`` out."""
    product, position = _Unit(1, 1, (0, 0, 0, 0)), 0
    while position < len(name):
        factor = _FACTOR.match(name, position) if len(name) <= _LONGEST_UNIT else None
        if factor is None:
            raise UnitsError(f"{what}: {shown(text)}: cannot read the unit; write it as kg*m^2, N*m or rad/s")
        operator, symbol, power, superscript = factor.groups()
        exponent = int(power or _SUPERSCRIPT.get(superscript, 1))
        product = _times(product, _known(symbol, text, what), -exponent if operator == "/" else exponent)
        position = factor.end()
    return product


def _known(symbol: str, text: str, what: object) -> _Unit:
    symbol = symbol.replace("µ", "u").replace("μ", "u")
    if symbol not in _UNITS:
        word = symbol.lower().removesuffix("s")
        near = f"; did you mean {_WORDS[word]!r}?" if word in _WORDS else did_you_mean(symbol, _UNITS)
        raise UnitsError(f"{what}: {shown(text)}: unknown unit {shown(symbol)}{near} (known: {listed(_UNITS)})")
    return _UNITS[symbol]


def _times(a: _Unit, b: _Unit, exponent: int) -> _Unit:
    top, bottom = (b.numerator, b.denominator) if exponent > 0 else (b.denominator, b.numerator)
    m, kg, s, rad = (x + exponent * y for x, y in zip(a.powers, b.powers, strict=True))
    return _Unit(a.numerator * top ** abs(exponent), a.denominator * bottom ** abs(exponent), (m, kg, s, rad))


def _kind(powers: Powers) -> str:
    for dimension, (known, _) in _DIMENSIONS.items():
        if known == powers:
            return _article(dimension)
    return "a quantity of another kind"


def _article(dimension: Dimension) -> str:
    return f"{'an' if dimension[0] in 'aeiou' else 'a'} {dimension}"


def _example(dimension: Dimension) -> str:
    examples: dict[Dimension, str] = {"angle": "75 deg", "mass": "494 g", "length": "13 mm"}
    return examples.get(dimension, f"0.5 {_DIMENSIONS[dimension][1]}")
