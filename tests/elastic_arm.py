"""The arm of two links with elastic joints on which the laws are tried, written out, and what is known of it.

Links of 2 kg and 1.5 kg move in a vertical plane, their middles 0.25 m from their joints, 0.5 m apart; q1 is counted
from the horizontal. ``STEADY`` are errors at rest in degrees, known to 1e-4.
"""

from __future__ import annotations

import numpy as np

import ravengc as rg

Array = np.ndarray

GRAVITY = (0.0, 0.0, -9.81)
STIFFNESS, KP, KD = np.array((100.0, 80.0)), np.array((60.0, 40.0)), np.array((6.0, 4.0))
MOTORS, DAMPING = np.array((0.05, 0.03)), 0.3
GOAL = np.array((0.3, 0.5))
ALPHA = 16.960204761
LEVEL = {"tilt": "level", "field": 9.81}

STEADY = {
    "pd": (-24.0524, -7.6654),
    "pd_aimed": (-15.6486, -5.3366),
    "rigid_motor": (-9.5122, -2.8275),
    "rigid_desired": (-9.6390, -2.9382),
    "desired": (0.0, 0.0),
    "motor": (-1.1422, -0.7669),
    "biased": (0.0, 0.0),
    "quasi_static": (0.0, 0.0),
    "link": (0.0, 0.0),
}


def two_links() -> rg.Robot:
    """The arm as a robot."""
    rows = [
        {"a": a, "mass": mass, "com": (0.25, 0.0, 0.0), "inertia": (turn, 0.0, 0.0, turn, 0.0, turn)}
        for a, mass, turn in ((0.0, 2.0, 0.05), (0.5, 1.5, 0.03))
    ]
    robot = rg.from_dh(rows, convention="modified", name="two links")
    robot.set_base(((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)))
    return robot


def gravity_torque(q: Array) -> Array:
    """g(q), (..., 2)."""
    second = 3.67875 * np.cos(q[..., 0] + q[..., 1])
    return np.stack((12.2625 * np.cos(q[..., 0]) + second, second), axis=-1)


def accelerations(q: Array, qd: Array, torque: Array) -> Array:
    """M^-1 (torque - C qd), (..., 2), without gravity."""
    h = 1.5 * 0.5 * 0.25
    coupled = 0.03 + 1.5 * 0.25**2
    m22, m12 = coupled, coupled + h * np.cos(q[..., 1])
    m11 = 0.05 + 2.0 * 0.25**2 + 1.5 * 0.5**2 + coupled + 2.0 * h * np.cos(q[..., 1])
    s = h * np.sin(q[..., 1])
    left1 = torque[..., 0] + s * (2.0 * qd[..., 0] + qd[..., 1]) * qd[..., 1]
    left2 = torque[..., 1] - s * qd[..., 0] ** 2
    determinant = m11 * m22 - m12**2
    return np.stack((m22 * left1 - m12 * left2, m11 * left2 - m12 * left1), axis=-1) / determinant[..., None]


def link_position(theta: Array) -> Array:
    """The fixed point q = theta - K^-1 g(q)."""
    q = theta
    for _ in range(25):
        q = theta - gravity_torque(q) / STIFFNESS
    return q


def fed_forward(q: Array, theta: Array) -> Array:
    """K_P times the aim, and gravity as each of the laws takes it, in the order of ``STEADY``: (9, 2)."""
    desired = gravity_torque(GOAL)
    beyond = GOAL + desired / STIFFNESS
    aims = (GOAL, beyond, GOAL, GOAL, beyond, beyond, beyond, beyond, beyond)
    torques = (
        np.zeros(2),
        np.zeros(2),
        gravity_torque(theta[2]),
        desired,
        desired,
        gravity_torque(theta[5]),
        gravity_torque(theta[6] - desired / STIFFNESS),
        gravity_torque(link_position(theta[7])),
        gravity_torque(q[8]),
    )
    return KP * np.array(aims) + np.array(torques)


def settled(seconds: float = 25.0, step: float = 5e-3) -> tuple[Array, Array]:
    """Link positions (9, 2) under all laws at once after so long, from rest at q = 0, and the largest |u| (9, 2)."""

    def effort(x: Array) -> Array:
        return fed_forward(x[0], x[1]) - KP * x[1] - KD * x[3]

    def slope(x: Array) -> Array:
        q, theta, qd, thetad = x
        pull = STIFFNESS * (theta - q)
        qdd = accelerations(q, qd, pull - gravity_torque(q) - DAMPING * qd)
        return np.array((qd, thetad, qdd, (effort(x) - pull) / MOTORS))

    x, peak = np.zeros((4, 9, 2)), np.zeros((9, 2))
    x[1] = gravity_torque(x[0]) / STIFFNESS
    for _ in range(round(seconds / step)):
        peak = np.maximum(peak, np.abs(effort(x)))
        a = slope(x)
        b = slope(x + 0.5 * step * a)
        c = slope(x + 0.5 * step * b)
        x = x + step / 6.0 * (a + 2.0 * b + 2.0 * c + slope(x + step * c))
    return x[0], peak
