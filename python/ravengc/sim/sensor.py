"""An accelerometer that is read at its own rate: between its samples a control loop sees the last one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_number, as_vector
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["SampledAccelerometer"]

Array = NDArray[np.float64]


class SampledAccelerometer:
    """Reads a specific force at ``hz`` and gives it, with white ``noise`` (m/s^2), as a gravity vector.

    ``read`` takes nothing and returns (3,), m/s^2, base axes. The first sample comes one period after the start.
    Until then ``gravity`` is the ``nominal`` vector; afterwards it is minus the last sample. ``gravity`` (3,) is
    updated in place, so a bound cycle can read it.
    """

    def __init__(
        self, read: Callable[[], Array], *, nominal: Array, hz: float = 100.0, noise: float = 0.0, seed: int = 0
    ) -> None:
        if not callable(read):
            raise ArgumentError(f"read is a {type(read).__name__}; expected a function without arguments")
        if not (0.0 < as_number(hz, "hz") <= LARGEST and 0.0 <= as_number(noise, "noise") <= LARGEST):
            expected = f"hz must be positive and noise not negative, both at most {LARGEST:g}"
            raise ConfigError(f"accelerometer: {expected}, not hz={hz}, noise={noise}")
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise ConfigError(f"accelerometer: seed must be a whole number from 0, not {shown(seed)}")
        self.gravity = as_vector(nominal, "nominal", 3).copy()
        self.age = math.nan
        self._read = read
        self._hz = hz
        self._noise = noise
        self._random = np.random.default_rng(seed)
        self._samples = 0
        self._stamp = math.nan

    def update(self, time: float) -> None:
        """Take the sample that is due at ``time`` (s since the start), if there is one, and work out the ``age`` (s).

        The age is NaN before the first sample. Of several samples that were missed, only the latest counts.
        """
        due = math.floor(time * self._hz + 1e-6)
        if due > self._samples:
            self._samples = due
            np.negative(self._read(), out=self.gravity)
            self.gravity += self._noise * self._random.standard_normal(3)
            self._stamp = time
        self.age = time - self._stamp
