"""A simulated robot on a moving base: MuJoCo's rigid-body mechanics, driven in the robot's own coordinates.

MuJoCo gives the mechanism's mass matrix M, and by inverse dynamics the torques n that hold it unaccelerated while the
base moves as prescribed. With q_m = C q + c0 the robot's coordinates then obey, exactly,

    (C^T M C + J) q'' = tau - C^T n - D q' - friction

where J is the inertia of the rotors, D viscous friction, and Coulomb friction sticks below and slides at its limit.
So coupled mechanisms move without springs in between, and the base follows its motion without error, whatever the arm
does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc._convert import as_double, as_number, as_vector, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, MissingExtraError, ModelError
from ravengc.messages import shown
from ravengc.sim.base_motion import BaseTrajectory, level
from ravengc.sim.mjcf import positive, to_mjcf

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ravengc.spec import RobotSpec

__all__ = ["Plant"]

Array = NDArray[np.float64]
PerCoordinate = float | Sequence[float] | Array

BASE_DOFS = 6
LONGEST_STEP = 1e6
"""Longest time (s) that a torque is held: weeks; what is longer, is a slip."""
FRICTION_SWEEPS = 50


class Plant:
    """A robot to be controlled: :meth:`step` takes torques; read ``q``, ``qd``, :meth:`accelerometer`, :meth:`gyro`.

    ``base`` is the prescribed motion of the base, ``step_s`` the longest integration step (s), ``sensor`` the place
    of the accelerometer and the gyro (m, base axes). ``rotor_inertia`` (kg m^2, kg; a number per coordinate or a full
    matrix), ``viscous`` (N m s, N s) and ``coulomb`` (N m, N) act on the robot's coordinates. The plant is built from
    ``robot.spec``: a payload, base or tool set at run time is not in it. Joint limits are not simulated. Raises
    ModelError if a coordinate has no inertia at all, ArgumentError for impossible numbers, MissingExtraError without
    MuJoCo.
    """

    def __init__(
        self,
        robot: ravengc.Robot,
        base: BaseTrajectory | None = None,
        *,
        step_s: float = 0.0005,
        sensor: Sequence[float] = (0.0, 0.0, 0.0),
        rotor_inertia: PerCoordinate = 0.0,
        viscous: PerCoordinate = 0.0,
        coulomb: PerCoordinate = 0.0,
    ) -> None:
        check_type(robot, ravengc.Robot, "robot")
        self.robot = robot
        self.base = level() if base is None else base
        check_type(self.base, BaseTrajectory, "base")
        self.step_s = positive(step_s, "step_s")
        self.coulomb = _per_coordinate("coulomb", coulomb, robot.n)
        self._viscous = np.diag(_per_coordinate("viscous", viscous, robot.n))
        self._rotor_inertia = _rotor_matrix(rotor_inertia, robot.n)
        self._mujoco = _import_mujoco()
        text = to_mjcf(robot.spec, self.base, step_s=self.step_s, sensor=sensor)
        self._model = self._mujoco.MjModel.from_xml_string(text)
        self._data = self._mujoco.MjData(self._model)
        self._coupling, self._coupling_offset = self._joint_motions()
        self._unit_motions = np.hstack((np.zeros((robot.n, BASE_DOFS)), self._coupling.T))
        self._momenta = np.zeros_like(self._unit_motions)
        self.q = np.zeros(robot.n)
        self.qd = np.zeros(robot.n)
        self._friction_force = np.zeros(robot.n)
        self.reset(self.q)
        self._require_inertia()

    @property
    def time(self) -> float:
        """Time on the base's clock (s): what :meth:`reset` set, plus the steps since."""
        return self._time

    @property
    def mjcf(self) -> str:
        """The MuJoCo model as MJCF text."""
        return to_mjcf(self.robot.spec, self.base, step_s=self.step_s, sensor=self._model.site_pos[0])

    def reset(
        self, q: Sequence[float] | Array, qd: Sequence[float] | Array | None = None, *, time: float = 0.0
    ) -> None:
        """Put the arm at ``q`` (n,), moving at ``qd`` (at rest if ``None``), and the base where it is at ``time``."""
        positions = self._coordinates(q, "q")
        rates = np.zeros(self.robot.n) if qd is None else self._coordinates(qd, "qd")
        start = as_number(time, "time")
        if not abs(start) <= LARGEST:
            raise ArgumentError(f"time is {start} s; expected a number of at most {LARGEST:g}")
        self._time = start
        self.q[:], self.qd[:] = positions, rates
        self._friction_force[:] = 0.0
        self._evaluate()

    def step(self, tau: Sequence[float] | Array, dt: float) -> None:
        """Hold the joint torques ``tau`` (n,) for ``dt`` seconds, in equal steps of at most ``step_s``."""
        held = as_double(tau, "tau")
        if held.shape != self.q.shape:
            raise ArgumentError(f"tau must be {self.robot.n} numbers, not an array of shape {held.shape}")
        if not 0.0 <= as_number(dt, "dt") <= LONGEST_STEP:
            raise ArgumentError(f"dt is {dt!r} s; expected 0 to {LONGEST_STEP:g}")
        count = max(1, int(np.ceil(dt / self.step_s - 1e-6)))
        for _ in range(count):
            self._advance(held, dt / count)

    def accelerometer(self) -> Array:
        """MuJoCo's accelerometer: the specific force at the sensor's place in base axes, (3,), m/s^2."""
        return np.array(self._data.sensordata[:3])

    def gyro(self) -> Array:
        """MuJoCo's gyro: the base's angular velocity in base axes, (3,), rad/s."""
        return np.array(self._data.sensordata[3:6])

    def mass_matrix(self) -> Array:
        """C^T M C, (n, n), of the mechanism as it stands, without rotors."""
        for column, motion in zip(self._momenta, self._unit_motions, strict=True):
            self._mujoco.mj_mulM(self._model, self._data, column, motion)
        return self._momenta[:, BASE_DOFS:] @ self._coupling

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """MuJoCo's torques, (n,), for a motion of the arm at the present time, without rotors and friction.

        The plant's own state is left as it was.
        """
        positions, rates = self._coordinates(q, "q"), self._coordinates(qd, "qd")
        accelerations = self._coordinates(qdd, "qdd")
        kept = self.q.copy(), self.qd.copy()
        self.q[:], self.qd[:] = positions, rates
        self._evaluate(self._coupling @ accelerations)
        torque: Array = self._coupling.T @ self._data.qfrc_inverse[BASE_DOFS:]
        self.q[:], self.qd[:] = kept
        self._evaluate()
        return torque

    def _coordinates(self, values: ArrayLike, name: str) -> Array:
        return as_vector(values, name, self.robot.n, LARGEST)

    def _evaluate(self, acceleration: float | Array = 0.0) -> None:
        """Work out mass matrix, torques and sensors; the mechanism's joints accelerate as given."""
        data, base = self._data, self.base.state(self._time)
        data.qpos[:BASE_DOFS], data.qvel[:BASE_DOFS], data.qacc[:BASE_DOFS] = base
        data.qpos[BASE_DOFS:] = self._coupling @ self.q + self._coupling_offset
        data.qvel[BASE_DOFS:] = self._coupling @ self.qd
        data.qacc[BASE_DOFS:] = acceleration
        self._mujoco.mj_inverse(self._model, data)

    def _advance(self, tau: Array, h: float) -> None:
        """One step: friction implicit, the rest explicit, positions with the new velocity (semi-implicit Euler)."""
        inertia = self.mass_matrix() + self._rotor_inertia
        bias = self._coupling.T @ self._data.qfrc_inverse[BASE_DOFS:]
        response = np.asarray(np.linalg.inv(inertia + h * self._viscous), dtype=np.float64)
        self.qd[:] = response @ (inertia @ self.qd + h * (tau - bias))
        if self.coulomb.any():
            self._rub(h * response)
        self.q += h * self.qd
        self._time += h
        self._evaluate()

    def _rub(self, response: Array) -> None:
        """Coulomb friction: the force at each coordinate that stops it, or its limit where that is not enough.

        ``response`` is the change of velocity by a force held for the step. Projected Gauss-Seidel, from the last
        step's forces.
        """
        self.qd -= response @ self._friction_force
        for _ in range(FRICTION_SWEEPS):
            before = self._friction_force.copy()
            for i, limit in enumerate(self.coulomb):
                wanted = self._friction_force[i] + self.qd[i] / response[i, i]
                change = min(max(wanted, -limit), limit) - self._friction_force[i]
                self._friction_force[i] += change
                self.qd -= change * response[:, i]
            if np.abs(self._friction_force - before).max() <= 1e-9 * self.coulomb.max():
                break

    def _joint_motions(self) -> tuple[Array, Array]:
        """C and c0 with a row for each of MuJoCo's joints, which it orders branch by branch."""
        matrix, offset = _coupling(self.robot.spec)
        place = {link.name: row for row, link in enumerate(self.robot.spec.moving_links)}
        rows = [place[self._model.joint(index).name] for index in range(BASE_DOFS, self._model.njnt)]
        return matrix[rows], offset[rows]

    def _require_inertia(self) -> None:
        eigenvalues, directions = np.linalg.eigh(self.mass_matrix() + self._rotor_inertia)
        if eigenvalues[0] < 1e-9:
            name = self.robot.joint_names[int(np.argmax(np.abs(directions[:, 0])))]
            raise ModelError(
                f"robot '{self.robot.name}': joint '{name}' moves no inertia "
                "(the links it carries are massless or points on its axis); give rotor_inertia"
            )


def _coupling(robot: RobotSpec) -> tuple[Array, Array]:
    if robot.coupling is None:
        n = len(robot.moving_links)
        return np.eye(n), np.zeros(n)
    return np.array(robot.coupling.matrix), np.array(robot.coupling.offset)


def _import_mujoco() -> Any:
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtraError("mujoco", "sim", "the simulated plant") from error
    return mujoco


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
