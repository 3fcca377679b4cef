"""What holds a UR5 on a small boat: by level gravity, by an accelerometer, by an inertial unit two metres away.

python examples/ur5_on_a_boat.py

The arm stands still on its deck. What it needs is then the inverse dynamics on a moving base; how far the three laws
are from that is the error that feedback has to carry. `ravengc run --robot ur5 --base ship --controller pd+bm` puts
the last of them into a loop.
"""

from __future__ import annotations

import numpy as np

import ravengc as rg

Q = np.radians([20.0, -70.0, 80.0, -30.0, 60.0, 0.0])
UNIT_AT = np.array([-2.0, 0.3, 0.5])
"""Where the inertial unit is bolted to the deck, m, base axes of the arm."""
SECONDS = np.arange(0.0, 60.0, 0.01)


def torques(robot: rg.Robot, boat: rg.sim.BaseTrajectory, t: float) -> dict[str, np.ndarray]:
    """What each law exerts at ``t`` (s), and what is right."""
    rest = np.zeros(robot.n)
    at_base, *turning = boat.motion_at(t, np.zeros(3))
    at_unit, w, dw = boat.motion_at(t, UNIT_AT)
    here = rg.BaseMotion(specific_force=at_base, angular_velocity=turning[0], angular_acceleration=turning[1])
    unit = rg.BaseMotion.from_imu(
        specific_force=at_unit, angular_velocity=w, angular_acceleration=dw, mounting=rg.Mounting(np.eye(3), UNIT_AT)
    )
    return {
        "right": robot.inverse_dynamics(Q, rest, rest, here),
        "level gravity": robot.gravity_torque(Q, rg.Gravity.level()),
        "accelerometer": robot.gravity_torque(Q, rg.SpecificForce(*at_unit)),
        "inertial unit": robot.inverse_dynamics(Q, rest, rest, unit),
    }


def errors() -> dict[str, np.ndarray]:
    """Largest error (n,) of each law in a minute, N m."""
    robot = rg.load("ur5")
    boat = rg.sim.ship(roll_deg=15.0, roll_hz=0.25, pitch_deg=6.0, pitch_hz=0.3, heave=0.4, heave_hz=0.25)
    minute = [torques(robot, boat, t) for t in SECONDS.tolist()]
    return {
        law: np.max([np.abs(moment[law] - moment["right"]) for moment in minute], axis=0)
        for law in minute[0]
        if law != "right"
    }


if __name__ == "__main__":
    for law, largest in errors().items():
        print(f"{law}: at most {', '.join(f'{error:.2f}' for error in largest)} N m off")  # noqa: T201 -- its result
