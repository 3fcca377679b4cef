"""Which terms of a moving base matter: what each way of compensating leaves of the torque that holds the arm.

The truth is inverse dynamics with the specific force of the base's origin, the angular velocity and the angular
acceleration. Equations (1)-(3) of the paper keep the specific force alone, and take it as the accelerometer gives it,
wherever that is mounted. The table shows, for a base that rocks at 1 Hz, what is left out in each case.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc.experiments.base_rows import Rocking, held_rows, turned
from ravengc.experiments.drawing import PALETTE, bars, legend_below, line_axes
from ravengc.experiments.experiment import Experiment, Finding, Outcome, Table, finding
from ravengc.experiments.raven import INERTIAS, base_axes, held_pose, raven
from ravengc.experiments.settings import Settings, setting

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

__all__ = ["MOVING_BASE_TERMS", "MovingBaseTerms"]

Array = NDArray[np.float64]

SCENES = {
    "A": "about z0 through the base origin; sensor off the pivot",
    "B": "about z0, pivot below the base; sensor at the base origin",
    "C": "about z0, pivot below the base; sensor on the pivot",
    "D": "about y0, pivot below the base; sensor at the base origin",
}
WAYS = {
    "sg": "static gravity, level",
    "sg_mean": "static gravity at the mean angle",
    "tilt": "tilt alone (AHRS)",
    "paper": "raw accelerometer, eqs (1)-(3)",
    "lever": "f0 by lever arm, no rotation terms",
    "rate": "f0 and angular velocity",
    "full": "f0, angular velocity and acceleration",
}
REFERENCE = {
    "A": {
        "sg": (44.6, 41.3, 25.6),
        "sg_mean": (23.4, 19.8, 6.3),
        "tilt": (15.0, 12.0, 1.0),
        "paper": (26.2, 21.5, 6.4),
        "lever": (15.0, 12.0, 1.0),
        "rate": (15.0, 12.0, 0.0),
        "full": (0.0, 0.0, 0.0),
    },
    "B": {
        "sg": (49.8, 46.0, 28.1),
        "sg_mean": (33.6, 29.1, 12.4),
        "tilt": (25.4, 21.1, 6.4),
        "paper": (14.6, 11.8, 1.0),
        "lever": (14.6, 11.8, 1.0),
        "rate": (14.6, 11.7, 0.0),
        "full": (0.0, 0.0, 0.0),
    },
    "C": {
        "sg": (49.8, 46.0, 28.1),
        "sg_mean": (33.6, 29.1, 12.4),
        "tilt": (25.4, 21.1, 6.4),
        "paper": (25.4, 21.1, 6.4),
        "lever": (14.6, 11.8, 1.0),
        "rate": (14.6, 11.7, 0.0),
        "full": (0.0, 0.0, 0.0),
    },
    "D": {
        "sg": (5.3, 58.1, 17.1),
        "sg_mean": (2.8, 38.1, 7.6),
        "tilt": (3.4, 28.3, 4.0),
        "paper": (3.2, 15.4, 0.8),
        "lever": (3.2, 15.4, 0.8),
        "rate": (3.2, 15.4, 0.0),
        "full": (0.0, 0.0, 0.0),
    },
}
"""RMS error in % of the RMS hold torque, joints 1 to 3: the same table from an independent NumPy implementation."""
TOLERANCE = 0.1


@dataclass(frozen=True, kw_only=True)
class MovingBaseTerms(Settings):
    """Settings of ``moving-base-terms``."""

    mean_deg: float = setting(15.0, -90.0, 90.0, "deg", "mean angle of the base")
    amplitude_deg: float = setting(5.0, 0.1, 45.0, "deg", "amplitude of the rocking")
    hz: float = setting(1.0, 0.01, 20.0, "Hz", "frequency of the rocking")
    lever: float = setting(0.3, 0.0, 5.0, "m", "distance of the pivot (scene A: of the sensor) below the base origin")
    gravity: float = setting(9.81, 0.1, 30.0, "m/s^2", "length of g")
    samples: int = setting(1000, 16, 100_000, "", "samples of one period")
    j1_deg: tuple[float, ...] = setting((15.0, 45.0, 75.0), 0.0, 90.0, "deg", "poses: shoulder")
    j2_deg: tuple[float, ...] = setting((60.0, 90.0, 120.0), 45.0, 135.0, "deg", "poses: elbow")
    d3: tuple[float, ...] = setting((0.30, 0.45), 0.23, 0.56, "m", "poses: insertion")
    frequencies_hz: tuple[float, ...] = setting(
        (0.1, 0.25, 0.5, 1.0, 2.0), 0.01, 20.0, "Hz", "frequencies for which the neglected torque is shown"
    )
    delays_ms: tuple[float, ...] = setting((10.0, 20.0, 50.0), 0.0, 500.0, "ms", "pure delays of f0 that are tried")


def _tasks(settings: MovingBaseTerms) -> list[tuple[MovingBaseTerms, str]]:
    return [(settings, name) for name in (*SCENES, "delays", "frequencies")]


def _run(task: tuple[MovingBaseTerms, str]) -> dict[str, Array]:
    settings, name = task
    if name == "delays":
        return _delays(settings)
    if name == "frequencies":
        return _frequencies(settings)
    return _scene(settings, name)


def _poses(settings: MovingBaseTerms) -> list[Array]:
    return [held_pose(*pose) for pose in itertools.product(settings.j1_deg, settings.j2_deg, settings.d3)]


def _hold(rows: Array, settings: MovingBaseTerms) -> Array:
    """Torque that holds each pose while the base moves as ``rows`` say, (poses, samples, 3)."""
    zero = np.zeros((len(rows), 3))
    return np.stack(
        [raven().inverse_dynamics_batch(np.tile(pose, (len(rows), 1)), zero, zero, rows) for pose in _poses(settings)]
    )


def _rocking(settings: MovingBaseTerms, axis: Array, pivot: Array, hz: float) -> Rocking:
    up = settings.gravity * base_axes()[0]
    mean, amplitude = np.deg2rad((settings.mean_deg, settings.amplitude_deg))
    return Rocking(axis, pivot, up, mean=mean, amplitude=amplitude, hz=hz, samples=settings.samples)


def _in_scene(settings: MovingBaseTerms, name: str) -> tuple[Rocking, Array, Array]:
    """The motion of a scene, the place of its sensor and its axis."""
    x0, y0, z0 = base_axes()
    below, origin = -settings.lever * x0, np.zeros(3)
    axis = y0 if name == "D" else z0
    pivot = origin if name == "A" else below
    sensor = {"A": below, "B": origin, "C": pivot, "D": origin}[name]
    return _rocking(settings, axis, pivot, settings.hz), sensor, axis


def _scene(settings: MovingBaseTerms, name: str) -> dict[str, Array]:
    """RMS error of each way of compensating in % of the RMS hold torque, and that torque."""
    motion, sensor, axis = _in_scene(settings, name)
    truth = _hold(motion.rows(), settings)
    size = _rms(truth)
    origin = motion.force_at(np.zeros(3))
    up = settings.gravity * base_axes()[0]
    mean = turned(axis, np.full(settings.samples, -np.deg2rad(settings.mean_deg)), up)
    rows = {
        "sg": held_rows(np.tile(up, (settings.samples, 1))),
        "sg_mean": held_rows(mean),
        "tilt": held_rows(motion.up_in_base),
        "paper": held_rows(motion.force_at(sensor)),
        "lever": held_rows(origin),
        "rate": np.hstack((origin, motion.w, np.zeros_like(motion.dw))),
        "full": motion.rows(),
    }
    errors = {way: 100.0 * _rms(_hold(row, settings) - truth) / size for way, row in rows.items()}
    return {**errors, "hold": size}


def _delays(settings: MovingBaseTerms) -> dict[str, Array]:
    """RMS error by a pure delay of f0 alone, everything else exact, in % of the RMS hold torque (scene B)."""
    motion, _, _ = _in_scene(settings, "B")
    truth = _hold(motion.rows(), settings)
    errors = {}
    for delay in settings.delays_ms:
        late = motion.rows()
        shift = delay * 1e-3 * settings.hz * settings.samples
        samples = np.arange(settings.samples)
        for column in range(3):  # one period: it repeats
            late[:, column] = np.interp(samples - shift, samples, late[:, column], period=settings.samples)
        errors[f"{delay:g}"] = 100.0 * _rms(_hold(late, settings) - truth) / _rms(truth)
    return errors


def _frequencies(settings: MovingBaseTerms) -> dict[str, Array]:
    """Peak of the torque by angular acceleration that eqs (1)-(3) leave out, in % of the largest gravity torque."""
    x0, _, z0 = base_axes()
    largest = np.abs(_hold(held_rows(_rocking(settings, z0, 0.0 * x0, 1.0).up_in_base), settings)).max((0, 1))
    found = {}
    for hz in settings.frequencies_hz:
        motion = _rocking(settings, z0, 0.0 * x0, hz)
        without = np.hstack((motion.force_at(np.zeros(3)), motion.w, np.zeros_like(motion.dw)))
        missing = _hold(motion.rows(), settings) - _hold(without, settings)
        found[f"{hz:g}"] = 100.0 * np.abs(missing).max((0, 1)) / largest
    return found


def _rms(torque: Array) -> Array:
    return np.asarray(np.sqrt((torque**2).mean((0, 1))))


def _combine(settings: MovingBaseTerms, results: Sequence[dict[str, Array]]) -> Outcome:
    scenes = dict(zip(SCENES, results, strict=False))
    delays, frequencies = results[-2:]
    numbers = {
        f"{scene}_{way}_j{j + 1}": float(found[way][j])
        for scene, found in scenes.items()
        for way in WAYS
        for j in range(3)
    }
    numbers |= {f"delay_{ms}ms_j1": float(errors[0]) for ms, errors in delays.items()}
    numbers |= {f"neglected_{hz}hz_j1": float(part[0]) for hz, part in frequencies.items()}
    series = {f"{scene}_j1": np.array([found[way][0] for way in WAYS]) for scene, found in scenes.items()}
    series |= {"hz": np.array(settings.frequencies_hz), "neglected": np.array([p[0] for p in frequencies.values()])}
    tables = (_table(scenes), _delay_table(delays), _frequency_table(frequencies))
    return Outcome(numbers, tables, tuple(_findings(settings, scenes, numbers)), series)


def _table(scenes: dict[str, dict[str, Array]]) -> Table:
    def row(way: str) -> tuple[str, ...]:
        return (WAYS[way], *(" / ".join(f"{value:.1f}" for value in scenes[scene][way]) for scene in SCENES))

    hold = tuple("{:.2f} N·m / {:.2f} N·m / {:.2f} N".format(*scenes[scene]["hold"]) for scene in SCENES)
    return Table(
        "RMS torque error in % of the RMS hold torque, joints 1 / 2 / 3",
        ("compensation", *(f"{name}: {text}" for name, text in SCENES.items())),
        (*map(row, WAYS), ("RMS torque that holds the arm", *hold)),
        INERTIAS,
    )


def _delay_table(delays: dict[str, Array]) -> Table:
    rows = tuple((f"{ms} ms", *(f"{value:.1f}" for value in errors)) for ms, errors in delays.items())
    title = "Delay of f0 alone, everything else exact (scene B): RMS error, % of RMS hold torque"
    return Table(title, ("delay", "joint 1", "joint 2", "joint 3"), rows)


def _frequency_table(frequencies: dict[str, Array]) -> Table:
    rows = tuple((f"{hz} Hz", *(f"{value:.2f}" for value in part)) for hz, part in frequencies.items())
    title = "Peak torque by angular acceleration that eqs (1)-(3) leave out, % of the largest gravity torque"
    return Table(title, ("rocking at", "joint 1", "joint 2", "joint 3"), rows, "It grows with amplitude x frequency^2.")


def _findings(
    settings: MovingBaseTerms, scenes: dict[str, dict[str, Array]], numbers: dict[str, float]
) -> list[Finding]:
    default = settings == MovingBaseTerms()
    findings = []
    for scene in SCENES if default else ():
        worst = max(float(np.abs(scenes[scene][way] - REFERENCE[scene][way]).max()) for way in WAYS)
        findings.append(
            finding(
                f"scene {scene}: largest difference from the reference table, 7 ways x 3 joints",
                worst,
                "points",
                expected=0.0,
                tolerance=TOLERANCE,
                why="The reference is an independent implementation of the same definitions, rounded to 0.1.",
            )
        )
    findings.append(
        finding(
            "joint 1: what point acceleration alone leaves, sensor at the base origin (B)",
            numbers["B_paper_j1"],
            "% of hold torque",
            stated="the accelerometer compensates for base motion in addition to gravity (section VI)",
            expected=REFERENCE["B"]["paper"][0] if default else None,
            tolerance=TOLERANCE,
            verdict="not reproduced" if numbers["B_paper_j1"] > 5.0 else "reproduced",
            why="True of the translation of the base. Eqs (1)-(3) have no term for its angular acceleration, which at "
            "this frequency is the larger part; a gyro supplies it. Below 0.25 Hz it is under 1 %.",
        )
    )
    findings.append(
        finding(
            "joint 1: the same with the sensor on the pivot (C)",
            numbers["C_paper_j1"],
            "% of hold torque",
            expected=REFERENCE["C"]["paper"][0] if default else None,
            tolerance=TOLERANCE,
            why="A sensor away from the base origin feels another acceleration; the lever-arm correction needs the "
            "angular rate and acceleration, so a gyro.",
        )
    )
    return findings


def _draw(figure: Figure, outcome: Outcome) -> None:
    left, right = figure.subplots(1, 2, width_ratios=(1.7, 1.0))
    groups = {f"scene {scene}": outcome.series[f"{scene}_j1"] for scene in SCENES}
    bars(left, list(WAYS.values()), groups)
    left.set_title("joint 1: RMS torque error, % of RMS hold torque")
    line_axes(right, "rocking frequency, Hz", "joint 1: what eqs (1)-(3) leave out, % of max gravity")
    right.loglog(outcome.series["hz"], np.maximum(outcome.series["neglected"], 1e-9), "o-", color=PALETTE[0])
    legend_below(figure, left)


MOVING_BASE_TERMS = Experiment(
    name="moving-base-terms",
    title="Which terms of the base's motion matter",
    source="Lewis & Hannaford, section I-C and eqs (1)-(3); Wronka & Dunnigan 2011; Sadraei & Moghaddam 2013",
    about="The arm is held still on a base that rocks. Each row is a way of compensating; the number is what is left "
    "for the PD term, against inverse dynamics with the full motion of the base.",
    settings=MovingBaseTerms,
    tasks=_tasks,
    run=_run,
    combine=_combine,
    draw=_draw,
)
