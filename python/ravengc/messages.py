"""How errors are worded: a value as it was given, cut to a readable length, and the name or file that was meant."""

from __future__ import annotations

import reprlib
from itertools import islice
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

__all__ = ["did_you_mean", "kind_of", "listed", "near_file", "shown", "with_article"]

_LONGEST = 80
_MOST_NAMES = 1000
_MOST_MEANT = 4

_brief = reprlib.Repr()
_brief.maxstring = _brief.maxother = _LONGEST
_brief.maxlist = _brief.maxtuple = _brief.maxdict = 8
_brief.maxlevel = 3


def shown(value: object) -> str:
    """Return the value as a reader would recognise it, in about 80 characters on one line."""
    try:
        text = _brief.repr(value)
        return " ".join(text.split()) if "\n" in text else text  # an array's repr has several lines
    except ValueError:  # Python refuses to print integers of more than 4300 digits
        return f"a very large {type(value).__name__}"


def listed(names: Iterable[str]) -> str:
    """Return the names in quotes with commas, the first thirty of them: ``'a', 'b', 'c'``."""
    quoted = [repr(name) for name in islice(names, 31)]
    return ", ".join(quoted if len(quoted) <= 30 else [*quoted[:30], "..."])


def kind_of(value: object) -> str:
    """Return what the value is: ``a str``, ``an int``."""
    return with_article(type(value).__name__)


def with_article(name: str) -> str:
    """Return the name of a kind with its article: ``a str``, ``an Accelerometer``."""
    return f"{'an' if name[:1].lower() in set('aeiou') else 'a'} {name}"


def did_you_mean(word: object, options: Iterable[str]) -> str:
    """Return ``"; did you mean 'mass'?"`` with the options that begin as the text ``word``, or the nearest, or nothing.

    ``roll`` among ``roll_deg`` and ``roll_hz`` is either, so both are named; of more than four only the nearest is.
    ``degs`` is ``deg``, not ``deg/s``.
    """
    import difflib

    if not isinstance(word, str):
        return ""
    by_lower = {option.lower(): option for option in islice(options, _MOST_NAMES)}
    start = word[:_LONGEST].lower()
    near = [name for name in by_lower if len(start) > 1 and name.startswith(start)]
    if (singular := start.removesuffix("s")) in by_lower:
        near = [singular]
    elif not 1 <= len(near) <= _MOST_MEANT:
        near = difflib.get_close_matches(start, by_lower, n=1, cutoff=0.6)
    return f"; did you mean {' or '.join(repr(by_lower[name]) for name in near)}?" if near else ""


def near_file(path: Path) -> str:
    """Return ``"; did you mean 'arm.urdf'?"`` with the files beside ``path`` that are called nearly so, or nothing."""
    try:
        return did_you_mean(path.name, [entry.name for entry in islice(path.parent.iterdir(), _MOST_NAMES)])
    except (OSError, ValueError):
        return ""
