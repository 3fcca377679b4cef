"""The control law in its loop: what it is given, what is recorded of it, and what does not fit together."""

from __future__ import annotations

import time

import numpy as np
import pytest

import ravengc
from loop_parts import GAINS, TILTED, Integrator, Tilted, loop_on, still
from ravengc.control import CONTROLLER_STATES, EVENTS, Controller, Drive, raven2_drive
from ravengc.errors import ArgumentError, TimingError
from ravengc.loop import ControlLoop
from ravengc.trajectory import JointSwing


class Rocking(Tilted):
    """A sensor that also says how the base turns."""

    def __init__(self) -> None:
        super().__init__()
        self.angular_velocity, self.angular_acceleration = np.array((0.5, 0.0, -0.2)), np.array((3.0, 1.0, 0.0))


class Chained(Tilted):
    """A sensor that leaves it to its chain to say so."""

    def __init__(self) -> None:
        super().__init__()
        self.accelerometer = ravengc.Accelerometer()


@pytest.mark.parametrize("sensor", [Rocking(), Chained()])
def test_full_base_motion_is_the_inverse_dynamics_at_rest(sensor: Rocking | Chained) -> None:
    robot = ravengc.load("rrbot")
    loop = ControlLoop(Integrator(), Controller(robot, "pd+bm", GAINS), sensor, still(), duration_s=0.05, paced=False)
    record = loop.run()
    w, dw = (getattr(sensor, name, np.zeros(3)) for name in ("angular_velocity", "angular_acceleration"))
    base = ravengc.BaseMotion(specific_force=-TILTED, angular_velocity=w, angular_acceleration=dw)
    zero = np.zeros(2)
    for q, tau_gravity in zip(record.q, record.tau_gravity, strict=True):
        assert tau_gravity == pytest.approx(robot.inverse_dynamics(q, zero, zero, base), rel=1e-12)


def test_a_law_that_takes_turning_needs_a_sensor_that_knows_of_it() -> None:
    controller = Controller(ravengc.load("rrbot"), "pd+bm", GAINS)
    with pytest.raises(ArgumentError, match="sensor is a Tilted without 'accelerometer'"):
        ControlLoop(Integrator(), controller, Tilted(), still())


def test_feedback_from_the_motors_drives_the_joints_alike() -> None:
    """With gains C^T K C at the motors, coupled cables and all, the arm moves as with K at the joints."""
    robot = ravengc.load("raven2_gold")
    transmission = robot.spec.transmission
    assert transmission is not None
    C = np.array(transmission.joint_per_motor)
    kp, kd = np.array((400.0, 300.0, 5e4)), np.array((10.0, 8.0, 4e3))
    rest = np.array((0.5, 1.5, 0.4))

    class Raven(Integrator):
        def __init__(self) -> None:
            super().__init__()
            self.q, self.qd = rest.copy(), np.zeros(3)
            self.torques: list[np.ndarray] = []

        def step(self, tau: np.ndarray, dt: float) -> None:
            self.torques.append(tau.copy())
            self.q += dt * np.array((0.1, -0.1, 0.05))
            self.qd[:] = (0.1, -0.1, 0.05)

    torques = {}
    for feedback in ("joint", "motor"):
        gains = [np.diag(k) if feedback == "joint" else C.T @ np.diag(k) @ C for k in (kp, kd)]
        # A controller's gains are diagonal; what is not, is left out on both sides.
        diagonal = [np.diag(k).copy() for k in gains]
        controller = Controller(
            robot, "pd+dg", Drive(*diagonal, np.zeros(3), "test"), feedback=feedback, output="joint", limits="robot"
        )
        plant, swing = Raven(), JointSwing(rest, np.zeros(3), np.ones(3))
        record = ControlLoop(plant, controller, Tilted(), swing, duration_s=0.02, paced=False).run()
        torques[feedback] = record.tau_gravity
        m = robot.motor_positions(record.q[-1])
        if feedback == "motor":
            motor_torque = diagonal[0] * (robot.motor_positions(rest) - m) - diagonal[1] * np.linalg.solve(C, plant.qd)
            assert record.tau_pd[-1] == pytest.approx(np.linalg.solve(C.T, motor_torque), rel=1e-9)
    assert torques["motor"] == pytest.approx(torques["joint"], rel=1e-9)


def test_a_loop_at_another_rate_than_its_controller_counts_is_refused() -> None:
    robot = ravengc.load("rrbot")
    for timed in ({"ramp_s": 0.5}, {"tau_rate_max": 10.0}, {"jump": 0.1}, {"differentiate": True}):
        controller = Controller(robot, "pd", GAINS, **timed)
        with pytest.raises(
            TimingError, match=r"1000 updates per second .* the loop makes 500; make it with rate_hz=500"
        ):
            ControlLoop(Integrator(), controller, Tilted(), still(), rate_hz=500.0)
        controller = Controller(robot, "pd", GAINS, rate_hz=500.0, **timed)
        ControlLoop(Integrator(), controller, Tilted(), still(), rate_hz=500.0)


def test_a_loop_has_no_use_for_torques_at_the_motors() -> None:
    drive = raven2_drive()
    controller, plant = Controller(ravengc.load("raven2_gold"), "pd", drive, output="motor"), Integrator()
    plant.q, plant.qd = np.zeros((2, 3))
    with pytest.raises(ArgumentError, match="output='joint'"):
        ControlLoop(plant, controller, Tilted(), still())


def test_a_record_holds_how_the_controller_was() -> None:
    plant = Integrator()

    def lose_an_encoder(step: int) -> None:
        plant.q[1] = np.nan if step >= 20 else plant.q[1]

    plant._at_step = lose_an_encoder
    record = loop_on(plant, "pd+dg", duration_s=0.15).run()
    states = [CONTROLLER_STATES[state] for state in record.controller_state]
    assert states[:21] == ["armed"] * 21
    assert states[-1] == "fault"
    assert states.index("fault") == 21 + 50
    bits = {name: 1 << bit for bit, name in enumerate(EVENTS)}
    assert (record.controller_status[:21] == 0).all()
    assert ((record.controller_status[21:] >> 32 & bits["absent"]) != 0).all()
    assert np.isfinite(record.tau).all()
    assert record.tau[-1] == pytest.approx(record.tau_gravity[-1])


def test_skipped_cycles_make_the_last_pose_older() -> None:
    plant = Integrator(lambda step: time.sleep(0.02) if step == 10 else None)
    controller = Controller(ravengc.load("rrbot"), "pd", GAINS, differentiate=True)
    loop = ControlLoop(plant, controller, Tilted(), still(), duration_s=0.05)
    speeds = []
    update = controller.update

    def remembered() -> None:
        update()
        speeds.append((GAINS.kp * -controller.q - controller.tau_pd) / GAINS.kd)

    controller.update = remembered
    record = loop.run()
    assert record.skipped >= 15
    np.testing.assert_allclose(np.array(speeds)[1:], record.qd[1 : record.count], rtol=0.3, atol=0.05)
