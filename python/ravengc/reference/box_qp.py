"""Rates within limits, in plain NumPy: least squares in a box, manipulability, the step that climbs it.

Nothing is shared with the core, neither formulas nor method: the programme is written with H and c and solved by a
primal active set (one bound at a time, always in the box), the gradient of the manipulability by complex step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_array
from ravengc.errors import ArgumentError
from ravengc.reference.arguments import checked
from ravengc.reference.kinematics import jacobian

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

__all__ = ["Programme", "ascend", "box_minimum", "manipulability", "velocity_box"]

Array = npt.NDArray[Any]
STEP = 1e-30
"""Complex step: small enough that its square vanishes."""


class Programme(NamedTuple):
    """Minimise ½ Σ weight (x - wish)² + ½ Σ row_weight (rows x - target)² subject to lower <= x <= upper.

    ``rows`` (k, n), ``target`` and ``row_weight`` (k,), the others (n,). ``weight`` > 0; bounds may be infinite.
    """

    rows: Array
    target: Array
    row_weight: Array
    wish: Array
    weight: Array
    lower: Array
    upper: Array

    @property
    def H(self) -> Array:  # noqa: N802 the letter of the literature
        """Second derivative of the cost (n, n)."""
        curved: Array = np.diag(self.weight) + self.rows.T @ np.diag(self.row_weight) @ self.rows
        return curved

    @property
    def c(self) -> Array:
        """The cost is ½ xᵀ H x + cᵀ x and a constant (n,)."""
        pulled: Array = -self.weight * self.wish - self.rows.T @ (self.row_weight * self.target)
        return pulled

    def cost(self, x: Array) -> float:
        """What is minimised."""
        own, task = self.weight @ (x - self.wish) ** 2, self.row_weight @ (self.rows @ x - self.target) ** 2
        return float(own + task) / 2.0


def box_minimum(programme: Programme) -> Array:
    """The minimum (n,) by a primal active set, after J. Nocedal and S. J. Wright, Numerical Optimization, 2006, 16.5.

    The free variables go towards their minimum, as far as the box allows. One that meets its bound is bound; at the
    minimum, the bound that holds back most is left. ArgumentError where the box is empty or a weight is not positive.
    """
    programme = _meant(programme)
    hessian, c, low, high = programme.H, programme.c, programme.lower, programme.upper
    x: Array = np.clip(0.0, low, high)
    free = (low < x) & (x < high)
    for _ in range(100 * len(x)):
        step = np.zeros_like(x)
        step[free] = np.linalg.solve(hessian[np.ix_(free, free)], -(hessian @ x + c)[free])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            room = np.where(step > 0.0, (high - x) / step, np.where(step < 0.0, (low - x) / step, np.inf))
        nearest = int(np.argmin(room))
        if room[nearest] < 1.0:
            x = x + max(room[nearest], 0.0) * step
            x[nearest] = high[nearest] if step[nearest] > 0.0 else low[nearest]
            free[nearest] = False
            continue
        x = x + step
        downhill = np.where(free | (low == high), 0.0, np.where(x == low, -1.0, 1.0) * (hessian @ x + c))
        if np.max(downhill, initial=0.0) <= 1e-13 * np.max(np.abs(c), initial=1.0):
            return x
        free[int(np.argmax(downhill))] = True
    return x


def velocity_box(
    q: npt.ArrayLike, limits: tuple[Array, Array, Array], damper: tuple[float, float, float], dt: float
) -> tuple[Array, Array]:
    """Rates (n,), (n,) allowed at ``q``: B. Faverjon and P. Tournassoud, ICRA 1987, and no limit passed in ``dt``.

    ``limits``: lowest and highest positions and largest rates, (n,) each. ``damper``: from which distance it slows
    down, where it stops, and what rate it allows at the first (1/s).
    """
    low, high, rate = limits
    influence, stop, gain = damper
    position = as_array(q, "q")

    def slowed(room: Array) -> Array:
        damped = np.where(room < influence, gain * (room - stop) / (influence - stop), np.inf)
        return np.clip(np.minimum(damped, room / dt), -rate, rate)

    down, up = -slowed(position - low), slowed(high - position)
    squeezed = down > up
    return np.where(squeezed, 0.0, down), np.where(squeezed, 0.0, up)


@checked
def manipulability(spec: RobotSpec, q: npt.ArrayLike, frame: str = "tool") -> tuple[float, Array]:
    """Yoshikawa's m = √det(J Jᵀ) and ∂m/∂q (n,): m Σ (∂J/∂qⱼ)∘((J Jᵀ)⁻¹ J), the derivative by complex step."""
    position = np.asarray(q, dtype=float)
    rows = jacobian(spec, position, frame)
    m = float(np.sqrt(max(np.linalg.det(rows @ rows.T), 0.0)))
    solved = np.linalg.solve(rows @ rows.T, rows)
    steps = STEP * np.eye(len(position))
    changes = (np.imag(jacobian(spec, position + 1j * step, frame)) / STEP for step in steps)
    return m, np.array([m * np.sum(solved * change) for change in changes])


def ascend(programme: Programme, gradient: npt.ArrayLike, progress: float = 0.5) -> Array:
    """Rates (n,) that follow the rows and climb ``gradient`` (n,): Haviland and Corke, arXiv 2002.11901, with a floor.

    ``programme`` is that of the task alone: no wish, the effort Y as weights and 1/e as weights of the rows. Of the way
    that the task alone would go, the part ``progress`` is gone whatever the gradient says; 0 is theirs.
    """
    climbing = programme._replace(wish=programme.wish + as_array(gradient, "gradient") / programme.weight)
    task, up = box_minimum(programme), box_minimum(climbing)
    along = programme.rows.T @ programme.target
    missing, gained = progress * (along @ task) - along @ up, along @ (task - up)
    part = min(missing / gained, 1.0) if missing > 0.0 and gained > 0.0 else 0.0
    mixed: Array = up + part * (task - up)
    return mixed


def _meant(programme: Programme) -> Programme:
    """The programme as arrays, or ArgumentError."""
    named = Programme(*(as_array(value, name) for name, value in zip(Programme._fields, programme, strict=True)))
    if not np.all(named.weight > 0.0):
        raise ArgumentError(f"weight is {named.weight}; expected positive numbers")
    if not np.all(named.lower <= named.upper):
        raise ArgumentError(f"lower is {named.lower} and upper {named.upper}; expected lower <= upper everywhere")
    return named
