"""An accelerometer that is read at its own rate: between its samples a control loop sees the last one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_number
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import shown
from ravengc.monitored import MonitoredSensor, chain_for

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["SampledAccelerometer"]

Array = NDArray[np.float64]

SLOWEST_HZ, FASTEST_HZ = 1.0, 1e5


class SampledAccelerometer(MonitoredSensor):
    """Reads a specific force at ``hz``, adds white ``noise`` (m/s^2), and hands it to the sensor's chain.

    ``read`` takes nothing and returns (3,), m/s^2, base axes. The first sample comes one period after the start. The
    chain is one for this rate, without a low-pass (and without noise, one that lets numbers repeat), unless ``chain``
    settings (:class:`ravengc.Accelerometer`) say otherwise. Time is the plant's, from 0 s.
    """

    def __init__(
        self,
        read: Callable[[], Array],
        *,
        hz: float = 100.0,
        noise: float = 0.0,
        seed: int = 0,
        **chain: Any,
    ) -> None:
        if not callable(read):
            raise ArgumentError(f"read is a {type(read).__name__}; expected a function without arguments")
        if not (SLOWEST_HZ <= as_number(hz, "hz") <= FASTEST_HZ and 0.0 <= as_number(noise, "noise") <= LARGEST):
            expected = f"hz must be from {SLOWEST_HZ:g} to {FASTEST_HZ:g} and noise from 0 to {LARGEST:g}"
            raise ConfigError(f"accelerometer: {expected}, not hz={hz:g}, noise={noise:g}")
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise ConfigError(f"accelerometer: seed must be a whole number from 0, not {shown(seed)}")
        repeats = {} if noise > 0.0 else {"stuck_count": 0, "axis_stuck_count": 0}
        super().__init__(chain_for(hz, **{"cutoff_hz": None, "noise": min(noise, 1.0), **repeats, **chain}))
        self._read = read
        self._hz = hz
        self._noise = noise
        self._random = np.random.default_rng(seed)
        self._samples = 0
        self._lead_ns = 0

    def warm_up(self, patience: float) -> None:
        """Let a chain that must be live before it may be armed see the plant at rest for at most ``patience`` s."""
        while not self.accelerometer.armable and self._lead_ns < 1e9 * patience:
            self.update(1e-3)
            self._lead_ns += 1_000_000

    def update(self, time: float) -> None:
        """Take the sample that is due at ``time`` (s since the start), if there is one, and step the chain.

        Of several samples that were missed, only the latest counts.
        """
        now_ns = self._lead_ns + round(1e9 * time)
        due = math.floor(1e-9 * now_ns * self._hz + 1e-6)
        if due > self._samples:
            self._samples = due
            force = self._read() + self._noise * self._random.standard_normal(3)
            self.accelerometer.push(due, now_ns, force)
        self.step(now_ns)
