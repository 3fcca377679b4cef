"""The way of a reading from the base's accelerometer to the torque: low-pass, age, sample-and-hold, gain.

    H(s) = rho LP(s) e^(-s T),    T = latency + 1 / (2 sample rate) + 1 / (2 loop rate)

A value that is held for one period is on average half a period old. LP is the chain's own second-order Butterworth
(``ravengc.Accelerometer``, ``cutoff_hz``), a first-order low-pass, or none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_count
from ravengc.stability.ranges import optional, within

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Sensing"]

Complex = Any
"""A complex number or an array of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensing:
    """What lies between the base's acceleration and the gravity that the law takes.

    ``rate_hz`` and ``loop_rate_hz``: samples and cycles per second, each held for one period (None: continuous).
    ``latency_s``: age of a sample when it is used first. ``cutoff_hz``: low-pass of the chain (None: none), of
    ``order`` 1 or 2. ``gain``: the share rho of the measured deviation from rest that the law compensates (1: all of
    it, 0: static gravity). Raises ConfigError for numbers outside their range.
    """

    rate_hz: float | None = 100.0
    latency_s: float = 0.0
    cutoff_hz: float | None = None
    order: int = 2
    gain: float = 1.0
    loop_rate_hz: float | None = None

    def __post_init__(self) -> None:
        """Check every number against its range."""
        checked = {
            "rate_hz": optional(within, self.rate_hz, "rate_hz", 1.0, 1e6, "Hz"),
            "latency_s": within(self.latency_s, "latency_s", 0.0, 10.0, "s"),
            "cutoff_hz": optional(within, self.cutoff_hz, "cutoff_hz", 1e-3, 1e5, "Hz"),
            "order": as_count(self.order, "order", 1, 2),
            "gain": within(self.gain, "gain", 0.0, 100.0, ""),
            "loop_rate_hz": optional(within, self.loop_rate_hz, "loop_rate_hz", 1.0, 1e6, "Hz"),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def with_(self, **changes: Any) -> Sensing:
        """Return the same with some numbers changed."""
        return replace(self, **changes)

    @property
    def hold_s(self) -> float:
        """Mean age of what is held between samples and between cycles, s."""
        return sum(0.5 / rate for rate in (self.rate_hz, self.loop_rate_hz) if rate is not None)

    @property
    def delay_s(self) -> float:
        """T, s."""
        return self.latency_s + self.hold_s

    @property
    def corner(self) -> float:
        """Cut-off of the low-pass, rad/s; infinite without one."""
        return math.inf if self.cutoff_hz is None else 2.0 * math.pi * self.cutoff_hz

    @property
    def lag_s(self) -> float:
        """T and the low-pass's own delay at low frequencies, s: together what the lag rule calls T_tot."""
        return self.delay_s + {1: 1.0, 2: math.sqrt(2.0)}[self.order] / self.corner

    @property
    def polynomial(self) -> NDArray[np.float64]:
        """The low-pass's denominator, lowest power first; it starts with 1."""
        if self.cutoff_hz is None:
            return np.ones(1)
        a = 1.0 / self.corner
        return np.array((1.0, a)) if self.order == 1 else np.array((1.0, math.sqrt(2.0) * a, a * a))

    @property
    def rightmost_filter_pole(self) -> float:
        """Largest real part of the low-pass's poles, 1/s; minus infinity without one."""
        return -self.corner / {1: 1.0, 2: math.sqrt(2.0)}[self.order]

    def response(self, s: Complex) -> Complex:
        """H(s)."""
        return self.gain * np.exp(-s * self.delay_s) / np.polynomial.polynomial.polyval(s, self.polynomial)

    def slope(self, s: Complex) -> Complex:
        """H'(s) / H(s)."""
        p = self.polynomial
        value, slope = (np.polynomial.polynomial.polyval(s, q) for q in (p, np.polynomial.polynomial.polyder(p)))
        return -self.delay_s - slope / value

    def bound(self, radius: float, right_of: float) -> float:
        """Return a bound of abs(H) for all s with abs(s) >= ``radius`` and Re s >= ``right_of``; infinite if none."""
        delayed = self.gain * math.exp(-right_of * self.delay_s)
        if self.cutoff_hz is None:
            return delayed
        beyond = radius / self.corner - 1.0  # every pole of the low-pass lies on the circle of this radius
        falling = beyond**-self.order if beyond > 0.0 else math.inf
        return delayed * (min(falling, 1.0) if right_of >= 0.0 else falling)
