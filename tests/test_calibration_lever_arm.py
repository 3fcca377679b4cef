"""The place of a sensor on a rocking base comes out, or the component that the motion leaves open is named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import G, rocked, rotation
from ravengc.calibration import fit_lever_arm
from ravengc.errors import ArgumentError, CalibrationError, UnitsError

LENGTH = st.floats(-0.5, 0.5)


@settings(max_examples=20, deadline=None)
@given(place=st.tuples(LENGTH, LENGTH, LENGTH))
def test_the_place_of_the_sensor_comes_out(place: tuple[float, float, float]) -> None:
    found = fit_lever_arm(*rocked(place))
    assert (np.abs(found.position - place) <= 6.0 * found.position_error + 1e-5).all()
    assert found.position_error.max() < 0.002
    assert found.gravity == pytest.approx(G, rel=1e-3)
    assert found.good


@pytest.mark.parametrize("options", [{"hz": 0.25, "seconds": 60.0}, {"hz": 2.0, "degrees": 5.0}, {"gyro_noise": 0.01}])
def test_slow_small_and_noisy_rocking(options: dict[str, Any]) -> None:
    found = fit_lever_arm(*rocked(**options))
    assert (np.abs(found.position - [0.1, -0.2, 0.3]) <= 5.0 * found.position_error).all()
    assert found.position_error.max() < 0.005


def test_standard_errors_are_right() -> None:
    """Of a short recording, in which the start's attitude, the gyro's bias and the place are told apart badly."""
    found = [fit_lever_arm(*rocked(seconds=1.5, gyro_noise=2e-4, seed=seed)) for seed in range(120)]
    units = [(one.position - [0.1, -0.2, 0.3]) / one.position_error for one in found]
    np.testing.assert_allclose(np.std(units, axis=0), 1.0, atol=0.3)


@pytest.mark.parametrize("seconds", [5.0, 20.0, 100.0])
def test_noise_of_the_gyroscope_does_not_shorten_the_arm(seconds: float) -> None:
    options = {"seconds": seconds, "hz": 0.5, "gyro_noise": 0.02, "noise": 0.0}
    places = np.array([fit_lever_arm(*rocked(**options, seed=seed)).position for seed in range(12)])
    np.testing.assert_allclose(places.mean(axis=0), [0.1, -0.2, 0.3], atol=4.0 * places.std(axis=0).max() / np.sqrt(12))


@pytest.mark.parametrize(("degrees", "hz"), [(10.0, 1.0), (20.0, 1.5)])
@pytest.mark.parametrize("bias", [(0.0, 0.0, 0.0), (0.01, -0.02, 0.015)])
def test_without_noise_place_and_bias_are_exact(degrees: float, hz: float, bias: tuple[float, ...]) -> None:
    """What is left is the motion between samples. The bias about the vertical is seen in the turning terms alone."""
    found = fit_lever_arm(*rocked(degrees=degrees, hz=hz, noise=0.0, gyro_noise=0.0, gyro_bias=bias))
    np.testing.assert_allclose(found.position, [0.1, -0.2, 0.3], atol=3e-5)
    np.testing.assert_allclose(found.gyro_bias, bias, atol=1e-5)
    assert found.residual < 0.001


def test_the_place_turns_with_the_axes_and_moves_with_the_pivot() -> None:
    t, f, w = rocked()
    straight, r = fit_lever_arm(t, f, w), rotation(2)
    turned = fit_lever_arm(t, f @ r.T, w @ r.T)
    np.testing.assert_allclose(turned.position, r @ straight.position, atol=1e-6)
    moved = fit_lever_arm(t, f, w, pivot=(1.0, 2.0, 3.0))
    np.testing.assert_allclose(moved.position, straight.position + np.array([1.0, 2.0, 3.0]), atol=1e-12)


def test_rocking_about_one_axis_leaves_the_place_along_it_open() -> None:
    t, f, w = rocked(axes=1)
    with pytest.raises(CalibrationError, match=r"place of the sensor along x undetermined .* second axis"):
        fit_lever_arm(t, f, w)
    quarter = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    with pytest.raises(CalibrationError, match="along y undetermined"):
        fit_lever_arm(t, f @ quarter.T, w @ quarter.T)
    slant = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(CalibrationError, match=r"along \(-?0\.80, -?0\.60, -?0\.00\) undetermined"):
        fit_lever_arm(t, f @ slant.T, w @ slant.T)


@pytest.mark.parametrize("noise", [0.0, 1e-4, 0.002, 0.01, 0.05])
@pytest.mark.parametrize("seconds", [10.0, 200.0])
def test_one_axis_is_refused_however_noisy_and_long(noise: float, seconds: float) -> None:
    """The noise of the gyroscope looks like a little turning about every axis, and says the sensor is at 0 along x."""
    with pytest.raises(CalibrationError, match="along x undetermined"):
        fit_lever_arm(*rocked(axes=1, gyro_noise=noise, seconds=seconds))


def test_one_axis_is_refused_without_noise_too() -> None:
    with pytest.raises(CalibrationError, match="along x undetermined"):
        fit_lever_arm(*rocked(axes=1, noise=0.0, gyro_noise=0.0, gyro_bias=(0.0, 0.0, 0.0)))


def test_a_base_that_hardly_turns_is_refused() -> None:
    with pytest.raises(CalibrationError, match=r"turns by 0\.01\d rad/s RMS only"):
        fit_lever_arm(*rocked(degrees=0.1))


def test_a_pivot_that_moves_and_a_sensor_without_calibration_are_told() -> None:
    t, f, w = rocked()
    swaying = fit_lever_arm(t, f + np.sin(6.0 * t)[:, np.newaxis] * [1.0, 0.0, 0.0], w)
    assert not swaying.good
    assert "did the pivot stay at rest?" in swaying.verdict
    raw = fit_lever_arm(t, 1.05 * f, w)
    assert not raw.good
    assert "calibrate bias and scale first" in raw.verdict


@pytest.mark.parametrize(
    ("factor", "unit"),
    [(180.0 / np.pi, "deg/s"), (1000.0, "mrad/s"), (np.pi / 180.0, "rad/s taken for deg/s")],
)
@pytest.mark.parametrize("hz", [0.25, 1.0])
def test_an_angular_velocity_in_another_unit_is_named(factor: float, unit: str, hz: float) -> None:
    t, f, w = rocked(hz=hz)
    with pytest.raises(UnitsError, match=f"the angular velocity looks like {unit}, in which it explains the readings"):
        fit_lever_arm(t, f, factor * w)


@pytest.mark.parametrize("wrong", [np.diag([1.0, -1.0, 1.0]), -np.eye(3), np.eye(3)[[1, 0, 2]]])
def test_gyroscope_and_accelerometer_with_other_axes_are_told(wrong: np.ndarray) -> None:
    """More rocking would not help."""
    t, f, w = rocked()
    try:
        said = fit_lever_arm(t, f, w @ wrong).verdict
    except CalibrationError as error:
        said = str(error)
    assert "Are axes, signs and time of gyroscope and accelerometer alike?" in said
    assert "second axis" not in said


def test_a_pause_is_told_and_samples_lost_here_and_there_are_not() -> None:
    t, f, w = rocked()
    kept = np.delete(np.arange(t.size), np.arange(800, 950))
    with pytest.raises(CalibrationError, match=r"no samples for 1\.5 s after 8\.0 s: .* record without a pause"):
        fit_lever_arm(t[kept], f[kept], w[kept])
    some = np.random.default_rng(0).random(t.size) > 0.1
    found = fit_lever_arm(t[some], f[some], w[some])
    assert found.good
    np.testing.assert_allclose(found.position, [0.1, -0.2, 0.3], atol=0.003)


def test_a_sensor_that_gives_gravity_is_suspected() -> None:
    """All signs are the other way, so the motion cannot tell; that up is down can."""
    t, f, w = rocked()
    found = fit_lever_arm(t, -f, w)
    assert "up is -z: unless the base hangs, the sensor gives gravity and all signs are wrong" in found.verdict
    np.testing.assert_allclose(found.position, [-0.1, 0.2, -0.3], atol=0.001)
    assert "up is -z" not in fit_lever_arm(t, f, w).verdict


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (lambda t, f, w: (t[::-1], f, w), ArgumentError, "stamps"),
        (lambda t, f, w: (t, f[:-1], w), ArgumentError, "specific_force has shape"),
        (lambda t, f, w: (t, f, w[:, :2]), ArgumentError, "angular_velocity has shape"),
        (lambda t, f, w: (t, f * np.nan, w), ArgumentError, "finite"),
        (lambda t, f, w: (t[:20], f[:20], w[:20]), CalibrationError, "too short"),
        (lambda t, f, w: (t[:0], f[:0], w[:0]), CalibrationError, "too short"),
        (lambda t, f, w: (t[::1000], f[::1000], w[::1000]), CalibrationError, "too short"),
        (lambda _, f, w: ("abc", f, w), ArgumentError, "t has dtype"),
    ],
)
def test_what_is_no_motion_is_refused(change: Any, kind: type[Exception], message: str) -> None:
    with pytest.raises(kind, match=message):
        fit_lever_arm(*change(*rocked()))
