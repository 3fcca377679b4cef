"""An ellipsoid gives back bias, scale and misalignment to within its errors, or says what is missing."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import (
    NOISE,
    UPPER,
    G,
    a_bias,
    cone,
    correction,
    evenly,
    readings,
    rotation,
    spread_of,
    within,
)
from ravengc.calibration import (
    fit_ellipsoid,
)
from ravengc.calibration.ellipsoid import _model
from ravengc.errors import CalibrationError

SEEDS = st.integers(0, 2**32 - 1)
thorough = settings(max_examples=60, deadline=None)


def largest_direction_error(found: Any, s: np.ndarray, bias: np.ndarray, rng: np.random.Generator) -> float:
    """Degrees, over directions within 30 degrees of z: what tells how well a tilt is known."""
    true = G * cone(rng, 300, 30.0)
    seen = found.apply(readings(true, s, bias))
    return max(np.degrees(np.arccos(np.clip((seen * true).sum(axis=1) / np.linalg.norm(seen, axis=1) / G, -1, 1))))


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


@thorough
@given(seed=SEEDS, count=st.integers(12, 24), size=st.floats(0.02, 0.1))
def test_the_position_that_is_wrong_is_the_one_that_is_named(seed: int, count: int, size: float) -> None:
    """With few positions the fit follows a wrong one, and others have larger residuals."""
    rng = np.random.default_rng(seed)
    forces = readings(G * evenly(count) @ rotation(seed), correction(rng), a_bias(rng), rng)
    wrong = int(rng.integers(count))
    forces[wrong] *= 1.0 + size
    position, distance = fit_ellipsoid(forces, NOISE).suspect
    assert position == wrong
    assert distance == pytest.approx(size * G, rel=0.2, abs=10.0 * NOISE)


def test_directions_that_the_positions_leave_badly_known_are_told() -> None:
    """The sensor was turned about y alone, and a little to its sides."""
    rng = np.random.default_rng(1)
    azimuth, lean = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False), np.radians(rng.uniform(-5.0, 5.0, 24))
    band = np.column_stack([np.cos(lean) * np.cos(azimuth), np.sin(lean), np.cos(lean) * np.sin(azimuth)])
    s, bias = correction(rng), a_bias(rng)
    found = fit_ellipsoid(readings(G * band, s, bias, rng), NOISE)
    (note,) = found.notes
    told = re.fullmatch(r"far from .* known worse: to (\S+) deg with \((\S+), (\S+), (\S+)\) up", note)
    assert told
    degrees, up = float(told[1]), G * np.array([float(told[axis]) for axis in (2, 3, 4)])
    assert degrees > 3.0 * np.degrees(found.direction_error)
    errors = []
    for seed in range(40):
        noisy = fit_ellipsoid(readings(G * band, s, bias, np.random.default_rng(seed)), NOISE)
        seen = noisy.apply(readings(up[np.newaxis], s, bias))[0]
        errors.append(np.degrees(np.linalg.norm(np.cross(seen, up)) / np.linalg.norm(seen) / np.linalg.norm(up)))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(degrees, rel=0.4)
    assert fit_ellipsoid(readings(G * evenly(24), s, bias, rng), NOISE).notes == ()


def test_standard_errors_of_an_ellipsoid_are_right() -> None:
    s, bias, directions = correction(np.random.default_rng(9)), np.array([0.5, -0.5, 0.1]), evenly(30)
    noise = np.linspace(0.001, 0.006, 30)

    def trial(rng: np.random.Generator) -> np.ndarray:
        forces = readings(G * directions, s, bias) + noise[:, np.newaxis] * rng.standard_normal((30, 3))
        found = fit_ellipsoid(forces, noise)
        scale = (found.correction - s)[UPPER] / found.correction_error[UPPER]
        return np.concatenate([scale, (found.bias - bias) / found.bias_error])

    np.testing.assert_allclose(spread_of(trial, 250), 0.95, atol=0.17)


def test_the_jacobian_of_the_ellipsoid_is_its_derivative() -> None:
    rng = np.random.default_rng(0)
    s, x, h = evenly(12), np.array([1.05, 0.02, -0.03, 0.97, 0.01, 1.02, 0.03, -0.02, 0.01]), 1e-6
    sigma = rng.uniform(0.5, 2.0, 12)
    steps = h * np.eye(9)
    slopes = [(_model(x + step, s, sigma)[0] - _model(x - step, s, sigma)[0]) / (2 * h) for step in steps]
    np.testing.assert_allclose(_model(x, s, sigma)[1], np.transpose(slopes), atol=1e-9)
