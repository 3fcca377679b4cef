"""What a robot's description amounts to: its masses, how far its tool gets, and all of it as plain data."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.coordinates import sliding

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import ravengc
    from ravengc.spec import RobotSpec

__all__ = ["RobotFacts", "as_data", "default_pose", "facts_of"]

GRID = 13
SWEEPS = 10
STARTS = 4
SHRINK = 0.6


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """Masses of the links that joints move and of those fixed to the base (kg), and the reach (m).

    ``reach`` is the largest distance found of the tool from the base origin within the joint limits (turning joints
    without limits may turn freely); ``None`` where a sliding joint has no limits.
    """

    moving_mass: float
    base_mass: float
    reach: float | None


def facts_of(robot: ravengc.Robot) -> RobotFacts:
    """The facts of a robot as it stands now, its tool frame included."""
    links = robot.spec.links
    moved = _moved(robot.spec)
    moving = math.fsum(link.mass for link in links if link.name in moved)
    return RobotFacts(moving, math.fsum(link.mass for link in links) - moving, _reach(robot))


def default_pose(robot: RobotSpec) -> list[float]:
    """Zero for every coordinate that may be zero, else the middle of its range (rad, m)."""
    return [0.0 if lower <= 0.0 <= upper else _middle(lower, upper) for lower, upper in _ranges(robot, math.inf)]


def _middle(lower: float, upper: float) -> float:
    """Middle of a range that does not hold zero, or its finite end."""
    ends = [end for end in (lower, upper) if math.isfinite(end)]
    return math.fsum(ends) / len(ends)


def as_data(robot: ravengc.Robot) -> dict[str, Any]:
    """Everything that was understood of a robot, in SI, as JSON can hold it."""
    spec, facts = robot.spec, facts_of(robot)
    coordinates = zip(spec.coordinate_names, sliding(spec), spec.coordinate_limits, strict=True)
    return {
        **asdict(spec),
        "disturbances": [{"kind": element.kind, **asdict(element)} for element in spec.disturbances],
        "coordinates": [
            {"name": name, "unit": "m" if slides else "rad", "limits": asdict(limits)}
            for name, slides, limits in coordinates
        ],
        "frames": list(robot.frame_names),
        "moving_mass": facts.moving_mass,
        "base_mass": facts.base_mass,
        "reach": facts.reach,
    }


def _moved(spec: RobotSpec) -> set[str]:
    """Names of the links that some joint moves; parents come first, so one pass tells."""
    moved: set[str] = set()
    for link in spec.links:
        if link.joint != "fixed" or link.parent in moved:
            moved.add(link.name)
    return moved


def _reach(robot: ravengc.Robot) -> float | None:
    ranges = list(_ranges(robot.spec, math.pi))
    if not np.isfinite(ranges).all():
        return None
    return max(_farthest_from(robot, start, ranges) for start in _starts(ranges))


def _starts(ranges: Sequence[tuple[float, float]]) -> Iterator[list[float]]:
    """Poses spread over the ranges: coordinate i of start k is at the fraction frac(k i φ), φ the golden ratio."""
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    for start in range(1, STARTS + 1):
        yield [low + (start * i * golden % 1.0) * (high - low) for i, (low, high) in enumerate(ranges, start=1)]


def _farthest_from(robot: ravengc.Robot, start: list[float], ranges: Sequence[tuple[float, float]]) -> float:
    """Largest distance found by moving one coordinate at a time to its best place, on grids that get finer."""
    q, width, farthest = np.array(start), 1.0, 0.0
    for _ in range(SWEEPS):
        for i, (low, high) in enumerate(ranges):
            half = 0.5 * width * (high - low)
            poses = np.tile(q, (GRID + 1, 1))
            poses[:GRID, i] = np.linspace(max(low, q[i] - half), min(high, q[i] + half), GRID)
            distances = np.linalg.norm(robot.forward_kinematics_batch(poses)[:, :3, 3], axis=1)
            q, farthest = poses[distances.argmax()], float(distances.max())
        width *= SHRINK
    return farthest


def _ranges(spec: RobotSpec, unbounded: float) -> Iterator[tuple[float, float]]:
    """Limits of the coordinates, ±``unbounded`` for turning and ±inf for sliding ones that have none."""
    for limits, slides in zip(spec.coordinate_limits, sliding(spec), strict=True):
        most = math.inf if slides else unbounded
        yield (-most if limits.lower is None else limits.lower, most if limits.upper is None else limits.upper)
