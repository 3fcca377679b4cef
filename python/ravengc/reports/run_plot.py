"""A run as a picture: the base, the gravity vector the loop saw, who gave the torque, and the joint errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.monitored import STATES
from ravengc.reports.base_curves import base_curves
from ravengc.reports.figures import AXIS_COLOURS, FAINT, INK, STYLE, require_matplotlib, save_figure

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.loop import Record
    from ravengc.sim import PrescribedBase

__all__ = ["plot_run"]

Array = NDArray[np.float64]

GRAVITY_COLOUR, PD_COLOUR, DISTURBANCE_COLOUR = "#2a7f9e", "#d1603d", "#6b4f9e"
STATE_COLOURS = {
    "no_data": "#e3e3e3",
    "nominal": "#e3e3e3",
    "held": "#f6e3a1",
    "degraded": "#f2c79b",
    "fault": "#eda6a0",
}
ABOVE = {
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 0.98),
    "ncols": 6,
    "handlelength": 1.2,
    "columnspacing": 1.0,
    "borderaxespad": 0.0,
}


def plot_run(
    path: Path, record: Record, base: PrescribedBase, *, title: str, joints: tuple[str, ...], slides: NDArray[np.bool_]
) -> None:
    """Draw a run into a file (png, svg, pdf): base and gravity on top, and a row per joint with torques and error.

    The torque of disturbance elements is drawn where the robot has any.
    """
    matplotlib = require_matplotlib("a picture of the run")
    rows = slice(0, record.count)
    time = record.time[rows]
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(10.5, 1.9 + 1.55 * len(joints)), layout="constrained")
        axes = figure.subplots(1 + len(joints), 2, sharex=True, squeeze=False)
        figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        _draw_base(axes[0, 0], time, base)
        _draw_gravity(axes[0, 1], time, record.gravity[rows], record.sensor_state[rows])
        for i, (name, slide) in enumerate(zip(joints, slides, strict=True)):
            _draw_torque(axes[1 + i, 0], record, i, f"{name}: force, N" if slide else f"{name}: torque, N·m")
            _draw_error(axes[1 + i, 1], time, record.q_desired[rows, i] - record.q[rows, i], name, slides=bool(slide))
        axes[1, 0].legend(**ABOVE)
        for bottom in axes[-1]:
            bottom.set_xlabel("time, s")
            if len(time) > 1:
                bottom.set_xlim(time[0], time[-1])
        save_figure(figure, path)


def _draw_base(axes: Any, time: Array, base: PrescribedBase) -> None:
    """Angles on the left, accelerations on the right, or on the left where nothing turns."""
    curves = base_curves(base, time)
    turns, slides = ([curve for curve in curves if curve.turns is kind] for kind in (True, False))
    places = [axes, axes.twinx() if turns and slides else axes]
    colours = iter((INK, *AXIS_COLOURS, GRAVITY_COLOUR, PD_COLOUR))
    for curve in curves:
        style = {} if curve.turns or not turns else {"linestyle": "--"}
        places[not curve.turns].plot(time, curve.values, color=next(colours), label=curve.name, **style)
    axes.set_title("base" if turns and slides else "base acceleration, m/s²" if slides else "base angle, deg")
    if len(curves) > 1:
        handles = [line for place in dict.fromkeys(places) for line in place.get_lines()]
        axes.legend(handles=handles, **ABOVE)
    if places[1] is not axes:
        axes.set_ylabel("deg")
        places[1].set_ylabel("m/s²")
        places[1].spines["right"].set_visible(True)
        places[1].grid(visible=False)


def _draw_gravity(axes: Any, time: Array, gravity: Array, state: NDArray[np.int8]) -> None:
    """The gravity vector; where the sensor was not live, in front of the state's colour."""
    for number, name in enumerate(STATES):
        where = state == number
        if name != "live" and where.any():
            span = {"transform": axes.get_xaxis_transform(), "linewidth": 0.0, "color": STATE_COLOURS[name]}
            axes.fill_between(time, 0.0, 1.0, where=where, step="post", label=name.replace("_", " "), **span)
    for name, colour, component in zip("xyz", AXIS_COLOURS, gravity.T, strict=True):
        axes.plot(time, component, color=colour, label=f"g{name}")
    axes.set_title("gravity used, m/s²")
    axes.legend(**ABOVE)


def _draw_torque(axes: Any, record: Record, joint: int, title: str) -> None:
    """The terms of the law."""
    rows = slice(0, record.count)
    time, gravity = record.time[rows], record.tau_gravity[rows, joint]
    axes.fill_between(time, gravity, color=GRAVITY_COLOUR, alpha=0.18, linewidth=0.0)
    axes.plot(time, gravity, color=GRAVITY_COLOUR, label="gravity term")
    if record.tau_disturbance[rows].any():
        axes.plot(time, record.tau_disturbance[rows, joint], color=DISTURBANCE_COLOUR, label="disturbance term")
    axes.plot(time, record.tau_pd[rows, joint], color=PD_COLOUR, label="PD term")
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    axes.set_title(title)


def _draw_error(axes: Any, time: Array, error: Array, name: str, *, slides: bool) -> None:
    axes.plot(time, 1e3 * error if slides else np.rad2deg(error), color=INK)
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    axes.set_title(f"{name}: error, {'mm' if slides else 'deg'}")
