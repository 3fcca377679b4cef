"""What commands note of a robot that is good on a level base only, where gravity is tilted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from ravengc.spec import RobotSpec

__all__ = ["level_only_notes"]

LEVEL_WITHIN_DEG = 0.5
"""Tilt up to which nothing is noted: an error of a hundredth of the torque."""


def level_only_notes(robot: RobotSpec, gravity: npt.ArrayLike) -> tuple[str, ...]:
    """One line where a robot marked ``level_only`` meets a gravity (..., 3) in base axes that is tilted, else none."""
    if not robot.level_only:
        return ()
    x, y, z = (np.asarray(gravity, dtype=np.float64) @ np.array(robot.base.rotation)).T
    tilt = float(np.degrees(np.arctan2(np.hypot(x, y), -z)).max())
    if not tilt > LEVEL_WITHIN_DEG:
        return ()
    where = f"gravity is tilted by {tilt:.1f} deg from -z of its frame 0"
    return (f"robot '{robot.name}' is for a level base only (level_only), and {where}: its torques are wrong there",)
