from collections.abc import Iterator
from typing import Any, Self, TypeAlias, TypedDict, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import disjoint_base

from ravengc.spec import Matrix, RobotSpec, Vector

__all__ = [
    "INSTRUCTIONS",
    "MAX_JOINTS",
    "STANDARD_GRAVITY",
    "BaseMotion",
    "Cycle",
    "Gravity",
    "Mounting",
    "Robot",
    "SpecificForce",
    "base_wrench_batch",
    "bind_forward_kinematics",
    "bind_gravity_torque",
    "bind_inverse_dynamics",
    "bind_jacobian",
    "center_of_mass_batch",
    "forward_dynamics_batch",
    "forward_kinematics_batch",
    "gravity_regressor_batch",
    "gravity_stiffness_batch",
    "gravity_torque_batch",
    "inverse_dynamics_batch",
    "inverse_dynamics_regressor_batch",
    "jacobian_batch",
    "mass_matrix_batch",
    "potential_energy_batch",
]

_Array: TypeAlias = NDArray[np.float64]
_GravityLike: TypeAlias = ArrayLike | Gravity | SpecificForce
_BaseLike: TypeAlias = BaseMotion | Gravity | SpecificForce
_BaseRows: TypeAlias = _BaseLike | _Array

class _PoseState(TypedDict):
    rotation: Matrix
    translation: Vector

class _PayloadState(TypedDict):
    mass: float
    com: Vector
    inertia: tuple[float, float, float, float, float, float]
    tool: _PoseState
    tip: str

class _State(TypedDict):
    base: _PoseState
    tool: _PoseState
    tip: str
    payload: _PayloadState | None

INSTRUCTIONS: str
MAX_JOINTS: int
STANDARD_GRAVITY: float

@final
class Gravity:
    def __new__(cls, x: float, y: float, z: float) -> Self: ...
    @staticmethod
    def level() -> Gravity: ...
    def as_specific_force(self) -> SpecificForce: ...
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def z(self) -> float: ...
    def __iter__(self) -> Iterator[float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class SpecificForce:
    def __new__(cls, x: float, y: float, z: float) -> Self: ...
    @staticmethod
    def level() -> SpecificForce: ...
    def as_gravity(self) -> Gravity: ...
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def z(self) -> float: ...
    def __iter__(self) -> Iterator[float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class BaseMotion:
    def __new__(
        cls,
        *,
        specific_force: ArrayLike | SpecificForce | Gravity,
        angular_velocity: ArrayLike | None = None,
        angular_acceleration: ArrayLike | None = None,
    ) -> Self: ...
    @staticmethod
    def at_rest(gravity: _GravityLike) -> BaseMotion: ...
    @staticmethod
    def from_imu(
        *,
        specific_force: ArrayLike,
        angular_velocity: ArrayLike | None = None,
        angular_acceleration: ArrayLike | None = None,
        mounting: Mounting | None = None,
    ) -> BaseMotion: ...
    @property
    def specific_force(self) -> SpecificForce: ...
    @property
    def angular_velocity(self) -> tuple[float, float, float]: ...
    @property
    def angular_acceleration(self) -> tuple[float, float, float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Mounting:
    def __new__(cls, rotation: ArrayLike, position: ArrayLike | None = None) -> Self: ...
    @property
    def rotation(self) -> list[tuple[float, float, float]]: ...
    @property
    def position(self) -> tuple[float, float, float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs__(self) -> tuple[Any, ...]: ...

@final
class Cycle:
    def step(self) -> None: ...

@disjoint_base
class Robot:
    def __new__(cls, spec: RobotSpec) -> Self: ...
    @property
    def name(self) -> str: ...
    @property
    def n(self) -> int: ...
    @property
    def body_count(self) -> int: ...
    @property
    def joint_names(self) -> tuple[str, ...]: ...
    @property
    def frame_names(self) -> tuple[str, ...]: ...
    def gravity_torque(self, q: ArrayLike, gravity: _GravityLike, out: _Array | None = None) -> _Array: ...
    def forward_kinematics(self, q: ArrayLike, frame: str | None = None, out: _Array | None = None) -> _Array: ...
    def jacobian(
        self, q: ArrayLike, frame: str | None = None, axes: str | None = None, out: _Array | None = None
    ) -> _Array: ...
    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, base: _BaseLike, out: _Array | None = None
    ) -> _Array: ...
    def base_wrench(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, base: _BaseLike, out: _Array | None = None
    ) -> _Array: ...
    def mass_matrix(self, q: ArrayLike, out: _Array | None = None) -> _Array: ...
    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, base: _BaseLike, out: _Array | None = None
    ) -> _Array: ...
    def gravity_regressor(self, q: ArrayLike, gravity: _GravityLike, out: _Array | None = None) -> _Array: ...
    def inverse_dynamics_regressor(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, base: _BaseLike, out: _Array | None = None
    ) -> _Array: ...
    def gravity_stiffness(self, q: ArrayLike, gravity: _GravityLike, out: _Array | None = None) -> _Array: ...
    def potential_energy(self, q: ArrayLike, gravity: _GravityLike) -> float: ...
    def center_of_mass(self, q: ArrayLike, out: _Array | None = None) -> _Array: ...
    def inertial_parameters(self) -> _Array: ...
    def actuator_torque(self, tau: ArrayLike, out: _Array | None = None) -> _Array: ...
    def joint_torque(self, tau_motor: ArrayLike, out: _Array | None = None) -> _Array: ...
    def joint_positions(self, motors: ArrayLike, out: _Array | None = None) -> _Array: ...
    def motor_positions(self, q: ArrayLike, out: _Array | None = None) -> _Array: ...
    def set_payload(self, mass: float, com: ArrayLike, inertia: ArrayLike | None = None) -> None: ...
    def clear_payload(self) -> None: ...
    def set_base(self, rotation: ArrayLike, translation: ArrayLike | None = None) -> None: ...
    def set_tool(self, rotation: ArrayLike, translation: ArrayLike | None = None, link: str | None = None) -> None: ...
    def __getstate__(self) -> _State: ...
    def __setstate__(self, state: _State) -> None: ...

def bind_gravity_torque(robot: Robot, q: _Array, gravity: _Array, out: _Array) -> Cycle: ...
def bind_inverse_dynamics(
    robot: Robot,
    q: _Array,
    qd: _Array,
    qdd: _Array,
    specific_force: _Array,
    angular_velocity: _Array,
    angular_acceleration: _Array,
    out: _Array,
) -> Cycle: ...
def bind_forward_kinematics(robot: Robot, q: _Array, out: _Array, frame: str | None = None) -> Cycle: ...
def bind_jacobian(robot: Robot, q: _Array, out: _Array, frame: str | None = None, axes: str | None = None) -> Cycle: ...
def gravity_torque_batch(
    robot: Robot,
    q: ArrayLike,
    gravity: ArrayLike | Gravity | SpecificForce,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def gravity_regressor_batch(
    robot: Robot,
    q: ArrayLike,
    gravity: ArrayLike | Gravity | SpecificForce,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def gravity_stiffness_batch(
    robot: Robot,
    q: ArrayLike,
    gravity: ArrayLike | Gravity | SpecificForce,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def potential_energy_batch(
    robot: Robot,
    q: ArrayLike,
    gravity: ArrayLike | Gravity | SpecificForce,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def inverse_dynamics_batch(
    robot: Robot,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    base: _BaseRows,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def inverse_dynamics_regressor_batch(
    robot: Robot,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    base: _BaseRows,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def base_wrench_batch(
    robot: Robot,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    base: _BaseRows,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def forward_dynamics_batch(
    robot: Robot,
    q: ArrayLike,
    qd: ArrayLike,
    tau: ArrayLike,
    base: _BaseRows,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
def mass_matrix_batch(robot: Robot, q: ArrayLike, out: _Array | None = None, threads: int = 1) -> _Array: ...
def center_of_mass_batch(robot: Robot, q: ArrayLike, out: _Array | None = None, threads: int = 1) -> _Array: ...
def forward_kinematics_batch(
    robot: Robot, q: ArrayLike, frame: str | None = None, out: _Array | None = None, threads: int = 1
) -> _Array: ...
def jacobian_batch(
    robot: Robot,
    q: ArrayLike,
    frame: str | None = None,
    axes: str | None = None,
    out: _Array | None = None,
    threads: int = 1,
) -> _Array: ...
