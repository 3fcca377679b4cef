"""An MTM calibrated in simulation, on a level base as the published procedure has it, and with the base tilted too.

The arm is the bundled one with cables that pull as the page's do, straight lines on both sides of the page's
thresholds, and Coulomb friction of the size that the published files show at rest. Every pose of the published grid is
approached from both sides and read ten times, with 0.01 N·m of noise a reading; the mean has no friction. Both
calibrations fit the same model with the same number of readings: masses and first moments of all links but the last,
which the page gives no mass, and a polynomial of every joint's own position (of the first power at joint 2, of the
fourth at the others), to all joints' torques at once.

On a level base a cable along joint 2 and gravity about it look almost alike, and gravity about joint 1 is not seen at
all. On tilted bases gravity turns and the cables do not.

Source of the grid, the orders and the noise: dvrk-gravity-compensation@18787b3c dataCollection_config.json,
mlse_config.json; of the friction: half the difference of the two directions at the files' own test pose, smallest of
the five of dvrk_config_jhu@033a1946 (joint 7, which they leave out: as joint 6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ravengc import STANDARD_GRAVITY
from ravengc._convert import as_count, as_number, as_vector, check_choice, check_type
from ravengc.config.physical import LARGEST
from ravengc.disturbances import Constant, Friction, LinearSpring
from ravengc.errors import ArgumentError
from ravengc.identify import Model, Recording, identify, polynomial
from ravengc.robot import Robot, load
from ravengc.spec import RobotSpec

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["COULOMB", "Calibrated", "calibrate", "simulated_mtm", "tilt_fields"]

Array = npt.NDArray[np.float64]
COULOMB = (0.0055, 0.020, 0.0025, 0.030, 0.0017, 0.0007, 0.0007)
"""Coulomb friction of joints 1 to 7, N·m: the smallest that was found, so the least that can hold an arm."""
NOISE, READINGS = 0.01, 10
"""N·m, standard deviation of a reading, and how many are averaged in a pose, each time it is approached."""
TILT_DEG = 20.0
MTMS = ("dvrk_mtml", "dvrk_mtmr")
ORDERS = (4, 1, 4, 4, 4, 4)
REST = (0.0, 0.0, 0.0, 0.0, 90.0, 0.0, 0.0)
"""deg: where the joints stay that are not swept."""
CABLES = ((0, 0.1, -0.15, 0.04), (1, 1.0, 0.05, 0.05 - 0.30), (2, 0.1, 0.05, -0.07))
"""Joint, slope (N·m/rad), threshold (rad) and torque there (N·m) of the page's cables; -0.30 is its offset."""


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """A calibration: parameters (p,) of ``robot``'s gravity columns and then of each joint's polynomial.

    ``tilts`` counts the attitudes of the base it was made in, ``rank`` its base parameters, ``condition`` that of the
    fit.
    """

    robot: Robot
    parameters: Array
    tilts: int
    readings: int
    rank: int
    condition: float

    def torque(self, q: npt.ArrayLike, gravity: npt.ArrayLike) -> Array:
        """The torques, (n,) N·m, that hold the arm at q (n,) in a gravity field (3,), base axes, m/s²."""
        angles = as_vector(q, "q", self.robot.n, LARGEST)
        columns = 4 * (self.robot.body_count - 1)
        rows = self.robot.gravity_regressor(angles, as_vector(gravity, "gravity", 3, LARGEST))
        tau: Array = rows[:, :columns] @ self.parameters[:columns]
        at = columns
        for joint, order in enumerate(ORDERS):
            tau[joint] += np.polynomial.polynomial.polyval(angles[joint], self.parameters[at : at + order + 1])
            at += order + 1
        return tau

    def error(self, q: npt.ArrayLike, gravity: npt.ArrayLike) -> Array:
        """How far these torques (n,) are from those of the arm at rest, N·m."""
        return self.torque(q, gravity) - self.robot.gravity_torque(q, gravity) - self.robot.disturbance_torque(q)

    def error_at_any_tilt(self, q: npt.ArrayLike) -> Array:
        """The largest error (n,) at q over all attitudes of a base at rest, N·m.

        The error is b + A g, whose joint j is largest for the g along row j of A: abs(b_j) + g norm(A_j).
        """
        b = self.error(q, np.zeros(3))
        a = np.array([self.error(q, unit) - b for unit in np.eye(3)])
        largest: Array = np.abs(b) + STANDARD_GRAVITY * np.linalg.norm(a, axis=0)
        return largest


def simulated_mtm(name: str = "dvrk_mtmr") -> RobotSpec:
    """The bundled MTM with the page's cables as straight lines, constants and springs along joints 1 to 3."""
    check_choice(name, MTMS, "name")
    spec = load(name).spec
    names, source = spec.coordinate_names, "the page's cable, held straight on both sides of its threshold"
    elements: list[Constant | LinearSpring | Friction] = []
    for joint, slope, threshold, torque in CABLES:
        along = names[joint]
        elements.append(Constant(name=f"offset of {along}", joint=along, torque=torque, source=source))
        elements.append(
            LinearSpring(name=f"cable of {along}", joint=along, stiffness=slope, rest=threshold, source=source)
        )
    rubbing = "half the difference of the directions in the published files, the smallest of five"
    for along, coulomb in zip(names, COULOMB, strict=True):
        elements.append(Friction(name=f"friction of {along}", joint=along, coulomb=coulomb, source=rubbing))
    return replace(spec, disturbances=tuple(elements))


def tilt_fields(degrees: float = TILT_DEG) -> Array:
    """Gravity in base axes (5, 3) on a level base, and on one tilted by so much forth and back about x and y."""
    angle = np.radians(as_number(degrees, "degrees"))
    side, down = np.sin(angle), np.cos(angle)
    fields = ((0.0, 0.0, -1.0), (0.0, -side, -down), (0.0, side, -down), (side, 0.0, -down), (-side, 0.0, -down))
    gravity: Array = STANDARD_GRAVITY * np.array(fields)
    return gravity


def calibrate(truth: RobotSpec, *, tilted: bool, seed: int = 0, degrees: float = TILT_DEG) -> Calibrated:
    """Calibrate an arm in simulation: the grid five times on a level base, or once level and once at each of 4 tilts.

    ``truth`` is a description as :func:`simulated_mtm` gives. Raises ArgumentError for tilts beyond 0.1 to 90 deg.
    """
    check_type(truth, RobotSpec, "truth")
    check_type(tilted, bool, "tilted")
    if not 0.1 <= as_number(degrees, "degrees") <= 90.0:
        raise ArgumentError(f"degrees is {degrees!r}; expected 0.1 to 90")
    robot = Robot(truth)
    if robot.n != len(REST):
        raise ArgumentError(f"truth is {truth.name} with {robot.n} coordinates; expected an MTM with {len(REST)}")
    fields = tilt_fields(degrees)
    if not tilted:
        fields = np.tile(fields[:1], (len(fields), 1))
    grid = calibration_grid()
    q, g = np.tile(grid, (len(fields), 1)), np.repeat(fields, len(grid), axis=0)
    cables = np.array([robot.disturbance_torque(row) for row in grid])  # at rest, which friction does not see
    noise = np.random.default_rng(as_count(seed, "seed", 0)).normal(0.0, NOISE / np.sqrt(2.0 * READINGS), q.shape)
    recording = Recording(
        stamps=np.arange(float(len(q))),
        q=q,
        tau=robot.gravity_torque_batch(q, g) + np.tile(cables, (len(fields), 1)) + noise,
        specific_force=-g,
        source="simulated",
    )
    elements = tuple(
        polynomial(name, range(order + 1)) for name, order in zip(truth.coordinate_names, ORDERS, strict=False)
    )
    sought = tuple(link.name for link in truth.moving_links[:-1])
    unknowing = Robot(replace(truth, disturbances=()))  # elements that a robot has would count as known
    found = identify(unknowing, recording, Model(kind="gravity", elements=elements, links=sought), held_out=0.2)
    attitudes = len(np.unique(fields, axis=0))
    return Calibrated(robot, found.parameters, attitudes, len(q), found.rank, found.condition)


def calibration_grid() -> Array:
    """The published grid, (N, 7) rad: of each joint, while another steps through a few places."""
    rows = [
        *_sweep(6, (-40, 40, 2), 5, (-90, 90, 30)),
        *_sweep(5, (-85, 175, 6), 3, (-10, 20, 5)),
        *_sweep(4, (-80, 190, 6), 3, (-10, 20, 5)),
        *(row for row in _sweep(3, (-34, 34, 1), 2, (-14, 20, 2)) if -11 <= row[1] + row[2] <= 16),
        *(_sweep(2, (-11, 16, 1), 3, (0, 0, 1)) * 10),
        *(_sweep(1, (-40, 7, 1), 3, (0, 0, 1)) * 10),
    ]
    shuffled = np.random.default_rng(0).permutation(len(rows))
    poses: Array = np.radians(np.array(rows, dtype=np.float64)[shuffled])
    return poses


def _sweep(
    joint: int, sweep: tuple[int, int, int], other: int, places: tuple[int, int, int]
) -> list[tuple[float, ...]]:
    """Poses (deg) of one joint's sweep (first, last, step; joints from 1) in the places of another."""
    return [_pose({joint: angle, other: place}) for place, angle in product(_steps(places), _steps(sweep))]


def _pose(changed: dict[int, float]) -> tuple[float, ...]:
    return tuple(changed.get(joint, angle) for joint, angle in enumerate(REST, 1))


def _steps(span: tuple[int, int, int]) -> Iterable[int]:
    first, last, step = span
    return range(first, last + 1, step)
