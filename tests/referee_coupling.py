"""What leads from a robot's coordinates to its joints, for referees that know joints only."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec


def coupling(spec: RobotSpec) -> tuple[np.ndarray, np.ndarray]:
    """C and c0 of q_mechanism = C q + c0."""
    if spec.coupling is None:
        return np.eye(len(spec.moving_links)), np.zeros(len(spec.moving_links))
    return np.array(spec.coupling.matrix), np.array(spec.coupling.offset)
