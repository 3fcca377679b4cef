"""What a robot's base stands on: how it can move, what it weighs, and what holds it.

The base has one to six coordinates y. Its twist, linear velocity of the base origin and angular velocity in base axes,
is ``directions`` @ dy/dt. Between the base and the world act ``stiffness`` @ y + ``damping`` @ dy/dt. Stiffness is what
holds the base with the arm on it, weight included: what a shove and a stop watch measure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_double, as_texts, as_vector, check_type
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.stability.ranges import square, within

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["NAMES", "Mount", "directions_of", "parse_mount"]

Array = Any

NAMES = ("x", "y", "z", "rx", "ry", "rz")
"""Along and about the base's axes."""

HEAVIEST, STIFFEST, FASTEST_HZ, FARTHEST = 1e7, 1e12, 1e4, 1e3
"""kg (kg m^2), N/m (N m/rad), Hz and m: what is beyond is a slip."""
SYNTAX = "MASS:HZ:ZETA or MASS:HZ:ZETA:DIRECTION, for example 15:2:0.01:y"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mount:
    """A base with m coordinates.

    ``directions`` (m, 6): twist per unit of each, linear then angular. ``mass``: of the base alone, kg (kg m^2); one
    number, m, or (m, m). Give either ``stiffness`` (N/m, N m/rad, arm mounted) or ``frequency_hz``, at which each
    coordinate swings alone with the arm held still; and either ``damping`` (N s/m) or ``damping_ratio``. ``names`` say
    what the coordinates are. Raises ConfigError for what no base has.
    """

    directions: Array
    mass: Array
    stiffness: Array = None
    frequency_hz: Array = None
    damping: Array = None
    damping_ratio: Array = None
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check everything, and turn it into matrices and vectors."""
        directions = _twists(self.directions)
        m = len(directions)
        names = as_texts(self.names, "names")
        _one_of("stiffness", self.stiffness, "frequency_hz", self.frequency_hz)
        _one_of("damping", self.damping, "damping_ratio", self.damping_ratio)
        checked: dict[str, Any] = {
            "directions": directions,
            "mass": square(self.mass, "mass", m, positive=False, high=HEAVIEST),
            "names": names if len(names) == m else tuple(f"y{i + 1}" for i in range(m)),
        }
        if self.stiffness is not None:
            checked["stiffness"] = square(self.stiffness, "stiffness", m, positive=True, high=STIFFEST)
        else:
            checked["frequency_hz"] = _each(self.frequency_hz, "frequency_hz", m, 1e-3, FASTEST_HZ, "Hz")
        if self.damping is not None:
            checked["damping"] = square(self.damping, "damping", m, positive=False, high=STIFFEST)
        else:
            checked["damping_ratio"] = _each(self.damping_ratio, "damping_ratio", m, 0.0, 10.0, "")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def size(self) -> int:
        """Number of coordinates, m."""
        return len(self.directions)

    def held(self, total: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Stiffness and damping (m, m) for the mass matrix ``total`` (m, m) of base and arm together.

        k = M w^2 and c = 2 zeta M w with the diagonal of M: each coordinate alone.
        """
        masses = np.diag(total)
        if self.stiffness is None:
            stiffness = np.diag(masses * (2.0 * math.pi * self.frequency_hz) ** 2)
        else:
            stiffness = self.stiffness
        if self.damping is None:
            return stiffness, np.diag(2.0 * self.damping_ratio * np.sqrt(np.diag(stiffness) * masses))
        return stiffness, self.damping


def directions_of(text: str, pivot: Sequence[float] = (0.0, 0.0, 0.0)) -> tuple[NDArray[np.float64], tuple[str, ...]]:
    """Read directions: names of :data:`NAMES` with commas between, or a vector ``X,Y,Z`` to move along.

    Turning is about ``pivot`` (m, base axes), so that the base origin moves with -w x pivot. Returns twists (m, 6) and
    names; ConfigError for anything else.
    """
    check_type(text, str, "direction")
    words = [word.strip().lower() for word in text.split(",")]
    if vector := _numbers(words):
        return _unit(vector), (text,)
    for word in words:
        if word not in NAMES:
            near = did_you_mean(word, NAMES)
            raise ConfigError(f"direction {shown(word)} is unknown: choose {listed(NAMES)}, or a vector X,Y,Z{near}")
    if len(set(words)) != len(words):
        raise ConfigError(f"direction {shown(text)} names the same one twice")
    twists = np.eye(6)[[NAMES.index(word) for word in words]]
    twists[:, :3] -= np.cross(twists[:, 3:], as_vector(pivot, "pivot", 3, FARTHEST))
    return twists, tuple(words)


def parse_mount(text: str) -> Mount:
    """Read ``MASS:HZ:ZETA[:DIRECTION]``: kg (kg m^2 for turning), Hz, damping ratio, by default along x, y and z.

    Raises ConfigError for anything else.
    """
    check_type(text, str, "mount")
    mass, hz, ratio, direction = [*text.split(":"), "x,y,z"][:4] if text.count(":") in {2, 3} else ("", "", "", "")
    numbers = _numbers([mass, hz, ratio])
    if not numbers:
        raise ConfigError(f"mount {shown(text)}: write {SYNTAX}")
    twists, names = directions_of(direction)
    weight = within(numbers[0], "mount: mass", 1e-6, HEAVIEST, "kg")
    return Mount(directions=twists, mass=weight, frequency_hz=numbers[1], damping_ratio=numbers[2], names=names)


def _numbers(words: list[str]) -> list[float]:
    """Three numbers, or nothing if that is not what the words are."""
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return []
    return numbers if len(numbers) == 3 else []


def _unit(vector: list[float]) -> NDArray[np.float64]:
    direction = as_vector(vector, "direction", 3, FARTHEST)
    length = float(np.linalg.norm(direction))
    if length < 1e-9:
        raise ConfigError(f"direction {shown(vector)} has no direction")
    return np.concatenate([direction / length, np.zeros(3)])[None]


def _twists(value: Any) -> NDArray[np.float64]:
    twists = np.atleast_2d(as_double(value, "directions"))
    if twists.ndim != 2 or twists.shape[1] != 6 or not 1 <= len(twists) <= 6 or not (np.abs(twists) <= FARTHEST).all():
        raise ConfigError(f"directions is {shown(value)}; expected 1 to 6 rows of 6 numbers: linear, then angular")
    if np.linalg.matrix_rank(twists) < len(twists):
        raise ConfigError("directions: one is a combination of the others; expected independent ones")
    return twists.copy()


def _each(value: Any, name: str, m: int, low: float, high: float, unit: str) -> NDArray[np.float64]:
    numbers = as_double(value, name)
    if numbers.shape not in {(), (1,), (m,)}:
        raise ConfigError(f"{name} has shape {numbers.shape}; expected one number or {m}")
    return np.array([within(float(number), name, low, high, unit) for number in np.broadcast_to(numbers, (m,))])


def _one_of(first: str, one: Any, second: str, other: Any) -> None:
    if (one is None) == (other is None):
        given = "neither" if one is None else "both"
        raise ConfigError(f"mount: {given} of {first} and {second} given; expected one of the two")
