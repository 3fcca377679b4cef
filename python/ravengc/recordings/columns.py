"""Which column of a table is what, told from its name.

===============  ===========================================================================================
quantity         names (case does not matter)
===============  ===========================================================================================
time             t, time, stamp, timestamp, sec, seconds; a unit may follow: time_ms, stamp_ns, "t [us]"
positions        q, pos, position, angle
velocities       qd, dq, qdot, vel, velocity
accelerations    qdd, ddq, qddot, acc, acceleration
torques          tau, effort, torque, trq
===============  ===========================================================================================

A joint follows or precedes the quantity: ``q1``, ``q_1``, ``q[0]``, ``position.elbow``, ``elbow_position``,
``/joint_states/elbow/position``; behind the last ``/`` of a name stands the quantity alone. Numbered columns are put in
order and win over named ones; named columns keep the order of the positions. A unit may follow in brackets or after an
underscore: ``q1 [deg]``, ``q3_mm``. A one-joint robot needs no number: ``t,q,tau``. Those of the base are in
:mod:`ravengc.recordings.base_columns`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ravengc.errors import ParseError
from ravengc.messages import shown
from ravengc.recordings.base_columns import base_columns

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["KEYS", "Column", "Layout", "layout_of"]

KEYS: Mapping[str, tuple[str, ...]] = {
    "t": ("t", "time", "time_s", "__time", "stamp", "timestamp", "sec", "seconds"),
    "q": ("q", "pos", "position", "positions", "angle", "angles"),
    "qd": ("qd", "dq", "qdot", "vel", "velocity", "velocities"),
    "qdd": ("qdd", "ddq", "qddot", "acc", "acceleration", "accelerations"),
    "tau": ("tau", "effort", "efforts", "torque", "torques", "trq"),
}
DEGREE = 0.017453292519943295
UNITS: Mapping[str, Mapping[str, float]] = {
    "t": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9},
    "q": {"rad": 1.0, "deg": DEGREE, "m": 1.0, "mm": 1e-3},
    "qd": {"rad/s": 1.0, "deg/s": DEGREE, "m/s": 1.0, "mm/s": 1e-3},
    "qdd": {"rad/s^2": 1.0, "rad/s2": 1.0, "deg/s^2": DEGREE, "deg/s2": DEGREE, "m/s^2": 1.0, "m/s2": 1.0},
    "tau": {"nm": 1.0, "n m": 1.0, "n·m": 1.0, "n*m": 1.0, "n": 1.0, "mnm": 1e-3, "nmm": 1e-3},
}
ALL_UNITS = frozenset(unit for known in UNITS.values() for unit in known)
ROLE_OF = {name: role for role, names in KEYS.items() for name in names}
ROLE = "|".join(sorted((name for name, role in ROLE_OF.items() if role != "t"), key=len, reverse=True))
NUMBERED = re.compile(rf"(?P<role>{ROLE})[\s_.:/\-]*\[?(?P<key>\d+)\]?", re.IGNORECASE)
PATH = re.compile(rf"(?P<key>.+)/(?P<role>{ROLE})", re.IGNORECASE)
ROLE_FIRST = re.compile(rf"(?P<role>{ROLE})[\s_.:\-\[]+(?P<key>[^/]+?)\]?", re.IGNORECASE)
NAME_FIRST = re.compile(rf"(?P<key>[^/]+?)[\s_.:\-]+(?P<role>{ROLE})", re.IGNORECASE)
BRACKETED_UNIT = re.compile(r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\d\])][^\])]*?)\s*[\])]")
SUFFIX_UNIT = re.compile(r"(?P<name>.+)_(?P<unit>s|ms|us|ns|rad|deg|m|mm)", re.IGNORECASE)
AXES = frozenset("xyz")
"""Joints that are called so have positions; else it is a sensor that has these axes."""
LONGEST_NAME = 200
"""Longer cells are no names; the patterns above would take very long over them."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column that was understood: its place (from 0), its quantity, its joint, and the factor to SI."""

    place: int
    role: str
    key: str
    scale: float


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of every quantity, in the order of the joints or x, y, z, and the unused names."""

    time: Column | None
    roles: Mapping[str, tuple[Column, ...]]
    names: tuple[str, ...]
    ignored: tuple[str, ...]

    @property
    def used(self) -> tuple[Column, ...]:
        """All columns that hold numbers to read: time first, then positions and the rest."""
        first = (self.time,) if self.time else ()
        return first + tuple(column for columns in self.roles.values() for column in columns)


def layout_of(cells: Sequence[str], *, file: str, line: int = 1) -> Layout:
    """The layout of a table with these column names.

    Raises ParseError for columns given twice, a joint without its number, and quantities for different joints.
    """
    columns = [column for place, cell in enumerate(cells) if (column := _column(cell, place, file=file, line=line))]
    times = [column for column in columns if column.role == "t"]
    numbered = any(column.role == "q" and column.key.isdecimal() for column in columns)
    named = {column.key for column in columns if column.role == "q"} | {"1"}
    of_joints = [column for column in columns if column.key not in AXES or column.key in named]
    chosen = [column for column in of_joints if column.role != "t" and column.key.isdecimal() == numbered]
    _refuse_twice([*times, *chosen], cells, file=file, line=line)
    roles = {role: found for role in ("q", "qd", "qdd", "tau") if (found := _in_role(chosen, role))}
    if "q" not in roles:
        raise ParseError(f"no position columns among {_listed(cells)}; expected {EXPECTED}", file=file, line=line)
    keys = tuple(column.key for column in roles["q"])
    if numbered:
        _check_numbering([int(key) for key in keys], file=file, line=line)
    ordered = {role: _for_joints(found, keys, role, file=file, line=line) for role, found in roles.items()}
    taken = {column.place for column in (*times, *chosen)}
    base = _of_the_base(["" if place in taken else cell for place, cell in enumerate(cells)], file=file, line=line)
    used = {column.place for columns in (times, chosen, *base.values()) for column in columns}
    ignored = tuple(cell.strip() for place, cell in enumerate(cells) if place not in used and cell.strip())
    return Layout(times[0] if times else None, {**ordered, **base}, () if numbered else keys, ignored)


EXPECTED = "a header such as t,q1,q2,dq1,dq2,tau1,tau2 or time,elbow_position,elbow_effort"


def _column(cell: str, place: int, *, file: str, line: int) -> Column | None:
    found = _role_key_unit(cell.strip().strip("\"'").strip())
    if found is None:
        return None
    role, key, unit = found
    number = str(int(key)) if key.isdecimal() else key
    return Column(place, role, number, _scale(role, unit, cell, file=file, line=line, column=place + 1))


def _role_key_unit(text: str) -> tuple[str, str, str] | None:
    if len(text) > LONGEST_NAME:
        return None
    if path := PATH.fullmatch(text):  # a joint's name may end as a unit does
        return ROLE_OF[path["role"].lower()], path["key"].strip("/ "), ""
    bracketed = BRACKETED_UNIT.fullmatch(text)
    if bracketed and bracketed["unit"].lower() in ALL_UNITS:
        return _with_unit(bracketed)
    if found := _role_and_key(text):
        suffixed = SUFFIX_UNIT.fullmatch(found[1])
        return (found[0], suffixed["name"], suffixed["unit"]) if suffixed else (*found, "")
    unit = bracketed or SUFFIX_UNIT.fullmatch(text)
    return _with_unit(unit) if unit else None


def _with_unit(match: re.Match[str]) -> tuple[str, str, str] | None:
    found = _role_and_key(match["name"])
    return (*found, match["unit"]) if found else None


def _role_and_key(name: str) -> tuple[str, str] | None:
    if ROLE_OF.get(name.lower()) == "t":
        return "t", ""
    if role := ROLE_OF.get(name.lower()):
        return role, "1"
    for pattern in (NUMBERED, PATH, ROLE_FIRST, NAME_FIRST):
        if match := pattern.fullmatch(name):
            return ROLE_OF[match["role"].lower()], match["key"].strip("/ ")
    return None


def _of_the_base(cells: Sequence[str], *, file: str, line: int) -> dict[str, tuple[Column, ...]]:
    return {
        quantity: tuple(Column(one.place, quantity, axis, one.factor) for axis, one in zip("xyz", three, strict=True))
        for quantity, three in base_columns(cells, file=file, line=line).items()
    }


def _scale(role: str, unit: str, cell: str, *, file: str, line: int, column: int) -> float:
    known = UNITS[role]
    if not unit:
        return 1.0
    if unit.lower() not in known:
        message = f"unknown unit '{unit}' in column '{cell.strip()}'; expected one of {', '.join(known)}"
        raise ParseError(message, file=file, line=line, column=column)
    return known[unit.lower()]


def _in_role(columns: Sequence[Column], role: str) -> tuple[Column, ...]:
    found = [column for column in columns if column.role == role]
    if found and found[0].key.isdecimal():
        found.sort(key=lambda column: int(column.key))
    return tuple(found)


def _refuse_twice(columns: Sequence[Column], cells: Sequence[str], *, file: str, line: int) -> None:
    seen: dict[tuple[str, str], int] = {}
    for column in columns:
        key = (column.role, column.key)
        if key in seen:
            both = f"'{cells[seen[key]].strip()}' and '{cells[column.place].strip()}'"
            message = f"two columns for the same quantity: {both}; remove or rename one"
            raise ParseError(message, file=file, line=line, column=column.place + 1)
        seen[key] = column.place


def _for_joints(
    columns: Sequence[Column], keys: Sequence[str], role: str, *, file: str, line: int
) -> tuple[Column, ...]:
    """The columns of one quantity in the order of the joints ``keys``; every joint must have one."""
    found = {column.key: column for column in columns}
    if missing := [key for key in keys if key not in found]:
        message = f"{role} has no column for joint {', '.join(missing)}; expected {len(keys)} joints as for q"
        raise ParseError(message, file=file, line=line)
    if extra := [key for key in found if key not in keys]:
        raise ParseError(f"{role} has columns for {', '.join(extra)}, but q has none", file=file, line=line)
    return tuple(found[key] for key in keys)


def _check_numbering(numbers: Sequence[int], *, file: str, line: int) -> None:
    expected = list(range(numbers[0], numbers[0] + len(numbers)))
    if numbers[0] in (0, 1) and list(numbers) == expected:
        return
    message = f"position columns are numbered {shown(list(numbers))}; expected 1, 2, 3 ... or 0, 1, 2 ... without a gap"
    raise ParseError(message, file=file, line=line)


def _listed(cells: Sequence[str]) -> str:
    first = ", ".join(cell.strip()[:LONGEST_NAME] for cell in cells[:12])
    return f"'{first}'" + (f" and {len(cells) - 12} more" if len(cells) > 12 else "")
