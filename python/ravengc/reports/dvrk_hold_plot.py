"""Arms held by computed torques as a picture: how far each tool moved with them and without."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ravengc.reports.figures import FAINT, INK, PREDICTED, STYLE, require_matplotlib, save_figure

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from ravengc.dvrk import Holding

__all__ = ["plot_holding"]

FALLING = "#d1603d"
SMALLEST_MM = 1e-13
"""What is smaller, also nothing, is drawn there."""


def plot_holding(path: Path, holding: Holding, names: Sequence[str]) -> None:
    """Draw a holding into a file (png, svg, pdf); ``names`` are those of the coordinates."""
    matplotlib = require_matplotlib("a picture of the arm that is held")
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(10.5, 4.2), layout="constrained")
        moves, torques = figure.subplots(1, 2, width_ratios=(3, 2))
        verdict = "held" if holding.holds_all else "NOT HELD"
        title = f"{holding.robot}, base {holding.base}: {len(holding.holds)} poses {verdict} by computed torques alone"
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        for place, one in enumerate(holding.holds):
            label = place == 0
            held, fallen = (np.maximum(1e3 * values, SMALLEST_MM) for values in (one.held, one.falling))
            moves.semilogy(one.time, held, color=PREDICTED, label="with the torques" if label else None)
            moves.semilogy(one.fall_time, fallen, color=FALLING, label="without" if label else None)
        moves.axhline(1e-2, color=FAINT, linewidth=0.8, linestyle=":")
        moves.set(xlabel="time, s", title="the tool's distance from its place, mm (dotted: what counts as held)")
        moves.legend(loc="center right")
        for one in holding.holds:
            torques.plot(one.tau, np.arange(len(names)), "o", color=PREDICTED, markersize=4, alpha=0.7)
        torques.set_yticks(np.arange(len(names)), names)
        torques.invert_yaxis()
        torques.axvline(0.0, color=FAINT, linewidth=0.8)
        torques.set_title("torques that hold, N·m or N; a dot a pose")
        save_figure(figure, path)
