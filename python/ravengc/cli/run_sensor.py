"""The base sensor of ``ravengc run``: the plant's own, or a real or recorded one behind the same chain."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import ravengc
from ravengc.calibration.block import AccelerometerBlock, read_block
from ravengc.errors import ConfigError, SensorError
from ravengc.monitored import MonitoredSensor, chain_for
from ravengc.sensors.address import parse_address
from ravengc.sensors.live import LiveSensor
from ravengc.sensors.seen import Watch
from ravengc.sensors.verdicts import complaints, size_words
from ravengc.sensors.watch import WatchedSensor
from ravengc.sim import CarriedBase, Plant, SampledAccelerometer
from ravengc.sim.base_motion import WORLD_GRAVITY

if TYPE_CHECKING:
    import argparse

    from ravengc.sensors.address import Address

__all__ = [
    "DEFAULT_RATE_HZ",
    "OWN",
    "address_of",
    "block_of",
    "chain_of",
    "cutoff_of",
    "judge",
    "run_sensor",
    "settle_sensor",
    "wait_until_armable",
]

DEFAULT_RATE_HZ = 100.0

OWN = "sim"
"""The address of the plant's own accelerometer."""
OWN_DEFAULTS: dict[str, Any] = {
    "sensor_place": (0.0, 0.0, 0.0),
    "sensor_rate": DEFAULT_RATE_HZ,
    "noise": 0.02,
    "seed": 0,
}
"""The options that only the plant's own accelerometer has: m in base axes, Hz, m/s^2."""
DECLARED_ACCELERATION = 1.5
"""How hard the base origin accelerates where nobody says otherwise, m/s^2: the chain's own default."""
PATIENCE_S = 5.0
"""How long a strict run waits for its sensor."""


def settle_sensor(args: argparse.Namespace, file: str | None) -> None:
    """Put the address of the run's sensor into ``args``: the option's, else that of the robot's file, else the plant's.

    Options that only the plant's own has get their defaults; ConfigError if one is given beside another sensor.
    """
    args.sensor = args.sensor or block_of(file).sensor or OWN
    given = [f"--{name.replace('_', '-')}" for name in OWN_DEFAULTS if getattr(args, name) is not None]
    if args.sensor != OWN and given:
        raise ConfigError(
            f"{', '.join(given)}: only the plant's own accelerometer has that, not '{args.sensor}'; leave it out, "
            f"or say --sensor {OWN}"
        )
    for name, value in OWN_DEFAULTS.items():
        if args.sensor == OWN and getattr(args, name) is None:
            setattr(args, name, value)


def run_sensor(
    args: argparse.Namespace, robot: ravengc.Robot, plant: Plant, base: CarriedBase, *, turning: bool
) -> MonitoredSensor:
    """Open the sensor that :func:`settle_sensor` has put into ``args``.

    The chain is the one that the robot's file declares. ``turning``: the plant's own has a gyro, by which the chain
    takes out the lever arm to the base origin; how hard that accelerates is declared from the motion of ``base``. What
    the robot's file declares of the base comes before that, and holds for the plant's own sensor too.
    """
    block = block_of(robot.spec.file)
    cutoff = cutoff_of(args, block)
    if args.sensor == OWN:
        chain: dict[str, Any] = {"policy": args.policy or block.policy, "cutoff_hz": cutoff}
        if turning:
            hardest = max(DECLARED_ACCELERATION, 1.1 * hardest_acceleration(base, args.duration))
            chain |= {"gyro": plant.gyro, "position": args.sensor_place, "linear_acceleration": min(hardest, 1e4)}
        chain |= block.of_the_base
        return SampledAccelerometer(plant.accelerometer, hz=args.sensor_rate, noise=args.noise, seed=args.seed, **chain)
    if args.fast:
        instead = "leave out --fast" if args.sensor != block.sensor else f"leave out --fast, or say --sensor {OWN}"
        raise ConfigError(f"--fast: sensor '{args.sensor}' lives in real time; {instead}")
    address = address_of(args.sensor, block, block.rate_hz)
    own = {"cutoff_hz": cutoff, "policy": args.policy or block.policy}
    rate = block.rate_hz or DEFAULT_RATE_HZ
    return WatchedSensor(chain_of(block, rate, **own), address.prepare(), Watch(rate, address))


def cutoff_of(args: argparse.Namespace, block: AccelerometerBlock) -> float | None:
    """Return the low-pass of a run, Hz: the option's, else that of the robot's table; None for none."""
    cutoff: float | None = block.cutoff_hz if args.cutoff is None else args.cutoff
    return cutoff


def hardest_acceleration(base: CarriedBase, duration: float) -> float:
    """Return the largest acceleration of the base origin (m/s^2) at a thousand moments of so many seconds."""
    moments = np.linspace(0.0, duration, 1000)
    accelerations = [base.motion_at(t, np.zeros(3))[0] + base.rotation(t).T @ WORLD_GRAVITY for t in moments]
    return float(np.linalg.norm(accelerations, axis=1).max())


def address_of(text: str, block: AccelerometerBlock, rate_hz: float | None) -> Address:
    """Read an address; what it leaves open is as the robot's table, or the declared rate, says."""
    rate = {} if rate_hz is None else {"rate": rate_hz}
    return parse_address(text).with_defaults(unit=block.unit, **rate)


def block_of(file: str | None) -> AccelerometerBlock:
    """Read the [accelerometer] table of a robot's file, or take its defaults."""
    block = read_block(file) if file is not None and file.endswith(".toml") else None
    return block or AccelerometerBlock()


def chain_of(block: AccelerometerBlock, rate_hz: float, **own: Any) -> ravengc.Accelerometer:
    """Make the chain that a table declares; ``own`` settings come first."""
    declared = {
        "rotation": block.rotation,
        "position": block.position,
        "bias": block.bias,
        "correction": block.correction,
        "gyro_bias": block.gyro_bias,
        "cutoff_hz": block.cutoff_hz,
        "policy": block.policy,
    }
    if block.range is not None:
        declared["range"] = block.range
    return chain_for(rate_hz, **{**declared, **block.of_the_sensor, **block.of_the_base, **own})


def wait_until_armable(sensor: MonitoredSensor) -> None:
    """Wait for a live sensor where the policy wants one; SensorError, with the reasons, if none comes."""
    sensor.warm_up(PATIENCE_S)
    if not sensor.accelerometer.armable:
        raise SensorError(f"the arm is not armed: {_reasons(sensor)}")


def judge(sensor: MonitoredSensor, seconds: dict[str, float], *, is_used: bool) -> tuple[list[str], bool]:
    """Say what was wrong with the sensor of a run, so many ``seconds`` in each state, and whether it was of no use.

    It was of no use if the law's gravity ``is_used`` to come from it and it was never live, for a reason that the chain
    counted: a run may be too short for any sensor.
    """
    counters = sensor.accelerometer.counters
    useless = is_used and not seconds["live"] and any(counters[name] for name in ravengc.FAULTS)
    said = ["it was never live: the law had the gravity of a level base throughout"] if useless else []
    watched = complaints(sensor.judged_by(seconds)) if isinstance(sensor, WatchedSensor) else []
    return [*said, *watched], useless


def _reasons(sensor: MonitoredSensor) -> str:
    chain = sensor.accelerometer
    words = [ravengc.FAULTS[name] for name in chain.alarms] or [f"the sensor is {chain.state} after {PATIENCE_S:g} s"]
    if isinstance(sensor, LiveSensor) and sensor.norm is not None:
        words.append(size_words(sensor.norm, sensor.address, chain.likely_unit))
    return "; ".join(part for part in [*words, sensor.remark] if part)
