"""From the options of ``ravengc run`` to a robot, a plant on a moving base, a controller and a loop."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING

import ravengc
from ravengc.cli.progress import PrerenderedBar
from ravengc.cli.run_sensor import OWN_DEFAULTS, run_sensor, settle_sensor
from ravengc.control import Controller, Drive, drive_for
from ravengc.coordinates import sliding
from ravengc.errors import ConfigError
from ravengc.loop import ControlLoop, check_timing
from ravengc.monitored import STATES
from ravengc.sim import CarriedBase, Plant, parse_base
from ravengc.trajectory import swing_within_limits

if TYPE_CHECKING:
    import argparse

    import numpy as np
    from numpy.typing import NDArray

    from ravengc.monitored import MonitoredSensor
    from ravengc.spec import RobotSpec

__all__ = ["Setup", "build"]


@dataclass(frozen=True, slots=True)
class Setup:
    """What a run is made of; ``sliding`` (n,) says which coordinates slide."""

    robot: ravengc.Robot
    base: CarriedBase
    plant: Plant
    drive: Drive
    loop: ControlLoop
    sensor: MonitoredSensor
    bar: PrerenderedBar
    sliding: NDArray[np.bool_]


def build(args: argparse.Namespace) -> Setup:
    """Make everything as the options say; errors of ravengc where they cannot be followed, with the sensor closed."""
    check_timing(args.rate, args.duration)
    robot = ravengc.load(args.robot, mass_set=args.mass_set)
    _require_masses(robot.spec)
    settle_sensor(args, robot.spec.file)
    base = parse_base(args.base, axis=args.axis or rocking_axis(robot.spec), pivot=args.pivot)
    motion = swing_within_limits(robot.spec, scale=float(args.motion == "swing" and args.controller != "passive"))
    drive = drive_for(
        robot, motion.start, natural_frequency_hz=args.natural_frequency, damping_ratio=args.damping_ratio
    )
    plant = Plant(
        robot,
        base,
        sensor=args.sensor_place or OWN_DEFAULTS["sensor_place"],
        rotor_inertia=drive.rotor_inertia,
        viscous=args.viscous,
        coulomb=args.coulomb,
    )
    plant.reset(motion.start)
    controller = Controller(
        robot, args.controller, drive, tau_max=torque_limits(robot.spec), limits="robot", rate_hz=args.rate
    )
    sensor = run_sensor(args, robot, plant, base, turning=controller.law.turning)
    with ExitStack() as refused:
        refused.callback(sensor.close)
        bar = PrerenderedBar(f"{robot.name}, {args.controller}", lambda: _sensor_note(sensor))
        loop = ControlLoop(
            plant,
            controller,
            sensor,
            motion,
            rate_hz=args.rate,
            duration_s=args.duration,
            paced=not args.fast,
            on_tick=bar.show,
        )
        refused.pop_all()
    return Setup(robot, base, plant, drive, loop, sensor, bar, sliding(robot.spec))


def _sensor_note(sensor: MonitoredSensor) -> str:
    """State, the first alarm that stands, and how many of the samples were good, for the progress line."""
    chain, counters = sensor.accelerometer, sensor.accelerometer.counters
    alarm = next((f" ({name})" for name in chain.alarms), "")
    return f"{STATES[sensor.state]}{alarm} {counters['accepted']} good of {counters['received']}"


def rocking_axis(robot: RobotSpec) -> tuple[float, float, float]:
    """The z axis of the robot's frame 0 (RAVEN: the axis of joint 1) in base axes where it is horizontal, else x.

    About a vertical axis a base could rock for ever without gravity changing.
    """
    (_, _, x), (_, _, y), (_, _, z) = robot.base.rotation
    return (x, y, z) if abs(z) < 0.5 else (1.0, 0.0, 0.0)


def torque_limits(robot: RobotSpec) -> list[float]:
    """Effort limits of the coordinates (N m, N), infinite where there is none."""
    return [float("inf") if limit.effort is None else limit.effort for limit in robot.coordinate_limits]


def _require_masses(robot: RobotSpec) -> None:
    if not any(link.mass for link in robot.links):
        raise ConfigError(f"robot '{robot.name}' has no masses: there is nothing to compensate and nothing to simulate")
