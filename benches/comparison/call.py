"""One way in which one library does one operation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

OPERATIONS = {
    "gravity": "gravity torque, new gravity vector every call",
    "kinematics": "pose of the tool as a homogeneous matrix",
    "jacobian": "Jacobian of the tool, base axes",
    "inverse_dynamics": "inverse dynamics, base at rest",
    "moving_base": "inverse dynamics on a base that accelerates and turns",
    "mass_matrix": "mass matrix",
    "regressor": "regressor of the inverse dynamics",
}


@dataclass(frozen=True, eq=False)
class Call:
    """``run(k)`` computes cycle k; ``value`` makes an array in this project's convention of what it returned.

    ``fetches`` is the number of lists from which ``run`` takes its inputs, or what else it does before the library is
    called (a sensor that fills bound arrays): that time is measured and subtracted. ``alone`` is then the rest of ``run``.
    """

    library: str
    operation: str
    way: str
    run: Callable[[int], Any]
    fetches: int | Callable[[int], Any]
    value: Callable[[Any], Any] = np.asarray
    alone: Callable[[], Any] | None = None

    @property
    def key(self) -> str:
        """Name in the files written."""
        return f"{self.operation}/{self.library}/{self.way}"
