"""Resolved rate where things go wrong: bounded rates, a status, never a jump; what cannot be meant is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import ravengc as rg
from rate_arms import DT, FREE, HOME, PANDA, SINGULAR, TROCAR, made, of_task, truth
from ravengc.errors import ArgumentError, ConfigError, LimitError
from ravengc.resolved_rate import DAMPINGS, LIMITS, RATE_EVENTS, TASKS, ResolvedRate


@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("task", TASKS)
def test_rates_are_within_limits_wherever_the_arm_is(task: str, damping: str, limits: str) -> None:
    if limits == "manipulability" and task == "remote_centre":
        pytest.skip("refused at construction")
    rate = made(PANDA, task, damping=damping, limits=limits)
    most = np.array([limit.velocity for limit in PANDA.spec.coordinate_limits])
    random = np.random.default_rng(3)
    poses = [*SINGULAR, *random.uniform(-3.0, 3.0, (300, 7))]
    for q in poses:
        for size in (1.0, 1e4):
            qd = rate.step(q, of_task(task, size * random.standard_normal(6)), DT)
            assert (np.abs(qd) <= most).all(), rate.reason


@pytest.mark.parametrize("name", ["raven2_gold", "rrbot", "dvrk_psm_si", "dvrk_psm", "pa10"])
@pytest.mark.parametrize("task", ["twist", "position"])
def test_small_coupled_and_sliding_arms_are_bounded_too(name: str, task: str) -> None:
    robot, random = rg.load(name), np.random.default_rng(4)
    rate = made(robot, task, qd_max=3.0, q_min=-np.inf, q_max=np.inf)
    for _ in range(300):
        q, own = random.uniform(-3.0, 3.0, robot.n), random.standard_normal(robot.n)
        twist = of_task(task, robot.jacobian(q) @ own)
        qd = rate.step(q, twist, DT)
        assert (np.abs(qd) <= 3.0).all()
        wanted = truth(robot, q, twist, task)
        if np.linalg.svd(wanted.J, compute_uv=False)[-1] > 0.041 and rate.scale == 1.0:
            np.testing.assert_allclose(wanted.J @ qd, wanted.v, atol=1e-9)


BAD = [np.nan, np.inf, -np.inf, 1e300]


@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("bad", BAD)
def test_bad_numbers_stop_the_arm_on_a_ramp(bad: float, limits: str) -> None:
    twist, target = np.full(6, 0.1), PANDA.forward_kinematics(HOME)
    rate = made(PANDA, qdd_max=5.0, limits=limits)
    for _ in range(100):
        before = rate.step(HOME, twist, DT)
    broken = {
        name: np.array(x, float) for name, x in {"q": HOME, "twist": twist, "base": twist, "target": target}.items()
    }
    for x in broken.values():
        x.flat[0] = bad
    for call in (
        lambda: rate.step(broken["q"], twist, DT),
        lambda: rate.step(HOME, broken["twist"], DT),
        lambda: rate.step(HOME, twist, DT, broken["base"]),
        lambda: rate.step(HOME, twist, bad),
        lambda: rate.step(HOME, twist, 0.0),
        lambda: rate.track(HOME, broken["target"], DT),
        lambda: rate.track(HOME, target, DT, broken["twist"]),
        lambda: rate.track(HOME, np.zeros((4, 4)), DT),
    ):
        rate.acknowledge()
        qd = call()
        assert np.abs(qd - before).max() <= 5.0 * DT * (1.0 + 1e-9)
        before = qd
        assert np.isfinite(rate.sigma_min)
        assert rate.status >> 32
    rate.reset()
    assert np.isfinite(rate.step(HOME, twist, DT)).all()
    assert rate.counters["cycles"] == 109


@pytest.mark.parametrize(
    ("options", "error", "match"),
    [
        ({"task": "twists"}, ConfigError, "twist"),
        ({"damping": "none"}, ConfigError, "adaptive"),
        ({"limits": "clip"}, ConfigError, "scale"),
        ({"task": "remote_centre"}, ArgumentError, "remote_centre is missing"),
        ({"null_space": "posture"}, ArgumentError, "posture is missing"),
        ({"qd_max": 0.0}, LimitError, "qd_max of 'panda_joint1' is 0.0"),
        ({"q_min": 1.0, "q_max": 1.0}, LimitError, "above q_min"),
        ({"gain": 2000.0}, ConfigError, "zero to rate_hz"),
        ({"eps": math.nan}, ConfigError, "eps is NaN"),
        ({"rows": [False] * 6}, ConfigError, "rows is false for all; it should be true for one to six of them"),
        ({"task": "position", "rows": [True] * 6}, ArgumentError, "rows is for task 'twist', not for 'position'"),
        ({"remote_centre": TROCAR}, ArgumentError, "remote_centre is for task 'remote_centre', not for 'twist'"),
        ({"null_space": "limits", "posture": HOME}, ArgumentError, "posture is for null_space 'posture', not"),
        ({"rows": [1, 0]}, ArgumentError, "six truth values"),
        ({"pointing_axis": (0, 0, 0)}, ConfigError, "not all zero"),
        ({"frame": "nowhere"}, ArgumentError, "nowhere"),
        (
            {"task": "remote_centre", "remote_centre": TROCAR, "limits": "manipulability"},
            ConfigError,
            "task is 'remote_centre'; it should be a whole twist",
        ),
        (
            {"rows": [True] * 5 + [False], "limits": "manipulability"},
            ConfigError,
            "task is 'twist' of 5 rows; it should",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(options: dict[str, Any], error: type[Exception], match: str) -> None:
    with pytest.raises(error, match=match):
        ResolvedRate(PANDA, **options)


def test_time_steps_of_the_wrong_kind_are_named() -> None:
    rate, q, out = made(PANDA), HOME.copy(), np.empty(7)
    wrong: Any = "a"
    for call in (
        lambda: rate.step(q, np.zeros(6), wrong),
        lambda: rate.track(q, np.eye(4), wrong),
        lambda: rate.bind(q=q, twist=np.zeros(6), out=out, dt=wrong),
    ):
        with pytest.raises(ArgumentError, match="dt is a str; expected a number, in s"):
            call()


def test_events_have_meanings() -> None:
    assert all(name.islower() and text for name, text in RATE_EVENTS.items())
    rate = made(PANDA, **FREE)
    rate.step(SINGULAR[0], np.full(6, 0.1), DT)
    assert "singular" in rate.seen
    assert "sigma_min" in rate.reason


def test_a_bound_cycle_gives_the_same_bits() -> None:
    pose, out, random = PANDA.forward_kinematics(HOME), np.empty(7), np.random.default_rng(9)
    one, other = made(PANDA), made(PANDA)
    q, target, moves, base = HOME.copy(), pose.copy(), np.zeros(6), np.zeros(6)
    cycle = one.bind(q=q, target=target, target_twist=moves, base_twist=base, out=out)
    for _ in range(50):
        q[:] = HOME + 0.1 * random.standard_normal(7)
        moves[:], base[:] = random.standard_normal((2, 6))
        cycle()
        np.testing.assert_array_equal(out, other.track(q, target, DT, moves, base))
    with pytest.raises(ArgumentError, match="either twist, or target"):
        one.bind(q=q, out=out)
    with pytest.raises(ArgumentError, match="shares memory"):
        one.bind(q=q, twist=moves, out=q)
