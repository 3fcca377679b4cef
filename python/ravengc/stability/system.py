"""The linear system of base, arm, law and sensor.

    (M s^2 + C s + K - U H(s) (R2 s^2 + R0)) x = 0,        x = (base coordinates y, joint coordinates q)

M, C, K: base and arm with the law's PD gains, as static gravity compensation leaves them. The sensor reads
(R2 s^2 + R0) x; what :class:`Sensing` makes of it, H, becomes joint torque through U. :func:`linearise` takes it from
a robot's model in one pose; :mod:`one_link` writes it down for one link.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc._convert import as_vector, check_choice, check_type
from ravengc.config.physical import LARGEST
from ravengc.control import Drive
from ravengc.coordinates import sliding
from ravengc.errors import ConfigError
from ravengc.reference.kinematics import skew
from ravengc.stability.mount import Mount
from ravengc.stability.sensing import Sensing

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["LAWS", "System", "linearise"]

Array = NDArray[np.float64]
LEVEL = (0.0, 0.0, -ravengc.STANDARD_GRAVITY)
FEEDING_LAWS = ("pd+dg", "pd+bm")
"""Laws that feed the sensor's reading forward."""
LAWS = ("pd", "pd+sg", *FEEDING_LAWS)
"""Laws that hold the joints, so that there is something to certify."""
FARTHEST = 1e3
"""m: no sensor is further from the base origin."""


@dataclass(frozen=True, eq=False)
class System:
    """A linear system with one delayed feedback, N coordinates, the base's ``base`` first, and r fed signals.

    ``mass``, ``damping``, ``stiffness`` (N, N); ``inputs`` U (N, r); ``reads_acceleration`` R2 and ``reads_position``
    R0 (r, N). ``sensing`` is H. ``turns`` (N,) says which coordinates are angles (rad) and not lengths (m).
    """

    mass: Array
    damping: Array
    stiffness: Array
    inputs: Array
    reads_acceleration: Array
    reads_position: Array
    base: int
    sensing: Sensing
    turns: tuple[bool, ...]

    @property
    def size(self) -> int:
        """Number of coordinates, N."""
        return len(self.mass)

    @property
    def fed(self) -> bool:
        """Whether any reading reaches a torque; without that, and with damping, there is nothing to become unstable."""
        reads = np.abs(self.reads_acceleration).max() + np.abs(self.reads_position).max()
        return bool(self.sensing.gain > 0.0 and np.abs(self.inputs).max() > 0.0 and reads > 0.0)

    @property
    def high_frequency_gain(self) -> float:
        """What is left of the loop's gain at high frequency, rho times the spectral radius of R2 M^-1 U.

        0 behind a low-pass. Above 1, with a delay, it is unstable for any delay.
        """
        if self.sensing.cutoff_hz is not None:
            return 0.0
        through = self.reads_acceleration @ np.linalg.solve(self.mass, self.inputs)
        return self.sensing.gain * float(np.abs(np.linalg.eigvals(through)).max())

    def sensed(self, **changes: float | None) -> System:
        """Return the same with another way from the reading to the torque."""
        return replace(self, sensing=self.sensing.with_(**changes))

    @cached_property
    def normal(self) -> System:
        """The same in coordinates with mass 1, where lengths and angles compare: all norms are taken there."""
        left, right = _to_unit_mass(self.mass)
        return replace(
            self,
            mass=np.eye(self.size),
            damping=left @ self.damping @ right,
            stiffness=left @ self.stiffness @ right,
            inputs=left @ self.inputs,
            reads_acceleration=self.reads_acceleration @ right,
            reads_position=self.reads_position @ right,
        )

    def reading(self, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """R2 s^2 + R0 for every s (k,): (k, r, N)."""
        return self.reads_acceleration * (s * s)[:, None, None] + self.reads_position

    def without_feedback(self, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """M s^2 + C s + K for every s (k,): (k, N, N)."""
        each = s[:, None, None]
        found: NDArray[np.complex128] = self.mass * each * each + self.damping * each + self.stiffness
        return found

    def matrix(self, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """The whole matrix for every s (k,): (k, N, N). Its determinant is zero at the poles."""
        fed = self.sensing.response(s)[:, None, None] * (self.inputs @ self.reading(s))
        found: NDArray[np.complex128] = self.without_feedback(s) - fed
        return found


def linearise(
    robot: ravengc.Robot,
    q: Sequence[float] | Array,
    drive: Drive,
    mount: Mount,
    sensing: Sensing,
    *,
    law: str = "pd+dg",
    gravity: Sequence[float] | Array = LEVEL,
    sensor: Sequence[float] | Array = (0.0, 0.0, 0.0),
) -> System:
    """Linearise a robot that ``drive`` holds at ``q`` on a ``mount``, under one of :data:`LAWS`.

    ``gravity`` (3,) at rest, base axes, m/s^2. ``sensor`` (3,): place of the accelerometer that no lever-arm correction
    makes up for, m, base axes; 0 for one whose readings are brought to the base origin with a gyroscope. Raises
    ArgumentError and ConfigError.
    """
    arm = _arm(robot, q, drive, law, gravity)
    check_type(mount, Mount, "mount")
    check_type(sensing, Sensing, "sensing")
    place, twists = as_vector(sensor, "sensor", 3, FARTHEST), mount.directions.T
    coupling = arm.on_base @ twists  # M_qb
    on_base = mount.mass + twists.T @ arm.inertia @ twists
    held, lost = mount.held(on_base)
    n, m = robot.n, mount.size
    turning = arm.force @ twists[3:]  # f of a base at rest, in base axes, when it turns: f x phi
    pull = arm.on_base[:, :3] @ turning
    if law == "pd+bm":
        inputs, reads, tilt = arm.on_base, twists, np.vstack([turning, np.zeros((3, m))])
    else:
        inputs, tilt = arm.on_base[:, :3], turning
        reads = twists[:3] - skew(place) @ twists[3:]
    feeds = law in FEEDING_LAWS
    return System(
        mass=_definite(np.block([[on_base, coupling.T], [coupling, arm.mass]])),
        damping=np.block([[lost, np.zeros((m, n))], [np.zeros((n, m)), np.diag(drive.kd)]]),
        stiffness=np.block([[held, pull.T], [pull, arm.stiffness]]),
        inputs=np.vstack([np.zeros((m, inputs.shape[1])), inputs * feeds]),
        reads_acceleration=np.hstack([reads, np.zeros((len(reads), n))]),
        reads_position=np.hstack([tilt, np.zeros((len(reads), n))]),
        base=m,
        sensing=sensing,
        turns=(*twists[3:].any(axis=0).tolist(), *(~sliding(robot.spec)).tolist()),
    )


@dataclass(frozen=True, eq=False)
class _Arm:
    """The arm in one pose.

    ``mass`` and ``stiffness`` (n, n), torques ``on_base`` (n, 6) for unit accelerations of the base, its own 6 x 6
    ``inertia`` as the base carries it, and S(f) of the specific force at rest, ``force``.
    """

    mass: Array
    stiffness: Array
    on_base: Array
    inertia: Array
    force: Array


def _arm(
    robot: ravengc.Robot, q: Sequence[float] | Array, drive: Drive, law: str, gravity: Sequence[float] | Array
) -> _Arm:
    check_type(robot, ravengc.Robot, "robot")
    check_type(drive, Drive, "drive")
    check_choice(law, LAWS, "law")
    pose, field = as_vector(q, "q", robot.n, LARGEST), as_vector(gravity, "gravity", 3, LARGEST)
    kp, _, rotors = (_numbers_of(drive, name, robot) for name in ("kp", "kd", "rotor_inertia"))
    still = np.zeros(robot.n)
    torques, wrenches = [], []
    for unit in np.eye(6):
        motion = ravengc.BaseMotion(specific_force=unit[:3], angular_acceleration=unit[3:])
        torques.append(robot.inverse_dynamics(pose, still, still, motion))
        wrenches.append(robot.base_wrench(pose, still, still, motion))
    inertia = np.array(wrenches)
    stiffness = np.diag(kp)
    if law not in FEEDING_LAWS:  # those compensate this pose's gravity where the joints are
        stiffness = stiffness + robot.gravity_stiffness(pose, field)
    if law == "pd+sg":
        stiffness = stiffness - robot.gravity_stiffness(pose, LEVEL)
    mass = robot.mass_matrix(pose) + np.diag(rotors)
    return _Arm(mass, stiffness, np.array(torques).T, (inertia + inertia.T) / 2.0, skew(-field))


def _numbers_of(drive: Drive, name: str, robot: ravengc.Robot) -> Array:
    """Return one kind of the drive's numbers, all of them such that the joints are held and damped."""
    numbers = as_vector(getattr(drive, name), name, robot.n, 1e30)
    good, wanted = (numbers > 0.0, "above zero") if name == "kp" else (numbers >= 0.0, "zero or more")
    if not good.all():
        first = int(np.argmin(good))
        raise ConfigError(f"{name} of '{robot.joint_names[first]}' is {numbers[first]}; expected {wanted}")
    return numbers


def _definite(mass: Array) -> Array:
    """Return the mass matrix itself, refused if some motion has no inertia."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(mass), 1e-300))
    least = float(np.linalg.eigvalsh(mass * np.outer(scale, scale)).min())
    if not least > 1e-12:
        raise ConfigError(
            "the mass matrix of base and arm is singular: give the base a mass above zero, and links or rotors inertia"
        )
    return mass


def _to_unit_mass(mass: Array) -> tuple[Array, Array]:
    """Return P and Q with P M Q = 1; for a symmetric M they are each other's transposes."""
    if np.array_equal(mass, mass.T):
        left: Array = np.asarray(np.linalg.inv(np.linalg.cholesky(mass)), np.float64)
        return left, left.T
    right = np.diag(1.0 / np.sqrt(np.diag(mass)))
    return np.asarray(np.linalg.inv(mass @ right), np.float64), right
