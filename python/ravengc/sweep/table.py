"""The table of a sweep: one row per trial, written as CSV and, where pyarrow is installed, as Parquet."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_path, check_type
from ravengc.atomic import replacing
from ravengc.config.files import write_atomically
from ravengc.errors import MissingExtraError
from ravengc.sweep.plan import SEED

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from ravengc.sweep.journal import Result
    from ravengc.sweep.plan import Plan

__all__ = ["SweepTable", "sweep_table"]

TRIAL, ERROR = "trial", "error"


@dataclass(frozen=True)
class SweepTable:
    """A sweep's trials: ``columns`` by name, all of one length, trial by trial.

    In this order: ``trial``; the settings that were ``swept``; ``seed`` where every trial had its own; ``error``, the
    message of a trial that failed and else empty; and the ``numbers`` that the experiment found, NaN where a trial has
    none. A number that is called like a column before it has ``number/`` in front. Arrays, but for texts and lists.
    ``units`` are those of the settings that were swept.
    """

    experiment: str
    swept: tuple[str, ...]
    numbers: tuple[str, ...]
    columns: Mapping[str, Any]
    units: Mapping[str, str] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.columns[TRIAL])

    @property
    def failed(self) -> int:
        """Number of trials that ended with an error."""
        return sum(error != "" for error in self.columns[ERROR])

    def write_csv(self, path: str | Path) -> None:
        """Write CSV, whole or not at all: floats in full, NaN as an empty cell, ``/`` between the entries of a list."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        columns = [getattr(column, "tolist", lambda column=column: column)() for column in self.columns.values()]
        writer.writerows([_cell(value) for value in row] for row in zip(*columns, strict=True))
        write_atomically(as_path(path, "path"), text.getvalue())

    def write_parquet(self, path: str | Path) -> None:
        """Write the table as Parquet, whole or not at all; MissingExtraError without pyarrow."""
        file = as_path(path, "path")
        try:
            import pyarrow as pa
            from pyarrow import parquet
        except ImportError as error:
            raise MissingExtraError("pyarrow", "sweep", "a Parquet table") from error
        columns = {name: _listed(column) for name, column in self.columns.items()}
        table = pa.table(columns).replace_schema_metadata({"experiment": self.experiment})
        with replacing(file) as temporary:
            parquet.write_table(table, temporary)


def sweep_table(plan: Plan, results: Mapping[int, Result]) -> SweepTable:
    """Put the results of trials into a table, in the order of the trials."""
    check_type(results, dict, "results")
    order = sorted(results)
    changes = [plan.changes(index) for index in order]
    found = [results[index] for index in order]
    columns: dict[str, Any] = {TRIAL: np.array(order, dtype=np.int64)}
    for key in (*plan.swept, *([SEED] if plan.seeded else [])):
        columns[key] = _column([change[key] for change in changes])
    columns[ERROR] = [result.error for result in found]
    names = list(dict.fromkeys(name for result in found for name in result.numbers))
    called = {name: f"number/{name}" if name in columns else name for name in names}
    for name in names:
        columns[called[name]] = np.array([result.numbers.get(name, math.nan) for result in found], dtype=np.float64)
    units = {one.name: one.metadata["unit"] for one in fields(plan.experiment.settings) if one.name in plan.swept}
    return SweepTable(plan.experiment.name, plan.swept, tuple(called.values()), columns, units)


def _column(values: list[Any]) -> Any:
    """An array of what are numbers or flags, a list of one counting as its entry; else the values."""
    if all(isinstance(value, tuple) and len(value) == 1 for value in values):
        values = [value[0] for value in values]
    return values if any(isinstance(value, (tuple, str)) for value in values) else np.array(values)


def _listed(column: Any) -> Any:
    return (
        [list(value) if isinstance(value, tuple) else value for value in column] if isinstance(column, list) else column
    )


def _cell(value: Any) -> Any:
    if isinstance(value, tuple):
        return "/".join(map(str, value))
    return "" if isinstance(value, float) and math.isnan(value) else value
