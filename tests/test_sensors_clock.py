"""A sensor's clock on the host's: no stamp after its arrival, none further from the truth than the delays allow."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ravengc.sensors.clock import ClockMap, Unwrapper, spread

MS, S = 1_000_000, 1_000_000_000
START = 1234 * S


@pytest.mark.parametrize("bits", [8, 16, 23, 24, 32, 64])
@given(start=st.integers(0, 2**70), steps=st.lists(st.integers(-100, 2000), max_size=50))
@settings(deadline=None)
def test_unwrapping_gives_the_steps_back(bits: int, start: int, steps: list[int]) -> None:
    """Steps of less than half a turn, forwards and back, over any number of wraps."""
    half = 1 << (bits - 1)
    small = [max(-half + 1, min(step, half - 1)) for step in steps]
    counts = list(itertools.accumulate(small, initial=start))
    clock = Unwrapper(bits)
    unwrapped = [clock.unwrap(count % (1 << bits)) for count in counts]
    assert [later - sooner for sooner, later in itertools.pairwise(unwrapped)] == small


@given(
    delays=st.lists(st.integers(0, 30 * MS), min_size=200, max_size=200),
    ppm=st.integers(-5000, 5000),
    zero=st.integers(-(10**18), 10**18),
)
@settings(deadline=None)
def test_stamps_are_true_to_the_spread_of_the_delays(delays: list[int], ppm: int, zero: int) -> None:
    """A clock off by up to 0.5 % with any zero: once a reading came straight, errors are the rise of the map alone.

    The shortest delay stays hidden, so each tenth reading is given none.
    """
    clock, errors, last = ClockMap(), [], 0
    for number in range(200):
        taken = START + 10 * MS * number
        arrival = max(taken + (delays[number] if number % 10 else 0), last)
        stamp = clock.stamp(zero + (taken - START) * (1_000_000 + ppm) // 1_000_000, arrival)
        assert stamp <= arrival
        errors.append(stamp - taken)
        last = arrival
    assert clock.restarts == 0
    assert max(map(abs, errors[10:])) <= 3 * MS


def test_a_late_reading_keeps_the_time_it_was_taken() -> None:
    clock = ClockMap()
    for number in range(100):
        clock.stamp(10 * MS * number, START + 10 * MS * number)
    stamps = [clock.stamp(10 * MS * number, START + 10 * MS * 130) for number in range(100, 131)]
    truth = [START + 10 * MS * number for number in range(100, 131)]
    assert max(abs(stamp - true) for stamp, true in zip(stamps, truth, strict=True)) <= 4 * MS
    assert stamps == sorted(set(stamps))


def test_a_reading_out_of_order_has_its_own_stamp_and_the_gate_sees_it() -> None:
    clock = ClockMap()
    stamps = [clock.stamp(10 * MS * number, START + 10 * MS * number) for number in range(10)]
    assert clock.stamp(75 * MS, START + 91 * MS) == pytest.approx(START + 75 * MS, abs=MS)
    assert clock.stamp(100 * MS, START + 100 * MS) > stamps[-1]


@pytest.mark.parametrize("after", [-500 * S, 3600 * S])
def test_a_clock_that_jumps_is_followed_at_once(after: int) -> None:
    clock = ClockMap()
    for number in range(10):
        clock.stamp(600 * S + 10 * MS * number, START + 10 * MS * number)
    for number in range(10, 20):
        arrival = START + 10 * MS * number
        assert abs(clock.stamp(600 * S + after + 10 * MS * number, arrival) - arrival) <= MS
    assert clock.restarts == 1


@pytest.mark.parametrize("ran", [0.15, 0.3, 0.8])
@pytest.mark.parametrize("pause", [0.05, 2.0])
def test_a_board_that_restarts_at_once_is_followed_at_once(ran: float, pause: float) -> None:
    """A short step back is a restart too: else what follows would count as late by the whole pause, for minutes."""
    clock, ran_ns, pause_ns = ClockMap(), round(ran * S), round(pause * S)
    for age in range(0, ran_ns + 1, 10 * MS):
        clock.stamp(age, START + age)
    again = START + ran_ns + pause_ns
    for age in range(0, 200 * MS, 10 * MS):
        assert abs(clock.stamp(age, again + age) - (again + age)) <= MS
    assert clock.restarts == 1


def test_a_glitch_of_the_clock_costs_no_more_than_itself() -> None:
    clock = ClockMap()
    for number in range(30):
        arrival = START + 10 * MS * number
        stamp = clock.stamp(10 * MS * number + (7200 * S if number == 15 else 0), arrival)
        assert arrival - MS <= stamp <= arrival
    assert clock.restarts == 2


@given(
    clocks=st.lists(st.integers(-(2**63), 2**63), min_size=1, max_size=30),
    arrivals=st.lists(st.integers(0, 2**62), min_size=30),
)
@settings(deadline=None)
def test_no_clock_whatever_stamps_the_future(clocks: list[int], arrivals: list[int]) -> None:
    clock = ClockMap()
    for ticks, arrival in zip(clocks, arrivals, strict=False):
        assert clock.stamp(ticks, arrival) <= arrival


@given(count=st.integers(1, 100), before=st.integers(0, 2**62), gap=st.integers(0, 10 * S))
def test_readings_that_come_together_are_spread(count: int, before: int, gap: int) -> None:
    stamps = spread(count, before, before + gap)
    assert len(stamps) == count
    assert before < stamps[0]
    assert all(later > sooner for sooner, later in itertools.pairwise(stamps))
    assert stamps[-1] == max(before + gap, before + count)
