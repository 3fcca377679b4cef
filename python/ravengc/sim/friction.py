"""Coulomb friction over one step: at each coordinate the force that stops it, or its limit where that is not enough.

Of all forces within their limits the one is sought that leaves the residual zero wherever it is below its limit,

    residual = v+ - (1 - b h) v - h R F,        v+ = v0 - W F,      |F| <= limit

with v the rates before the step, v0 those after it without friction, W the change of rate by forces held for the
step h. Two models differ in b and R:

    stick       b = 1/h, R = 0: the residual is v+ itself. What sticks stands still.
    soft        b = 2 / (0.95 * 20 ms), R_i = W_ii / (9 h): MuJoCo's ``frictionloss`` with its default ``solref``
                and ``solimp`` (impedance 0.9): what sticks creeps at 1 mm/s for each m/s^2 that the forces on it,
                friction left out, would give, as 1/(9 b) is 1.06 ms.

Solved by projected Gauss-Seidel from the last step's forces, in floats: for a dozen coordinates or fewer that is
several times faster than arrays.
"""

from __future__ import annotations

from operator import mul
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["FRICTION_MODELS", "CoulombFriction"]

Array = NDArray[np.float64]

FRICTION_MODELS = ("stick", "soft")
MOST_SWEEPS = 50
TOLERANCE = 1e-9
SOFT_RATE = 2.0 / (0.95 * 0.02)
"""b of MuJoCo's defaults (1/s): solref (0.02, 1), solimp (0.9, 0.95, ...)."""
SOFTNESS = (1.0 - 0.9) / 0.9


class CoulombFriction:
    """Friction of n coordinates with these limits (n,), N m or N, by ``model``; ``force`` is that of the last step."""

    def __init__(self, limits: Sequence[float], model: Literal["stick", "soft"]) -> None:
        self._limits = [float(limit) for limit in limits]
        self._rubbing = [i for i, limit in enumerate(self._limits) if limit > 0.0]
        self._soft = model == "soft"
        self._close_enough = TOLERANCE * max(self._limits)
        self.force = [0.0] * len(self._limits)

    @property
    def present(self) -> bool:
        """Whether any coordinate rubs."""
        return bool(self._rubbing)

    def reset(self) -> None:
        """Forget the last step's forces."""
        self.force[:] = [0.0] * len(self.force)

    def rub(self, before: Array, after: Array, change: Array, h: float) -> Array:
        """Find the forces of a step: rates before it and after it without friction (n,), and W (n, n)."""
        force, limits = self.force, self._limits
        rows: list[list[float]] = change.tolist()
        give = [SOFTNESS * row[i] if self._soft else 0.0 for i, row in enumerate(rows)]
        residual: list[float] = after.tolist()
        if self._soft:
            kept = max(0.0, 1.0 - SOFT_RATE * h)
            residual = [new - kept * old for new, old in zip(residual, before.tolist(), strict=True)]
        for i, row in enumerate(rows):
            residual[i] -= sum(map(mul, row, force)) + give[i] * force[i]
        for _ in range(MOST_SWEEPS):
            largest = 0.0
            for i in self._rubbing:
                row, old = rows[i], force[i]
                new = old + residual[i] / (row[i] + give[i])
                limit = limits[i]
                if new > limit:
                    new = limit
                elif new < -limit:
                    new = -limit
                step = new - old
                if step != 0.0:
                    force[i] = new
                    largest = max(largest, abs(step))
                    residual = [rest - step * share for rest, share in zip(residual, row, strict=True)]
                    residual[i] -= step * give[i]
            if largest <= self._close_enough:
                break
        return np.array(force)
