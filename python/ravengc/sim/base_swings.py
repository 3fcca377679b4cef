"""Base motions made of sinusoids: level, tilted, rocking, swinging in six coordinates, and a ship's."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_double, as_number, as_vector, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ConfigError
from ravengc.sim.base_motion import Axis, BaseState, CarriedBase, as_time, axis_text, hinge_axes, orthonormal

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["BaseTrajectory", "level", "oscillating", "rocking", "ship", "tilted"]

Array = NDArray[np.float64]

ARM_ON_SHIP = (3.0, 1.0, 4.0)


@dataclass(frozen=True, slots=True)
class BaseTrajectory(CarriedBase):
    """Each coordinate i of the base is offset_i + amplitude_i sin(2 pi hz_i t + phase_i), for all time.

    ``offset``, ``amplitude`` (m, rad), ``hz`` and ``phase`` (rad) have six numbers: slides x, y, z, then the hinges
    about the rows of ``axes`` (orthonormal, base axes at level). ``pivot`` (m, base axes) is the point the hinges
    turn about. Raises ArgumentError for other shapes, numbers that are not finite or above 1e9, and axes that are not
    orthonormal.
    """

    offset: Array = field(default_factory=lambda: np.zeros(6))
    amplitude: Array = field(default_factory=lambda: np.zeros(6))
    hz: Array = field(default_factory=lambda: np.zeros(6))
    phase: Array = field(default_factory=lambda: np.zeros(6))
    axes: Array = field(default_factory=lambda: np.eye(3))
    pivot: Array = field(default_factory=lambda: np.zeros(3))
    description: str = "level"
    swings: tuple[tuple[int, float, float, float, float], ...] = field(init=False, repr=False, compare=False)
    """Coordinates that move, as floats: number, offset, amplitude, rate (rad/s), phase."""

    def __post_init__(self) -> None:
        """Turn what was given as lists into arrays, and check them."""
        for name, n in (("offset", 6), ("amplitude", 6), ("hz", 6), ("phase", 6), ("pivot", 3)):
            object.__setattr__(self, name, as_vector(getattr(self, name), name, n, LARGEST).copy())
        object.__setattr__(self, "axes", orthonormal(self.axes))
        check_type(self.description, str, "description")
        rate = 2.0 * np.pi * self.hz
        columns = (column.tolist() for column in (self.offset, self.amplitude, rate, self.phase))
        rows = zip(range(6), *columns, strict=True)
        object.__setattr__(self, "swings", tuple(row for row in rows if row[2] != 0.0))

    def state(self, t: float) -> BaseState:
        """The six coordinates at time ``t`` (s) with their velocities and accelerations."""
        time = as_time(t)
        position, velocity, acceleration = self.offset.copy(), np.zeros(6), np.zeros(6)
        for i, offset, amplitude, rate, phase in self.swings:
            angle = rate * time + phase
            swing = amplitude * math.sin(angle)
            position[i] = offset + swing
            velocity[i] = amplitude * rate * math.cos(angle)
            acceleration[i] = -rate * rate * swing
        return BaseState(position, velocity, acceleration)


def level() -> BaseTrajectory:
    """Stay at rest, as mounted."""
    return BaseTrajectory()


def tilted(degrees: float, axis: Axis = "x") -> BaseTrajectory:
    """Stay at rest, turned by ``degrees`` about ``axis`` (a vector in base axes, or "x", "y", "z")."""
    axes, degrees = hinge_axes(axis), as_number(degrees, "degrees")
    if not abs(degrees) <= LARGEST:
        raise ConfigError(f"degrees must be a number of at most {LARGEST:g}, not {degrees:g}")
    offset = np.array((0.0, 0.0, 0.0, np.deg2rad(degrees), 0.0, 0.0))
    return BaseTrajectory(offset=offset, axes=axes, description=f"tilted {degrees:g} deg about {axis_text(axes)}")


def rocking(
    low_deg: float, high_deg: float, *, hz: float, axis: Axis = "x", pivot: Sequence[float] = (0.0, 0.0, 0.0)
) -> BaseTrajectory:
    """Rock between two angles (deg) about ``axis`` through ``pivot`` (m, base axes), ``hz`` times a second.

    The angle is mean - half range * cos(2 pi hz t): it starts at the low end, at rest.
    """
    axes = hinge_axes(axis)
    low_deg, high_deg, hz = as_number(low_deg, "low_deg"), as_number(high_deg, "high_deg"), as_number(hz, "hz")
    if not (abs(low_deg) <= LARGEST and abs(high_deg) <= LARGEST and 0.0 < hz <= LARGEST):
        problem = f"the angles must be finite and hz a positive number, all at most {LARGEST:g}"
        raise ConfigError(f"rocking({low_deg}, {high_deg}, hz={hz}): {problem}")
    mean, half = np.deg2rad((low_deg + high_deg) / 2.0), np.deg2rad((high_deg - low_deg) / 2.0)
    first_hinge = np.eye(6)[3]
    return BaseTrajectory(
        offset=mean * first_hinge,
        amplitude=half * first_hinge,
        hz=hz * first_hinge,
        phase=-np.pi / 2.0 * first_hinge,
        axes=axes,
        pivot=as_double(pivot, "pivot"),
        description=f"rocking {low_deg:g} to {high_deg:g} deg at {hz:g} Hz about {axis_text(axes)}",
    )


def oscillating(
    *,
    amplitude: Sequence[float],
    hz: Sequence[float],
    phase: Sequence[float] = (0.0,) * 6,
    offset: Sequence[float] = (0.0,) * 6,
    pivot: Sequence[float] = (0.0, 0.0, 0.0),
) -> BaseTrajectory:
    """Swing in six coordinates at once, as a ship does: surge, sway, heave (m), roll, pitch, yaw (rad).

    The rotation is Rx(roll) Ry(pitch) Rz(yaw); every argument but ``pivot`` has six numbers.
    """
    return BaseTrajectory(
        offset=as_double(offset, "offset"),
        amplitude=as_double(amplitude, "amplitude"),
        hz=as_double(hz, "hz"),
        phase=as_double(phase, "phase"),
        pivot=as_double(pivot, "pivot"),
        description="oscillating in six coordinates",
    )


def ship(
    *,
    roll_deg: float = 10.0,
    roll_hz: float = 0.1,
    pitch_deg: float = 4.0,
    pitch_hz: float = 0.13,
    heave: float = 1.0,
    heave_hz: float = 0.1,
    place: Sequence[float] = ARM_ON_SHIP,
) -> BaseTrajectory:
    """Ride a ship: R = Rx(roll) Ry(pitch), each a sine of time, and a heave (m) of the centre of rotation.

    ``place`` is where the arm's base stands, m from the centre of rotation, ship axes. Amplitudes are those of the
    sines; all start at zero. ConfigError for amplitudes or frequencies that are negative.
    """
    numbers = {
        "roll_deg": roll_deg,
        "pitch_deg": pitch_deg,
        "heave": heave,
        "roll_hz": roll_hz,
        "pitch_hz": pitch_hz,
        "heave_hz": heave_hz,
    }
    values = {name: as_number(value, name) for name, value in numbers.items()}
    for name, value in values.items():
        if not 0.0 <= value <= LARGEST:
            raise ConfigError(f"ship: {name} is {value:g}; expected a number from 0 to {LARGEST:g}")
    roll, pitch = math.radians(values["roll_deg"]), math.radians(values["pitch_deg"])
    return BaseTrajectory(
        amplitude=np.array((0.0, 0.0, values["heave"], roll, pitch, 0.0)),
        hz=np.array((0.0, 0.0, values["heave_hz"], values["roll_hz"], values["pitch_hz"], 0.0)),
        pivot=-as_vector(place, "place", 3, LARGEST),
        description=(
            f"ship: roll {values['roll_deg']:g} deg at {values['roll_hz']:g} Hz, pitch {values['pitch_deg']:g} deg at "
            f"{values['pitch_hz']:g} Hz, heave {values['heave']:g} m at {values['heave_hz']:g} Hz"
        ),
    )
