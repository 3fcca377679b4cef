"""What the documentation of resolved rate promises, from every state: limits, caps, names, direction, bad numbers."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rate_arms import DT, FREE, HOME, PANDA, made, of_task, target_at
from ravengc.resolved_rate import LIMITS, TASKS, ResolvedRate

if TYPE_CHECKING:
    from collections.abc import Callable

adversarial = settings(max_examples=60, deadline=None)
seeds = st.integers(0, 2**32 - 1).map(np.random.default_rng)
LOWER, UPPER = (np.array([getattr(x, side) for x in PANDA.spec.coordinate_limits]) for side in ("lower", "upper"))
FASTEST = np.array([limit.velocity for limit in PANDA.spec.coordinate_limits])


def within(random: np.random.Generator) -> np.ndarray:
    """Positions between the limits, some of them at one."""
    q = random.uniform(LOWER, UPPER)
    return np.where(random.random(7) < 0.2, np.where(random.random(7) < 0.5, LOWER, UPPER), q)


def wild(random: np.random.Generator) -> np.ndarray:
    """A twist of any size."""
    return random.standard_normal(6) * 10.0 ** random.uniform(-6, 5)


@pytest.mark.parametrize("limits", LIMITS)
@adversarial
@given(random=seeds, qdd=st.sampled_from([0.5, 20.0, np.inf]), qddd=st.sampled_from([10.0, 1e3, np.inf]))
def test_no_limit_of_rate_or_position_is_passed_from_any_state(
    limits: str, random: np.random.Generator, qdd: float, qddd: float
) -> None:
    """Whatever the twists, and however long each step is."""
    rate, q = made(PANDA, limits=limits, qdd_max=qdd, qddd_max=qddd), within(random)
    for _ in range(60):
        dt = random.choice([1e-6, 1e-3, 1e-3, 0.02, 0.4, 1.0])
        qd = rate.step(q, wild(random), dt)
        assert (np.abs(qd) <= FASTEST).all(), rate.reason
        q = q + dt * qd
        assert (q >= LOWER - 1e-12).all(), rate.reason
        assert (q <= UPPER + 1e-12).all(), rate.reason


@pytest.mark.parametrize("limits", LIMITS)
@adversarial
@given(random=seeds, jerky=st.booleans())
def test_caps_hold_from_any_rates_before(limits: str, random: np.random.Generator, jerky: bool) -> None:
    """Where no limit of rate or position comes first: those may need a harder change."""
    qdd, qddd = random.uniform(1.0, 20.0, 7), random.uniform(50.0, 500.0, 7)
    options: dict[str, Any] = {"limits": limits, "qdd_max": qdd, **FREE} | ({"qddd_max": qddd} if jerky else {})
    rate, before, slope = made(PANDA, **options), np.zeros(7), np.zeros(7)
    for _ in range(80):
        dt = random.choice([1e-4, 1e-3, 1e-3, 0.02, 0.3])
        qd = rate.step(random.uniform(-3.0, 3.0, 7), wild(random), dt)
        now = (qd - before) / dt
        rounding = 1e-12 * (1.0 + np.abs(before).max() / dt)
        assert (np.abs(now) <= qdd * (1.0 + 1e-9) + rounding).all(), rate.reason
        if jerky:
            assert (np.abs(now - slope) <= qddd * dt * (1.0 + 1e-9) + 2.0 * rounding).all(), rate.reason
        before, slope = qd, now


@pytest.mark.parametrize("kind", ["velocity", "position", "acceleration", "jerk"])
@pytest.mark.parametrize("task", ["twist", "position", "pointing"])
@adversarial
@given(random=seeds)
def test_the_joint_that_is_named_is_the_one_that_stands(task: str, kind: str, random: np.random.Generator) -> None:
    """The joint whose limit leaves the smallest share of its own rate; and that share of all rates is what is done."""
    q, twist = HOME + random.uniform(-0.3, 0.3, 7), of_task(task, random.standard_normal(6))
    wanted = made(PANDA, task, **FREE).step(q, twist, DT)
    most = np.abs(wanted) * random.uniform(0.2, 3.0, 7) + 1e-6
    if kind == "jerk":  # so far from the goal that nothing is braked for
        most = 0.02 * most
    given: dict[str, Any] = {
        "velocity": {**FREE, "qd_max": most},
        "position": {**FREE, "q_min": q - most / 20.0, "q_max": q + most / 20.0},
        "acceleration": {**FREE, "qdd_max": most / DT},
        "jerk": {**FREE, "qddd_max": most / DT**2},
    }[kind]
    rate = made(PANDA, task, **given)
    shares = most / np.abs(wanted)
    share = min(1.0, shares.min())
    done = rate.step(q, twist, DT)
    np.testing.assert_allclose(done, share * wanted, rtol=1e-9, atol=1e-12)
    if share == 1.0:
        assert (rate.limiting_joint, rate.limit, rate.reason) == (None, None, "")
        return
    assert rate.limit == kind
    assert shares[rate.limiting_joint] == pytest.approx(share, rel=1e-6)
    assert rate.seen == (f"{kind}_limit",)
    assert repr(PANDA.joint_names[rate.limiting_joint]) in rate.reason
    assert rate.scale == pytest.approx(share if kind in {"velocity", "position"} else 1.0)


@pytest.mark.parametrize("task", TASKS)
@adversarial
@given(random=seeds)
def test_what_is_slowed_down_keeps_its_direction(task: str, random: np.random.Generator) -> None:
    """By limits of rate and position at once, in every task."""
    q, twist = np.clip(within(random), LOWER + 1e-3, UPPER - 1e-3), of_task(task, 10.0 * random.standard_normal(6))
    free, rate = made(PANDA, task, **FREE), made(PANDA, task)
    wanted, done = free.step(q, twist, DT), rate.step(q, twist, DT)
    np.testing.assert_allclose(done, rate.scale * wanted, atol=1e-9)
    assert 0.0 <= rate.scale <= 1.0


BAD = (np.nan, np.inf, -np.inf, 1e7, -1e300)


def broken(x: np.ndarray, place: int, bad: float) -> np.ndarray:
    copy = np.array(x, float)
    copy.flat[place] = bad
    return copy


def spoiled(rate: ResolvedRate, task: str, target: np.ndarray, bad: float) -> dict[str, list[Callable[[], np.ndarray]]]:
    """Every number that can come in, one bad at a time, by the event that it is."""
    twist, base = of_task(task, np.full(6, 0.1)), np.full(6, 0.01)
    entries = range(12 if target.shape == (4, 4) else target.size)  # the last row of a pose says nothing
    return {
        "absent": [partial(rate.step, broken(HOME, k, bad), twist, DT, base) for k in range(7)],
        "twist": [partial(rate.step, HOME, broken(twist, k, bad), DT, base) for k in range(twist.size)]
        + [partial(rate.track, HOME, target, DT, broken(twist, k, bad), base) for k in range(twist.size)],
        "base_twist": [partial(rate.step, HOME, twist, DT, broken(base, k, bad)) for k in range(6)],
        "target": [partial(rate.track, HOME, broken(target, k, bad), DT, twist, base) for k in entries],
        "time": [partial(rate.step, HOME, twist, bad, base)],
    }


@pytest.mark.parametrize("limits", LIMITS[:2])
@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("task", TASKS)
def test_every_bad_number_is_named_and_forgotten(task: str, bad: float, limits: str) -> None:
    """The arm comes to rest or goes on, on its ramp; afterwards nothing is left of it."""
    rate, fresh = (made(PANDA, task, limits=limits, qdd_max=5.0, null_space="limits") for _ in range(2))
    pose = PANDA.forward_kinematics(HOME)
    target = target_at(pose, task, np.array([0.4, 0.0, 0.5]))
    twist, base, before = of_task(task, np.full(6, 0.1)), np.full(6, 0.01), np.zeros(7)
    for event, calls in spoiled(rate, task, target, bad).items():
        for call in calls:
            qd = call()
            assert event in rate.seen
            assert np.isfinite(qd).all()
            assert np.abs(qd - before).max() <= 5.0 * DT * (1.0 + 1e-9)
            before = qd
    for _ in range(1500):
        after, wanted = (one.step(HOME, twist, DT, base) for one in (rate, fresh))
    np.testing.assert_allclose(after, wanted, atol=1e-9)
    assert rate.seen == fresh.seen
