"""Which column of a table is what: by its name, with the unit that the name states, or by its place."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from ravengc.errors import ParseError
from ravengc.messages import listed, shown
from ravengc.targets.lengths import LENGTH_UNITS

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["TIME_UNITS", "Found", "find_columns", "found_in"]

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
UNITS = {"t": TIME_UNITS, **dict.fromkeys(("x", "y", "z"), LENGTH_UNITS)}
"""Units that a column may state; normals have none."""
ROLES = {
    "t": r"t|time|timestamp|stamp|stamps|elapsed",
    **{axis: rf"{axis}|(?:p|d|pos|position|point|points|disp|displacement)[_. ]?{axis}" for axis in "xyz"},
    **{f"n{axis}": rf"(?:n|normal|normals)[_. ]?{axis}" for axis in "xyz"},
}
ROLE = {role: re.compile(pattern, re.IGNORECASE) for role, pattern in ROLES.items()}
BRACKETS = re.compile(r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\])]*?)\s*[\])]")
SUFFIX = re.compile(r"(?P<name>.+?)[_ ](?P<unit>ns|us|µs|ms|s|mm|cm|m)", re.IGNORECASE)
LONGEST_NAME = 80


class Found(NamedTuple):
    """A column that was understood: its place from 0, and the unit that its name states, "" if none."""

    place: int
    unit: str


def find_columns(names: Sequence[str], file: str) -> dict[str, Found]:
    """Return the columns by role: t, x, y, z, nx, ny, nz, those that are there; ParseError for one given twice."""
    found: dict[str, Found] = {}
    for place, name in enumerate(names):
        role, unit = _role(name[:LONGEST_NAME], file)
        if role in found:
            both = f"{shown(names[found[role].place])} and {shown(name)}"
            raise ParseError(f"two columns for {role}: {both}; remove or rename one", file=file)
        if role:
            found[role] = Found(place, unit)
    return found


def found_in(found: dict[str, Found], file: str) -> str | None:
    """Return the one unit that all the columns x, y and z state, or None; ParseError where they differ."""
    units = {found[axis].unit for axis in "xyz" if axis in found}
    if len(units) > 1:
        raise ParseError(f"columns x, y and z state different units: {listed(sorted(units))}", file=file)
    return (units.pop() if units else "") or None


def _role(name: str, file: str) -> tuple[str, str]:
    plain = _plain_role(name)
    if plain:
        return plain, ""
    match = BRACKETS.fullmatch(name) or SUFFIX.fullmatch(name)
    role = _plain_role(match["name"]) if match else ""
    if not match or not role:
        return "", ""
    unit = match["unit"].lower()
    known = UNITS.get(role, {})
    if unit not in known and known and unit:
        raise ParseError(f"column {shown(name)} is in {shown(unit)}; expected one of {listed(known)}", file=file)
    return role, unit if known else ""


def _plain_role(name: str) -> str:
    return next((role for role, pattern in ROLE.items() if pattern.fullmatch(name.strip())), "")
