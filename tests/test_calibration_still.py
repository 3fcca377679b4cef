"""Where a recording lies still, which positions that makes, and how far around they reach."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import G, cone, evenly, held, rotation
from ravengc.calibration import (
    ImuRecording,
    StillLimits,
    calibrate_accelerometer,
    coverage_deg,
    missing_faces,
    still_positions,
    still_segments,
    tilted_force,
)
from ravengc.calibration.imu import check_unit
from ravengc.calibration.positions import FACES, angle_between, different, rest_rate
from ravengc.errors import ArgumentError, CalibrationError, ConfigError, RavenGCError, UnitsError

SEEDS = st.integers(0, 2**32 - 1)
UPRIGHT = np.array([[0.0, 0.0, G]])


# Still segments


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, count=st.integers(1, 6), rate=st.sampled_from([50.0, 100.0, 400.0]), gyro=st.booleans())
def test_every_rest_is_found_and_nothing_else(seed: int, count: int, rate: float, gyro: bool) -> None:
    forces = G * evenly(max(count, 2))[:count] @ rotation(seed)
    recording = held(forces, rate=rate, gyro=gyro, seed=seed)
    segments = still_segments(recording)
    assert len(segments) == count
    for number, (segment, force) in enumerate(zip(segments, forces, strict=True)):
        assert 4.0 * number - 0.05 <= segment.begin < segment.end <= 4.0 * number + 3.05
        assert segment.end - segment.begin > 2.4
        assert np.linalg.norm(segment.force - force) < 0.02
        assert segment.noise == pytest.approx(0.02 / np.sqrt(rate), rel=1.0)


def test_limits_are_in_si_whatever_the_recording_was_in() -> None:
    recording = held(G * evenly(3))
    again = replace(recording, unit="g")
    assert [s.begin for s in still_segments(again)] == [s.begin for s in still_segments(recording)]


def test_a_constant_gyro_bias_is_rest_and_a_turn_is_not() -> None:
    still = held(UPRIGHT, hold_s=10.0)
    rate = still.angular_velocity
    assert rate is not None
    for bias in (0.0, 0.3):
        segments = still_segments(replace(still, angular_velocity=rate + bias))
        assert len(segments) == 1
        np.testing.assert_allclose(rest_rate(segments), np.array([0.01, -0.02, 0.005]) + bias, atol=0.001)
    turned = rate.copy()
    turned[400:500, 2] += 0.1
    assert len(still_segments(replace(still, angular_velocity=turned))) == 2


def test_a_slow_turn_without_a_gyroscope_is_no_long_rest() -> None:
    angle = np.radians(np.linspace(0.0, 40.0, 4000))
    force = G * np.column_stack([np.sin(angle), 0.0 * angle, np.cos(angle)])
    recording = ImuRecording(t=np.arange(4000) / 100.0, specific_force=force)
    assert all(segment.end - segment.begin < 1.3 for segment in still_segments(recording))


def test_a_pause_ends_a_rest() -> None:
    still = held(UPRIGHT, hold_s=10.0)
    t = still.t + np.where(np.arange(still.samples) >= 500, 60.0, 0.0)
    segments = still_segments(replace(still, t=t))
    assert [(round(s.begin), round(s.end)) for s in segments] == [(0, 5), (65, 70)]


@pytest.mark.parametrize("samples", [0, 1, 2, 7, 50])
def test_short_recordings_have_no_rest(samples: int) -> None:
    recording = ImuRecording(t=np.arange(samples) / 100.0, specific_force=np.tile([0.0, 0.0, G], (samples, 1)))
    assert still_segments(recording) == ()
    with pytest.raises(CalibrationError, match=r"a rest takes at least 1 s|never lies still"):
        still_positions(recording)


def test_restlessness_is_told_in_numbers() -> None:
    recording = held(UPRIGHT, noise=0.2, hold_s=5.0)
    with pytest.raises(CalibrationError, match=r"deviation is 0\.\d+ m/s² \(limit 0\.05\) and 0\.00\d+ rad/s .* raise"):
        still_positions(recording)
    assert len(still_segments(recording, StillLimits(force=0.4))) == 1


def test_a_gyroscope_in_another_unit_is_suspected() -> None:
    recording = held(UPRIGHT)
    assert recording.angular_velocity is not None
    with pytest.raises(CalibrationError, match="it is the gyroscope that never rests, or its unit is another"):
        still_positions(replace(recording, angular_velocity=np.degrees(recording.angular_velocity)))


@pytest.mark.parametrize("name", ["force", "rate", "window_s", "shortest_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_limits_are_positive(name: str, value: float) -> None:
    with pytest.raises(ConfigError, match=f"{name} is"):
        StillLimits(**{name: value})


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS)
def test_the_standard_error_of_a_rest_holds_for_smooth_noise(seed: int) -> None:
    """A sensor's filter makes neighbours alike: the mean is then worse known than independent samples tell."""
    rng = np.random.default_rng(seed)
    smooth = np.apply_along_axis(np.convolve, 0, rng.standard_normal((12_010, 3)), np.ones(11) / 11.0, "valid")
    still = ImuRecording(t=np.arange(12_000) / 100.0, specific_force=0.05 * smooth + [0.0, 0.0, G])
    (position,), _ = still_positions(still)
    assert position.error == pytest.approx(0.05 / np.sqrt(12_000), rel=0.35)


# Positions


def test_rests_in_one_direction_are_one_position() -> None:
    forces = np.array([[0.0, 0.0, G], [G, 0.0, 0.0], [0.05, 0.0, G]])
    positions, segments = still_positions(held(forces))
    assert [position.rests for position in positions] == [2, 1]
    assert len(segments) == 3
    assert positions[0].force[0] == pytest.approx(0.025, abs=0.005)
    assert positions[0].error < positions[1].error


def test_in_order_only_neighbours_are_joined() -> None:
    forces = np.array([[0.0, 0.0, G], [0.01, 0.0, G], [G, 0.0, 0.0], [0.0, 0.0, G]])
    positions, _ = still_positions(held(forces), in_order=True)
    assert [position.rests for position in positions] == [2, 1, 1]


# Coverage


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, count=st.integers(1, 25), degrees=st.floats(0.0, 85.0))
def test_coverage_is_the_narrowest_cone(seed: int, count: int, degrees: float) -> None:
    """It holds the cone the directions came from, and no axis has all of them nearer."""
    rng = np.random.default_rng(seed)
    directions = cone(rng, count, degrees) @ rotation(seed)
    covered = coverage_deg(directions)
    assert covered <= degrees + 1e-4
    axes = cone(rng, 2000, 180.0)
    assert np.degrees(np.arccos(np.clip((axes @ directions.T).min(axis=1), -1, 1))).min() >= covered - 1e-4


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, count=st.integers(2, 60), scale=st.floats(0.1, 100.0))
def test_coverage_grows_with_positions_and_turns_with_them(seed: int, count: int, scale: float) -> None:
    directions = cone(np.random.default_rng(seed), count, 80.0)
    covered = coverage_deg(directions)
    assert coverage_deg(scale * directions @ rotation(seed)) == pytest.approx(covered, abs=1e-4)
    assert coverage_deg(directions[:-1]) <= covered + 1e-4
    assert coverage_deg(np.vstack([directions, directions[:3]])) == pytest.approx(covered, abs=1e-4)


def test_coverage_of_known_shapes() -> None:
    faces = np.array(list(FACES.values()))
    assert coverage_deg(faces) == pytest.approx(np.degrees(np.arccos(-1.0 / np.sqrt(3.0))))
    assert coverage_deg(faces[:1]) == 0.0
    assert coverage_deg(faces[:2]) == pytest.approx(90.0)
    tilts = [tilted_force(*np.radians(pair)) for pair in [(20, 0), (-20, 0), (0, 20), (0, -20), (0, 0)]]
    assert coverage_deg(tilts) == pytest.approx(20.0)


def test_missing_faces_and_different_directions() -> None:
    faces = np.array(list(FACES.values()))
    assert missing_faces(faces) == ()
    assert missing_faces(faces[[0, 3]]) == ("-x", "+y", "+z", "-z")
    assert different(np.vstack([faces, faces])) == 6
    assert different([tilted_force(np.radians(angle), 0.0) for angle in (0.0, 1.0, 2.5, 5.0)]) == 3


def test_small_angles_are_exact() -> None:
    assert angle_between([1.0, 0.0, 0.0], [1.0, 1e-9, 0.0]) == pytest.approx(np.degrees(1e-9))
    assert angle_between([2.0, 0.0, 0.0], [-3.0, 0.0, 0.0]) == 180.0


# From a recording to a calibration


def test_the_method_is_the_one_that_the_positions_allow() -> None:
    faces = G * np.array(list(FACES.values()))
    assert calibrate_accelerometer(held(faces)).calibration.method == "six positions"
    assert calibrate_accelerometer(held(G * evenly(14), hold_s=2.0)).calibration.method == "ellipsoid"
    tilts = np.array([tilted_force(*np.radians(pair)) for pair in [(0, 0), (15, 0), (0, 15), (-15, 0)]])
    assert calibrate_accelerometer(held(tilts), tilts=tilts).calibration.method == "known tilts"


def test_faces_that_lean_are_free_positions_if_there_are_enough() -> None:
    forces = G * np.array(list(FACES.values()))
    turns = [rotation(0), np.eye(3)]
    many = np.vstack([0.96 * forces + 0.25 * forces @ turn for turn in turns])
    many = G * many / np.linalg.norm(many, axis=1, keepdims=True)
    assert calibrate_accelerometer(held(many, hold_s=2.0)).calibration.method == "ellipsoid"
    assert calibrate_accelerometer(held(forces + np.array([0.0, 2.0, 0.0]))).calibration.method == "six positions"


def test_what_is_written_is_what_was_determined() -> None:
    tilts = np.array([tilted_force(*np.radians(pair)) for pair in [(0, 0), (15, 0), (0, 15), (-15, 0)]])
    assert list(calibrate_accelerometer(held(tilts), tilts=tilts).block()) == ["bias", "rotation", "gyro_bias"]
    free = held(G * evenly(14), hold_s=2.0, gyro=False)
    assert list(calibrate_accelerometer(free).block()) == ["bias", "correction"]


def test_free_positions_at_known_tilts_give_the_mounting_too() -> None:
    r, forces = rotation(8), G * evenly(14)
    outcome = calibrate_accelerometer(held(forces @ r + [0.1, 0.2, -0.1], hold_s=2.0), "ellipsoid", tilts=forces)
    assert outcome.calibration.rotation is not None
    np.testing.assert_allclose(outcome.calibration.rotation, r, atol=2e-3)
    assert list(outcome.block()) == ["bias", "correction", "rotation", "gyro_bias"]


def test_one_position_is_refused_with_the_ways_there_are() -> None:
    """As a sensor on a table that is picked up and put back now and then."""
    forces = np.array([tilted_force(*np.radians(pair)) for pair in [(0, 0), (0.3, 0), (0.1, 0.1)]])
    with pytest.raises(CalibrationError) as caught:
        calibrate_accelerometer(held(forces))
    message = str(caught.value)
    assert "3 still segments" in message
    assert "within 0.3 degrees of each other: 1 position, coverage 0.0 degrees" in message
    assert "missing: +x, -x, +y, -y, -z" in message
    assert "at least 12 free ones that cover 60 degrees" in message


@pytest.mark.parametrize("method", ["six", "ellipsoid", "tilts"])
def test_a_method_that_does_not_fit_is_refused(method: str) -> None:
    recording = held(G * np.array([[0.0, 0.0, 1.0], [0.0, np.sin(0.2), np.cos(0.2)]]))
    with pytest.raises(CalibrationError, match="2 still segments"):
        calibrate_accelerometer(recording, method)


def test_tilts_are_one_for_each_position() -> None:
    tilts = np.array([tilted_force(*np.radians(pair)) for pair in [(0, 0), (15, 0), (0, 15), (-15, 0)]])
    with pytest.raises(CalibrationError, match=r"3 tilts for 4 positions; .* 0\.1 to 2\.9 s, 4\.1 to 6\.9 s"):
        calibrate_accelerometer(held(tilts), tilts=tilts[:3])
    with pytest.raises(CalibrationError, match="six positions need no tilts"):
        calibrate_accelerometer(held(tilts), "six", tilts=tilts)


@pytest.mark.parametrize(
    ("factor", "unit", "looks"),
    [
        (1 / G, "m/s^2", "it looks like g: set the unit"),
        (100.0, "m/s^2", "it looks like mg or cm/s^2: set the unit"),
        (G, "g", "it looks like m/s^2: set the unit"),
        (G, "m/s^2", "it looks like m/s^2 taken for g: does the header name the right unit?"),
        (1e5, "m/s^2", "m/s^2; no known unit makes that about 1 g"),
        (1e-9, "g", "g; no known unit makes that about 1 g"),
    ],
)
def test_a_wrong_unit_is_named(factor: float, unit: str, looks: str) -> None:
    recording = held(UPRIGHT)
    wrong = replace(recording, specific_force=factor * recording.specific_force, unit=unit)
    with pytest.raises(UnitsError, match=re.escape(looks)):
        calibrate_accelerometer(wrong)


@pytest.mark.parametrize("scale", [0.81, 1.24])
@pytest.mark.parametrize("bias", [-2.9, 2.9])
def test_a_bias_and_a_scale_that_sensors_have_are_no_other_unit(scale: float, bias: float) -> None:
    """Seen from one position, as a live sensor is."""
    force = np.array([[0.0, 0.0, G / scale + bias]])
    check_unit(held(force))


@settings(max_examples=60, deadline=None)
@given(
    seed=SEEDS,
    samples=st.integers(0, 1200),
    scale=st.sampled_from([0.0, 1e-300, 1e-3, 1.0, 1e9 / G]),
    noise=st.sampled_from([0.0, 1e-12, 0.02, 3.0]),
    moves=st.integers(0, 30),
    method=st.sampled_from(["auto", "six", "ellipsoid", "tilts"]),
    gyro=st.booleans(),
)
def test_any_recording_is_calibrated_or_refused(
    seed: int, samples: int, scale: float, noise: float, moves: int, method: str, gyro: bool
) -> None:
    """Pieces that are held, at random, of any size: finite numbers come out, or an error of ours."""
    rng = np.random.default_rng(seed)
    directions = G * cone(rng, moves + 1, 180.0)
    held_in = np.sort(rng.integers(0, moves + 1, samples))
    force = np.clip(scale * (directions[held_in] + noise * rng.standard_normal((samples, 3))), -1e9, 1e9)
    rate = rng.standard_normal((samples, 3)) * 10.0 ** rng.integers(-9, 9) if gyro else None
    recording = ImuRecording(t=np.cumsum(rng.uniform(1e-4, 0.02, samples)), specific_force=force, angular_velocity=rate)
    tilts = directions[rng.permutation(moves + 1)] if method == "tilts" else None
    with suppress(RavenGCError):
        found = calibrate_accelerometer(recording, method, tilts=tilts).calibration
        assert np.isfinite(found.covariance).all()
        assert np.isfinite(found.bias).all()
        assert found.verdict


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"t": [0.0, 0.0, 1.0]}, "stamps"),
        ({"t": [0.0, np.nan, 1.0]}, "stamps"),
        ({"specific_force": np.zeros((2, 3))}, r"shape \(2, 3\); expected \(3, 3\)"),
        ({"specific_force": np.full((3, 3), np.nan)}, "finite"),
        ({"angular_velocity": np.zeros(3)}, r"shape \(3,\)"),
        ({"specific_force": "abc"}, "specific_force"),
    ],
)
def test_recordings_hold_numbers(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        ImuRecording(**{"t": np.arange(3.0), "specific_force": np.ones((3, 3))} | changes)
