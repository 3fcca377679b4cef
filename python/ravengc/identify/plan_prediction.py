"""How uncertain the torques will be that hold the robot on a tilted base, from the plan alone.

Rows X of a plan in units of the noise leave parameters with the covariance (XᵀX)⁻¹, whatever is measured; a torque
Y p has the variance Y (XᵀX)⁻¹ Yᵀ. A torque that depends on what no row shows is open: its uncertainty is infinite.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_count, as_double, check_type
from ravengc.errors import ArgumentError
from ravengc.identify.base_parameters import base_parameters
from ravengc.identify.model import Model
from ravengc.identify.plan_space import as_tilt, directions, joint_ranges, poses_within, standing
from ravengc.identify.ranks import triangle
from ravengc.identify.recording import FloatArray, Recording
from ravengc.messages import shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["Prediction", "per_joint", "predict_uncertainty", "predicted"]

NOISE = 0.01
STEPS = 9
POSES = 64
SEED = 1972
UNSEEN = 1e-10
"""Singular value, as a share of the largest, below which rows say nothing."""
ROUNDING = 1e-8
"""Singular value below which rows say nothing even where it is the largest: an uncertainty of 1e8 N·m is rounding's."""
OUTSIDE = 1e-6
"""Part of a row, in columns of unit size, outside of what the plan's rows span above which its torque is open."""


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """Standard deviation ``sd`` (m, n), N·m or N, of the torques that hold the robot at base tilts ``angles`` (m,) rad.

    Root mean square over poses, in the worst direction of the tilt; ``inf`` where a torque depends on parameters that
    nothing measured shows.
    """

    angles: FloatArray
    sd: FloatArray

    @property
    def worst(self) -> FloatArray:
        """Of every joint at the worst tilt, (n,)."""
        return np.asarray(self.sd.max(axis=0))


def predict_uncertainty(
    robot: Robot,
    model: Model,
    recording: Recording,
    *,
    tilt: float = np.radians(10.0),
    noise: float | npt.ArrayLike = NOISE,
    poses: npt.ArrayLike | None = None,
    steps: int = STEPS,
) -> Prediction:
    """Predict the uncertainty of holding torques at tilts up to ``tilt`` (rad), from what is, or will be, recorded.

    The torques of ``recording`` are not used; those that do not count show nothing. ``noise`` is the standard deviation
    of one sample's torque, N·m or N, one number or (n,); samples are taken as independent, which close samples of one
    motion are not. ``poses`` (k, n) are those in which the torques are wanted; by default 64 within the joints' limits.
    """
    check_type(robot, Robot, "robot")
    check_type(model, Model, "model")
    check_type(recording, Recording, "recording")
    if recording.joints != robot.n:
        raise ArgumentError(f"{recording.source} has {recording.joints} joints; expected {robot.n}")
    wanted = _wanted(robot, poses)
    chosen = base_parameters(robot, model, "tilted").chosen
    sigma = per_joint(noise, robot.n, "noise")
    rows = model.regressor(robot, recording)[:, chosen] / np.tile(sigma, recording.samples)[:, np.newaxis]
    rows = rows[recording.counts.ravel()]
    return predicted(robot, model, rows, chosen, wanted, as_tilt(tilt, "tilt"), as_count(steps, "steps", 1, 1000))


def _wanted(robot: Robot, poses: npt.ArrayLike | None) -> FloatArray:
    if poses is None:
        return poses_within(joint_ranges(robot.spec, None), POSES, np.random.default_rng(SEED))
    given = as_double(poses, "poses")
    if given.ndim != 2 or given.shape[1] != robot.n or not len(given) or not np.isfinite(given).all():
        raise ArgumentError(f"poses has shape {given.shape}; expected (k, {robot.n}), finite")
    return given


def per_joint(given: object, joints: int, name: str) -> FloatArray:
    """Positive numbers (n,) from one number or n; ArgumentError for anything else."""
    values = as_double(given, name)
    if values.ndim == 0:
        values = np.full(joints, float(values))
    if values.shape != (joints,) or not (np.isfinite(values) & (values > 0.0)).all():
        raise ArgumentError(f"{name} is {shown(given)}; expected one positive number, or {joints}")
    return values


def predicted(
    robot: Robot,
    model: Model,
    rows: FloatArray,
    chosen: npt.NDArray[np.intp],
    wanted: FloatArray,
    tilt: float,
    steps: int = STEPS,
) -> Prediction:
    """The prediction from rows (N, b) in units of the noise."""
    angles = np.linspace(0.0, tilt, steps) if tilt > 0.0 else np.zeros(1)
    blocks = [_holding(robot, model, wanted, angle)[:, :, :, chosen] for angle in angles]
    scale = np.sqrt(np.mean([(block**2).mean(axis=(0, 1, 2)) for block in blocks], axis=0))
    seen = Seen(rows, scale)
    sd = [np.sqrt((seen.torque_sd(block) ** 2).mean(axis=1)).max(axis=0) for block in blocks]
    return Prediction(angles, np.array(sd))


def _holding(robot: Robot, model: Model, wanted: FloatArray, angle: float) -> FloatArray:
    """Rows that hold the robot in every pose at a tilt to all sides, (directions, poses, n, p)."""
    sides = directions(angle) if angle > 0.0 else np.zeros((1, 2))
    q = np.tile(wanted, (len(sides), 1))
    regressor = model.regressor(robot, standing(q, np.repeat(sides, len(wanted), axis=0)))
    return regressor.reshape(len(sides), len(wanted), robot.n, -1)


class Seen:
    """What rows in units of the noise show of the parameters, in columns of the size they are used in."""

    def __init__(self, rows: FloatArray, scale: FloatArray) -> None:
        size = np.sqrt((rows**2).mean(axis=0))
        biggest = max(float(scale.max(initial=0.0)), float(size.max(initial=0.0)), 1e-300)
        self.scale = np.where(scale > 1e-12 * biggest, scale, np.where(size > 0.0, size, 1.0))
        _, sizes, axes = np.linalg.svd(triangle(rows / self.scale), full_matrices=False)
        kept = sizes > max(UNSEEN * float(sizes.max(initial=0.0)), ROUNDING)
        self.sizes, self.axes = sizes[kept], axes[kept]

    @property
    def condition(self) -> float:
        """Largest over smallest singular value of what is seen."""
        return float(self.sizes[0] / self.sizes[-1]) if self.sizes.size else np.inf

    def torque_sd(self, rows: FloatArray) -> FloatArray:
        """Standard deviation of the torque of every row (..., b); infinite for rows that are not seen."""
        scaled = rows / self.scale
        parts = scaled @ self.axes.T
        sd = np.linalg.norm(parts / self.sizes, axis=-1)
        left = np.linalg.norm(scaled - parts @ self.axes, axis=-1)
        return np.where(left > OUTSIDE, np.inf, sd)
