"""A run over a moving surface as a picture: what was covered, how the surface was predicted, and the errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.reports.figures import FAINT, INK, MEASURED, PREDICTED, STYLE, require_matplotlib
from ravengc.track import OUTCOMES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ravengc.track import TrackResult

__all__ = ["OUTCOME_COLOURS", "PURPOSE", "draw_track", "flattened"]

Array = NDArray[np.float64]

PURPOSE = "a picture of the run"
OUTCOME_COLOURS = dict(zip(OUTCOMES, ("#5b9a52", "#d1963d", "#d1603d", "#7a4fa3", "#d5d9de"), strict=True))
RUN_COLOURS = (PREDICTED, "#d1603d", "#7a4fa3", "#d1963d")
MOTION_WINDOW_S, CHASE_WINDOW_S = 12.0, 1.6
LEAST_MM, MOST_MM = 1e-3, 1e3
HIGHEST_QUANTILE = 0.995
"""Of the errors that are drawn against time; a jump from one hold test to the next is far above."""


def draw_track(runs: Mapping[str, TrackResult], title: str) -> Any:
    """Draw runs by their names, the first the one that counts; returns matplotlib's Figure, MissingExtraError without.

    The upper row: the points by outcome in the plane in which they spread most, the surface's motion as it was, as it
    was seen and as it was predicted, and how near the tool came over a few points. The lower row: the errors of dwells
    and of hold tests.
    """
    matplotlib = require_matplotlib(PURPOSE)
    first = next(iter(runs.values()))
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(13.5, 7.6), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        (map_axes, motion, chase), (dwells, holds, shares) = figure.subplots(2, 3)
        _draw_map(map_axes, first)
        _draw_motion(motion, first)
        _draw_chase(chase, runs)
        _draw_dwells(dwells, runs)
        _draw_holds(holds, runs)
        _draw_shares(shares, runs)
    return figure


def flattened(points: Array) -> Array:
    """Return the points (n, 2) in the plane in which they spread most, in mm, from their middle."""
    away = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(away, full_matrices=False)
    across = axes[:2] if len(axes) > 1 else np.eye(3)[:2]
    across = across * np.where(across[np.arange(2), np.abs(across).argmax(axis=1)] < 0.0, -1.0, 1.0)[:, None]
    flat: Array = 1e3 * away @ across.T
    return flat


def _draw_map(axes: Any, run: TrackResult) -> None:
    places = flattened(run.surface.points)[run.visits.point]
    axes.plot(*places.T, color=FAINT, linewidth=0.6, zorder=1)
    for outcome, colour in OUTCOME_COLOURS.items():
        among = run.visits.outcome == outcome
        if among.any():
            label = f"{outcome}, {int(among.sum())}"
            axes.scatter(*places[among].T, s=13.0, color=colour, linewidths=0.0, label=label, zorder=2)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(title=f"{run.surface.name}: {100.0 * run.coverage:.1f} % covered", xlabel="mm", ylabel="mm")
    axes.legend(loc="upper right", handletextpad=0.2, borderaxespad=0.0)


def _draw_motion(axes: Any, run: TrackResult) -> None:
    """The displacement along the direction of most of it, from when the tour begins."""
    trace = run.trace
    start = _tour_start(run)
    shown = (trace.stamps >= start) & (trace.stamps <= start + MOTION_WINDOW_S)
    along = _direction(trace.displacement)
    seen = run.camera[(run.camera[:, 0] >= start) & (run.camera[:, 0] <= start + MOTION_WINDOW_S)]
    time = trace.stamps[shown]
    axes.plot(time, 1e3 * trace.displacement[shown] @ along, color=INK, label="is", zorder=2)
    axes.plot(time, 1e3 * trace.predicted[shown] @ along, color=PREDICTED, label="taken for", zorder=3)
    axes.plot(seen[:, 0], 1e3 * seen[:, 1:] @ along, ".", color=MEASURED, markersize=3.5, label="seen", zorder=1)
    rms = "" if not np.isfinite(run.prediction_rms_m) else f", predicted to {1e3 * run.prediction_rms_m:.2f} mm RMS"
    axes.set(title=f"where the surface is, mm{rms}", xlabel="time, s")
    axes.margins(y=0.14)  # room for the legend
    axes.legend(loc="upper right", ncols=3, handlelength=1.2, columnspacing=1.0)


def _draw_chase(axes: Any, runs: Mapping[str, TrackResult]) -> None:
    """How far the tool is from the point it goes for, over a few points; a dwell counts below the tolerance."""
    for (name, run), colour in zip(runs.items(), RUN_COLOURS, strict=False):
        start = _tour_start(run)
        shown = (run.trace.stamps >= start) & (run.trace.stamps <= start + CHASE_WINDOW_S)
        axes.plot(run.trace.stamps[shown] - start, _millimetres(run.trace.error_m[shown]), color=colour, label=name)
    settings = next(iter(runs.values())).settings
    axes.axhline(1e3 * settings.covered_m, color=FAINT, linewidth=0.9, linestyle="--")
    axes.set(yscale="log", title="distance from the moving point, mm", xlabel="time from the second point on, s")
    axes.yaxis.set_major_formatter(_plain)
    _legend(axes, runs)


def _draw_dwells(axes: Any, runs: Mapping[str, TrackResult]) -> None:
    """The largest error of every dwell, in order of size."""
    for (name, run), colour in zip(runs.items(), RUN_COLOURS, strict=False):
        worst = np.sort(run.visits.error_max_m[np.isfinite(run.visits.error_max_m)])
        if len(worst):
            axes.plot(np.linspace(0.0, 100.0, len(worst)), _millimetres(worst), color=colour, label=name)
    settings = next(iter(runs.values())).settings
    axes.axhline(1e3 * settings.covered_m, color=FAINT, linewidth=0.9, linestyle="--")
    axes.set(
        title="largest error during a dwell, mm\n(dashed: what a covered point may have)", xlabel="% of the dwells"
    )
    axes.set_ylim(bottom=0.0)
    _legend(axes, runs)


def _draw_holds(axes: Any, runs: Mapping[str, TrackResult]) -> None:
    """Errors of the hold tests one behind the other, without the time for the way there."""
    highest = 0.0
    for i, ((name, run), colour) in enumerate(zip(runs.items(), RUN_COLOURS, strict=False)):
        errors = hold_errors(run)
        if len(errors):
            time, label = np.arange(len(errors)) / run.settings.trace_hz, f"{name}, {_rms_text(run.hold_rms_m)}"
            axes.plot(time, 1e3 * errors, color=colour, linewidth=0.6, label=label, zorder=9 - i)
            highest = max(highest, 1e3 * float(np.quantile(errors, HIGHEST_QUANTILE)))
    axes.set(title="error of the hold tests, mm", xlabel="time held, s")
    if highest:
        axes.set_ylim(0.0, 1.3 * highest)
        axes.legend(loc="upper right", ncols=2, handlelength=1.2)
    else:
        _say(axes, "no hold tests in this run")


def _draw_shares(axes: Any, runs: Mapping[str, TrackResult]) -> None:
    """The share of the time, held or else in dwells, in which the error is at most so large."""
    for (name, run), colour in zip(runs.items(), RUN_COLOURS, strict=False):
        errors = hold_errors(run)
        errors = np.sort(errors if len(errors) else run.trace.error_m[run.trace.phase == "dwell"])
        if len(errors):
            axes.plot(_millimetres(errors), np.linspace(0.0, 100.0, len(errors)), color=colour, label=name)
    axes.axhline(95.0, color=FAINT, linewidth=0.9, linestyle="--")
    axes.set(title="% of the time held with an error up to", xlabel="mm", xscale="log", ylim=(0.0, 101.0))
    axes.xaxis.set_major_formatter(_plain)
    _legend(axes, runs)


def hold_errors(run: TrackResult) -> Array:
    """Return the errors (m) of the hold tests in the trace, after the way there."""
    trace = run.trace
    parts = [
        trace.error_m[(trace.visit == -1 - i) & (trace.phase == "hold") & (trace.stamps >= hold.scored_s)]
        for i, hold in enumerate(run.holds)
    ]
    return np.concatenate([*parts, np.empty(0)])


def _tour_start(run: TrackResult) -> float:
    """When the tool sets out for the second point: the way to the first is long."""
    starts = np.sort(run.visits.start_s[np.isfinite(run.visits.start_s) & (run.visits.tries == 1)])
    return float(starts[min(1, len(starts) - 1)]) if len(starts) else float(run.trace.stamps[0])


def _direction(displacement: Array) -> Array:
    _, _, axes = np.linalg.svd(displacement - displacement.mean(axis=0), full_matrices=False)
    direction: Array = axes[0] * (1.0 if axes[0][np.abs(axes[0]).argmax()] > 0.0 else -1.0)
    return direction


def _millimetres(metres: Array) -> Array:
    """For an axis of logarithms."""
    return np.clip(1e3 * metres, LEAST_MM, MOST_MM)


def _plain(value: float, _: int) -> str:
    """A tick of an axis of logarithms."""
    return f"{value:g}"


def _rms_text(metres: float) -> str:
    return f"{1e3 * metres:.2f} mm RMS" if np.isfinite(metres) else "–"


def _legend(axes: Any, runs: Mapping[str, TrackResult]) -> None:
    if len(runs) > 1 and axes.get_legend_handles_labels()[0]:
        axes.legend(handlelength=1.2)


def _say(axes: Any, text: str) -> None:
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", color=FAINT)
