"""The arm of the paper: RAVEN II, gold, the three positioning joints, its drives, and where its base turns.

Frame 0 of the arm has x up and z along joint 1, horizontal: the base is tilted and rocked about that z, through the
origin of frame 0 or a pivot below it. Masses and centres of mass are those of the control software (the robot file's
default set), link inertias ASSUMED slender rods of length 2|COM| (the third link: a point mass), as the file has them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc.experiments.base_rows import turned
from ravengc.spec import DhRow

__all__ = [
    "INERTIAS",
    "JOINTS",
    "Path",
    "base_axes",
    "held_pose",
    "raven",
    "sinusoid_path",
    "still_path",
    "tilted_gravity",
    "tool_joints",
]

Array = NDArray[np.float64]

JOINTS = ("J1 shoulder", "J2 elbow", "J3 insertion")
INERTIAS = (
    "RAVEN II, gold arm: masses 0.494, 0.750, 0.231 kg and centres of mass of the control software (grav_comp.cpp); "
    "link inertias are ASSUMED slender rods of length 2|COM| along the COM, the carriage a point mass"
)
SINE_CYCLES = 2


@lru_cache(maxsize=1)
def raven() -> ravengc.Robot:
    """Return the gold arm with its default masses."""
    return ravengc.load("raven2_gold")


def base_axes() -> Array:
    """Return the axes of frame 0 in base axes, as rows x0 (up), y0, z0 (along joint 1)."""
    return np.array(raven().spec.base.rotation).T


def tilted_gravity(tilt_deg: float) -> Array:
    """Return gravity (3,) in base axes, on a base that is tilted about z0."""
    level = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))
    gravity: Array = turned(base_axes()[2], np.array([-np.deg2rad(tilt_deg)]), level)[0]
    return gravity


def held_pose(j1_deg: float = 45.0, j2_deg: float = 90.0, d3: float = 0.33) -> Array:
    """Return joint coordinates (rad, rad, m) of a pose given in degrees and metres."""
    return np.array((np.deg2rad(j1_deg), np.deg2rad(j2_deg), d3))


def tool_joints(points: Array) -> Array:
    """Inverse kinematics of the tool point, (..., 3) in base axes to (..., 3) coordinates, in closed form.

    The axes of joints 1, 2 and the rail of joint 3 meet in the origin, so the tool point is s n with the rail's
    direction n = Rz(t1) Rx(a1) Rz(t2) Rx(a2) e_z and s = d3 - 0.47 m < 0. The third component of n gives t2, whose sine
    is negative within the elbow's limits; then the angles of the first two components give t1.
    """
    offset = raven().spec.tool.translation[2]
    rows = [link.placement for link in raven().spec.links if isinstance(link.placement, DhRow)]
    a1, a2 = rows[1].alpha, rows[2].alpha
    in_frame_0 = points @ np.array(raven().spec.base.rotation)
    s = -np.linalg.norm(in_frame_0, axis=-1)
    n = in_frame_0 / s[..., None]
    t2 = -np.arccos((np.cos(a1) * np.cos(a2) - n[..., 2]) / (np.sin(a1) * np.sin(a2)))
    x, y = np.sin(t2) * np.sin(a2), -np.cos(t2) * np.sin(a2) * np.cos(a1) - np.sin(a1) * np.cos(a2)
    t1 = np.arctan2(n[..., 1], n[..., 0]) - np.arctan2(y, x)
    j1 = np.mod(t1 - rows[0].theta + np.pi, 2.0 * np.pi) - np.pi
    j2 = np.mod(t2 - rows[1].theta, 2.0 * np.pi)
    return np.stack((j1, j2, s - offset), axis=-1)


@dataclass(frozen=True)
class Path:
    """Set-points at a fixed rate: positions ``q`` and velocities ``qd``, (cycles, 3), ``rate_hz`` of them a second."""

    q: Array
    qd: Array
    rate_hz: float


def still_path(pose: Array, duration_s: float, rate_hz: float = 1000.0) -> Path:
    """Set-points of an arm that holds a pose."""
    cycles = round(duration_s * rate_hz)
    return Path(np.tile(pose, (cycles, 1)), np.zeros((cycles, len(pose))), rate_hz)


@lru_cache(maxsize=8)
def sinusoid_path(amplitude: float, period_s: float, cycles: int = SINE_CYCLES, rate_hz: float = 1000.0) -> Path:
    """The paper's test trajectory: sinusoids of the tool point along x0, y0 and z0 in turn, about the middle pose.

    ``amplitude`` (m) is that of the sine; ``cycles`` periods for each direction. Joint velocities are J^-1 v.
    """
    per_direction = round(cycles * period_s * rate_hz)
    time = np.arange(per_direction) / rate_hz
    rate = 2.0 * np.pi / period_s
    swing = amplitude * np.sin(rate * time)[:, None]
    speed = amplitude * rate * np.cos(rate * time)[:, None]
    middle = raven().forward_kinematics(held_pose())[:3, 3]
    q = tool_joints(middle + np.concatenate([swing * axis for axis in base_axes()]))
    velocity = np.concatenate([speed * axis for axis in base_axes()])
    jacobian = raven().jacobian_batch(q, "tool")[:, :3]
    return Path(q, np.linalg.solve(jacobian, velocity[..., None])[..., 0], rate_hz)
