"""Calibrations recover what a sensor was given, to within their own standard errors, or say what is missing."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import NOISE, UPPER, G, cone, correction, evenly, readings, rotation
from ravengc.calibration import (
    CalibrationError,
    fit_ellipsoid,
    fit_six_positions,
    fit_tilts,
    mounting_rotation,
    tilted_force,
)
from ravengc.calibration.ellipsoid import _model
from ravengc.calibration.kabsch import MIRRORS, rotation_angle_deg
from ravengc.calibration.six import nearest_face
from ravengc.errors import ArgumentError

SEEDS = st.integers(0, 2**32 - 1)
SIGMAS = 6.0
FACES = np.vstack([np.eye(3), -np.eye(3)])
thorough = settings(max_examples=60, deadline=None)


def within(found: Any, truth: Any, error: Any, slack: float = 1e-9) -> bool:
    return bool((np.abs(np.asarray(found) - truth) <= SIGMAS * np.asarray(error) + slack).all())


def a_bias(rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(-0.5, 0.5, 3)


def largest_direction_error(found: Any, s: np.ndarray, bias: np.ndarray, rng: np.random.Generator) -> float:
    """Degrees, over directions within 30 degrees of z: what tells how well a tilt is known."""
    true = G * cone(rng, 300, 30.0)
    seen = found.apply(readings(true, s, bias))
    return max(np.degrees(np.arccos(np.clip((seen * true).sum(axis=1) / np.linalg.norm(seen, axis=1) / G, -1, 1))))


# Ellipsoid


@thorough
@given(seed=SEEDS, count=st.integers(14, 60), noise=st.floats(1e-5, 0.01))
def test_an_ellipsoid_gives_back_bias_scale_and_misalignment(seed: int, count: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    s, bias = correction(rng), a_bias(rng)
    found = fit_ellipsoid(readings(G * evenly(count) @ rotation(seed), s, bias, rng, noise), noise)
    assert within(found.bias, bias, found.bias_error)
    assert within(found.correction[UPPER], s[UPPER], found.correction_error[UPPER])
    assert (np.tril(found.correction, -1) == 0.0).all()
    assert np.degrees(found.direction_error) < 0.5


def test_without_noise_an_ellipsoid_is_exact() -> None:
    rng = np.random.default_rng(5)
    s, bias = correction(rng), a_bias(rng)
    found = fit_ellipsoid(readings(G * evenly(12), s, bias), 1e-6)
    np.testing.assert_allclose(found.correction, s, atol=1e-10)
    np.testing.assert_allclose(found.bias, bias, atol=1e-9)
    assert found.residual < 1e-10
    assert found.good


@thorough
@given(seed=SEEDS, gravity=st.floats(9.76, 9.84))
def test_the_local_gravity_scales_the_correction_alone(seed: int, gravity: float) -> None:
    rng = np.random.default_rng(seed)
    forces = readings(G * evenly(24), correction(rng), a_bias(rng), rng)
    standard, local = fit_ellipsoid(forces, NOISE), fit_ellipsoid(forces, NOISE, gravity)
    np.testing.assert_allclose(local.correction, standard.correction * gravity / G, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(local.bias, standard.bias, atol=1e-7)


@pytest.mark.parametrize(("count", "degrees"), [(12, 0.066), (24, 0.027), (50, 0.015)])
def test_errors_of_the_ellipsoid_are_those_known(count: int, degrees: float) -> None:
    """Median over random sensors of the largest direction error within 30 degrees, noise 0.0028 m/s²."""
    rng, errors = np.random.default_rng(count), []
    while len(errors) < 60:
        s, bias = correction(rng), a_bias(rng)
        try:
            found = fit_ellipsoid(readings(G * cone(rng, count, 180.0), s, bias, rng), NOISE)
        except CalibrationError:  # two of the random positions were one
            continue
        errors.append(largest_direction_error(found, s, bias, rng))
    assert degrees / 1.4 < np.median(errors) < 1.4 * degrees


@pytest.mark.parametrize("degrees", [20.0, 30.0, 45.0, 59.0])
def test_less_than_sixty_degrees_are_refused_with_what_is_missing(degrees: float) -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(CalibrationError, match=r"cover \d+\.\d degrees; .* at least 60.* near .*-z up") as caught:
        fit_ellipsoid(G * cone(rng, 50, degrees) + [0.3, -0.2, 0.1], NOISE)
    covered = re.search(r"cover (\S+) degrees", str(caught.value))
    assert covered
    assert float(covered[1]) == pytest.approx(degrees, abs=4.0)


def test_sixty_degrees_are_enough() -> None:
    rng = np.random.default_rng(2)
    s, bias = correction(rng), a_bias(rng)
    found = fit_ellipsoid(readings(G * cone(rng, 50, 66.0), s, bias, rng), NOISE)
    assert largest_direction_error(found, s, bias, rng) < 0.2


@thorough
@given(seed=SEEDS, lean=st.floats(0.0, 80.0))
def test_positions_on_a_circle_are_refused(seed: int, lean: float) -> None:
    """All on one cone, or in one plane: the readings lie on a plane, through which go many ellipsoids."""
    azimuth, tilt = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False), np.radians(lean)
    circle = np.column_stack(
        [np.cos(tilt) * np.cos(azimuth), np.cos(tilt) * np.sin(azimuth), np.full(24, np.sin(tilt))]
    )
    rng = np.random.default_rng(seed)
    with pytest.raises(CalibrationError, match=r"do not determine bias and scale|cover|different positions"):
        fit_ellipsoid(readings(G * circle @ rotation(seed), correction(rng), a_bias(rng), rng), NOISE)


@pytest.mark.parametrize("degrees", [0.5, 2.0])
def test_positions_near_a_plane_are_refused(degrees: float) -> None:
    rng = np.random.default_rng(4)
    azimuth, lean = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False), np.radians(rng.uniform(-degrees, degrees, 48))
    band = np.column_stack([np.cos(lean) * np.cos(azimuth), np.sin(lean), np.cos(lean) * np.sin(azimuth)])
    with pytest.raises(CalibrationError, match=r"do not determine bias and scale .* near \+y, -y up"):
        fit_ellipsoid(readings(G * band, np.eye(3), np.zeros(3), rng, 1e-5), 1e-5)


def test_a_plane_is_refused_naming_the_axis_across_it() -> None:
    azimuth = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    circle = np.column_stack([np.cos(azimuth), 0.0 * azimuth, np.sin(azimuth)])
    with pytest.raises(CalibrationError, match=r"add positions near \+y, -y up"):
        fit_ellipsoid(G * circle, NOISE)


def test_eleven_positions_are_refused_and_repeats_do_not_count() -> None:
    eleven = G * evenly(11)
    for forces in (eleven, np.vstack([eleven, eleven + 0.01])):
        with pytest.raises(CalibrationError, match=r"11 different positions; .* at least 12: 1 more"):
            fit_ellipsoid(forces, NOISE)


def test_a_position_that_moved_raises_residual_and_errors() -> None:
    rng = np.random.default_rng(3)
    forces = readings(G * evenly(24), np.eye(3), np.zeros(3), rng)
    forces[7] *= 1.1
    found = fit_ellipsoid(forces, NOISE)
    assert not found.good
    assert "position 8 is off" in found.verdict
    assert found.noise_ratio is not None
    assert found.noise_ratio > 20.0
    assert (found.bias_error > 10.0 * fit_ellipsoid(G * evenly(24), NOISE).bias_error).all()


# Six positions


@thorough
@given(seed=SEEDS, noise=st.floats(1e-5, 0.02))
def test_six_positions_give_back_bias_and_scale(seed: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    k, bias = rng.uniform(0.9, 1.1, 3), a_bias(rng)
    found = fit_six_positions(readings(G * FACES[rng.permutation(6)], np.diag(k), bias, rng, noise), noise)
    assert within(found.bias, bias, found.bias_error)
    assert within(np.diag(found.correction), k, np.diag(found.correction_error))


def test_six_positions_are_the_formula() -> None:
    up, down = np.array([10.1, 9.7, 9.9]), np.array([-9.3, -9.9, -9.6])
    found = fit_six_positions(np.vstack([np.diag(up), np.diag(down)]), NOISE)
    np.testing.assert_allclose(found.bias, (up + down) / 2.0)
    np.testing.assert_allclose(found.correction, np.diag(2.0 * G / (up - down)))


@thorough
@given(seed=SEEDS)
def test_six_positions_and_ellipsoid_agree(seed: int) -> None:
    """Two routes to the same sensor, which has no misalignment."""
    rng = np.random.default_rng(seed)
    k, bias = rng.uniform(0.95, 1.05, 3), a_bias(rng)
    six = fit_six_positions(readings(G * FACES, np.diag(k), bias, rng), NOISE)
    free = fit_ellipsoid(readings(G * evenly(40), np.diag(k), bias, rng), NOISE)
    assert within(six.bias, free.bias, np.hypot(six.bias_error, free.bias_error))
    assert within(six.correction, free.correction, np.hypot(six.correction_error, free.correction_error))


def test_leaning_faces_make_the_scale_too_large_by_what_is_said() -> None:
    turn = np.radians(4.0)
    lean = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(turn), -np.sin(turn)], [0.0, np.sin(turn), np.cos(turn)]])
    found = fit_six_positions(G * FACES @ lean.T, NOISE)
    np.testing.assert_allclose(np.diag(found.correction), [1.0, 1.0 / np.cos(turn), 1.0 / np.cos(turn)])
    assert found.notes == ("faces lean by up to 4.0 deg: scale up to 0.24 % too large",)


@pytest.mark.parametrize(
    ("gone", "named"), [((0,), r"\+x"), ((3, 5), "-x, -z"), ((0, 1, 2, 3, 4), r"\+x, -x, \+y, -y, \+z")]
)
def test_missing_faces_are_named(gone: tuple[int, ...], named: str) -> None:
    with pytest.raises(CalibrationError, match=rf"missing: {named} up"):
        fit_six_positions(G * np.delete(FACES, gone, axis=0), NOISE)


def test_a_face_that_leans_too_far_is_refused() -> None:
    forces = G * FACES
    forces[1] = G * np.array([0.0, np.cos(0.3), np.sin(0.3)])
    with pytest.raises(CalibrationError, match=r"position 2 \(\+y up\) leans by 1\d\.\d degrees"):
        fit_six_positions(forces, NOISE)


def test_the_nearest_face_is_the_axis_that_points_up() -> None:
    assert [nearest_face(force) for force in FACES] == ["+x", "+y", "+z", "-x", "-y", "-z"]


# Known tilts


def tilts(degrees: float, count: int, rng: np.random.Generator) -> np.ndarray:
    return G * cone(rng, count, degrees)


@thorough
@given(seed=SEEDS, count=st.integers(4, 30), noise=st.floats(1e-5, 0.01))
def test_known_tilts_give_back_bias_and_mounting(seed: int, count: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    r, bias, s = rotation(seed), a_bias(rng), correction(rng)
    expected = np.array([tilted_force(roll, pitch) for roll, pitch in np.radians(rng.uniform(-20, 20, (count, 2)))])
    expected[:3] = [tilted_force(0.0, 0.0), tilted_force(0.35, 0.0), tilted_force(0.0, 0.35)]
    found = fit_tilts(readings(expected @ r, s, bias, rng, noise), expected, noise / np.sqrt(2), correction=s)
    turn = found.rotation @ r.T
    angles = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2.0
    assert within(found.bias, bias, 1.1 * np.sqrt(2) * found.bias_error)
    assert within(angles, 0.0, 1.1 * np.sqrt(2) * found.rotation_error)
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(found.rotation @ found.rotation.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(("count", "degrees", "bias_error"), [(6, 0.09, 0.013), (24, 0.03, 0.005)])
def test_errors_of_known_tilts_are_those_known(count: int, degrees: float, bias_error: float) -> None:
    rng, turned, off = np.random.default_rng(count), [], []
    for seed in range(80):
        r, bias, expected = rotation(seed), a_bias(rng), tilts(20.0, count, rng)
        found = fit_tilts(readings(expected @ r, np.eye(3), bias, rng), expected, NOISE)
        turned.append(rotation_angle_deg(found.rotation @ r.T))
        off.append(np.linalg.norm(found.bias - bias))
    assert degrees / 1.6 < np.median(turned) < 1.6 * degrees
    assert bias_error / 1.6 < np.median(off) < 1.6 * bias_error


@pytest.mark.parametrize("fault", MIRRORS)
@pytest.mark.parametrize("mounting", [None, 4, 5])
def test_a_mirrored_sensor_is_refused_and_its_fault_named(fault: str, mounting: int | None) -> None:
    rng = np.random.default_rng(11)
    r = np.eye(3) if mounting is None else rotation(mounting)
    expected = tilts(20.0, 8, rng)
    forces = readings(expected @ r, np.eye(3), np.array([0.2, -0.1, 0.1]), rng) @ MIRRORS[fault]
    with pytest.raises(CalibrationError, match="mirror image") as caught:
        fit_tilts(forces, expected, NOISE, declared=None if mounting is None else r)
    assert f"read with {fault}:" in str(caught.value)
    assert re.search(r"mounting [01]\.\d degrees from", str(caught.value))


@thorough
@given(seed=SEEDS)
def test_a_rotation_is_never_taken_for_a_mirror(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for degrees, count in ((5.0, 8), (20.0, 4), (180.0, 12)):
        expected = tilts(degrees, count, rng)
        r = rotation(seed)
        found = mounting_rotation(readings(expected @ r, np.eye(3), np.zeros(3), rng), expected, NOISE)
        assert np.linalg.det(found.rotation) > 0.0
        assert rotation_angle_deg(found.rotation @ r.T) <= 6.0 * np.degrees(np.linalg.norm(found.rotation_error))


@thorough
@given(seed=SEEDS, reach=st.floats(15.0, 60.0), count=st.integers(5, 12))
def test_tilts_about_one_axis_are_never_taken_for_a_mirror(seed: int, reach: float, count: int) -> None:
    """All vectors lie in one plane: a mirror across it fits as well, and noise decides which fits a little better."""
    rng = np.random.default_rng(seed)
    expected = np.array([tilted_force(angle, 0.0) for angle in np.radians(np.linspace(-reach, reach, count))])
    forces = readings(expected @ rotation(seed), np.eye(3), np.zeros(3), rng)
    for found in (fit_tilts(forces, expected, NOISE), mounting_rotation(forces, expected, NOISE)):
        assert np.linalg.det(found.rotation) == pytest.approx(1.0)
        turned = rotation_angle_deg(found.rotation @ rotation(seed).T)
        assert turned <= 6.0 * np.degrees(np.linalg.norm(found.rotation_error))


@pytest.mark.parametrize(
    ("angles", "message"),
    [
        ([(0, 0), (10, 0)], "2 positions; .* at least 3"),
        ([(0, 0), (0, 0), (0, 0), (0, 0)], "do not tell bias from rotation"),
        ([(-1, 0), (0, 0), (1, 0), (0.5, 0)], r"do not tell bias from rotation .* reach 1.0 degrees .* second axis"),
    ],
)
def test_tilts_that_tell_too_little_are_refused(angles: list[tuple[float, float]], message: str) -> None:
    expected = np.array([tilted_force(*np.radians(pair)) for pair in angles])
    with pytest.raises(CalibrationError, match=message):
        fit_tilts(expected, expected, NOISE)


def test_tilts_about_one_axis_are_enough_if_they_are_large() -> None:
    rng = np.random.default_rng(0)
    expected = np.array([tilted_force(angle, 0.0) for angle in np.radians([-20.0, -10.0, 0.0, 10.0, 20.0])])
    found = fit_tilts(readings(expected @ rotation(3), np.eye(3), np.full(3, 0.1), rng), expected, NOISE)
    assert rotation_angle_deg(found.rotation @ rotation(3).T) < 1.5


def test_a_tilt_is_the_base_turned_about_x_then_about_the_level_y() -> None:
    np.testing.assert_allclose(tilted_force(0.0, 0.0), [0.0, 0.0, G])
    np.testing.assert_allclose(tilted_force(0.1, 0.0), [0.0, G * np.sin(0.1), G * np.cos(0.1)])
    np.testing.assert_allclose(tilted_force(0.0, 0.1), [-G * np.sin(0.1), 0.0, G * np.cos(0.1)])
    assert np.linalg.norm(tilted_force(0.7, -0.4)) == pytest.approx(G)


@thorough
@given(seed=SEEDS)
def test_tilts_that_hardly_leave_a_plane_are_never_taken_for_a_mirror(seed: int) -> None:
    """Half a standard error out of it: which side it was on is anybody's guess."""
    rng = np.random.default_rng(seed)
    aside = 0.5 * NOISE / G * rng.standard_normal(9)
    expected = np.array(
        [tilted_force(roll, pitch) for roll, pitch in zip(np.linspace(-0.5, 0.5, 9), aside, strict=True)]
    )
    forces = readings(expected @ rotation(seed), np.eye(3), np.zeros(3), rng)
    assert np.linalg.det(fit_tilts(forces, expected, NOISE).rotation) == pytest.approx(1.0)


# Standard errors


def spread_of(trial: Any, count: int) -> np.ndarray:
    """Standard deviation, over random noise, of errors in units of their standard errors: 1 if these are right."""
    return np.std([trial(np.random.default_rng(seed)) for seed in range(count)], axis=0)


def test_standard_errors_of_six_positions_are_right() -> None:
    k, bias = np.array([0.82, 1.0, 1.22]), np.array([0.5, -0.5, 0.1])
    noise = 0.01 * np.arange(1.0, 7.0)

    def trial(rng: np.random.Generator) -> np.ndarray:
        forces = readings(G * FACES, np.diag(k), bias) + noise[:, np.newaxis] * rng.standard_normal((6, 3))
        found = fit_six_positions(forces, noise)
        scale = (np.diag(found.correction) - k) / np.diag(found.correction_error)
        return np.concatenate([scale, (found.bias - bias) / found.bias_error])

    np.testing.assert_allclose(spread_of(trial, 600), 1.0, atol=0.12)


def test_standard_errors_of_an_ellipsoid_are_right() -> None:
    s, bias, directions = correction(np.random.default_rng(9)), np.array([0.5, -0.5, 0.1]), evenly(30)
    noise = np.linspace(0.001, 0.006, 30)

    def trial(rng: np.random.Generator) -> np.ndarray:
        forces = readings(G * directions, s, bias) + noise[:, np.newaxis] * rng.standard_normal((30, 3))
        found = fit_ellipsoid(forces, noise)
        scale = (found.correction - s)[UPPER] / found.correction_error[UPPER]
        return np.concatenate([scale, (found.bias - bias) / found.bias_error])

    np.testing.assert_allclose(spread_of(trial, 250), 0.95, atol=0.17)


def test_standard_errors_of_known_tilts_are_right() -> None:
    """The bias is known best along the vertical, which here is the sensor's y."""
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    expected, s = tilts(20.0, 10, np.random.default_rng(2)), np.diag([1.2, 0.85, 1.0])
    best = fit_tilts(readings(expected @ upright, s, np.zeros(3)), expected, NOISE, correction=s).bias_error
    assert best[1] < 0.3 * best[[0, 2]].min()

    def trial(rng: np.random.Generator) -> np.ndarray:
        forces = expected @ upright + NOISE * rng.standard_normal((10, 3))
        found = fit_tilts(forces @ np.linalg.inv(s).T, expected, NOISE, correction=s)
        turn = found.rotation @ upright.T
        angles = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2.0
        return np.concatenate([angles / found.rotation_error, found.bias / found.bias_error])

    np.testing.assert_allclose(spread_of(trial, 400), 0.97, atol=0.14)


def test_the_jacobian_of_the_ellipsoid_is_its_derivative() -> None:
    rng = np.random.default_rng(0)
    s, x, h = evenly(12), np.array([1.05, 0.02, -0.03, 0.97, 0.01, 1.02, 0.03, -0.02, 0.01]), 1e-6
    sigma = rng.uniform(0.5, 2.0, 12)
    steps = h * np.eye(9)
    slopes = [(_model(x + step, s, sigma)[0] - _model(x - step, s, sigma)[0]) / (2 * h) for step in steps]
    np.testing.assert_allclose(_model(x, s, sigma)[1], np.transpose(slopes), atol=1e-9)


# What no sensor has, and what is no data


@pytest.mark.parametrize("fit", [fit_ellipsoid, fit_six_positions])
def test_impossible_sensors_are_refused(fit: Any) -> None:
    forces = G * (FACES if fit is fit_six_positions else evenly(24))
    with pytest.raises(CalibrationError, match=r"bias along y would be 3\.9"):
        fit(forces + np.array([0.0, 3.9, 0.0]), NOISE)
    with pytest.raises(CalibrationError, match=r"scale would be 0\.5 to 0\.5.*unit"):
        fit(2.0 * forces, NOISE)


@pytest.mark.parametrize("fit", [fit_ellipsoid, fit_six_positions, lambda f, e: fit_tilts(f, np.ones((3, 3)), e)])
@pytest.mark.parametrize(
    ("forces", "message"),
    [
        (np.full((3, 3), np.nan), r"forces\[0\] is \[nan"),
        (np.full((3, 3), np.inf), r"forces\[0\] is \[inf"),
        (np.full((3, 3), 1e200), r"forces\[0\] is \[1e\+200"),
        (np.ones((3, 2)), r"shape \(3, 2\)"),
        (np.ones(3), r"shape \(3,\)"),
        ([["a", "b", "c"]], "forces"),
        (None, "forces"),
    ],
)
def test_what_is_no_data_is_refused(fit: Any, forces: Any, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        fit(forces, NOISE)


@pytest.mark.parametrize("errors", [0.0, -1.0, np.nan, [NOISE], np.inf])
def test_errors_are_positive_and_one_for_each(errors: Any) -> None:
    with pytest.raises(ArgumentError, match="errors must be one or 24 positive numbers"):
        fit_ellipsoid(G * evenly(24), errors)


def test_free_fall_has_no_direction() -> None:
    with pytest.raises(CalibrationError, match="no direction"):
        fit_ellipsoid(np.zeros((12, 3)), NOISE)
