"""Theorems of resolved-rate motion, and the core against the reference by singular values."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc as rg
from rate_arms import DT, FREE, HOME, PANDA, made, of_task, truth
from ravengc.reference import resolved_rate as ref
from ravengc.resolved_rate import LIMITS, NULL_SPACES, TASKS
from strategies import Case, cases

agreement = settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
numbers = st.floats(-2.0, 2.0)
twists = st.lists(numbers, min_size=6, max_size=6).map(np.array)


@pytest.mark.parametrize("task", TASKS)
@agreement
@given(cases(), twists, twists)
def test_the_task_is_done_exactly_away_from_singularities(
    task: str, case: Case, twist: np.ndarray, base: np.ndarray
) -> None:
    robot, q = rg.Robot(case.spec), case.q
    wanted = truth(robot, q, of_task(task, twist), task, base)
    singular = np.linalg.svd(wanted.J, compute_uv=False)
    rate = made(robot, task, **FREE)
    qd = rate.step(q, of_task(task, twist), DT, base)
    assert np.isfinite(qd).all()
    size = 1.0 + np.abs(wanted.v).max() + np.abs(wanted.J).max()
    if singular[-1] > 0.0401 * max(1.0, 1e-5 * singular[0]):
        assert rate.damping_used == 0.0
        best = np.linalg.lstsq(wanted.J, wanted.v, rcond=None)[0]
        np.testing.assert_allclose(qd, best, atol=1e-10 * size * (singular[0] / singular[-1]) ** 2)
        for _ in range(20):  # it is tracked: one step shows what lies near it too
            rate.step(q, of_task(task, twist), DT, base)
        np.testing.assert_allclose(rate.sigma_min, singular[-1], rtol=0.01)
    else:
        assert np.linalg.norm(wanted.J @ qd) <= np.linalg.norm(wanted.v) * (1.0 + 1e-6)


@pytest.mark.parametrize("task", TASKS)
def test_the_task_is_exact_to_ten_digits_on_a_real_arm(task: str) -> None:
    random = np.random.default_rng(0)
    rate, worst = made(PANDA, task, **FREE), 0.0
    for _ in range(500):
        q = HOME + random.uniform(-0.5, 0.5, 7)
        wanted = truth(PANDA, q, twist := of_task(task, random.standard_normal(6)), task)
        if np.linalg.svd(wanted.J, compute_uv=False)[-1] > 0.05:
            worst = max(worst, np.abs(wanted.J @ rate.step(q, twist, DT) - wanted.v).max())
    assert worst < 1e-10


@pytest.mark.parametrize("damping", ["constant", "manipulability", "adaptive", "filtered"])
def test_damping_is_that_of_the_singular_values_once_tracked(damping: str) -> None:
    random = np.random.default_rng(1)
    rate = made(PANDA, damping=damping, **FREE)
    for _ in range(200):
        q, twist = HOME + random.uniform(-1.5, 1.5, 7), random.standard_normal(6)
        for _ in range(30):
            qd = rate.step(q, twist, DT)
        wanted = truth(PANDA, q, twist, "twist")
        inverse = ref.damped_inverse(wanted.J, damping)
        expected = inverse.matrix @ wanted.v
        np.testing.assert_allclose(rate.damping_used, inverse.damping, atol=4e-4)
        np.testing.assert_allclose(qd, expected, atol=0.02 * np.abs(expected).max())


def test_selective_damping_is_that_of_the_singular_vectors() -> None:
    random = np.random.default_rng(2)
    rate = made(PANDA, damping="selective", qd_max=np.full(7, 2.0), q_min=-np.inf, q_max=np.inf)
    for _ in range(200):
        q, twist = random.uniform(-2.0, 2.0, 7), 0.3 * random.standard_normal(6)
        wanted = truth(PANDA, q, twist, "twist")
        expected = ref.shortened(ref.selectively_damped(wanted.J, wanted.v, 2.0), 2.0)
        np.testing.assert_allclose(rate.step(q, twist, DT), expected, atol=1e-7)


@pytest.mark.parametrize("null_space", NULL_SPACES)
@pytest.mark.parametrize("task", ["twist", "position", "pointing"])
def test_null_motion_leaves_the_task_still(task: str, null_space: str) -> None:
    random = np.random.default_rng(5)
    options: dict[str, Any] = {"posture": HOME + 0.3} if null_space == "posture" else {}
    rate = made(PANDA, task, null_space=null_space, **options, **(FREE if null_space != "limits" else {}))
    for _ in range(100):
        q = HOME + random.uniform(-0.4, 0.4, 7)
        qd = rate.step(q, np.zeros(3 if task == "position" else 6), DT)
        assert np.abs(truth(PANDA, q, np.zeros(6), task).J @ qd).max() < 1e-12
        assert (null_space == "none") == (not qd.any())


def test_null_motion_goes_where_it_should() -> None:
    def run(start: np.ndarray, **options: Any) -> np.ndarray:
        rate, q = made(PANDA, "position", **options), start.copy()
        for _ in range(3000):
            q = q + DT * rate.step(q, np.zeros(3), DT)
        return q

    def manipulability(q: np.ndarray) -> float:
        return math.sqrt(np.linalg.det((J := PANDA.jacobian(q)[:3]) @ J.T))

    posture = HOME + np.array((0.2, 0.0, -0.2, 0.1, 0.1, 0.0, 0.3))
    assert np.linalg.norm(run(HOME, null_space="posture", posture=posture) - posture) < np.linalg.norm(HOME - posture)
    start = HOME + np.array((0.4, 0.3, 0.5, 0.2, 0.4, 0.3, 0.0))
    assert manipulability(run(start, null_space="manipulability")) > 1.1 * manipulability(start)


def test_a_slowed_twist_keeps_its_direction() -> None:
    rate, random = made(PANDA), np.random.default_rng(6)
    for _ in range(100):
        q, twist = HOME + random.uniform(-0.4, 0.4, 7), 20.0 * random.standard_normal(6)
        done = PANDA.jacobian(q) @ rate.step(q, twist, DT)
        if rate.damping_used == 0.0:
            np.testing.assert_allclose(done, rate.scale * twist, atol=1e-9)
            assert rate.scale < 1.0
            assert rate.limiting_joint is not None
            assert PANDA.joint_names[rate.limiting_joint] in rate.reason


def test_least_squares_within_limits_do_no_less_than_slowing_down() -> None:
    random = np.random.default_rng(7)
    slowed, bent = made(PANDA), made(PANDA, limits="qp")
    for _ in range(200):
        q, twist = HOME + random.uniform(-0.4, 0.4, 7), 3.0 * random.standard_normal(6)
        J = PANDA.jacobian(q)
        left = [np.linalg.norm(J @ rate.step(q, twist, DT) - twist) for rate in (slowed, bent)]
        assert left[1] <= left[0] * (1.0 + 1e-6) + 1e-6


def test_all_joints_at_their_limits_are_named() -> None:
    rate, most = made(PANDA, limits="qp"), np.array([limit.velocity for limit in PANDA.spec.coordinate_limits])
    qd = rate.step(HOME, np.array((1.0, 2.0, -1.0, 3.0, 0.0, 1.0)), DT)
    standing = np.flatnonzero(np.isclose(np.abs(qd), most)).tolist()
    assert len(standing) > 1
    assert rate.limited_joints == tuple(standing)
    assert rate.limiting_joint in standing
    *some, last = (repr(PANDA.joint_names[joint]) for joint in standing)
    assert f"{', '.join(some)} and {last} at their velocity limits: " in rate.reason
    rate.step(HOME, np.zeros(6), DT)
    assert (rate.limited_joints, rate.limiting_joint, rate.reason) == ((), None, "")


@pytest.mark.parametrize("limits", LIMITS)
def test_every_joint_that_is_named_stands_at_a_limit(limits: str) -> None:
    lower, upper = (np.array([getattr(x, side) for x in PANDA.spec.coordinate_limits]) for side in ("lower", "upper"))
    most = np.array([limit.velocity for limit in PANDA.spec.coordinate_limits])
    rate, random, found = made(PANDA, limits=limits), np.random.default_rng(10), set[str | None]()
    for _ in range(500):
        q = np.where(
            random.random(7) < 0.2, np.where(random.random(7) < 0.5, lower, upper), random.uniform(lower, upper)
        )
        qd = rate.step(q, random.standard_normal(6) * 10.0 ** random.uniform(-2, 2), DT)
        bound = np.minimum(most, 20.0 * np.maximum(np.where(qd > 0.0, upper - q, q - lower), 0.0))
        still = (qd == 0.0) & ((q == lower) | (q == upper))
        stands = (np.abs(qd) >= bound * (1.0 - 1e-9)) | still
        assert all(stands[joint] for joint in rate.limited_joints), rate.reason
        assert (rate.limiting_joint is None) == (not rate.limited_joints)
        assert rate.limiting_joint is None or rate.limiting_joint in rate.limited_joints
        found.add(rate.limit)
    assert found >= {"velocity", "position"}


def test_what_too_few_joints_leave_undone_is_said() -> None:
    robot, q = rg.load("raven2_gold"), np.array((0.5, 1.5, 0.4))
    rate, J = made(robot), robot.jacobian(q)
    rate.step(q, J @ np.array((0.02, -0.01, 0.01)), DT)
    assert rate.reason == ""
    rate.step(q, np.array((0.01, 0.02, -0.01, 0.03, 0.0, 0.01)), DT)
    assert rate.seen == ("undone",)
    assert "6 rows, the arm 3 coordinates" in rate.reason
    target = robot.forward_kinematics(q)
    rate.track(q, target, DT)
    assert rate.reason == ""
    target[:3, 3] += (0.02, 0.0, 0.01)
    for _ in range(3000):
        q = q + DT * rate.track(q, target, DT)
    assert np.abs(robot.forward_kinematics(q) - target).max() > 0.01
    assert "undone" in rate.seen
    reached = made(robot, "position")
    reached.step(q, np.array((0.01, 0.02, -0.01)), DT)
    assert reached.reason == ""


def test_a_motion_that_is_stopped_as_a_whole_says_what_would_go_on() -> None:
    q = HOME.copy()
    q[3] = PANDA.spec.coordinate_limits[3].upper
    twist = PANDA.jacobian(q) @ np.array((0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0))
    slowed, bent = made(PANDA), made(PANDA, limits="qp")
    assert not slowed.step(q, twist, DT).any()
    assert "0.0 % of the task (limits='qp' lets the other joints go on)" in slowed.reason
    assert bent.step(q, twist, DT).any()
    assert "limits='qp'" not in bent.reason


@pytest.mark.parametrize("limits", LIMITS)
def test_positions_stay_within_their_limits(limits: str) -> None:
    lower, upper = (np.array([getattr(x, side) for x in PANDA.spec.coordinate_limits]) for side in ("lower", "upper"))
    random = np.random.default_rng(8)
    rate, q = made(PANDA, limits=limits, qdd_max=50.0), HOME.copy()
    before = np.zeros(7)
    for cycle in range(6000):
        if cycle % 400 == 0:
            twist = random.standard_normal(6)
        qd = rate.step(q, twist, DT)
        assert np.abs(qd - before).max() <= 50.0 * DT * (1.0 + 1e-9), rate.reason
        before = qd
        q = q + DT * qd
        assert (q >= lower - 1e-12).all()
        assert (q <= upper + 1e-12).all()


def test_joints_beyond_a_limit_are_led_back() -> None:
    q = HOME.copy()
    q[3] = 0.1  # the limit is -0.0698
    rate = made(PANDA, limits="qp")
    for _ in range(1000):
        q = q + DT * rate.step(q, np.zeros(6), DT)
    assert q[3] <= -0.0697
    assert "position_limit" in rate.since


def test_a_step_in_the_twist_becomes_a_ramp() -> None:
    twist = np.array((0.3, -0.2, 0.1, 0.5, 0.0, 0.2))
    rate, q, done = made(PANDA, qdd_max=5.0, **FREE), HOME.copy(), np.zeros(6)
    before, J = np.zeros(7), PANDA.jacobian(HOME)
    for cycle in range(1200):
        wanted = twist if cycle < 400 else -twist
        qd = rate.step(q, wanted, DT)
        assert np.abs(qd - before).max() <= 5.0 * DT * (1.0 + 1e-9)
        before, done = qd, J @ qd
        assert np.linalg.norm(done - twist * (done @ twist) / (twist @ twist)) < 1e-10  # always along the twist
    np.testing.assert_allclose(done, -twist, atol=1e-10)


def test_jerk_is_limited_and_the_goal_is_not_overshot() -> None:
    rate = made(PANDA, qdd_max=5.0, qddd_max=200.0, **FREE)
    twist, past = np.array((0.3, -0.2, 0.1, 0.5, 0.0, 0.2)), [np.zeros(7), np.zeros(7)]
    goal = np.linalg.pinv(PANDA.jacobian(HOME)) @ twist
    past.extend(rate.step(HOME, twist, DT) for _ in range(600))
    rates = np.array(past)
    assert np.abs(np.diff(rates, axis=0)).max() <= 5.0 * DT * (1.0 + 1e-9)
    assert np.abs(np.diff(rates, 2, axis=0)).max() <= 200.0 * DT**2 * (1.0 + 1e-6)
    assert (np.abs(rates) <= np.abs(goal) * (1.0 + 1e-9) + 1e-12).all()
    np.testing.assert_allclose(rates[-1], goal, atol=1e-9)


def test_rows_of_a_twist_can_be_left_free() -> None:
    rate = made(PANDA, rows=[True, True, False, False, False, True], **FREE)
    twist = np.array((0.1, 0.2, 9.0, 9.0, 9.0, 0.3))
    done = PANDA.jacobian(HOME) @ rate.step(HOME, twist, DT)
    np.testing.assert_allclose(done[[0, 1, 5]], twist[[0, 1, 5]], atol=1e-12)
