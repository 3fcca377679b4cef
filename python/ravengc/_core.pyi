from collections.abc import Callable, Iterator
from typing import Any, Literal, Self, TypeAlias, TypedDict, Unpack, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import disjoint_base

from ravengc.spec import Matrix, RobotSpec, Vector

__all__ = [
    "EVENTS",
    "FAULTS",
    "INSTRUCTIONS",
    "MAX_JOINTS",
    "NOTES",
    "RATE_EVENTS",
    "STANDARD_GRAVITY",
    "Accelerometer",
    "BaseMotion",
    "ControlCycle",
    "Controller",
    "Cycle",
    "ElasticCycle",
    "ElasticGravity",
    "Gravity",
    "Mounting",
    "Predictor",
    "PredictorCycle",
    "RateCycle",
    "ResolvedRate",
    "Robot",
    "SpecificForce",
    "_ascend",
    "_box_minimum",
    "_manipulability",
    "base_wrench_batch",
    "bind_elastic_gravity",
    "bind_forward_kinematics",
    "bind_gravity_torque",
    "bind_inverse_dynamics",
    "bind_jacobian",
    "center_of_mass_batch",
    "disturbance_regressor_batch",
    "disturbance_torque_batch",
    "forward_dynamics_batch",
    "forward_kinematics_batch",
    "gravity_regressor_batch",
    "gravity_stiffness_batch",
    "gravity_stiffness_bound",
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

class _AccelerometerSettings(TypedDict, total=False):
    rate_hz: float
    range: float
    gyro_range: float
    bandwidth_hz: float | None
    unit: Literal["m/s^2", "g", "mg", "cm/s^2"]
    bias: ArrayLike
    correction: ArrayLike
    gyro_bias: ArrayLike
    rotation: ArrayLike
    position: ArrayLike
    up: ArrayLike
    cutoff_hz: float | None
    policy: Literal["paper", "strict"]
    norm: tuple[float, float]
    norm_tolerance: float
    noise: float
    jerk: float
    linear_acceleration: float
    moving_base: bool
    pose_limit: float
    tilt_limit: float
    tilt_time: float
    max_age_s: float
    hold_s: float
    fault_after_s: float
    no_sensor_s: float
    stuck_count: int
    axis_stuck_count: int
    density: int
    start_count: int
    gravity_rate: float
    angular_acceleration: float
    angular_jerk: float

EVENTS: dict[str, str]
FAULTS: dict[str, str]
INSTRUCTIONS: str
MAX_JOINTS: int
NOTES: dict[str, str]
RATE_EVENTS: dict[str, str]
STANDARD_GRAVITY: float

@final
class Gravity:
    def __new__(cls, x: ArrayLike, y: float | None = None, z: float | None = None) -> Self: ...
    @staticmethod
    def level() -> Gravity: ...
    @staticmethod
    def tilted(angle: float, axis: Literal["x", "y", "z"] | ArrayLike) -> Gravity: ...
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
    def __new__(cls, x: ArrayLike, y: float | None = None, z: float | None = None) -> Self: ...
    @staticmethod
    def level() -> SpecificForce: ...
    @staticmethod
    def tilted(angle: float, axis: Literal["x", "y", "z"] | ArrayLike) -> SpecificForce: ...
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
class Accelerometer:
    def __new__(cls, **settings: Unpack[_AccelerometerSettings]) -> Self: ...
    def push(
        self, seq: int, stamp_ns: int, specific_force: ArrayLike, angular_velocity: ArrayLike | None = None
    ) -> bool: ...
    def step(self, now_ns: int | None = None, out: _Array | None = None) -> None: ...
    def acknowledge(self) -> None: ...
    @property
    def gravity(self) -> Gravity: ...
    @property
    def base_motion(self) -> BaseMotion: ...
    @property
    def state(self) -> Literal["no_data", "nominal", "live", "held", "degraded", "fault"]: ...
    @property
    def age_ns(self) -> int | None: ...
    @property
    def status(self) -> int: ...
    @property
    def alarms(self) -> tuple[str, ...]: ...
    @property
    def seen(self) -> tuple[str, ...]: ...
    @property
    def armable(self) -> bool: ...
    @property
    def likely_unit(self) -> str | None: ...
    @property
    def counters(self) -> dict[str, int]: ...

@disjoint_base
class ResolvedRate:
    def __new__(
        cls,
        robot: Robot,
        *,
        task: str,
        frame: str | None = None,
        rows: ArrayLike | None = None,
        damping: str,
        eps: float,
        lambda_max: float,
        rate_hz: float,
        qd_max: ArrayLike | None = None,
        qdd_max: ArrayLike | None = None,
        qddd_max: ArrayLike | None = None,
        q_min: ArrayLike | None = None,
        q_max: ArrayLike | None = None,
        damper: float,
        limits: str,
        null_space: str,
        null_gain: float,
        posture: ArrayLike | None = None,
        characteristic_length: float,
        remote_centre: ArrayLike | None = None,
        pointing_axis: ArrayLike | None = None,
        gain: float,
        turning_gain: float,
        speed_max: float,
        turning_max: float,
        midpoint: bool,
    ) -> Self: ...
    def step(
        self,
        q: ArrayLike,
        twist: ArrayLike,
        dt: float,
        base_twist: ArrayLike | None = None,
        out: _Array | None = None,
    ) -> _Array: ...
    def track(
        self,
        q: ArrayLike,
        target: ArrayLike,
        dt: float,
        target_twist: ArrayLike | None = None,
        base_twist: ArrayLike | None = None,
        out: _Array | None = None,
    ) -> _Array: ...
    def bind(
        self,
        *,
        q: _Array,
        out: _Array,
        twist: _Array | None = None,
        target: _Array | None = None,
        target_twist: _Array | None = None,
        base_twist: _Array | Accelerometer | None = None,
        pivot: ArrayLike | None = None,
        base_velocity: _Array | None = None,
        dt: float | None = None,
    ) -> Callable[[], None]: ...
    def acknowledge(self) -> None: ...
    def reset(self) -> None: ...
    @property
    def status(self) -> int: ...
    @property
    def seen(self) -> tuple[str, ...]: ...
    @property
    def since(self) -> tuple[str, ...]: ...
    @property
    def counters(self) -> dict[str, int]: ...
    @property
    def sigma_min(self) -> float: ...
    @property
    def damping_used(self) -> float: ...
    @property
    def scale(self) -> float: ...
    @property
    def limiting_joint(self) -> int | None: ...
    @property
    def limited_joints(self) -> tuple[int, ...]: ...
    @property
    def limit(self) -> Literal["velocity", "position", "acceleration", "jerk"] | None: ...
    @property
    def reason(self) -> str: ...

@final
class RateCycle:
    def step(self) -> None: ...

@final
class Predictor:
    def __new__(
        cls,
        rate_hz: float,
        axes: int = 3,
        method: Literal["switch", "periodic", "autoregressive", "fourier", "hold", "velocity", "acceleration"]
        | None = None,
        latency_s: float = 0.0,
        horizon_s: float | None = None,
        band: ArrayLike = ...,
        noise: float = 3e-4,
        harmonics: int = 2,
        speed_limit: float = 0.5,
        jump_m: float | None = None,
        longest_s: float = 1.0,
        start_s: float | None = None,
    ) -> Self: ...
    def update(self, stamp_s: float, position: ArrayLike) -> bool: ...
    def predict(self, at_s: float, out: _Array | None = None) -> _Array: ...
    def velocity(self, at_s: float, out: _Array | None = None) -> _Array: ...
    def bind(self, *, out: _Array, velocity: _Array | None = None) -> Callable[[float], None]: ...
    def covariance(self, at_s: float, out: _Array | None = None) -> _Array: ...
    def reset(self) -> None: ...
    @property
    def frequency(self) -> float | None: ...
    @property
    def frequency_margin(self) -> float | None: ...
    @property
    def amplitude(self) -> _Array | None: ...
    @property
    def amplitude_margin(self) -> _Array | None: ...
    @property
    def chosen(self) -> str: ...
    @property
    def status(self) -> int: ...
    @property
    def notes(self) -> tuple[str, ...]: ...
    @property
    def counters(self) -> dict[str, int]: ...

@final
class PredictorCycle:
    def step(self, at_s: float) -> None: ...

@final
class Controller:
    def __new__(
        cls,
        robot: Robot,
        law: str,
        *,
        kp: ArrayLike,
        kd: ArrayLike,
        rate_hz: float = 1000.0,
        tau_max: ArrayLike | None = None,
        tau_rate_max: ArrayLike | None = None,
        lower: ArrayLike | None = None,
        upper: ArrayLike | None = None,
        jump: ArrayLike | None = None,
        wrap: ArrayLike | None = None,
        ramp_s: float = 1.0,
        hold_s: float = 0.05,
        feedback: str | None = None,
        output: str | None = None,
        on_fault: str | None = None,
        elastic: ElasticGravity | None = None,
        disturbances: bool = True,
    ) -> Self: ...
    def bind(
        self,
        *,
        q: _Array,
        out: _Array,
        gravity: _Array | Accelerometer | None = None,
        specific_force: _Array | None = None,
        angular_velocity: _Array | None = None,
        angular_acceleration: _Array | None = None,
        qd: _Array | None = None,
        q_link: _Array | None = None,
        q_desired: _Array | None = None,
        qd_desired: _Array | None = None,
        tau_pd: _Array | None = None,
        tau_gravity: _Array | None = None,
        tau_disturbance: _Array | None = None,
        theta_desired: _Array | None = None,
    ) -> Callable[[], None]: ...
    def arm(self) -> None: ...
    def disarm(self) -> None: ...
    def acknowledge(self) -> None: ...
    def skip(self, cycles: int) -> None: ...
    @property
    def state(self) -> Literal["disarmed", "ramping", "armed", "fault"]: ...
    @property
    def status(self) -> int: ...
    @property
    def seen(self) -> tuple[str, ...]: ...
    @property
    def since(self) -> tuple[str, ...]: ...
    @property
    def counters(self) -> dict[str, int]: ...
    @property
    def iterations(self) -> int: ...
    @property
    def error_bound(self) -> float: ...

@final
class ControlCycle:
    def step(self) -> None: ...

@final
class Cycle:
    def step(self) -> None: ...

@final
class ElasticCycle:
    def step(self) -> None: ...

@disjoint_base
class ElasticGravity:
    def __new__(
        cls,
        robot: Robot,
        stiffness: ArrayLike,
        variant: str,
        contraction: float,
        iterations: int,
        tolerance: float,
    ) -> Self: ...
    @property
    def variant(self) -> str: ...
    @property
    def iterations(self) -> int: ...
    @property
    def error_bound(self) -> float: ...
    def reset(self) -> None: ...
    def torque(
        self,
        theta: ArrayLike,
        q_desired: ArrayLike,
        gravity: _GravityLike,
        q: ArrayLike | None = None,
        out: _Array | None = None,
    ) -> _Array: ...
    def theta_desired(self, q_desired: ArrayLike, gravity: _GravityLike, out: _Array | None = None) -> _Array: ...
    def link_position(self, theta: ArrayLike, gravity: _GravityLike, out: _Array | None = None) -> _Array: ...

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
    def disturbance_torque(self, q: ArrayLike, qd: ArrayLike | None = None, out: _Array | None = None) -> _Array: ...
    def disturbance_regressor(self, q: ArrayLike, qd: ArrayLike | None = None, out: _Array | None = None) -> _Array: ...
    def disturbance_parameters(self) -> _Array: ...
    @property
    def disturbance_columns(self) -> tuple[str, ...]: ...
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

def bind_gravity_torque(robot: Robot, q: _Array, gravity: _Array | Accelerometer, out: _Array) -> Cycle: ...
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
def bind_elastic_gravity(
    law: ElasticGravity,
    theta: _Array,
    q_desired: _Array,
    gravity: _Array | Accelerometer,
    out: _Array,
    q: _Array | None = None,
    theta_desired: _Array | None = None,
) -> ElasticCycle: ...
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
def gravity_stiffness_bound(
    robot: Robot,
    lower: ArrayLike,
    upper: ArrayLike,
    along: ArrayLike | None = None,
    out: _Array | None = None,
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
def disturbance_torque_batch(
    robot: Robot, q: ArrayLike, qd: ArrayLike | None = None, out: _Array | None = None, threads: int = 1
) -> _Array: ...
def disturbance_regressor_batch(
    robot: Robot, q: ArrayLike, qd: ArrayLike | None = None, out: _Array | None = None, threads: int = 1
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
def _ascend(
    rows: _Array,
    v: _Array,
    gradient: _Array,
    settings: tuple[float, float, float],
    lower: _Array,
    upper: _Array,
) -> tuple[_Array, float, int]: ...
def _box_minimum(
    rows: _Array,
    target: _Array,
    row_weight: _Array,
    wish: _Array,
    weight: _Array,
    lower: _Array,
    upper: _Array,
    warm: tuple[int, int],
) -> tuple[_Array, tuple[int, int], float, int, int]: ...
def _manipulability(robot: Robot, q: _Array) -> tuple[float, _Array]: ...
