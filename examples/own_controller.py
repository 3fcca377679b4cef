"""Resolved rate under a controller of your own: an arm that slides along a wall and presses with 5 N.

python examples/own_controller.py

The controller is any law that gives a twist (m/s, rad/s, base axes); `ResolvedRate` makes joint rates of it that keep
to the arm's limits and stay calm near singularities. Here the law is an admittance: the tool moves on as long as the
force is not the one that is wanted.
"""

from __future__ import annotations

import numpy as np

import ravengc as rg

RATE_HZ, SECONDS = 1000.0, 4.0
WALL_N_PER_M, WANTED_N, ADMITTANCE = 5000.0, 5.0, 0.002
"""The wall's stiffness, the force that is wanted, and how fast the tool moves for each newton that is missing (m/s)."""
ALONG = 0.03
"""How fast it slides, m/s."""


def slide() -> tuple[np.ndarray, np.ndarray, str]:
    """Press and slide: the forces (N), the tool's places (k, 3) in m, and what held the last step back, if anything."""
    robot = rg.load("ur5")
    q = np.radians([0.0, -110.0, 110.0, -90.0, -90.0, 0.0])
    twist, rates = np.zeros(6), np.zeros(robot.n)
    rate = rg.ResolvedRate(robot, rate_hz=RATE_HZ, qd_max=1.0, qdd_max=10.0)
    cycle = rate.bind(q=q, twist=twist, out=rates)
    wall_z = robot.forward_kinematics(q)[2, 3] - 0.005
    forces, places = [], []
    for _ in range(round(RATE_HZ * SECONDS)):
        place = robot.forward_kinematics(q)[:3, 3]
        force = WALL_N_PER_M * max(0.0, wall_z - place[2])  # your force sensor
        twist[:3] = 0.0, ALONG, ADMITTANCE * (force - WANTED_N)  # your controller
        cycle()
        q += rates / RATE_HZ  # your drives
        forces.append(force)
        places.append(place)
    return np.array(forces), np.array(places), rate.reason


if __name__ == "__main__":
    forces, places, reason = slide()
    print(f"{forces[-1]:.3f} N after {SECONDS:g} s, at most {forces.max():.3f} N")  # noqa: T201 -- its result
    print(f"slid {1e3 * np.ptp(places[:, 1]):.1f} mm; held back by: {reason or 'nothing'}")  # noqa: T201 -- its result
