"""LIVER-500: the benchmark of covering a breathing surface, and LIVER-500-S, through a nearly singular region.

Five hundred points of the upper side of an ellipsoid the size of a liver lobe move by quiet respiration in front of a
Panda with a 103 mm tool, seen 30 times a second, 60 ms late, with 0.3 mm of noise per axis.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_count, check_type
from ravengc.robot import load
from ravengc.track.camera import Camera
from ravengc.track.motions import lujan
from ravengc.track.settings import TrackSettings
from ravengc.track.surface import Surface

if TYPE_CHECKING:
    from ravengc.robot import Robot
    from ravengc.track.motions import Breathing

__all__ = ["liver_500", "liver_surface"]

Array = NDArray[np.float64]

COUNT = 500
SEMI_AXES = (0.075, 0.100, 0.045)
"""m: superior-inferior along x, left-right along y, anterior-posterior along z."""
CENTRE, CENTRE_SINGULAR = (0.520, 0.0, 0.320), (0.480, 0.0, 0.180)
STEEPEST = math.cos(math.radians(45.0))
STRIP_M = 0.006
TOOL_M = 0.2104
"""From joint 7 to the tool centre point."""
START_Q = (0.0, 0.2, 0.0, -2.1, 0.0, 2.3, math.pi / 4.0)
ALONG = (0.95, 0.27, 0.15)
"""Direction of the respiration in base axes."""
CAMERA_SEEDS = 10_000


def liver_500(seed: int = 0, *, singular: bool = False) -> tuple[Robot, Surface, Breathing, Camera, TrackSettings]:
    """Return what ``track`` takes: robot, surface, motion, camera and settings of LIVER-500, or of LIVER-500-S.

    ``seed`` decides the breaths and the camera's noise.
    """
    word = as_count(seed, "seed", 0, 2**62)
    robot = load("panda")
    robot.set_tool(np.eye(3), (0.0, 0.0, TOOL_M))
    motion = lujan(amplitude=0.015, period_s=4.0, variation=0.1, seed=word, direction=ALONG)
    settings = TrackSettings(order="strips", strip_m=STRIP_M, hold_points=10, hold_from_arrival=False, start_q=START_Q)
    return robot, liver_surface(singular=singular), motion, Camera(seed=CAMERA_SEEDS + word), settings


def liver_surface(*, singular: bool = False) -> Surface:
    """The 500 points: the most level ones of the smallest Fibonacci spiral with as many within 45 degrees of up."""
    check_type(singular, bool, "singular")
    count = 600
    while True:
        unit = _fibonacci(count)
        normals = unit / np.array(SEMI_AXES)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        if np.count_nonzero(normals[:, 2] >= STEEPEST) >= COUNT:
            break
        count += 10
    flattest = np.argsort(-normals[:, 2], kind="stable")[:COUNT]
    centre = np.array(CENTRE_SINGULAR if singular else CENTRE)
    name = "LIVER-500-S" if singular else "LIVER-500"
    return Surface(centre + unit[flattest] * np.array(SEMI_AXES), normals[flattest], name)


def _fibonacci(count: int) -> Array:
    """Points of the unit sphere on a Fibonacci spiral, from pole to pole."""
    i = np.arange(count)
    z = 1.0 - (2.0 * i + 1.0) / count
    angle = math.pi * (3.0 - math.sqrt(5.0)) * (i + 0.5)
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle), z))
