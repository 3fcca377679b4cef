"""An arm on a ship: the six-joint PA10 of the moving-base literature, and what each way of compensating leaves.

The ship rolls, pitches and heaves slowly; the arm stands away from the centre of rotation. Here the specific force at
the arm's base, the paper's equations (1)-(3), is nearly the whole truth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc.experiments.base_rows import held_rows, turned
from ravengc.experiments.drawing import PALETTE, bars, legend_below, line_axes
from ravengc.experiments.experiment import Experiment, Finding, Outcome, Table, finding
from ravengc.experiments.settings import Settings, setting

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

__all__ = ["SHIP", "Ship", "ship_motion"]

Array = NDArray[np.float64]

X, Y, Z = np.eye(3)
WAYS = {
    "sg": "static gravity, level",
    "tilt": "tilt alone (AHRS)",
    "accelerometer": "accelerometer at the base, eqs (1)-(3)",
    "full": "f0, angular velocity and acceleration",
}
REFERENCE = {
    "sg": ((100.0, 19.0, 21.0, 87.0, 66.0), 0.5),
    "tilt": ((16.0, 3.6, 7.0, 14.0, 12.0), 0.5),
    "accelerometer": ((2.4, 0.9, 0.8, 2.7, 2.9), 0.05),
    "full": ((0.0, 0.0, 0.0, 0.0, 0.0), 1e-9),
}
"""RMS error in % of the RMS torque, joints 1 to 5, and half a unit of its last digit: an independent computation."""
LEVEL_TORQUE = (0.0, -25.0096, 8.4105, 0.0124, 0.0357, 0.0)
COUNTED = 5


@dataclass(frozen=True, kw_only=True)
class Ship(Settings):
    """Settings of ``ship``."""

    roll_deg: float = setting(10.0, 0.0, 45.0, "deg", "amplitude of roll, about x")
    roll_hz: float = setting(0.1, 0.001, 5.0, "Hz", "frequency of roll")
    pitch_deg: float = setting(4.0, 0.0, 45.0, "deg", "amplitude of pitch, about y")
    pitch_hz: float = setting(0.13, 0.001, 5.0, "Hz", "frequency of pitch")
    heave: float = setting(1.0, 0.0, 20.0, "m", "amplitude of heave, along the world's z")
    heave_hz: float = setting(0.1, 0.001, 5.0, "Hz", "frequency of heave")
    place: tuple[float, ...] = setting(
        (3.0, 1.0, 4.0), -200.0, 200.0, "m", "the arm's base, from the centre of rotation, in the ship's axes", count=3
    )
    pose: tuple[float, ...] = setting(
        (0.3, 0.6, -1.0, 0.2, 0.5, 0.1), -6.3, 6.3, "rad", "joint coordinates of the arm", count=6
    )
    gravity: float = setting(9.81, 0.1, 30.0, "m/s^2", "length of g")
    duration_s: float = setting(60.0, 1.0, 3600.0, "s", "time")
    rate_hz: float = setting(100.0, 1.0, 1000.0, "Hz", "samples per second")


def ship_motion(settings: Ship, time: Array) -> tuple[Array, Array]:
    """Motion of the arm's base: nine columns (specific force of its origin, w, w'), and R^T of the upward g.

    R = Rx(roll) Ry(pitch); in the ship's axes w = Ry^T (roll' e_x) + pitch' e_y, and its derivative.
    """
    roll, roll_rate, roll_acceleration = _sine(np.deg2rad(settings.roll_deg), settings.roll_hz, time)
    pitch, pitch_rate, pitch_acceleration = _sine(np.deg2rad(settings.pitch_deg), settings.pitch_hz, time)
    heave = _sine(settings.heave, settings.heave_hz, time)[2]
    axis = turned(Y, -pitch, X)
    w = axis * roll_rate[:, None] + Y * pitch_rate[:, None]
    dw = axis * roll_acceleration[:, None] + Y * pitch_acceleration[:, None]
    dw += np.cross(axis, Y) * (roll_rate * pitch_rate)[:, None]
    up = _to_ship(roll, pitch)
    arm = np.broadcast_to(np.array(settings.place), w.shape)
    force = up * (settings.gravity + heave)[:, None] + np.cross(dw, arm) + np.cross(w, np.cross(w, arm))
    return np.hstack((force, w, dw)), settings.gravity * up


def _sine(amplitude: float, hz: float, time: Array) -> tuple[Array, Array, Array]:
    rate = 2.0 * np.pi * hz
    swing = amplitude * np.sin(rate * time)
    return swing, amplitude * rate * np.cos(rate * time), -rate * rate * swing


def _to_ship(roll: Array, pitch: Array) -> Array:
    """The world's e_z in the ship's axes, Ry^T Rx^T e_z, (N, 3)."""
    return np.stack((-np.sin(pitch) * np.cos(roll), np.sin(roll), np.cos(pitch) * np.cos(roll)), axis=1)


def _tasks(settings: Ship) -> list[Ship]:
    return [settings]


def _run(settings: Ship) -> dict[str, Array]:
    robot = ravengc.load("pa10")
    time = np.arange(round(settings.duration_s * settings.rate_hz)) / settings.rate_hz
    rows, up = ship_motion(settings, time)
    level = np.tile(settings.gravity * Z, (len(time), 1))

    def hold(motion: Array) -> Array:
        zero = np.zeros((len(time), robot.n))
        return robot.inverse_dynamics_batch(np.tile(settings.pose, (len(time), 1)), zero, zero, motion)

    truth = hold(rows)
    torques = {"sg": held_rows(level), "tilt": held_rows(up), "accelerometer": held_rows(rows[:, :3]), "full": rows}
    size = np.sqrt((truth**2).mean(0))[:COUNTED]
    errors = {way: (hold(motion) - truth)[:, :COUNTED] for way, motion in torques.items()}
    found = {way: 100.0 * np.sqrt((error**2).mean(0)) / size for way, error in errors.items()}
    traces = {f"trace_{way}": errors[way][:, 1] for way in WAYS}
    return {**found, **traces, "size": size, "time": time, "level_torque": hold(held_rows(level))[0]}


def _combine(settings: Ship, results: Sequence[dict[str, Array]]) -> Outcome:
    (found,) = results
    numbers = {f"{way}_j{j + 1}": float(found[way][j]) for way in WAYS for j in range(COUNTED)}
    numbers |= {f"level_torque_j{j + 1}": float(value) for j, value in enumerate(found["level_torque"])}
    joints = tuple(f"joint {j + 1}" for j in range(COUNTED))
    rows = tuple((text, *(f"{value:.1f}" for value in found[way])) for way, text in WAYS.items())
    size = ("RMS torque, N·m", *(f"{value:.4g}" for value in found["size"]))
    note = (
        "PA10, six joints: masses of a simulation model, link inertias ASSUMED cylinders (radius 0.06 m). Joint 6 "
        f"carries no first moment across its axis. Level gravity torque at this pose with g = {settings.gravity:g} "
        f"m/s²: {', '.join(f'{value:.4f}' for value in found['level_torque'] + 0.0)} N·m."
    )
    title = "RMS torque error in % of the RMS torque"
    table = Table(title, ("compensation", *joints), (*rows, size), note)
    series = {key: value for key, value in found.items() if key in {*WAYS, "time"} or key.startswith("trace")}
    return Outcome(numbers, (table,), tuple(_findings(settings, found)), series)


def _findings(settings: Ship, found: dict[str, Array]) -> list[Finding]:
    default = settings == Ship()
    findings = []
    for way, (reference, tolerance) in REFERENCE.items() if default else ():
        findings.append(
            finding(
                f"{WAYS[way]}: largest difference from the reference row, joints 1 to 5",
                float(np.abs(found[way] - reference).max()),
                "points",
                expected=0.0,
                tolerance=tolerance,
                why="The reference is an independent computation, rounded to this tolerance.",
            )
        )
    if default:
        worst = float(np.abs(found["level_torque"] - LEVEL_TORQUE).max())
        findings.append(
            finding("level gravity torque: largest difference from the reference", worst, "N·m", expected=0.0,
                    tolerance=1e-4)
        )  # fmt: skip
    findings.append(
        finding(
            "eqs (1)-(3) with an accelerometer at the base: worst joint",
            float(found["accelerometer"].max()),
            "% of RMS torque",
            stated="an inclinometer improves all controllers, an accelerometer further (Dunnigan & Wronka 2011)",
            verdict="reproduced" if (found["accelerometer"] < found["tilt"]).all() else "not reproduced",
            why="Against tilt alone the accelerometer adds heave and the lever arm to the centre of rotation. What is "
            "left, angular acceleration inside the arm, is small at a ship's frequencies.",
        )
    )
    return findings


def _draw(figure: Figure, outcome: Outcome) -> None:
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.4))
    labels = [f"joint {j + 1}" for j in range(COUNTED)]
    bars(left, labels, {WAYS[way]: outcome.series[way] for way in WAYS})
    left.set_title("RMS torque error, % of RMS torque")
    line_axes(right, "time, s", "joint 2: torque error, N·m")
    for i, (way, text) in enumerate(WAYS.items()):
        right.plot(outcome.series["time"], outcome.series[f"trace_{way}"], label=text, color=PALETTE[i])
    legend_below(figure, left)


SHIP = Experiment(
    name="ship",
    title="PA10 on a ship",
    source="Wronka & Dunnigan 2011; Dunnigan & Wronka 2011; Sadraei & Moghaddam 2013 (refs [6]-[8] of the paper)",
    about="A six-joint PA10 is held still on a ship that rolls, pitches and heaves. What static gravity, tilt alone, "
    "the accelerometer and the full base motion each leave of the torque.",
    settings=Ship,
    tasks=_tasks,
    run=_run,
    combine=_combine,
    draw=_draw,
)
