"""Settings of experiments from a TOML file: a table per experiment, ``[rocking]``, with keys of its settings."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING

from ravengc._convert import as_path
from ravengc.config.files import decode, read_bytes
from ravengc.errors import ConfigError, ParseError
from ravengc.experiments import EXPERIMENTS
from ravengc.experiments.settings import settings_from
from ravengc.messages import did_you_mean, listed, shown

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from ravengc.experiments.settings import Settings

__all__ = ["experiment_named", "read_settings", "settings_of"]


def read_settings(path: str | Path) -> dict[str, Settings]:
    """Return the settings of the experiments that the file has a table for, all of them checked.

    Raises ParseError for what is no TOML, and ConfigError for a file without settings, an experiment or key that does
    not exist and a value outside its range: the message says where, and what is allowed.
    """
    file = as_path(path, "path")
    text = decode(read_bytes(file), str(file))
    try:
        tables = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ParseError(f"not valid TOML: {error}", file=str(file)) from error
    if not tables:
        raise ConfigError(
            f"{file}: no settings in it; expected a table per experiment, such as [{next(iter(EXPERIMENTS))}]"
        )
    found = {}
    for name, table in tables.items():
        experiment_named(name, f"{file}: [{name}]")
        if not isinstance(table, dict):
            raise ConfigError(f"{file}: {name} is {shown(table)}; expected a table, [{name}]")
        found[name] = settings_from(EXPERIMENTS[name].settings, table, f"{file}: [{name}]")
    return found


def settings_of(names: Sequence[str], path: str | Path) -> dict[str, Settings]:
    """Return what :func:`read_settings` does, of a file that is meant for experiments of these names.

    Raises ConfigError, too, for a file without a table for any of them, which would change nothing.
    """
    found = read_settings(path)
    if not found.keys() & set(names):
        wanted = ", ".join(f"[{name}]" for name in names)
        raise ConfigError(f"{path}: has tables for {listed(found)} and none for what is run; expected {wanted}")
    return found


def experiment_named(name: str, where: str = "experiment") -> None:
    """Raise ConfigError unless there is an experiment of this name; the near one is suggested."""
    if name not in EXPERIMENTS:
        near = did_you_mean(name, EXPERIMENTS)
        raise ConfigError(f"{where}: there is no experiment {shown(name)}{near} (choose {listed(EXPERIMENTS)})")
