"""The page's simulator check: an arm held at any pose by its computed gravity torques alone.

There is no controller behind them: gravity balanced by torque is an indifferent equilibrium, so the arm stays where it
was put if the torques are right, and falls the way their error points if they are not. The plant is MuJoCo's, which has
its own kinematics and masses; gravity is what its accelerometer on the base gives.

Source: jhu-dvrk/sawIntuitiveResearchKit wiki, page 'Control Gravity Compensation': "we send computed values to Gazebo
Simulator to visually check the values".
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_count, as_double, as_number, check_choice, check_type
from ravengc.coordinates import sliding
from ravengc.dvrk.watching import as_span, watched
from ravengc.errors import ArgumentError, ModelError
from ravengc.robot import Robot
from ravengc.sim import Plant, level, tilted

if TYPE_CHECKING:
    from ravengc.sim import PrescribedBase
    from ravengc.spec import JointLimits

__all__ = ["Hold", "Holding", "hold"]

Array = npt.NDArray[np.float64]
STEP_S = 0.001
LONGEST_S = 600.0
FALL_S = 1.0
"""How long the arm is watched without torques."""
ROTOR = 1e-3
"""kg m², kg: rotors for coordinates that move points on their axes or nothing, as those of the page's masses."""
HELD_M = 1e-5
"""How far the tool of an arm that is held moves at most (m)."""


@dataclass(frozen=True, slots=True, eq=False)
class Hold:
    """One pose: ``q`` and the torques at it (n,), and how far the tool was from its place, m.

    ``time``, ``held`` and ``falling`` (samples,) are with the torques for the whole time, and without any for
    :data:`FALL_S`; ``joint`` is the largest motion of a coordinate while held (rad, m).
    """

    q: Array
    tau: Array
    time: Array
    held: Array
    fall_time: Array
    falling: Array
    joint: float

    @property
    def drift(self) -> float:
        """Farthest that the tool was from its place (m)."""
        return float(self.held.max())

    @property
    def stays(self) -> bool:
        """Whether the tool stayed within 0.01 mm."""
        return self.drift <= HELD_M

    @property
    def fall(self) -> float:
        """How far the tool went without torques (m)."""
        return float(self.falling.max())


@dataclass(frozen=True, slots=True, eq=False)
class Holding:
    """All poses of an arm on a base, and whether every one was held."""

    robot: str
    base: str
    seconds: float
    rotor_inertia: float
    holds: tuple[Hold, ...]

    @property
    def holds_all(self) -> bool:
        """Whether the tool stayed within 0.01 mm in every pose."""
        return all(one.stays for one in self.holds)


def hold(
    robot: Robot,
    poses: npt.ArrayLike | None = None,
    *,
    count: int = 8,
    seconds: float = 5.0,
    tilt_deg: float = 0.0,
    axis: Literal["x", "y", "z"] = "x",
    seed: int = 0,
) -> Holding:
    """Hold the robot in MuJoCo at ``poses`` (N, n), or at ``count`` random ones within its limits.

    The base is tilted by ``tilt_deg`` about ``axis``. Elements beside the masses (``spec.disturbances``) act in the
    plant and are in the torques. Raises ArgumentError for impossible numbers, ModelError for a robot without
    masses, MissingExtraError without MuJoCo.
    """
    check_type(robot, Robot, "robot")
    check_choice(axis, ("x", "y", "z"), "axis", ArgumentError)
    span, angle = as_span(seconds, STEP_S, LONGEST_S), as_number(tilt_deg, "tilt_deg")
    if not abs(angle) <= 360.0:
        raise ArgumentError(f"tilt_deg is {tilt_deg!r}; expected -360 to 360")
    if not any(link.mass for link in robot.spec.links):
        raise ModelError(f"robot '{robot.name}' has no masses: there is nothing to hold")
    places = random_poses(robot, count, seed) if poses is None else _poses(poses, robot.n)
    base = tilted(angle, axis) if angle else level()
    plant, rotor = plant_for(robot, base)
    found = tuple(_held(robot, plant, q, span) for q in places)
    return Holding(robot.name, base.description, span, rotor, found)


def random_poses(robot: Robot, count: int, seed: int) -> Array:
    """Poses within the limits of the coordinates, (N, n); over a turn or 1 m where an end is missing."""
    rng, slides = np.random.default_rng(as_count(seed, "seed", 0)), sliding(robot.spec)
    limits = zip(robot.spec.coordinate_limits, slides, strict=True)
    low_ends, high_ends = np.array([_range(one, 0.5 if slide else np.pi) for one, slide in limits]).T
    return rng.uniform(low_ends, high_ends, (as_count(count, "count", 1, 10_000), robot.n))


def _range(limits: JointLimits, half: float) -> tuple[float, float]:
    """Both limits, or from the one that there is as far as two halves reach."""
    if limits.lower is None:
        high = half if limits.upper is None else limits.upper
        return high - 2.0 * half, high
    return limits.lower, limits.lower + 2.0 * half if limits.upper is None else limits.upper


def plant_for(robot: Robot, base: PrescribedBase) -> tuple[Plant, float]:
    """The robot in MuJoCo, and the inertia of the rotors that it needed to be one."""
    try:
        return Plant(robot, base, step_s=STEP_S), 0.0
    except ModelError:
        return Plant(robot, base, step_s=STEP_S, rotor_inertia=ROTOR), ROTOR


def _poses(poses: npt.ArrayLike, n: int) -> Array:
    places = np.atleast_2d(as_double(poses, "poses"))
    if places.ndim != 2 or places.shape[1] != n or not len(places) or not np.isfinite(places).all():
        raise ArgumentError(f"poses has shape {places.shape}; expected (N, {n}), finite")
    return places


def _held(robot: Robot, plant: Plant, q: Array, span: float) -> Hold:
    tau, nothing = np.zeros(robot.n), np.zeros(robot.n)
    plant.reset(q)
    hold_it = partial(_computed, robot, plant, tau)
    first = hold_it().copy()
    held = watched(robot, plant, q, hold_it, seconds=span, step_s=STEP_S)
    fall = watched(robot, plant, q, lambda: nothing, seconds=min(span, FALL_S), step_s=STEP_S)
    there = np.isfinite(fall.moved)
    return Hold(q, first, held.time, held.moved, fall.time[there], fall.moved[there], held.joint)


def _computed(robot: Robot, plant: Plant, tau: Array) -> Array:
    """The torques at the plant's pose, on the base as its accelerometer says that it stands."""
    robot.gravity_torque(plant.q, -plant.accelerometer(), out=tau)
    if robot.spec.disturbances:
        tau += robot.disturbance_torque(plant.q, plant.qd)
    return tau
