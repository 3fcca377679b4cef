"""What ``ravengc identify fit`` says: one JSON object, or tables for people."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from ravengc.cli.common import console, fixed, new_table, plain, right
from ravengc.coordinates import sliding
from ravengc.identify import tilted_sd

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator

    from numpy.typing import NDArray
    from rich.console import Console
    from rich.table import Table

    from ravengc.cli.identify_fit_setup import Fit

__all__ = ["describe", "show"]

LONGEST_LIST = 8
TILT, MOST_POSES = np.radians(10.0), 100
"""How far the base is tilted, and in how many poses, where it is asked how sure the torques then are."""


def describe(args: argparse.Namespace, fit: Fit) -> dict[str, Any]:
    """Everything about a fit as plain data, SI, as ``--json`` prints it."""
    found = fit.found
    about = {
        "command": _command(args),
        "robot": found.given.name,
        "model": found.model.kind,
        "estimator": found.estimator,
        "logs": list(found.sources),
        "held_out_log": sorted({one.source for one in fit.held} - set(found.sources)),
        "samples": {"read": _samples(fit.read), "fitted": _samples(fit.train), "held_out": _samples(fit.held)},
        "skipped_rows": fit.skipped,
        "notes": [*fit.notes, *(_file_notes(args, fit) if args.out is not None else ())],
        "joints": _joints(fit),
        "overall": {"train": found.train.overall, "held_out": found.held_out.overall},
        "rank": found.rank,
        "columns": len(found.base.columns),
        "condition": found.condition,
        "tilt_deg": float(np.degrees(TILT)),
        "parameters": _parameters(fit),
        "coefficients": found.coefficients,
        "not_identifiable": list(found.base.unidentifiable),
        "refused": found.refused,
        "warnings": list(found.warnings),
        "no_robot_file": fit.why_no_file,
        "provenance": found.provenance,
        "out": str(args.out) if args.out is not None and fit.why_no_file is None else None,
        "report": None if args.report is None else str(args.report / "report.html"),
    }
    described: dict[str, Any] = plain(about)
    return described


def _file_notes(args: argparse.Namespace, fit: Fit) -> Iterator[str]:
    """What of the result is not in the robot file, and what of the old file."""
    found = fit.found
    if found.not_filed:
        yield f"a robot file has no form for what was identified of: {', '.join(dict.fromkeys(found.not_filed))}"
    if args.friction_share == 0.0 and {"coulomb", "viscous"} & set(found.model.terms):
        yield "the written robot has no friction for control laws to add; --friction-share 0.7 gives it most of it"
    if (before := found.given.spec.disturbances) and not found.model.disturbances:
        names = ", ".join(one.name for one in before)
        yield f"what the file has beside its masses counts as known and stays ({names}); --disturbances seeks it too"


def _command(args: argparse.Namespace) -> str:
    """What was asked for, without what was left as it is."""
    told = {"model": args.model, "estimator": args.estimator, "held-out": args.held_out, "units": args.units}
    options = [word for name, value in told.items() if value for word in (f"--{name}", str(value))]
    options += [word for joints in args.at for word in ("--at", *joints)]
    return shlex.join(["ravengc", "identify", "fit", args.robot, *args.logs, *options])


def _samples(recordings: tuple[Any, ...]) -> int:
    return sum(one.samples for one in recordings)


def _joints(fit: Fit) -> list[dict[str, Any]]:
    found, spec = fit.found, fit.found.given.spec
    floor = np.full(found.given.n, np.nan) if found.floor is None else found.floor
    sd = tilted_sd(found, _some_poses(fit), TILT)
    return [
        {
            "name": name,
            "unit": "N" if slides else "N·m",
            "rms_torque": found.held_out.torque[place],
            "train_rms": found.train.rms[place],
            "train_relative": found.train.relative[place],
            "held_out_rms": found.held_out.rms[place],
            "held_out_relative": found.held_out.relative[place],
            "floor_rms": floor[place],
            "sd_at_tilt": sd[place],
        }
        for place, (name, slides) in enumerate(zip(spec.coordinate_names, sliding(spec), strict=True))
    ]


def _some_poses(fit: Fit) -> NDArray[np.float64]:
    """Poses of the logs, spread over all of them."""
    q = np.concatenate([one.q for one in fit.train])
    return q[:: max(1, len(q) // MOST_POSES)]


def _parameters(fit: Fit) -> list[dict[str, Any]]:
    """Base parameters with what the robot's file has for them."""
    found = fit.found
    rows = zip(
        found.base.names,
        found.values,
        found.formal_sd,
        found.cross_sd,
        found.base.K @ found.model.prior(found.given),
        strict=True,
    )
    keys = ("name", "value", "formal_sd", "cross_sd", "in_file")
    return [dict(zip(keys, row, strict=True)) for row in rows]


def show(about: dict[str, Any]) -> None:
    """Print the tables, what is not shown, and the verdict."""
    out, samples = console(), about["samples"]
    logs = ", ".join(dict.fromkeys(about["logs"]))
    head = f"{about['robot']}: {about['model']} from {logs}, estimator {about['estimator']}"
    out.print(head, style="bold", soft_wrap=True, markup=False)
    held = "".join(f" ({name})" for name in about["held_out_log"])
    counts = f"{samples['read']} samples read; {samples['fitted']} fitted, {samples['held_out']} held out{held}"
    out.print(counts, soft_wrap=True, markup=False)
    for reason, rows in about["skipped_rows"].items():
        out.print(f"left out: {rows} x {reason}", style="yellow", markup=False)
    for note in about["notes"]:
        out.print(f"note: {note}", markup=False)
    out.print(_joint_table(about))
    out.print(_parameter_table(about))
    _show_open(out, about)
    _show_verdict(out, about)


def _joint_table(about: dict[str, Any]) -> Table:
    headings = ("RMS torque", "error, fitted", "error, held out", "held out, %", "floor", "± at a tilt")
    table = new_table("joint", "unit", *map(right, headings))
    for joint in about["joints"]:
        numbers = (joint["rms_torque"], joint["train_rms"], joint["held_out_rms"])
        share = "-" if joint["held_out_relative"] is None else fixed(100.0 * joint["held_out_relative"], 2)
        tilted = "unknown" if joint["sd_at_tilt"] is None else fixed(joint["sd_at_tilt"], 4)
        cells = (*map(_measured, numbers), share, _measured(joint["floor_rms"]), tilted)
        table.add_row(escape(joint["name"]), joint["unit"], *cells)
    table.add_section()
    table.add_row("all joints", "", "", "", "", fixed(100.0 * about["overall"]["held_out"], 2), "", "", style="bold")
    has_floor = any(joint["floor_rms"] is not None for joint in about["joints"])
    of_floor = "; floor: how well the motion repeats itself" if has_floor else ""
    tilt = f"; ± at a tilt: sd of the holding torque with the base tilted {about['tilt_deg']:g} degrees, any way"
    table.caption = f"RMS errors; %: of the joint's RMS torque{of_floor}{tilt}"
    return table


def _measured(value: float | None) -> str:
    """A torque, or a dash where none counts."""
    return "-" if value is None else fixed(value, 4)


def _parameter_table(about: dict[str, Any]) -> Table:
    """The base parameters, as the torques show them: sums of the links' parameters."""
    table = new_table("parameter", *map(right, ("found", "± cross-validated", "± formal", "in the file")))
    for row in about["parameters"]:
        numbers = (row["value"], row["cross_sd"], row["formal_sd"], row["in_file"])
        table.add_row(escape(row["name"]), *(fixed(value, 5) for value in numbers))
    table.caption = (
        f"{about['rank']} sums of {about['columns']} parameters show in the torques; condition"
        f" {about['condition']:.3g}; m: kg, h: kg·m, I: kg·m², friction: N·m (N) and per rad/s (m/s)"
    )
    return table


def _show_open(out: Console, about: dict[str, Any]) -> None:
    if about["not_identifiable"]:
        out.print("not identifiable from these logs:", style="bold")
        for text in about["not_identifiable"]:
            out.print(f"  {_shortened(text)}", soft_wrap=True, markup=False)


def _shortened(text: str) -> str:
    """A list of parameters and what would show them, with no more than a few of the parameters."""
    names, colon, remedy = text.partition(": ")
    mark = "; " if "; " in names else ", "
    every = names.split(mark)
    rest = f"{mark}and {len(every) - LONGEST_LIST} more" if len(every) > LONGEST_LIST else ""
    return f"{mark.join(every[:LONGEST_LIST])}{rest}{colon}{remedy}"


def _show_verdict(out: Console, about: dict[str, Any]) -> None:
    for text in about["warnings"]:
        out.print(f"weak: {text}", style="bold yellow", soft_wrap=True, markup=False)
    if about["refused"] is not None:
        out.print(f"refused: {about['refused']}", style="bold red", soft_wrap=True, markup=False)
    elif about["no_robot_file"] is not None:
        out.print(f"no robot file: {about['no_robot_file']}", style="bold yellow", soft_wrap=True, markup=False)
    for name in ("out", "report"):
        if about[name] is not None:
            out.print(f"{name}: {about[name]}", soft_wrap=True, markup=False)
