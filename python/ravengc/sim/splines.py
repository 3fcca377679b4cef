"""Twice differentiable curves through samples, as polynomials in pieces: (k, columns, 6) factors of 1, s, ..., s^5.

``times`` (k + 1,) increase; values are (k + 1, columns); s is the time since the begin of a piece.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["natural_cubic", "quintic", "slopes", "twice_integrated"]

Array = NDArray[np.float64]


def natural_cubic(times: Array, values: Array) -> Array:
    """Return the cubic spline whose second derivative is continuous, and zero at both ends."""
    h = np.diff(times)[:, None]
    slope = np.diff(values, axis=0) / h
    curvature = np.zeros_like(values)
    curvature[1:-1] = _tridiagonal(h[:, 0], 6.0 * np.diff(slope, axis=0))
    pieces = np.zeros((len(h), values.shape[1], 6))
    pieces[..., 0] = values[:-1]
    pieces[..., 1] = slope - h * (2.0 * curvature[:-1] + curvature[1:]) / 6.0
    pieces[..., 2] = curvature[:-1] / 2.0
    pieces[..., 3] = np.diff(curvature, axis=0) / (6.0 * h)
    return pieces


def slopes(times: Array, pieces: Array) -> Array:
    """First derivatives at all times, (k + 1, columns)."""
    s = times[-1] - times[-2]
    last = pieces[-1] @ np.array((0.0, 1.0, 2.0 * s, 3.0 * s**2, 4.0 * s**3, 5.0 * s**4))
    return np.vstack((pieces[..., 1], last))


def quintic(times: Array, values: Array, rates: Array, accelerations: Array) -> Array:
    """Return the pieces that have these values and first and second derivatives at all times."""
    h = np.diff(times)[:, None]
    pieces = np.zeros((len(h), values.shape[1], 6))
    pieces[..., 0], pieces[..., 1], pieces[..., 2] = values[:-1], rates[:-1], accelerations[:-1] / 2.0
    # what the last three terms must add, at s = h, to value, h rate and h^2 acceleration
    value = values[1:] - values[:-1] - h * rates[:-1] - h**2 * accelerations[:-1] / 2.0
    rate = h * (rates[1:] - rates[:-1]) - h**2 * accelerations[:-1]
    bend = h**2 * (accelerations[1:] - accelerations[:-1])
    pieces[..., 3] = (10.0 * value - 4.0 * rate + 0.5 * bend) / h**3
    pieces[..., 4] = (-15.0 * value + 7.0 * rate - bend) / h**4
    pieces[..., 5] = (6.0 * value - 3.0 * rate + 0.5 * bend) / h**5
    return pieces


def twice_integrated(spans: Array, first: Array, last: Array) -> Array:
    """Return the motion from rest at zero whose acceleration goes straight from ``first`` to ``last``, (k, columns).

    ``spans`` (k,) are the lengths of the pieces.
    """
    h = spans[:, None]
    rise = (last - first) / h
    gained = _summed(h * (first + h * rise / 2.0))
    pieces = np.zeros((*first.shape, 6))
    pieces[..., 0] = _summed(h * (gained + h * (first / 2.0 + h * rise / 6.0)))
    pieces[..., 1], pieces[..., 2], pieces[..., 3] = gained, first / 2.0, rise / 6.0
    return pieces


def _summed(changes: Array) -> Array:
    """What has come together before each piece."""
    return np.vstack((np.zeros((1, changes.shape[1])), np.cumsum(changes, axis=0)[:-1]))


def _tridiagonal(h: Array, right: Array) -> Array:
    """Solve h[i-1] x[i-1] + 2 (h[i-1] + h[i]) x[i] + h[i] x[i+1] = right[i]: eliminated forwards, then backwards."""
    diagonal, x = 2.0 * (h[:-1] + h[1:]), right.copy()
    for i in range(1, len(x)):
        factor = h[i] / diagonal[i - 1]
        diagonal[i] -= factor * h[i]
        x[i] -= factor * x[i - 1]
    for i in range(len(x) - 1, -1, -1):
        if i + 1 < len(x):
            x[i] -= h[i + 1] * x[i + 1]
        x[i] /= diagonal[i]
    return x
