"""Torques that hold an arm at 1 kHz, from a robot file and a base sensor.

python examples/imu_to_torques.py                                           # a UR5, a simulated sensor
python examples/imu_to_torques.py my_arm.urdf 'serial:/dev/ttyUSB0?format=line'

`ravengc info my_arm.urdf` shows what was understood of the arm, and `ravengc sensor 'serial:...'` whether the sensor is
well. Where the sensor's axes are not those of the base, `ravengc calibrate accelerometer` finds the `rotation`.
"""

from __future__ import annotations

import argparse
import sys
import time

import numpy as np

import ravengc as rg
from ravengc.errors import RavenGCError, SensorError
from ravengc.sensors import LiveSensor, parse_address
from ravengc.trajectory import swing_within_limits

PERIOD_NS = 1_000_000
PATIENCE_S, SECONDS = 5.0, 3.0


class Drives:
    """In the place of yours: joints that swing slowly, and torques that are remembered."""

    def __init__(self, robot: rg.Robot) -> None:
        self.swing, self.qd = swing_within_limits(robot.spec), np.zeros(robot.n)
        self.torques: list[np.ndarray] = []

    def read(self, q: np.ndarray) -> None:
        """Write where the joints are (rad, m) into ``q``."""
        self.swing.at(1e-9 * PERIOD_NS * len(self.torques), q, self.qd)

    def exert(self, tau: np.ndarray) -> None:
        """Send torques (N m, N) to the motors."""
        self.torques.append(tau.copy())


def hold(robot: rg.Robot, address: str, drives: Drives, seconds: float) -> rg.Accelerometer:
    """Hold the arm for so long once the sensor is trusted; return the sensor's chain, which knows what it saw."""
    chain = rg.Accelerometer(rate_hz=100, policy="strict")
    q, tau = np.zeros(robot.n), np.zeros(robot.n)
    cycle = robot.bind(q=q, gravity=chain, out=tau)
    with LiveSensor(chain, parse_address(address).prepare()) as sensor:  # a thread that feeds the chain
        sensor.warm_up(PATIENCE_S)
        if not chain.armable:
            why = "; ".join(filter(None, (*(rg.FAULTS[alarm] for alarm in chain.alarms), sensor.remark)))
            raise SensorError(f"{address}: no sensor to trust after {PATIENCE_S:g} s: {why}")
        start = time.monotonic_ns()
        for due in range(start, start + round(1e9 * seconds), PERIOD_NS):
            time.sleep(1e-9 * max(0, due - time.monotonic_ns()))
            drives.read(q)
            cycle()  # newest sample -> gravity that is bounded whatever was sent -> torque
            drives.exert(tau)
    return chain


def main(file: str, address: str) -> None:
    """Hold, and say between what the torques were."""
    robot = rg.load(file)
    drives = Drives(robot)
    chain = hold(robot, address, drives, SECONDS)
    print(f"{len(drives.torques)} cycles, the sensor is {chain.state}")  # noqa: T201 -- its result
    for name, torques in zip(robot.joint_names, np.transpose(drives.torques), strict=True):
        print(f"{name:>16}: {torques.min():+8.3f} to {torques.max():+8.3f}")  # noqa: T201 -- its result


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", default="ur5", help="bundled robot, or a .toml or .urdf file")
    parser.add_argument("address", nargs="?", default="sim:rocking:10:20:1?noise=0.03", help="sensor of the base")
    try:
        main(**vars(parser.parse_args()))
    except RavenGCError as error:
        sys.exit(str(error))
