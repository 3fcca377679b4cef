"""Disturbance elements from the ``[[disturbance]]`` tables of a robot file.

::

    [[disturbance]]
    kind = "cable"                 # polynomial, cable, linear_spring, spring, friction, constant, harmonic
    name = "cable of the elbow"
    joint = "elbow"                # or a number for every coordinate
    knots = ["3 deg"]
    pieces = [[-0.07, 0.1], [0.0]] # N·m, N·m/rad: powers of the distance from the knot
"""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any

from ravengc.config.couplings import kinds_of_coordinates
from ravengc.config.disturbance_rules import BLENDS, DIRECTIONS
from ravengc.config.fields import Table, read_vector
from ravengc.disturbances import KINDS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from ravengc.disturbances import Along, Disturbance
    from ravengc.spec import JointKind, RobotSpec
    from ravengc.units import Dimension

__all__ = ["DISTURBANCE_KEYS", "read_disturbance"]

DISTURBANCE_KEYS = tuple(dict.fromkeys(("kind", *(field.name for kind in KINDS.values() for field in fields(kind)))))

CHOICES = {"direction": DIRECTIONS, "blend": BLENDS}
LISTS = {"coefficients": "number", "range": "position", "knots": "position"}

NUMBERS = {
    "dead_band": "rate",
    "saturation": "rate",
    "stribeck_velocity": "rate",
    "rest": "position",
    "ratio": "number",
    "order": "number",
    "coulomb": "effort",
    "stribeck": "effort",
    "torque": "effort",
    "cosine": "effort",
    "sine": "effort",
    "viscous": "damping",
    "stiffness": "stiffness",
    "rest_length": "position",
}
"""What a field measures; which unit that is depends on the joint."""

TURNING: Mapping[str, Dimension] = {
    "position": "angle",
    "rate": "angular velocity",
    "effort": "torque",
    "damping": "angular damping",
    "stiffness": "angular stiffness",
}
SLIDING: Mapping[str, Dimension] = {
    "position": "length",
    "rate": "velocity",
    "effort": "force",
    "damping": "damping",
    "stiffness": "stiffness",
}


def read_disturbance(table: Table, spec: RobotSpec) -> Disturbance:
    """Return one element of a robot; whether it fits the robot is a question for ``validate``."""
    kind = table.choice("kind", tuple(KINDS))
    of_kind = KINDS[kind]
    known = fields(of_kind)
    table = table.limited(("kind", *(field.name for field in known)))
    for field in known:
        if field.default is MISSING and field.name not in table:
            raise table.complaint(field.name, f"a value, as every element of kind '{kind}' has one")
    units = _units(table, kind, spec)
    element: Disturbance = of_kind(
        **{field.name: _read(table, field.name, units) for field in known if field.name in table}
    )
    return element


def _read(table: Table, name: str, units: Mapping[str, Dimension]) -> Any:
    if name in NUMBERS:
        return table.number(name, units.get(NUMBERS[name], "number"))
    if name in LISTS:
        return table.numbers(name, units.get(LISTS[name], "number"))
    if name in CHOICES:
        return table.choice(name, CHOICES[name])
    return OTHERS.get(name, Table.text)(table, name)


def _read_along(table: Table, name: str) -> Along:
    return table.text(name) if table.is_text(name) else table.numbers(name, "number")


OTHERS: Mapping[str, Callable[[Table, str], Any]] = {
    "joint": _read_along,
    "of": _read_along,
    "pieces": Table.matrix,
    "point_a": read_vector,
    "point_b": read_vector,
}


def _units(table: Table, kind: str, spec: RobotSpec) -> Mapping[str, Dimension]:
    """Units of an element: those of the coordinates it reads and acts on, where these are all of one sort."""
    if kind == "spring":
        return SLIDING
    moved = {_sort(_read_along(table, key), spec) for key in ("joint", "of") if key in table}
    return {"revolute": TURNING, "prismatic": SLIDING}.get(str(moved.pop()), {}) if len(moved) == 1 else {}


def _sort(along: Along, spec: RobotSpec) -> JointKind | None:
    """What all coordinates of a direction are, or None where they differ or are not there."""
    names, kinds = spec.coordinate_names, kinds_of_coordinates(spec)
    if isinstance(along, str):
        return kinds[names.index(along)] if along in names else None
    used = {kind for kind, share in zip(kinds, along, strict=False) if share != 0.0}
    return used.pop() if len(used) == 1 else None
