"""Later pictures judge a dwell, and points that they do not show covered are visited again, from pictures alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ravengc.track import Camera, Surface, TrackSettings, liver_500, track
from ravengc.track.hindsight import Hindsight
from ravengc.track.itinerary import Itinerary

ROBOT, LIVER, MOTION, CAMERA, SETTINGS = liver_500(0)
COVERED = SETTINGS.covered_m
TIMES = 3.0 + 1e-3 * np.arange(50)


def breathing(t):
    return 0.015 * np.sin(0.25 * np.pi * np.atleast_1d(t))[:, None] ** 4 * (1.0, 0.0, 0.0)


def verdict(off_m=0.0, camera=CAMERA, *, moves=breathing, times=TIMES, seed=0, seen=None, shuffled=False):
    """What is said of a dwell that was off by so much, of which the camera took its pictures."""
    hindsight = Hindsight(SETTINGS, camera)
    stamps = np.arange(0.0, times[-1] + 2.0, 1.0 / camera.rate_hz)
    stamps = stamps if seen is None else stamps[seen(stamps)]
    random = np.random.default_rng(seed)
    pictures = moves(stamps) + camera.noise_m * random.standard_normal((len(stamps), 3))
    for i in random.permutation(len(stamps)) if shuffled else range(len(stamps)):
        hindsight.saw(stamps[i], tuple(pictures[i].tolist()))
    hindsight.dwelt(7, times, moves(times) + np.array((0.0, off_m, 0.0)))
    due = hindsight.due_s
    assert due is not None
    assert not hindsight.verdicts(due - 1e-9)
    found = hindsight.verdicts(due)
    assert list(found) == [7]
    assert hindsight.due_s is None
    return found[7]


def test_a_tool_on_its_point_is_shown_there_and_one_off_it_is_contradicted():
    assert [verdict(0.3 * COVERED, seed=seed) for seed in range(50)] == ["shown"] * 50
    assert [verdict(1.3 * COVERED, seed=seed) for seed in range(50)] == ["contradicted"] * 50


def test_hardly_a_tool_that_was_too_far_off_is_taken_for_good():
    """At the very limit the margin is two standard deviations."""
    found = [verdict(1.01 * COVERED, seed=seed) for seed in range(200)]
    assert found.count("shown") <= 10


def test_the_order_of_the_pictures_does_not_matter():
    for off in (0.0, 2.0 * COVERED):
        assert verdict(off, shuffled=True) == verdict(off)


def test_without_pictures_around_it_nothing_is_called_covered():
    assert verdict(seen=lambda t: (t < 2.9) | (t > 4.0)) == "missing"
    assert verdict(seen=lambda t: t < 2.9) == "missing"


def test_what_pictures_cannot_tell_is_neither_shown_nor_contradicted():
    """Too noisy; or a motion that no quadratic follows from picture to picture."""
    assert verdict(camera=Camera(noise_m=0.003)) == "untold"
    assert verdict(moves=lambda t: 0.01 * np.sin(60.0 * np.atleast_1d(t))[:, None] * (1.0, 1.0, 1.0)) == "untold"


@pytest.mark.parametrize("rate_hz", [30.0, 100.0, 1000.0])
def test_a_beating_heart_is_followed_with_fewer_pictures(rate_hz):
    """Two hertz: where that is fast for the camera it says that it cannot tell, and never that a good dwell was bad."""
    camera = Camera(rate_hz=rate_hz, noise_m=1e-4)
    beat = lambda t: 0.004 * np.sin(4.0 * np.pi * np.atleast_1d(t))[:, None] * (1.0, 0.0, 0.5)  # noqa: E731
    good = {verdict(0.1 * COVERED, camera, moves=beat, seed=seed, times=TIMES + 0.01 * seed) for seed in range(20)}
    bad = {verdict(2.0 * COVERED, camera, moves=beat, seed=seed, times=TIMES + 0.01 * seed) for seed in range(20)}
    assert good <= {"shown", "untold"}
    assert bad <= {"contradicted", "untold"}
    assert rate_hz < 1000.0 or (good, bad) == ({"shown"}, {"contradicted"})


def test_a_long_dwell_is_as_good_as_its_worst_piece():
    times = 3.0 + 5e-3 * np.arange(400)
    hindsight = Hindsight(SETTINGS, CAMERA)
    for stamp in np.arange(0.0, 8.0, 1.0 / 30.0).tolist():
        hindsight.saw(stamp, tuple(breathing(stamp)[0].tolist()))
    places = breathing(times)
    places[300:320] += (0.0, 0.0, 1.5 * COVERED)
    hindsight.dwelt(0, times, places)
    assert hindsight.verdicts(9.0) == {0: "contradicted"}


def test_pictures_are_kept_no_longer_than_they_are_needed():
    hindsight = Hindsight(SETTINGS, CAMERA)
    for i in range(3000):
        hindsight.saw(i / 30.0, (0.0, 0.0, 0.0))
        if i % 30 == 0:
            hindsight.dwelt(i, np.array([i / 30.0]), np.zeros((1, 3)))
            hindsight.verdicts(i / 30.0)
    assert len(hindsight._pictures) < 120


# Where the tool goes next


@given(st.integers(1, 12), st.integers(0, 3), st.data())
@settings(max_examples=200, deadline=None)
def test_every_point_is_visited_and_none_more_often_than_it_may_be(count, most, data):
    plan = Itinerary(np.random.default_rng(count).normal(size=(count, 3)), most)
    seen: list[int] = []
    while (row := plan.next()) is not None:
        seen.append(row)
        if data.draw(st.booleans()):
            plan.again(row)
    assert sorted(set(seen)) == list(range(count))
    assert plan.visited == count
    assert max(seen.count(row) for row in range(count)) <= most + 1
    assert plan.tries.tolist() == [seen.count(row) for row in range(count)]
    firsts = [row for i, row in enumerate(seen) if row not in seen[:i]]
    assert firsts == list(range(count))


def test_a_point_is_visited_again_when_the_tour_comes_by_or_else_at_the_end():
    there_and_back = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    plan = Itinerary(there_and_back, 2)
    assert [plan.next() for _ in range(4)] == [0, 1, 2, 3]
    plan.again(0)
    plan.again(1)
    assert [plan.next() for _ in range(5)] == [1, 0, 4, 5, None]


# In a run


class Startled:
    """A surface that lies still and jerks aside by 3 mm at times that nobody knows, within a tenth of a second."""

    description = "startled"
    jerks = (16.6, 17.4, 18.2)

    def positions(self, t):
        return self._along(np.clip((t[:, None] - self.jerks) / 0.1, 0.0, 1.0).sum(axis=1) * 0.003)

    def velocities(self, t):
        jerking = (t[:, None] >= self.jerks) & (t[:, None] < np.add(self.jerks, 0.1))
        return self._along(jerking.sum(axis=1) * 0.03)

    def _along(self, x):
        return x[:, None] * (1.0, 0.0, 0.0)


def startled(**changes):
    surface = Surface(LIVER.points[:24], LIVER.normals[:24])
    given = dataclasses.replace(
        SETTINGS, order="tour", hold_points=0, lead_in_s=15.0, settle_s=1.0, trace_hz=1000.0, **changes
    )
    return track(ROBOT, surface, Startled(), CAMERA, given)


def test_points_from_which_the_surface_jerked_away_are_visited_again():
    once, again = startled(revisits=0), startled()
    assert once.coverage < 1.0
    assert once.revisits == 0
    assert (once.visits.verdict[once.visits.outcome == "missed"] != "shown").all()
    assert again.coverage == 1.0
    assert again.confirmed >= 0.95 > once.confirmed
    assert again.revisits == int((again.visits.tries - 1).sum()) > 0
    for run in (once, again):
        assert run.limit_violations == {"position": 0, "velocity": 0}
        touring = run.trace.phase != "settle"
        spent = np.count_nonzero(touring) / run.settings.rate_hz
        assert run.time_per_point_s * len(run.visits) == pytest.approx(spent, abs=2e-3)


def test_the_naive_chase_and_the_oracle_do_not_look_back():
    for method in ("naive", "oracle"):
        assert startled(method=method).revisits == 0


def test_points_visited_while_the_camera_was_blind_are_not_called_covered_before_they_were_seen():
    camera = dataclasses.replace(CAMERA, gap_starts_s=(16.5,), gap_lengths_s=(0.8,))
    surface = Surface(LIVER.points[:24], LIVER.normals[:24])
    given = dataclasses.replace(SETTINGS, order="tour", hold_points=0, lead_in_s=15.0, settle_s=1.0, timeout_s=0.5)
    blind, run = (track(ROBOT, surface, MOTION, camera, dataclasses.replace(given, revisits=n)) for n in (0, 2))
    assert "missing" in blind.visits.verdict
    assert run.revisits > 0
    assert "missing" not in run.visits.verdict
    assert run.confirmed > blind.confirmed


def test_a_camera_that_goes_blind_for_good_ends_the_run_after_a_bounded_number_of_visits():
    camera = dataclasses.replace(CAMERA, gap_starts_s=(15.5,), gap_lengths_s=(1e6,))
    given = dataclasses.replace(SETTINGS, order="tour", hold_points=0, lead_in_s=15.0, settle_s=1.0, timeout_s=0.2)
    run = track(ROBOT, Surface(LIVER.points[:4], LIVER.normals[:4]), MOTION, camera, given)
    assert run.visits.tries.max() <= 1 + given.revisits
    assert run.confirmed == 0.0


def test_settings_say_how_often():
    assert TrackSettings().revisits == 2
