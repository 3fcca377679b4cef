"""``ElasticGravity``: the compiled law with the conditions under which it is proven stable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

import numpy as np

from ravengc import _core
from ravengc._convert import as_count, as_double, as_number, check_choice, check_type
from ravengc.elastic.alpha import proven_alpha, stiffest_gravity
from ravengc.elastic.conditions import VARIANTS, WITH_GAINS, Condition, condition_for, positive_matrix
from ravengc.errors import ArgumentError, ConfigError
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from ravengc._core import Accelerometer
    from ravengc.elastic.alpha import Tilt

    Array = NDArray[np.float64]

__all__ = ["VARIANTS", "ElasticGravity"]

MOST_ITERATIONS = 64
"""The core's own limit on the steps of a cycle."""


class ElasticGravity(_core.ElasticGravity):
    """Gravity torque for motors behind springs, with where the motors belong; see :mod:`ravengc.elastic`.

    ``stiffness`` is K in joint units: (n,) N m/rad (N/m), infinite for a rigid joint, or a symmetric (n, n) where
    cables couple. ``variant`` is one of "desired", "motor", "biased", "quasi_static", "link"; ``kp`` the motors' gains
    in joint units, (n,) or (n, n), which the first three need for their condition.

    ``tilt`` ("any", or "level") and ``field`` (m/s^2) say which gravities occur, and with them what alpha is at most;
    ``alpha`` (N m/rad) replaces that bound by a better one that you know. The robot counts as it is now: make a new law
    for a heavier payload. ``iterations`` and ``tolerance`` (rad, m) bound the fixed point of "quasi_static" and
    :meth:`link_position`: a cycle costs one gravity torque for the goal and one for each step.

    Raises ConfigError, with the bound, the numbers and what would do, where the condition does not hold;
    ``allow_unproven=True`` takes the law as it is.
    """

    _condition: Condition | None
    _allow_unproven: bool
    _given: tuple[Robot, Array, float, Tilt, float]

    def __new__(
        cls,
        robot: Robot,
        stiffness: ArrayLike,
        variant: str = "quasi_static",
        *,
        kp: ArrayLike | None = None,
        alpha: float | None = None,
        tilt: Tilt = "any",
        field: float = _core.STANDARD_GRAVITY,
        iterations: int = 16,
        tolerance: float = 1e-9,
        allow_unproven: bool = False,
    ) -> Self:
        """Check the condition and make the law; raises ConfigError or ArgumentError."""
        check_type(robot, Robot, "robot")
        check_type(allow_unproven, bool, "allow_unproven")
        check_choice(variant, VARIANTS, "variant")
        positive_matrix(stiffness, "stiffness", robot.n)
        most = proven_alpha(robot, tilt=tilt, field=field) if alpha is None else as_number(alpha, "alpha")
        condition = None
        if kp is not None or not (allow_unproven and variant in WITH_GAINS):
            condition = condition_for(variant, stiffness, most, kp)
        if condition is not None and not condition.holds and not allow_unproven:
            raise ConfigError(_unproven(condition, robot, tilt, field))
        steps = as_count(iterations, "iterations", 1, MOST_ITERATIONS)
        close = as_number(tolerance, "tolerance")
        if not close >= 0.0:
            raise ArgumentError(f"tolerance is {tolerance}; expected rad (m), zero or more")
        springs = condition_for("quasi_static", stiffness, most)
        per_field = springs.contraction / field if field else 0.0
        law = super().__new__(cls, robot, stiffness, variant, per_field, steps, close)
        law._condition, law._allow_unproven = condition, allow_unproven
        law._given = robot, np.array(as_double(stiffness, "stiffness")), most, tilt, field
        return law

    @property
    def condition(self) -> Condition | None:
        """The condition under which the law is proven stable, with its numbers; None if it was not even weighed."""
        return self._condition

    def require(self, kp: ArrayLike) -> None:
        """Raise ConfigError if the condition does not hold with gains ``kp``, (n,) or (n, n) N m/rad in joint units.

        A law that was made with ``allow_unproven`` accepts any. What else counts is what the law was made with.
        """
        if self._allow_unproven or self.variant not in WITH_GAINS:
            return
        robot, stiffness, alpha, tilt, field = self._given
        condition = condition_for(self.variant, stiffness, alpha, kp)
        if not condition.holds:
            raise ConfigError(f"with these gains: {_unproven(condition, robot, tilt, field)}")

    def bind(
        self,
        *,
        theta: Array,
        q_desired: Array,
        gravity: Array | Accelerometer,
        out: Array,
        q: Array | None = None,
        theta_desired: Array | None = None,
    ) -> Callable[[], None]:
        """Bind the law to arrays: ``cycle()`` reads theta, q_desired (n,) and gravity (3,), and writes out (n,).

        With an Accelerometer as ``gravity``, each call steps it too. It also writes theta_desired (n,), where the
        motors belong, and reads q (n,), the links (variant "link"), if they are given. The arrays are checked once and
        held, as in :meth:`ravengc.Robot.bind`; a call allocates nothing.
        """
        return _core.bind_elastic_gravity(self, theta, q_desired, gravity, out, q, theta_desired).step

    def __repr__(self) -> str:
        return f"<ElasticGravity {self.variant}: {self._condition.says if self._condition else 'not weighed'}>"


def _unproven(condition: Condition, robot: Robot, tilt: Tilt, field: float) -> str:
    """Say what is violated, by which numbers, and what would do."""
    found = stiffest_gravity(robot, tilt=tilt, field=field).found
    means = f"{found:.6g} was found by search; give alpha= if you know a better bound than the proven one"
    return f"{condition.says} ({means}, or allow_unproven=True to go without)"
