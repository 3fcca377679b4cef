"""The numbers of runs over a moving surface as rows of a table: one run, or the mean of several seeds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["ROWS", "Row", "cell", "means", "setting_text"]


class Row(NamedTuple):
    """A number of a run's summary: what it is called, its key (one below another with a dot), factor and digits.

    ``counts`` is true of a number that is whole in a single run, and shown so.
    """

    name: str
    key: str
    factor: float = 1.0
    digits: int = 2
    counts: bool = False


ROWS = (
    Row("coverage, %", "coverage", 100.0, 1),
    Row("shown covered by later pictures, %", "confirmed", 100.0, 1),
    Row("visited again", "revisits", 1.0, 1, counts=True),
    Row("time per point, s", "time_per_point_s", 1.0, 3),
    Row("dwell error, RMS, mm", "dwell_rms_m", 1e3, 3),
    Row("dwell error, 95 %, mm", "dwell_p95_m", 1e3, 3),
    Row("dwell error, largest, mm", "dwell_max_m", 1e3, 2),
    Row("hold error, RMS, mm", "hold_rms_m", 1e3, 3),
    Row("hold error, 95 %, mm", "hold_p95_m", 1e3, 3),
    Row("hold error, largest, mm", "hold_max_m", 1e3, 2),
    Row("prediction error, RMS, mm", "prediction_rms_m", 1e3, 3),
    Row("tool's acceleration, RMS, m/s²", "acceleration_rms", 1.0, 1),
    Row("cycles beyond a limit", "limit_violations", 1.0, 0),
    Row("cycle, median, µs", "cycle_us.median", 1.0, 1),
    Row("cycle, 99 %, µs", "cycle_us.p99", 1.0, 1),
)


def means(summaries: Sequence[dict[str, Any]]) -> dict[str, float]:
    """Return the mean of every row's number over runs, NaN where no run has one; limit violations are added up."""
    found = {}
    for row in ROWS:
        values = [value for summary in summaries if (value := _value(summary, row.key)) is not None]
        combined = np.sum if row.key == "limit_violations" else np.mean
        found[row.key] = float(combined(values)) if values else float("nan")
    return found


def cell(row: Row, numbers: Mapping[str, float]) -> str:
    """Return a number of :func:`means` as text; a dash where there is none."""
    value = numbers[row.key]
    if not np.isfinite(value):
        return "–"
    text = f"{row.factor * value:.{row.digits}f}"
    return text.removesuffix(".0") if row.counts else text


def setting_text(value: Any) -> str:
    """Return a setting as text: numbers with six digits, those of a row with commas between."""
    if isinstance(value, tuple):
        return ", ".join(map(setting_text, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _value(summary: dict[str, Any], key: str) -> float | None:
    found: Any = summary
    for part in key.split("."):
        found = found.get(part) if isinstance(found, dict) else None
    if isinstance(found, dict):
        found = sum(found.values())
    return None if found is None else float(found)
