"""A sensor that is computed: from a function of time or a prescribed base motion, with a real one's imperfections."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_count, as_number, as_vector, check_members
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import kind_of
from ravengc.sensors.pacing import wait_until
from ravengc.sensors.sample import Sample, Statistics

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ravengc.sensors.sample import Triple

__all__ = ["BaseMotion", "SimulatedSensor", "from_base"]

Array = NDArray[np.float64]

FASTEST_HZ = 10_000.0
LONGEST_LATENCY_S = 10.0
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class BaseMotion(Protocol):
    """A motion of the base: :class:`ravengc.sim.BaseTrajectory`, or anything with this method."""

    def motion_at(self, t: float, point: Array) -> tuple[Array, Array, Array]:
        """Specific force at ``point``, angular velocity and angular acceleration, base axes, SI."""


class SimulatedSensor:
    """Samples ``read_at(t)`` at ``rate_hz`` from its opening on; t in s.

    ``read_at`` returns specific force (m/s^2) and angular velocity (rad/s) or None, in sensor axes. ``noise`` (m/s^2)
    and ``gyro_noise`` (rad/s) are the standard deviations of white noise; ``quantisation`` and ``full_scale`` (both
    m/s^2, 0: none) the step and the end of the sensor's range; a sample comes ``latency_s`` after it was taken.
    ``paced`` false gives samples without waiting, with the stamps they would have. The same ``seed`` gives the same
    noise.
    """

    def __init__(
        self,
        read_at: Callable[[float], tuple[Any, Any]],
        *,
        rate_hz: float = 100.0,
        noise: float = 0.0,
        gyro_noise: float = 0.0,
        quantisation: float = 0.0,
        full_scale: float = 0.0,
        latency_s: float = 0.0,
        seed: int = 0,
        paced: bool = True,
        name: str = "sim:",
    ) -> None:
        if not callable(read_at):
            raise ArgumentError(f"read_at is {kind_of(read_at)}; expected a function of time")
        self._rate_hz = _within(rate_hz, "rate", FASTEST_HZ, least=1e-3)
        self._noise = _within(noise, "noise"), _within(gyro_noise, "gyro_noise")
        self._step = _within(quantisation, "quantisation")
        self._end = _within(full_scale, "range") or math.inf
        self._latency_ns = round(1e9 * _within(latency_s, "latency", LONGEST_LATENCY_S))
        self._random = np.random.default_rng(as_count(seed, "seed", 0))
        self.name = name
        self.statistics = Statistics()
        self.remark = ""
        self.finished = False
        self._read_at = read_at
        self._paced = paced
        self._start_ns = time.monotonic_ns()
        self._seq = 0

    def read(self, timeout_s: float) -> Sample | None:
        """Wait at most ``timeout_s`` for the next sample."""
        time_s = self._seq / self._rate_hz
        stamp_ns = self._start_ns + round(1e9 * time_s)
        if self._paced and not wait_until(stamp_ns + self._latency_ns, timeout_s):
            return None
        force, rate = self._read_at(time_s)
        sample = Sample(self._seq, stamp_ns, self._sensed(force), None if rate is None else self._turned(rate))
        self._seq += 1
        self.statistics.samples += 1
        return sample

    def close(self) -> None:
        """Nothing is held."""

    def _sensed(self, force: Array) -> Triple:
        noisy = np.asarray(force, float) + self._noise[0] * self._random.standard_normal(3)
        if self._step:
            noisy = self._step * np.round(noisy / self._step)
        x, y, z = np.clip(noisy, -self._end, self._end).tolist()
        return (x, y, z)

    def _turned(self, rate: Array) -> Triple:
        x, y, z = (np.asarray(rate, float) + self._noise[1] * self._random.standard_normal(3)).tolist()
        return (x, y, z)


def from_base(
    base: BaseMotion,
    *,
    position: Sequence[float] = (0.0, 0.0, 0.0),
    rotation: Sequence[Sequence[float]] = IDENTITY,
    gyro: bool = True,
    **options: Any,
) -> SimulatedSensor:
    """A sensor on a moving base, at ``position`` (m, base axes), turned by ``rotation`` (R_BS: base <- sensor).

    f_S = R_BS^T f_B(position), w_S = R_BS^T w_B; ``gyro`` false leaves w out. ``options`` are SimulatedSensor's.
    """
    check_members(base, ("motion_at",), "base")
    place = as_vector(position, "position", 3)
    to_sensor = np.array([as_vector(row, "rotation", 3) for row in rotation]).T

    def read_at(t: float) -> tuple[Array, Array | None]:
        force, rate, _ = base.motion_at(t, place)
        return to_sensor @ force, to_sensor @ rate if gyro else None

    return SimulatedSensor(read_at, **options)


def _within(value: float, name: str, most: float = 1e9, least: float = 0.0) -> float:
    number = as_number(value, name)
    if not least <= number <= most:
        raise ConfigError(f"simulated sensor: {name} is {number:g}; expected a number from {least:g} to {most:g}")
    return number
