"""What a sensor's steps leave in the mean of a rest: as much as they do, by its readings alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import FACES, G, a_bias, held, readings
from ravengc.calibration import StillLimits, calibrate_accelerometer
from ravengc.calibration.rounding import rounding_error, step_of

COARSE = 0.0981
"""m/s²: two digits of a number in g, as many sketches print it."""


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), step=st.floats(1e-3, 1.0), noise=st.sampled_from([0.0, 0.05, 0.1, 0.2, 0.3]))
def test_the_error_of_rounded_means_is_the_one_that_is_told(seed: int, step: float, noise: float) -> None:
    """Over many true values; ``noise`` is in steps."""
    rng = np.random.default_rng(seed)
    true = rng.uniform(-10.0, 10.0, (300, 3))
    rests = [step * np.round(force / step + noise * rng.standard_normal((2000, 3))) for force in true]
    errors = np.array([rest.mean(axis=0) - force for rest, force in zip(rests, true, strict=True)])
    assert rounding_error(rests, step) == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.15)


def test_noise_as_large_as_a_step_leaves_nothing() -> None:
    rng = np.random.default_rng(0)
    rests = [np.round(rng.uniform(-9, 9, 3) + rng.standard_normal((500, 3))) for _ in range(20)]
    assert rounding_error(rests, 1.0) < 1e-6
    assert rounding_error(rests, 0.0) == 0.0


@given(step=st.floats(1e-3, 1.9), levels=st.lists(st.integers(-9, 9), min_size=9, max_size=30, unique=True))
def test_the_step_is_found_where_all_readings_are_multiples_of_it(step: float, levels: list[int]) -> None:
    column = step * np.array([*levels, 20, 21])
    assert step_of(np.column_stack([column, 0.0 * column, column[::-1]])) == pytest.approx(step)


def test_what_is_not_rounded_has_no_step() -> None:
    assert step_of(np.random.default_rng(0).standard_normal((100, 3))) == 0.0
    assert step_of(G * FACES) == 0.0
    assert step_of(np.zeros((0, 3))) == 0.0
    assert step_of(np.ones((50, 3))) == 0.0


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.02, 0.03, 0.06])
def test_standard_errors_hold_for_a_sensor_that_rounds(noise: float) -> None:
    """Six positions, which have no residuals that would tell."""
    found = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        k, bias = rng.uniform(0.95, 1.05, 3), a_bias(rng)
        exact = held(readings(G * FACES, np.diag(k), bias), noise=noise, seed=seed, hold_s=2.0)
        rounded = replace(exact, specific_force=COARSE * np.round(exact.specific_force / COARSE))
        calibration = calibrate_accelerometer(rounded, limits=StillLimits(force=0.12)).calibration
        found.append((calibration.bias - bias) / calibration.bias_error)
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(1.0, abs=0.4)
