"""One closed-loop run of the RAVEN in simulation: what is held or followed, on which base, with which law and friction.

The loop, the law, the sensor's chain and the plant are those that ``ravengc run`` uses: MuJoCo's dynamics on a
prescribed base, integrated every 0.5 ms, control every 1 ms, Coulomb friction that sticks exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.control import Controller, raven2_drive
from ravengc.experiments.raven import Path, raven
from ravengc.loop import ControlLoop, Record
from ravengc.sim import Plant, SampledAccelerometer

if TYPE_CHECKING:
    from ravengc.sim import PrescribedBase

__all__ = ["COULOMB_RATIO", "PLANT_NOTE", "Friction", "Sensing", "Trial", "friction_at", "rms", "run_trial"]

Array = NDArray[np.float64]

COULOMB_RATIO = np.array((1.0, 0.6, 4.0))
"""Coulomb friction of joints 1 to 3 (N m, N m, N) for 1 N m at joint 1: ASSUMED."""
VISCOUS_RATIO = np.array((1.0, 0.6, 10.0))
"""Viscous friction (N m s, N m s, N s) for 1 N m of Coulomb friction at joint 1, up to 2 N m: ASSUMED."""
MOST_VISCOUS = 2.0
STEP_S = 0.0005
OPEN_GATE: dict[str, Any] = {"start_count": 1, "moving_base": True, "jerk": 1e6, "gravity_rate": 1e6}

PLANT_NOTE = (
    "Plant: MuJoCo's dynamics, 0.5 ms steps, control 1 kHz; gains of the RAVEN II software (r2params.yaml) at the "
    "joints; rotors 1.42e-5 kg m² (RE40) on the motor side; no cable elasticity, no noise in the encoders; g = 9.80665 "
    "m/s². ASSUMED: friction and link inertias (rods)."
)


@dataclass(frozen=True)
class Friction:
    """Coulomb (N m, N) and viscous (N m s, N s) friction at the joints, (3,) each; what sticks stands still."""

    coulomb: tuple[float, ...] = (0.0, 0.0, 0.0)
    viscous: tuple[float, ...] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Sensing:
    """The accelerometer: its rate, latency, noise (m/s^2) and low-pass, and the seed of its noise.

    ``place`` (m, base axes) is where it is, ``told`` where its chain takes it to be; with a ``gyro`` the chain takes
    the lever arm out. ``gated``: samples pass the chain's gate, and its output, level at first, moves no faster than
    its limit; else the chain begins with what the sensor feels, and lets everything through.
    """

    place: tuple[float, ...] = (0.0, 0.0, 0.0)
    told: tuple[float, ...] = (0.0, 0.0, 0.0)
    gyro: bool = False
    rate_hz: float = 100.0
    latency_s: float = 0.015
    noise: float = 0.0
    seed: int = 0
    cutoff_hz: float | None = None
    gated: bool = False


@dataclass(frozen=True)
class Trial:
    """One run: law, base, set-points, friction, sensor; ``start`` is the pose it begins in (None: the first one)."""

    law: str
    base: PrescribedBase
    path: Path
    friction: Friction = Friction()
    sensing: Sensing = Sensing()
    start: tuple[float, ...] | None = None


class _Follower:
    """Gives the loop the set-points of a path, one per cycle; the last one stays."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._last = len(path.q) - 1

    def at(self, t: float, q: Array, qd: Array) -> None:
        """Write the set-point of time ``t`` (s)."""
        row = min(round(t * self._path.rate_hz), self._last)
        q[:] = self._path.q[row]
        qd[:] = self._path.qd[row]


def friction_at(level: float) -> Friction:
    """Friction with ``level`` N m of Coulomb friction at joint 1 and the assumed ratios for the rest."""
    coulomb, viscous = level * COULOMB_RATIO, min(level, MOST_VISCOUS) * VISCOUS_RATIO
    return Friction(tuple(coulomb.tolist()), tuple(viscous.tolist()))


def run_trial(trial: Trial) -> Record:
    """Run one trial at the rate of its path and return the record of every cycle. Ctrl-C goes through."""
    drive, sensing = raven2_drive(), trial.sensing
    plant = Plant(
        raven(),
        trial.base,
        step_s=STEP_S,
        sensor=sensing.place,
        rotor_inertia=drive.rotor_inertia,
        viscous=trial.friction.viscous,
        coulomb=trial.friction.coulomb,
    )
    path = trial.path
    plant.reset(path.q[0] if trial.start is None else trial.start, path.qd[0])
    sensor = _sensor(plant, sensing)
    loop = ControlLoop(
        plant,
        Controller(raven(), trial.law, drive),
        sensor,
        _Follower(path),
        rate_hz=path.rate_hz,
        duration_s=len(path.q) / path.rate_hz,
        paced=False,
    )
    record = loop.run()
    if record.interrupted:
        raise KeyboardInterrupt
    return record


def _sensor(plant: Plant, sensing: Sensing) -> SampledAccelerometer:
    """The base's accelerometer, and a gyro if wanted, behind the chain."""
    open_gate = {**OPEN_GATE, "up": plant.accelerometer()}
    return SampledAccelerometer(
        plant.accelerometer,
        hz=sensing.rate_hz,
        noise=sensing.noise,
        seed=sensing.seed,
        latency_s=sensing.latency_s,
        gyro=plant.gyro if sensing.gyro else None,
        position=sensing.told,
        cutoff_hz=sensing.cutoff_hz,
        **({} if sensing.gated else open_gate),
    )


def rms(values: Array) -> Array:
    """Root of the mean square over the cycles, per joint."""
    return np.asarray(np.sqrt((values**2).mean(axis=0)))
