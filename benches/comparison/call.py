"""One way in which one library does one operation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

OPERATIONS = {
    "gravity": "gravity torque, new gravity vector every call",
    "live": "gravity torque from a live base sensor: its gate, filter and states in the same call",
    "kinematics": "pose of the tool as a homogeneous matrix",
    "jacobian": "Jacobian of the tool, base axes",
    "inverse_dynamics": "inverse dynamics, base at rest",
    "moving_base": "inverse dynamics on a base that accelerates and turns",
    "mass_matrix": "mass matrix",
    "regressor": "regressor of the inverse dynamics",
    "control": "control step: PD + dynamic gravity, within torque limits",
    "control_live": "control step that also steps the base sensor: slot, gate, filter",
}


@dataclass(frozen=True, eq=False)
class Call:
    """``run(k)`` computes cycle k; ``value`` makes an array in this project's convention of what it returned.

    ``fetches`` is the number of lists from which ``run`` takes its inputs: that time is measured and subtracted. Where
    a sensor would fill bound arrays, ``fill(k)`` does it; ``alone()`` is then the cycle, and what is timed. Where its
    cost is ``varied`` with the numbers, hot loops time ``run`` instead, which is bound to the arrays of cycle k.
    """

    library: str
    operation: str
    way: str
    run: Callable[[int], Any]
    fetches: int
    value: Callable[[Any], Any] = np.asarray
    fill: Callable[[int], Any] | None = None
    alone: Callable[[], Any] | None = None
    varied: bool = False

    @property
    def key(self) -> str:
        """Name in the files written."""
        return f"{self.operation}/{self.library}/{self.way}"

    def ready(self, k: int) -> Callable[[int], Any]:
        """What is timed in cycle k: ``run``, or ``alone`` with the arrays filled."""
        if self.fill is None or self.alone is None:
            return self.run
        self.fill(k)
        alone = self.alone
        return lambda _: alone()

    @property
    def hot(self) -> tuple[Callable[[int], Any], int]:
        """What is timed in a hot loop, and from how many lists it takes its inputs."""
        return (self.run, self.fetches) if self.alone is None or self.varied else (self.ready(0), 0)
