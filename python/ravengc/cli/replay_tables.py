"""What ``ravengc replay`` says: one JSON object, or tables for people."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from ravengc.cli.common import console, fixed, new_table, plain, right

if TYPE_CHECKING:
    import argparse

    from rich.table import Table

    import ravengc
    from ravengc.replay import Replay

__all__ = ["describe", "show"]


def describe(args: argparse.Namespace, robot: ravengc.Robot, replayed: Replay) -> dict[str, Any]:
    """Everything about a replay as plain data, as ``--json`` prints it."""
    recording = replayed.recording
    about = {
        "robot": robot.name,
        "mass_set": robot.spec.mass_set,
        "model": replayed.model,
        "gravity": "recorded" if replayed.gravity.ndim == 2 else replayed.gravity,
        "payload": args.payload,
        "recording": {
            "source": recording.source,
            "samples": recording.samples,
            "duration_s": recording.duration,
            "skipped_rows": dict(recording.skipped),
            "notes": [*recording.notes, *replayed.notes],
        },
        "units": {
            "t": "s",
            "q": ["m" if unit == "N" else "rad" for unit in replayed.units],
            **{name: list(replayed.units) for name in ("tau", "tau_predicted")},
        },
        "joints": [asdict(error) for error in replayed.joint_errors],
        "overall_relative_error": replayed.overall_error,
        "out": None if args.out is None else str(args.out),
        "plot": None if args.plot is None else str(args.plot),
    }
    described: dict[str, Any] = plain(about)
    return described


def show(about: dict[str, Any], replayed: Replay) -> None:
    """Print the table and its notes."""
    out, log = console(), about["recording"]
    model = "gravity torque" if replayed.model == "gravity" else "inverse dynamics"
    out.print(f"{replayed.robot}: {model} along {log['source']}", style="bold", soft_wrap=True, markup=False)
    out.print(f"{log['samples']} samples, {log['duration_s']:.2f} s; gravity {_gravity(replayed)}; nothing fitted")
    for reason, rows in log["skipped_rows"].items():
        out.print(f"[yellow]left out: {rows} x {reason}[/yellow]")
    for note in log["notes"]:
        out.print(f"note: {note}", markup=False)
    out.print(_error_table(replayed) if replayed.joint_errors else _prediction_table(replayed))
    for name in ("out", "plot"):
        if about[name] is not None:
            out.print(f"{name}: {about[name]}", soft_wrap=True, markup=False)


def _error_table(replayed: Replay) -> Table:
    headings = ("RMS measured", "RMS error", "largest error", "relative error")
    table = new_table("joint", "unit", *map(right, headings))
    for error in replayed.joint_errors:
        numbers = (error.rms_measured, error.rms_error, error.max_error)
        cells = (*(fixed(number, 4) for number in numbers), _fraction(error.relative))
        table.add_row(escape(error.name), error.unit, *cells)
    table.add_section()
    mixed = " (N·m and N together)" if len(set(replayed.units)) > 1 else ""
    table.add_row(f"all joints{mixed}", "", "", "", "", _fraction(replayed.overall_error), style="bold")
    table.caption = "relative error: ‖measured - predicted‖ / ‖measured‖ over all samples"
    return table


def _prediction_table(replayed: Replay) -> Table:
    """What was predicted, where nothing was measured."""
    table = new_table("joint", "unit", *map(right, ("RMS predicted", "least", "greatest")))
    for name, unit, torque in zip(replayed.names, replayed.units, replayed.predicted.T, strict=True):
        numbers = (float(np.sqrt(np.mean(torque**2))), torque.min(), torque.max())
        table.add_row(escape(name), unit, *(fixed(number, 4) for number in numbers))
    table.caption = "the recording has no measured torques: nothing was compared"
    return table


def _fraction(value: float | None) -> str:
    return "-" if value is None else fixed(value, 4)


def _gravity(replayed: Replay) -> str:
    if replayed.gravity.ndim == 2:
        return "as recorded"
    return f"({', '.join(f'{value:.6g}' for value in replayed.gravity)}) m/s²"
