"""The full nonlinear motion of one link on a springy base under PD+DG, with a delayed, low-passed accelerometer.

The base moves along y, upwards; the link's centre of mass is at l (cos q, sin q) from its joint, so gravity acts on it
too, and the law gives rho m l cos q (g + H y''). Against :class:`ravengc.stability.OneLink`, its linear model.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ravengc.stability import OneLink

__all__ = ["growth_of", "swing"]

Array = NDArray[np.float64]

STEP_S = 0.0005
FIRST_PEAKS = 5


def swing(link: OneLink, *, start: float, duration_s: float) -> Array:
    """Displacement of the base (m) every 0.5 ms, from ``start`` (m) at rest.

    The delay is a whole number of steps; the low-pass, if any, is of first order. Semi-implicit Euler.
    """
    delay = round(link.sensing.delay_s / STEP_S)
    keep = math.exp(-link.sensing.corner * STEP_S) if math.isfinite(link.sensing.corner) else 0.0
    past = [0.0] * (delay + 1)
    y, speed, q, rate = start, 0.0, 0.0, 0.0
    displacement = np.zeros(round(duration_s / STEP_S))
    for step in range(len(displacement)):
        felt = past[step % (delay + 1)]
        acceleration, turning = _accelerations(link, y, speed, q, rate, felt)
        speed += STEP_S * acceleration
        rate += STEP_S * turning
        y += STEP_S * speed
        q += STEP_S * rate
        latest = past[(step - 1) % (delay + 1)] if delay else felt
        past[step % (delay + 1)] = keep * latest + (1.0 - keep) * acceleration
        displacement[step] = y
    return displacement


def _accelerations(link: OneLink, y: float, speed: float, q: float, rate: float, felt: float) -> tuple[float, float]:
    """Accelerations of the base and of the joint: a 2x2 system. The spring's rest is where it carries the weight.

    Gravity on the link and the law's answer to it, m l g cos q, cancel: the model is exact.
    """
    coupling = link.coupling * math.cos(q)
    push = link.coupling * math.sin(q) * rate * rate - link.damping * speed - link.stiffness * y
    torque = -link.kp * q - link.kd * rate + link.sensing.gain * coupling * felt
    determinant = link.total * link.inertia - coupling * coupling
    acceleration = (link.inertia * push - coupling * torque) / determinant
    return acceleration, (link.total * torque - coupling * push) / determinant


def growth_of(displacement: Array) -> float:
    """Rate (1/s) at which the peaks of a swing grow, from a line through their logarithms, its first ones left out."""
    size = np.abs(displacement)
    peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))[FIRST_PEAKS:] + 1
    return float(np.polyfit(peaks * STEP_S, np.log(size[peaks]), 1)[0])
