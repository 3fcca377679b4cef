"""A replay as a picture: measured and predicted torque of every joint, and what is left between them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.reports.figures import FAINT, INK, MEASURED, PREDICTED, STYLE, require_matplotlib, save_figure

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ravengc.replay import Replay

__all__ = ["plot_replay"]

RESIDUAL = "#d1603d"
ROW_HEIGHT = 1.45


def plot_replay(path: Path, replay: Replay) -> None:
    """Draw a replay into the file ``path`` (png, svg, pdf), a row per joint: torques, and their difference."""
    matplotlib = require_matplotlib("a picture of the replay")
    rows = len(replay.names)
    with matplotlib.rc_context(STYLE):
        figure = matplotlib.figure.Figure(figsize=(11.0, 1.1 + ROW_HEIGHT * rows), layout="constrained")
        axes = figure.subplots(rows, 2, sharex=True, squeeze=False, width_ratios=(2.0, 1.0))
        figure.suptitle(_title(replay), x=0.01, ha="left", fontsize=11.5, fontweight="bold", color=INK)
        for joint in range(rows):
            _draw_torques(axes[joint, 0], replay, joint)
            _draw_residual(axes[joint, 1], axes[joint, 0], replay, joint)
        handles, labels = axes[0, 0].get_legend_handles_labels()
        axes[0, 0].legend(handles, labels, loc="lower right", ncols=2, bbox_to_anchor=(1.0, 0.97))
        for bottom in axes[-1]:
            bottom.set_xlabel("time, s")
            bottom.set_xlim(replay.recording.t[0], replay.recording.t[-1] + 1e-9)
        save_figure(figure, path)


def _title(replay: Replay) -> str:
    model = "gravity torque" if replay.model == "gravity" else "inverse dynamics"
    overall = replay.overall_error
    error = "" if overall is None else f", relative error {overall:.4f}"
    return f"{replay.robot}: {model} along {Path(replay.recording.source).name}{error}"


def _draw_torques(axes: Any, replay: Replay, joint: int) -> None:
    t, measured = replay.recording.t, replay.recording.tau
    if measured is not None:
        axes.plot(t, measured[:, joint], color=MEASURED, linewidth=2.2, label="measured")
    axes.plot(t, replay.predicted[:, joint], color=PREDICTED, label="predicted")
    axes.set_title(f"{replay.names[joint]}, {replay.units[joint]}")


def _draw_residual(axes: Any, torques: Any, replay: Replay, joint: int) -> None:
    """The residual at the scale of the torques beside it, so that its size can be compared."""
    residual = replay.residual
    if residual is None:
        axes.set_axis_off()
        return
    error = replay.joint_errors[joint]
    relative = "" if error.relative is None else f" ({100.0 * error.relative:.1f} %)"
    _fill(axes, replay.recording.t, residual[:, joint])
    low, high = torques.get_ylim()
    reach = max(0.5 * (high - low), float(abs(residual[:, joint]).max()) * 1.05)
    axes.set_ylim(-reach, reach)
    axes.set_title(f"residual: RMS {error.rms_error:.3g} {error.unit}{relative}")


def _fill(axes: Any, t: NDArray[np.float64], residual: NDArray[np.float64]) -> None:
    axes.fill_between(t, residual, color=RESIDUAL, alpha=0.25, linewidth=0.0)
    axes.plot(t, residual, color=RESIDUAL, linewidth=0.8)
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
