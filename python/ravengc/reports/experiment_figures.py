"""Pictures of experiments, as files and as bytes to embed."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from ravengc.reports.figures import INK, STYLE, require_matplotlib, save_figure

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.experiments import Experiment, Outcome

__all__ = ["draw_experiment", "embedded_png", "save_experiment"]

WIDTH = 12.5
"""Of every picture, in."""
PURPOSE = "pictures of experiments"


def draw_experiment(experiment: Experiment, outcome: Outcome) -> Any:
    """Draw one experiment; returns matplotlib's Figure. MissingExtraError without matplotlib."""
    matplotlib = require_matplotlib(PURPOSE)
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": experiment.name}):
        figure = matplotlib.figure.Figure(figsize=(WIDTH, experiment.height), layout="constrained")
        figure.suptitle(experiment.title, x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        experiment.draw(figure, outcome)
    return figure


def save_experiment(figure: Any, folder: Path, name: str) -> list[Path]:
    """Write a figure as ``name.png`` and ``name.svg`` into a folder, each whole or not at all; returns both paths."""
    paths = [folder / f"{name}{suffix}" for suffix in (".png", ".svg")]
    for path in paths:
        save_figure(figure, path)
    return paths


def embedded_png(figure: Any) -> bytes:
    """Return a figure as the bytes of a PNG, fit for a page that has the title already; takes it off the figure."""
    figure.suptitle("")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()
