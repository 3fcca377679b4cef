"""The folder that ``ravengc track --out`` writes: report, pictures, numbers."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import plain
from ravengc.config.files import write_atomically
from ravengc.reports.experiment_figures import embedded_png, save_experiment
from ravengc.reports.track_figures import draw_track
from ravengc.reports.track_report import Report, write_report

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from ravengc.cli.track_setup import Setup
    from ravengc.track import TrackResult

__all__ = ["FILES", "write_folder"]

FILES = ("report.html", "results.json", "track.png", "track.svg", "view.html")
"""What may be written there."""

NO_VIEW = "for a view to play back in three dimensions: pip install 'ravengc[view]'"


def write_folder(
    folder: Path, setup: Setup, runs: Mapping[str, TrackResult], about: dict[str, Any], view: Path | None
) -> list[Path]:
    """Write report.html, results.json, track.png and track.svg, each whole or not at all; returns their paths."""
    figure = draw_track(runs, setup.title)
    pictures = save_experiment(figure, folder, "track")
    results = json.dumps(plain(about), indent=2, ensure_ascii=False, allow_nan=False)
    write_atomically(folder / "results.json", results + "\n")
    report = Report(
        title=setup.title,
        summaries={name: run["seeds"] for name, run in about["runs"].items()},
        runs=runs,
        picture=embedded_png(figure),
        command=setup.command,
        notes=[*about["notes"], *about["problems"], *([] if view else [NO_VIEW])],
        links={"play it back in three dimensions": os.path.relpath(view, folder)} if view else {},
    )
    write_report(folder / "report.html", report)
    return [folder / "report.html", folder / "results.json", *pictures]
