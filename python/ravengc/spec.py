"""What a robot is, before it is compiled: plain immutable data in SI units.

A :class:`RobotSpec` is what a file, a DH table or a URDF is read into, what ``to_toml`` writes, and what
:class:`ravengc.Robot` lowers once, in Rust, to the representation that a cycle uses. It holds numbers and names, no
maths. Lists and arrays given for vectors and matrices become tuples.
"""

from __future__ import annotations

from collections.abc import Mapping  # noqa: TC003 - types of a description are looked up at run time
from dataclasses import dataclass, field
from typing import Any, Literal

from ravengc.disturbances import Disturbance  # noqa: TC001 - as above
from ravengc.frozen import freeze

__all__ = ["CouplingSpec", "DhRow", "JointLimits", "JointOrigin", "LinkSpec", "Pose", "RobotSpec", "TransmissionSpec"]

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]
JointKind = Literal["revolute", "prismatic", "fixed"]
Convention = Literal["standard", "modified", "frames"]

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Pose:
    """A frame in another: p_outer = rotation @ p_inner + translation (m)."""

    rotation: Matrix = IDENTITY
    translation: Vector = ZERO

    def __post_init__(self) -> None:
        """Freeze what was given as lists or arrays."""
        freeze(self, "rotation", "translation")


@dataclass(frozen=True, slots=True, kw_only=True)
class DhRow:
    """One row of a Denavit-Hartenberg table (rad, m).

    The joint's coordinate adds to ``theta`` (revolute) or ``d`` (prismatic).

    Standard: Rz(theta) Tz(d) Tx(a) Rx(alpha), joint about z of the parent frame, link frame distal.
    Modified (Craig): Rx(alpha) Tx(a) Rz(theta) Tz(d), joint about z of the link's own frame.
    """

    alpha: float = 0.0
    a: float = 0.0
    d: float = 0.0
    theta: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class JointOrigin:
    """An explicit joint frame in the parent link's frame at coordinate zero, as URDF has it.

    ``axis``, a unit vector, is in the joint frame. The link frame is the joint frame after the joint's own motion about
    (or along) it.
    """

    pose: Pose = Pose()
    axis: Vector = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        """Freeze what was given as a list or array."""
        freeze(self, "axis")


@dataclass(frozen=True, slots=True, kw_only=True)
class JointLimits:
    """Limits of one joint: rad or m, rad/s or m/s, N·m or N; ``None`` where there is none."""

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkSpec:
    """A link and the joint that carries it.

    ``parent`` is the name of the link that carries the joint, ``None`` for the base. Parents come first.
    ``com`` (m) and ``inertia`` (kg·m², order xx xy xz yy yz zz, about the COM) are in the link frame of the convention.
    ``massless`` says that a zero mass is meant.
    """

    name: str
    placement: DhRow | JointOrigin
    joint: JointKind = "revolute"
    joint_name: str = ""
    parent: str | None = None
    mass: float = 0.0
    com: Vector = ZERO
    inertia: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    massless: bool = False
    limits: JointLimits = JointLimits()
    source: str = ""

    def __post_init__(self) -> None:
        """Freeze what was given as lists or arrays."""
        freeze(self, "com", "inertia")


@dataclass(frozen=True, slots=True, kw_only=True)
class CouplingSpec:
    """Affine coupling of the mechanism's moving joints (rows, in link order) to the user's coordinates (columns).

    q_mechanism = matrix @ q + offset; torques map with the transpose, tau = matrixᵀ @ tau_mechanism.
    """

    coordinates: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]
    offset: tuple[float, ...]
    limits: tuple[JointLimits, ...] = ()
    source: str = ""

    def __post_init__(self) -> None:
        """Freeze what was given as lists or arrays."""
        freeze(self, "coordinates", "matrix", "offset", "limits")


@dataclass(frozen=True, slots=True, kw_only=True)
class TransmissionSpec:
    """Actuators to joints: q = joint_per_motor @ m + offset, tau_motor = joint_per_motorᵀ @ tau_joint.

    Rows are the robot's coordinates, columns the motors; the matrix is square and invertible.
    """

    motors: tuple[str, ...]
    joint_per_motor: tuple[tuple[float, ...], ...]
    offset: tuple[float, ...]
    source: str = ""

    def __post_init__(self) -> None:
        """Freeze what was given as lists or arrays."""
        freeze(self, "motors", "joint_per_motor", "offset")


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSpec:
    """A robot as data: links in order (parents first), the base pose, the tool frame, coupling and transmission.

    ``base`` leads from frame 0 of the links to the base frame B (z up when the arm is mounted level): p_B = R p_0 + t.
    ``tool`` is the tool frame in the frame of link ``tip`` (the last link when ``None``).
    ``mass_set`` names the set of masses in use and ``mass_sets`` those that the file offers. ``accelerometer`` is the
    table of the base's sensor as the file has it: :mod:`ravengc.calibration.block` reads it. ``disturbances`` act on
    the coordinates beside the masses: :mod:`ravengc.disturbances`. ``level_only`` says that masses and elements were
    told from each other on no tilt: their torques hold only where gravity is along -z of frame 0.
    """

    name: str
    convention: Convention
    links: tuple[LinkSpec, ...]
    base: Pose = Pose()
    tool: Pose = Pose()
    tip: str | None = None
    coupling: CouplingSpec | None = None
    transmission: TransmissionSpec | None = None
    description: str = ""
    source: str = ""
    mass_set: str = "default"
    mass_sets: tuple[str, ...] = ("default",)
    accelerometer: Mapping[str, Any] | None = field(default=None, hash=False)
    disturbances: tuple[Disturbance, ...] = ()
    level_only: bool = False
    file: str | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Freeze what was given as lists."""
        freeze(self, "links", "mass_sets", "disturbances")

    @property
    def moving_links(self) -> tuple[LinkSpec, ...]:
        """The links that a revolute or prismatic joint carries, in order."""
        return tuple(link for link in self.links if link.joint != "fixed")

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of the user's coordinates: the coupling's, or the moving joints' names."""
        if self.coupling is not None:
            return self.coupling.coordinates
        return tuple(link.joint_name or link.name for link in self.moving_links)

    @property
    def coordinate_limits(self) -> tuple[JointLimits, ...]:
        """Limits of the user's coordinates, in the order of :attr:`coordinate_names`."""
        if self.coupling is not None:
            return self.coupling.limits or tuple(JointLimits() for _ in self.coupling.coordinates)
        return tuple(link.limits for link in self.moving_links)
