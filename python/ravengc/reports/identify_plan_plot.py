"""A plan as a picture: how uncertain every joint's torque is against the tilt of the base."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.coordinates import sliding
from ravengc.reports.figures import INK, PREDICTED, STYLE, require_matplotlib, save_figure

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from ravengc.identify import Prediction
    from ravengc.spec import RobotSpec

__all__ = ["plot_plan"]

WORSE = "#d1603d"
MOST_COLUMNS = 4
LEAST = 1e-5
"""N·m or N below which nothing is drawn: a joint that carries nothing level."""


def plot_plan(path: Path, curves: Mapping[str, Prediction], robot: RobotSpec, *, title: str) -> None:
    """Draw standard deviations of the holding torques, a picture per joint, into a file (png, svg, pdf).

    ``curves`` are predictions by label: those that a plan gives, then what a level base alone would.
    """
    matplotlib = require_matplotlib("the picture of a plan")
    names = robot.coordinate_names
    columns = min(MOST_COLUMNS, len(names))
    rows = -(-len(names) // columns)
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(2.6 * columns + 0.6, 2.2 * rows + 0.8), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        for place, (name, slides) in enumerate(zip(names, sliding(robot), strict=True)):
            _draw_joint(axes[place], curves, place)
            axes[place].set_title(f"{name}, {'N' if slides else 'N·m'}")
        for unused in axes[len(names) :]:
            unused.set_axis_off()
        for lowest in axes[max(0, len(names) - columns) : len(names)]:
            lowest.set_xlabel("tilt of the base, °")
            lowest.tick_params(labelbottom=True)
        handles, labels = axes[0].get_legend_handles_labels()
        (axes[-1] if len(axes) > len(names) else axes[0]).legend(handles, labels, loc="center")
        save_figure(figure, path)


def _draw_joint(axes: Any, curves: Mapping[str, Prediction], joint: int) -> None:
    """The curves of a joint; where one ends, its torque is open from there on."""
    alone = len(curves) == 1
    for number, (label, curve) in enumerate(curves.items()):
        colour = WORSE if number and not alone else PREDICTED
        sd = curve.sd[:, joint]
        known = np.isfinite(sd) & (sd > LEAST)
        axes.semilogy(np.degrees(curve.angles[known]), sd[known], "o-", color=colour, markersize=3, label=label)
        if not np.isfinite(sd).all():
            axes.text(
                0.97, 0.94, f"{label}: open", color=colour, transform=axes.transAxes, ha="right", va="top", fontsize=8
            )
