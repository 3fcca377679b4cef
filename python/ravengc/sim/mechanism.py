"""A robot's links on their moving base in MuJoCo: mass matrix and torques in the robot's own coordinates.

With the mechanism's joints q_m = C q + c0, M_m their mass matrix and n the torques that hold them unaccelerated while
the base moves, the robot's coordinates have the mass matrix C^T M_m C and the bias C^T n.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.errors import MissingExtraError
from ravengc.sim.mjcf import to_mjcf

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ravengc.sim.base_motion import PrescribedBase
    from ravengc.spec import RobotSpec

__all__ = ["Mechanism"]

Array = NDArray[np.float64]

BASE_DOFS = 6


class Mechanism:
    """MuJoCo's model of a robot whose base moves as ``base`` says; what it says holds for the last :meth:`place`.

    Raises MissingExtraError without MuJoCo.
    """

    def __init__(self, robot: RobotSpec, base: PrescribedBase, *, step_s: float, sensor: Sequence[float]) -> None:
        self._mujoco = _import_mujoco()
        self._base = base
        self.text = to_mjcf(robot, base, step_s=step_s, sensor=sensor)
        self._model = self._mujoco.MjModel.from_xml_string(self.text)
        self._data = data = self._mujoco.MjData(self._model)
        self._coupling, self._coupling_offset = self._joint_motions(robot)
        self._is_coupled = robot.coupling is not None or not np.array_equal(self._coupling, np.eye(len(self._coupling)))
        self._masses = np.zeros((self._model.nv, self._model.nv))
        self._joint_masses = self._masses[BASE_DOFS:, BASE_DOFS:]
        self._read_masses = _mass_reader(self._mujoco, self._model, data, self._masses)
        self._base_position, self._position = data.qpos[:BASE_DOFS], data.qpos[BASE_DOFS:]
        self._base_velocity, self._velocity = data.qvel[:BASE_DOFS], data.qvel[BASE_DOFS:]
        self._base_acceleration, self._acceleration = data.qacc[:BASE_DOFS], data.qacc[BASE_DOFS:]
        self._torque = data.qfrc_inverse[BASE_DOFS:]
        self._sensors = data.sensordata

    def place(self, time: float, q: Array, qd: Array) -> None:
        """Put base and arm where they are, the arm moving at ``qd`` without acceleration; (n,) each."""
        self._base_position[:], self._base_velocity[:], self._base_acceleration[:] = self._base.state(time)
        if self._is_coupled:
            self._position[:] = self._coupling @ q + self._coupling_offset
            self._velocity[:] = self._coupling @ qd
        else:
            self._position[:], self._velocity[:] = q, qd
        self._mujoco.mj_inverse(self._model, self._data)

    def bias(self) -> Array:
        """C^T n, (n,)."""
        bias: Array = self._coupling.T @ self._torque if self._is_coupled else self._torque.copy()
        return bias

    def mass_matrix(self) -> Array:
        """C^T M_m C, (n, n), without rotors."""
        self._read_masses()
        masses = self._joint_masses
        return self._coupling.T @ masses @ self._coupling if self._is_coupled else masses.copy()

    def torque(self, time: float, q: Array, qd: Array, qdd: Array) -> Array:
        """Torques, (n,), of a motion (n,) each; leaves the arm there, but not accelerating."""
        self._acceleration[:] = self._coupling @ qdd
        self.place(time, q, qd)
        self._acceleration[:] = 0.0
        return self.bias()

    def accelerometer(self) -> Array:
        """Specific force at the sensor's place in base axes, (3,), m/s^2."""
        return np.array(self._sensors[:3])

    def gyro(self) -> Array:
        """Angular velocity of the base in base axes, (3,), rad/s."""
        return np.array(self._sensors[3:6])

    def _joint_motions(self, robot: RobotSpec) -> tuple[Array, Array]:
        """C and c0 with a row for each of MuJoCo's joints, which it orders branch by branch."""
        matrix, offset = _coupling(robot)
        place = {link.name: row for row, link in enumerate(robot.moving_links)}
        rows = [place[self._model.joint(index).name] for index in range(BASE_DOFS, self._model.njnt)]
        return matrix[rows], offset[rows]


def _coupling(robot: RobotSpec) -> tuple[Array, Array]:
    if robot.coupling is None:
        n = len(robot.moving_links)
        return np.eye(n), np.zeros(n)
    return np.array(robot.coupling.matrix), np.array(robot.coupling.offset)


def _mass_reader(mujoco: Any, model: Any, data: Any, dense: Array) -> Callable[[], None]:
    """What writes the mass matrix into ``dense``; from version 4 on MuJoCo takes it from the data itself."""
    if hasattr(data, "qM"):
        return partial(mujoco.mj_fullM, model, dense, data.qM)
    return partial(mujoco.mj_fullM, model, data, dense)


def _import_mujoco() -> Any:
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtraError("mujoco", "sim", "the simulated plant") from error
    return mujoco
