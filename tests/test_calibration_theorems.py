"""From a recording to a calibration: what a made-up sensor was given comes back, as exactly as its own errors say.

Each recording holds a sensor with random faults still, in one position after the other, and shakes it in between. The
errors of all parameters together, eᵀ C⁻¹ e, follow χ² with as many degrees of freedom as there are parameters, if the
covariance C is right: as large on average, and never six standard deviations above.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import (
    FACES,
    UPPER,
    G,
    a_bias,
    correction,
    evenly,
    held,
    readings,
    rocked,
    rotation,
    turn_between,
    within,
)
from ravengc.calibration import calibrate_accelerometer, fit_lever_arm, tilted_force
from ravengc.errors import CalibrationError

SEEDS = st.integers(0, 2**32 - 1)
NOISES = st.floats(0.002, 0.04)
thorough = settings(max_examples=25, deadline=None)


def chi_square(found: Any, error: np.ndarray) -> float:
    """eᵀ C⁻¹ e."""
    return float(error @ np.linalg.solve(found.covariance, error))


def largest_chi_square(parameters: int) -> float:
    """Mean and six standard deviations of χ², and as much again for noise that is itself estimated."""
    return 1.5 * (parameters + 6.0 * np.sqrt(2.0 * parameters))


def ellipsoid_of(seed: int, noise: float, count: int, tilts: bool = False) -> tuple[Any, np.ndarray, np.ndarray]:
    """A calibration from free positions, the errors of its parameters, and the true mounting."""
    rng = np.random.default_rng(seed)
    s, bias, r, forces = correction(rng), a_bias(rng), rotation(seed), G * evenly(count) @ rotation(seed + 1)
    recording = held(readings(forces @ r, s, bias), noise=noise, hold_s=2.0, seed=seed)
    found = calibrate_accelerometer(recording, "ellipsoid", tilts=forces if tilts else None).calibration
    return found, np.concatenate([(found.correction - s)[UPPER], found.bias - bias]), r


def six_of(seed: int, noise: float) -> tuple[Any, np.ndarray]:
    """A calibration from faces in any order, some of them shown twice, and the errors of its parameters."""
    rng = np.random.default_rng(seed)
    k, bias = rng.uniform(0.9, 1.1, 3), a_bias(rng)
    order = rng.permutation(np.concatenate([np.arange(6), rng.integers(0, 6, rng.integers(0, 4))]))
    found = calibrate_accelerometer(held(readings(G * FACES[order], np.diag(k), bias), noise=noise, seed=seed))
    found = found.calibration
    assert found.method == "six positions"
    return found, np.concatenate([np.diag(found.correction) - k, found.bias - bias])


def tilts_of(seed: int, noise: float, count: int) -> tuple[Any, np.ndarray]:
    """A calibration from known tilts of up to 25 degrees, with S known, and the errors of its parameters."""
    rng = np.random.default_rng(seed)
    s, bias, r = correction(rng), a_bias(rng), rotation(seed)
    around = rng.uniform(0.0, 2.0 * np.pi) + np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    lean = np.radians(rng.uniform(12.0, 25.0, count))
    expected = np.array([tilted_force(a * np.cos(b), a * np.sin(b)) for a, b in zip(lean, around, strict=True)])
    recording = held(readings(expected @ r, s, bias), noise=noise, seed=seed)
    found = calibrate_accelerometer(recording, tilts=expected, correction=s).calibration
    assert found.method == "known tilts"
    return found, np.concatenate([turn_between(found.rotation, r), found.bias - bias])


@thorough
@given(seed=SEEDS, noise=NOISES, count=st.integers(12, 24))
def test_free_positions(seed: int, noise: float, count: int) -> None:
    found, error, _ = ellipsoid_of(seed, noise, count)
    assert chi_square(found, error) < largest_chi_square(9)
    assert found.good


@thorough
@given(seed=SEEDS, noise=NOISES)
def test_six_positions_in_any_order(seed: int, noise: float) -> None:
    found, error = six_of(seed, noise)
    assert chi_square(found, error) < largest_chi_square(6)
    assert found.good


@thorough
@given(seed=SEEDS, noise=NOISES, count=st.integers(4, 10))
def test_known_tilts(seed: int, noise: float, count: int) -> None:
    found, error = tilts_of(seed, noise, count)
    assert chi_square(found, error) < largest_chi_square(6)
    assert found.good


@thorough
@given(seed=SEEDS, noise=NOISES, count=st.integers(12, 20))
def test_free_positions_at_known_tilts(seed: int, noise: float, count: int) -> None:
    found, error, r = ellipsoid_of(seed, noise, count, tilts=True)
    assert chi_square(found, error) < largest_chi_square(9)
    assert within(turn_between(found.rotation, r), 0.0, found.rotation_error)
    assert found.good


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        (lambda seed: ellipsoid_of(seed, 0.02, 14)[:2], 9),
        (lambda seed: six_of(seed, 0.02), 6),
        (lambda seed: tilts_of(seed, 0.02, 6), 6),
    ],
)
def test_covariances_are_as_large_as_the_errors(method: Any, parameters: int) -> None:
    """Neither too small, which would promise too much, nor too large, which would refuse what is good."""
    found = [chi_square(*method(seed)) for seed in range(60)]
    assert 0.7 < np.mean(found) / parameters < 1.5


@thorough
@given(
    place=st.tuples(*[st.floats(-0.4, 0.4)] * 3),
    seed=SEEDS,
    degrees=st.floats(6.0, 20.0),
    hz=st.floats(0.5, 1.5),
    noise=st.floats(0.005, 0.05),
)
def test_the_place_of_a_sensor(
    place: tuple[float, float, float], seed: int, degrees: float, hz: float, noise: float
) -> None:
    """In any axes of the base; what the motion between two samples hides is a ten-thousandth of the arm."""
    r = rotation(seed)
    t, f, w = rocked(place, degrees=degrees, hz=hz, noise=noise, seed=seed % 2**31)
    found = fit_lever_arm(t, f @ r.T, w @ r.T)
    assert within(found.position, r @ np.array(place), found.position_error, 1e-4 * np.linalg.norm(place) + 1e-5)
    assert found.position_error.max() < 0.01


@thorough
@given(seed=SEEDS, degrees=st.floats(0.05, 0.2))
def test_too_little_rocking_is_refused_and_not_guessed(seed: int, degrees: float) -> None:
    with pytest.raises(CalibrationError, match=r"turns by .* RMS only|undetermined"):
        fit_lever_arm(*rocked(degrees=degrees, hz=1.0, seed=seed % 2**31))
