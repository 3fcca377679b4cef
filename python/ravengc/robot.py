"""``Robot``: the compiled core with a description, names, limits and files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple, Self

from ravengc import _core
from ravengc.batch import BatchFunctions

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from os import PathLike

    import numpy as np
    from numpy.typing import NDArray

    from ravengc._core import Accelerometer, _PoseState
    from ravengc.spec import CouplingSpec, Pose, RobotSpec, TransmissionSpec, Vector

    Array = NDArray[np.float64]
    DhConvention = Literal["standard", "modified"]

__all__ = ["Payload", "Robot", "from_dh", "from_toml", "from_urdf", "load"]


class Payload(NamedTuple):
    """What a tool carries, as :meth:`Robot.set_payload` was given it.

    ``mass`` (kg), ``com`` (3,) m and ``inertia`` (6,) about it (kg·m², order xx xy xz yy yz zz) are in the tool frame
    to which it was attached: ``tool`` in the frame of link ``tip``. It stays there when the robot's tool is replaced.
    """

    mass: float
    com: Vector
    inertia: tuple[float, float, float, float, float, float]
    tool: Pose
    tip: str


class Robot(BatchFunctions):
    """A robot arm on a base that may tilt, rock or accelerate.

    Built from a :class:`~ravengc.spec.RobotSpec` and lowered once; every function of a cycle is a method of the
    compiled core. ``n`` coordinates (rad, m), ``body_count`` moving bodies, ``frame_names`` known to ``frame=``.

    ``base``, ``tool`` and ``tip`` begin as in ``spec``; with ``payload`` they are all that may change afterwards.
    Copies and pickles carry them: a copy computes with the same bits.
    """

    _spec: RobotSpec

    def __new__(cls, spec: RobotSpec) -> Self:
        """Build the core from the description; raises ModelError or LimitError for a robot that cannot exist."""
        from ravengc.config import validate

        validate(spec)
        robot = super().__new__(cls, spec)
        robot._spec = spec
        return robot

    @property
    def spec(self) -> RobotSpec:
        """What the robot was built from; base, tool and payload as they are now are its own properties."""
        return self._spec

    @property
    def base(self) -> Pose:
        """Pose of frame 0 of the links in the base frame B, as given last: p_B = rotation @ p_0 + translation (m).

        ``set_base(rotation, translation)`` changes it.
        """
        return _pose(self.__getstate__()["base"])

    @property
    def tool(self) -> Pose:
        """Pose of the tool frame in the frame of link :attr:`tip` (m), as given last; ``set_tool`` changes both."""
        return _pose(self.__getstate__()["tool"])

    @property
    def tip(self) -> str:
        """The link that carries the tool frame, or "base"."""
        return self.__getstate__()["tip"]

    @property
    def payload(self) -> Payload | None:
        """What the tool carries, as given last; ``None`` if nothing. ``set_payload``, ``clear_payload`` change it."""
        payload = self.__getstate__()["payload"]
        if payload is None:
            return None
        mass, com, inertia = payload["mass"], payload["com"], payload["inertia"]
        return Payload(mass, com, inertia, _pose(payload["tool"]), payload["tip"])

    def __repr__(self) -> str:
        return f"<Robot {self.name}: {self.n} coordinates, {self.body_count} bodies>"

    def __reduce__(self) -> tuple[type[Robot], tuple[RobotSpec], object]:
        """Copy and pickle by description, and by base, tool and payload as they were given last."""
        return type(self), (self.spec,), self.__getstate__()

    def bind(self, *, q: Array, gravity: Array | Accelerometer, out: Array) -> Callable[[], None]:
        """Bind the gravity torque to arrays: ``cycle()`` reads q (n,) and gravity (3,) and writes out (n,).

        With an Accelerometer for gravity, a call first steps that too, at ``time.monotonic_ns()``: gate, calibration,
        filter and torque in one cycle. The arrays are checked once and held: C-contiguous float64, ``out`` sharing no
        memory with the others. A call parses and allocates nothing; it raises ArgumentError only if an array was
        resized, reshaped, retyped or made read-only since.
        """
        return _core.bind_gravity_torque(self, q, gravity, out).step

    def bind_inverse_dynamics(
        self,
        *,
        q: Array,
        qd: Array,
        qdd: Array,
        specific_force: Array,
        angular_velocity: Array,
        angular_acceleration: Array,
        out: Array,
    ) -> Callable[[], None]:
        """Bind the inverse dynamics on a moving base to arrays, as :meth:`bind` does."""
        base = (specific_force, angular_velocity, angular_acceleration)
        return _core.bind_inverse_dynamics(self, q, qd, qdd, *base, out).step

    def bind_forward_kinematics(self, *, q: Array, out: Array, frame: str | None = None) -> Callable[[], None]:
        """Bind the pose of a frame, out (4, 4), to arrays, as :meth:`bind` does."""
        return _core.bind_forward_kinematics(self, q, out, frame).step

    def bind_jacobian(
        self, *, q: Array, out: Array, frame: str | None = None, axes: str | None = None
    ) -> Callable[[], None]:
        """Bind the Jacobian of a frame, out (6, n), to arrays, as :meth:`bind` does."""
        return _core.bind_jacobian(self, q, out, frame, axes).step

    def to_toml(self, path: str | PathLike[str] | None = None) -> str:
        """Return the robot as TOML, and write it atomically to ``path`` if one is given.

        Base and tool are those of now, so :func:`from_toml` gives a robot that computes the same. What a robot file has
        no place for is refused rather than left out: ConfigError for a payload or a tool on the base frame.
        ``ravengc.config.spec_to_toml(robot.spec)`` is the robot as it was built.
        """
        from ravengc.config import spec_to_toml, write_toml

        spec = self._as_it_is()
        if path is not None:
            write_toml(spec, path)
        return spec_to_toml(spec)

    def _as_it_is(self) -> RobotSpec:
        """The description with base and tool as they are now; ConfigError if that is not the whole robot."""
        from dataclasses import replace

        from ravengc.errors import ConfigError
        from ravengc.messages import listed

        state, spec = self.__getstate__(), self.spec
        links, tip = [link.name for link in spec.links], state["tip"]
        if state["payload"] is not None:
            problem = f"carries a payload of {state['payload']['mass']:g} kg, for which a robot file has no place"
            raise ConfigError(f"{self.name} {problem}; clear_payload() takes it off, a fixed link would keep it")
        if tip not in links:
            expected = f"expected a link (set_tool(..., link=NAME) with one of {listed(links)})"
            raise ConfigError(f"the tool of {self.name} stands on '{tip}', which a robot file cannot say; {expected}")
        named = spec.tip if tip == (spec.tip or links[-1]) else tip
        return replace(spec, base=_pose(state["base"]), tool=_pose(state["tool"]), tip=named)


def _pose(state: _PoseState) -> Pose:
    from ravengc.spec import Pose

    return Pose(state["rotation"], state["translation"])


def load(name_or_path: str | PathLike[str], mass_set: str | None = None) -> Robot:
    """Load a bundled robot by name, or a .toml or .urdf file by path; ``mass_set`` selects one of the file's mass sets.

    Raises ConfigError for an unknown name (the message lists the near ones), ParseError, UnitsError or ModelError for a
    file that cannot be read or a robot that cannot exist.
    """
    from ravengc.config import spec_for

    return Robot(spec_for(name_or_path, mass_set=mass_set))


def from_toml(path_or_text: str | PathLike[str], mass_set: str | None = None) -> Robot:
    """Build a robot from a TOML file, or from the text itself."""
    from ravengc.config import spec_from_toml

    return Robot(spec_from_toml(path_or_text, mass_set=mass_set))


def from_urdf(path: str | PathLike[str], *, tip: str | None = None) -> Robot:
    """Build a robot from a URDF file; nothing that the file refers to is opened.

    ``tip`` is the link that carries the tool frame; by default the last in tree order, which may be a gripper's finger.
    :func:`ravengc.config.spec_from_urdf` says what is read and what is refused.
    """
    from ravengc.config import spec_from_urdf

    return Robot(spec_from_urdf(path, tip=tip))


def from_dh(
    rows: Sequence[Mapping[str, object]],
    convention: DhConvention,
    *,
    name: str = "robot",
    base: Pose | None = None,
    tool: Pose | None = None,
    tip: str | None = None,
    coupling: CouplingSpec | None = None,
    transmission: TransmissionSpec | None = None,
    description: str = "",
    source: str = "",
) -> Robot:
    """Build a robot from Denavit-Hartenberg rows; see :func:`ravengc.config.spec_from_dh` for all arguments."""
    from ravengc.config import spec_from_dh

    spec = spec_from_dh(
        rows,
        convention,
        name=name,
        base=base,
        tool=tool,
        tip=tip,
        coupling=coupling,
        transmission=transmission,
        description=description,
        source=source,
    )
    return Robot(spec)
