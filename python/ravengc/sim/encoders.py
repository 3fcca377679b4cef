"""Encoders at the motors: what a control loop knows of a plant's joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_count, as_double, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ModelError
from ravengc.messages import shown
from ravengc.sim.plant import Plant

if TYPE_CHECKING:
    from ravengc.spec import TransmissionSpec

__all__ = ["Encoders", "raven2_encoders"]

Array = NDArray[np.float64]
PerCoordinate = float | Sequence[float] | Array

RAVEN2_COUNTS_PER_TURN = 4000.0
RAVEN2_BITS = 24
"""Counts per turn of a RAVEN II motor, inc/motor.h, and bits of its counters, src/dof.cpp, in uw-biorobotics/raven2."""


class Encoders:
    """Incremental encoders of a plant's motors: ``q`` and ``qd`` (n,) as a control loop gets them, updated in place.

    A counter stands at floor(c m), for ``counts_per_unit`` c and the position m of its motor: in the units of the
    joints (rad, m), or with ``at_motors`` in rad of the motors, which the robot's transmission joins. ``offset`` (n,),
    rad or m, is added to ``q``: the error of a robot that was homed wrong. Counters of ``bits`` bits wrap round, in
    two's complement, and ``q`` with them. ``qd`` is the first difference of ``q``, unfiltered, as in the software of
    the RAVEN II: its steps are one count per period; and a wrap shows in it. It is zero at the first update.

    With :meth:`step` the encoders stand for their plant in a control loop. Raises ArgumentError for numbers that are
    not positive, or not finite, and ModelError where a robot without transmission is asked for its motors.
    """

    def __init__(
        self,
        plant: Plant,
        counts_per_unit: PerCoordinate,
        *,
        offset: PerCoordinate = 0.0,
        bits: int | None = None,
        at_motors: bool = False,
    ) -> None:
        check_type(plant, Plant, "plant")
        check_type(at_motors, bool, "at_motors")
        self.plant = plant
        n = plant.robot.n
        self.counts_per_unit = _numbers("counts_per_unit", counts_per_unit, n)
        if not (self.counts_per_unit > 0.0).all():
            raise ArgumentError(f"counts_per_unit must be positive, not {shown(counts_per_unit)}")
        self._half_range = None if bits is None else 2 ** (as_count(bits, "bits", 2, 62) - 1)
        self._joint_per_motor, zero = _transmission(plant, n) if at_motors else (np.eye(n), np.zeros(n))
        self._to_counts = self.counts_per_unit[:, None] * np.linalg.inv(self._joint_per_motor)
        self._zero = zero
        self._offset = zero + _numbers("offset", offset, n)
        self.counts = np.zeros(n, dtype=np.int64)
        self.q, self.qd = np.zeros((2, n))
        self._read_at: float | None = None
        self.update()

    def reset(self) -> None:
        """Read anew after the plant was reset: no velocity yet."""
        self._read_at = None
        self.update()

    def update(self) -> None:
        """Read the counters as they stand; the velocity is over the plant's time since the last reading."""
        counts = np.floor(self._to_counts @ (self.plant.motor_q - self._zero))
        if self._half_range is not None:
            counts = (counts + self._half_range) % (2 * self._half_range) - self._half_range
        self.counts[:] = counts
        q = self._joint_per_motor @ (counts / self.counts_per_unit) + self._offset
        now = self.plant.time
        if self._read_at is None:
            self.qd[:] = 0.0
        elif now > self._read_at:
            self.qd[:] = (q - self.q) / (now - self._read_at)
        self.q[:] = q
        self._read_at = now

    def step(self, tau: Sequence[float] | Array, dt: float) -> None:
        """Step the plant, and read."""
        self.plant.step(tau, dt)
        self.update()


def raven2_encoders(plant: Plant, *, offset: PerCoordinate = 0.0) -> Encoders:
    """Read the plant's motors as a RAVEN II does: 4000 counts per turn, 24 bits, through its cable coupling.

    A count is 1.15e-5 rad of the shoulder, 1.29e-5 rad of the elbow, 7.3e-7 m of the insertion. ModelError for a robot
    without transmission.
    """
    return Encoders(plant, RAVEN2_COUNTS_PER_TURN / (2.0 * np.pi), offset=offset, bits=RAVEN2_BITS, at_motors=True)


def _transmission(plant: Plant, n: int) -> tuple[Array, Array]:
    transmission: TransmissionSpec | None = plant.robot.spec.transmission
    if transmission is None:
        raise ModelError(f"robot '{plant.robot.name}' has no transmission, so its motors' angles are not known")
    return np.array(transmission.joint_per_motor).reshape(n, n), np.array(transmission.offset)


def _numbers(name: str, value: PerCoordinate, n: int) -> Array:
    numbers = as_double(value, name)
    if numbers.shape not in {(), (n,)} or not (np.abs(numbers) <= LARGEST).all():
        raise ArgumentError(f"{name} must be one number or {n}, finite, at most {LARGEST:g}, not {shown(value)}")
    return np.array(np.broadcast_to(numbers, (n,)))
