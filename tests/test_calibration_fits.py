"""Six positions give back bias and scale; and what every fit refuses: no sensor, and no data."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import (
    FACES,
    NOISE,
    G,
    a_bias,
    evenly,
    readings,
    spread_of,
    within,
)
from ravengc.calibration import (
    fit_ellipsoid,
    fit_six_positions,
    fit_tilts,
)
from ravengc.calibration.six import nearest_face
from ravengc.errors import ArgumentError, CalibrationError

SEEDS = st.integers(0, 2**32 - 1)
thorough = settings(max_examples=60, deadline=None)


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


def test_standard_errors_of_six_positions_are_right() -> None:
    k, bias = np.array([0.82, 1.0, 1.22]), np.array([0.5, -0.5, 0.1])
    noise = 0.01 * np.arange(1.0, 7.0)

    def trial(rng: np.random.Generator) -> np.ndarray:
        forces = readings(G * FACES, np.diag(k), bias) + noise[:, np.newaxis] * rng.standard_normal((6, 3))
        found = fit_six_positions(forces, noise)
        scale = (np.diag(found.correction) - k) / np.diag(found.correction_error)
        return np.concatenate([scale, (found.bias - bias) / found.bias_error])

    np.testing.assert_allclose(spread_of(trial, 600), 1.0, atol=0.12)


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
