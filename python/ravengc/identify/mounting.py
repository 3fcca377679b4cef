"""How the base's accelerometer is turned, its bias, and the arm's first moments, from torques on a tilted base.

In rest tau = Σ_k f_k Y_k(q) p with the specific force f = R (s - b) of the reading s, and Y_k the regressor of a unit
force along axis k: linear in p, and in R and b but for the rotation. Gauss and Newton go over the rotation, the bias
and p at once. The scale of the sensor cannot be found this way (twice f and half of p are the same torques); it is
fixed by |f| = g. A level base shows two of the three angles and no bias, tilts about one axis show them badly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc._core import STANDARD_GRAVITY
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.identify.base_parameters import BaseParameters, base_parameters
from ravengc.identify.model import Model
from ravengc.identify.recording import FloatArray, Recording
from ravengc.messages import shown
from ravengc.robot import Robot

__all__ = ["MountingFit", "mounting"]

WEAK_CONDITION = 50.0
"""Beyond it a fit is good for torques within the tilts it saw, and a poor calibration of the sensor."""
REMEDY = "tilt it by 10 degrees or more about two axes, a dozen poses of the arm at each"
LOST = 0.1
"""rad; a standard error of the rotation from which on nothing has been found."""
ONE_AXIS = 0.2
"""Ratio of the second to the first spread of tilts below which they count as about one axis."""
ROUNDS = 100
SETTLED = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class MountingFit:
    """``rotation`` R (base axes from sensor axes) and ``bias`` b (3,) m/s²: f = R (s - b); ``values`` (b,) of ``base``.

    ``rotation_sd`` (3,) rad about base axes and ``bias_sd`` are formal; ``condition`` is that of rotation and bias with
    all parameters free. ``rms`` (n,) is the torque error, ``scale`` the mean of |s - b| over g: further from 1 than
    noise explains, the sensor's scale is wrong. ``warnings`` say what to record for a better one.
    """

    rotation: FloatArray
    bias: FloatArray
    rotation_sd: FloatArray
    bias_sd: FloatArray
    base: BaseParameters
    values: FloatArray
    rms: FloatArray
    condition: float
    scale: float
    warnings: tuple[str, ...]


def mounting(robot: Robot, recording: Recording, *, noise: float = 0.02) -> MountingFit:
    """Fit mounting, bias and first moments to poses at rest, with the sensor's own readings as ``specific_force``.

    ``noise`` (m/s²) is that of a reading; with it |s - b| = g counts beside the torques. The search starts from the
    masses that the robot has. Raises ArgumentError for a recording without readings, and CalibrationError for tilts
    that do not show the mounting.
    """
    check_type(robot, Robot, "robot")
    check_type(recording, Recording, "recording")
    if recording.specific_force is None or recording.joints != robot.n:
        raise ArgumentError(f"{recording.source}: expected {robot.n} joints, and readings as specific_force")
    sigma = as_number(noise, "noise")
    if not 0.0 < sigma < np.inf:
        raise ArgumentError(f"noise is {shown(noise)}; expected more than 0 m/s²")
    return _Fit(robot, recording, sigma).run()


class _Fit:
    """The unknowns and the rows of one fit: torques in units of their joint's error, and |s - b| in units of noise."""

    def __init__(self, robot: Robot, recording: Recording, noise: float) -> None:
        self.recording, self.noise = recording, noise
        self.readings = np.asarray(recording.specific_force)
        self.base = base_parameters(robot, Model(), "tilted")
        self.Y = [robot.gravity_regressor_batch(recording.q, -axis) for axis in np.eye(3)]
        self.prior = Model().prior(robot)
        self.sigma = np.maximum(np.sqrt((recording.tau**2).mean(axis=0)), 1e-12)
        self.R, self.b = self._start(), np.zeros(3)
        self.p = self._moments()

    def _start(self) -> FloatArray:
        """R from the torques of the robot's own masses: f = A s + c by least squares, A made a rotation."""
        by_axis = [(part @ self.prior) / self.sigma for part in self.Y]
        samples = np.column_stack([self.readings, np.ones(len(self.readings))])
        columns = [(axis[:, :, np.newaxis] * samples[:, np.newaxis, :]).reshape(-1, 4) for axis in by_axis]
        found = np.linalg.lstsq(np.hstack(columns), (self.recording.tau / self.sigma).ravel(), rcond=1e-6)[0]
        A = found.reshape(3, 4)[:, :3]
        U, _, Vt = np.linalg.svd(A)
        R: FloatArray = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
        return R

    def force(self) -> FloatArray:
        return np.asarray((self.readings - self.b) @ self.R.T)

    def _regressor(self, force: FloatArray) -> FloatArray:
        """Rows for p at these forces, (N, n, rank)."""
        whole = sum(force[:, axis, np.newaxis, np.newaxis] * self.Y[axis] for axis in range(3))
        return np.asarray(whole)[:, :, self.base.chosen]

    def _moments(self) -> FloatArray:
        rows = (self._regressor(self.force()) / self.sigma[:, np.newaxis]).reshape(-1, self.base.rank)
        found: FloatArray = np.linalg.lstsq(rows, (self.recording.tau / self.sigma).ravel())[0]
        return found

    def errors(self) -> FloatArray:
        """Torque errors, (N, n)."""
        return np.asarray(self.recording.tau - self._regressor(self.force()) @ self.p)

    def rows(self) -> tuple[FloatArray, FloatArray]:
        """Jacobian by (rotation, bias, p) and errors, torques first, all in their own units of noise."""
        force = self.force()
        by_force = np.stack([part[:, :, self.base.chosen] @ self.p for part in self.Y], axis=2)  # (N, n, 3)
        turned = np.cross(np.eye(3)[np.newaxis], force[:, np.newaxis])  # d f = w x f: row k is e_k x f
        by_turn = np.einsum("inj,ikj->ink", by_force, turned)
        torque = np.concatenate([by_turn, -by_force @ self.R, self._regressor(force)], axis=2)
        weighted = (torque / self.sigma[:, np.newaxis]).reshape(-1, torque.shape[2])
        lengths = np.linalg.norm(force, axis=1)
        length = np.zeros((len(force), torque.shape[2]))
        length[:, 3:6] = -(force / lengths[:, np.newaxis]) @ self.R
        errors = [(self.errors() / self.sigma).ravel(), (STANDARD_GRAVITY - lengths) / self.noise]
        return np.vstack([weighted, length / self.noise]), np.concatenate(errors)

    def run(self) -> MountingFit:
        for round_ in range(ROUNDS):
            jacobian, errors = self.rows()
            step = np.asarray(np.linalg.lstsq(jacobian, errors, rcond=1e-10)[0], dtype=np.float64)
            self._move(step)
            if round_ % 4 == 3:
                self.sigma = np.maximum(np.sqrt((self.errors() ** 2).mean(axis=0)), 1e-9 * self.sigma + 1e-15)
            if round_ > 8 and np.abs(step[:6]).max() < SETTLED:
                break
        return self._result(self.rows()[0])

    def _move(self, step: FloatArray) -> None:
        """Turn and shift by a step, no more than a third of a radian at a time."""
        angle = float(np.linalg.norm(step[:3]))
        share = min(1.0, 0.3 / angle) if angle > 0.0 else 1.0
        self.R = _rotation(share * step[:3]) @ self.R
        self.b = self.b + share * step[3:6]
        self.p = self.p + share * step[6:]

    def _result(self, jacobian: FloatArray) -> MountingFit:
        sd = _errors(jacobian)
        if not sd[:3].max() < LOST:
            what = f"the mounting is open by {min(np.degrees(sd[:3].max()), 180.0):.0f} degrees: the base hardly tilts"
            raise CalibrationError(f"{what}; {REMEDY}")
        condition = _condition(jacobian)
        lengths = np.linalg.norm(self.readings - self.b, axis=1)
        return MountingFit(
            rotation=self.R,
            bias=self.b,
            rotation_sd=sd[:3],
            bias_sd=sd[3:6],
            base=self.base,
            values=self.p,
            rms=np.sqrt((self.errors() ** 2).mean(axis=0)),
            condition=condition,
            scale=float(lengths.mean() / STANDARD_GRAVITY),
            warnings=tuple(_warnings(self.readings, condition)),
        )


def _errors(jacobian: FloatArray) -> FloatArray:
    """Standard errors of all unknowns under rows of unit noise; infinite where the rows show nothing."""
    lengths = np.linalg.norm(jacobian, axis=0)
    scale = np.where(lengths > 0.0, lengths, 1.0)
    _, sizes, Vt = np.linalg.svd(jacobian / scale, full_matrices=False)
    with np.errstate(divide="ignore"):
        spread = np.where(sizes > 1e-12 * sizes[0], 1.0 / sizes, np.inf)
    return np.asarray(np.linalg.norm(spread[:, np.newaxis] * Vt, axis=0) / scale)


def _condition(jacobian: FloatArray) -> float:
    """Condition of rotation and bias, columns of one length, after all that the moments can explain."""
    Q = np.linalg.qr(jacobian[:, 6:])[0]
    left = jacobian[:, :6] - Q @ (Q.T @ jacobian[:, :6])
    lengths = np.linalg.norm(left, axis=0)
    sizes = np.linalg.svd(left / np.where(lengths > 0.0, lengths, 1.0), compute_uv=False)
    return float(sizes[0] / sizes[-1]) if sizes[-1] > 0.0 else np.inf


def _warnings(readings: FloatArray, condition: float) -> list[str]:
    said = []
    spread = np.linalg.svd(readings - readings.mean(axis=0), compute_uv=False)
    if spread[1] < ONE_AXIS * spread[0]:
        said.append("the base tilts about one axis only: tilt it about a second one, as far")
    if condition > WEAK_CONDITION:
        said.append(
            f"the condition is {condition:.0f}, more than {WEAK_CONDITION:.0f}: tilt further, and about both axes"
        )
    return said


def _rotation(turn: FloatArray) -> FloatArray:
    """The rotation by a vector (Rodrigues)."""
    angle = float(np.linalg.norm(turn))
    if angle < 1e-14:
        return np.eye(3)
    x, y, z = turn / angle
    S = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * S + (1.0 - np.cos(angle)) * S @ S)
