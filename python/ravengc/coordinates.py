"""Which coordinates of a robot slide, so that their units are metres and newtons, and which turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import check_type
from ravengc.spec import RobotSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["sliding"]


def sliding(robot: RobotSpec) -> NDArray[np.bool_]:
    """Whether each coordinate slides, (n,); one that moves several joints is of the kind of the first of them."""
    check_type(robot, RobotSpec, "robot")
    prismatic = np.array([link.joint == "prismatic" for link in robot.moving_links])
    if robot.coupling is None:
        return prismatic
    moved = np.array(robot.coupling.matrix) != 0.0
    first: NDArray[np.bool_] = prismatic[np.argmax(moved, axis=0)]
    return first
