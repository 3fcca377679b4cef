"""Typed questions to one table of a robot file or one row of a DH list: an answer, or an error that names the place."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ravengc.config.locate import Place
from ravengc.config.physical import check_angle
from ravengc.config.rotations import rotation_from_rpy
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.spec import IDENTITY, ZERO, JointKind, JointLimits, Matrix, Vector
from ravengc.units import Dimension, to_si_vector

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

__all__ = ["POSITION", "Table", "read_limits", "read_rotation", "read_vector"]

MOST_ROWS = 64
"""No matrix of a robot has more rows."""

POSITION: Mapping[JointKind, Dimension] = {"revolute": "angle", "prismatic": "length", "fixed": "angle"}
"""What a joint's coordinate measures."""

_VELOCITY: Mapping[JointKind, Dimension] = {
    "revolute": "angular velocity",
    "prismatic": "velocity",
    "fixed": "angular velocity",
}
_EFFORT: Mapping[JointKind, Dimension] = {"revolute": "torque", "prismatic": "force", "fixed": "torque"}


class Table:
    """Named values at a place of a document. A key that is not in ``keys`` is a ConfigError, with the nearest one."""

    def __init__(self, data: object, place: Place, keys: Iterable[str]) -> None:
        self.place = place
        if not isinstance(data, Mapping):
            raise ConfigError(f"{place}: got {shown(data)}, expected a table of keys and values")
        self._data: Mapping[str, object] = data
        known = tuple(keys)
        for key in data:
            if key not in known:
                near = did_you_mean(key, known)
                raise ConfigError(f"{place.on_line_of(key)}: unknown key {shown(key)}{near} (known: {listed(known)})")

    def __contains__(self, key: object) -> bool:
        """Tell whether the key is there."""
        return key in self._data

    def limited(self, keys: Iterable[str]) -> Table:
        """Return the same table with fewer keys that it may have."""
        return Table(self._data, self.place, keys)

    def complaint(self, key: str, expected: str) -> ConfigError:
        """Return the error that says what stands at ``key`` and what was expected there."""
        if key not in self._data:
            return ConfigError(f"{self.place}: {key!r} is missing, expected {expected}")
        return ConfigError(f"{self.place.at(key)}: got {shown(self._data[key])}, expected {expected}")

    def names(self) -> tuple[str, ...]:
        """Return the keys that are there, in order."""
        return tuple(self._data)

    def raw(self, flags: Iterable[str] = ()) -> dict[str, Any]:
        """Return everything as it was read: texts, numbers, and lists of them; of ``flags``, true or false."""
        known = tuple(flags)
        for key, value in self._data.items():
            if key in known:
                self.flag(key)
            elif not _is_plain(value):
                raise self.complaint(key, "a text, a number, or a list of them")
        return dict(self._data)

    def text(self, key: str, default: str | None = "") -> str:
        """Return a text; without default (``None``) it must be there."""
        value = self._data.get(key, default)
        if not isinstance(value, str):
            raise self.complaint(key, "a text in quotes")
        return value

    def is_text(self, key: str) -> bool:
        """Tell whether a text stands at ``key``."""
        return isinstance(self._data.get(key), str)

    def choice(self, key: str, options: Sequence[str], default: str | None = None) -> str:
        """Return one of the texts in ``options``."""
        value = self._data.get(key, default)
        if not isinstance(value, str) or value not in options:
            raise self.complaint(key, f"one of {listed(options)}{did_you_mean(value, options)}")
        return value

    def flag(self, key: str, *, default: bool = False) -> bool:
        """Return true or false."""
        value = self._data.get(key, default)
        if not isinstance(value, bool):
            raise self.complaint(key, "true or false")
        return value

    def number(self, key: str, dimension: Dimension, default: float = 0.0) -> float:
        """Return one quantity in SI."""
        found = self.optional_number(key, dimension)
        return default if found is None else found

    def optional_number(self, key: str, dimension: Dimension) -> float | None:
        """Return one quantity in SI, or None where the key is not given."""
        return _quantities([self._data[key]], [dimension], self.place.at(key))[0] if key in self else None

    def vector(self, key: str, dimensions: Sequence[Dimension]) -> tuple[float, ...]:
        """Return as many quantities in SI as there are dimensions; all with a unit or all without."""
        what = ", ".join(dict.fromkeys(dimensions))
        expected = f"{len(dimensions)} numbers" if what == "number" else f"{len(dimensions)} numbers ({what})"
        values = self._entries(key, expected)
        if len(values) != len(dimensions):
            raise self.complaint(key, f"{expected}, not {len(values)}")
        return _quantities(values, dimensions, self.place.at(key))

    def numbers(self, key: str, dimension: Dimension) -> tuple[float, ...]:
        """Return a list of quantities in SI, of any length; all with a unit or all without."""
        values = self._entries(key, f"a list of numbers ({dimension})")
        if len(values) > MOST_ROWS:
            raise self.complaint(key, f"at most {MOST_ROWS} numbers, not {len(values)}")
        return _quantities(values, [dimension] * len(values), self.place.at(key))

    def matrix(self, key: str) -> tuple[tuple[float, ...], ...]:
        """Return rows of plain numbers; how many there must be is the caller's question."""
        rows, found = [], self._entries(key, "a list of rows of numbers")
        if len(found) > MOST_ROWS:
            raise self.complaint(key, f"at most {MOST_ROWS} rows of numbers, not {len(found)}")
        for index, row in enumerate(found):
            place, entries = self.place.at(key, index), _as_list(row)
            if entries is None:
                raise ConfigError(f"{place}: got {shown(row)}, expected a row of numbers")
            rows.append(_quantities(entries, ["number"] * len(entries), place))
        return tuple(rows)

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a list of texts."""
        values = self._entries(key, "a list of texts")
        for index, value in enumerate(values):
            if not isinstance(value, str):
                raise ConfigError(f"{self.place.at(key, index)}: got {shown(value)}, expected a text in quotes")
        return tuple(cast("list[str]", values))

    def table(self, key: str, keys: Iterable[str] | None = None) -> Table:
        """Return the table at ``key``, empty where it is not given; ``keys`` are those it may have (None: any)."""
        data = self._data.get(key, {})
        any_key = data if isinstance(data, Mapping) else ()
        place = self.place.at(key) if self.place.path else Place(f"[{key}]", (key,), self.place.where)
        return Table(data, place, any_key if keys is None else keys)

    def tables(self, key: str, keys: Iterable[str], label: str) -> list[Table]:
        """Return the tables of a list, none where it is not given; label, number (from 1) and name tell them apart."""
        known = tuple(keys)
        values = self._entries(key, "a list of tables") if key in self else []
        return [Table(value, self._entry(key, index, value, label), known) for index, value in enumerate(values)]

    def _entry(self, key: str, index: int, value: object, label: str) -> Place:
        name = value.get("name") if isinstance(value, Mapping) else None
        full = f"{label} {index + 1} {shown(name)}" if isinstance(name, str) else f"{label} {index + 1}"
        return Place(full, (*self.place.path, key, index), self.place.where)

    def _entries(self, key: str, expected: str) -> list[object]:
        values = _as_list(self._data.get(key))
        if values is None:
            raise self.complaint(key, expected)
        return values


def read_vector(table: Table, key: str, default: Vector = ZERO) -> Vector:
    """Return three lengths (m)."""
    if key not in table:
        return default
    x, y, z = table.vector(key, ("length",) * 3)
    return (x, y, z)


def read_rotation(table: Table) -> Matrix:
    """Return ``rotation`` (three rows) or ``rpy`` (roll, pitch, yaw about fixed x, y, z), no rotation by default."""
    if "rpy" in table:
        if "rotation" in table:
            raise table.complaint("rpy", "either 'rotation' or 'rpy', not both")
        angles = table.vector("rpy", ("angle",) * 3)
        for index, angle in enumerate(angles):
            check_angle(angle, table.place.at("rpy", index))
        return rotation_from_rpy(*angles)
    if "rotation" not in table:
        return IDENTITY
    rows = table.matrix("rotation")
    if [len(row) for row in rows] != [3, 3, 3]:
        raise table.complaint("rotation", "three rows of three numbers")
    return cast("Matrix", rows)


def read_limits(table: Table, joint: JointKind) -> JointLimits:
    """Return ``{lower, upper, velocity, effort}`` in the units of the joint."""
    if len({table.is_text(key) for key in ("lower", "upper") if key in table}) > 1:
        raise table.complaint("lower", "'lower' and 'upper' both with a unit or both without (then SI)")
    return JointLimits(
        lower=table.optional_number("lower", POSITION[joint]),
        upper=table.optional_number("upper", POSITION[joint]),
        velocity=table.optional_number("velocity", _VELOCITY[joint]),
        effort=table.optional_number("effort", _EFFORT[joint]),
    )


def _quantities(values: Sequence[object], dimensions: Sequence[Dimension], place: Place) -> tuple[float, ...]:
    for index, value in enumerate(values):
        if isinstance(value, bool) or not isinstance(value, (Real, str)) or _is_not_finite(value):
            unit = "" if dimensions[index] == "number" else ", or a text with a unit"
            entry = place.at(index) if len(values) > 1 else place
            raise ConfigError(f"{entry}: got {shown(value)}, expected a finite number{unit}")
    return to_si_vector(values, dimensions, place)


def _as_list(value: object) -> list[object] | None:
    """Return the entries of a list, a tuple or an array; None for anything else."""
    if isinstance(value, (list, tuple)):
        return list(value)
    return list(value) if isinstance(value, np.ndarray) and value.ndim > 0 else None


def _is_not_finite(value: object) -> bool:
    return isinstance(value, float) and value - value != 0.0


def _is_plain(value: object, depth: int = 3) -> bool:
    if isinstance(value, list):
        return depth > 0 and all(_is_plain(entry, depth - 1) for entry in value)
    return isinstance(value, (str, int, float)) and not isinstance(value, bool)
