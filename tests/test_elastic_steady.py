"""Where the laws for elastic joints leave the arm: numbers known to 1e-4 degrees, solved at rest and integrated."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastic_arm as arm
import ravengc as rg
from ravengc import elastic
from ravengc.errors import ArgumentError, ConfigError, RavenGCError
from strategies import coordinates, robots

ROBOT = arm.two_links()
DRIVE = {"kd": arm.KD, "motor_inertia": arm.MOTORS, "joint_damping": arm.DAMPING}
PEAKS = {"desired": (31.28, 22.01), "biased": (32.94, 23.12), "quasi_static": (32.94, 23.12)}
"""Largest |u|, N m, from rest at q = 0."""


@pytest.fixture(scope="module")
def settled() -> tuple[np.ndarray, np.ndarray]:
    """The end of 25 s under all laws at once, by equations written out for this arm."""
    return arm.settled()


def test_the_arm_written_out_is_the_robot() -> None:
    q, qd, torque = np.array((0.3, -0.7)), np.array((1.5, -2.0)), np.array((3.0, -1.0))
    assert ROBOT.gravity_torque(q, arm.GRAVITY) == pytest.approx(arm.gravity_torque(q), abs=1e-13)
    found = ROBOT.forward_dynamics(q, qd, torque, rg.Gravity(*arm.GRAVITY))
    assert found == pytest.approx(arm.accelerations(q, qd, torque - arm.gravity_torque(q)), abs=1e-11)


@pytest.mark.parametrize("law", elastic.LAWS)
def test_errors_at_rest_are_as_known(law: str) -> None:
    found = elastic.steady_error(ROBOT, arm.STIFFNESS, arm.KP, arm.GOAL, arm.GRAVITY, law)
    assert np.rad2deg(found) == pytest.approx(arm.STEADY[law], abs=1e-4)


def test_integration_written_out_comes_to_rest_there(settled: tuple[np.ndarray, np.ndarray]) -> None:
    q, peak = settled
    found = elastic.steady_errors(ROBOT, arm.STIFFNESS, arm.KP, arm.GOAL, arm.GRAVITY)
    assert tuple(found) == tuple(arm.STEADY)
    assert np.rad2deg(q - arm.GOAL) == pytest.approx(np.rad2deg(list(found.values())), abs=1e-6)
    for law, largest in PEAKS.items():
        assert peak[list(arm.STEADY).index(law)] == pytest.approx(largest, abs=5e-3)


@pytest.mark.parametrize("law", ["motor", "biased", "quasi_static", "link"])
def test_the_arm_settles_as_the_one_written_out(law: str, settled: tuple[np.ndarray, np.ndarray]) -> None:
    """Two programs for one run, step by step the same."""
    run = elastic.settle(ROBOT, arm.STIFFNESS, arm.KP, arm.GOAL, arm.GRAVITY, law, **DRIVE)
    which = list(arm.STEADY).index(law)
    assert run.q == pytest.approx(settled[0][which], abs=1e-9)
    assert run.peak == pytest.approx(settled[1][which], rel=1e-9)
    assert run.theta == pytest.approx(run.q + arm.gravity_torque(run.q) / arm.STIFFNESS, abs=1e-8)


@pytest.mark.parametrize(
    ("gains", "law", "degrees"),
    [
        (0.25, "desired", 0.0),
        (0.10, "desired", 15.4),
        (0.05, "desired", 30.4),
        (0.02, "desired", 43.5),
        (0.05, "biased", 0.0),
        (0.02, "quasi_static", 0.0),
    ],
)
def test_below_tomeis_bound_the_laws_differ(gains: float, law: str, degrees: float) -> None:
    """With a tenth of the gains, the law with g(q_d) finds another pose at rest; those that follow the arm do not."""
    run = elastic.settle(ROBOT, arm.STIFFNESS, gains * arm.KP, arm.GOAL, arm.GRAVITY, law, **DRIVE, seconds=60.0)
    assert np.rad2deg(np.abs(run.q - arm.GOAL).max()) == pytest.approx(degrees, abs=0.05)
    condition = elastic.condition_for(law, arm.STIFFNESS, arm.ALPHA, gains * arm.KP)
    assert condition.holds == (law == "quasi_static")


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_laws_that_promise_it_leave_no_error(data: st.DataObject) -> None:
    """Any arm, any gravity, stiff springs and strong gains: the links rest at the goal, but for the laws that err."""
    spec = data.draw(robots(most=5, coupled=False))
    robot = rg.Robot(spec)
    q = data.draw(coordinates(spec))
    gravity = data.draw(st.tuples(*[st.floats(-10.0, 10.0)] * 3))
    stiff = np.abs(robot.gravity_stiffness(q, gravity)).max() + np.abs(robot.gravity_torque(q, gravity)).max() + 1.0
    springs, gains = np.full(robot.n, 1e3 * stiff), np.full(robot.n, 5e2 * stiff)
    for law in ("desired", "biased", "quasi_static", "link"):
        assert np.abs(elastic.steady_error(robot, springs, gains, q, gravity, law)).max() <= 1e-9
    beside = elastic.steady_error(robot, springs, gains, q, gravity, "pd_aimed")
    wanted = robot.gravity_torque(q, gravity) / gains
    assert np.abs(beside + wanted).max() <= 0.1 * np.abs(wanted).max() + 1e-9


def test_coupled_springs_and_gains_are_matrices() -> None:
    springs = np.array(((100.0, 20.0), (20.0, 80.0)))
    found = elastic.steady_error(ROBOT, springs, np.diag(arm.KP), arm.GOAL, arm.GRAVITY, "pd_aimed")
    run = elastic.settle(ROBOT, springs, np.diag(arm.KP), arm.GOAL, arm.GRAVITY, "pd_aimed", **DRIVE)
    assert run.q - arm.GOAL == pytest.approx(found, abs=1e-8)


def test_where_there_is_no_rest_near_the_goal_there_is_no_number() -> None:
    weak = elastic.steady_error(ROBOT, arm.STIFFNESS, 1e-9 * arm.KP, arm.GOAL, arm.GRAVITY, "rigid_desired")
    assert np.isfinite(weak).all() or np.isnan(weak).all()
    with pytest.raises(ArgumentError, match="stiffness is infinite for a joint"):
        elastic.settle(ROBOT, [np.inf, 1.0], arm.KP, arm.GOAL, arm.GRAVITY, "pd", **DRIVE)


def test_rigid_joints_rest_where_pd_alone_leaves_them() -> None:
    error = elastic.steady_error(ROBOT, [np.inf, np.inf], 1e6 * arm.KP, arm.GOAL, arm.GRAVITY, "pd")
    assert error == pytest.approx(-arm.gravity_torque(arm.GOAL) / (1e6 * arm.KP), rel=1e-4)


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        ({"law": "biasd"}, ConfigError, "law 'biasd' is unknown.*did you mean 'biased'"),
        ({"kp": [1.0]}, ConfigError, r"kp has shape \(1,\); expected 2 numbers or \(2, 2\)"),
        ({"kp": [1.0, -2.0]}, ConfigError, "kp is .*; expected positive numbers"),
        ({"gravity": (0.0, np.nan, 0.0)}, ArgumentError, "gravity must be 3 finite numbers"),
        ({"kd": [-1.0, 1.0]}, ArgumentError, "kd and joint_damping not negative"),
        ({"motor_inertia": [0.0, 1.0]}, ArgumentError, "motor_inertia must be positive"),
        ({"seconds": -1.0}, ArgumentError, "seconds is -1.0, step_s 0.005; expected"),
        ({"start": [1.0]}, ArgumentError, "start must be 2 finite numbers"),
    ],
)
def test_what_cannot_be_meant_is_refused(change: dict[str, object], kind: type[RavenGCError], message: str) -> None:
    given = {"robot": ROBOT, "stiffness": arm.STIFFNESS, "kp": arm.KP, "q_desired": arm.GOAL, "gravity": arm.GRAVITY}
    with pytest.raises(kind, match=message):
        elastic.settle(**{**given, "law": "pd", **DRIVE, **change})
