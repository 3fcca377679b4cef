"""An arm put down somewhere in the plant and left to torques, watched: how far its tool goes from its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_number
from ravengc.errors import ArgumentError

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.robot import Robot
    from ravengc.sim import Plant

__all__ = ["Watched", "as_span", "watched"]

Array = npt.NDArray[np.float64]
GONE = 20.0
"""rad, m: an arm of which a coordinate has moved so far, or to no number at all, is not watched any longer."""
SAMPLES = 500
"""About how many are kept of a run."""


@dataclass(frozen=True, slots=True, eq=False)
class Watched:
    """The tool's distance from its place, ``moved`` m at ``time`` s (samples,), infinite where the arm is gone.

    ``joint`` is the largest motion of a coordinate (rad, m).
    """

    time: Array
    moved: Array
    joint: float


def watched(
    robot: Robot,
    plant: Plant,
    q: Array,
    torque: Callable[[], Array],
    *,
    seconds: float,
    step_s: float,
    far: float = np.inf,
) -> Watched:
    """Put the plant at rest at q (n,), send it ``torque()`` every step, and watch until the tool is ``far`` (m) off."""
    plant.reset(q)
    place = robot.forward_kinematics(q)[:3, 3]
    steps = max(1, round(seconds / step_s))
    every = max(1, steps // SAMPLES)
    moved, joint = [0.0], 0.0
    for step in range(1, steps + 1):
        plant.step(torque(), step_s)
        joint = float(np.maximum(joint, np.abs(plant.q - q).max()))  # no number stays no number
        if not joint <= GONE:
            moved.append(np.inf)
        elif step % every == 0:
            moved.append(float(np.linalg.norm(robot.forward_kinematics(plant.q)[:3, 3] - place)))
        if moved[-1] > far or moved[-1] == np.inf:
            break
    time = np.arange(0, every * len(moved), every, dtype=np.float64) * step_s
    return Watched(time, np.array(moved), joint)


def as_span(seconds: object, step_s: float, longest: float) -> float:
    """How long to watch, s: a step to the longest; ArgumentError for anything else."""
    span = as_number(seconds, "seconds")
    if not step_s <= span <= longest:
        raise ArgumentError(f"seconds is {seconds!r}; expected {step_s:g} to {longest:g}")
    return span
