"""Covering a moving surface: what must come of it, whatever the surface, its motion and the camera do."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

import ravengc as rg
from ravengc.errors import ArgumentError, ConfigError
from ravengc.track import (
    OUTCOMES,
    Camera,
    Surface,
    TrackSettings,
    drifting,
    liver_500,
    liver_surface,
    lujan,
    still,
    track,
)

ROBOT, LIVER, MOTION, CAMERA, SETTINGS = liver_500(0)
PATCH = Surface(LIVER.points[:12], LIVER.normals[:12], "patch")
QUICK = dataclasses.replace(SETTINGS, order="tour", hold_points=0, lead_in_s=15.0, settle_s=1.0)


def run(surface=PATCH, motion=MOTION, camera=CAMERA, on_progress=None, robot=ROBOT, **changes):
    settings = dataclasses.replace(QUICK, **changes)
    return track(robot, surface, motion, camera, settings, on_progress)


def bounded(result, robot=ROBOT):
    """Whatever happened: finite numbers, and no joint beyond a limit."""
    assert result.limit_violations == {"position": 0, "velocity": 0}
    for column in (result.trace.q, result.trace.tool, result.trace.predicted):
        assert np.isfinite(column).all()
    lower = np.array([limits.lower for limits in robot.spec.coordinate_limits])
    upper = np.array([limits.upper for limits in robot.spec.coordinate_limits])
    assert ((result.trace.q >= lower - 1e-9) & (result.trace.q <= upper + 1e-9)).all()
    return result


# What it does


def test_a_patch_of_the_liver_is_covered():
    told = []
    result = bounded(run(on_progress=lambda done, total: told.append((done, total))))
    assert result.coverage == 1.0
    assert told == [(done, 12) for done in range(1, 13)]
    assert result.visits.error_max_m.max() <= 1e-3
    assert result.time_per_point_s < 0.5
    assert sorted(result.visits.point) == list(range(12))


def test_a_still_target_is_held_exactly():
    """Without noise and motion, what is left after the way there is rounding."""
    result = bounded(run(motion=still(), camera=Camera(noise_m=0.0), hold_points=3, hold_s=3.0, hold_after_s=2.0))
    assert result.coverage == 1.0
    assert result.hold_max_m < 1e-9


def test_the_oracle_shows_what_the_controller_costs():
    """Knowing the truth, the tool stays within hundredths of a millimetre of a breathing point."""
    result = bounded(run(method="oracle", hold_points=2, hold_s=5.0, hold_after_s=2.0))
    assert result.coverage == 1.0
    assert result.prediction_rms_m == 0.0
    assert result.hold_max_m < 2e-5


def test_prediction_beats_chasing_what_was_seen():
    """The naive chase is behind by the age of the pictures; it must be seen in every number."""
    ours, naive = (run(method=method, hold_points=2, hold_s=5.0) for method in ("resolved", "naive"))
    assert ours.hold_rms_m < 0.6 * naive.hold_rms_m
    assert ours.prediction_rms_m < 0.6 * naive.prediction_rms_m


def test_a_hold_far_away_counts_from_arrival():
    """On the way to a point 0.38 m off the tool is up to that far from it, which says nothing of how it holds."""
    along = np.linspace(-0.19, 0.19, 5)
    bar = Surface(np.column_stack((np.full(5, 0.5), along, np.full(5, 0.3))), np.tile((0.0, 0.0, 1.0), (5, 1)), "bar")
    timed, arrived = (
        bounded(run(bar, still(), Camera(noise_m=0.0), hold_points=2, hold_s=2.0, hold_from_arrival=flag))
        for flag in (False, True)
    )
    assert timed.hold_max_m > 0.05
    assert arrived.hold_max_m <= SETTINGS.tolerance_m
    assert arrived.hold_rms_m < 2e-4
    assert [hold.scored_s - hold.start_s for hold in timed.holds] == pytest.approx([1.0, 1.0])
    late = max(hold.scored_s - hold.start_s for hold in arrived.holds)
    assert 0.38 / SETTINGS.speed_max < late <= 1.0 + 0.38 / SETTINGS.speed_max + 0.01


def test_a_hold_of_a_point_that_the_tool_never_reaches_has_no_error():
    """Neither one beyond the arm nor one within its length that it does not come to."""
    for x in (5.0, 0.85):
        away = Surface([[x, 0.0, 0.3]], [[-1.0, 0.0, 0.0]], "away")
        result = bounded(run(away, still(), hold_points=1, hold_s=2.0, timeout_s=1.0, hold_from_arrival=True))
        assert result.visits.count("unreachable") + result.visits.count("timeout") == 1
        assert np.isnan(result.hold_max_m)
        assert result.summary()["hold_rms_m"] is None
        assert np.isnan(result.holds[0].scored_s)


def test_what_the_predictor_noted_is_told():
    """Shivers of 5 Hz are out of the usual band of cycles, and found in their own; a chase predicts nothing.

    The first 12 s, three fifths of the pictures, are for learning.
    """
    shivers = lujan(amplitude=0.004, period_s=0.2)
    usual, told = (run(motion=shivers, **band) for band in ({}, {"band_hz": (2.0, 8.0), "harmonics": 3}))
    received = usual.predictor_counters["received"]
    assert received >= len(usual.camera) - 1
    assert usual.predictor_counters["out_of_band"] > 0.2 * received
    assert told.predictor_counters["out_of_band"] < 0.1 * told.predictor_counters["received"]
    assert told.prediction_rms_m < 0.8 * usual.prediction_rms_m
    assert usual.summary()["predictor_counters"] == usual.predictor_counters
    assert run(method="naive").predictor_counters == {}


def test_feeding_the_velocity_forward_removes_the_lag():
    """A proportional law behind a target at speed v lags by v / K."""
    with_it, without = (
        run(method="oracle", approach="proportional", feed_forward=flag, hold_points=1, hold_s=5.0)
        for flag in (True, False)
    )
    fastest = np.linalg.norm(MOTION.velocities(np.arange(0.0, 60.0, 0.01)), axis=1).max()
    assert with_it.hold_max_m < 2e-5
    assert 0.5 * fastest / 20.0 < without.hold_max_m <= 1.01 * fastest / 20.0


def test_smooth_approaches_accelerate_little():
    """The proportional law jumps at every hop; the smooth one keeps within what it is given."""
    smooth, jumping = (run(method="oracle", approach=approach) for approach in ("smooth", "proportional"))
    assert smooth.acceleration_max < 2.0 * QUICK.acceleration_max
    assert jumping.acceleration_max > 10.0 * smooth.acceleration_max
    assert smooth.time_per_point_s < jumping.time_per_point_s


def test_a_stand_off_keeps_the_tool_away_and_its_axis_on_the_normal():
    result = bounded(run(method="oracle", stand_off_m=0.03, dwell_s=0.2))
    trace, visits = result.trace, result.visits
    for row in range(len(visits)):
        dwelling = (trace.visit == row) & (trace.phase == "dwell")
        point, normal = PATCH.points[visits.point[row]], PATCH.normals[visits.point[row]]
        away = trace.tool[dwelling] - trace.displacement[dwelling] - point
        np.testing.assert_allclose(away, np.tile(0.03 * normal, (len(away), 1)), atol=6e-4)
        assert (trace.axis[dwelling] @ -normal > np.cos(SETTINGS.tolerance_rad) - 1e-9).all()


def test_palpation_presses_by_the_profile_of_depths():
    """The tool's height above the moving point, along its normal, is the profile's at the profile's times."""
    result = bounded(run(method="oracle", mode="palpate", trace_hz=1000.0))
    trace, visits = result.trace, result.visits
    assert result.coverage == 1.0
    for row in range(len(visits)):
        point, normal = PATCH.points[visits.point[row]], PATCH.normals[visits.point[row]]
        pressing = (trace.visit == row) & (trace.phase == "dwell")
        height = (trace.tool[pressing] - point - trace.displacement[pressing]) @ normal
        assert height.min() == pytest.approx(-0.003, abs=1e-4)
        assert height[-1] == pytest.approx(0.005, abs=6e-4)
        assert visits.dwell_s[row] == pytest.approx(0.9, abs=2e-3)


def test_the_same_seed_gives_the_same_run():
    first, again = run(), run()
    assert np.array_equal(first.trace.q, again.trace.q)
    assert first.visits.time_s.tolist() == again.visits.time_s.tolist()


# What it is given


def test_one_point_is_a_surface():
    assert bounded(run(Surface([LIVER.points[0]], [LIVER.normals[0]]))).coverage == 1.0


def test_duplicate_points_are_visited_where_they_lie():
    twice = Surface(np.repeat(PATCH.points, 2, axis=0), np.repeat(PATCH.normals, 2, axis=0))
    result = bounded(run(twice))
    assert result.coverage == 1.0
    assert len(result.visits) == 24


def test_a_million_points_can_be_begun():
    """What is done for every point is little: the run ends when it must."""
    spread = np.random.default_rng(0).uniform(-0.05, 0.05, (1_000_000, 3)) * (1.0, 1.0, 0.0)
    surface = Surface(LIVER.points[0] + spread, np.tile((0.0, 0.0, 1.0), (1_000_000, 1)))
    result = bounded(run(surface, most_s=2.0, lead_in_s=5.0))
    assert 0 < 1_000_000 - result.visits.count("not visited") < 50


def test_normals_that_point_away_from_each_other_are_turned_to_without_a_jump():
    surface = Surface(np.repeat(LIVER.points[:2], 2, axis=0), [LIVER.normals[0], -LIVER.normals[0]] * 2)
    bounded(run(surface, timeout_s=0.5))


def test_a_point_beyond_the_arm_is_reported_at_once():
    far = Surface(np.vstack((PATCH.points, [[3.0, 0.0, 0.3]])), np.vstack((PATCH.normals, [[0.0, 0.0, 1.0]])))
    result = bounded(run(far))
    at = int(np.flatnonzero(result.visits.point == 12)[0])
    assert result.visits.outcome[at] == "unreachable"
    assert result.visits.time_s[at] == 0.0
    assert result.coverage == pytest.approx(12 / 13)


def test_a_point_that_the_arm_cannot_reach_is_given_up_after_the_time_out():
    """Within the links' length but inside the arm itself: the tool stops short of it and goes on."""
    inside = Surface([[0.0, 0.0, 0.3], LIVER.points[0]], [[0.0, 0.0, 1.0], LIVER.normals[0]])
    result = bounded(run(inside, order="given", timeout_s=4.0))
    assert result.visits.outcome.tolist() == ["unreachable", "covered"]


def test_a_target_that_leaves_is_followed_to_the_end_of_the_arm_and_no_farther():
    result = bounded(run(motion=drifting((0.15, 0.0, 0.0), start_s=16.0), timeout_s=1.0))
    assert set(result.visits.outcome.tolist()) <= set(OUTCOMES)
    assert result.coverage < 1.0
    assert np.linalg.norm(result.trace.tool - (0.0, 0.0, 0.333), axis=1).max() < 1.2


def test_a_camera_that_sees_nothing_leaves_the_arm_where_it_is():
    result = bounded(run(camera=Camera(drop_fraction=1.0), timeout_s=0.1))
    assert result.coverage == 0.0
    assert (result.trace.q == result.trace.q[0]).all()


@pytest.mark.parametrize(
    "camera",
    [
        Camera(drop_fraction=0.5),
        Camera(jitter_s=0.2),
        Camera(gap_starts_s=(16.0, 18.0), gap_lengths_s=(0.5, 1.0)),
        Camera(rate_hz=5.0, noise_m=0.003, latency_s=0.3),
        Camera(rate_hz=1000.0, latency_s=0.0),
        Camera(rate_hz=2.0, latency_s=2.0, jitter_s=2.0),
    ],
    ids=("drops", "swapped", "gaps", "poor", "fast", "slow"),
)
def test_pictures_may_be_few_late_swapped_or_missing(camera):
    """The tool never jumps: closing in and being carried along each keep to the acceleration, arms add little."""
    result = bounded(run(camera=camera, timeout_s=0.5))
    assert set(result.visits.outcome.tolist()) <= set(OUTCOMES)
    assert result.acceleration_max < 3.0 * QUICK.acceleration_max


def test_a_run_ends_when_it_must_and_says_what_is_left():
    result = bounded(run(LIVER, most_s=3.0))
    assert result.visits.count("not visited") > 400
    assert result.visits.count("covered") > 5


def test_the_summary_is_json_and_its_outcomes_add_up():
    result = run(Surface([LIVER.points[0]], [LIVER.normals[0]]))
    summary = json.loads(json.dumps(result.summary(), allow_nan=False))
    assert sum(summary["outcomes"].values()) == summary["points"] == 1
    assert summary["hold_rms_m"] is None


def test_an_arm_without_limits_starts_at_zero_and_reports_none():
    robot = rg.from_dh(
        [{"a": 0.5, "mass": 1.0}] * 2 + [{"a": 0.3, "alpha": "90 deg", "mass": 1.0}] * 4, convention="standard"
    )
    surface = Surface([[1.0, 0.3, 0.2]], [[0.0, 0.0, 1.0]])
    result = run(surface, motion=still(), robot=robot, start_q=(0.3, 0.4, 0.5, 0.6, 0.7, 0.8), timeout_s=5.0)
    assert result.limit_violations == {"position": 0, "velocity": 0}
    assert np.isfinite(result.trace.q).all()


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: run(start_q=(0.0,) * 3), ConfigError, "start_q has 3 numbers; expected 7"),
        (lambda: run(robot=rg.load("rrbot")), ConfigError, "rrbot has 2 joints; 5 at least"),
        (lambda: run(start_q=(9.0,) * 7), ConfigError, "start_q: panda_joint1 at 9 is outside its limits, -2.8973"),
        (lambda: TrackSettings(mode="scna"), ConfigError, "mode is 'scna'.*did you mean 'scan'"),
        (lambda: TrackSettings(press_times_s=(0.0, 0.0), press_depths_m=(0.0, 0.0)), ConfigError, "increasing"),
        (lambda: TrackSettings(press_times_s=(0.0, 1.0)), ConfigError, "expected as many"),
        (lambda: TrackSettings(gain_per_s=300.0, rate_hz=100.0), ConfigError, "needs a rate_hz above it"),
        (lambda: TrackSettings(hold_points=1, hold_s=1.0, hold_after_s=1.0), ConfigError, "less than hold_s"),
        (lambda: TrackSettings(band_hz=(1.0, 1.2)), ConfigError, "band_hz is 1 to 1.2; expected the second 1.5 times"),
        (lambda: run(band_hz=(0.1, 20.0)), ConfigError, "at most half the rate of the samples"),
        (lambda: Camera(gap_starts_s=(1.0, 2.0)), ConfigError, "gap_starts_s and gap_lengths_s have 2 and 1"),
        (lambda: track(ROBOT, PATCH.points, MOTION, CAMERA, QUICK), ArgumentError, "surface is a ndarray"),
        (lambda: track(ROBOT, PATCH, "breathing", CAMERA, QUICK), ArgumentError, "motion is a str without"),
        (lambda: run(on_progress=3), ConfigError, "on_progress"),
        (lambda: Camera(rate_hz=0.1), ConfigError, "rate_hz is 0.1; expected a number from 2 to 1000 Hz"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_anything_moves(make, error, message):
    with pytest.raises(error, match=message):
        make()


def test_a_motion_of_the_callers_must_give_finite_rows():
    class Broken:
        description = "broken"

        def positions(self, t):
            return np.full((len(t), 3), np.nan)

        velocities = positions

    with pytest.raises(ArgumentError, match=r"motion.positions\(t\) must be .* finite"):
        run(motion=Broken())


def test_recordings_of_the_liver_are_motions_too():
    assert len(liver_surface()) == 500
    assert lujan(seed=0).description.startswith("respiration 15 mm")


# Stopped


def stopping_after(points):
    def tell(done, _total):
        if done == points:
            raise KeyboardInterrupt

    return tell


def test_ctrl_c_keeps_what_was_done():
    """The run until then, marked; its numbers are those of the points that were visited."""
    result = bounded(run(LIVER, on_progress=stopping_after(7), hold_points=2))
    assert result.interrupted
    assert result.visits.count("covered") == 7
    assert result.visits.count("not visited") == len(LIVER) - 7
    assert result.coverage == 7 / len(LIVER)
    assert 0.05 < result.time_per_point_s < 0.5
    assert not result.holds
    assert json.loads(json.dumps(result.summary(), allow_nan=False))["interrupted"]
    assert not run().interrupted


def test_ctrl_c_before_the_first_point_leaves_nothing_to_keep():
    class Stopping(type(MOTION)):
        def positions(self, _t):
            raise KeyboardInterrupt

    motion = Stopping(*(getattr(MOTION, name) for name in MOTION.__dataclass_fields__))
    with pytest.raises(KeyboardInterrupt):
        run(motion=motion)
