"""How the base's accelerometer is turned, its bias, and the arm's first moments, from torques on a tilted base.

In rest tau = (Σ_k f_k Y_k(q) + E(q)) p with the specific force f = R (s - b) of the reading s, Y_k the regressor of a
unit force along axis k, and E that of springs and cables: linear in p, and in R and b but for the rotation. Gauss and
Newton go over the rotation, the bias and p at once. The scale of the sensor cannot be found this way (twice f and half
of p are the same torques); it is fixed by |f| = g. A level base shows two of the three angles and no bias, tilts about
one axis show them badly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_number, as_texts, check_type
from ravengc._core import STANDARD_GRAVITY
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.identify.base_parameters import BaseParameters, base_parameters
from ravengc.identify.model import Model
from ravengc.identify.recording import FloatArray, Recording
from ravengc.identify.weakness import WEAK_CONDITION, about_one_axis
from ravengc.messages import listed, shown
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["MountingFit", "mounting"]

SOUGHT = ("rotation", "bias")
REMEDY = "tilt it by 10 degrees or more about two axes, a dozen poses of the arm at each"
LOST = 0.1
"""rad; a standard error of the rotation from which on nothing has been found."""
ROUNDS = 100
SETTLED = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class MountingFit:
    """``rotation`` R (base axes from sensor axes) and ``bias`` b (3,) m/s²: f = R (s - b); ``values`` (b,) of ``base``.

    With the recording as :meth:`corrected` an identification of the same model has these values, held-out errors and a
    robot file.

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

    def corrected(self, recording: Recording) -> Recording:
        """The recording with its readings made the specific force in base axes, R (s - b), its gyroscope's R ω."""
        check_type(recording, Recording, "recording")
        if recording.specific_force is None:
            raise ArgumentError(f"{recording.source} has no readings as specific_force")
        turned: dict[str, Any] = {
            name: values @ self.rotation.T
            for name in ("angular_velocity", "angular_acceleration")
            if (values := getattr(recording, name)) is not None
        }
        force = (recording.specific_force - self.bias) @ self.rotation.T
        return replace(recording, specific_force=force, **turned)


def mounting(
    robot: Robot,
    recording: Recording,
    *,
    model: Model | None = None,
    find: Sequence[str] = SOUGHT,
    noise: float = 0.02,
) -> MountingFit:
    """Fit mounting, bias and first moments to poses at rest, with the sensor's own readings as ``specific_force``.

    ``model`` (default: the masses alone) may have springs and cables too. ``noise`` (m/s²) is that of a reading; with
    it |s - b| = g counts beside the torques. The search starts from the masses that the robot has. Raises ArgumentError
    for a recording without readings, and when something else is to be found, and CalibrationError for tilts that do
    not show the mounting.
    """
    check_type(robot, Robot, "robot")
    check_type(recording, Recording, "recording")
    sought = Model() if model is None else model
    check_type(sought, Model, "model")
    if sought.kind == "dynamics":
        raise ArgumentError("model is one of dynamics; poses at rest show gravity, springs and cables")
    _check_find(find)
    if recording.specific_force is None or recording.joints != robot.n:
        raise ArgumentError(f"{recording.source}: expected {robot.n} joints, and readings as specific_force")
    if not recording.counts.all():
        raise ArgumentError(f"{recording.source}: not every torque counts; a mounting needs those of all joints")
    sigma = as_number(noise, "noise")
    if not 0.0 < sigma < np.inf:
        raise ArgumentError(f"noise is {shown(noise)}; expected more than 0 m/s²")
    return _Fit(robot, recording, sought, sigma).run()


def _check_find(find: object) -> None:
    words = as_texts(find, "find")
    if "scale" in words:
        raise ArgumentError(
            "find has 'scale', which torques do not show: twice the force and half of all masses are the same torques."
            " Turn every axis of the sensor once up and once down, at rest, for calibration.fit_six_positions"
        )
    if sorted(words) != sorted(SOUGHT):
        raise ArgumentError(f"find is {shown(find)}; expected {listed(SOUGHT)}, which are found together")


class _Fit:
    """The unknowns and the rows of one fit: torques in units of their joint's error, and |s - b| in units of noise."""

    def __init__(self, robot: Robot, recording: Recording, model: Model, noise: float) -> None:
        self.readings, self.noise = np.asarray(recording.specific_force), noise
        self.base = base_parameters(robot, model, "tilted", at_rest=recording.qd is None)
        of_links = len(model.link_columns(robot.spec))
        self.Y = [_under(robot, recording, model, axis) for axis in np.eye(3)]
        self.E = self.Y[0].copy()
        self.E[:, :, :of_links] = 0.0
        for part in self.Y:
            part[:, :, of_links:] = 0.0
        self.prior = model.prior(robot)
        self.tau = recording.tau - model.known(robot, recording)
        self.sigma = np.maximum(np.sqrt((self.tau**2).mean(axis=0)), 1e-12)
        self.R, self.b = self._start(), np.zeros(3)
        self.p = self._moments()

    def _start(self) -> FloatArray:
        """R from the torques of the robot's own masses: f = A s + c by least squares, A made a rotation."""
        by_axis = [(part @ self.prior) / self.sigma for part in self.Y]
        samples = np.column_stack([self.readings, np.ones(len(self.readings))])
        columns = [(axis[:, :, np.newaxis] * samples[:, np.newaxis, :]).reshape(-1, 4) for axis in by_axis]
        fixed = (self.E / self.sigma[:, np.newaxis]).reshape(-1, self.E.shape[2])
        found = np.linalg.lstsq(np.hstack([*columns, fixed]), (self.tau / self.sigma).ravel(), rcond=1e-6)[0]
        A = found[:12].reshape(3, 4)[:, :3]
        U, _, Vt = np.linalg.svd(A)
        R: FloatArray = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
        return R

    def force(self) -> FloatArray:
        return np.asarray((self.readings - self.b) @ self.R.T)

    def _regressor(self, force: FloatArray) -> FloatArray:
        """Rows for p at these forces, (N, n, rank)."""
        whole = sum(force[:, axis, np.newaxis, np.newaxis] * self.Y[axis] for axis in range(3))
        return np.asarray(whole + self.E)[:, :, self.base.chosen]

    def _moments(self) -> FloatArray:
        rows = (self._regressor(self.force()) / self.sigma[:, np.newaxis]).reshape(-1, self.base.rank)
        found: FloatArray = np.linalg.lstsq(rows, (self.tau / self.sigma).ravel())[0]
        return found

    def errors(self) -> FloatArray:
        """Torque errors, (N, n)."""
        return np.asarray(self.tau - self._regressor(self.force()) @ self.p)

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


def _under(robot: Robot, recording: Recording, model: Model, force: FloatArray) -> FloatArray:
    """The model's columns (N, n, p) at the recorded poses under one specific force."""
    there = replace(recording, specific_force=np.tile(force, (recording.samples, 1)), angular_velocity=None,
                    angular_acceleration=None, cutoff_hz=None)  # fmt: skip
    return model.regressor(robot, there).reshape(recording.samples, robot.n, -1)


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
    if about_one_axis(readings):
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
