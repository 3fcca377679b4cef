"""The base sensor of ``ravengc run``: the plant's own, or a real or recorded one behind the same chain."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import ravengc
from ravengc.calibration.block import AccelerometerBlock, read_block
from ravengc.errors import ConfigError, SensorError
from ravengc.monitored import MonitoredSensor, chain_for
from ravengc.sensors.address import parse_address
from ravengc.sensors.live import LiveSensor
from ravengc.sim import Plant, SampledAccelerometer

if TYPE_CHECKING:
    import argparse

__all__ = ["OWN", "block_of", "chain_of", "run_sensor", "wait_until_armable"]

OWN = "sim"
"""The address of the plant's own accelerometer."""
PATIENCE_S = 3.0
"""How long a strict run waits for its sensor."""


def run_sensor(args: argparse.Namespace, robot: ravengc.Robot, plant: Plant, *, turning: bool) -> MonitoredSensor:
    """Open the sensor that the options name, with the chain that the robot's file declares.

    ``turning``: the plant's own has a gyro, by which the chain takes out the lever arm to the base origin.
    """
    block = block_of(robot.spec.file)
    if args.sensor == OWN:
        chain = {"policy": args.policy or block.policy, "cutoff_hz": args.cutoff}
        if turning:
            chain |= {"gyro": plant.gyro, "position": args.sensor_place}
        return SampledAccelerometer(plant.accelerometer, hz=args.sensor_rate, noise=args.noise, seed=args.seed, **chain)
    if args.fast:
        raise ConfigError(f"--fast: sensor '{args.sensor}' lives in real time; leave out --fast")
    address = parse_address(args.sensor).with_defaults(unit=block.unit)
    own = {} if args.cutoff is None else {"cutoff_hz": args.cutoff}
    if args.policy is not None:
        own["policy"] = args.policy
    return LiveSensor(chain_of(block, block.rate_hz or 100.0, **own), address.prepare())


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
    return chain_for(rate_hz, **{**declared, **own})


def wait_until_armable(sensor: MonitoredSensor) -> None:
    """Wait for a live sensor where the policy wants one; SensorError, with the reasons, if none comes."""
    sensor.warm_up(PATIENCE_S)
    if not sensor.accelerometer.armable:
        raise SensorError(f"the arm is not armed: {_reasons(sensor)}")


def _reasons(sensor: MonitoredSensor) -> str:
    chain = sensor.accelerometer
    words = [ravengc.FAULTS[name] for name in chain.alarms] or [f"the sensor is {chain.state} after {PATIENCE_S:g} s"]
    if chain.likely_unit is not None:
        words.append(f"it looks like {chain.likely_unit}: set the unit")
    return "; ".join([*words, sensor.remark] if sensor.remark else words)
