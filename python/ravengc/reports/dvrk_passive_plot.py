"""An arm that was let go on tilted bases, as a picture: how far its tool drifted with two calibrations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.reports.figures import FAINT, INK, PREDICTED, STYLE, require_matplotlib, save_figure

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.dvrk import Drift, PassiveRuns

__all__ = ["plot_passive"]

LEVEL_ONLY = "#d1603d"
SMALLEST_MM = 1e-13
"""What is smaller, also nothing, is drawn there."""
CALIBRATIONS = ("calibrated on tilted bases", "calibrated on a level base alone")


def plot_passive(path: Path, runs: PassiveRuns) -> None:
    """Draw passive runs into a file (png, svg, pdf)."""
    matplotlib = require_matplotlib("a picture of the drift")
    both = (runs.with_identified, runs.with_level_only)
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(10.5, 4.4), layout="constrained")
        drifts, errors = figure.subplots(1, 2, width_ratios=(3, 2))
        title = f"{runs.robot} let go for {runs.seconds:g} s on bases tilted up to {_steepest(runs):g}°"
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        for found, label, colour in zip(both, CALIBRATIONS, (PREDICTED, LEVEL_ONLY), strict=True):
            _draw(drifts, errors, found, label, colour)
        drifts.axhline(1.0, color=FAINT, linewidth=0.8, linestyle=":")
        drifts.set(xlabel="time, s", title="the tool's distance from where it was let go, mm (dotted: 1 mm)")
        drifts.legend(loc="center right")
        errors.set(xlabel="tilt of the base, deg", title="error of joint 2's torque when let go, N·m")
        save_figure(figure, path)


def _draw(drifts: Any, errors: Any, found: tuple[Drift, ...], label: str, colour: str) -> None:
    for place, run in enumerate(found):
        moved = np.maximum(1e3 * run.moved, SMALLEST_MM)
        drifts.semilogy(run.time, moved, color=colour, label=None if place else label)
    size = [max(abs(float(run.error[1])), 1e-6) for run in found]
    errors.semilogy([run.tilt_deg for run in found], size, "o", color=colour, markersize=5)


def _steepest(runs: PassiveRuns) -> float:
    return max(run.tilt_deg for run in runs.with_identified)
