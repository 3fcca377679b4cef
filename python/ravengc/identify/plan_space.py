"""Where a robot and its base may be brought: ranges of the joints, poses within them, tilts of the base."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_double, as_number, as_vector, check_type
from ravengc._core import STANDARD_GRAVITY
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError, ConfigError
from ravengc.identify.recording import FloatArray, Recording
from ravengc.messages import did_you_mean, listed, shown

if TYPE_CHECKING:
    import numpy.typing as npt

    from ravengc.robot import Robot
    from ravengc.spec import RobotSpec

__all__ = [
    "SHORTEST_RISE",
    "as_tilt",
    "bearable",
    "check_progress",
    "directions",
    "fastest",
    "forces",
    "joint_ranges",
    "poses_within",
    "standing",
    "tilt_candidates",
    "usual_speeds",
]

MARGIN = 0.02
"""Share of a joint's range that is kept from both of its ends."""
STEEPEST = np.radians(90.0)
SLOW = (1.0, 0.1)
"""rad/s and m/s of joints whose limit is not known."""
SHORTEST_RISE = 0.5
"""s in which a joint may reach its largest velocity unless its acceleration is known."""
LEVEL = np.zeros((1, 2))


def check_progress(on_progress: object) -> None:
    """Raise ArgumentError for what is neither ``None`` nor a function."""
    if on_progress is not None and not callable(on_progress):
        raise ArgumentError(f"on_progress is {shown(on_progress)}; expected a function of what is done and the total")


def joint_ranges(robot: RobotSpec, ranges: Mapping[str, tuple[float, float]] | None) -> FloatArray:
    """Least and most of every coordinate, (n, 2): within its limits, a little off their ends, and within ``ranges``.

    A joint that turns without a limit, or more than a turn, gets half a turn to both sides. Raises ConfigError for a
    range of no joint, one outside the limits, and for a slide without limits.
    """
    given = {} if ranges is None else ranges
    check_type(given, Mapping, "ranges")
    names = robot.coordinate_names
    for name in given:
        if name not in names:
            near = did_you_mean(name, names)
            raise ConfigError(f"ranges: {robot.name} has no joint {shown(name)}{near}; it has {listed(names)}")
    found = _limits(robot, set(given))
    inner, ended = found.copy(), np.isfinite(found).all(axis=1)
    inner[ended] += MARGIN * np.diff(found[ended]) * [1.0, -1.0]
    for place, name in enumerate(names):
        if name in given:
            inner[place] = _narrowed(given[name], found[place], name)
    return inner


def _limits(robot: RobotSpec, given: set[str]) -> FloatArray:
    found = np.empty((len(robot.coordinate_names), 2))
    rows = zip(robot.coordinate_names, robot.coordinate_limits, sliding(robot), strict=True)
    for place, (name, limit, slides) in enumerate(rows):
        lower = -np.inf if limit.lower is None else limit.lower
        upper = np.inf if limit.upper is None else limit.upper
        if not slides and name not in given and upper - lower > 2.0 * np.pi:
            middle = min(max(0.0, lower + np.pi), upper - np.pi)
            lower, upper = middle - np.pi, middle + np.pi
        if name not in given and not np.isfinite(upper - lower):
            raise ConfigError(f"{robot.name}: joint '{name}' slides and has no limits; give its range in metres")
        found[place] = lower, upper
    return found


def _narrowed(given: object, limit: FloatArray, name: str) -> FloatArray:
    wanted = as_vector(given, f"ranges['{name}']", 2)
    if not wanted[0] < wanted[1]:
        raise ArgumentError(f"ranges['{name}'] is {shown(given)}; expected the least before the most")
    if wanted[0] < limit[0] - 1e-9 or wanted[1] > limit[1] + 1e-9:
        within = f"{limit[0]:g} to {limit[1]:g}"
        raise ConfigError(f"ranges['{name}'] is {wanted[0]:g} to {wanted[1]:g}; the joint's limits are {within}")
    return wanted


def fastest(robot: RobotSpec) -> FloatArray:
    """The limits of the velocities (n,), rad/s or m/s; infinite where not known."""
    own = [limit.velocity for limit in robot.coordinate_limits]
    return np.array([np.inf if limit is None else limit for limit in own])


def usual_speeds(robot: RobotSpec) -> FloatArray:
    """The limits of the velocities (n,), or a slow one, rad/s or m/s, where not known."""
    known = fastest(robot)
    return np.where(np.isfinite(known), known, np.where(sliding(robot), SLOW[1], SLOW[0]))


def poses_within(ranges: FloatArray, count: int, random: np.random.Generator) -> FloatArray:
    """Poses (count, n) spread over the ranges: in every joint, one in each of ``count`` equal parts of its range."""
    parts = np.array([random.permutation(count) for _ in ranges]).T + random.uniform(size=(count, len(ranges)))
    return np.asarray(ranges[:, 0] + (ranges[:, 1] - ranges[:, 0]) * parts / count)


def bearable(robot: Robot, poses: FloatArray, attitudes: FloatArray) -> FloatArray:
    """The poses that the drives can hold on every one of the attitudes, by the masses that the robot has now."""
    effort = np.array([np.inf if limit.effort is None else limit.effort for limit in robot.spec.coordinate_limits])
    holds = np.ones(len(poses), dtype=bool)
    for force in forces(attitudes):
        holds &= (np.abs(robot.gravity_torque_batch(poses, -force)) <= effort).all(axis=1)
    return np.ascontiguousarray(poses[holds])


def as_tilt(angle: object, name: str) -> float:
    """An angle from 0 to 90 degrees, rad; ArgumentError for anything else."""
    found = as_number(angle, name)
    if not 0.0 <= found <= STEEPEST:
        raise ArgumentError(f"{name} is {shown(angle)}; expected 0 to {STEEPEST:.4g} rad, the angle from level")
    return found


def directions(angle: float, count: int = 8) -> FloatArray:
    """Roll and pitch (count, 2) of tilts by ``angle`` from level, to all sides alike, the first about x."""
    to = 2.0 * np.pi * np.arange(count) / count
    # f/g = (-sin p, cos p sin r, cos p cos r) is (-sin a sin t, sin a cos t, cos a) of a turn by a about (cos t, sin t)
    pitch = np.arcsin(np.sin(angle) * np.sin(to))
    roll = np.arctan2(np.sin(angle) * np.cos(to), np.cos(angle))
    tilts = np.column_stack([roll, pitch])
    tilts[np.abs(tilts) < 1e-12] = 0.0
    return tilts


def tilt_candidates(tilts: npt.ArrayLike | None, tilt: float) -> FloatArray:
    """Attitudes (k, 2) to choose from, level first: those given, or eight to all sides."""
    if tilts is None:
        return np.vstack([LEVEL, directions(tilt)]) if tilt > 0.0 else LEVEL
    given = as_double(tilts, "tilts")
    if given.ndim != 2 or given.shape[1] != 2 or not len(given) or not (np.abs(given) <= STEEPEST).all():
        raise ArgumentError(
            f"tilts has shape {given.shape}; expected (k, 2), roll and pitch of at most {STEEPEST:.4g} rad"
        )
    return np.vstack([LEVEL, given[np.abs(given).max(axis=1) > 0.0]])


def forces(attitudes: FloatArray) -> FloatArray:
    """Specific force (k, 3) at rest at every roll and pitch (k, 2), in axes of the base, turned by Ry(p) Rx(r)."""
    roll, pitch = attitudes.T
    up = np.column_stack([-np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)])
    return np.asarray(STANDARD_GRAVITY * up)


def standing(q: FloatArray, attitudes: FloatArray) -> Recording:
    """Poses (N, n) at rest, each on its own attitude (N, 2), as a recording without torques."""
    return Recording(
        stamps=np.arange(float(len(q))), q=q, tau=np.zeros_like(q), specific_force=forces(attitudes), source="plan"
    )
