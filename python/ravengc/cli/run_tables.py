"""What ``ravengc run`` says: one JSON object, or tables for people."""

from __future__ import annotations

from dataclasses import asdict
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.markup import escape

from ravengc import FAULTS
from ravengc.cli.common import console, fixed, new_table, plain, right
from ravengc.cli.run_sensor import OWN
from ravengc.control import CONTROLLER_STATES, EVENTS, LAWS
from ravengc.monitored import STATES

if TYPE_CHECKING:
    import argparse

    from rich.table import Table

    from ravengc.cli.run_setup import Setup
    from ravengc.reports.run_summary import RunSummary

__all__ = ["describe", "show"]

NOT_FELT = "it does not feel the simulated base, so the PD share says nothing of the law"
HARDLY_FED = 1e-6
"""Share of the largest term of gravity and disturbances below which a joint has none, and its PD share says nothing."""


def describe(args: argparse.Namespace, setup: Setup, summary: RunSummary) -> dict[str, Any]:
    """Everything about a run as plain data: the log's metadata, and what ``--json`` prints."""
    robot, drive, record = setup.robot, setup.drive, setup.loop.record
    about = {
        "version": version("ravengc"),
        "title": f"{robot.name}, {LAWS[args.controller].title}, base {setup.base.description}",
        "robot": robot.name,
        "mass_set": robot.spec.mass_set,
        "joints": list(robot.joint_names),
        "controller": args.controller,
        "motion": args.motion,
        "base": setup.base.description,
        "pivot_m": list(args.pivot),
        "mount": args.mount,
        "sensor": args.sensor,
        "sensor_place_m": args.sensor_place,
        "sensor_rate_hz": args.sensor_rate,
        "noise_m_s2": args.noise,
        "sensor_states": list(STATES),
        "sensor_counters": setup.sensor.accelerometer.counters,
        "controller_states": list(CONTROLLER_STATES),
        "controller_counters": setup.loop.controller.counters,
        "seed": args.seed,
        "rate_hz": args.rate,
        "duration_s": args.duration,
        "paced": not args.fast,
        "real_time": record.real_time,
        "interrupted": record.interrupted,
        "gains": {
            "source": drive.source,
            "kp": drive.kp,
            "kd": drive.kd,
            "rotor_inertia": drive.rotor_inertia,
        },
        "coulomb": args.coulomb,
        "viscous": args.viscous,
        "units": _units(setup),
        "summary": asdict(summary),
        "log": str(args.log),
        "plot": None if args.plot is None else str(args.plot),
    }
    described: dict[str, Any] = plain(about)
    return described


def show(about: dict[str, Any], setup: Setup, summary: RunSummary) -> None:
    """Print the tables."""
    out = console()
    out.print(about["title"], style="bold", soft_wrap=True, markup=False)
    out.print(f"gains: {about['gains']['source']}")
    out.print(_pace(about, summary))
    out.print(_loop_table(summary))
    out.print(_sensor_table(setup, summary))
    for words in filter(None, (*about["sensor_verdicts"], about["sensor_remark"])):
        out.print(f"base sensor: {words}", style="yellow", soft_wrap=True, markup=False)
    if about["sensor"] != OWN:
        out.print(f"base sensor: {NOT_FELT}", style="yellow", soft_wrap=True)
    out.print(_joint_table(setup, summary))
    if events := [f"{EVENTS[name]} ({count} cycles)" for name, count in _events(about).items() if count]:
        out.print(f"controller: {'; '.join(events)}", soft_wrap=True)
    if not summary.finite:
        out.print("[bold red]The arm ran away: its motion is not finite.[/bold red]")
    for name in ("log", "plot"):
        if about[name] is not None:
            out.print(f"{name}: {about[name]}", soft_wrap=True, markup=False)


def _events(about: dict[str, Any]) -> dict[str, int]:
    """What happened to the controller, and in how many cycles."""
    return {name: count for name, count in about["controller_counters"].items() if name in EVENTS}


def _pace(about: dict[str, Any], summary: RunSummary) -> str:
    """How many cycles ran, and how."""
    priority = "real-time" if about["real_time"] else "normal"
    pace = f"at {about['rate_hz']:g} Hz, {priority} priority" if about["paced"] else "unpaced"
    stopped = ", stopped by Ctrl-C" if about["interrupted"] else ""
    return f"{summary.cycles} cycles {pace}{stopped}; {summary.late_cycles} late, {summary.skipped_cycles} skipped"


def _loop_table(summary: RunSummary) -> Table:
    """How punctual the loop was."""
    table = new_table("loop", right("p50"), right("p99.9"), right("max"))
    for name, spread in (
        ("cycle time: law and gravity, µs", summary.compute_us),
        ("start after the deadline, µs", summary.lateness_us),
    ):
        table.add_row(name, f"{spread.p50:.1f}", f"{spread.p99_9:.1f}", f"{spread.max:.1f}")
    return table


def _sensor_table(setup: Setup, summary: RunSummary) -> Table:
    """How far the base sensor could be trusted, and what was wrong with it."""
    counters = setup.sensor.accelerometer.counters
    table = new_table("base sensor", right("seconds"), "what was found", right("times"), "which means")
    found = [(name, count) for name, count in counters.items() if name in FAULTS and count]
    states = [(name, seconds) for name, seconds in summary.sensor_seconds.items() if seconds > 0.0]
    for row in range(max(len(states), len(found), 1)):
        state, seconds = states[row] if row < len(states) else ("", None)
        fault, count = found[row] if row < len(found) else ("nothing" if not found and row == 0 else "", None)
        times = "" if count is None else str(count)
        table.add_row(state, "" if seconds is None else f"{seconds:.2f}", fault, times, FAULTS.get(fault, ""))
    return table


def _joint_table(setup: Setup, summary: RunSummary) -> Table:
    """How well the joints followed, and who gave the torque."""
    terms = {"RMS torque": summary.rms_torque, "gravity term": summary.rms_gravity}
    if summary.rms_disturbance.any():
        terms["disturbance term"] = summary.rms_disturbance
    terms["PD term"] = summary.rms_pd
    table = new_table("joint", *map(right, ("RMS error", *terms, "PD share")))
    fed = summary.rms_gravity + summary.rms_disturbance
    shared = (fed > HARDLY_FED * fed.max()) | (fed.max() == 0.0)
    for i, (name, slides) in enumerate(zip(setup.robot.joint_names, setup.sliding, strict=True)):
        rms_error, unit = (1e3 * summary.rms_error[i], "mm") if slides else (np.rad2deg(summary.rms_error[i]), "deg")
        error = f"{fixed(rms_error, 3)} {unit}"
        torques = (f"{fixed(values[i], 3)} {'N' if slides else 'N·m'}" for values in terms.values())
        share = _percent(summary.pd_share[i]) if shared[i] else "-"
        table.add_row(escape(name), error, *torques, share)
    table.add_section()
    table.add_row("all turning", "", *("" for _ in terms), _percent(summary.pd_share_revolute))
    return table


def _percent(share: float) -> str:
    return "-" if np.isnan(share) else f"{100.0 * share:.1f} %"


def _units(setup: Setup) -> dict[str, str | list[str]]:
    """The unit of every column of the log, one for each joint where turning and sliding joints differ."""
    of_joints: dict[str, tuple[str, str]] = {
        **dict.fromkeys(("q", "q_desired"), ("rad", "m")),
        "qd": ("rad/s", "m/s"),
        **dict.fromkeys(("tau_pd", "tau_gravity", "tau_disturbance", "tau"), ("N m", "N")),
    }
    return {
        "time": "s",
        **{name: [units[int(slides)] for slides in setup.sliding] for name, units in of_joints.items()},
        "gravity": "m/s^2, base axes",
        "sensor_age": "s",
        "sensor_state": "number in sensor_states",
        "sensor_status": "bits of alarms in the order of ravengc.FAULTS, 32 bits higher what was seen in the cycle",
        "controller_state": "number in controller_states",
        "controller_status": "bits of events in the order of ravengc.control.EVENTS, 32 bits higher those of the cycle",
        "compute_ns": "ns",
        "lateness_ns": "ns",
        "late": "1 if the next deadline was missed, else 0",
    }
