"""The unit of lengths in a file: as given, as the file says, or guessed from how large the thing would be, in words."""

from __future__ import annotations

import re

from ravengc._convert import check_choice
from ravengc.errors import ConfigError

__all__ = ["LENGTH_UNITS", "unit_in", "unit_of"]

LENGTH_UNITS = {"m": 1.0, "cm": 0.01, "mm": 1e-3}
UNLIKELY = 10.0
SPELLINGS = {"metre": "m", "meter": "m", "millimetre": "mm", "millimeter": "mm", "centimetre": "cm", "centimeter": "cm"}
OTHERS = ("inch", "inches", "foot", "feet", "ft", "km", "um", "µm", "micron", "microns")
"""Units that a file may state, and that are not read."""
STATED = re.compile(r"\bunits?\b\W*(?:(?:are|is|in)\W+)*(?P<unit>\w+)", re.IGNORECASE)


def unit_of(size: float, given: str | None, stated: str | None, *, what: str, between: tuple[float, float]) -> str:
    """Return the unit of a file in which ``what`` (such as "the cloud's diagonal") measures ``size``, and check it.

    ``given`` is the caller's, ``stated`` the file's; without either a size up to ``between[0]`` is metres, one from
    ``between[1]`` on millimetres. Raises ConfigError where the two contradict each other, between the bounds, for a
    unit that is not read, and for ten times ``between[0]`` metres where the caller has given no unit.
    """
    if stated in OTHERS:
        raise ConfigError(f"{what} is in {stated}, as the file says; expected m, cm or mm")
    if given is not None:
        check_choice(given, LENGTH_UNITS, "units")
        if stated not in (None, given):
            raise ConfigError(f"units are given as {given}, but the file says {stated}; leave them out")
        return given
    low, high = between
    unit = stated or ("m" if size <= low else "mm" if size >= high else None)
    if unit is None:
        raise ConfigError(
            f"{what} measures {size:.4g}, which can be metres or millimetres; say which (units m, cm or mm)"
        )
    if (metres := size * LENGTH_UNITS[unit]) > UNLIKELY * low:
        hint = "remove what is far from the rest, or, if that is right, say the unit (units m, cm or mm)"
        raise ConfigError(f"{what} measures {metres:.4g} m, taken as {unit}; {hint}")
    return unit


def unit_in(text: str) -> str | None:
    """Return the unit of length that a comment such as ``units: mm`` states, or None; also one that is not read."""
    for match in STATED.finditer(text):
        word = match["unit"].lower()
        unit = SPELLINGS.get(word.removesuffix("s"), word)
        if unit in LENGTH_UNITS or unit in OTHERS:
            return unit
    return None
