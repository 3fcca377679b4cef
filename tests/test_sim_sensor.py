"""The simulated inertial sensor: latency, stamps, errors of its own, and the motion of the base that comes out."""

from __future__ import annotations

import numpy as np
import pytest

import ravengc
from ravengc import sim
from ravengc.errors import ArgumentError, ConfigError
from ravengc.monitored import STATES

pytest.importorskip("mujoco")

RAVEN = ravengc.load("raven2_gold")
PLACE = np.array((0.1, -0.05, 0.3))
SHOULDER = np.array(RAVEN.spec.base.rotation)[:, 2]
ROCKING = sim.rocking(10, 20, hz=1.0, axis=SHOULDER, pivot=(0.0, 0.0, -0.3))


class Ramp:
    """A specific force whose first component tells when it was read (s)."""

    def __init__(self) -> None:
        self.time = 0.0

    def __call__(self) -> np.ndarray:
        return np.array((self.time, 0.0, 9.8))


def ramped(**options: object) -> list[tuple[float, float, float]]:
    """For each millisecond the time, when the gravity in use was felt, and the age that the chain knows."""
    ramp, found = Ramp(), []
    sensor = sim.SampledAccelerometer(ramp, **options)
    for k in range(900):
        ramp.time = 1e-3 * k
        sensor.update(ramp.time)
        found.append((ramp.time, -sensor.gravity[0], sensor.age))
    return found[600:]


@pytest.mark.parametrize("latency_s", [0.0, 0.015, 0.05, 0.13])
def test_a_sample_is_seen_as_long_after_it_was_taken(latency_s: float) -> None:
    late = [time - felt for time, felt, _ in ramped(hz=100.0, latency_s=latency_s)]
    assert min(late) == pytest.approx(latency_s, abs=1.001e-3)
    assert max(late) == pytest.approx(latency_s + 0.009, abs=1.001e-3)


@pytest.mark.parametrize(("stamp", "hidden"), [("taken", 0.0), ("arrived", 0.05)])
def test_the_age_of_a_sample_is_that_of_its_stamp(stamp: str, hidden: float) -> None:
    for time, felt, age in ramped(hz=100.0, latency_s=0.05, stamp=stamp):
        assert age == pytest.approx(time - felt - hidden, abs=1e-6)


def test_bias_scale_and_misalignment_are_the_sensor_s() -> None:
    force = np.array((1.0, -2.0, 9.0))
    skewed = np.array(((1.01, 0.002, 0.0), (0.0, 0.99, 0.003), (0.001, 0.0, 1.02)))
    sensor = sim.SampledAccelerometer(lambda: force, scale=skewed, bias=(0.1, 0.2, -0.3))
    for k in range(500):
        sensor.update(1e-3 * k)
    np.testing.assert_allclose(-sensor.gravity, skewed @ force + (0.1, 0.2, -0.3), atol=1e-9)


def test_calibration_of_the_chain_takes_them_out_again() -> None:
    force, bias = np.array((1.0, -2.0, 9.0)), (0.1, 0.2, -0.3)
    skewed = np.array(((1.01, 0.002, 0.0), (0.0, 0.99, 0.003), (0.001, 0.0, 1.02)))
    correction = np.linalg.inv(skewed)
    sensor = sim.SampledAccelerometer(lambda: force, scale=skewed, bias=bias, correction=correction)
    sensor.update(0.0)
    wrong = sim.SampledAccelerometer(lambda: force, scale=1.05)
    right = sim.SampledAccelerometer(lambda: force, scale=1.05, bias=bias, correction=np.eye(3) / 1.05)
    for k in range(500):
        wrong.update(1e-3 * k)
        right.update(1e-3 * k)
    assert np.linalg.norm(wrong.gravity) == pytest.approx(1.05 * np.linalg.norm(force))
    np.testing.assert_allclose(-right.gravity, force + np.array(bias) / 1.05, atol=1e-9)


def run(seconds: float = 1.2, **options: object) -> tuple[np.ndarray, np.ndarray]:
    """RMS errors of specific force, angular velocity and acceleration of the base, and RMS sizes, of the worst axis."""
    plant = sim.Plant(RAVEN, ROCKING, sensor=PLACE, rotor_inertia=1.0)
    sensor = sim.SampledAccelerometer(
        plant.accelerometer, gyro=plant.gyro, position=PLACE, moving_base=True, **{"hz": 1000.0, **options}
    )
    errors, sizes = [], []
    for k in range(round(1e3 * seconds)):
        sensor.update(1e-3 * k)
        f, w, dw = plant.base.motion_at(plant.time, (0.0, 0.0, 0.0))
        errors.append((sensor.gravity + f, sensor.angular_velocity - w, sensor.angular_acceleration - dw))
        sizes.append((f, w, dw))
        plant.step(np.zeros(3), 1e-3)
    assert (STATES[sensor.state], sensor.status) == ("live", 0)
    return tuple(np.sqrt((np.array(one)[300:] ** 2).mean(axis=0)).max(axis=1) for one in (errors, sizes))


def test_gyro_and_lever_arm_give_the_motion_of_the_base() -> None:
    errors, sizes = run()
    assert (errors < (0.01, 1e-4, 0.05)).all()
    assert (errors[1:] < 0.02 * sizes[1:]).all()


def test_a_filtered_noisy_sensor_is_still_close() -> None:
    errors, sizes = run(noise=0.02, gyro_noise=0.002, cutoff_hz=20.0, hz=500.0)
    assert (errors < (0.15, 0.05, 0.3)).all()
    assert (errors < (0.02, 0.1, 0.1) * sizes).all()


def test_the_full_law_with_this_sensor_is_close_to_the_exact_motion() -> None:
    """Torques of inverse dynamics from the sensor against those of the motion: 1 % where f0 alone leaves 15 %."""
    plant = sim.Plant(RAVEN, ROCKING, sensor=PLACE, rotor_inertia=1.0)
    sensor = sim.SampledAccelerometer(plant.accelerometer, hz=1000.0, gyro=plant.gyro, position=PLACE, moving_base=True)
    q, still = np.array((0.8, 1.5, 0.4)), np.zeros(3)
    full, gravity, exact = [], [], []
    for k in range(1300):
        sensor.update(1e-3 * k)
        felt = ravengc.BaseMotion(
            specific_force=-sensor.gravity,
            angular_velocity=sensor.angular_velocity,
            angular_acceleration=sensor.angular_acceleration,
        )
        full.append(RAVEN.inverse_dynamics(q, still, still, felt))
        gravity.append(RAVEN.gravity_torque(q, sensor.gravity))
        exact.append(RAVEN.inverse_dynamics(q, still, still, ROCKING.motion(plant.time)))
        plant.step(still, 1e-3)
    truth = np.array(exact)[300:]
    with_turning, without = (np.array(one)[300:] - truth for one in (full, gravity))
    size = np.sqrt((truth**2).mean(axis=0))
    assert (np.sqrt((with_turning**2).mean(axis=0)) / size < 0.01).all()
    assert np.sqrt((without**2).mean(axis=0))[0] / size[0] > 0.05


def test_errors_of_the_gyro_come_through() -> None:
    plant = sim.Plant(RAVEN, rotor_inertia=1.0)
    sensor = sim.SampledAccelerometer(plant.accelerometer, gyro=plant.gyro, gyro_bias=(0.01, -0.02, 0.03))
    for k in range(500):
        sensor.update(1e-3 * k)
    np.testing.assert_allclose(sensor.angular_velocity, (0.01, -0.02, 0.03), atol=1e-6)
    np.testing.assert_allclose(sensor.angular_acceleration, 0.0, atol=1e-6)


def test_without_a_gyro_no_turning_is_claimed() -> None:
    sensor = sim.SampledAccelerometer(lambda: np.array((0.0, 0.0, 9.8)))
    for k in range(300):
        sensor.update(1e-3 * k)
    assert np.abs((sensor.angular_velocity, sensor.angular_acceleration)).max() == 0.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"latency_s": -0.1}, "latency_s is -0.1; expected a number from 0"),
        ({"latency_s": np.nan}, "latency_s is nan"),
        ({"stamp": "sent"}, "stamp 'sent' is unknown: choose 'taken', 'arrived'"),
        ({"gyro_noise": -1.0}, "gyro_noise is -1"),
        ({"bias": (1.0, 2.0)}, "bias must be 3 finite numbers"),
        ({"scale": np.eye(2)}, "scale must be one number or a 3x3 matrix"),
        ({"gyro": 5}, "gyro is an int; expected a function"),
    ],
)
def test_impossible_sensors_are_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises((ArgumentError, ConfigError), match=message):
        sim.SampledAccelerometer(lambda: np.zeros(3), **options)
