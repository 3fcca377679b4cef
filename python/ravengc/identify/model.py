"""What is identified: parameters of the links and elements along the joints, as columns of one regressor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ravengc._convert import as_number, as_texts, check_choice, check_type
from ravengc.errors import ArgumentError, ConfigError
from ravengc.identify import elements as _elements
from ravengc.identify.elements import Element
from ravengc.identify.own_elements import filtered, own_columns, own_groups, own_rows, own_torque
from ravengc.identify.recording import FloatArray, Recording
from ravengc.messages import did_you_mean, kind_of, listed, shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

__all__ = ["Kind", "Model"]

Kind = Literal["gravity", "gravity+friction", "dynamics"]
KINDS = ("gravity", "gravity+friction", "dynamics")
GRAVITY_LABELS = ("m", "hx", "hy", "hz")
INERTIA_LABELS = ("Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")
USUAL_FRICTION = ("coulomb", "viscous", "offset")


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model that is linear in its parameters: tau = Y(q, qd, qdd, base) p.

    ``"gravity"`` has mass and first moment (m, hx, hy, hz; kg, kg·m, link frame) of every moving link;
    ``"gravity+friction"`` also friction along every joint; ``"dynamics"`` also the six moments of inertia about the
    origin of the link frame. ``friction`` are the terms along every joint (see :func:`~ravengc.identify.friction`;
    the kind decides when it is ``None``), rounded over ``width`` rad/s or m/s; ``rotor`` adds the reflected inertia
    of every joint's rotor; ``elements`` are springs, cables, and friction or rotors anywhere else. The disturbance
    elements of the robot's own file count as known, unless ``disturbances`` seeks their coefficients too. ``links``
    names the moving links whose parameters are sought, all when ``None``; the torques of the others must be known to be
    nothing.
    """

    kind: Kind = "gravity"
    friction: tuple[str, ...] | None = None
    width: float = 0.0
    rotor: bool = False
    elements: tuple[Element, ...] = ()
    disturbances: bool = False
    links: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Check the kind and the elements."""
        check_choice(self.kind, KINDS, "kind")
        if self.friction is not None:
            object.__setattr__(self, "friction", as_texts(self.friction, "friction"))
        object.__setattr__(self, "width", as_number(self.width, "width"))
        check_type(self.rotor, bool, "rotor")
        check_type(self.disturbances, bool, "disturbances")
        if self.links is not None:
            object.__setattr__(self, "links", as_texts(self.links, "links"))
        if not isinstance(self.elements, (list, tuple)):
            raise ArgumentError(f"elements is {kind_of(self.elements)}; expected a tuple of Element")
        for element in self.elements:
            check_type(element, Element, "elements")
        object.__setattr__(self, "elements", tuple(self.elements))

    @property
    def terms(self) -> tuple[str, ...]:
        """The friction terms along every joint."""
        if self.friction is not None:
            return self.friction
        return () if self.kind == "gravity" else USUAL_FRICTION

    @property
    def per_link(self) -> tuple[str, ...]:
        """Labels of the parameters of a link."""
        return (*GRAVITY_LABELS, *INERTIA_LABELS) if self.kind == "dynamics" else GRAVITY_LABELS

    def extras(self, robot: RobotSpec) -> tuple[Element, ...]:
        """All elements: friction and rotors of every joint, then those given."""
        names = robot.coordinate_names
        along = tuple(_elements.friction(name, self.terms, width=self.width) for name in names) if self.terms else ()
        rotors = tuple(_elements.rotor(name) for name in names) if self.rotor else ()
        return (*along, *rotors, *self.elements)

    def link_columns(self, robot: RobotSpec) -> tuple[str, ...]:
        """Names of the columns of the links: ``LINK.m``, ``LINK.hx`` and so on."""
        sought = [robot.moving_links[place].name for place in self.bodies(robot)]
        return tuple(f"{name}.{label}" for name in sought for label in self.per_link)

    def bodies(self, robot: RobotSpec) -> tuple[int, ...]:
        """Places of the links whose parameters are sought among the moving links; ConfigError for an unknown name."""
        names = [link.name for link in robot.moving_links]
        for name in self.links or ():
            if name not in names:
                near = did_you_mean(name, names)
                raise ConfigError(f"{robot.name} has no moving link {shown(name)}{near}; it has {listed(names)}")
        return tuple(place for place, name in enumerate(names) if self.links is None or name in self.links)

    def columns(self, robot: RobotSpec) -> tuple[str, ...]:
        """Names of all columns, (p,)."""
        own = own_columns(robot) if self.disturbances else ()
        return (*self.link_columns(robot), *(name for part in self.extras(robot) for name in part.columns), *own)

    def order(self, robot: RobotSpec) -> tuple[int, ...]:
        """The columns in the order in which base parameters are named after them: first moments, masses, the rest."""
        names = self.columns(robot)
        kinds = {"hx": 0, "hy": 0, "hz": 0, "m": 1}
        of_links = len(self.link_columns(robot))
        ranks = [kinds.get(name.rpartition(".")[2], 2) if place < of_links else 3 for place, name in enumerate(names)]
        return tuple(sorted(range(len(names)), key=ranks.__getitem__))

    def groups(self, robot: RobotSpec) -> tuple[str, ...]:
        """For every column what it is left out with: "links", "friction", "rotor" or an element's group."""
        extra = (part.group or part.name for part in self.extras(robot) for _ in part.labels)
        own = own_groups(robot) if self.disturbances else ()
        return (*("links" for _ in self.link_columns(robot)), *extra, *own)

    def regressor(self, robot: Robot, recording: Recording) -> FloatArray:
        """Y, (N n, p): row i n + j is joint j of sample i."""
        check_type(robot, Robot, "robot")
        check_type(recording, Recording, "recording")
        parts = [self._link_rows(robot, recording)]
        q, qd, qdd = recording.q, recording.velocity, recording.acceleration
        parts += [element.rows(robot.spec, q, qd, qdd) for element in self.extras(robot.spec)]
        parts += [own_rows(robot, recording)] if self.disturbances else []
        whole = filtered(np.concatenate(parts, axis=2).reshape(recording.samples, -1), recording)
        return whole.reshape(recording.samples * robot.n, -1)

    def known(self, robot: Robot, recording: Recording) -> FloatArray:
        """Torques (N, n) that are not sought: of the robot's own disturbance elements, unless they are columns."""
        check_type(robot, Robot, "robot")
        check_type(recording, Recording, "recording")
        return np.zeros_like(recording.q) if self.disturbances else own_torque(robot, recording)

    def _link_rows(self, robot: Robot, recording: Recording) -> FloatArray:
        base, q = recording.base, recording.q
        if self.kind == "dynamics":
            whole = robot.inverse_dynamics_regressor_batch(q, recording.velocity, recording.acceleration, base)
        else:
            whole = robot.gravity_regressor_batch(q, -base[:, :3])
        if self.links is None:
            return whole
        of_bodies = whole.reshape(*q.shape, robot.body_count, -1)[:, :, self.bodies(robot.spec)]
        return np.asarray(of_bodies.reshape(*q.shape, -1))

    def prior(self, robot: Robot) -> FloatArray:
        """The parameters that the robot has now, (p,): of its links and its own elements, and zero for the others."""
        check_type(robot, Robot, "robot")
        whole = robot.inertial_parameters().reshape(robot.body_count, 10)
        of_links = whole[self.bodies(robot.spec), : len(self.per_link)].ravel()
        own = robot.disturbance_parameters() if self.disturbances else np.zeros(0)
        return np.concatenate([of_links, np.zeros(len(self.columns(robot.spec)) - of_links.size - own.size), own])
