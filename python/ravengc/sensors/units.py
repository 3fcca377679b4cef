"""What sensors send, to SI, and their axes to others: exact factors, and turns that only swap and negate."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ravengc import STANDARD_GRAVITY
from ravengc._convert import check_choice
from ravengc.errors import ConfigError
from ravengc.inertial_units import ACCELERATION_UNITS, RATE_UNITS
from ravengc.messages import shown

if TYPE_CHECKING:
    from ravengc.sensors.sample import Triple

__all__ = [
    "ACCELERATION_UNITS",
    "AXES",
    "NEAR",
    "RATE_UNITS",
    "SENDS",
    "Axes",
    "acceleration_factor",
    "mistaken_unit",
    "parse_axes",
]

NEAR = 0.06
"""How close to the size that a wrong unit would give a norm has to be, relative."""
SENDS = {"specific_force": 1.0, "gravity": -1.0}
"""What the numbers are: f = a - g, +9.81 along up at rest, or the gravity vector, which is -f at rest."""


class Axes(NamedTuple):
    """New axes in terms of the sensor's: entry i of the turned vector is ``signs[i] * vector[order[i]]``."""

    order: tuple[int, int, int] = (0, 1, 2)
    signs: Triple = (1.0, 1.0, 1.0)

    def turn(self, vector: Triple) -> Triple:
        """The vector in the new axes."""
        (i, j, k), (a, b, c) = self.order, self.signs
        return (a * vector[i], b * vector[j], c * vector[k])


AXES = Axes()


def acceleration_factor(unit: str, sends: str = "specific_force") -> float:
    """What to multiply by to get specific force in m/s^2; ConfigError for an unknown unit or sign convention."""
    check_choice(unit, ACCELERATION_UNITS, "unit")
    check_choice(sends, SENDS, "sends")
    return ACCELERATION_UNITS[unit] * SENDS[sends]


def mistaken_unit(norm: float, declared: str = "") -> tuple[str, str] | None:
    """Which unit was declared and which was sent, if that is why gravity has this norm (m/s^2); None if it is not.

    ``declared`` is the unit that is known to be declared, if it is.
    """
    ratio = norm / STANDARD_GRAVITY
    wrong = {
        (taken, sent): ACCELERATION_UNITS[taken] / ACCELERATION_UNITS[sent]
        for taken in ACCELERATION_UNITS
        for sent in ACCELERATION_UNITS
        if declared in ("", taken)
    }
    near = min(wrong, key=lambda pair: abs(ratio / wrong[pair] - 1.0))
    is_right = abs(wrong[near] - 1.0) <= NEAR
    return near if abs(ratio / wrong[near] - 1.0) <= NEAR and not is_right else None


def parse_axes(text: str) -> Axes:
    """Read axes such as ``x,-y,-z``: which of the sensor's axes, and which way, becomes x, y and z.

    Raises ConfigError for anything else and for a mirror image, which no mounting can be.
    """
    words = [word.strip() for word in text.split(",")]
    names = [word.removeprefix("-") for word in words]
    if sorted(names) != ["x", "y", "z"]:
        raise ConfigError(f"axes {shown(text)}: write each of x, y, z once, with or without '-', such as x,-y,-z")
    first, second, third = ("xyz".index(name) for name in names)
    a, b, c = (-1.0 if word.startswith("-") else 1.0 for word in words)
    order = (first, second, third)
    if _parity(order) * a * b * c < 0.0:
        raise ConfigError(f"axes {shown(text)} are a mirror image (left-handed); no mounting turns a sensor into that")
    return Axes(order, (a, b, c))


def _parity(order: tuple[int, int, int]) -> float:
    return 1.0 if order in {(0, 1, 2), (1, 2, 0), (2, 0, 1)} else -1.0
