"""A simulated robot on a moving base: MuJoCo's rigid-body mechanics, driven in the robot's own coordinates.

MuJoCo gives the mechanism's mass matrix M and the torques n that hold it unaccelerated while the base moves as
prescribed (:mod:`ravengc.sim.mechanism`). With rotors J, viscous friction D and Coulomb friction F the robot's
coordinates then obey, exactly,

    rigid       (M + J) q'' = tau - n - D q' - F(q')
    elastic     M q'' = c - n,    J o'' = tau - c - D o' - F(o'),    c = K (o - q) + B (o' - q')

where o are the rotors in units of the joints, K and B stiffness and damping of the cables between: friction is that of
motors, gears and pulleys, on the rotors' side of the cable. To n come the torques of the robot's disturbance elements,
which act on the links. So coupled mechanisms move without springs in between, and the base follows its motion without
error, whatever the arm does.

A step h is semi-implicit Euler: first velocities v, then positions x+ = x + h v+. Implicit are damping, friction, and
of the cables what keeps them stable: their force is taken at x + h (v+ - v) / 4. An undamped cable of natural frequency
w then swings with (2 / h) atan(w h / 2), neither damped nor driven by the integration, however stiff it is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc._convert import as_double, as_number, as_vector, check_choice, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ModelError
from ravengc.messages import shown
from ravengc.sim.base_swings import level
from ravengc.sim.elements import PlantElements
from ravengc.sim.friction import FRICTION_MODELS, CoulombFriction
from ravengc.sim.mechanism import Mechanism
from ravengc.sim.mjcf import positive

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ravengc.sim.base_motion import PrescribedBase

__all__ = ["Plant"]

Array = NDArray[np.float64]
PerCoordinate = float | Sequence[float] | Array

LONGEST_STEP = 1e6
"""Longest time (s) that a torque is held: weeks; what is longer, is a slip."""


class Plant:
    """A robot to be controlled: :meth:`step` takes torques; read ``q``, ``qd``, :meth:`accelerometer`, :meth:`gyro`.

    ``base`` is the prescribed motion of the base, ``step_s`` the longest integration step (s), ``sensor`` the place
    of the accelerometer and the gyro (m, base axes). ``rotor_inertia`` (kg m^2, kg; a number per coordinate or a full
    matrix), ``viscous`` (N m s, N s) and ``coulomb`` (N m, N) act on the robot's coordinates; ``friction`` says how
    Coulomb friction holds: "stick" exactly, "soft" with MuJoCo's creep (:mod:`ravengc.sim.friction`).
    ``cable_stiffness`` (N m/rad, N/m) and ``cable_damping`` (N m s, N s), a number per coordinate, put elastic cables
    between rotors and links; without them ``motor_q`` and ``motor_qd`` are ``q`` and ``qd``. The arrays ``q``, ``qd``,
    ``motor_q``, ``motor_qd`` (n,) are updated in place.

    The cables, springs and friction that ``robot.spec`` has as disturbance elements act too, unless ``disturbances`` is
    false: friction of a joint is added to ``viscous`` and ``coulomb``, the rest is explicit in time.

    The plant is built from ``robot.spec``: a payload, base or tool set at run time is not in it. Joint limits are not
    simulated. Raises ModelError if a coordinate (with cables: a link or a rotor) has no inertia at all, ArgumentError
    for impossible numbers, MissingExtraError without MuJoCo.
    """

    def __init__(
        self,
        robot: ravengc.Robot,
        base: PrescribedBase | None = None,
        *,
        step_s: float = 0.0005,
        sensor: Sequence[float] = (0.0, 0.0, 0.0),
        rotor_inertia: PerCoordinate = 0.0,
        viscous: PerCoordinate = 0.0,
        coulomb: PerCoordinate = 0.0,
        friction: Literal["stick", "soft"] = "stick",
        cable_stiffness: PerCoordinate | None = None,
        cable_damping: PerCoordinate = 0.0,
        disturbances: bool = True,
    ) -> None:
        check_type(robot, ravengc.Robot, "robot")
        check_choice(friction, FRICTION_MODELS, "friction", ArgumentError)
        self.robot = robot
        self._h = 0.0
        self.base: PrescribedBase = level() if base is None else base
        self.step_s = positive(step_s, "step_s")
        check_type(disturbances, bool, "disturbances")
        self._elements = PlantElements(robot, present=disturbances)
        self.coulomb = _per_coordinate("coulomb", coulomb, robot.n) + self._elements.coulomb
        self._friction = CoulombFriction(self.coulomb.tolist(), friction)
        self._rotors = _rotor_matrix(rotor_inertia, robot.n)
        self._viscous = np.diag(_per_coordinate("viscous", viscous, robot.n) + self._elements.viscous)
        self._cable_stiffness = _cable_stiffness(cable_stiffness, robot.n)
        self._cable_damping = _per_coordinate("cable_damping", cable_damping, robot.n)
        if self._cable_stiffness is None and self._cable_damping.any():
            raise ArgumentError("cable_damping needs cable_stiffness: without it there are no cables")
        self._make_state(robot.n)
        self._mechanism = Mechanism(robot.spec, self.base, step_s=self.step_s, sensor=sensor)
        self.reset(self.q)
        self._require_inertia()

    @property
    def time(self) -> float:
        """Time on the base's clock (s): what :meth:`reset` set, plus the steps since."""
        return self._time

    @property
    def mjcf(self) -> str:
        """The MuJoCo model as MJCF text."""
        return self._mechanism.text

    @property
    def elastic(self) -> bool:
        """Whether there are cables between rotors and links."""
        return self._cable_stiffness is not None

    @property
    def friction_torque(self) -> Array:
        """Coulomb friction during the last step, (n,), N m or N: what the motors had to give for it."""
        return np.array(self._friction.force)

    @property
    def cable_torque(self) -> Array:
        """What the cables give the links, (n,), N m or N; ModelError without cables."""
        if self._cable_stiffness is None:
            raise ModelError("the plant is rigid; give cable_stiffness")
        stretch, rate = self.motor_q - self.q, self.motor_qd - self.qd
        return self._cable_stiffness * stretch + self._cable_damping * rate

    def reset(
        self,
        q: Sequence[float] | Array,
        qd: Sequence[float] | Array | None = None,
        *,
        time: float = 0.0,
        motor_q: Sequence[float] | Array | None = None,
    ) -> None:
        """Put the arm at ``q`` (n,), moving at ``qd`` (at rest if ``None``), and the base where it is at ``time``.

        Rotors move with their links. They stand at ``motor_q`` (n,), or where the cables carry the arm unaccelerated;
        ArgumentError for ``motor_q`` of a rigid plant.
        """
        positions = self._coordinates(q, "q")
        rates = np.zeros(self.robot.n) if qd is None else self._coordinates(qd, "qd")
        rotors = None if motor_q is None else self._coordinates(motor_q, "motor_q")
        if rotors is not None and self._cable_stiffness is None:
            raise ArgumentError("motor_q is that of a plant with cables; give cable_stiffness")
        start = as_number(time, "time")
        if not abs(start) <= LARGEST:
            raise ArgumentError(f"time is {start} s; expected a number of at most {LARGEST:g}")
        self._time = start
        self.q[:], self.qd[:] = positions, rates
        self.motor_qd[:] = rates
        self._friction.reset()
        self._mechanism.place(start, self.q, self.qd)
        if self._cable_stiffness is not None:
            load = self._mechanism.bias() + self._elements.torque(self.q, self.qd)
            loaded = self.q + load / self._cable_stiffness
            self.motor_q[:] = loaded if rotors is None else rotors

    def step(self, tau: Sequence[float] | Array, dt: float) -> None:
        """Hold the joint torques ``tau`` (n,) for ``dt`` seconds, in equal steps of at most ``step_s``."""
        held = as_double(tau, "tau")
        if held.shape != self.q.shape:
            raise ArgumentError(f"tau must be {self.robot.n} numbers, not an array of shape {held.shape}")
        span = dt if type(dt) is float else as_number(dt, "dt")
        if not 0.0 <= span <= LONGEST_STEP:
            raise ArgumentError(f"dt is {dt!r} s; expected 0 to {LONGEST_STEP:g}")
        count = math.ceil(span / self.step_s - 1e-6) or int(span > 0.0)
        if count == 0:
            return
        h = span / count
        if h != self._h:
            self._h, self._cables = h, 0.25 * h * h * self._stiffness
            self._implicit = self._cables + h * self._damping
        for _ in range(count):
            self._advance(held)

    def accelerometer(self) -> Array:
        """MuJoCo's accelerometer: the specific force at the sensor's place in base axes, (3,), m/s^2."""
        return self._mechanism.accelerometer()

    def gyro(self) -> Array:
        """MuJoCo's gyro: the base's angular velocity in base axes, (3,), rad/s."""
        return self._mechanism.gyro()

    def mass_matrix(self) -> Array:
        """C^T M C, (n, n), of the mechanism as it stands, without rotors."""
        return self._mechanism.mass_matrix()

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """MuJoCo's torques, (n,), for a motion of the arm at the present time, without rotors and friction.

        The plant's own state is left as it was.
        """
        motion = self._coordinates(q, "q"), self._coordinates(qd, "qd"), self._coordinates(qdd, "qdd")
        torque = self._mechanism.torque(self._time, *motion)
        self._mechanism.place(self._time, self.q, self.qd)
        return torque

    def _coordinates(self, values: ArrayLike, name: str) -> Array:
        return as_vector(values, name, self.robot.n, LARGEST)

    def _make_state(self, n: int) -> None:
        """Make the state of links and rotors, which are the same where there are no cables, and their matrices.

        Rotors come last: friction and motor torques act on the last n.
        """
        size = n if self._cable_stiffness is None else 2 * n
        self._positions, self._velocities, self._force = np.zeros((3, size))
        self.q, self.qd = self._positions[:n], self._velocities[:n]
        self.motor_q, self.motor_qd = self._positions[-n:], self._velocities[-n:]
        self._links_force, self._motors_force = self._force[:n], self._force[-n:]
        self._inertia, self._damping, self._stiffness = np.zeros((3, size, size))
        self._inertia[-n:, -n:] = self._rotors
        self._links_inertia = self._inertia[:n, :n]
        self._links_rotors = self._links_inertia.copy()
        self._damping[-n:, -n:] = self._viscous
        self._cables, self._implicit = np.zeros((2, size, size))
        if self._cable_stiffness is not None:
            between = np.array(((1.0, -1.0), (-1.0, 1.0)))
            self._stiffness += np.kron(between, np.diag(self._cable_stiffness))
            self._damping += np.kron(between, np.diag(self._cable_damping))

    def _advance(self, tau: Array) -> None:
        """One step of the length, and with the implicit terms, that :meth:`step` has set."""
        mechanism, velocities, h = self._mechanism, self._velocities, self._h
        np.add(mechanism.mass_matrix(), self._links_rotors, out=self._links_inertia)
        np.negative(mechanism.bias(), out=self._links_force)
        if self._elements.present:
            self._links_force -= self._elements.torque(self.q, self.qd)
        if self._cable_stiffness is None:
            self._links_force += tau
            momentum = self._inertia @ velocities
        else:
            self._motors_force[:] = tau
            self._force -= self._stiffness @ self._positions
            momentum = (self._inertia + self._cables) @ velocities
        response: Array = np.asarray(np.linalg.inv(self._inertia + self._implicit), dtype=np.float64)
        after = response @ (momentum + h * self._force)
        if self._friction.present:
            n = len(tau)
            change: Array = h * response[:, -n:]
            after -= change @ self._friction.rub(self.motor_qd, after[-n:], change[-n:], h)
        velocities[:] = after
        self._positions += h * after
        self._time += h
        mechanism.place(self._time, self.q, self.qd)

    def _require_inertia(self) -> None:
        links = self._mechanism.mass_matrix() + self._links_rotors
        self._require("moves no inertia (the links it carries are massless or points on its axis)", links)
        if self._cable_stiffness is not None:
            self._require("has a cable, but a rotor without inertia", self._rotors)

    def _require(self, otherwise: str, inertia: Array) -> None:
        eigenvalues, directions = np.linalg.eigh(inertia)
        if eigenvalues[0] < 1e-9:
            name = self.robot.joint_names[int(np.argmax(np.abs(directions[:, 0])))]
            raise ModelError(f"robot '{self.robot.name}': joint '{name}' {otherwise}; give rotor_inertia")


def _cable_stiffness(value: PerCoordinate | None, n: int) -> Array | None:
    if value is None:
        return None
    stiffness = _per_coordinate("cable_stiffness", value, n)
    if not stiffness.all():
        raise ArgumentError(f"cable_stiffness must be positive, not {shown(value)}; a motor needs its cable")
    return stiffness


def _rotor_matrix(value: PerCoordinate, n: int) -> Array:
    matrix = as_double(value, "rotor_inertia")
    if matrix.ndim < 2:
        return np.diag(_per_coordinate("rotor_inertia", matrix, n))
    if matrix.shape != (n, n) or not _is_inertia(matrix):
        raise ArgumentError(
            f"rotor_inertia must be a number, {n} numbers or a symmetric positive {n}x{n} matrix, "
            f"not an array of shape {matrix.shape}"
        )
    return matrix


def _is_inertia(matrix: Array) -> bool:
    symmetric = bool((np.abs(matrix) <= LARGEST).all()) and np.allclose(matrix, matrix.T)
    return symmetric and bool(np.linalg.eigvalsh(matrix)[0] >= -1e-12)


def _per_coordinate(name: str, value: PerCoordinate, n: int) -> Array:
    numbers = as_double(value, name)
    if numbers.shape not in {(), (n,)} or not ((numbers >= 0.0) & (numbers <= LARGEST)).all():
        expected = f"finite and not negative, at most {LARGEST:g}"
        raise ArgumentError(f"{name} must be one number or {n}, {expected}, not {shown(value)}")
    return np.array(np.broadcast_to(numbers, (n,)))
