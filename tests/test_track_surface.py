"""Surfaces, their tours and motions: what a cloud may be, and what is said about one that may not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ravengc.errors import ArgumentError, ConfigError
from ravengc.track import Surface, drifting, liver_500, liver_surface, lujan, recorded, still, tour

UP = (0.0, 0.0, 1.0)
RNG = np.random.default_rng(0)


def flat(points):
    return Surface(points, np.tile(UP, (len(points), 1)))


def length(surface, order):
    return float(np.linalg.norm(np.diff(surface.points[order], axis=0), axis=1).sum())


# LIVER-500


def test_the_surface_of_liver_500_has_the_published_checks():
    """Extent, sum of the coordinates about the centre, and the hops of the strips, to the digits published."""
    surface = liver_surface()
    millimetres = 1e3 * (surface.points - (0.520, 0.0, 0.320))
    assert len(surface) == 500
    np.testing.assert_allclose(np.ptp(millimetres, axis=0), (126.491, 180.719, 26.138), atol=6e-4)
    assert millimetres.sum() == pytest.approx(16408.475397, abs=1e-5)
    hops = np.linalg.norm(np.diff(millimetres[tour(surface, "strips")], axis=0), axis=1)
    assert hops.mean() == pytest.approx(7.66, abs=5e-3)
    assert hops.max() == pytest.approx(29.1, abs=0.05)


def test_the_singular_surface_is_the_same_lower_and_nearer():
    shift = liver_surface(singular=True).points - liver_surface().points
    np.testing.assert_allclose(shift, np.tile((-0.040, 0.0, -0.140), (500, 1)), atol=1e-15)


def test_liver_500_is_decided_by_its_seed():
    _, _, first, camera, _ = liver_500(3)
    _, _, again, _, _ = liver_500(3)
    _, _, other, _, _ = liver_500(4)
    t = np.linspace(0.0, 60.0, 100)
    assert np.array_equal(first.positions(t), again.positions(t))
    assert not np.array_equal(first.positions(t), other.positions(t))
    assert camera.seed == 10_003


# Surfaces


def test_normals_become_unit_and_the_cloud_is_kept_as_given():
    points = RNG.normal(size=(9, 3))
    surface = Surface(points, 7.0 * RNG.normal(size=(9, 3)))
    points[0] = 99.0
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0, atol=1e-15)
    assert abs(surface.points).max() < 99.0
    assert not surface.points.flags.writeable


@pytest.mark.parametrize(
    ("points", "normals", "message"),
    [
        ([[np.nan, 0, 0], [0, 0, 0]], [UP, UP], "not finite in 1 of 2 rows, the first is row 0"),
        ([[0, 0, 0], [0, 0, 0]], [UP, (0, 0, 0)], "without length in 1 of 2 rows, the first is row 1"),
        ([[5e3, 0, 0]], [UP], "farther than 1000 m"),
        ([[0, 0, 0]], [UP, UP], r"normals has shape \(2, 3\); expected that of points"),
        ([[0, 0]], [UP], r"points has shape \(1, 2\)"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "points has 0 rows"),
    ],
)
def test_a_cloud_that_cannot_be_visited_is_refused_and_says_where(points, normals, message):
    with pytest.raises(ArgumentError, match=message):
        Surface(points, normals)


def test_cleaning_leaves_out_what_cannot_be_visited_and_counts_it():
    points = [[0, 0, 0], [1, 0, 0], [0, 0, 0], [np.inf, 0, 0], [2, 0, 0], [1 + 1e-9, 0, 0]]
    normals = [UP, UP, UP, UP, (0, 0, 0), UP]
    surface = Surface.cleaned(points, normals)
    assert surface.points.tolist() == [[0, 0, 0], [1, 0, 0]]
    assert surface.dropped == {"a number that is not finite": 1, "a normal without length": 1, "duplicate point": 2}
    with pytest.raises(ArgumentError, match="no point is left of 1"):
        Surface.cleaned([[np.nan, 0, 0]], [UP])


# Tours


@given(st.integers(1, 60), st.integers(0, 1000), st.sampled_from(["tour", "given", "strips"]))
@settings(max_examples=60, deadline=None)
def test_a_tour_visits_every_point_once(count, seed, order):
    points = np.random.default_rng(seed).normal(size=(count, 3)).round(1)  # many of them coincide
    assert sorted(tour(flat(points), order)) == list(range(count))


def test_a_tour_is_shorter_than_strips_and_much_shorter_than_the_spiral():
    surface = liver_surface()
    short, strips = (length(surface, tour(surface, order)) for order in ("tour", "strips"))
    assert short < 0.95 * strips < 0.2 * length(surface, tour(surface, "given"))


def test_the_two_sides_of_a_plate_are_toured_one_after_the_other():
    grid = np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1).reshape(-1, 2) / 100.0
    points = np.tile(np.column_stack((grid, np.zeros(64))), (2, 1)) + np.repeat([[0, 0, 1e-4], [0, 0, -1e-4]], 64, 0)
    surface = Surface(points, np.repeat([[0, 0, 1.0], [0, 0, -1.0]], 64, 0))
    sides = np.sign(surface.normals[tour(surface), 2])
    assert np.count_nonzero(np.diff(sides)) <= 3


def test_a_million_points_are_toured_by_a_sort():
    surface = flat(RNG.uniform(size=(1_000_000, 3)) * (1.0, 1.0, 1e-3))
    order = tour(surface)
    assert np.array_equal(np.sort(order), np.arange(1_000_000))
    assert length(surface, order) < 3_000.0  # the shortest way over n random points is 0.71 sqrt(n)


def test_an_unknown_order_is_refused():
    with pytest.raises(ConfigError, match=r"order 'strip' is unknown.*did you mean 'strips'"):
        tour(flat(np.zeros((1, 3))), "strip")


# Motions


@pytest.mark.parametrize(
    "motion",
    [
        lujan(seed=1),
        lujan(variation=0.0),
        recorded(np.arange(40.0) ** 1.1, RNG.normal(size=(40, 3))),
        drifting((0.0, 0.01, 0.0)),
        still(),
    ],
    ids=lambda motion: motion.description,
)
def test_velocity_is_the_derivative_of_position(motion):
    t, h = RNG.uniform(1.0, 100.0, 500), 1e-6
    slope = (motion.positions(t + h) - motion.positions(t - h)) / (2.0 * h)
    np.testing.assert_allclose(motion.velocities(t), slope, atol=2e-5)


def test_breaths_vary_by_the_share_that_they_shall_and_no_breath_jumps():
    motion = lujan(amplitude=0.015, period_s=4.0, variation=0.1, seed=0)
    assert motion.periods.mean() == pytest.approx(4.0, rel=0.02)
    assert motion.periods.std() == pytest.approx(0.4, rel=0.1)
    assert motion.amplitudes.std() == pytest.approx(0.0015, rel=0.1)
    assert abs(motion.periods - 4.0).max() <= 1.0 + 1e-12
    t = np.arange(0.0, 3600.0, 0.01)
    assert np.linalg.norm(np.diff(motion.positions(t), axis=0), axis=1).max() < 0.01 * 0.030


def test_a_recording_is_met_at_its_samples_and_played_back_and_forth():
    stamps, shifts = np.array([5.0, 6.0, 7.0, 9.0]), RNG.normal(size=(4, 3))
    motion = recorded(stamps, shifts)
    centred = shifts - shifts.mean(axis=0)
    np.testing.assert_allclose(motion.positions(stamps - 5.0), centred, atol=1e-12)
    np.testing.assert_allclose(motion.positions(8.0 - (stamps - 5.0)), centred, atol=1e-12)
    np.testing.assert_allclose(motion.positions(8.0 + (stamps - 5.0)), centred, atol=1e-12)


@pytest.mark.parametrize("gap", [0.3, 5.0, 60.0, 1e6])
def test_across_a_gap_a_recording_does_not_swing_out_of_where_it_was(gap):
    """A cubic through both sides would: by 80 mm for a target of 18 mm that was lost for a minute."""
    before = np.arange(200) / 25.0
    seen = 0.01 * np.column_stack((np.sin(2.0 * before), np.cos(1.3 * before), 0.2 * np.sin(before)))
    seen -= seen.mean(axis=0)
    stamps = np.where(before < 3.0, before, before + gap)
    motion = recorded(stamps, seen)
    np.testing.assert_allclose(motion.positions(stamps), seen, atol=1e-9)
    between = (motion.stamps[:-1] + np.linspace(0.0, 1.0, 21)[:, None] * np.diff(motion.stamps)).ravel()
    far = 1.01 * abs(seen).max(axis=0)
    assert (abs(motion.positions(between)) <= far).all()
    assert abs(motion.velocities(between)).max() < 0.03


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: recorded([0.0, 1.0, 1.0], np.zeros((3, 3))), ArgumentError, "stamps must be .* increase"),
        (lambda: recorded([0.0, 1.0, 2.0], np.full((3, 3), np.nan)), ArgumentError, "not finite"),
        (lambda: recorded([0.0, 1.0, 2.0], np.zeros((2, 3))), ArgumentError, r"expected \(3, 3\)"),
        (lambda: lujan(variation=0.5), ConfigError, "variation is 0.5; expected 0 to 0.35"),
        (lambda: lujan(direction=(0, 0, 0)), ArgumentError, "direction is zero"),
    ],
)
def test_a_motion_that_is_none_is_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()
