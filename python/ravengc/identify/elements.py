"""What acts along a joint beside the masses: friction, rotor inertia, springs, cables; each a few linear columns.

An element acts along one coordinate, or along a fixed combination of them (a relative joint of a parallelogram, a
motor): s = wᵀq, and its torque is w φ(s, ṡ, s̈)ᵀ c with columns φ that are known and coefficients c that are identified.
It is fixed to the base: it does not turn with gravity.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ravengc._convert import as_count, as_double, as_number, as_texts, check_type
from ravengc.errors import ArgumentError, ConfigError
from ravengc.identify import filing
from ravengc.messages import did_you_mean, listed, shown

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ravengc.identify.filing import Filed
    from ravengc.identify.recording import FloatArray
    from ravengc.spec import RobotSpec

    Basis = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]

__all__ = ["Element", "friction", "geometric_spring", "hysteresis", "polynomial", "rotor"]

TERMS = ("coulomb", "viscous", "offset", "quadratic", "stribeck", "cubic_root")


@dataclass(frozen=True, slots=True, kw_only=True)
class Element:
    """Columns along one direction of the coordinates.

    ``joint`` is the name of a coordinate, or n numbers w with s = wᵀq. ``basis(s, sd, sdd)`` takes arrays (N,) and
    gives (N, len(labels)); ``labels`` name the coefficients. ``group`` is what the element is left out with when a fit
    without it is tried, its own name unless given. ``filed(coefficients, span, share)`` says what a robot file has of
    it, from the least and most s that were visited and the share of friction that control laws shall add; ``None``
    where a robot file has no such element.
    """

    name: str
    joint: str | tuple[float, ...]
    basis: Basis
    labels: tuple[str, ...]
    group: str = ""
    filed: Filed | None = None

    def __post_init__(self) -> None:
        """Check the names; the joint is checked against the robot when columns are built."""
        check_type(self.name, str, "name")
        check_type(self.group, str, "group")
        object.__setattr__(self, "labels", as_texts(self.labels, "labels"))
        if not callable(self.basis):
            raise ArgumentError(f"basis is {shown(self.basis)}; expected a function of s, sd and sdd")
        if self.filed is not None and not callable(self.filed):
            raise ArgumentError(f"filed is {shown(self.filed)}; expected a function of coefficients, span and share")
        object.__setattr__(self, "joint", _joint(self.joint))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(f"{self.name}.{label}" for label in self.labels)

    def direction(self, robot: RobotSpec) -> FloatArray:
        """w, (n,): the direction in the robot's coordinates; ConfigError for a joint that it does not have."""
        names = robot.coordinate_names
        if not isinstance(self.joint, str):
            if len(self.joint) != len(names):
                raise ConfigError(
                    f"{self.name} acts along {len(self.joint)} coordinates; {robot.name} has {len(names)}"
                )
            return np.array(self.joint)
        if self.joint not in names:
            near = did_you_mean(self.joint, names)
            raise ConfigError(f"{self.name}: {robot.name} has no joint '{self.joint}'{near}; it has {listed(names)}")
        return np.array([float(name == self.joint) for name in names])

    def rows(self, robot: RobotSpec, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """The columns of this element, (N, n, k)."""
        w = self.direction(robot)
        values = np.asarray(self.basis(q @ w, qd @ w, qdd @ w), dtype=np.float64)
        if values.shape != (len(q), len(self.labels)):
            raise ArgumentError(f"basis of {self.name} gave {values.shape}; expected {(len(q), len(self.labels))}")
        return w[:, np.newaxis] * values[:, np.newaxis, :]


def friction(
    joint: str | Sequence[float],
    terms: Sequence[str] = ("coulomb", "viscous", "offset"),
    *,
    width: float = 0.0,
    name: str | None = None,
    group: str = "friction",
) -> Element:
    """Friction along a joint: Coulomb sign(v), viscous v, a constant offset, and others on request.

    ``width`` (rad/s, m/s) rounds the step: tanh(v/width). ``"stribeck"`` is sign(v) exp(-(v/v0)²) with v0 = 10 width,
    ``"quadratic"`` v |v|, ``"cubic_root"`` sign(v) |v|^(1/3).
    """
    chosen, softness = as_texts(_list(terms, "terms"), "terms"), as_number(width, "width")
    for term in chosen:
        if term not in TERMS:
            raise ConfigError(
                f"friction term {shown(term)} is unknown: choose {listed(TERMS)}{did_you_mean(term, TERMS)}"
            )

    def basis(_: FloatArray, v: FloatArray, __: FloatArray) -> FloatArray:
        return np.column_stack([_term(term, v, softness) for term in chosen])

    label, along = _name(joint, name), _joint(joint)
    made = filing.friction(label, along, chosen, softness)
    return Element(name=label, joint=along, basis=basis, labels=chosen, group=group, filed=made)


def _term(term: str, v: FloatArray, width: float) -> FloatArray:
    sign = np.tanh(v / width) if width > 0.0 else np.sign(v)
    match term:
        case "coulomb":
            return sign
        case "viscous":
            return v
        case "offset":
            return np.ones_like(v)
        case "quadratic":
            return v * np.abs(v)
        case "stribeck":
            return cast("FloatArray", sign * np.exp(-((v / filing.stribeck_velocity(width)) ** 2)))
        case _:
            return cast("FloatArray", np.cbrt(v))


def hysteresis(
    joint: str | Sequence[float],
    distances: Sequence[float] = (0.02,),
    *,
    name: str | None = None,
    group: str = "hysteresis",
) -> Element:
    """Friction that gives before it slips, as of cables and gears: elastic up to a distance (rad, m), then sliding.

    One stop operator per distance d (Prandtl and Ishlinskii): z follows s but stays within ±d, and the column is z/d.
    The state at the first sample is slack; samples must follow each other closely against d.
    """
    spans = tuple(as_number(distance, "distances") for distance in _list(distances, "distances"))
    if not spans or not all(0.0 < span < np.inf for span in spans):
        raise ArgumentError(f"distances are {shown(distances)}; expected positive numbers")

    def basis(s: FloatArray, _: FloatArray, __: FloatArray) -> FloatArray:
        return _stops(s, np.array(spans))

    labels = tuple(f"hysteresis_{span:g}" for span in spans)
    return Element(name=_name(joint, name), joint=_joint(joint), basis=basis, labels=labels, group=group)


def _stops(s: FloatArray, spans: FloatArray) -> FloatArray:
    """z/d of every stop, (N, k): z += step of s, held within ±d."""
    steps = np.diff(s, prepend=s[:1])
    states = np.zeros((len(s), len(spans)))
    for place, span in enumerate(spans.tolist()):
        state, column = 0.0, []
        for step in steps.tolist():
            state = min(span, max(-span, state + step))
            column.append(state / span)
        states[:, place] = column
    return states


def rotor(joint: str | Sequence[float], *, name: str | None = None, group: str = "rotor") -> Element:
    """The reflected inertia of a rotor along a joint: J s̈."""
    label = _name(joint, name)
    return Element(
        name=label, joint=_joint(joint), basis=lambda _, __, a: a[:, np.newaxis], labels=("rotor",), group=group
    )


def polynomial(
    joint: str | Sequence[float],
    degrees: Sequence[int],
    *,
    centre: float = 0.0,
    scale: float = 1.0,
    name: str | None = None,
) -> Element:
    """A torque that is a polynomial of the position, as of a cable: ((s - centre)/scale)^k for each degree k."""
    powers = tuple(as_count(degree, "degree", 0, 20) for degree in _list(degrees, "degrees"))
    middle, unit = as_number(centre, "centre"), as_number(scale, "scale")

    def basis(s: FloatArray, _: FloatArray, __: FloatArray) -> FloatArray:
        return np.column_stack([((s - middle) / unit) ** power for power in powers])

    label, along = _name(joint, name, ".cable"), _joint(joint)
    made = filing.polynomial(label, along, powers, middle, unit)
    return Element(name=label, joint=along, basis=basis, labels=tuple(f"p{power}" for power in powers), filed=made)


def geometric_spring(
    joint: str | Sequence[float],
    *,
    radius: float,
    distance: float,
    rest: float,
    angle: float,
    name: str | None = None,
) -> Element:
    """A coil spring between a pin at ``radius`` on the link and one at ``distance`` on its carrier (m).

    Its length is l² = r² + h² - 2 r h cos(angle - s), its lever r h sin(angle - s)/l; the column is the torque of a
    unit stiffness that the joint must exert against it, -lever (l - rest).
    """
    r, h, rest_length, at = (
        as_number(value, label)
        for value, label in ((radius, "radius"), (distance, "distance"), (rest, "rest"), (angle, "angle"))
    )

    def basis(s: FloatArray, _: FloatArray, __: FloatArray) -> FloatArray:
        length = np.sqrt(r * r + h * h - 2.0 * r * h * np.cos(at - s))
        return (-r * h * np.sin(at - s) / length * (length - rest_length))[:, np.newaxis]

    return Element(name=_name(joint, name, ".spring"), joint=_joint(joint), basis=basis, labels=("stiffness",))


def _joint(joint: str | Sequence[float]) -> str | tuple[float, ...]:
    """The name of a coordinate, or a direction; ArgumentError for anything else."""
    if isinstance(joint, str):
        return joint
    along = as_double(joint, "joint")
    if along.ndim != 1 or not along.size or not np.isfinite(along).all() or not along.any():
        raise ArgumentError(f"joint is {shown(joint)}; expected a coordinate's name, or one number for each of them")
    return tuple(along.tolist())


def _name(joint: str | Sequence[float], name: str | None, kind: str = "") -> str:
    """The name as given, or made from the joint."""
    if name is not None:
        check_type(name, str, "name")
        return name
    along = _joint(joint)
    return (along if isinstance(along, str) else f"along({', '.join(f'{part:g}' for part in along)})") + kind


def _list(values: object, name: str) -> list[Any]:
    if not isinstance(values, (list, tuple, range)):
        raise ArgumentError(f"{name} is {shown(values)}; expected a list")
    return list(values)
