"""Whether a robot's description holds what its types say, so that its numbers can be looked at.

Files are read field by field and cannot get this wrong; a description made by hand can.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from functools import cache
from numbers import Real
from typing import TYPE_CHECKING, Any, Literal, Union, get_args, get_origin, get_type_hints

from ravengc.errors import ModelError
from ravengc.messages import shown

if TYPE_CHECKING:
    from ravengc.config.locate import Place

__all__ = ["check_kind"]

_WORDS = {
    str: "a text",
    Real: "a number",
    bool: "true or false",
    tuple: "a tuple",
    Mapping: "a table",
    type(None): "None",
}


def check_kind(value: object, hint: Any, place: Place) -> None:
    """Raise ModelError unless ``value`` is what the annotation ``hint`` says, down to the last number."""
    classes = _classes(hint)
    if not isinstance(value, classes) or (isinstance(value, bool) and bool not in classes):
        expected = " or ".join(_WORDS.get(kind, f"a {kind.__name__}") for kind in classes)
        raise ModelError(f"{place}: got {shown(value)}, expected {expected}")
    if is_dataclass(value):
        for name, of_field in _hints(value.__class__).items():
            check_kind(getattr(value, name), of_field, place.at(name))
    elif isinstance(value, tuple):
        entries = next(option for option in (hint, *get_args(hint)) if get_origin(option) is tuple)
        for index, entry in enumerate(value):
            check_kind(entry, get_args(entries)[0], place.at(index))


@cache
def _classes(hint: Any) -> tuple[type, ...]:
    """The classes that an annotation of a description allows."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Literal:
        return (str,)
    if origin in {tuple, Mapping}:
        return (origin,)
    if arguments and origin in {Union, type(int | None)}:
        return tuple(kind for option in arguments for kind in _classes(option))
    return (Real,) if hint is float else (hint,)


@cache
def _hints(kind: type[Any]) -> dict[str, Any]:
    return get_type_hints(kind)
