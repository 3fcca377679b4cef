"""What ``ravengc stability`` says: one JSON object, or tables for people."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from ravengc.cli.common import console, fixed, new_table, right

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from ravengc.cli.stability_setup import Setup
    from ravengc.stability import Mode, Tally

__all__ = ["describe", "show", "show_campaign"]


def describe(setup: Setup) -> dict[str, Any]:
    """Everything as plain data, SI, as ``--json`` prints it."""
    robot, sensing, mount, m = setup.robot, setup.system.sensing, setup.mount, setup.system.base
    return {
        "title": setup.title,
        "robot": robot.name,
        "mass_set": robot.spec.mass_set,
        "q": setup.q,
        "law": setup.law,
        "gains": {"source": setup.drive.source, "kp": setup.drive.kp, "kd": setup.drive.kd},
        "base": {
            "directions": list(mount.names),
            "mass": mount.mass,
            "mass_with_arm": setup.system.mass[:m, :m],
            "stiffness": setup.system.stiffness[:m, :m],
            "damping": setup.system.damping[:m, :m],
        },
        "sensing": {**asdict(sensing), "delay_s": sensing.delay_s, "lag_s": sensing.lag_s},
        **setup.certificate.as_dict(),
        "remedies": [asdict(remedy) for remedy in setup.remedies],
    }


def show(setup: Setup, about: dict[str, Any]) -> None:
    """Print the tables."""
    out = console()
    out.print(setup.title, style="bold", soft_wrap=True, markup=False)
    out.print(f"gains: {setup.drive.source}; {_sensor_text(setup)}", soft_wrap=True, markup=False)
    out.print(_numbers_table(setup))
    out.print(_mode_table(setup))
    _show_verdict(out, setup)
    if "plot" in about:
        out.print(f"plot: {about['plot']}", soft_wrap=True, markup=False)


def show_campaign(tallies: tuple[Tally, ...], seed: int) -> None:
    """Print what random cases did."""
    from ravengc.stability.trials import BAND

    out = console()
    headings = ("cases", "certified", "of these grew", "not certified", "of these grew", "near-marginal", "uncertain")
    table = new_table("random cases", *map(right, headings))
    for tally in tallies:
        numbers = (tally.cases, tally.certified, tally.certified_grew, tally.unstable, tally.unstable_grew)
        near = f"{tally.near} ({tally.near_certified_grew} certified grew)"
        table.add_row(tally.kind, *map(str, numbers), near, str(tally.uncertain))
    out.print(table)
    near = f"rightmost pole s with |Re s| < {BAND:g} |s|, or a high-frequency gain within 5 % of 1"
    out.print(f"seed {seed}; near-marginal: {near}")
    holds = all(tally.holds for tally in tallies)
    out.print("nothing certified grew" if holds else "[bold red]something certified grew[/bold red]")


def _sensor_text(setup: Setup) -> str:
    sensing = setup.system.sensing
    lowpass = "no low-pass"
    if sensing.cutoff_hz is not None:
        lowpass = f"low-pass {sensing.cutoff_hz:g} Hz of order {sensing.order}"
    late = f"{1e3 * sensing.latency_s:g} ms late, held {1e3 * sensing.hold_s:g} ms on average"
    return f"sensor: {late}, {lowpass}, share fed {sensing.gain:g}"


def _numbers_table(setup: Setup) -> Table:
    """Poles and margins."""
    certificate = setup.certificate
    count, pole = certificate.count, certificate.pole
    table = new_table("feedback", right("value"), "")
    unstable = "infinitely many" if math.isinf(count.number) else "?" if math.isnan(count.number) else f"{count.number}"
    proof = f"proven: {count.pieces} pieces, none beyond {count.radius:.4g} rad/s" if count.proven else "not proven"
    table.add_row("unstable poles", unstable, proof)
    proven = "none further right" if pole.proven else "further right: not proven"
    table.add_row("rightmost pole, 1/s", f"{pole.s.real:+.4f} ± {abs(pole.s.imag):.3f}i", proven)
    table.add_row("gain margin, dB", _decibel(certificate.margin_db), _gain_text(certificate.margins.critical_gains))
    worst = certificate.margins.worst_hz
    where = "" if math.isnan(worst) else f"at {worst:.3g} Hz, the worst frequency"
    table.add_row("smallest |1 + L|", f"{certificate.margins.distance:.3f}", where)
    return table


def _mode_table(setup: Setup) -> Table:
    """What is left of the damping of every swing of the base."""
    table = new_table("swing of the base", *map(right, ("Hz", "damping c", "c_eff", "c_eff / c", "ratio")))
    for mode in setup.certificate.modes:
        share = "-" if not math.isfinite(mode.share) else f"{100.0 * mode.share:.0f} %"
        table.add_row(
            escape(_shape(setup, mode)),
            f"{mode.frequency_hz:.3f}",
            f"{fixed(mode.damping, 3)} {_unit(setup, mode)}",
            fixed(mode.effective_damping, 3),
            share,
            f"{mode.effective_ratio:.4f}",
        )
    return table


def _shape(setup: Setup, mode: Mode) -> str:
    """The directions that take part, the largest first."""
    parts = sorted(zip(mode.shape, setup.mount.names, strict=True), key=lambda part: -abs(part[0]))
    told = [name if part == 1.0 else f"{part:+.2f} {name}" for part, name in parts if abs(part) >= 0.05]
    return " ".join(told)


def _unit(setup: Setup, mode: Mode) -> str:
    largest = max(range(len(mode.shape)), key=lambda i: abs(mode.shape[i]))
    return "N m s/rad" if setup.system.turns[largest] else "N s/m"


def _decibel(margin: float) -> str:
    return "unlimited" if margin == math.inf else "none" if margin == -math.inf else f"{margin:+.2f}"


def _gain_text(critical: tuple[float, ...]) -> str:
    return f"a pole is on the axis at {critical[0]:.3g} times the gain" if critical else ""


def _show_verdict(out: Console, setup: Setup) -> None:
    certificate = setup.certificate
    colour = "red" if not certificate.certified else "yellow" if certificate.cautions else "green"
    out.print(certificate.verdict, style=f"bold {colour}", soft_wrap=True, markup=False)
    for caution in certificate.cautions:
        out.print(f"  but {caution}", soft_wrap=True, markup=False)
    if not certificate.certified:
        out.print("What to change; each alone is enough, unless it says otherwise:", soft_wrap=True)
        for remedy in setup.remedies:
            mark = "-" if remedy.value is not None else "x"
            out.print(f"  {mark} {remedy.text}", soft_wrap=True, markup=False)
