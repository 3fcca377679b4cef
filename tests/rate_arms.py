"""What the tests of resolved rate share: an arm, poses of it, and the task by the reference."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import ravengc as rg
from ravengc.reference import resolved_rate as ref
from ravengc.resolved_rate import ResolvedRate

DT = 1e-3
PANDA = rg.load("panda")
HOME = np.array((0.0, 0.2, 0.0, -2.1, 0.0, 2.3, math.pi / 4))
TROCAR = (0.4, 0.0, 0.5)
FREE: dict[str, Any] = {"qd_max": np.inf, "q_min": -np.inf, "q_max": np.inf}
SINGULAR = [
    np.zeros(7), np.array((0, 0, 0, -0.07, 0, 0, 0)), np.array((0, 0.2, 0, -2.1, 0, 0, 0)),
    np.array((0, math.pi / 2, 0, 0, 0, 0, 0)), np.full(7, math.pi / 2),
    np.array((0, 0, 0, -math.pi / 2, 0, math.pi / 2, 0)),
]  # fmt: skip


def made(robot: rg.Robot, task: str = "twist", **options: Any) -> ResolvedRate:
    """Resolved rate with a trocar where the task has one."""
    given = {"remote_centre": TROCAR} if task == "remote_centre" else {}
    return ResolvedRate(robot, task, **(given | options))


def of_task(task: str, twist: np.ndarray) -> np.ndarray:
    """As many numbers as the task's twist has."""
    return twist[:3].copy() if task == "position" else twist


def truth(robot: rg.Robot, q: np.ndarray, twist: np.ndarray, task: str, base: np.ndarray | None = None) -> ref.Task:
    return ref.task(robot.spec, q, twist, task, base_twist=base, remote_centre=TROCAR)


def target_at(pose: np.ndarray, task: str, trocar: np.ndarray) -> np.ndarray:
    """The target of a task at which the tool is already, with this pose (4, 4)."""
    tip, axis = pose[:3, 3], pose[:3, 2]
    return {
        "twist": pose,
        "position": tip,
        "pointing": np.concatenate([tip, -axis]),
        "remote_centre": np.concatenate([tip, trocar]),
    }[task]


def rotation_about(axis: np.ndarray, angle: float) -> np.ndarray:
    K = np.cross(np.eye(3), axis)
    return np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
