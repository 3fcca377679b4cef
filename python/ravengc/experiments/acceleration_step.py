"""Step response under sustained acceleration of the base: an open question of the paper (section VII).

The base accelerates by 0.2 g along one of its axes for a while, then stops doing so; the arm holds a pose. What the
joints do depends on how late the law learns of it: the integral of joint 1's error is (dtau / K_P) times the sensor's
total lag, and nothing stays, while PD and static gravity keep the error dtau / K_P for as long as the acceleration
lasts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc import STANDARD_GRAVITY
from ravengc.control import raven2_drive
from ravengc.experiments.drawing import LAW_COLOURS, PALETTE, legend_below, line_axes
from ravengc.experiments.experiment import Experiment, Finding, Outcome, Table, finding
from ravengc.experiments.raven import INERTIAS, base_axes, held_pose, raven, still_path, tilted_gravity
from ravengc.experiments.settings import Settings, setting
from ravengc.experiments.tracking import UNITS
from ravengc.experiments.trial import PLANT_NOTE, Friction, Sensing, Trial, run_trial
from ravengc.sim import acceleration_step

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

__all__ = ["ACCELERATION_STEP", "AccelerationStep"]

Array = NDArray[np.float64]

RATE_HZ = 1000.0
AXES = ("x0", "y0", "z0")

WAYS = {
    "pd": "PD",
    "sg": "PD+SG",
    "ideal": "PD+DG, ideal sensor (1 kHz, no latency)",
    "typical": "PD+DG, sensor as in the paper",
    "filtered": "PD+DG, the same with a low-pass",
    "slow": "PD+DG, slow sensor",
    "gated": "PD+DG, as in the paper, behind the default gate",
    "ramped": "PD+DG, behind the gate, acceleration rising within {rise:g} s",
}
COLOURS = dict(
    zip(
        WAYS,
        (LAW_COLOURS["pd"], LAW_COLOURS["pd+sg"], PALETTE[2], LAW_COLOURS["pd+dg"], *PALETTE[3:6], PALETTE[7]),
        strict=True,
    )
)
STATED = "the step response under sustained accelerations would be an interesting study (section VII)"


@dataclass(frozen=True, kw_only=True)
class AccelerationStep(Settings):
    """Settings of ``acceleration-step``."""

    acceleration: float = setting(0.2 * STANDARD_GRAVITY, 0.01, 9.0, "m/s^2", "the sustained acceleration: 0.2 g")
    start_s: float = setting(0.5, 0.1, 10.0, "s", "when it begins")
    lasts_s: float = setting(1.5, 0.1, 30.0, "s", "how long it lasts")
    after_s: float = setting(1.0, 0.1, 30.0, "s", "how long the run goes on")
    sensor_hz: float = setting(100.0, 10.0, 1000.0, "Hz", "accelerometer's rate")
    latency_s: float = setting(0.015, 0.0, 0.5, "s", "age of its samples, as in the paper")
    slow_latency_s: float = setting(0.05, 0.0, 0.5, "s", "age of the samples of a slow sensor")
    cutoff_hz: float = setting(5.0, 0.1, 45.0, "Hz", "the low-pass (second-order Butterworth)")
    coulomb: tuple[float, ...] = setting(
        (0.3, 0.18, 1.2), 0.0, 100.0, "N m, N m, N", "Coulomb friction of the second series", count=3
    )
    rise_s: float = setting(
        0.1, 0.001, 1.0, "s", "the last series: how long the acceleration takes to rise, and to fall"
    )
    settled: float = setting(0.05, 0.001, 0.5, "", "share of the peak below which the response counts as settled")


class _Case(NamedTuple):
    """One run: a way of sensing, an axis of frame 0, and whether joints rub."""

    way: str
    axis: int
    rubs: bool


def _tasks(settings: AccelerationStep) -> list[tuple[AccelerationStep, _Case]]:
    cases = [_Case(way, axis, False) for axis in range(3) for way in WAYS]
    cases += [_Case(way, 1, True) for way in WAYS]
    return [(settings, case) for case in cases]


def _run(task: tuple[AccelerationStep, _Case]) -> dict[str, Array]:
    """Error of the joints less that before the step, at every cycle, in deg, deg, mm; and the PD share."""
    settings, case = task
    pose = held_pose()
    rise = settings.rise_s if case.way == "ramped" else 0.0
    base = acceleration_step(
        settings.acceleration,
        tuple(base_axes()[case.axis]),
        start_s=settings.start_s,
        end_s=settings.start_s + settings.lasts_s + rise,
        rise_s=rise,
    )
    path = still_path(pose, settings.start_s + settings.lasts_s + settings.after_s, RATE_HZ)
    friction = Friction(settings.coulomb) if case.rubs else Friction()
    start = _sagged(pose) if case.way == "pd" else pose
    law = {"pd": "pd", "sg": "pd+sg"}.get(case.way, "pd+dg")
    record = run_trial(Trial(law, base, path, friction, _sensing(settings, case.way), tuple(start)))
    error = UNITS * (record.q_desired - record.q)
    begin, end = (round(moment * RATE_HZ) for moment in (settings.start_s, settings.start_s + settings.lasts_s))
    pd, total = (np.sqrt((tau[begin:end, :2] ** 2).mean(0)) for tau in (record.tau_pd, record.tau))
    return {"error": error - error[begin - 1], "share": 100.0 * np.linalg.norm(pd) / np.linalg.norm(total) * np.ones(1)}


def _sagged(pose: Array) -> Array:
    """Where PD alone holds ``pose``: it sags until it carries gravity."""
    q = pose
    for _ in range(20):
        q = pose - raven().gravity_torque(q, tilted_gravity(0.0)) / raven2_drive().kp
    return q


def _sensing(settings: AccelerationStep, way: str) -> Sensing:
    if way == "ideal":
        return Sensing(rate_hz=RATE_HZ, latency_s=0.0)
    return Sensing(
        rate_hz=settings.sensor_hz,
        latency_s=settings.slow_latency_s if way == "slow" else settings.latency_s,
        cutoff_hz=settings.cutoff_hz if way == "filtered" else None,
        gated=way in {"gated", "ramped"},
    )


class _Response(NamedTuple):
    """Joint 1 while the acceleration lasts: deg, deg, s, deg s."""

    peak: float
    steady: float
    settling: float
    integral: float


def _response(settings: AccelerationStep, error: Array) -> _Response:
    begin, end = (round(moment * RATE_HZ) for moment in (settings.start_s, settings.start_s + settings.lasts_s))
    during = np.abs(error[begin:end, 0])
    peak, steady = float(during.max()), float(during[-100:].mean())
    away = np.flatnonzero(np.abs(during - steady) > settings.settled * max(peak, 1e-12))
    settling = float(away[-1] + 1) / RATE_HZ if len(away) else 0.0
    return _Response(peak, steady, settling, float(np.abs(error[begin:end, 0].sum())) / RATE_HZ)


def _combine(settings: AccelerationStep, results: Sequence[dict[str, Array]]) -> Outcome:
    found = {case: result for (_, case), result in zip(_tasks(settings), results, strict=True)}
    responses = {case: _response(settings, result["error"]) for case, result in found.items()}
    numbers = {
        f"{case.way}_{AXES[case.axis]}{'_friction' if case.rubs else ''}_{name}": value
        for case, response in responses.items()
        for name, value in response._asdict().items()
    }
    numbers["rise_s"] = settings.rise_s
    tables = (*(_table(settings, found, responses, axis, rubs=False) for axis in (1, 0, 2)),
              _table(settings, found, responses, 1, rubs=True))  # fmt: skip
    series = {"time": np.arange(len(results[0]["error"])) / RATE_HZ - settings.start_s}
    for way in WAYS:
        series[way] = found[_Case(way, 1, False)]["error"][:, 0]
        series[f"{way}_friction"] = found[_Case(way, 1, True)]["error"][:, 0]
    return Outcome(numbers, tables, tuple(_findings(settings, responses)), series)


def _table(
    settings: AccelerationStep, found: dict[_Case, Any], responses: dict[_Case, _Response], axis: int, *, rubs: bool
) -> Table:
    rows = []
    for way, text in WAYS.items():
        response = responses[_Case(way, axis, rubs)]
        share = found[_Case(way, axis, rubs)]["share"][0]
        values = (f"{response.peak:.4f}", f"{response.steady:.4f}", f"{response.settling:.3f}")
        rows.append((text.format(rise=settings.rise_s), *values, f"{1e3 * response.integral:.3f}", f"{share:.1f} %"))
    friction = ", Coulomb friction {:g} / {:g} N·m / {:g} N".format(*settings.coulomb) if rubs else ", no friction"
    title = f"Joint 1 under {settings.acceleration:.3f} m/s² along {AXES[axis]}{friction}"
    heads = ("law and sensor", "peak, deg", "stays, deg", "settles, s", "integral, 1e-3 deg s", "PD share")
    note = f"Change of the error from before the step. {INERTIAS}. {PLANT_NOTE}" if axis == 1 and not rubs else ""
    return Table(title, heads, tuple(rows), note)


def _findings(settings: AccelerationStep, responses: dict[_Case, _Response]) -> list[Finding]:
    return [*_on_the_error(settings, responses), *_on_the_lag(settings, responses)]


def _on_the_error(settings: AccelerationStep, responses: dict[_Case, _Response]) -> list[Finding]:
    """Expected are the errors per m/s^2 of an independent simulation."""
    default = settings == AccelerationStep()
    along = {way: responses[_Case(way, 1, False)] for way in WAYS}
    torque, sag = _sag(settings)
    sagging = f"dtau / K_P = {sag:.4f} deg: {torque:.3f} N·m on {raven2_drive().kp[0]:.1f} N·m/rad."
    yielding = "Until the law learns of the acceleration, the arm gives way as with static gravity."
    rows = (
        ("PD+SG: peak of joint 1's error along y0", along["sg"].peak, 0.0470, "PD overshoots what stays."),
        ("PD+SG: what stays while the acceleration lasts", along["sg"].steady, 0.0393, sagging),
        ("PD+DG, sensor as in the paper: peak", along["typical"].peak, 0.01155, yielding),
        ("PD+DG, slow sensor: peak", along["slow"].peak, 0.03425, "The later, the nearer to that of static gravity."),
    )
    return [
        finding(
            quantity,
            value,
            "deg",
            stated=STATED if quantity == rows[0][0] else "",
            expected=per_acceleration * settings.acceleration if default else None,
            tolerance=0.0015,
            why=why,
        )
        for quantity, value, per_acceleration, why in rows
    ]


def _on_the_lag(settings: AccelerationStep, responses: dict[_Case, _Response]) -> list[Finding]:
    default, typical = settings == AccelerationStep(), responses[_Case("typical", 1, False)]
    lag = settings.latency_s + (-settings.start_s) % (1.0 / settings.sensor_hz)
    ramped = responses[_Case("ramped", 0, False)].steady
    return [
        finding(
            "PD+DG: what stays",
            typical.steady,
            "deg",
            expected=0.0 if default else None,
            tolerance=1e-3,
            why="The accelerometer feels the acceleration as gravity, and that is what the arm feels.",
        ),
        finding(
            "PD+DG, sensor as in the paper: integral of the error over (dtau / K_P), the effective lag",
            1e3 * typical.integral / _sag(settings)[1],
            "ms",
            expected=1e3 * lag if default else None,
            tolerance=0.3,
            why="Linear theory: the latency, and the time from the step to the next sample.",
        ),
        finding(
            "PD+DG behind the default gate, acceleration upwards: what stays",
            responses[_Case("gated", 0, False)].steady,
            "deg",
            why="0.2 g from one sample to the next (20 g/s) is a fault to the gate (jerk limit 150 m/s³): it holds the "
            "last value, with an alarm, until the reading is credible as gravity again. What a base can do passes: "
            f"rising within {settings.rise_s:g} s, {ramped:.4f} deg stay.",
        ),
    ]


def _sag(settings: AccelerationStep) -> tuple[float, float]:
    """Joint 1's torque by the acceleration along y0 (N m), and how far PD gives way to it (deg)."""
    torque = abs(raven().gravity_torque(held_pose(), tuple(-settings.acceleration * base_axes()[1]))[0])
    return float(torque), float(np.rad2deg(torque / raven2_drive().kp[0]))


def _draw(figure: Figure, outcome: Outcome) -> None:
    series = outcome.series
    for axes, suffix, title in zip(
        figure.subplots(1, 2, sharey=True), ("", "_friction"), ("no friction", "with Coulomb friction"), strict=True
    ):
        line_axes(axes, "time since the step, s", f"joint 1, acceleration along y0, {title}: error, deg")
        for way, text in WAYS.items():
            axes.plot(
                series["time"],
                series[f"{way}{suffix}"],
                color=COLOURS[way],
                label=text.format(rise=outcome.numbers["rise_s"]),
            )
        axes.set_xlim(-0.1, series["time"][-1])
    legend_below(figure, axes)


ACCELERATION_STEP = Experiment(
    name="acceleration-step",
    title="Step under sustained acceleration of the base",
    source="Lewis & Hannaford, section VII (open question: sustained accelerations, step response of PD+DG)",
    about="The base accelerates by 0.2 g along one axis; the arm holds a pose. Peak, what stays, settling and integral "
    "of the error for each law and sensor.",
    settings=AccelerationStep,
    tasks=_tasks,
    run=_run,
    combine=_combine,
    draw=_draw,
)
