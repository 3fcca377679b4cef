"""Where a law leaves an arm with elastic joints: at rest by Newton's method, and in time by integration.

Motors at theta, links at q, damping of the joints d, rotors B (all in joint units)::

    M(q) q'' + C q' + g(q) = K (theta - q) - d q'          B theta'' = u - K (theta - q)
    u = K_P (aim - theta) - K_D theta' + g(at)

At rest u = g(q) and theta = q + K^-1 g(q): one equation for q. ``q_d`` and gravity are constant here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ravengc import _core
from ravengc._convert import as_double, as_number, as_vector, check_choice, check_type
from ravengc.elastic.conditions import inverse_of, positive_matrix
from ravengc.errors import ArgumentError
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]
    At = Literal["nowhere", "q_d", "theta", "theta_biased", "theta_quasi_static", "q"]

__all__ = ["LAWS", "ElasticLaw", "Settled", "settle", "steady_error", "steady_errors"]

NEWTON, HALVINGS = 60, 30
"""Steps of Newton's method, and how often one of them is halved."""

AT_REST = 1e-13
"""What is left of the equation (relative to gravity and gains) where it is solved."""

MOST_STEPS = 10_000_000


@dataclass(frozen=True, slots=True)
class ElasticLaw:
    """Where a law aims the motors (theta_d, or q_d as if rigid), and where it takes gravity."""

    aims_beyond: bool
    at: At
    title: str


LAWS = {
    "pd": ElasticLaw(False, "nowhere", "PD, motors at q_d"),
    "pd_aimed": ElasticLaw(True, "nowhere", "PD, motors at theta_d"),
    "rigid_motor": ElasticLaw(False, "theta", "as if rigid: motors at q_d, g(theta)"),
    "rigid_desired": ElasticLaw(False, "q_d", "as if rigid: motors at q_d, g(q_d)"),
    "desired": ElasticLaw(True, "q_d", "g(q_d) (Tomei)"),
    "motor": ElasticLaw(True, "theta", "g(theta)"),
    "biased": ElasticLaw(True, "theta_biased", "g(theta - K^-1 g(q_d)) (De Luca, Siciliano, Zollo)"),
    "quasi_static": ElasticLaw(True, "theta_quasi_static", "g(qbar(theta)) (Ott et al.)"),
    "link": ElasticLaw(True, "q", "g(q)"),
}
"""The variants of :class:`ravengc.ElasticGravity`, and before them what is done without it."""


@dataclass(frozen=True, slots=True)
class Settled:
    """The end of a run of :func:`settle`: positions (n,) of links and motors, and the largest |u| (n,) on the way."""

    q: Array
    theta: Array
    peak: Array


class _Arm:
    """An arm with springs, gains, a goal and a constant gravity: checked once."""

    def __init__(
        self, robot: Robot, stiffness: ArrayLike, kp: ArrayLike, q_desired: ArrayLike, gravity: _core._GravityLike
    ) -> None:
        check_type(robot, Robot, "robot")
        self.robot, self.n = robot, robot.n
        self.springs = positive_matrix(stiffness, "stiffness", self.n)
        self.compliance = inverse_of(self.springs)
        self.kp = positive_matrix(kp, "kp", self.n)
        self.q_d = as_vector(q_desired, "q_desired", self.n)
        self.gravity = _core.Gravity(*_numbers(gravity))
        self.desired = robot.gravity_torque(self.q_d, self.gravity)
        self.theta_d = self.q_d + self.compliance @ self.desired

    def g(self, q: Array) -> Array:
        """Gravity torque (n,)."""
        return self.robot.gravity_torque(q, self.gravity)

    def slope(self, q: Array) -> Array:
        """dg/dq (n, n)."""
        return self.robot.gravity_stiffness(q, self.gravity)


def _numbers(gravity: _core._GravityLike) -> Array:
    if isinstance(gravity, _core.SpecificForce):
        gravity = gravity.as_gravity()
    return as_vector(list(gravity) if isinstance(gravity, _core.Gravity) else gravity, "gravity", 3)


def steady_errors(
    robot: Robot, stiffness: ArrayLike, kp: ArrayLike, q_desired: ArrayLike, gravity: _core._GravityLike
) -> dict[str, Array]:
    """Return how far each of :data:`LAWS` leaves the links from the goal, q - q_desired (n,), at rest near the goal.

    ``stiffness`` and ``kp`` as in :class:`ravengc.ElasticGravity`, positive; ``kp`` acts on the motors. With gains or
    springs too weak for gravity there are other poses at rest: :func:`settle` says which one an arm comes to. NaN where
    none was found near the goal.
    """
    return {law: steady_error(robot, stiffness, kp, q_desired, gravity, law) for law in LAWS}


def steady_error(
    robot: Robot,
    stiffness: ArrayLike,
    kp: ArrayLike,
    q_desired: ArrayLike,
    gravity: _core._GravityLike,
    law: str,
) -> Array:
    """Return q - q_desired (n,) at rest near the goal under one of :data:`LAWS`; see :func:`steady_errors`."""
    check_choice(law, LAWS, "law")
    arm, kind = _Arm(robot, stiffness, kp, q_desired, gravity), LAWS[law]
    aim = arm.theta_d if kind.aims_beyond else arm.q_d
    scale = AT_REST * (np.linalg.norm(arm.desired) + np.linalg.norm(arm.kp) + 1e-300)
    q = arm.q_d.copy()
    left, slope = _unbalance(arm, aim, kind.at, q)
    for _ in range(NEWTON):
        if np.linalg.norm(left) <= scale:
            return q - arm.q_d
        step = np.asarray(np.linalg.lstsq(slope, -left, rcond=None)[0], np.float64)
        q, left, slope = _closer(arm, aim, kind.at, q, step, float(np.linalg.norm(left)))
    return np.full(arm.n, np.nan)


def _closer(arm: _Arm, aim: Array, at: At, q: Array, step: Array, before: float) -> tuple[Array, Array, Array]:
    """Go as much of a step as makes the unbalance smaller."""
    for halvings in range(HALVINGS):
        there = q + step * 0.5**halvings
        left, slope = _unbalance(arm, aim, at, there)
        if np.linalg.norm(left) < before:
            break
    return there, left, slope


def _unbalance(arm: _Arm, aim: Array, at: At, q: Array) -> tuple[Array, Array]:
    """Return K_P (aim - theta) + g(at) - g(q) with theta = q + K^-1 g(q), and its derivative by q."""
    g, slope = arm.g(q), arm.slope(q)
    theta, moves = q + arm.compliance @ g, np.eye(arm.n) + arm.compliance @ slope
    fed, fed_slope = _fed_forward(arm, at, theta, moves, g, slope)
    return arm.kp @ (aim - theta) + fed - g, fed_slope - arm.kp @ moves - slope


def _fed_forward(arm: _Arm, at: At, theta: Array, moves: Array, g: Array, slope: Array) -> tuple[Array, Array]:
    """Gravity as the law takes it, with its derivative; ``moves`` is dtheta/dq."""
    match at:
        case "nowhere":
            return np.zeros(arm.n), np.zeros((arm.n, arm.n))
        case "q_d":
            return arm.desired, np.zeros((arm.n, arm.n))
        case "theta" | "theta_biased":
            where = theta - (arm.theta_d - arm.q_d) * (at == "theta_biased")
            return arm.g(where), arm.slope(where) @ moves
        case _:  # at rest the links are where the quasi-static law thinks
            return g, slope


def settle(
    robot: Robot,
    stiffness: ArrayLike,
    kp: ArrayLike,
    q_desired: ArrayLike,
    gravity: _core._GravityLike,
    law: str,
    *,
    kd: ArrayLike,
    motor_inertia: ArrayLike,
    joint_damping: ArrayLike = 0.0,
    start: ArrayLike | None = None,
    seconds: float = 25.0,
    step_s: float = 5e-3,
) -> Settled:
    """Let the arm move under one of :data:`LAWS` from rest: its links at ``start`` (zero), held there by its motors.

    ``kd`` (n,) acts on the motors; ``motor_inertia`` B (n,) kg m^2 and ``joint_damping`` (one number or n) N m s/rad
    are in joint units. Classical Runge-Kutta with steps of ``step_s``, which must resolve the springs on their rotors:
    about ``step_s < 2 sqrt(B / (K + K_P))``. NaN where it did not.
    """
    check_choice(law, LAWS, "law")
    arm, kind = _Arm(robot, stiffness, kp, q_desired, gravity), LAWS[law]
    inertia, damping = as_vector(motor_inertia, "motor_inertia", arm.n), as_vector(kd, "kd", arm.n)
    one_for_all = as_double(joint_damping, "joint_damping")
    joints = as_vector(np.full(arm.n, one_for_all) if not one_for_all.ndim else one_for_all, "joint_damping", arm.n)
    if not ((inertia > 0.0).all() and (damping >= 0.0).all() and (joints >= 0.0).all()):
        raise ArgumentError("motor_inertia must be positive, kd and joint_damping not negative")
    if not np.isfinite(arm.springs).all():
        raise ArgumentError(
            "stiffness is infinite for a joint: a motor that is rigid with its link is no motor of its own"
        )
    steps, h = _steps(seconds, step_s)
    effort = _effort(arm, kind, damping)

    def slope(x: Array) -> Array:
        q, theta, qd, thetad = x
        pull = arm.springs @ (theta - q)
        qdd = robot.forward_dynamics(q, qd, pull - joints * qd, arm.gravity)
        return np.array((qd, thetad, qdd, (effort(q, theta, thetad) - pull) / inertia))

    x, peak = np.zeros((4, arm.n)), np.zeros(arm.n)
    x[:2] = np.zeros(arm.n) if start is None else as_vector(start, "start", arm.n)
    x[1] += arm.compliance @ arm.g(x[0])
    for _ in range(steps):
        peak = np.maximum(peak, np.abs(effort(x[0], x[1], x[3])))
        a = slope(x)
        b = slope(x + 0.5 * h * a)
        c = slope(x + 0.5 * h * b)
        x = x + h / 6.0 * (a + 2.0 * b + 2.0 * c + slope(x + h * c))
    return Settled(x[0], x[1], peak)


def _steps(seconds: float, step_s: float) -> tuple[int, float]:
    span, step = as_number(seconds, "seconds"), as_number(step_s, "step_s")
    if not (0.0 < step <= span and span / step <= MOST_STEPS):
        raise ArgumentError(
            f"seconds is {seconds}, step_s {step_s}; expected 1 to {MOST_STEPS:,} steps of positive length"
        )
    steps = round(span / step)
    return steps, span / steps


def _effort(arm: _Arm, law: ElasticLaw, damping: Array) -> Callable[[Array, Array, Array], Array]:
    """u(q, theta, theta') of a law."""
    aim = arm.theta_d if law.aims_beyond else arm.q_d
    iterated = _core.ElasticGravity(arm.robot, arm.springs, "quasi_static", np.inf, 64, 0.0)
    sag = arm.theta_d - arm.q_d

    def fed(q: Array, theta: Array) -> Array:
        match law.at:
            case "nowhere":
                return np.zeros(arm.n)
            case "q_d":
                return arm.desired
            case "theta":
                return arm.g(theta)
            case "theta_biased":
                return arm.g(theta - sag)
            case "theta_quasi_static":
                return iterated.torque(theta, arm.q_d, arm.gravity)
            case "q":
                return arm.g(q)

    return lambda q, theta, thetad: arm.kp @ (aim - theta) - damping * thetad + fed(q, theta)
