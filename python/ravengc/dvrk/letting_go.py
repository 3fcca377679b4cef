"""An MTM let go on tilted bases, with its own calibration for gravity: how far does the tool drift?

No controller but the calibrated torques, which take gravity from the accelerometer of the base. The plant has the
cables and the friction of :func:`~ravengc.dvrk.simulated_mtm`; friction holds what the torques' error leaves, where
that is less, so the arm stands still if its calibration is better than its friction, and falls where it is not.
Runs show that at some tilts; :func:`friction_shares` bounds it for all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_count, as_double, as_number, as_vector, check_type
from ravengc.config.physical import LARGEST
from ravengc.dvrk.calibration import COULOMB, TILT_DEG, Calibrated, calibrate, simulated_mtm
from ravengc.dvrk.watching import as_span, watched
from ravengc.errors import ArgumentError
from ravengc.messages import shown
from ravengc.sim import Plant, tilted

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["PASSIVE_TILTS", "SHARE_POSES", "Drift", "PassiveRuns", "friction_shares", "let_go", "passive"]

Array = npt.NDArray[np.float64]
STEP_S = 0.004
LONGEST_S = 3600.0
ALLOWED_M = 1e-3
SHARE_POSES, MOST_POSES = 500, 1_000_000
FELL_M = 0.1
"""m: an arm that has moved so far has fallen, and is not watched any longer."""
ROTORS = (4e-3, 2.5e-3, 3.6e-3, 1.1e-4, 6e-5, 6e-5, 1.5e-5)
"""kg m²: square of the gear ratio (SAW compute-ftmax.py) times a rotor of 1e-6, joints 1 to 4, or 5.5e-8, assumed."""
PASSIVE_TILTS = (
    (0.0, (1.0, 0.0)), (10.0, (1.0, 0.0)), (10.0, (0.0, 1.0)), (20.0, (1.0, 1.0)), (45.0, (1.0, -1.0)),
    (90.0, (1.0, 0.0)), (90.0, (0.0, 1.0)), (135.0, (-1.0, 1.0)), (180.0, (1.0, 0.0)),
)  # fmt: skip
"""Tilt of the base (deg) and the horizontal axis that it is about."""
CALIBRATED_DEG = ((-40, 7), (-11, 16), (-11, 11), (-80, 190), (-85, 175), (-40, 40), (-180, 180))
"""Where the published grid has calibrated the joints (deg); joint 3 where joint 2 may be anywhere in its own range."""


@dataclass(frozen=True, slots=True, eq=False)
class Drift:
    """One run: how the base stood, where the arm was let go (n,), and how far its tool went.

    ``error`` (n,) is that of the torques when it was let go, N·m; ``moved`` (samples,) m at ``time`` s.
    """

    tilt_deg: float
    axis: tuple[float, float]
    q: Array
    error: Array
    time: Array
    moved: Array

    @property
    def drift(self) -> float:
        """Farthest that the tool was from where it was let go (m)."""
        return float(self.moved.max())

    @property
    def stays(self) -> bool:
        """Whether the tool stayed within 1 mm."""
        return self.drift <= ALLOWED_M


@dataclass(frozen=True, slots=True, eq=False)
class PassiveRuns:
    """The same runs with a calibration on tilted bases and with one on a level base; their :func:`friction_shares`."""

    robot: str
    seconds: float
    identified: Calibrated
    level_only: Calibrated
    with_identified: tuple[Drift, ...]
    with_level_only: tuple[Drift, ...]
    identified_shares: Array
    level_only_shares: Array

    @property
    def stays(self) -> bool:
        """Whether the arm stayed within 1 mm at every tilt with the calibration on tilted bases."""
        return all(run.stays for run in self.with_identified)


def passive(
    name: str = "dvrk_mtmr",
    *,
    seconds: float = 60.0,
    tilts: Sequence[tuple[float, tuple[float, float]]] = PASSIVE_TILTS,
    calibration_tilt_deg: float = TILT_DEG,
    seed: int = 0,
    on_progress: Callable[[int, int], object] | None = None,
) -> PassiveRuns:
    """Calibrate an MTM both ways in simulation and let it go at every tilt, at a random pose of the calibrated range.

    ``tilts`` are (deg, horizontal axis); ``on_progress`` is told runs done and in all. Raises ArgumentError for
    impossible numbers, ConfigError for an unknown robot, MissingExtraError without MuJoCo.
    """
    truth = simulated_mtm(name)
    span, rng = as_span(seconds, STEP_S, LONGEST_S), np.random.default_rng(as_count(seed, "seed", 0))
    places = _tilts(tilts)
    if on_progress is not None and not callable(on_progress):
        raise ArgumentError(f"on_progress is {shown(on_progress)}; expected a function of runs done and in all")
    identified, level_only = (
        calibrate(truth, tilted=kind, seed=seed, degrees=calibration_tilt_deg) for kind in (True, False)
    )
    poses = _calibrated_poses(rng, len(places))
    runs: list[list[Drift]] = [[], []]
    for place, (tilt, q) in enumerate(zip(places, poses, strict=True)):
        for found, calibration in zip(runs, (identified, level_only), strict=True):
            found.append(let_go(calibration, q, tilt_deg=tilt[0], axis=tilt[1], seconds=span))
        if on_progress is not None:
            on_progress(place + 1, len(places))
    shares = [friction_shares(calibration, seed=seed) for calibration in (identified, level_only)]
    return PassiveRuns(name, span, identified, level_only, tuple(runs[0]), tuple(runs[1]), *shares)


def friction_shares(calibration: Calibrated, *, count: int = SHARE_POSES, seed: int = 0) -> Array:
    """Largest errors of the torques (n,), at ``count`` random poses and any tilt of the base, as shares of friction.

    Where all are below 1, friction holds what the errors leave: the arm stands still however the base stands.
    """
    check_type(calibration, Calibrated, "calibration")
    rng = np.random.default_rng(as_count(seed, "seed", 0))
    poses = _calibrated_poses(rng, as_count(count, "count", 1, MOST_POSES))
    errors = np.array([calibration.error_at_any_tilt(q) for q in poses])
    shares: Array = errors.max(axis=0) / COULOMB
    return shares


def _calibrated_poses(rng: np.random.Generator, count: int) -> Array:
    low, high = np.radians(CALIBRATED_DEG).T
    return rng.uniform(low, high, (count, len(low)))


def let_go(
    calibration: Calibrated,
    q: npt.ArrayLike,
    *,
    tilt_deg: float = 0.0,
    axis: tuple[float, float] = (1.0, 0.0),
    seconds: float = 60.0,
) -> Drift:
    """Let the calibrated arm go at q (n,) on a tilted base, until time is up or it has fallen by 0.1 m."""
    check_type(calibration, Calibrated, "calibration")
    robot, span = calibration.robot, as_span(seconds, STEP_S, LONGEST_S)
    ((angle, along),) = _tilts([(tilt_deg, axis)])
    plant = Plant(robot, tilted(angle, (*along, 0.0)), step_s=STEP_S, rotor_inertia=ROTORS)
    plant.reset(as_vector(q, "q", robot.n, LARGEST))
    start = plant.q.copy()
    gravity = -plant.accelerometer()
    error = calibration.error(start, gravity)
    seen = watched(
        robot, plant, start, lambda: calibration.torque(plant.q, -plant.accelerometer()),
        seconds=span, step_s=STEP_S, far=FELL_M,
    )  # fmt: skip
    return Drift(angle, along, start, error, seen.time, seen.moved)


def _tilts(tilts: object) -> list[tuple[float, tuple[float, float]]]:
    if not isinstance(tilts, (list, tuple)) or not tilts:
        raise ArgumentError("tilts must be a list of (deg, (x, y)), with at least one")
    found = []
    for tilt in tilts:
        if not isinstance(tilt, (list, tuple)) or len(tilt) != 2:
            raise ArgumentError("a tilt must be (deg, (x, y)), the angle and a horizontal axis")
        degrees, axis = as_number(tilt[0], "tilt"), as_double(tilt[1], "axis")
        if not abs(degrees) <= 360.0 or axis.shape != (2,) or not np.isfinite(axis).all() or not axis.any():
            raise ArgumentError(f"a tilt is {shown(tilt)}; expected -360 to 360 deg and two numbers, not both zero")
        x, y = axis.tolist()
        found.append((degrees, (x, y)))
    return found
