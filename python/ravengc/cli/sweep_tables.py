"""What ``ravengc sweep`` says: one JSON object, or tables for people."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from ravengc.cli.common import console, new_table, right
from ravengc.sweep import summarise

if TYPE_CHECKING:
    import argparse
    from pathlib import Path

    from ravengc.sweep import Progress, SweepTable

__all__ = ["describe", "show"]

MOST_ERRORS = 5


def describe(table: SweepTable, args: argparse.Namespace, progress: Progress, out: Path) -> dict[str, Any]:
    """Everything but the table as plain data, as ``--json`` prints it."""
    from ravengc.sweep.folder import table_files

    summaries = summarise(table, args.number, best=args.best)
    errors = [(int(trial), text) for trial, text in zip(table.columns["trial"], table.columns["error"], strict=True)]
    files = [*table_files(out), *([args.plot] if args.plot is not None else [])]
    return {
        "experiment": table.experiment,
        "swept": list(table.swept),
        "seed": args.seed,
        "trials": progress.total,
        "already": progress.already,
        "failed": table.failed,
        "best": args.best,
        "numbers": {summary.name: _summary(table, asdict(summary)) for summary in summaries},
        "errors": {str(trial): text for trial, text in errors if text},
        "files": [str(path) for path in files],
    }


def show(table: SweepTable, about: dict[str, Any]) -> None:
    """Print the summary, the first errors and the files."""
    screen = console()
    screen.print(
        f"{about['experiment']}: {about['trials']} trials over {', '.join(table.swept) or 'seeds'}", style="bold"
    )
    rows = new_table("number", right("best"), "at", right("worst"), "at", right("mean"), right("spread"))
    for name, summary in about["numbers"].items():
        best, worst, mean, spread = (f"{summary[key]:.5g}" for key in ("best", "worst", "mean", "spread"))
        rows.add_row(escape(name), best, _at(summary["best_at"]), worst, _at(summary["worst_at"]), mean, spread)
    screen.print(rows)
    for trial, text in list(about["errors"].items())[:MOST_ERRORS]:
        screen.print(f"trial {trial}: {text}", style="red", soft_wrap=True, markup=False)
    if about["failed"]:
        screen.print(f"{about['failed']} of {about['trials']} trials failed", style="bold red")
    for path in about["files"]:
        screen.print(path, soft_wrap=True, markup=False)


def _summary(table: SweepTable, summary: dict[str, Any]) -> dict[str, Any]:
    """A summary with the settings that varied of its best and worst trials."""
    rows = {int(trial): row for row, trial in enumerate(table.columns["trial"])}
    varied = [key for key in table.swept if len(set(table.columns[key])) > 1]
    for which in ("best", "worst"):
        row = rows[summary[f"{which}_trial"]]
        summary[f"{which}_at"] = {key: table.columns[key][row] for key in varied}
    return {key: value for key, value in summary.items() if key != "name"}


def _at(settings: dict[str, Any]) -> str:
    """The settings that belong to a value, shortly."""
    texts = (f"{value:.4g}" if isinstance(value, float) else str(value) for value in settings.values())
    return escape(" ".join(f"{key}={text}" for key, text in zip(settings, texts, strict=True)))
