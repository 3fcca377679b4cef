"""The folder of a sweep: what it is (``sweep.json``), the journal of its trials, and the tables at the end.

A folder belongs to one sweep. The same one goes on where it stopped; anything else is refused, with what differs.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

from ravengc._convert import as_path
from ravengc._core import INSTRUCTIONS
from ravengc.config.files import decode, read_bytes, write_atomically
from ravengc.errors import ConfigError, ParseError, RavenGCError
from ravengc.experiments.settings import settings_from
from ravengc.messages import shown
from ravengc.sweep.journal import Journal, read_journal
from ravengc.sweep.plan import Draw, experiment_for, plan_sweep
from ravengc.sweep.table import SweepTable, sweep_table

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from ravengc.experiments import Experiment
    from ravengc.sweep.plan import Plan

__all__ = ["finished_trials", "open_journal", "read_sweep", "table_files", "versions", "write_tables"]

ABOUT, JOURNAL, CSV, PARQUET = "sweep.json", "journal.jsonl", "sweep.csv", "sweep.parquet"
FORMAT = 1


def open_journal(plan: Plan, folder: Path) -> Journal:
    """Open the journal of a sweep, in a folder made for it or one that the same sweep left.

    Raises ConfigError for the folder of another sweep, with what differs, for one that is in use or cannot be written;
    ParseError where its files are not those of a sweep.
    """
    about = _about(plan)
    if (folder / ABOUT).exists():
        _check_same(_read_about(folder / ABOUT), about, folder)
    else:
        for name in (JOURNAL, CSV, PARQUET):
            if (folder / name).exists():
                raise ConfigError(f"{folder}: has a {name} without {ABOUT}, so it is not of this sweep; choose another")
        write_atomically(folder / ABOUT, json.dumps(about, indent=2, ensure_ascii=False) + "\n")
    return Journal(folder / JOURNAL, plan.total)


def read_sweep(folder: str | Path, experiment: Experiment | None = None) -> SweepTable:
    """Return the table of the trials that a sweep has finished so far, whether it is at work, done or was stopped.

    An ``experiment`` that is not one of ravengc must be given. Raises ParseError or ConfigError for a folder that is
    not that of a sweep of this experiment.
    """
    place = as_path(folder, "folder")
    if experiment is not None:
        experiment_for(experiment)
    about = _read_about(place / ABOUT)
    try:
        if experiment is None or experiment.name != about["experiment"]:
            experiment = experiment_for(about["experiment"])
        plan = plan_sweep(
            experiment,
            grid=about["grid"],
            random={key: Draw(**draw) for key, draw in about["random"].items()},
            trials=about["trials"],
            seed=about["seed"],
            settings=settings_from(experiment.settings, about["settings"]),
        )
    except RavenGCError as error:
        raise ConfigError(f"{place / ABOUT}: {error}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise ParseError(f"not a sweep: {error}", file=str(place / ABOUT)) from None
    return sweep_table(plan, read_journal(place / JOURNAL, plan.total)[0])


def finished_trials(folder: Path) -> int:
    """How many trials the journal in a folder has, whole lines of it."""
    path = folder / JOURNAL
    return path.read_bytes().count(b"\n") if path.exists() else 0


def write_tables(table: SweepTable, folder: Path) -> None:
    """Write ``sweep.csv``, and ``sweep.parquet`` where pyarrow is installed."""
    from importlib.util import find_spec

    table.write_csv(folder / CSV)
    if find_spec("pyarrow") is not None:
        table.write_parquet(folder / PARQUET)


def table_files(folder: Path) -> list[Path]:
    """The tables that there are in the folder of a sweep."""
    return [folder / name for name in (PARQUET, CSV) if (folder / name).exists()]


@cache
def versions() -> dict[str, str]:
    """What the bits of a trial depend on: versions of the packages that compute, and the processor's instructions."""
    packages = {name: _version(name) for name in ("ravengc", "numpy", "mujoco")}
    return {**packages, "instructions": INSTRUCTIONS}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _about(plan: Plan) -> dict[str, Any]:
    """The sweep as ``sweep.json`` has it: plain data, so that it compares as it is read."""
    about = {
        "format": FORMAT,
        "experiment": plan.experiment.name,
        "settings": asdict(plan.settings),
        "grid": plan.grid,
        "random": {key: asdict(draw) for key, draw in plan.random.items()},
        "trials": plan.trials,
        "seed": plan.seed,
        "versions": versions(),
    }
    plain: dict[str, Any] = json.loads(json.dumps(about))
    return plain


def _read_about(path: Path) -> dict[str, Any]:
    text = decode(read_bytes(path), str(path))
    try:
        about = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ParseError(f"not valid JSON: {error}", file=str(path)) from error
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise ParseError(
            f"not a sweep of this version of ravengc: expected an object with format {FORMAT}", file=str(path)
        )
    return about


def _check_same(there: dict[str, Any], here: dict[str, Any], folder: Path) -> None:
    if differences := list(_differences(there, here)):
        told = "; ".join(differences[:4]) + ("; ..." if len(differences) > 4 else "")
        raise ConfigError(
            f"{folder}: holds another sweep: {told}. Choose another folder, or repeat that sweep to go on"
        )


def _differences(there: dict[str, Any], here: dict[str, Any], inside: str = "") -> Iterator[str]:
    if not inside and there.get("experiment") != here["experiment"]:
        there, here = ({"experiment": about.get("experiment")} for about in (there, here))
    if inside in {"grid.", "random."} and list(there) != list(here) and set(there) == set(here):
        yield f"the order of {inside[:-1]} is {', '.join(there)} there and {', '.join(here)} here"
    for key in dict.fromkeys((*there, *here)):
        first, second = there.get(key), here.get(key)
        if isinstance(first, dict) and isinstance(second, dict):
            yield from _differences(first, second, f"{inside}{key}.")
        elif first != second:
            told = ("absent" if value is None else shown(value) for value in (first, second))
            yield f"{inside}{key} is {next(told)} there and {next(told)} here"
