"""An accelerometer, with a gyro if wanted, that is read at its own rate: between samples a loop sees the last one."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_double, as_number, as_vector, check_choice
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import kind_of, shown
from ravengc.monitored import MonitoredSensor, chain_for

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

__all__ = ["SampledAccelerometer"]

Array = NDArray[np.float64]

SLOWEST_HZ, FASTEST_HZ = 1.0, 1e5
LONGEST_LATENCY_S = 10.0
STAMPS = ("taken", "arrived")


class Sample(NamedTuple):
    """A sample under way: when it arrives (ns), its number, and what was felt."""

    arrives: int
    number: int
    taken: int
    force: Array
    rate: Array | None


class SampledAccelerometer(MonitoredSensor):
    """Reads a specific force at ``hz`` and hands it to the sensor's chain ``latency_s`` later.

    ``read`` takes nothing and returns the specific force (3,), m/s^2, sensor axes; ``gyro``, if given, the angular
    velocity (3,), rad/s. The sensor says scale @ f + bias + noise: ``noise`` and ``gyro_noise`` are standard deviations
    of white noise, ``bias`` and ``gyro_bias`` (3,) constant, ``scale`` one factor or a (3, 3) matrix of sensitivities
    and misalignments. ``stamp`` says what time a sample carries: when it was "taken", so that the chain knows its age,
    or when it "arrived", as where the computer puts the stamp.

    The first sample is taken one period after the start. The chain is one for this rate and latency, without a low-pass
    (and without noise, one that lets numbers repeat), unless ``chain`` settings (:class:`ravengc.Accelerometer`) say
    otherwise; ``position`` is the place of the sensor, whose lever arm the chain takes out. ``gravity`` (3,) is updated
    in place, and with it ``angular_velocity`` and ``angular_acceleration`` (3,), zero without a gyro: together the
    motion of the base origin. Time is the plant's, from 0 s.
    """

    def __init__(
        self,
        read: Callable[[], Array],
        *,
        hz: float = 100.0,
        noise: float = 0.0,
        seed: int = 0,
        latency_s: float = 0.0,
        stamp: Literal["taken", "arrived"] = "taken",
        bias: Sequence[float] = (0.0, 0.0, 0.0),
        scale: float | Sequence[Sequence[float]] = 1.0,
        gyro: Callable[[], Array] | None = None,
        gyro_noise: float = 0.0,
        gyro_bias: Sequence[float] = (0.0, 0.0, 0.0),
        **chain: Any,
    ) -> None:
        for name, function in (("read", read), ("gyro", gyro)):
            if not callable(function) and not (function is None and name == "gyro"):
                raise ArgumentError(f"{name} is {kind_of(function)}; expected a function without arguments")
        _check_rate(hz, noise)
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise ConfigError(f"accelerometer: seed must be a whole number from 0, not {shown(seed)}")
        check_choice(stamp, STAMPS, "stamp")
        self._latency_ns = round(1e9 * _within(latency_s, "latency_s", LONGEST_LATENCY_S))
        self._gyro_noise = _within(gyro_noise, "gyro_noise", LARGEST)
        self._bias, self._gyro_bias = as_vector(bias, "bias", 3, LARGEST), as_vector(gyro_bias, "gyro_bias", 3, LARGEST)
        self._scale = _scale(scale)
        repeats = {} if noise > 0.0 else {"stuck_count": 0, "axis_stuck_count": 0}
        late = _allowing(hz, 1e-9 * self._latency_ns) if stamp == "taken" else {}
        own = {"cutoff_hz": None, "noise": min(noise, 1.0), **repeats, **late}
        super().__init__(chain_for(hz, **{**own, **chain}))
        self.angular_velocity, self.angular_acceleration = np.zeros(3), np.zeros(3)
        self._read, self._gyro = read, gyro
        self._hz = hz
        self._noise = noise
        self._stamped_when_taken = stamp == "taken"
        self._random = np.random.default_rng(seed)
        self._samples = 0
        self._under_way: deque[Sample] = deque()
        self._lead_ns = 0

    def warm_up(self, patience: float) -> None:
        """Let a chain that must be live before it may be armed see the plant at rest for at most ``patience`` s."""
        while not self.accelerometer.armable and self._lead_ns < 1e9 * patience:
            self.update(1e-3)
            self._lead_ns += 1_000_000

    def update(self, time: float) -> None:
        """Take the sample that is due at ``time`` (s since the start), deliver those that arrive, step the chain.

        Of several samples that were missed, only the latest counts.
        """
        now_ns = self._lead_ns + round(1e9 * time)
        due = math.floor(1e-9 * now_ns * self._hz + 1e-6)
        if due > self._samples:
            self._samples = due
            self._under_way.append(self._taken(due, now_ns))
        while self._under_way and self._under_way[0].arrives <= now_ns:
            sample = self._under_way.popleft()
            stamp = sample.taken if self._stamped_when_taken else sample.arrives
            self.accelerometer.push(sample.number, stamp, sample.force, sample.rate)
        self.step(now_ns)
        if self._gyro is not None:
            motion = self.accelerometer.base_motion
            self.angular_velocity[:] = motion.angular_velocity
            self.angular_acceleration[:] = motion.angular_acceleration

    def _taken(self, number: int, now_ns: int) -> Sample:
        force = self._scale @ self._read() + self._bias + self._noise * self._random.standard_normal(3)
        rate = None
        if self._gyro is not None:
            rate = self._gyro() + self._gyro_bias + self._gyro_noise * self._random.standard_normal(3)
        return Sample(now_ns + self._latency_ns, number, now_ns, force, rate)


def _allowing(hz: float, latency_s: float) -> dict[str, float]:
    """Time limits of a chain whose samples are that much older than those of a sensor without latency."""
    age = max(0.04, 4.0 / hz) + latency_s
    return {
        "max_age_s": age,
        "hold_s": max(0.05, age),
        "fault_after_s": max(0.5, 2.0 * age),
        "no_sensor_s": max(0.045, 4.5 / hz) + latency_s,
    }


def _check_rate(hz: float, noise: float) -> None:
    if not (SLOWEST_HZ <= as_number(hz, "hz") <= FASTEST_HZ and 0.0 <= as_number(noise, "noise") <= LARGEST):
        expected = f"hz must be from {SLOWEST_HZ:g} to {FASTEST_HZ:g} and noise from 0 to {LARGEST:g}"
        raise ConfigError(f"accelerometer: {expected}, not hz={hz:g}, noise={noise:g}")


def _within(value: float, name: str, most: float) -> float:
    number = as_number(value, name)
    if not 0.0 <= number <= most:
        raise ConfigError(f"accelerometer: {name} is {number:g}; expected a number from 0 to {most:g}")
    return number


def _scale(value: float | Sequence[Sequence[float]]) -> Array:
    scale = as_double(value, "scale")
    if scale.shape not in {(), (3, 3)} or not (np.abs(scale) <= LARGEST).all():
        raise ArgumentError(f"scale must be one number or a 3x3 matrix, finite, not {shown(value)}")
    return np.array(scale if scale.ndim else scale * np.eye(3))
