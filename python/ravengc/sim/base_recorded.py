"""Base motions from recordings: poses at times, or what an inertial sensor on the base felt."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_double, as_vector, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError
from ravengc.sim.base_motion import WORLD_GRAVITY
from ravengc.sim.base_profiles import ProfiledBase, powers
from ravengc.sim.hinges import hinge_angles, hinge_rates, orientations
from ravengc.sim.splines import natural_cubic, quintic, slopes, twice_integrated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

__all__ = ["recorded", "recorded_imu"]

Array = NDArray[np.float64]

MOST_SAMPLES = 1_000_000
UNIT = 1e-6
"""How far recorded rotations may be from orthonormal."""
SETTLING_S = 1.0
"""Time in which the turning of a base begins before its recording and ends after it."""
STILL_S = 0.5
"""The first orientation is where the mean specific force of this long points up."""


def recorded(
    times: ArrayLike, position: ArrayLike, rotation: ArrayLike, *, description: str = "recorded poses"
) -> ProfiledBase:
    """Move through poses: ``position`` (k, 3), m, and ``rotation`` (k, 3, 3), R_WB, at ``times`` (k,), s.

    Between them each coordinate is a natural cubic spline, so that accelerations are continuous; they amplify noise of
    the poses (1 mm at 100 Hz is tens of m/s^2): where there is an inertial sensor, :func:`recorded_imu` is better.
    Before and after the recording the base slides on as it did, and stops turning within a second. ArgumentError for
    arrays that do not fit, ConfigError for a base that turns too far about all its axes.
    """
    stamps = _stamps(times)
    places = _rows(position, "position", len(stamps), (3,))
    axes, angles = hinge_angles(_rotations(rotation, len(stamps)))
    pieces = natural_cubic(stamps, np.hstack((places, angles)))
    return _settled(stamps, pieces, axes, description)


def recorded_imu(
    times: ArrayLike,
    specific_force: ArrayLike,
    angular_velocity: ArrayLike,
    *,
    place: Sequence[float] = (0.0, 0.0, 0.0),
    description: str = "recorded by an inertial sensor",
) -> ProfiledBase:
    """Move as a sensor felt: ``specific_force`` (k, 3), m/s^2, ``angular_velocity`` (k, 3), rad/s, at ``times``, s.

    Both are in base axes, felt at ``place`` (m, base axes). At the times of the samples the base has exactly these
    values; between them the angular velocity is as smooth as a cubic spline makes it and the acceleration of the origin
    linear. The first orientation is the one that, unturned about the vertical, has the mean specific force of the first
    half second point up. Drift of a sensor's bias makes the base slide away, which nothing in a plant depends on.
    Before, between and after the samples as :func:`recorded`.
    """
    stamps = _stamps(times)
    force = _rows(specific_force, "specific_force", len(stamps), (3,))
    rate = _rows(angular_velocity, "angular_velocity", len(stamps), (3,))
    arm = as_vector(place, "place", 3, LARGEST)
    curve = natural_cubic(stamps, rate)
    acceleration = slopes(stamps, curve)
    half = np.diff(stamps) / 2.0
    amid = np.einsum("kcp,kp->kc", curve, half[:, None] ** np.arange(6))
    still = stamps <= stamps[0] + STILL_S
    orientation = orientations(stamps, rate, amid, upright(force[still].mean(axis=0)))
    axes, angles = hinge_angles(orientation)
    turning = quintic(stamps, angles, *hinge_rates(axes, angles, rate, acceleration))
    origin = force - np.cross(acceleration, arm) - np.cross(rate, np.cross(rate, arm))
    felt = np.einsum("kij,kj->ki", orientation, origin) + WORLD_GRAVITY
    sliding = twice_integrated(np.diff(stamps), felt[:-1], felt[1:])
    return _settled(stamps, np.concatenate((sliding, turning), axis=1), axes, description)


def upright(force: Array) -> Array:
    """R_WB of the base at rest that feels ``force``: its direction turned the shortest way to the world's z axis."""
    size = float(np.linalg.norm(force))
    if not size > 0.0:
        raise ConfigError("specific_force is zero at the beginning; expected some that shows where up is")
    x, y, z = force / size
    if z < UNIT - 1.0:
        return np.diag((1.0, -1.0, -1.0))
    factor = 1.0 / (1.0 + z)
    xx, xy, yy = x * x * factor, x * y * factor, y * y * factor
    return np.array(((1.0 - xx, -xy, -x), (-xy, 1.0 - yy, -y), (x, y, z)))


def _settled(stamps: Array, pieces: Array, axes: Array, description: str) -> ProfiledBase:
    """Put a piece before and one after, in which the hinges come from rest and go to rest while the slides coast."""
    check_type(description, str, "description")
    first, last = pieces[0] @ powers(0.0), pieces[-1] @ powers(stamps[-1] - stamps[-2])
    before, after = _ending(stamps[0], first, -SETTLING_S), _ending(stamps[-1], last, SETTLING_S)
    times = np.concatenate(([stamps[0] - SETTLING_S], stamps, [stamps[-1] + SETTLING_S]))
    return ProfiledBase(times, np.concatenate((before, pieces, after)), axes=axes, description=description)


def _ending(time: float, state: Array, away: float) -> Array:
    """One piece from a state (6, 3) at ``time`` on, or up to it: slides lose their acceleration, hinges their rate."""
    value, rate, bend = state.T
    coasting = rate + away * bend / 2.0, value + away * (rate + away * bend / 3.0)
    stopped = np.zeros(6), value + away * rate / 2.0
    end_rate, end_value = np.where(np.arange(6) < 3, coasting, stopped)
    near, far = np.stack((value, rate, bend)), np.stack((end_value, end_rate, np.zeros(6)))
    first, last = (near, far) if away > 0.0 else (far, near)
    return quintic(np.sort((time, time + away)), *np.stack((first, last), axis=1))


def _stamps(times: ArrayLike) -> Array:
    stamps = as_double(times, "times")
    increasing = stamps.ndim == 1 and np.isfinite(stamps).all() and bool((np.diff(stamps) > 0.0).all())
    if not increasing or not 3 <= len(stamps) <= MOST_SAMPLES:
        raise ArgumentError(f"times must be 3 to {MOST_SAMPLES} finite numbers that increase")
    return stamps


def _rows(values: ArrayLike, name: str, count: int, shape: tuple[int, ...]) -> Array:
    array = as_double(values, name)
    if array.shape != (count, *shape):
        raise ArgumentError(f"{name} has shape {array.shape}; expected {(count, *shape)}, a row for each time")
    if not (np.abs(array) <= LARGEST).all():
        raise ArgumentError(f"{name} holds a number that is not finite, or above {LARGEST:g}")
    return array


def _rotations(rotation: ArrayLike, count: int) -> Array:
    matrices = _rows(rotation, "rotation", count, (3, 3))
    square = matrices @ matrices.transpose(0, 2, 1)
    wrong = (np.abs(square - np.eye(3)).max(axis=(1, 2)) > UNIT) | (np.linalg.det(matrices) < 0.0)
    if wrong.any():
        which = f"rotation[{int(np.argmax(wrong))}]"
        raise ArgumentError(f"{which} is no rotation matrix; expected orthonormal rows, not mirrored")
    return matrices
