"""A live sensor in a hand: the user is asked for positions, and what was still becomes a recording."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from calibration_scenes import G, Turned, evenly, rotation
from ravengc.calibration import (
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
from ravengc.errors import ArgumentError, CalibrationError, SensorError, UnitsError
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
    assert hand.asked[1] == (
        "That was +z up (the axes are the sensor's). +x up: put it there, hold it still and press Enter"
    )
    assert hand.asked[2].startswith("That was -x up (the axes")
    assert calibrate_accelerometer(recording).calibration.method == "six positions"
    hand = Turned([z] * 20)
    with pytest.raises(CalibrationError, match=r"\+x up was not taken in 5 attempts\. That was \+z up"):
        ask_for_faces(hand.read, hand.ask)


def test_a_face_that_leans_too_far_is_asked_for_again() -> None:
    faces = np.array(list(FACES.values()))
    hand = Turned(G * np.insert(faces, 0, [0.8, 0.6, 0.0], axis=0))
    assert calibrate_accelerometer(ask_for_faces(hand.read, hand.ask)).calibration.good
    assert hand.asked[1].startswith("It leans by 37 degrees: set it on its face. +x up: put it there")


def test_a_position_that_is_not_held_is_asked_for_again_and_those_before_it_are_kept() -> None:
    hand = Turned()

    def read(timeout_s: float) -> Sample | None:
        sample = hand.read(timeout_s)
        if sample is None or len(hand.asked) != 4:
            return sample
        x, y, z = sample.specific_force
        return sample._replace(specific_force=(x + (-1.0) ** sample.seq, y, z))

    assert calibrate_accelerometer(ask_for_faces(read, hand.ask)).calibration.good
    assert len(hand.asked) == 7
    assert hand.asked[4].startswith("Not taken (it did not lie still within 30 s: the standard deviation is 0.99")
    assert hand.asked[4].endswith("). -y up: put it there, hold it still and press Enter")


@pytest.mark.parametrize("ask", [ask_for_faces, lambda read, answer: ask_for_tilts(read, answer, 3)])
def test_a_user_may_give_up(ask: Any) -> None:
    hand = Turned([])
    with pytest.raises(CalibrationError, match="the user gave up; all positions are needed"):
        ask(hand.read, hand.ask)


@pytest.mark.parametrize("limits", [StillLimits(), StillLimits(shortest_s=3.0), StillLimits(window_s=1.0)])
@pytest.mark.parametrize("noise", [0.02, 0.044, 0.048])
def test_what_a_session_takes_is_a_rest_for_the_calibration_too(limits: StillLimits, noise: float) -> None:
    """Near the limit of what counts as still, and for rests longer than a position is held by itself."""
    hand = Turned(noise=noise)
    recording = ask_for_faces(hand.read, hand.ask, limits)
    assert calibrate_accelerometer(recording, limits=limits).calibration.method == "six positions"


def test_huge_numbers_in_between_are_left_out_and_told() -> None:
    hand = Turned()

    def read(timeout_s: float) -> Sample | None:
        sample = hand.read(timeout_s)
        return sample._replace(specific_force=(1e12, 0.0, 0.0)) if sample and sample.seq % 50 == 0 else sample

    outcome = calibrate_accelerometer(ask_for_faces(read, hand.ask))
    assert outcome.calibration.good
    assert outcome.recording.notes[0] == "position 1: 4 samples not finite, huge or not in order: left out"


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


def test_stamps_that_stand_still_or_go_back_are_no_endless_wait() -> None:
    def stuck(timeout_s: float) -> Sample | None:
        return Sample(1, 10**18, (0.0, 0.0, G)) if timeout_s else None

    for wait in (lambda: record(stuck, 1.0), lambda: wait_until_still(stuck, QUIET)):
        with pytest.raises(CalibrationError, match="stamps of 1000 samples do not move on"):
            wait()


@pytest.mark.parametrize("seconds", [0.0, -1.0, np.nan, np.inf, 1e9])
def test_a_recording_takes_a_time_that_can_be_waited_for(seconds: float) -> None:
    with pytest.raises(ArgumentError, match="expected a number above 0, up to 3600"):
        record(Turned().read, seconds)


def test_record_takes_so_many_seconds() -> None:
    assert record(Turned().read, 3.0).duration == pytest.approx(3.0)
