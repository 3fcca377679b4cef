"""What ``ravengc track`` says: one JSON object, or a table for people."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from ravengc import _core
from ravengc.cli.common import console, new_table, print_json, right
from ravengc.reports.track_numbers import ROWS, cell, means, setting_text

if TYPE_CHECKING:
    from rich.console import Console

    from ravengc.cli.track_runs import Runs
    from ravengc.cli.track_setup import Setup

__all__ = ["describe", "list_settings", "show"]

NOTES: dict[str, str] = _core.NOTES
NOTED = 0.1
"""Of low coverage, a note of the predictor with this share of the pictures may be the reason."""
REMEDIES = {
    "out_of_band": "; band_hz and harmonics in [track] of --settings say which cycles to expect",
    "learning": "; lead_in_s in [track] of --settings gives it time",
}


def describe(setup: Setup, runs: Runs) -> dict[str, Any]:
    """Everything but traces and visits as plain data, SI, as ``--json`` prints it."""
    problems = _problems(setup, next(iter(runs.summaries.values())))
    return {
        "title": setup.title,
        "command": setup.command,
        "notes": [*setup.notes, *_played_again(setup, runs)],
        "interrupted": runs.interrupted,
        "seeds": list(range(setup.first_seed, setup.first_seed + runs.seeds)),
        "camera": asdict(setup.camera_of(setup.first_seed)),
        "settings": asdict(next(iter(setup.methods.values()))),
        "runs": {name: {"mean": means(summaries), "seeds": summaries} for name, summaries in runs.summaries.items()},
        "problems": [*([runs.interrupted] if runs.interrupted else []), *problems],
        "holds": not problems and not runs.interrupted,
    }


def _problems(setup: Setup, summaries: list[dict[str, Any]]) -> list[str]:
    """Why the exit code is 1."""
    numbers = means(summaries)
    found = []
    if numbers["coverage"] < setup.least_coverage:
        least = f"expected {setup.least_coverage:.1%} at least"
        found.append(f"{numbers['coverage']:.1%} of the points covered; {least}{_reach(setup, summaries)}")
        found += _predicted(summaries)
    if numbers["limit_violations"]:
        found.append(f"{numbers['limit_violations']:.0f} cycles with a joint beyond its limit; expected none")
    return found


def _reach(setup: Setup, summaries: list[dict[str, Any]]) -> str:
    """What helps against points out of reach."""
    unreached = sum(summary["outcomes"]["unreachable"] for summary in summaries)
    if not unreached:
        return ""
    which = "all" if unreached == sum(sum(summary["outcomes"].values()) for summary in summaries) else f"{unreached}"
    help_ = ": --at X,Y,Z puts the cloud elsewhere, --turn R,P,Y turns it" if setup.is_from_file else ""
    return f"; {which} of them out of the arm's reach{help_}"


def _predicted(summaries: list[dict[str, Any]]) -> list[str]:
    """What the predictor noted with many of the pictures."""
    counters = [summary["predictor_counters"] for summary in summaries]
    received = sum(counted.get("received", 0) for counted in counters)
    shares = {note: sum(counted.get(note, 0) for counted in counters) / max(received, 1) for note in NOTES}
    return [
        f"the predictor, with {share:.0%} of the pictures: {NOTES[note]} ({note}){REMEDIES.get(note, '')}"
        for note, share in shares.items()
        if share >= NOTED
    ]


def _played_again(setup: Setup, runs: Runs) -> list[str]:
    longest = max(summary["duration_s"] for summaries in runs.summaries.values() for summary in summaries)
    if setup.recorded_s is None or longest <= setup.recorded_s:
        return []
    length = f"the recording lasts {setup.recorded_s:.0f} s, the run {longest:.0f} s"
    return [f"{length}: it was played backwards and forwards again"]


def show(about: dict[str, Any]) -> None:
    """Print the table."""
    out = console()
    out.print(about["title"], style="bold", soft_wrap=True, markup=False)
    for note in about["notes"]:
        out.print(note, style="dim", markup=False)
    columns = [right(escape(name)) for name in about["runs"]]
    seeds = len(about["seeds"])
    table = new_table("" if seeds == 1 else f"mean of {seeds} seeds", *columns)
    for row in ROWS:
        table.add_row(row.name, *(cell(row, run["mean"]) for run in about["runs"].values()))
    out.print(table)
    _show_outcomes(out, about)
    if seeds > 1:
        _show_seeds(out, about)
    for problem in about["problems"]:
        out.print(f"[red]{escape(problem)}[/]")
    for path in about["files"]:
        out.print(f"written: {path}", soft_wrap=True, markup=False)


def _show_outcomes(out: Console, about: dict[str, Any]) -> None:
    """How the visits that did not end well ended."""
    for name, run in about["runs"].items():
        counts: dict[str, int] = {}
        for summary in run["seeds"]:
            for outcome, count in summary["outcomes"].items():
                counts[outcome] = counts.get(outcome, 0) + count
        others = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count and outcome != "covered")
        if others:
            out.print(f"{name}: {others} of {sum(counts.values())} points", markup=False)


def _show_seeds(out: Console, about: dict[str, Any]) -> None:
    """How much the seeds differ."""
    for name, run in about["runs"].items():
        covered = ", ".join(f"{100.0 * summary['coverage']:.1f}" for summary in run["seeds"])
        out.print(f"{name}: coverage of the seeds: {covered} %", markup=False)


def list_settings(*, as_json: bool) -> int:
    """Print the settings that a file may change."""
    from ravengc.experiments.settings import settings_table
    from ravengc.track import liver_500

    _, _, _, camera, settings = liver_500()
    of_camera = [row for row in settings_table(camera) if row[0] != "seed"]  # which --seed decides
    tables = {"track": settings_table(settings), "camera": of_camera}
    if as_json:
        keys = ("key", "value", "unit", "allowed", "meaning")
        print_json({name: [dict(zip(keys, row, strict=True)) for row in rows] for name, rows in tables.items()})
        return 0
    out = console()
    for name, rows in tables.items():
        table = new_table("setting", "value", "allowed", "what it is")
        for key, value, _, allowed, meaning in rows:
            table.add_row(key, escape(setting_text(value)), escape(allowed), escape(meaning))
        out.print(f"[bold]{escape(f'[{name}]')}[/]")
        out.print(table)
    return 0
