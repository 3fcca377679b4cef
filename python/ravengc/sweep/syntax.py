"""A grid and random draws as they are typed: ``hz=0.5:2:4``, ``tilts_deg=0,10,20``, ``latency_s=1e-3:0.1:log``."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import check_type
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.sweep.plan import MOST_TRIALS, Draw, experiment_for

if TYPE_CHECKING:
    from ravengc.experiments import Experiment

__all__ = ["read_draw", "read_points"]

GRID_FORM = "expected key=from:to:count, key=from:to:count:log or key=value,value,..."
DRAW_FORM = "expected key=low:high or key=low:high:log"


def read_points(experiment: Experiment | str, text: str) -> tuple[str, list[Any]]:
    """Return the key and the values of one key of a grid.

    ``key=from:to:count`` are evenly spaced values with both ends, ``:log`` behind it those of even ratio;
    ``key=v,v,...`` are these values, and ``/`` stands between the entries of a list: ``coulomb=0/0/0,1/0.6/4``.

    Raises ConfigError for another form, an unknown key (the near one is suggested) and what is no value of its kind.
    """
    key, words = _split(text, "grid", GRID_FORM)
    like = _like(experiment, key, "grid")
    if ":" not in words:
        return key, [_entries(like, word, f"grid: {key}") for word in words.split(",")]
    first, last, count, log = _range_words(words, text)
    values = np.geomspace(first, last, count) if log else np.linspace(first, last, count)
    return key, [_whole(like, float(f"{value:.15g}")) for value in values]


def read_draw(experiment: Experiment | str, text: str) -> tuple[str, Draw]:
    """Return the key and the range of one random draw, ``key=low:high``, uniform, or ``key=low:high:log``.

    Raises ConfigError for another form and for an unknown key (the near one is suggested).
    """
    key, words = _split(text, "random", DRAW_FORM)
    like = _like(experiment, key, "random")
    low, high, *scale = words.split(":") if words.count(":") in {1, 2} else ("", "", "")
    if not low or scale not in ([], ["log"]):
        raise ConfigError(f"random: {shown(text)}; {DRAW_FORM}")
    first, last = (_whole(like, _number(word, f"random: {key}")) for word in (low, high))
    try:
        return key, Draw(first, last, log=bool(scale))
    except ConfigError as error:
        raise ConfigError(f"random: {key}: {error}") from None


def _split(text: str, where: str, form: str) -> tuple[str, str]:
    check_type(text, str, "text")
    key, equals, words = text.partition("=")
    if not (equals and key.strip() and words.strip()):
        raise ConfigError(f"{where}: {shown(text)}; {form}")
    return key.strip(), words.strip()


def _like(experiment: Experiment | str, key: str, where: str) -> Any:
    """The default of a setting, a single one of a list."""
    found = experiment_for(experiment)
    fields = {field.name: field.default for field in dataclasses.fields(found.settings)}
    if key not in fields:
        near = did_you_mean(key, fields)
        raise ConfigError(f"{where}: {found.name} has no setting {shown(key)}{near} (known: {listed(sorted(fields))})")
    return fields[key]


def _range_words(words: str, text: str) -> tuple[float, float, int, bool]:
    first, last, count, *scale = words.split(":") if words.count(":") in {2, 3} else ("", "", "", "none")
    if scale not in ([], ["log"]):
        raise ConfigError(f"grid: {shown(text)}; {GRID_FORM}")
    ends = [_number(word, f"grid: {shown(text)}") for word in (first, last)]
    number = int(count) if count.isascii() and count.isdigit() and len(count) < 10 else 0
    if not 2 <= number <= MOST_TRIALS:
        raise ConfigError(
            f"grid: {shown(text)}: the count is {shown(count)}; expected a whole number from 2 to 1000000"
        )
    if scale and not min(ends) > 0.0:
        raise ConfigError(f"grid: {shown(text)}: a logarithmic range needs positive ends")
    return ends[0], ends[1], number, bool(scale)


def _entries(like: Any, word: str, where: str) -> Any:
    if isinstance(like, tuple) and "/" in word:
        return tuple(_entry(like[0], part, where) for part in word.split("/"))
    return _entry(like[0] if isinstance(like, tuple) else like, word, where)


def _entry(like: Any, word: str, where: str) -> Any:
    """One value of the kind of ``like``; the range is checked with the plan."""
    word = word.strip()
    if isinstance(like, bool):
        return {"true": True, "false": False}.get(word, word)
    if isinstance(like, str):
        return word
    if isinstance(like, int) and word.removeprefix("-").isascii() and word.removeprefix("-").isdigit():
        return int(word) if len(word) < 100 else math.inf
    return _whole(like, _number(word, where, "; a range is key=from:to:count"))


def _number(word: str, where: str, hint: str = "") -> float:
    try:
        number = float(word) if word.isascii() and "_" not in word else math.nan
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ConfigError(f"{where}: {shown(word)} is not a finite number{hint}")
    return number


def _whole(like: Any, value: float) -> float:
    """A whole number where the setting is one and the value is, too."""
    single = like[0] if isinstance(like, tuple) else like
    return int(value) if isinstance(single, int) and value.is_integer() else value
