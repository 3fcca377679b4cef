"""The positions, goals and programmes that all compute."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, sqrt
from typing import TYPE_CHECKING

import numpy as np

import ravengc as rg
from comparison.arm import SAMPLES, Arm, Array, panda
from ravengc.reference.box_qp import Programme

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

GAIN = 10.0
"""Of the pose error, per second."""

SPREAD = 0.25
"""How far the goals are in each joint at most, rad: half of the steps then want more than some joint's rate."""

ROUND = 16
"""Steps in which the goal of a path comes near and goes again."""

DT = 1e-3
DAMPING = 0.04


@dataclass(frozen=True)
class Scene:
    """Panda: ``q`` (n,) within its limits, ``goal`` (4, 4) near by, and the ``programme`` of each step's rates."""

    operation: str
    arm: Arm
    robot: rg.Robot
    q: list[Array]
    goal: list[Array]
    programme: list[Programme]
    rate: Array

    @property
    def spec(self) -> RobotSpec:
        return self.robot.spec


def along_a_path() -> Scene:
    """A control loop's: each pose a millisecond after the one before, each second half of a round held by a limit."""
    robot, random = rg.load("panda"), np.random.default_rng(3)
    lower, upper, rate = limits(robot)
    start, qd, ahead = (
        random.uniform(lower + 0.3, upper - 0.3),
        random.uniform(-1, 1, len(rate)),
        random.choice([-1, 1], len(rate)),
    )
    q = [start + DT * k * qd for k in range(SAMPLES)]
    far = [SPREAD * (1.0 - 0.9 * np.cos(2.0 * np.pi * k / ROUND)) for k in range(SAMPLES)]
    return made("step", robot, q, [robot.forward_kinematics(at + s * ahead) for at, s in zip(q, far, strict=True)])


def anywhere() -> Scene:
    """Poses drawn at random, which no step can expect from the one before; in about half, a limit holds a joint."""
    robot, random = rg.load("panda"), np.random.default_rng(3)
    lower, upper, rate = limits(robot)
    q = [random.uniform(lower + 0.2, upper - 0.2) for _ in range(SAMPLES)]
    goal = [robot.forward_kinematics(at + random.uniform(-SPREAD, SPREAD, len(rate))) for at in q]
    return made("jump", robot, q, goal)


def limits(robot: rg.Robot) -> tuple[Array, Array, Array]:
    """Lower and upper ends of the joints' travel, and their largest rates, each (n,)."""
    found = robot.spec.coordinate_limits
    lower, upper, rate = (
        np.array([getattr(one, side) for one in found], float) for side in ("lower", "upper", "velocity")
    )
    return lower, upper, rate


def made(operation: str, robot: rg.Robot, q: list[Array], goal: list[Array]) -> Scene:
    """The scene of these steps, with the programme of each."""
    rate = limits(robot)[2]
    programme = [
        Programme(
            rows=robot.jacobian(at),
            target=GAIN * pose_error(robot.forward_kinematics(at), there),
            row_weight=np.ones(6),
            wish=np.zeros(len(at)),
            weight=np.full(len(at), DAMPING**2),
            lower=-rate,
            upper=rate,
        )
        for at, there in zip(q, goal, strict=True)
    ]
    return Scene(operation, panda(), robot, q, goal, programme, rate)


def pose_error(now: Array, goal: Array) -> Array:
    """Displacement, then the rotation vector, in base axes."""
    turn = goal[:3, :3] @ now[:3, :3].T
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    twice_sine = sqrt(float(axis @ axis))
    scale = atan2(twice_sine, float(np.trace(turn)) - 1.0) / twice_sine if twice_sine > 1e-12 else 0.5
    return np.concatenate([goal[:3, 3] - now[:3, 3], scale * axis])


def damped(rows: Array, v: Array) -> Array:
    """Jᵀ (J Jᵀ + λ² 1)⁻¹ v."""
    found: Array = rows.T @ np.linalg.solve(rows @ rows.T + DAMPING**2 * np.eye(6), v)
    return found
