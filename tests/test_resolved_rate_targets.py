"""Resolved rate towards targets that move, on bases that move, and through trocars."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc as rg
from rate_arms import DT, FREE, HOME, PANDA, TROCAR, made, rotation_about, target_at
from ravengc.reference import resolved_rate as ref
from ravengc.resolved_rate import TASKS, ResolvedRate, turning_about

twists = st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6).map(np.array)


@pytest.mark.parametrize("task", TASKS)
def test_a_still_target_is_held_exactly(task: str) -> None:
    pose = PANDA.forward_kinematics(HOME)
    target = target_at(pose, task, pose[:3, 3] - 0.2 * pose[:3, 2])
    assert np.abs(made(PANDA, task).track(HOME, target, DT)).max() < 1e-12


def walk(rate: ResolvedRate, q: np.ndarray, target: np.ndarray, steps: int = 2000) -> np.ndarray:
    for _ in range(steps):
        q = q + DT * rate.track(q, target, DT)
    return q


@pytest.mark.parametrize("angle", [0.05, 0.3, 1.0, 1.6])
def test_poses_are_reached(angle: float) -> None:
    q = HOME + angle * np.array((0.3, -0.2, 0.3, 0.2, 0.5, 0.3, -1.0))
    target = PANDA.forward_kinematics(q)
    reached = PANDA.forward_kinematics(walk(made(PANDA, gain=20.0, q_min=-np.inf, q_max=np.inf), HOME, target))
    np.testing.assert_allclose(reached, target, atol=1e-9)


@given(twists)
@settings(max_examples=50, deadline=None)
def test_orientation_errors_are_logarithms(turn: np.ndarray) -> None:
    vector = turn[3:] * 2.2
    angle = float(np.linalg.norm(vector))
    target = PANDA.forward_kinematics(HOME)
    if not 1e-9 < angle < math.pi - 1e-6:
        return
    K = np.cross(np.eye(3), vector / angle)
    R = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
    np.testing.assert_allclose(ref.rotation_vector(R), vector, atol=1e-7)
    target[:3, :3] = R @ target[:3, :3]
    rate = made(PANDA, gain=10.0, turning_gain=10.0, **FREE)
    done = PANDA.jacobian(HOME) @ rate.track(HOME, target, DT)
    np.testing.assert_allclose(done[3:], 10.0 * vector, atol=1e-7)


def test_opposed_targets_are_left() -> None:
    pose = PANDA.forward_kinematics(HOME)
    target = np.concatenate([pose[:3, 3], pose[:3, 2]])  # the outward normal along the axis: to be turned by pi
    rate = made(PANDA, "pointing", **FREE)
    assert np.isfinite(qd := rate.track(HOME, target, DT)).all()
    assert qd.any()
    assert "opposed" in rate.seen
    half = pose.copy()
    half[:3, 1:3] *= -1.0  # turned by pi about its own x
    turned = PANDA.jacobian(HOME) @ made(PANDA, gain=1.0, turning_gain=1.0, **FREE).track(HOME, half, DT)
    np.testing.assert_allclose(np.linalg.norm(turned[3:]), math.pi, rtol=1e-9)


def test_straight_lines_stay_straight() -> None:
    rate, q = made(PANDA, midpoint=True), HOME.copy()
    start = PANDA.forward_kinematics(q)
    way, worst = np.array((0.0, 0.2, 0.0)), 0.0
    for cycle in range(2000):
        q = q + DT * rate.step(q, np.concatenate([way / 2.0, np.zeros(3)]), DT)
        wanted = start[:3, 3] + way * (cycle + 1) / 2000
        worst = max(worst, np.linalg.norm(PANDA.forward_kinematics(q)[:3, 3] - wanted))
    assert worst < 1e-5
    np.testing.assert_allclose(PANDA.forward_kinematics(q)[:3, :3], start[:3, :3], atol=1e-5)


def rocked(rate: ResolvedRate, robot: rg.Robot, start: np.ndarray, task: str, degrees: float, height: float) -> float:
    """How far the tool gets from where it was in the world, m.

    The base rocks at 1 Hz about a pivot at that height; its gyroscope is read once per cycle, nothing is known ahead.
    """
    axis, pivot = np.array((1.0, 0.5, 0.0)) / math.sqrt(1.25), np.array((0.0, 0.0, height))
    swing = math.radians(degrees)

    def base(t: float) -> tuple[np.ndarray, np.ndarray]:
        """B in the world, and its angular velocity in its own axes."""
        R = rotation_about(axis, swing * math.sin(2.0 * math.pi * t))
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = R, pivot - R @ pivot
        return pose, axis * swing * 2.0 * math.pi * math.cos(2.0 * math.pi * t)

    q, worst = start.copy(), 0.0
    held = base(0.0)[0] @ robot.forward_kinematics(q)
    for cycle in range(2000):
        pose, w = base(cycle * DT)
        target = np.linalg.inv(pose) @ held
        target = target if task == "twist" else target[:3, 3].copy()
        q = q + DT * rate.track(q, target, DT, base_twist=turning_about(pivot, w))
        tool = base((cycle + 1) * DT)[0] @ robot.forward_kinematics(q)
        worst = max(worst, float(np.linalg.norm(tool[:3, 3] - held[:3, 3])))
    return worst


@pytest.mark.parametrize("degrees", [10.0, 20.0])
@pytest.mark.parametrize("task", ["twist", "position"])
def test_a_tool_stays_in_the_world_while_its_base_rocks(task: str, degrees: float) -> None:
    """An arm without limits that matter, 0.5 m above the pivot."""
    rate = made(PANDA, task, gain=200.0, q_min=-np.inf, q_max=np.inf, qd_max=10.0)
    assert rocked(rate, PANDA, HOME, task, degrees, -0.5) < 1e-4


@pytest.mark.parametrize(
    ("name", "start", "task", "degrees", "height"),
    [
        ("panda", HOME, "twist", 10.0, -0.5),
        ("panda", HOME, "position", 20.0, 0.0),
        ("ur5", np.array((0.0, -1.2, 1.6, -1.9, -1.5, 0.0)), "twist", 20.0, -0.5),
        ("ur5", np.array((0.0, -1.2, 1.6, -1.9, -1.5, 0.0)), "position", 20.0, -0.5),
    ],
)
def test_an_arm_with_its_own_limits_holds_its_tool_while_its_base_rocks(
    name: str, start: np.ndarray, task: str, degrees: float, height: float
) -> None:
    """Where it is fast enough for that; where it is not, the joint that is too slow is named."""
    robot = rg.load(name)
    rate = made(robot, task, gain=200.0)
    assert rocked(rate, robot, start, task, degrees, height) < 1e-4
    assert not rate.since, rate.reason


def test_a_base_that_rocks_faster_than_the_arm_can_is_said() -> None:
    rate = made(PANDA, gain=200.0)
    assert rocked(rate, PANDA, HOME, "twist", 20.0, -0.5) > 0.01
    assert {"velocity_limit", "position_limit"} & set(rate.since)


@pytest.mark.parametrize("breathes", [False, True])
def test_the_shaft_stays_in_its_trocar(breathes: bool) -> None:
    robot = rg.load("panda")
    robot.set_tool(np.eye(3), (0.0, 0.0, 0.45))
    q = HOME.copy()
    pose = robot.forward_kinematics(q)
    tip, rest = pose[:3, 3], pose[:3, 3] - 0.15 * pose[:3, 2]

    def trocar(t: float) -> tuple[np.ndarray, np.ndarray]:
        w, size = 2.0 * math.pi / 4.0, 0.0025 * breathes
        return rest + size * np.array((0, 0, 1.0 - math.cos(w * t))), size * w * np.array((0, 0, math.sin(w * t)))

    def circle(t: float) -> tuple[np.ndarray, np.ndarray]:
        w = 2.0 * math.pi / 4.0
        return (
            tip + 0.015 * np.array((math.cos(w * t) - 1.0, math.sin(w * t), 0.0)),
            0.015 * w * np.array((-math.sin(w * t), math.cos(w * t), 0.0)),
        )

    rate, worst = ResolvedRate(robot, "remote_centre", remote_centre=rest, gain=50.0, midpoint=True), [0.0, 0.0]
    for cycle in range(4000):
        (at, u), (goal, v) = trocar(cycle * DT), circle(cycle * DT)
        q = q + DT * rate.track(q, np.concatenate([goal, at]), DT, np.concatenate([v, u]))
        pose, at, goal = robot.forward_kinematics(q), trocar((cycle + 1) * DT)[0], circle((cycle + 1) * DT)[0]
        beside = np.linalg.norm(np.cross(at - pose[:3, 3], pose[:3, 2]))
        worst = np.maximum(worst, (beside, np.linalg.norm(pose[:3, 3] - goal)))
    assert max(worst) < 1e-5, worst


def test_directions_without_length_hold_the_tool() -> None:
    rate = made(PANDA, "pointing")
    assert not rate.track(HOME, np.concatenate([TROCAR, np.zeros(3)]), DT).any()
    assert rate.seen == ("target",)
