"""Settings of an experiment: a frozen dataclass whose fields carry a default, a unit and the range they may have.

Values are in the unit that the field states (``tilt_deg`` in degrees). A file or a sweep gives them as plain numbers,
texts, flags, or lists of numbers; one number where a list is expected is a list of one.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any, TypeVar

from ravengc._convert import check_type
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown

__all__ = ["Settings", "setting", "settings_from", "settings_table"]

MOST = 64
"""No list of a setting is longer."""

S = TypeVar("S", bound="Settings")


def setting(
    default: Any,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
    doc: str = "",
    *,
    count: int | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """Describe one field of a :class:`Settings` class: its default, the range of it (of every entry of a list), unit.

    ``count`` is the length that a list must have (None: one to 64 entries); ``choices`` are the texts that a text may
    be. The kind of the value (flag, whole number, number, text, list) is that of the default.
    """
    described = {"low": low, "high": high, "unit": unit, "doc": doc, "count": count, "choices": choices}
    return dataclasses.field(default=default, metadata=described)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Settings:
    """Base of all settings: a value of the wrong kind or out of its range is a ConfigError, whoever builds it."""

    def __post_init__(self) -> None:
        """Check every field, and turn whole numbers into floats and lists into tuples where that is the field's kind.

        Raises ConfigError with the key, the value and the allowed range.
        """
        for field in dataclasses.fields(self):
            object.__setattr__(self, field.name, _checked(field, getattr(self, field.name)))
        self.check()

    def check(self) -> None:
        """Raise ConfigError where values that are each in range do not fit together; overridden where that can be."""


def settings_from(cls: type[S], table: Mapping[str, object], where: str = "settings") -> S:
    """Build the settings of an experiment from a table of a file or the draw of a sweep, defaults for what is absent.

    Raises ConfigError, with ``where`` in front, for an unknown key (the near one is suggested) and for a value that is
    of the wrong kind or outside its range (the key and the range are named).
    """
    check_type(cls, type, "cls")
    check_type(table, Mapping, "table")
    known = {field.name for field in dataclasses.fields(cls)}
    for key in table:
        if key not in known:
            near = did_you_mean(key, known)
            raise ConfigError(f"{where}: unknown key {shown(key)}{near} (known: {listed(sorted(known))})")
    try:
        return cls(**dict(table))
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from None


def settings_table(settings: Settings) -> list[tuple[str, Any, str, str, str]]:
    """Return one row per setting: key, value, unit, allowed range, what it is."""
    check_type(settings, Settings, "settings")
    return [
        (field.name, getattr(settings, field.name), field.metadata["unit"], _range(field), field.metadata["doc"])
        for field in dataclasses.fields(settings)
    ]


def _checked(field: dataclasses.Field[Any], value: object) -> object:
    if isinstance(field.default, tuple):
        entries = tuple(value) if isinstance(value, (list, tuple)) else (value,)
        count = field.metadata["count"]
        if len(entries) != count if count else not 1 <= len(entries) <= MOST:
            raise ConfigError(f"{field.name} is {shown(value)}; expected {count or f'1 to {MOST}'} values")
        return tuple(_entry(field, field.default[0], entry) for entry in entries)
    return _entry(field, field.default, value)


def _entry(field: dataclasses.Field[Any], like: object, value: object) -> object:
    """One value, of the kind of ``like`` and in the field's range."""
    fits = {
        bool: isinstance(value, bool),
        int: isinstance(value, Integral) and not isinstance(value, bool),
        float: isinstance(value, Real) and not isinstance(value, bool),
        str: isinstance(value, str) and value in field.metadata["choices"],
    }[type(like)]
    low, high = field.metadata["low"], field.metadata["high"]
    outside = isinstance(value, Real) and not ((low is None or value >= low) and (high is None or value <= high))
    if not fits or outside:
        near = did_you_mean(value, field.metadata["choices"])
        raise ConfigError(f"{field.name} is {shown(value)}; expected {_range(field)}{near}")
    return type(like)(value)  # type: ignore[call-arg]


def _range(field: dataclasses.Field[Any]) -> str:
    """The values that a field may have, in words."""
    like = field.default[0] if isinstance(field.default, tuple) else field.default
    if isinstance(like, bool):
        return "true or false"
    if isinstance(like, str):
        return f"one of {listed(field.metadata['choices'])}"
    kind = "a whole number" if isinstance(like, int) else "a number"
    unit = f" {field.metadata['unit']}" if field.metadata["unit"] else ""
    each = f"{field.metadata['count'] or 'a list'} of: " if isinstance(field.default, tuple) else ""
    return f"{each}{kind} from {field.metadata['low']:g} to {field.metadata['high']:g}{unit}"
