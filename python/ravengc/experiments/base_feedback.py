"""Can the arm and the base's accelerometer feed each other? The paper's last open question (section VII).

The gravity torque follows the accelerometer, the arm pushes its base, the accelerometer feels it. On a light, weakly
damped base with a late sensor that loop grows. Here: one link on a springy base, its frequency response and poles, a
nonlinear simulation beside them, and the RAVEN on light mounts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.control import raven2_drive
from ravengc.errors import ConfigError
from ravengc.experiments.drawing import LAW_COLOURS, PALETTE, legend_below, line_axes
from ravengc.experiments.experiment import Experiment, Finding, Outcome, Table, finding
from ravengc.experiments.one_link_run import STEP_S, growth_of, swing
from ravengc.experiments.raven import held_pose, raven
from ravengc.experiments.settings import Settings, setting
from ravengc.stability import OneLink, Sensing, certify, linearise, parse_mount

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from ravengc.stability import Certificate

__all__ = ["BASE_FEEDBACK", "CASES", "POLES", "BaseFeedback", "link_of"]

Array = NDArray[np.float64]

CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "unstable": ("as set: late sensor, light damping", {}),
    "prompt": ("no delay, low-pass 100 Hz", {"latency_s": 0.0, "cutoff_hz": 100.0}),
    "damped": ("damping ratio 0.05", {"base_damping_ratio": 0.05}),
    "stiff": ("K_P and K_D four times as large", {"kp_factor": 4.0}),
    "static": ("static gravity: nothing fed back", {"gain": 0.0}),
}
POLES = {"unstable": 0.1696 + 15.201j, "prompt": -0.1294 + 15.686j, "damped": -0.3263, "stiff": -0.0761}
"""Rightmost poles of the cases with the default settings, 1/s: an independent computation."""
EFFECTIVE_DAMPING, CRITICAL_DELAY_S, GROWTH = -5.138, 0.01037, 0.1717
MOUNTS = {"cart, 15 kg, 2 Hz, damping ratio 0.01": "15:2:0.01:x", "stand, 5 kg, 3 Hz, 0.01": "5:3:0.01:x"}
RAVEN_SENSING = Sensing(rate_hz=None, latency_s=0.03)
LONGEST_DELAY_S, DELAY_STEP_S = 0.2, 0.001


@dataclass(frozen=True, kw_only=True)
class BaseFeedback(Settings):
    """Settings of ``base-feedback``."""

    base_mass: float = setting(10.0, 0.01, 1e5, "kg", "mass of the base")
    base_hz: float = setting(2.5, 0.05, 100.0, "Hz", "frequency at which base and arm swing together")
    damping_ratio: float = setting(0.01, 0.0, 1.0, "", "damping ratio of the base")
    mass: float = setting(2.0, 0.01, 1e4, "kg", "mass of the link")
    length: float = setting(0.4, 0.0, 10.0, "m", "centre of mass from the joint")
    inertia: float = setting(0.37, 1e-4, 1e5, "kg m^2", "inertia about the joint, rotor included")
    kp: float = setting(150.0, 0.1, 1e7, "N m/rad", "K_P")
    kd: float = setting(3.0, 0.0, 1e6, "N m s/rad", "K_D")
    cutoff_hz: float = setting(10.0, 0.1, 1000.0, "Hz", "first-order low-pass of the accelerometer")
    latency_s: float = setting(0.02, 0.0, 0.2, "s", "pure delay from acceleration to torque")
    gain: float = setting(1.0, 0.0, 2.0, "", "share of the measured acceleration that the law compensates")
    start: float = setting(1e-4, 1e-9, 0.01, "m", "simulation: first displacement of the base")
    duration_s: float = setting(20.0, 2.0, 120.0, "s", "simulation: time")

    def check(self) -> None:
        """Raise ConfigError for an inertia that no such link has."""
        least = self.mass * self.length**2
        if self.inertia < least:
            raise ConfigError(f"inertia is {self.inertia:g}; expected at least mass x length^2, {least:g} kg m^2")


def link_of(settings: BaseFeedback, case: str = "unstable") -> OneLink:
    """Return the link on its base, as set, in one of :data:`CASES`."""
    sensing = Sensing(
        rate_hz=None, latency_s=settings.latency_s, cutoff_hz=settings.cutoff_hz, order=1, gain=settings.gain
    )
    changes = dict(CASES[case][1])
    factor = changes.pop("kp_factor", 1.0)
    link = OneLink(
        base_mass=settings.base_mass,
        base_frequency_hz=settings.base_hz,
        base_damping_ratio=settings.damping_ratio,
        mass=settings.mass,
        length=settings.length,
        inertia=settings.inertia,
        kp=factor * settings.kp,
        kd=factor * settings.kd,
        sensing=sensing,
    )
    return link.with_(**changes)


def _tasks(settings: BaseFeedback) -> list[tuple[BaseFeedback, str]]:
    return [(settings, name) for name in (*CASES, "delay", "raven", "swing unstable", "swing prompt")]


def _run(task: tuple[BaseFeedback, str]) -> dict[str, Any]:
    settings, name = task
    if name.startswith("swing"):
        link = link_of(settings, name.removeprefix("swing "))
        return {"swing": swing(link, start=settings.start, duration_s=settings.duration_s)}
    if name == "delay":
        return {"critical_delay": _critical_delay(link_of(settings).with_(cutoff_hz=None))}
    if name == "raven":
        return {text: _on_mount(mount) for text, mount in MOUNTS.items()}
    return _facts(certify(link_of(settings, name).system()), link_of(settings, name))


def _facts(certificate: Certificate, link: OneLink | None = None) -> dict[str, Any]:
    """What the table shows of one system: pole, its base's damping and what is left of it, margin, verdict."""
    mode = certificate.modes[0]
    facts = {
        "pole": certificate.pole.s,
        "damping": mode.damping,
        "effective": mode.effective_damping,
        "hz": mode.frequency_hz,
        "margin_db": certificate.margin_db,
        "distance": certificate.margins.distance,
        "certified": certificate.certified,
        "verdict": certificate.verdict,
    }
    if link is not None:
        w = 2.0 * np.pi * np.geomspace(0.3, 50.0, 6000)
        facts |= {"hz_grid": w / (2.0 * np.pi), "compliance": np.abs(1.0 / link.characteristic(1j * w))}
        facts["loop"] = link.loop(1j * w)
    return facts


def _critical_delay(link: OneLink) -> float:
    """Shortest delay (s) at which the loop without a low-pass is no longer certified; infinite if there is none."""

    def stable(delay: float) -> bool:
        return certify(link.with_(latency_s=delay).system()).certified

    delays = np.arange(0.0, LONGEST_DELAY_S + 0.5 * DELAY_STEP_S, DELAY_STEP_S)
    late = next((i for i, delay in enumerate(delays) if not stable(delay)), None)
    if not late:
        return 0.0 if late == 0 else float("inf")
    low, high = delays[late - 1], delays[late]
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return float(low)


def _on_mount(text: str) -> dict[str, Any]:
    """The RAVEN held at its middle pose on a mount, with dynamic and with static gravity."""
    drive, mount = raven2_drive(), parse_mount(text)
    systems = {law: linearise(raven(), held_pose(), drive, mount, RAVEN_SENSING, law=law) for law in ("pd+dg", "pd+sg")}
    return {law: _facts(certify(system)) for law, system in systems.items()}


def _combine(settings: BaseFeedback, results: Sequence[dict[str, Any]]) -> Outcome:
    facts = dict(zip(CASES, results, strict=False))
    delay, mounts = results[len(CASES)]["critical_delay"], results[len(CASES) + 1]
    swings = {"unstable": results[-2]["swing"], "prompt": results[-1]["swing"]}
    numbers: dict[str, float] = {}
    for name, fact in facts.items():
        numbers |= {f"{name}_growth": fact["pole"].real, f"{name}_rate": abs(fact["pole"].imag)}
        numbers |= {f"{name}_effective_damping": fact["effective"], f"{name}_certified": float(fact["certified"])}
    numbers |= {"critical_delay_s": delay, "simulated_growth": growth_of(swings["unstable"])}
    for (_, mount), name in zip(mounts.items(), ("cart", "stand"), strict=True):
        numbers |= {f"raven_{name}_growth": mount["pd+dg"]["pole"].real}
        numbers |= {f"raven_{name}_effective_damping": mount["pd+dg"]["effective"]}
    series = {f"compliance_{name}": fact["compliance"] for name, fact in facts.items()}
    series |= {"hz": facts["unstable"]["hz_grid"], "loop_unstable": facts["unstable"]["loop"]}
    series |= {"loop_prompt": facts["prompt"]["loop"], "time": STEP_S * np.arange(len(swings["unstable"]))}
    series |= {f"swing_{name}": values for name, values in swings.items()}
    tables = (_table(settings, facts), _mount_table(mounts))
    return Outcome(numbers, tables, tuple(_findings(settings, numbers, facts)), series)


def _table(settings: BaseFeedback, facts: dict[str, dict[str, Any]]) -> Table:
    rows = tuple((CASES[name][0], *_row(fact)) for name, fact in facts.items())
    note = (
        f"Base {settings.base_mass:g} kg at {settings.base_hz:g} Hz, damping ratio {settings.damping_ratio:g}; link "
        f"{settings.mass:g} kg at {settings.length:g} m, J {settings.inertia:g} kg m²; K_P {settings.kp:g}, K_D "
        f"{settings.kd:g}; accelerometer {1e3 * settings.latency_s:g} ms late, low-pass {settings.cutoff_hz:g} Hz. "
        "Effective damping: what the loop leaves of the base's own, at the frequency where it swings."
    )
    return Table("One link on a springy base", ("case", *COLUMNS), rows, note)


COLUMNS = (
    "rightmost pole, 1/s",
    "own damping, N s/m",
    "effective damping, N s/m",
    "gain margin, dB",
    "min |1+L|",
    "certificate",
)


def _row(fact: dict[str, Any]) -> tuple[str, ...]:
    pole = f"{fact['pole'].real:+.4f} ± {abs(fact['pole'].imag):.3f}j"
    margin = f"{fact['margin_db']:.2f}" if np.isfinite(fact["margin_db"]) else "any"
    verdict = "stable" if fact["certified"] else "not certified"
    values = (f"{fact['damping']:.3f}", f"{fact['effective']:.3f}", margin, f"{fact['distance']:.3f}")
    return (pole, *values, verdict)


def _mount_table(mounts: dict[str, dict[str, dict[str, Any]]]) -> Table:
    rows = tuple(
        (text, {"pd+dg": "PD+DG", "pd+sg": "PD+SG"}[law], *_row(fact))
        for text, laws in mounts.items()
        for law, fact in laws.items()
    )
    title = "RAVEN at its middle pose on light mounts that move along y0, sensor 30 ms late"
    note = (
        "The RAVEN's PD loops are stiff and its links light: it takes damping from the base, and does not swing it up."
    )
    return Table(title, ("mount", "law", *COLUMNS), rows, note)


def _findings(settings: BaseFeedback, numbers: dict[str, float], facts: dict[str, dict[str, Any]]) -> list[Finding]:
    default = settings == BaseFeedback()
    stated = "perturbations of the base could cause positive feedback between robot and accelerometer (section VII)"
    findings = [
        finding(
            f"{CASES[name][0]}: real part of the rightmost pole",
            numbers[f"{name}_growth"],
            "1/s",
            stated=stated if name == "unstable" else "",
            expected=POLES[name].real if default else None,
            tolerance=1e-4,
            verdict=_swings_up(numbers) if name == "unstable" else "no number stated",
            why=facts[name]["verdict"].capitalize() + ".",
        )
        for name in POLES
    ]
    delay, delay_s = _longest_tried(numbers["critical_delay_s"])
    more = (
        ("as set: imaginary part", numbers["unstable_rate"], "rad/s", 15.201, 1e-3, "It swings at 2.4 Hz."),
        ("as set: effective damping of the base", numbers["unstable_effective_damping"], "N s/m", EFFECTIVE_DAMPING,
         2e-3, "The lag turns the arm's reaction into negative damping, more than the base has."),
        (f"without low-pass: {delay}", 1e3 * delay_s, "ms", 1e3 * CRITICAL_DELAY_S, 0.01,
         "A base slower than the arm's PD loop loses damping in proportion to the lag."),
        ("as set: growth in the nonlinear simulation", numbers["simulated_growth"], "1/s", GROWTH, 5e-3,
         "The full equations grow as the linear ones say."),
    )  # fmt: skip
    for quantity, value, unit, expected, tolerance, why in more:
        findings.append(
            finding(quantity, value, unit, expected=expected if default else None, tolerance=tolerance, why=why)
        )
    return findings


def _longest_tried(critical_s: float) -> tuple[str, float]:
    """What is known of the critical delay, in words, and the delay (s) that they end with."""
    if np.isfinite(critical_s):
        return "critical delay", critical_s
    return "no critical delay up to", LONGEST_DELAY_S


def _swings_up(numbers: dict[str, float]) -> Any:
    return "reproduced" if numbers["unstable_growth"] > 0.0 else "not reproduced"


def _draw(figure: Figure, outcome: Outcome) -> None:
    compliance, nyquist, moving = figure.subplots(1, 3)
    series = outcome.series
    line_axes(compliance, "frequency, Hz", "base displacement per disturbing force, m/N")
    for name, colour in zip(
        ("static", "prompt", "unstable"), (LAW_COLOURS["pd+sg"], PALETTE[2], PALETTE[0]), strict=True
    ):
        compliance.loglog(series["hz"], series[f"compliance_{name}"], color=colour, label=CASES[name][0])
    line_axes(nyquist, "Re L(jω)", "Nyquist curve of the feedback, Im L(jω)")
    for name, colour in (("prompt", PALETTE[2]), ("unstable", PALETTE[0])):
        nyquist.plot(series[f"loop_{name}"].real, series[f"loop_{name}"].imag, color=colour, label=CASES[name][0])
    nyquist.plot([-1.0], [0.0], "+", color=PALETTE[1], markersize=9)
    nyquist.set_aspect("equal")
    line_axes(moving, "time, s", "simulated base displacement, mm")
    for name, colour in (("unstable", PALETTE[0]), ("prompt", PALETTE[2])):
        moving.plot(series["time"], 1e3 * series[f"swing_{name}"], color=colour, label=CASES[name][0], linewidth=0.6)
    legend_below(figure, compliance)


BASE_FEEDBACK = Experiment(
    name="base-feedback",
    title="Feedback between arm, base and accelerometer",
    source="Lewis & Hannaford, section VII (open question: frequency response, positive feedback)",
    about="One link under PD+DG on a springy base, and the RAVEN on light mounts: frequency response, poles, what the "
    "feedback leaves of the base's damping, and a nonlinear simulation.",
    settings=BaseFeedback,
    tasks=_tasks,
    run=_run,
    combine=_combine,
    draw=_draw,
)
