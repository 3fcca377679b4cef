"""A live sensor in a hand: the user is asked for positions, and what was still becomes a recording."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from calibration_scenes import G, Turned, evenly, rotation
from ravengc.calibration import (
    CalibrationError,
    ask_for_faces,
    ask_for_positions,
    ask_for_tilts,
    calibrate_accelerometer,
    record,
    tilted_force,
)
from ravengc.calibration.positions import FACES
from ravengc.calibration.session import wait_until_still
from ravengc.calibration.still import StillLimits
from ravengc.errors import SensorError, UnitsError
from ravengc.sensors.sample import Sample

QUIET = StillLimits()


def test_six_faces_are_asked_for_and_calibrate() -> None:
    hand = Turned()
    recording = ask_for_faces(hand.read, hand.ask)
    assert [question[:5] for question in hand.asked] == [f"{face} up" for face in FACES]
    outcome = calibrate_accelerometer(recording)
    assert outcome.calibration.method == "six positions"
    assert outcome.calibration.good
    np.testing.assert_allclose(outcome.gyro_bias, [0.01, -0.02, 0.005])


def test_a_wrong_face_is_asked_for_again() -> None:
    x, y, z = G * np.eye(3)
    hand = Turned([z, -x, x, -x, y, -y, z, -z])
    recording = ask_for_faces(hand.read, hand.ask)
    assert hand.asked[1] == "That was +z up. +x up: turn it, hold it still and press Enter"
    assert hand.asked[2].startswith("That was -x up. +x up")
    assert calibrate_accelerometer(recording).calibration.method == "six positions"
    hand = Turned([z] * 20)
    with pytest.raises(CalibrationError, match=r"\+x up was not shown in 5 attempts"):
        ask_for_faces(hand.read, hand.ask)


def test_free_positions_go_on_until_the_user_has_enough() -> None:
    hand = Turned(G * evenly(14))
    recording = ask_for_positions(hand.read, hand.ask)
    assert hand.asked[0].startswith("Position 1 of 12 or more: turn it")
    assert "1 different so far, coverage 0 of 60 degrees, none near +x" in hand.asked[1]
    assert len(hand.asked) == 15
    assert calibrate_accelerometer(recording).calibration.method == "ellipsoid"


def test_known_tilts_are_asked_for_in_order() -> None:
    r = rotation(1)
    tilts = np.array([tilted_force(*np.radians(pair)) for pair in [(0, 0), (15, 0), (0, 15), (-15, 0)]])
    hand = Turned(tilts @ r)
    recording = ask_for_tilts(hand.read, hand.ask, 4)
    assert hand.asked[3] == "Tilt 4 of 4: hold the base still and press Enter"
    outcome = calibrate_accelerometer(recording, tilts=tilts)
    assert outcome.calibration.rotation is not None
    np.testing.assert_allclose(outcome.calibration.rotation, r, atol=0.01)


def test_a_sensor_without_gyroscope_does() -> None:
    hand = Turned(gyro=False)
    assert ask_for_faces(hand.read, hand.ask).angular_velocity is None


def test_restless_silent_and_lost_sensors_are_told() -> None:
    with pytest.raises(CalibrationError, match=r"did not lie still within 30 s: .* deviation is 0\.\d+ m/s²"):
        wait_until_still(Turned(noise=0.5).read, QUIET)
    with pytest.raises(CalibrationError, match="sent nothing for 5 s"):
        wait_until_still(lambda _: None, QUIET)
    with pytest.raises(UnitsError, match="looks like g"):
        wait_until_still(_in_g(Turned()), StillLimits(force=0.05))

    def gone(_: float) -> Sample:
        raise SensorError("unplugged")

    with pytest.raises(SensorError, match="unplugged"):
        wait_until_still(gone, QUIET)


def _in_g(hand: Turned) -> Any:
    def read(timeout_s: float) -> Sample | None:
        sample = hand.read(timeout_s)
        x, y, z = sample.specific_force if sample else (0.0, 0.0, 0.0)
        return sample and sample._replace(specific_force=(x / G, y / G, z / G))

    return read


def test_a_stream_of_nonsense_is_no_rest() -> None:
    count = iter(range(10**9))

    def read(timeout_s: float) -> Sample | None:
        number = next(count)
        return Sample(number, number * 10**7, (np.nan, np.inf, 1e300), None) if timeout_s else None

    with pytest.raises(CalibrationError, match=r"only 0 good samples in 2 s"):
        wait_until_still(read, QUIET)


def test_what_waits_in_a_buffer_is_dropped() -> None:
    """Three seconds of the position before are still in the buffer when the user presses Enter."""
    hand, stale = Turned([[G, 0.0, 0.0]]), [Sample(-k, -k * 10**7, (0.0, 0.0, G), None) for k in range(300)]
    hand.ask("next")

    def read(timeout_s: float) -> Sample | None:
        return stale.pop() if stale else hand.read(timeout_s)

    np.testing.assert_allclose(wait_until_still(read, QUIET).specific_force.mean(axis=0), [G, 0.0, 0.0], atol=0.01)


def test_record_takes_so_many_seconds() -> None:
    assert record(Turned().read, 3.0).duration == pytest.approx(3.0)
