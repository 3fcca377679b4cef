"""What ``ravengc identify plan`` says: one JSON object, or tables for people."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.cli.common import console, fixed, new_table, plain, right

if TYPE_CHECKING:
    import argparse

    from rich.table import Table

    from ravengc.cli.identify_plan_setup import Found

__all__ = ["describe", "show"]

OPEN = "open"


def describe(args: argparse.Namespace, found: Found) -> dict[str, Any]:
    """Everything as plain data, SI, as ``--json`` prints it; null where a torque stays open."""
    from ravengc.coordinates import sliding

    spec = found.robot.spec
    about: dict[str, Any] = {
        "title": _title(found),
        "robot": spec.name,
        "joints": spec.coordinate_names,
        "units": ["N" if slides else "N·m" for slides in sliding(spec)],
        "model": found.model.kind,
        "curves": {
            label: {"tilt": curve.angles, "sd": curve.sd, "worst": curve.worst} for label, curve in found.curves.items()
        },
        "out": None if args.out is None else str(args.out),
        "plot": None if args.plot is None else str(args.plot),
    }
    if found.plan is not None:
        about |= found.plan.as_dict()
    else:
        about["judged"] = found.judged
    return dict(plain(about))


def _title(found: Found) -> str:
    from ravengc.identify import Plan

    name, plan = found.robot.spec.name, found.plan
    if plan is None:
        return f"{name}: {found.judged} poses judged"
    tilts = plan.attitudes
    steepest = np.degrees(np.arccos(np.prod(np.cos(tilts), axis=1))).max()
    on = f"on {len(tilts)} base attitudes of up to {steepest:.3g}°" if steepest > 1e-9 else "on the level base"
    if isinstance(plan, Plan):
        return f"{name}: {len(plan.q)} poses {on}"
    return f"{name}: a motion of {plan.period:g} s {on}"


def show(about: dict[str, Any]) -> None:
    """Print the tables."""
    out = console()
    out.print(about["title"], style="bold", soft_wrap=True, markup=False)
    out.print(_uncertainty_table(about))
    if "pose" in about:
        out.print(_attitude_table(about))
    if "motion" in about:
        out.print(f"condition {about['condition']:.4g}, of random motions {about['start_condition']:.4g} (median)")
    elif "condition" in about:
        out.print(f"condition {about['condition']:.4g}; {len(about['identified'])} parameters are shown")
    for what in about.get("unidentifiable", ()):
        out.print(f"not shown: {what}", soft_wrap=True, markup=False)
    for name in ("out", "plot"):
        if about[name] is not None:
            out.print(f"{name}: {about[name]}", soft_wrap=True, markup=False)
    if about["out"] is None and "judged" not in about:
        out.print("-o FILE.csv writes what to record", markup=False)


def _uncertainty_table(about: dict[str, Any]) -> Table:
    curves = about["curves"]
    tilt = math.degrees(next(iter(curves.values()))["tilt"][-1])
    table = new_table(f"torque uncertainty up to {tilt:.3g}° of tilt", *map(right, curves), "unit")
    for place, (joint, unit) in enumerate(zip(about["joints"], about["units"], strict=True)):
        values = (curve["worst"][place] for curve in curves.values())
        table.add_row(joint, *(OPEN if value is None else fixed(value, 5) for value in values), unit)
    table.caption = "standard deviation, RMS over poses, in the worst direction; open: nothing recorded shows it"
    return table


def _attitude_table(about: dict[str, Any]) -> Table:
    """How many poses on which attitude, in their order."""
    poses: dict[tuple[float, float], int] = {}
    for pose in about["pose"]:
        attitude = (pose["roll"], pose["pitch"])
        poses[attitude] = poses.get(attitude, 0) + 1
    table = new_table("the base", *map(right, ("roll, °", "pitch, °", "poses")))
    for number, ((roll, pitch), count) in enumerate(poses.items(), 1):
        table.add_row(str(number), fixed(math.degrees(roll), 2), fixed(math.degrees(pitch), 2), str(count))
    return table
