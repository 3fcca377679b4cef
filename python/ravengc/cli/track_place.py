"""Where ``ravengc track`` puts a cloud: where options say, or where it is, or before an arm that does not reach it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc.resolved_rate import ResolvedRate
from ravengc.targets.thinning import evenly
from ravengc.track.recording import limits_of
from ravengc.trajectory import swing_within_limits

if TYPE_CHECKING:
    from collections.abc import Sequence

    import ravengc
    from ravengc.targets import Cloud

__all__ = ["placed", "posture"]

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

PLACE = (0.52, 0.0, 0.34)
"""Where a surface that the arm cannot reach is put (m) before an arm as long as a Panda with its tool."""
PANDA_REACH = 1.42
SAMPLE, LEAST_SHARE = 12, 0.75
RATE_HZ, STEPS = 200.0, 800
NEAR_M, NEAR_RAD = 0.005, 0.05
SPEED, TURNING = 0.5, 3.0
LEAST_FACING = 0.1
POSTURES, SHARE, WIDEST = 200, 0.5, 1.5
"""Tried as a start: so many, within this share of the ranges about their middle, and so many rad or m."""
GOOD = 0.5
"""A middle that leaves this share of the best one's freedom is the start."""


def placed(cloud: Cloud, robot: ravengc.Robot, start: Array, at: Vector | None, turn_deg: Vector | None) -> Cloud:
    """Return the cloud in base axes, with a note if it was put elsewhere than the file and the options say.

    ``start`` (n,) is where the joints begin. An arm reaches a cloud if it comes to three of four points of it. One that
    it does not reach is put before it, or else around the tool at the start.
    """
    turned = cloud.placed(turn_deg=turn_deg or (0.0, 0.0, 0.0))
    if at is not None:
        return turned.placed(at)
    if reaches(robot, start, turned):
        return turned
    before = _put(turned, length(robot) / PANDA_REACH * np.array(PLACE), (0.0, 0.0, 1.0), "face up", turn_deg)
    if reaches(robot, start, before):
        return before
    pose = robot.forward_kinematics(start)
    return _put(turned, pose[:3, 3], (-pose[:3, 2]).tolist(), "facing the tool at its start", turn_deg)


def _put(cloud: Cloud, place: Array, facing: Sequence[float], how: str, turn_deg: Vector | None) -> Cloud:
    """The cloud with its middle there and, unless options turn it, facing there."""
    turns = turn_deg is None and bool(np.linalg.norm(cloud.normals.mean(axis=0)) > LEAST_FACING)
    x, y, z = place.tolist()
    where = f"{_metres(x)}, {_metres(y)}, {_metres(z)} m{f', {how}' if turns else ''}"
    note = f"the arm does not reach it where it is: its middle is put at {where} (--at, --turn)"
    moved = (cloud.faced(facing) if turns else cloud).placed((x, y, z))
    return replace(moved, notes=(*moved.notes, note))


def _metres(x: float) -> str:
    """A coordinate to the millimetre."""
    return f"{round(x, 3) + 0.0:g}"


def posture(robot: ravengc.Robot) -> Array:
    """Return joint positions (n,) to begin with: the middle of the ranges, or, near a singularity, some way from it."""
    middle = swing_within_limits(robot.spec).centre
    lower, upper, _ = limits_of(robot)
    widths = np.minimum(SHARE * np.minimum(middle - lower, upper - middle), WIDEST)
    shares = np.random.default_rng(0).uniform(-1.0, 1.0, (POSTURES, robot.n))
    found = [middle, *(middle + shares * widths)]
    freedoms = np.array([_least_freedom(robot, q) for q in found])
    return middle if freedoms[0] >= GOOD * freedoms.max() else found[int(freedoms.argmax())]


def _least_freedom(robot: ravengc.Robot, q: Array) -> float:
    """The smallest singular value of the Jacobian of the tool's place and pointing, lengths in those of the arm."""
    moves, turns = np.vsplit(robot.jacobian(q), 2)
    across = robot.forward_kinematics(q)[:3, :2].T @ turns
    return float(np.linalg.svd(np.vstack((moves / length(robot), across)), compute_uv=False)[-1])


def reaches(robot: ravengc.Robot, start: Array, cloud: Cloud) -> bool:
    """Tell whether the tool comes to three of four points of the cloud, against their normals, from ``start`` (n,)."""
    rows = evenly(cloud.points, SAMPLE)
    reached = [_reached(robot, start, cloud.points[row], cloud.normals[row]) for row in rows]
    return sum(reached) >= LEAST_SHARE * len(reached)


def length(robot: ravengc.Robot) -> float:
    """Return how far the arm reaches about: the way from the base from frame to frame to the tool, m."""
    q = swing_within_limits(robot.spec).centre
    places = np.array([robot.forward_kinematics(q, frame=name)[:3, 3] for name in robot.frame_names])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def _reached(robot: ravengc.Robot, start: Array, point: Array, normal: Array) -> bool:
    """Go there for four seconds."""
    rate = ResolvedRate(
        robot, task="pointing", null_space="limits", rate_hz=RATE_HZ, speed_max=SPEED, turning_max=TURNING
    )
    q, qd, target = start.copy(), np.zeros(robot.n), np.concatenate((point, normal))
    for _ in range(STEPS):
        q += rate.track(q, target, 1.0 / RATE_HZ, out=qd) / RATE_HZ
    pose = robot.forward_kinematics(q)
    angle = math.acos(float(np.clip(-pose[:3, 2] @ normal, -1.0, 1.0)))
    return bool(np.linalg.norm(pose[:3, 3] - point) < NEAR_M) and angle < NEAR_RAD
