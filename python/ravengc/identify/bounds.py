"""What a body can be: bounds on masses, places of the centre of mass, and coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from types import MappingProxyType

import numpy as np

from ravengc._convert import as_number, as_vector, check_type
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import did_you_mean, listed, shown

__all__ = ["Bounds"]

Range = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """Bounds for ``estimator="consistent"``; a key may hold ``*``, and the first that fits counts.

    ``mass`` gives kg per link as (least, most); ``com`` gives m per link as six numbers x, y, z (least, most), in the
    link frame, and where none fits the centre of mass lies within ``reach`` m of the link frame's origin along each
    axis. ``total_mass`` kg bounds the sum. ``parameters`` gives (least, most) by column name; coefficients of
    Coulomb, viscous and hysteretic friction, rotors and stiffnesses are otherwise not negative.
    """

    mass: Mapping[str, Range] = field(default_factory=dict)
    com: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    reach: float = 1.0
    total_mass: float | None = None
    parameters: Mapping[str, Range] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that every bound is one."""
        for name, count in (("mass", 2), ("com", 6), ("parameters", 2)):
            check_type(getattr(self, name), Mapping, name)
            object.__setattr__(self, name, _checked(getattr(self, name), name, count))
        if not 0.0 < as_number(self.reach, "reach") < np.inf:
            raise ArgumentError(f"reach is {shown(self.reach)}; expected more than 0 m")
        if self.total_mass is not None and not as_number(self.total_mass, "total_mass") > 0.0:
            raise ArgumentError(f"total_mass is {shown(self.total_mass)}; expected more than 0 kg")

    def of_mass(self, link: str) -> Range:
        """Least and most mass of a link, kg."""
        least, most = _first(self.mass, link) or (0.0, np.inf)
        return float(least), float(most)

    def of_com(self, link: str) -> tuple[float, ...]:
        """Least and most x, y and z of a link's centre of mass, m."""
        return _first(self.com, link) or (-self.reach, self.reach) * 3

    def of_parameter(self, column: str) -> Range:
        """Least and most of a coefficient."""
        label = column.rpartition(".")[2]
        natural = (0.0, np.inf) if label.startswith(NOT_NEGATIVE) else (-np.inf, np.inf)
        least, most = _first(self.parameters, column) or natural
        return float(least), float(most)

    def check_names(self, links: tuple[str, ...], columns: tuple[str, ...]) -> None:
        """Raise ConfigError for a bound that is about nothing."""
        for name, known in (("mass", links), ("com", links), ("parameters", columns)):
            for key in getattr(self, name):
                if not any(fnmatchcase(one, key) for one in known):
                    near = did_you_mean(key, known)
                    raise ConfigError(f"bounds.{name}: there is no {shown(key)}{near}; there are {listed(known)}")


NOT_NEGATIVE = ("coulomb", "viscous", "hysteresis", "rotor", "stiffness")
"""Labels of coefficients that dissipate, or store, and so are not negative."""


def _checked(given: Mapping[str, tuple[float, ...]], name: str, count: int) -> Mapping[str, tuple[float, ...]]:
    checked = {}
    for key, values in given.items():
        check_type(key, str, f"a key of {name}")
        numbers = np.asarray(as_vector(np.nan_to_num(values, posinf=1e300, neginf=-1e300), f"{name}[{key!r}]", count))
        if (numbers[::2] > numbers[1::2]).any():
            raise ArgumentError(f"{name}[{key!r}] is {shown(values)}; expected the least before the most")
        checked[key] = tuple(float(number) for number in values)
    return MappingProxyType(checked)


def _first(bounds: Mapping[str, tuple[float, ...]], name: str) -> tuple[float, ...] | None:
    return next((value for key, value in bounds.items() if fnmatchcase(name, key)), None)
