"""Encoders of a plant's motors: counts, velocity by differences, counters that wrap, the RAVEN II's numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc
from ravengc import sim
from ravengc.control import RAVEN2_RATIO, Controller, raven2_drive
from ravengc.errors import ArgumentError, ModelError
from ravengc.loop import ControlLoop
from ravengc.trajectory import swing_within_limits

pytest.importorskip("mujoco")

RAVEN = ravengc.load("raven2_gold")
DRIVE = raven2_drive()
PLANT = sim.Plant(RAVEN, rotor_inertia=DRIVE.rotor_inertia)
PER_TURN = 4000.0 / (2.0 * np.pi)


@settings(deadline=None, max_examples=50)
@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.floats(1.0, 1e7))
def test_a_reading_is_less_than_one_count_low(q: tuple[float, float, float], counts: float) -> None:
    PLANT.reset(q)
    encoders = sim.Encoders(PLANT, counts)
    short = PLANT.q - encoders.q
    assert (short >= -1e-12).all()
    assert (short < 1.0 / counts + 1e-12).all()
    np.testing.assert_allclose(encoders.counts, np.round(encoders.q * counts), atol=0)


def test_velocity_is_the_first_difference_of_positions() -> None:
    plant = sim.Plant(RAVEN, rotor_inertia=DRIVE.rotor_inertia)
    plant.reset((0.8, 1.5, 0.4), (0.1, -0.2, 0.05))
    encoders = sim.Encoders(plant, 1e5)
    assert encoders.qd.tolist() == [0.0, 0.0, 0.0]
    for _ in range(5):
        before = encoders.q.copy()
        encoders.step((1.0, 2.0, 3.0), 1e-3)
        np.testing.assert_allclose(encoders.qd, (encoders.q - before) / 1e-3, rtol=1e-9)
        np.testing.assert_allclose(encoders.qd, plant.qd, atol=2e-2)
    kept = encoders.qd.copy()
    encoders.update()
    assert encoders.qd.tolist() == kept.tolist()
    encoders.reset()
    assert encoders.qd.tolist() == [0.0, 0.0, 0.0]


def test_offset_is_that_of_a_robot_homed_wrong() -> None:
    PLANT.reset((0.5, 1.5, 0.4))
    exact, wrong = sim.Encoders(PLANT, 1e6), sim.Encoders(PLANT, 1e6, offset=(0.01, -0.02, 0.003))
    np.testing.assert_allclose(wrong.q - exact.q, (0.01, -0.02, 0.003), atol=1e-12)
    assert wrong.counts.tolist() == exact.counts.tolist()


def test_counters_wrap_round() -> None:
    PLANT.reset((0.127, -0.129, 0.4))
    encoders = sim.Encoders(PLANT, 1000.0, bits=8)
    assert encoders.counts.tolist() == [127, 127, 400 - 512]
    PLANT.reset((0.1285, -0.128, 0.4))
    encoders.update()
    assert encoders.counts.tolist() == [-128, -128, 400 - 512]
    assert encoders.q[0] == pytest.approx(-0.128)


def test_the_raven_s_counts_are_those_of_its_motors() -> None:
    """4000 counts a turn behind 136.2, 121.5 and 2158.6 rad per rad or m, and the cables' coupling."""
    motors = np.array((100.0, 200.0, 900.0)) + 0.5 / PER_TURN
    PLANT.reset(RAVEN.joint_positions(motors))
    encoders = sim.raven2_encoders(PLANT)
    np.testing.assert_allclose(encoders.counts, np.floor(motors * PER_TURN))
    assert np.abs(encoders.q - PLANT.q).max() < 2e-5
    resolution = 1.0 / (PER_TURN * RAVEN2_RATIO)
    assert resolution == pytest.approx((1.153e-5, 1.293e-5, 7.28e-7), rel=1e-3)


def test_encoders_read_the_motor_s_side_of_a_cable() -> None:
    plant = sim.Plant(RAVEN, rotor_inertia=DRIVE.rotor_inertia, cable_stiffness=(500.0, 500.0, 1e4))
    plant.reset((0.8, 1.5, 0.4))
    encoders = sim.raven2_encoders(plant)
    assert np.abs(encoders.q - plant.motor_q).max() < 2e-5
    assert np.abs(plant.motor_q - plant.q).max() > 1e-3


def test_a_loop_drives_its_plant_through_encoders() -> None:
    plant = sim.Plant(RAVEN, sim.tilted(20.0, "y"), rotor_inertia=DRIVE.rotor_inertia)
    motion = swing_within_limits(RAVEN.spec)
    plant.reset(motion.start)
    sensor = sim.SampledAccelerometer(plant.accelerometer)
    controller = Controller(RAVEN, "pd+dg", DRIVE)
    record = ControlLoop(sim.raven2_encoders(plant), controller, sensor, motion, duration_s=0.3, paced=False).run()
    assert record.count == 300
    assert np.abs(record.q_desired[-1] - record.q[-1]).max() < 0.02
    assert np.abs(record.qd[1:] - np.diff(record.q, axis=0) / 1e-3).max() < 1e-6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"counts_per_unit": 0.0}, "counts_per_unit must be positive"),
        ({"counts_per_unit": (1.0, 2.0)}, "counts_per_unit must be one number or 3"),
        ({"offset": np.nan}, "offset must be one number or 3"),
        ({"bits": 1}, "bits is 1; expected a whole number from 2"),
        ({"plant": RAVEN}, "plant is a Robot; expected a Plant"),
    ],
)
def test_impossible_encoders_are_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        sim.Encoders(**{"plant": PLANT, "counts_per_unit": 1e5, **options})


def test_motors_need_a_transmission() -> None:
    plant = sim.Plant(ravengc.load("panda"), rotor_inertia=0.1)
    with pytest.raises(ModelError, match="robot 'panda' has no transmission"):
        sim.raven2_encoders(plant)
