"""Hypothesis strategies: random robots, poses, gravity vectors and base motions.

Geometry is drawn on a grid of integers (millimetres, grams, thousandths), so a failing robot shrinks to one that can
be read. Every draw is bounded and nothing is filtered away. Inertia is that of a cloud of mass: a body with it exists.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np
from hypothesis import strategies as st

from ravengc.spec import CouplingSpec, DhRow, JointOrigin, LinkSpec, Pose, RobotSpec

if TYPE_CHECKING:
    from ravengc.reference import Payload
    from ravengc.spec import Convention, JointKind, Vector

Draw = st.DrawFn
KINDS: tuple[JointKind, ...] = ("revolute", "revolute", "prismatic")
CONVENTIONS: tuple[Convention, ...] = ("standard", "modified", "frames")
AXES: tuple[Vector, ...] = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))
RIGHT_ANGLES = (0.0, pi / 2, -pi / 2, pi)


def grid(low: float, high: float, step: float = 1e-3) -> st.SearchStrategy[float]:
    """Multiples of ``step`` between two bounds, shrinking towards zero."""
    return st.integers(round(low / step), round(high / step)).map(lambda k: k * step)


def vectors(component: st.SearchStrategy[float]) -> st.SearchStrategy[Vector]:
    """Three independent components."""
    return st.tuples(component, component, component)


def direction(angles: tuple[float, float]) -> Vector:
    """Unit vector from its polar angle and its azimuth."""
    polar, azimuth = angles
    return sin(polar) * cos(azimuth), sin(polar) * sin(azimuth), cos(polar)


ANGLE = st.one_of(st.sampled_from(RIGHT_ANGLES), grid(-pi, pi))
LENGTH = st.one_of(st.just(0.0), grid(-0.8, 0.8))
POSITION = vectors(LENGTH)
UNIT_VECTOR = st.one_of(st.sampled_from(AXES), st.tuples(grid(0, pi), grid(-pi, pi)).map(direction))
MASS = grid(0.01, 5.0)
COM = vectors(grid(-0.3, 0.3))
ONE_IN_EIGHT = st.integers(0, 7).map(lambda k: k == 7)
ONE_IN_FOUR = st.integers(0, 3).map(lambda k: k == 3)


def pose(axis: Vector, angle: float, translation: Vector) -> Pose:
    """A frame turned by ``angle`` about a unit vector and moved."""
    x, y, z = axis
    turn = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(3) + sin(angle) * turn + (1 - cos(angle)) * turn @ turn
    return Pose(rotation=tuple(map(tuple, matrix.tolist())), translation=translation)


POSE = st.builds(pose, UNIT_VECTOR, ANGLE, POSITION)
DH_ROW = st.builds(DhRow, alpha=ANGLE, a=LENGTH, d=LENGTH, theta=ANGLE)
PLACEMENTS = {"standard": DH_ROW, "modified": DH_ROW, "frames": st.builds(JointOrigin, pose=POSE, axis=UNIT_VECTOR)}


def inertia_of_cloud(mass: float, widths: Vector, skews: Vector) -> tuple[float, ...]:
    """Inertia about its centre of a mass spread with covariance A Aᵀ, A lower triangular: I = tr(m A Aᵀ) 1 - m A Aᵀ."""
    spread = np.diag(widths)
    spread[np.tril_indices(3, -1)] = skews
    second_moment = mass * spread @ spread.T
    inertia = np.trace(second_moment) * np.eye(3) - second_moment
    return tuple(inertia[np.triu_indices(3)].tolist())


SKEWS = vectors(grid(-0.1, 0.1))
ANY_WIDTHS = vectors(grid(0.0, 0.2))
SOLID_WIDTHS = vectors(grid(0.02, 0.2))


@st.composite
def links(
    draw: Draw, name: str, parent: str | None, joint: JointKind, convention: Convention, *, solid: bool, empty: bool
) -> LinkSpec:
    """A link with its joint.

    ``solid`` gives it 2 cm or more in every direction; otherwise it may be a plate, a rod, a point, or, if it may be
    ``empty``, massless (one in eight).
    """
    placement = draw(PLACEMENTS[convention])
    if empty and not solid and draw(ONE_IN_EIGHT):
        return LinkSpec(name=name, parent=parent, joint=joint, placement=placement, massless=True)
    mass = draw(MASS)
    return LinkSpec(
        name=name,
        parent=parent,
        joint=joint,
        joint_name=f"{name}_joint",
        placement=placement,
        mass=mass,
        com=draw(COM),
        inertia=inertia_of_cloud(mass, draw(SOLID_WIDTHS if solid else ANY_WIDTHS), draw(SKEWS)),
    )


@st.composite
def couplings(draw: Draw, joints: int) -> CouplingSpec:
    """Affine coupling of full column rank: one joint per coordinate, the others copy and mix (mimic joints)."""
    coordinates = draw(st.integers(1, joints))
    own = np.diag(draw(st.lists(st.sampled_from((1.0, -1.0, 0.5, 2.0)), min_size=coordinates, max_size=coordinates)))
    own += np.diag(np.full(coordinates - 1, draw(st.sampled_from((0.0, 0.7, -1.0)))), -1)
    followers = joints - coordinates
    mix = [[draw(grid(-2.0, 2.0, 0.25)) for _ in range(coordinates)] for _ in range(followers)]
    matrix = np.vstack([own, np.reshape(mix, (followers, coordinates))])[draw(st.permutations(range(joints)))]
    return CouplingSpec(
        coordinates=tuple(f"x{i}" for i in range(coordinates)),
        matrix=tuple(map(tuple, matrix.tolist())),
        offset=tuple(draw(st.lists(ANGLE, min_size=joints, max_size=joints))),
    )


def body_counts(most: int) -> st.SearchStrategy[int]:
    """Numbers of moving bodies, mostly 1 to 8, sometimes up to ``most``."""
    few = min(8, most)
    return st.one_of(st.integers(1, min(3, most)), st.integers(1, few), st.integers(1, few), st.integers(1, most))


@st.composite
def robots(
    draw: Draw, *, most: int = 16, solid: bool = False, coupled: bool = True, convention: Convention | None = None
) -> RobotSpec:
    """Any robot: 1 to ``most`` moving bodies, serial or a tree, any convention, base, tool and (``coupled``) coupling.

    Its first moving link always has mass. ``solid`` gives every link mass and extent: M is positive definite.
    """
    chosen = convention or draw(st.sampled_from(CONVENTIONS))
    moving = draw(body_counts(most))
    kinds: list[JointKind] = [draw(st.sampled_from(KINDS)) for _ in range(moving)]
    for _ in range(draw(st.sampled_from((0, 0, 1, 2)))):
        kinds.insert(draw(st.integers(0, len(kinds))), "fixed")
    names = [f"link{i}" for i in range(len(kinds))]
    first = next(name for name, kind in zip(names, kinds, strict=True) if kind != "fixed")
    bodies = [
        draw(links(name, parent, kind, chosen, solid=solid, empty=name != first))
        for name, parent, kind in zip(names, draw(parents(names)), kinds, strict=True)
    ]
    return RobotSpec(
        name="random",
        convention=chosen,
        links=tuple(bodies),
        base=draw(POSE),
        tool=draw(POSE),
        tip=draw(st.sampled_from((None, *names))),
        coupling=draw(couplings(moving)) if coupled and draw(ONE_IN_FOUR) else None,
    )


@st.composite
def parents(draw: Draw, names: list[str]) -> list[str | None]:
    """Parent of every link: the one before it (a serial chain), or any earlier one or the base (a tree)."""
    if draw(st.booleans()):
        return [draw(st.sampled_from((None, *names[:i]))) for i in range(len(names))]
    return [None, *(before for before, _ in pairwise(names))]


def coordinates(spec: RobotSpec, size: float = pi) -> st.SearchStrategy[np.ndarray]:
    """A vector with one bounded number per coordinate: joint positions, rates, accelerations or torques."""
    n = len(spec.coordinate_names)
    return st.lists(st.floats(-size, size), min_size=n, max_size=n).map(np.array)


LEVEL_OR_NONE = st.sampled_from(((0.0, 0.0, -9.80665), (0.0, 0.0, 0.0)))
ACCELERATION = st.one_of(LEVEL_OR_NONE, vectors(st.floats(-30.0, 30.0)), vectors(st.floats(-30.0, 30.0))).map(np.array)
"""Gravity or specific force of any direction and magnitude; level and free fall among them."""

SPIN = vectors(st.floats(-3.0, 3.0)).map(np.array)
"""Angular velocity or acceleration of the base."""


def payload(mass: float, com: Vector, widths: Vector, skews: Vector) -> Payload:
    """Mass, COM and inertia in the tool frame."""
    return mass, com, inertia_of_cloud(mass, widths, skews)


PAYLOAD = st.builds(payload, MASS, COM, ANY_WIDTHS, SKEWS)


@dataclass(frozen=True)
class Case:
    """A robot in motion on a moving base; ``f``, ``w``, ``dw`` as in :func:`ravengc.reference.inverse_dynamics`."""

    spec: RobotSpec
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    f: np.ndarray
    w: np.ndarray
    dw: np.ndarray

    @property
    def g(self) -> np.ndarray:
        """The gravity field that a base at rest with this specific force stands in."""
        return -self.f

    @property
    def motion(self) -> tuple[np.ndarray, ...]:
        """``q, qd, qdd, f, w, dw``, the arguments of inverse dynamics."""
        return self.q, self.qd, self.qdd, self.f, self.w, self.dw


@st.composite
def cases(
    draw: Draw, *, most: int = 16, solid: bool = False, coupled: bool = True, convention: Convention | None = None
) -> Case:
    """A random robot with a random pose, motion and base motion."""
    spec = draw(robots(most=most, solid=solid, coupled=coupled, convention=convention))
    return Case(
        spec=spec,
        q=draw(coordinates(spec)),
        qd=draw(coordinates(spec, 3.0)),
        qdd=draw(coordinates(spec, 10.0)),
        f=draw(ACCELERATION),
        w=draw(SPIN),
        dw=draw(SPIN),
    )
