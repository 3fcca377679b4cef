"""Known tilts give back bias and mounting to within their errors; a mirror is refused, and so is what is no tilt."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration_scenes import (
    FACES,
    NOISE,
    G,
    a_bias,
    cone,
    correction,
    evenly,
    readings,
    rotation,
    spread_of,
    turn_between,
    within,
)
from ravengc.calibration import (
    fit_ellipsoid,
    fit_tilts,
    mounting_rotation,
    tilted_force,
)
from ravengc.calibration.kabsch import MIRRORS, rotation_angle_deg
from ravengc.calibration.mounted import mounted
from ravengc.errors import CalibrationError

SEEDS = st.integers(0, 2**32 - 1)
thorough = settings(max_examples=60, deadline=None)


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
    angles = turn_between(found.rotation, r)
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


def test_standard_errors_of_known_tilts_are_right() -> None:
    """The bias is known best along the vertical, which here is the sensor's y."""
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    expected, s = tilts(20.0, 10, np.random.default_rng(2)), np.diag([1.2, 0.85, 1.0])
    best = fit_tilts(readings(expected @ upright, s, np.zeros(3)), expected, NOISE, correction=s).bias_error
    assert best[1] < 0.3 * best[[0, 2]].min()

    def trial(rng: np.random.Generator) -> np.ndarray:
        forces = expected @ upright + NOISE * rng.standard_normal((10, 3))
        found = fit_tilts(forces @ np.linalg.inv(s).T, expected, NOISE, correction=s)
        return np.concatenate(
            [turn_between(found.rotation, upright) / found.rotation_error, found.bias / found.bias_error]
        )

    np.testing.assert_allclose(spread_of(trial, 400), 0.97, atol=0.14)


# Mirrors, and what may be one


@thorough
@given(seed=SEEDS, fault=st.sampled_from(sorted(MIRRORS)), reach=st.floats(8.0, 60.0), count=st.integers(3, 10))
def test_no_mirrored_sensor_is_accepted_from_tilts_to_several_sides(
    seed: int, fault: str, reach: float, count: int
) -> None:
    """Whatever its mounting and the tilts, with the fewest by the bias that a mirror would take."""
    rng, lean = np.random.default_rng(seed), np.radians(reach)
    around = rng.uniform(0.0, 2.0 * np.pi) + np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    expected = np.array([tilted_force(lean * np.cos(a), lean * np.sin(a)) for a in around])
    forces = readings(expected @ rotation(seed), np.eye(3), a_bias(rng), rng)
    good = fit_tilts(forces, expected, NOISE)
    assert good.notes == ()
    assert within(turn_between(good.rotation, rotation(seed)), 0.0, good.rotation_error, 1e-4)
    with pytest.raises(CalibrationError, match=r"mirror image|no axis exchanged"):
        fit_tilts(forces @ MIRRORS[fault], expected, NOISE)


@pytest.mark.parametrize("fault", [None, *MIRRORS])
def test_tilts_in_a_plane_are_accepted_with_the_note_that_they_show_no_mirror(fault: str | None) -> None:
    expected = np.array([tilted_force(0.0, angle) for angle in np.radians([-20.0, -10.0, 0.0, 10.0, 20.0])])
    mirror = np.eye(3) if fault is None else MIRRORS[fault]
    found = fit_tilts(readings(expected @ rotation(3), np.eye(3), np.full(3, 0.1)) @ mirror, expected, NOISE)
    assert found.notes == (
        "the tilts lie in a plane: a sensor with an axis mirrored would fit as well; one more, across it, would tell",
    )
    more = np.vstack([expected, tilted_force(0.3, 0.0)])
    forces = readings(more @ rotation(3), np.eye(3), np.full(3, 0.1)) @ mirror
    if fault is None:
        assert fit_tilts(forces, more, NOISE).notes == ()
    else:
        with pytest.raises(CalibrationError, match="mirror image"):
            fit_tilts(forces, more, NOISE)


def test_a_mounting_says_whether_a_mirror_is_excluded() -> None:
    assert mounting_rotation(FACES, FACES, NOISE).handed
    assert not mounting_rotation(FACES[:2], FACES[:2], NOISE).handed


@thorough
@given(seed=SEEDS, count=st.integers(5, 12), degrees=st.floats(2.0, 8.0))
def test_the_tilt_that_was_not_as_declared_is_named(seed: int, count: int, degrees: float) -> None:
    rng = np.random.default_rng(seed)
    around = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    expected = np.array([tilted_force(0.35 * np.cos(a), 0.35 * np.sin(a)) for a in around])
    forces = readings(expected @ rotation(seed), np.eye(3), a_bias(rng), rng)
    wrong, turn = int(rng.integers(count)), np.radians(degrees)
    declared = expected.copy()
    declared[wrong] = tilted_force(0.35 * np.cos(around[wrong]) + turn, 0.35 * np.sin(around[wrong]) - turn)
    found = fit_tilts(forces, declared, NOISE)
    assert found.suspect[0] == wrong
    assert found.suspect[1] == pytest.approx(np.linalg.norm(declared[wrong] - expected[wrong]), rel=0.1, abs=0.05)
    assert found.noise_ratio is not None
    assert found.noise_ratio > 5.0


@pytest.mark.parametrize("known", [np.zeros((3, 3)), np.diag([1.0, 1.0, 0.0]), 9.8 * np.eye(3)])
def test_a_correction_that_no_sensor_has_is_refused(known: np.ndarray) -> None:
    with pytest.raises(CalibrationError, match=r"scale would be .*; expected 0\.8 to 1\.25"):
        fit_tilts(G * FACES, G * FACES, NOISE, correction=known)


# Free positions at known tilts


def test_standard_errors_of_a_mounting_hold_the_errors_of_the_calibration() -> None:
    """Of twelve positions, which leave the calibration twice as uncertain as the rotation alone would be."""
    s, bias, r, expected = correction(np.random.default_rng(1)), np.array([0.3, -0.2, 0.1]), rotation(5), G * evenly(12)

    def trial(rng: np.random.Generator) -> np.ndarray:
        forces = readings(expected @ r, s, bias, rng)
        found = mounted(fit_ellipsoid(forces, NOISE), forces, expected, np.full(12, NOISE))
        return turn_between(found.rotation, r) / found.rotation_error

    np.testing.assert_allclose(spread_of(trial, 250), 0.95, atol=0.17)


def test_a_tilt_that_was_not_as_declared_shows_in_a_calibration_of_free_positions() -> None:
    """The lengths are right whatever the tilts are said to be."""
    expected, rng = G * evenly(16), np.random.default_rng(2)
    forces = readings(expected @ rotation(4), np.eye(3), np.full(3, 0.1), rng)
    expected[6] = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) @ expected[6]
    found = mounted(fit_ellipsoid(forces, NOISE), forces, expected, np.full(16, NOISE))
    assert not found.good
    assert "position 7 is off" in found.verdict
