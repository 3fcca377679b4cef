"""Values as TOML, as all writers of TOML here write them: read back, they are the same to the last bit."""

from __future__ import annotations

from typing import Any

__all__ = ["toml_text", "toml_value"]

_SHORT = {"\n": "\\n", "\t": "\\t", '"': '\\"', "\\": "\\\\"}


def toml_value(value: Any) -> str:
    """Return a number, truth value, text or nested list on one line; other numbers than Python's become floats."""
    if isinstance(value, str):
        return toml_text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, int) else repr(float(value))


def toml_text(value: str) -> str:
    """Return a basic string: what cannot be seen is escaped."""
    return f'"{"".join(map(_escaped, value))}"'


def _escaped(character: str) -> str:
    if character in _SHORT:
        return _SHORT[character]
    if character.isprintable():
        return character
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
