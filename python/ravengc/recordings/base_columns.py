"""Which columns of a table say what the base did: its gravity field or specific force, and its angular velocity.

================  ==========================================================================================
quantity          names (case does not matter), each with x y z behind it, or 0 1 2
================  ==========================================================================================
gravity           gx gy gz, gravity_x gravity_y gravity_z (base axes, m/s²)
specific force    ax ay az, acc_x ..., accelerometer_x ..., specific_force_x ..., linear_acceleration_x ...: what an
                  accelerometer reads, which is gravity with the other sign
angular velocity  wx wy wz, omega_x ..., gyro_x ..., angular_velocity_x ... (base axes, rad/s); gx gy gz beside
                  columns of gravity or specific force, or in deg/s, are a gyroscope's too
================  ==========================================================================================

A unit may follow in brackets: ``ax [g]``, ``gyro_x (deg/s)``.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from ravengc.errors import ParseError
from ravengc.inertial_units import ACCELERATION_UNITS, RATE_UNITS, name_and_unit
from ravengc.messages import listed

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["AxisColumn", "base_columns"]

GRAVITY = re.compile(r"gravity[\s_.\[]*(?P<axis>[xyz012])\]?", re.IGNORECASE)
FORCE = re.compile(
    r"(?:a|acc|accel|accelerometer|acceleration|specific[\s_]force|linear[\s_]acceleration)[\s_.\[]*(?P<axis>[xyz])\]?",
    re.IGNORECASE,
)
RATE = re.compile(
    r"(?:w|omega|gyr|gyro|gyroscope|angular[\s_](?:velocity|rate))[\s_.\[]*(?P<axis>[xyz012])\]?", re.IGNORECASE
)
EITHER = re.compile(r"g(?P<axis>[xyz012])", re.IGNORECASE)
UNITS = {**ACCELERATION_UNITS, **RATE_UNITS}
LONGEST = 200
"""Longer cells are no names."""


class AxisColumn(NamedTuple):
    """Where a component stands in a row, and the factor that makes it gravity in m/s², or a rate in rad/s."""

    place: int
    factor: float


def base_columns(cells: Sequence[str], *, file: str, line: int | None = 1) -> dict[str, tuple[AxisColumn, ...]]:
    """Columns of ``gravity`` and ``angular_velocity`` in the order x, y, z, where there are any.

    Raises ParseError for a unit that is none of theirs, and for two axes without the third.
    """
    named = {place: _name_and_unit(cell.strip()) for place, cell in enumerate(cells) if len(cell) <= LONGEST}
    table = _Names(named, file, line)
    gravity = table.three(GRAVITY, ACCELERATION_UNITS) or table.three(FORCE, ACCELERATION_UNITS, sign=-1.0)
    rate = table.three(RATE, RATE_UNITS)
    if either := table.three(EITHER, RATE_UNITS if gravity else ACCELERATION_UNITS):
        gravity, rate = (gravity, rate or either) if gravity else (either, rate)
    elif not rate:
        rate = table.three(EITHER, RATE_UNITS)
    found = {"gravity": gravity, "angular_velocity": rate}
    return {quantity: columns for quantity, columns in found.items() if columns}


def _name_and_unit(cell: str) -> tuple[str, str]:
    """Those of the cell, where what is in brackets is no axis."""
    name, unit = name_and_unit(cell)
    return (cell, "") if unit.lower() in {*"xyz012"} else (name, unit)


class _Names(NamedTuple):
    """Names and units of the columns by their places."""

    named: Mapping[int, tuple[str, str]]
    file: str
    line: int | None

    def three(self, names: re.Pattern[str], units: Mapping[str, float], *, sign: float = 1.0) -> tuple[AxisColumn, ...]:
        """The columns x, y, z that are called so and have one of these units, or none."""
        axes: dict[str, AxisColumn] = {}
        for place, (name, unit) in self.named.items():
            match = names.fullmatch(name)
            if match and self._fits(place, units):
                axes.setdefault(match["axis"].lower(), AxisColumn(place, sign * units.get(unit, 1.0)))
        order = next((order for order in ("xyz", "012") if set(order) <= set(axes)), "")
        if not order and len(axes) > 1:
            self._refuse_two(axes)
        return tuple(axes[axis] for axis in order)

    def _refuse_two(self, axes: Mapping[str, AxisColumn]) -> None:
        """A sensor that lacks an axis is no sensor, and hardly meant."""
        found = ", ".join(self.named[column.place][0] for column in axes.values())
        place = min(column.place for column in axes.values())
        message = f"{found} without the third axis: give all three, or rename these"
        raise ParseError(message, file=self.file, line=self.line, column=place + 1)

    def _fits(self, place: int, units: Mapping[str, float]) -> bool:
        name, unit = self.named[place]
        if unit and unit not in UNITS:
            message = f"unknown unit '{unit}' in column '{name} [{unit}]'; expected one of {listed(UNITS)}"
            raise ParseError(message, file=self.file, line=self.line, column=place + 1)
        return not unit or unit in units
