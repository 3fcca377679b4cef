"""What a sweep found, number by number: the best and the worst trial, the mean and the spread."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_texts, check_choice, check_type
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.sweep.table import TRIAL, SweepTable

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Summary", "check_number", "summarise"]

FEW = 12
"""As many numbers an error names."""


@dataclass(frozen=True)
class Summary:
    """One number over the ``count`` trials that have it: best and worst with their trials, mean, standard deviation."""

    name: str
    best: float
    best_trial: int
    worst: float
    worst_trial: int
    mean: float
    spread: float
    count: int


def summarise(table: SweepTable, numbers: Sequence[str] | None = None, *, best: str = "least") -> list[Summary]:
    """Return a summary per number (all of the table, or those named) that has a finite value in some trial.

    ``best`` is "least" or "largest". Raises ConfigError for a number that the table does not have.
    """
    check_type(table, SweepTable, "table")
    check_choice(best, ("least", "largest"), "best")
    names = table.numbers if numbers is None else as_texts(numbers, "numbers")
    for name in names:
        check_number(table, name)
    return [found for name in names if (found := _summary(table, name, best)) is not None]


def check_number(table: SweepTable, name: str) -> None:
    """Raise ConfigError, with the near one suggested, unless the table has this number."""
    if name not in table.numbers:
        near = did_you_mean(name, table.numbers)
        more = f" and {len(table.numbers) - FEW} more" if len(table.numbers) > FEW else ""
        known = f" (known: {listed(table.numbers[:FEW])}{more})" if table.numbers else ": no trial has any number"
        raise ConfigError(f"{table.experiment} has no number {shown(name)}{near}{known}")


def _summary(table: SweepTable, name: str, best: str) -> Summary | None:
    values = table.columns[name]
    finite = np.flatnonzero(np.isfinite(values))
    if not finite.size:
        return None
    order = finite[np.argsort(values[finite], kind="stable")]
    first, last = (order[0], order[-1]) if best == "least" else (order[-1], order[0])
    return Summary(
        name=name,
        best=float(values[first]),
        best_trial=int(table.columns[TRIAL][first]),
        worst=float(values[last]),
        worst_trial=int(table.columns[TRIAL][last]),
        mean=float(values[finite].mean()),
        spread=float(values[finite].std()),
        count=int(finite.size),
    )
