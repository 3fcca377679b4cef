"""What ``ravengc calibrate`` says: one JSON object, or tables for people."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from ravengc.calibration import coverage_deg, missing_faces
from ravengc.calibration.six import nearest_face
from ravengc.cli.common import console, fixed, new_table, plain, right
from ravengc.config.toml_values import toml_value

if TYPE_CHECKING:
    import argparse

    from rich.console import Console
    from rich.table import Table

    from ravengc.calibration import Calibration, ImuRecording, LeverArm, Outcome

__all__ = ["describe", "describe_lever_arm", "show", "show_lever_arm"]


def describe(args: argparse.Namespace, outcome: Outcome) -> dict[str, Any]:
    """Everything about a calibration as plain data, as ``--json`` prints it."""
    found, positions = outcome.calibration, outcome.positions
    forces = np.array([position.force for position in positions])
    about = {
        "recording": _recording(outcome.recording),
        "method": found.method,
        "good": found.good,
        "verdict": found.verdict,
        "coverage_deg": coverage_deg(forces),
        "missing_faces": missing_faces(forces),
        "condition": found.condition,
        "direction_error_deg": math.degrees(found.direction_error),
        "residual": found.residual,
        "noise_ratio": found.noise_ratio,
        "bias": found.bias,
        "bias_error": found.bias_error,
        "correction": found.correction,
        "correction_error": found.correction_error,
        "rotation": found.rotation,
        "rotation_error_deg": None if found.rotation_error is None else np.degrees(found.rotation_error),
        "gyro_bias": outcome.gyro_bias,
        "parameters": found.parameters,
        "covariance": found.covariance,
        "positions": [
            {
                "begin_s": position.begin,
                "end_s": position.end,
                "still_s": position.duration,
                "rests": position.rests,
                "force": position.force,
                "error": position.error,
                "residual": residual,
            }
            for position, residual in zip(positions, found.residuals.tolist(), strict=True)
        ],
        "notes": [*outcome.recording.notes, *found.notes],
        "units": {"force": "m/s^2", "bias": "m/s^2", "gyro_bias": "rad/s", "time": "s"},
        "plot": None if args.plot is None else str(args.plot),
    }
    described: dict[str, Any] = plain(about)
    return described


def _recording(recording: ImuRecording) -> dict[str, Any]:
    rate = 1.0 / recording.period if recording.samples > 1 else None
    return {
        "source": recording.source,
        "samples": recording.samples,
        "duration_s": recording.duration,
        "rate_hz": rate,
        "gyroscope": recording.angular_velocity is not None,
    }


def describe_lever_arm(args: argparse.Namespace, recording: ImuRecording, found: LeverArm) -> dict[str, Any]:
    """Everything about a lever arm as plain data."""
    about = {
        "recording": _recording(recording),
        "method": "lever arm",
        "good": found.good,
        "verdict": found.verdict,
        "position": found.position,
        "position_error": found.position_error,
        "gyro_bias": found.gyro_bias,
        "gravity": found.gravity,
        "condition": found.condition,
        "residual": found.residual,
        "notes": recording.notes,
        "units": {"position": "m", "gyro_bias": "rad/s", "gravity": "m/s^2", "residual": "m/s^2"},
        "plot": None if args.plot is None else str(args.plot),
    }
    described: dict[str, Any] = plain(about)
    return described


def show(about: dict[str, Any], outcome: Outcome) -> None:
    """Print the result, the positions and the verdict."""
    out = console()
    _show_head(out, about)
    out.print(_results(outcome.calibration, outcome.gyro_bias))
    out.print(_positions(outcome))
    _show_foot(out, about)


def show_lever_arm(about: dict[str, Any], found: LeverArm) -> None:
    """Print the place of the sensor and the verdict."""
    out = console()
    _show_head(out, about)
    table = new_table("", *map(right, "xyz"))
    table.add_row("place, m", *_numbers(found.position))
    table.add_row("standard error", *_numbers(found.position_error), style="dim")
    out.print(table)
    _show_foot(out, about)


def _show_head(out: Console, about: dict[str, Any]) -> None:
    log = about["recording"]
    out.print(f"[bold]accelerometer calibration: {about['method']}[/bold]")
    rate = f" at {log['rate_hz']:.1f} Hz" if log["rate_hz"] else ""
    out.print(escape(f"{log['source']}: {log['samples']} samples, {log['duration_s']:.1f} s{rate}"), soft_wrap=True)
    if "coverage_deg" in about:
        still = sum(position["still_s"] for position in about["positions"])
        count = len(about["positions"])
        out.print(
            f"{count} positions, still for {still:.1f} s; coverage {about['coverage_deg']:.0f} degrees; "
            f"condition {about['condition']:.3g}"
        )


def _results(found: Calibration, gyro_bias: Any) -> Table:
    table = new_table("", *map(right, "xyz"))
    table.add_row("bias, m/s²", *_numbers(found.bias))
    table.add_row("standard error", *_numbers(found.bias_error), style="dim")
    _add_matrix(table, "correction S", found.correction)
    if found.correction_error.any():
        table.add_row("largest standard error", *_numbers(found.correction_error.max(axis=0)), style="dim")
    if found.rotation is not None and found.rotation_error is not None:
        _add_matrix(table, "rotation R_BS", found.rotation)
        table.add_row("standard error, deg", *_numbers(np.degrees(found.rotation_error)), style="dim")
    if gyro_bias is not None:
        table.add_row("gyro bias, rad/s", *_numbers(gyro_bias))
    return table


def _add_matrix(table: Table, name: str, matrix: Any) -> None:
    for row, label in zip(matrix, (name, "", ""), strict=True):
        table.add_row(label, *_numbers(row))


def _numbers(values: Any) -> list[str]:
    return [fixed(float(value), 5, "+") for value in values]


def _positions(outcome: Outcome) -> Table:
    headings = ("position", "from, s", "still, s", "norm, m/s²", "residual, m/s²")
    table = new_table(right(headings[0]), "up", *map(right, headings[1:]))
    residuals = outcome.calibration.residuals
    for number, (position, residual) in enumerate(zip(outcome.positions, residuals, strict=True), start=1):
        norm = fixed(float(np.linalg.norm(position.force)), 4)
        face, begin, still = nearest_face(position.force), f"{position.begin:.1f}", f"{position.duration:.1f}"
        table.add_row(str(number), face, begin, still, norm, fixed(float(residual), 4, "+"))
    return table


def _show_foot(out: Console, about: dict[str, Any]) -> None:
    for note in about["notes"]:
        out.print(f"note: {note}", markup=False)
    out.print(about["verdict"], style="green" if about["good"] else "yellow", markup=False)
    if about["written"] is not None:
        out.print(f"written: \\[accelerometer] in {escape(about['written'])}", soft_wrap=True)
    elif about["good"]:
        out.print("\\[accelerometer]")
        for key, value in about["accelerometer"].items():
            out.print(f"{key} = {toml_value(value)}", markup=False, soft_wrap=True)
    else:
        out.print("not written: too poor to be used")
    if about["plot"] is not None:
        out.print(f"plot: {about['plot']}", soft_wrap=True, markup=False)
