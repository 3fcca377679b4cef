"""A base sensor behind its chain, as a loop reads it: gravity in an array that stays, and how far to trust it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import ravengc
from ravengc._convert import as_number, check_type

__all__ = ["STATES", "MonitoredSensor", "chain_for"]

STATES = ("no_data", "nominal", "live", "held", "degraded", "fault")
"""States of the chain; a log holds their numbers."""
_NUMBERS = {name: number for number, name in enumerate(STATES)}
_LIVE = _NUMBERS["live"]
_ALARMS = 0xFFFF_FFFF
"""The bits of a status word that are alarms."""


class MonitoredSensor:
    """The output of an accelerometer's chain after each step.

    ``gravity`` (3,), m/s^2, base axes, is updated in place. ``age`` (s) is that of the last accepted sample, NaN before
    the first; ``state`` is a number of :data:`STATES`, ``status`` the chain's word of alarms.
    """

    def __init__(self, accelerometer: ravengc.Accelerometer) -> None:
        check_type(accelerometer, ravengc.Accelerometer, "accelerometer")
        self.accelerometer = accelerometer
        gravity = accelerometer.gravity
        self.gravity = np.array((gravity.x, gravity.y, gravity.z))
        self.age = math.nan
        self.state = _NUMBERS[accelerometer.state]
        self.status = accelerometer.status

    def step(self, now_ns: int) -> None:
        """Step the chain at ``now_ns``, on the clock of its samples' stamps.

        A live chain leaves that state by an alarm alone, so while there is none its state is not asked for.
        """
        chain = self.accelerometer
        chain.step(now_ns, self.gravity)
        age_ns = chain.age_ns
        self.age = math.nan if age_ns is None else 1e-9 * age_ns
        self.status = status = chain.status
        if self.state != _LIVE or status & _ALARMS:
            self.state = _NUMBERS[chain.state]

    def update(self, time: float) -> None:
        """Take what is due at ``time`` (s) of the loop, and step."""
        self.step(round(1e9 * time))

    def warm_up(self, patience: float) -> None:
        """Let samples come, for at most ``patience`` s, until the chain may be armed."""

    @property
    def remark(self) -> str:
        """What is wrong with what feeds the chain, in words; "" if nothing is known to be."""
        return ""

    def close(self) -> None:
        """Let go of what feeds the chain."""


def chain_for(rate_hz: float, **settings: Any) -> ravengc.Accelerometer:
    """Make the chain of a sensor with this rate, with time limits and a low-pass that slow sensors can keep.

    No sample may be older than 40 ms or four periods, none is held for less than 50 ms, and without any the alarm comes
    after 45 ms or four and a half periods; the low-pass is at 20 Hz or a fifth of the rate. ``settings`` are those of
    :class:`ravengc.Accelerometer` and come first.
    """
    rate = as_number(rate_hz, "rate_hz")
    age = max(0.04, 4.0 / max(rate, 1e-9))
    limits = {"max_age_s": age, "hold_s": max(0.05, age), "fault_after_s": max(0.5, 2.0 * age)}
    filtered = {"cutoff_hz": min(20.0, max(0.2 * rate, 0.2))}
    own = {**limits, **filtered, "no_sensor_s": 1.125 * age, **settings}
    return ravengc.Accelerometer(**{"rate_hz": rate_hz, **own})
