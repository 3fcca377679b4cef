"""A whole run: look, go to the first point, visit every point in the order of the tour, then hold some of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import check_members, check_type
from ravengc.errors import ConfigError
from ravengc.robot import Robot
from ravengc.track.camera import Camera
from ravengc.track.follower import Follower
from ravengc.track.recording import limits_of
from ravengc.track.settings import TrackSettings
from ravengc.track.surface import Surface
from ravengc.track.tour import tour
from ravengc.track.visiting import Visiting

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.track.motions import Motion
    from ravengc.track.result import TrackResult

__all__ = ["check_arm", "track"]

Array = NDArray[np.float64]

FEWEST_JOINTS = 5
LEAST_COMMON = 0.5
"""Length of the mean of unit normals from which on it is a direction for all of them."""


def track(
    robot: Robot,
    surface: Surface,
    motion: Motion,
    camera: Camera,
    settings: TrackSettings,
    on_progress: Callable[[int, int], None] | None = None,
) -> TrackResult:
    """Visit every point of a surface that moves, with an arm of ideal velocity servos, and return what came of it.

    The tool's z axis points against the normals, its turn about it is free. ``on_progress(done, total)`` is told after
    every new point. Ctrl-C ends the run early: what it did until then is returned, marked as interrupted, unless
    it had come to no point yet. Raises ArgumentError for arguments of the wrong kind, ConfigError for an arm with fewer
    than five joints and for a start outside their limits; points that cannot be reached are outcomes, not errors.
    """
    for value, kind, name in (
        (robot, Robot, "robot"), (surface, Surface, "surface"), (camera, Camera, "camera"),
        (settings, TrackSettings, "settings"),
    ):  # fmt: skip
        check_type(value, kind, name)
    check_members(motion, ("description", "positions", "velocities"), "motion")
    if on_progress is not None and not callable(on_progress):
        raise ConfigError("on_progress is no function of two numbers")
    check_arm(robot)
    start = start_of(robot, settings)
    turning = settings.acceleration_max / settings.angular_acceleration_max
    order = tour(surface, settings.order, strip=settings.strip_m, turning=turning)
    follower = Follower(robot, motion, camera, settings, start, upright_of(surface))
    return Visiting(surface, settings, follower, order).run(on_progress or _unheard)


def check_arm(robot: Robot) -> None:
    """Raise ConfigError for an arm with too few joints to bring its tool to a point and against its normal."""
    if robot.n < FEWEST_JOINTS:
        needed = f"{FEWEST_JOINTS} at least bring a tool to a point of a surface and against its normal"
        raise ConfigError(f"{robot.name} has {robot.n} joints; {needed}")


def start_of(robot: Robot, settings: TrackSettings) -> Array:
    """Where the joints begin, (n,); ConfigError for another number of them, and outside their limits."""
    lower, upper, _ = limits_of(robot)
    start = np.array(settings.start_q)
    if start.size == 1 and robot.n > 1:
        bounded = np.isfinite(lower) & np.isfinite(upper)
        start = np.where(bounded, (np.where(bounded, lower, 0.0) + np.where(bounded, upper, 0.0)) / 2.0, 0.0)
    if start.size != robot.n:
        raise ConfigError(f"start_q has {start.size} numbers; expected {robot.n}, one for each joint of {robot.name}")
    outside = np.flatnonzero((start < lower) | (start > upper))
    if outside.size:
        i = int(outside[0])
        joint, value = robot.joint_names[i], start[i]
        raise ConfigError(f"start_q: {joint} at {value:g} is outside its limits, {lower[i]:g} to {upper[i]:g}")
    return start


def upright_of(surface: Surface) -> tuple[float, float, float] | None:
    """The mean normal, unit; None where the normals have no common side."""
    mean = surface.normals.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if length < LEAST_COMMON:
        return None
    x, y, z = (mean / length).tolist()
    return (x, y, z)


def _unheard(done: int, total: int) -> None:
    """Nobody asked for progress."""
