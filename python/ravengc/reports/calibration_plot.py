"""A calibration as a picture: where the positions lie on the sphere, what was still, and what the fit leaves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.calibration.positions import FACES, missing_faces
from ravengc.calibration.six import nearest_face
from ravengc.reports.figures import (
    AXIS_COLOURS,
    FAINT,
    INK,
    MEASURED,
    PREDICTED,
    STYLE,
    require_matplotlib,
    save_figure,
)

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from ravengc.calibration import LeverArm, Outcome

__all__ = ["plot_calibration", "plot_lever_arm"]

MISSING = "#d1603d"
RINGS_DEG = (2.0, 5.0, 10.0, 20.0, 60.0)
"""Steps between the rings of a map of leans; the last shows the whole sphere."""
MOST_POINTS = 20_000
"""Samples drawn of a long recording; more would only make the file large."""


def plot_calibration(path: Path, outcome: Outcome, gravity: float) -> None:
    """Draw a calibration into the file ``path`` (png, svg, pdf): sphere of directions, norm over time, residuals."""
    matplotlib = require_matplotlib("a picture of the calibration")
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(11.0, 6.4), layout="constrained")
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.15))
        figure.suptitle(_title(outcome), x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        _draw_directions(figure.add_subplot(grid[0, 0], projection="polar"), outcome)
        _draw_residuals(figure.add_subplot(grid[1, 0]), outcome)
        _draw_norm(figure.add_subplot(grid[0, 1]), outcome, gravity)
        _draw_rests(figure.add_subplot(grid[1, 1]), outcome, gravity)
        save_figure(figure, path)


def plot_lever_arm(path: Path, found: LeverArm) -> None:
    """Draw the turning terms, measured and predicted from the sensor's place, into the file ``path``."""
    matplotlib = require_matplotlib("a picture of the calibration")
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(11.0, 5.6), layout="constrained")
        x, y, z = (f"{1000.0 * value:.1f}" for value in found.position)
        title = f"lever arm ({x}, {y}, {z}) mm, residual {found.residual:.2g} m/s² RMS"
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        for axis, axes in enumerate(figure.subplots(3, 1, sharex=True)):
            axes.plot(
                found.t, found.measured[:, axis], color=MEASURED, linewidth=2.2, label="measured, gravity taken off"
            )
            axes.plot(found.t, found.predicted[:, axis], color=PREDICTED, label="turning about the pivot")
            axes.set_title(f"along {'xyz'[axis]}, m/s²")
        axes.set_xlabel("time, s")
        figure.axes[0].legend(loc="lower right", ncols=2, bbox_to_anchor=(1.0, 0.97))
        save_figure(figure, path)


def _title(outcome: Outcome) -> str:
    found = outcome.calibration
    error = np.degrees(found.direction_error)
    return (
        f"accelerometer, {found.method}: {len(outcome.positions)} positions, coverage {found.coverage_deg:.0f}°, "
        f"directions to {error:.2g}°, residual {found.residual:.2g} m/s²"
    )


def _draw_directions(axes: Any, outcome: Outcome) -> None:
    """Which way was up, in sensor axes: the lean from the nearest axis, and to which side; what was not seen is red."""
    forces = np.array([position.force for position in outcome.positions])
    missing, middle = missing_faces(forces), nearest_face(forces.mean(axis=0))
    sides, leans = _polar(forces, middle)
    step = next(step for step in RINGS_DEG if 3.0 * step >= leans.max() or step == RINGS_DEG[-1])
    reach = 3.0 * step
    axes.scatter(sides, leans, s=26, color=PREDICTED, zorder=3)
    for face, direction in FACES.items():
        side, lean = _polar(np.array([direction]), middle)
        if lean[0] <= reach:
            colour, angle = (MISSING if face in missing else INK), (np.pi / 4.0 if lean[0] == 180.0 else side[0])
            axes.annotate(face, (angle, lean[0]), ha="center", va="center", color=colour, fontsize=10, zorder=2)
    axes.set_ylim(0.0, reach)
    axes.set_xticklabels([])
    axes.set_rgrids([step, 2.0 * step], angle=60.0)
    unseen = f"\nnot seen: {', '.join(missing)}" if missing and reach == 180.0 else ""
    axes.set_title(f"which way was up: degrees from the sensor's {middle}{unseen}")


def _polar(directions: NDArray[np.float64], middle: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """To which side (rad) and how far (degrees) directions lean from an axis of the sensor."""
    axis = "xyz".index(middle[1])
    along = directions[:, axis] * (1.0 if middle[0] == "+" else -1.0)
    a, b = directions[:, (axis + 1) % 3], directions[:, (axis + 2) % 3]
    return np.arctan2(b, a), np.degrees(np.arctan2(np.hypot(a, b), along))


def _draw_residuals(axes: Any, outcome: Outcome) -> None:
    numbers = np.arange(1, len(outcome.positions) + 1)
    errors = [position.error for position in outcome.positions]
    style = {"fmt": "o", "markersize": 4, "color": PREDICTED, "ecolor": FAINT}
    axes.errorbar(numbers, outcome.calibration.residuals, yerr=errors, **style)
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    axes.set_title("what the calibration leaves, m/s² (bars: noise)")
    axes.set_xlabel("position")
    axes.xaxis.get_major_locator().set_params(integer=True)


def _draw_norm(axes: Any, outcome: Outcome, gravity: float) -> None:
    """Length of the readings over time, with the still segments shaded."""
    recording = outcome.recording
    every = slice(None, None, max(1, recording.samples // MOST_POINTS))
    t, force = recording.t[every], recording.specific_force[every]
    axes.plot(t, np.linalg.norm(force, axis=1), color=MEASURED, linewidth=0.7, label="raw")
    axes.plot(
        t, np.linalg.norm(outcome.calibration.apply(force), axis=1), color=PREDICTED, linewidth=0.7, label="calibrated"
    )
    axes.axhline(gravity, color=INK, linewidth=0.8)
    for segment in outcome.segments:
        axes.axvspan(segment.begin, segment.end, color=FAINT, alpha=0.35, linewidth=0.0)
    axes.set_title("norm, m/s² (shaded: still)")
    axes.set_xlabel("time, s")
    axes.legend(loc="lower right", ncols=2, bbox_to_anchor=(1.0, 0.97))


def _draw_rests(axes: Any, outcome: Outcome, gravity: float) -> None:
    """How far the length of each position is from g, before and after."""
    forces = np.array([position.force for position in outcome.positions])
    numbers = np.arange(1, len(forces) + 1)
    raw = np.linalg.norm(forces, axis=1) - gravity
    after = np.linalg.norm(outcome.calibration.apply(forces), axis=1) - gravity
    axes.vlines(numbers, raw, after, color=FAINT, linewidth=1.0)
    axes.plot(numbers, raw, "o", color=AXIS_COLOURS[0], markersize=4, label="raw")
    axes.plot(numbers, after, "o", color=PREDICTED, markersize=4, label="calibrated")
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set_title("norm minus g, m/s²")
    axes.set_xlabel("position")
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.legend(loc="lower right", ncols=2, bbox_to_anchor=(1.0, 0.97))
