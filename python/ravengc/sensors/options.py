"""Values of the keys in a sensor's address, from text: each reader returns what it means, or raises ConfigError."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ravengc._convert import check_choice
from ravengc.errors import ConfigError, UnitsError
from ravengc.messages import shown
from ravengc.units import to_si

if TYPE_CHECKING:
    from collections.abc import Collection

    from ravengc.units import Dimension

__all__ = ["Reader", "choice", "quantity", "read_baud", "read_flag", "read_text", "read_triple", "read_whole"]

Reader = Callable[[str], Any]


def quantity(dimension: Dimension, *, infinite: bool = False) -> Callable[[str], float]:
    """A reader of numbers, SI, or with a unit: ``0.02`` or ``20ms``."""

    def read(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            try:
                return to_si(text, dimension)
            except UnitsError as error:
                raise ConfigError(str(error).removeprefix("value: ")) from None
        if math.isnan(number) or (math.isinf(number) and not infinite):
            raise ConfigError(f"got {shown(text)}, expected a finite number")
        return number

    return read


def choice(options: Collection[str]) -> Callable[[str], str]:
    """A reader of one of these texts."""

    def read(text: str) -> str:
        check_choice(text, options, "value")
        return text

    return read


def read_flag(text: str) -> bool:
    """Yes or no."""
    flags = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}
    if text.lower() not in flags:
        raise ConfigError(f"got {shown(text)}, expected yes or no")
    return flags[text.lower()]


def read_whole(text: str) -> int:
    """A whole number from 0."""
    if not (text.isascii() and text.isdecimal() and len(text) <= 18):
        raise ConfigError(f"got {shown(text)}, expected a whole number from 0")
    return int(text)


def read_triple(text: str) -> tuple[float, ...]:
    """Three numbers with commas between them."""
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ConfigError(f"got {shown(text)}, expected three numbers: x,y,z")
    return numbers


def read_text(text: str) -> str:
    """Any text but an empty one."""
    if not text:
        raise ConfigError("got nothing, expected a text")
    return text


def read_baud(text: str) -> int:
    """A rate that serial ports have."""
    from ravengc.sensors.links import BAUD_RATES

    check_choice(text, [str(rate) for rate in BAUD_RATES], "baud")
    return int(text)
