"""An identification as pictures: measured and predicted torques of every joint, and how sure every number is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.coordinates import sliding
from ravengc.reports.figures import FAINT, INK, MEASURED, PREDICTED, STYLE, require_matplotlib

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from ravengc.identify import Identification, Recording

    Array = NDArray[np.float64]

__all__ = ["PURPOSE", "contributions", "draw_torques", "draw_uncertainty"]

PURPOSE = "the report of an identification"
HELD_OUT = "#d1603d"
ROW_HEIGHT, LINE_HEIGHT = 1.45, 0.2
MOST_POINTS, MOST_ROWS, LONGEST_NAME = 4000, 400, 44
BLOCK, MARGIN = 20_000, 500
"""Samples that are predicted together, and those on both sides that filters look at."""
LEAST = 1e-6
"""Share of the largest contribution below which a parameter is drawn at the edge."""


@dataclass(frozen=True)
class _Piece:
    """A part of a log in the picture: where it is drawn, what was measured and predicted, and what it is."""

    x: Array
    measured: Array
    predicted: Array
    held: bool
    dense: bool


def draw_torques(found: Identification, train: Sequence[Recording], held: Sequence[Recording]) -> Any:
    """Draw a row per joint, torques and what is left of them; matplotlib's Figure, MissingExtraError without it."""
    matplotlib = require_matplotlib(PURPOSE)
    pieces = list(_pieces(found, train, held))
    names = found.given.spec.coordinate_names
    units = ["N" if slides else "N·m" for slides in sliding(found.given.spec)]
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(11.0, 1.1 + ROW_HEIGHT * len(names)), layout="constrained")
        axes = figure.subplots(len(names), 2, sharex=True, squeeze=False, width_ratios=(2.0, 1.0))
        figure.suptitle(_title(found), x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        for joint, (name, unit) in enumerate(zip(names, units, strict=True)):
            _draw_joint(axes[joint, 0], pieces, joint)
            axes[joint, 0].set_title(f"{name}, {unit}")
            _draw_residual(axes[joint, 1], pieces, joint)
            axes[joint, 1].set_title(_errors(found, joint, unit))
        _legend(axes[0, 0])
        for bottom in axes[-1]:
            bottom.set_xlabel("time of the logs one after the other, s" if pieces[0].dense else "pose, or time in s")
    return figure


def _title(found: Identification) -> str:
    held = f"{100.0 * found.held_out.overall:.2f} % error held out"
    return f"{found.given.name}: {found.model.kind}, {found.estimator}, {held}"


def _errors(found: Identification, joint: int, unit: str) -> str:
    """The held-out error of a joint, and the floor under it."""
    if not found.held_out.samples[joint]:
        return "no torque counts"
    share = f"{100.0 * found.held_out.relative[joint]:.1f} %"
    error = f"left, held out: RMS {found.held_out.rms[joint]:.3g} {unit} ({share})"
    known = found.floor is not None and np.isfinite(found.floor[joint])
    return f"{error}, floor {found.floor[joint]:.3g}" if known and found.floor is not None else error


def _pieces(found: Identification, train: Sequence[Recording], held: Sequence[Recording]) -> Iterator[_Piece]:
    """All recordings, log after log, on one axis."""
    offset, starts = 0.0, {}
    for one in (*train, *held):
        if one.source not in starts:
            parts = [part for part in (*train, *held) if part.source == one.source]
            first, last = min(part.stamps[0] for part in parts), max(part.stamps[-1] for part in parts)
            starts[one.source] = offset - first
            offset += 1.05 * (last - first) + 1e-9
    for is_held, one in [*((False, one) for one in train), *((True, one) for one in held)]:
        rows = slice(None, None, max(1, one.samples // MOST_POINTS))
        x = one.stamps[rows] + starts[one.source]
        measured = np.where(one.counts, one.tau, np.nan)[rows]
        yield _Piece(x, measured, _predicted(found, one)[rows], is_held, _is_dense(one))


def _predicted(found: Identification, recording: Recording) -> Array:
    """Predicted torques, block by block: the columns of a long log do not fit into memory at once."""
    blocks = []
    for first in range(0, recording.samples, BLOCK):
        start = max(first - MARGIN, 0)
        part = found.predict(recording.take(slice(start, first + BLOCK + MARGIN)))
        blocks.append(part[first - start : first - start + BLOCK])
    return np.concatenate(blocks)


def _is_dense(recording: Recording) -> bool:
    return recording.samples > 8 and float(np.median(np.diff(recording.stamps))) < 0.5


def _draw_joint(axes: Any, pieces: Sequence[_Piece], joint: int) -> None:
    for piece in pieces:
        colour, word = (HELD_OUT, "held out") if piece.held else (PREDICTED, "fitted")
        wide = {"linewidth": 2.2, "markersize": 8.0, **_style(piece)}
        axes.plot(piece.x, piece.measured[:, joint], color=MEASURED, label="measured", **wide)
        fine = {"markersize": 4.0, **_style(piece)}
        axes.plot(piece.x, piece.predicted[:, joint], color=colour, label=f"predicted, {word}", **fine)


def _style(piece: _Piece) -> dict[str, str]:
    """A line for a motion, dots for poses."""
    return {"linestyle": "-", "marker": "none"} if piece.dense else {"linestyle": "none", "marker": "."}


def _draw_residual(axes: Any, pieces: Sequence[_Piece], joint: int) -> None:
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    for piece in pieces:
        left, colour = piece.measured[:, joint] - piece.predicted[:, joint], HELD_OUT if piece.held else PREDICTED
        axes.plot(piece.x, left, color=colour, linewidth=0.8, markersize=3.0, **_style(piece))


def _legend(axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    axes.legend(unique.values(), unique.keys(), loc="lower right", ncols=3, bbox_to_anchor=(1.0, 0.97))


def draw_uncertainty(found: Identification, train: Sequence[Recording]) -> Any:
    """Draw the errors of every joint, and every parameter's torque with its error bar; matplotlib's Figure."""
    matplotlib = require_matplotlib(PURPOSE)
    size, cross, formal = contributions(found, train)
    with matplotlib.rc_context(STYLE):
        height = 1.3 + LINE_HEIGHT * max(len(size), 2 * found.given.n, 8)
        figure = matplotlib.figure.Figure(figsize=(11.0, height), layout="constrained")
        joints, parameters = figure.subplots(1, 2, width_ratios=(1.0, 1.6))
        _draw_joint_errors(joints, found)
        _draw_parameters(parameters, found, size, cross, formal)
    return figure


def contributions(found: Identification, train: Sequence[Recording]) -> tuple[Array, Array, Array]:
    """What every base parameter adds to the torques (RMS over all joints, N·m or N), and its two uncertainties."""
    total, rows = np.zeros(found.rank), 0
    for one in train:
        some = replace(one.take(slice(None, None, max(1, one.samples // MOST_ROWS))), cutoff_hz=None)
        columns = found.model.regressor(found.given, some)[:, found.base.chosen]
        counted = columns[some.counts.ravel()]
        total += (counted**2).sum(axis=0)
        rows += len(counted)
    scale = np.sqrt(total / rows)
    return np.abs(found.values) * scale, found.cross_sd * scale, found.formal_sd * scale


def _draw_joint_errors(axes: Any, found: Identification) -> None:
    names = found.given.spec.coordinate_names
    places = np.arange(len(names))
    bars = [("fitted", found.train.relative, PREDICTED), ("held out", found.held_out.relative, HELD_OUT)]
    shift = 0.5 * (len(bars) - (found.floor is None))
    if found.floor is not None:
        bars.append(("floor", found.floor / np.maximum(found.held_out.torque, 1e-12), FAINT))
    for number, (label, values, colour) in enumerate(bars):
        axes.barh(places + 0.26 * (number - shift), 100.0 * values, 0.24, color=colour, label=label)
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_title("error, % of the joint's RMS torque")
    axes.legend(loc="best")


def _draw_parameters(axes: Any, found: Identification, size: Array, cross: Array, formal: Array) -> None:
    """Dots left of their bars are not determined: the bar ends at two cross-validated standard deviations."""
    least = LEAST * float(size.max(initial=1e-12))
    places = np.arange(len(size))
    axes.barh(places, np.maximum(2.0 * cross, least), 0.62, color="#e3e6ea", label="±2 sd, cross-validated")
    axes.plot(np.maximum(2.0 * formal, least), places, "|", color=FAINT, markersize=7.0, label="±2 sd, formal")
    axes.plot(np.maximum(size, least), places, "o", color=INK, markersize=3.5, label="found")
    axes.set_yticks(places, [_short(name) for name in found.base.names], fontsize=7)
    axes.set(xscale="log", title="torque of every parameter, RMS, N·m or N\n(one within its bar is not determined)")
    axes.set_xlim(left=0.3 * max(least, float(np.minimum(size, 2.0 * formal + least).min(initial=1.0))))
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.0), borderaxespad=2.4, ncols=3)


def _short(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - 3]}..."
