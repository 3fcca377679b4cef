"""Torques computed along a recorded motion, beside those that were measured.

A model is only as good as its torque on a real arm: ``replay`` takes the measured positions, computes what gravity
alone (or the full inverse dynamics) asks of every joint, with the robot's disturbance elements where it has any, and
says how far the measured torques are from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_count, as_double, as_number, check_choice, check_type
from ravengc.coordinates import sliding
from ravengc.differentiation import differentiate, window_for
from ravengc.errors import ConfigError
from ravengc.recordings.recording import Recording
from ravengc.robot import Robot

if TYPE_CHECKING:
    import ravengc

__all__ = ["DEFAULT_SPAN", "JointError", "Model", "Replay", "replay"]

FloatArray = npt.NDArray[np.float64]
Model = Literal["gravity", "full"]
MODELS = ("gravity", "full")
LEVEL = (0.0, 0.0, -9.80665)
DEFAULT_SPAN = 0.25
LONG_GAP = 5.0
OPPOSITE = -0.7
"""Correlation from which on torques have the wrong sign."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JointError:
    """How far one joint's measured torque is from the predicted one (N·m; N for a sliding joint).

    ``relative`` is ‖tau - tau_hat‖ / ‖tau‖ over all samples, ``None`` where nothing was measured but zero.
    """

    name: str
    unit: str
    rms_measured: float
    rms_error: float
    max_error: float
    relative: float | None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Replay:
    """Torques along a recording: ``predicted`` (samples, n), in the robot's order, N·m or N.

    ``recording`` is in the robot's order too; ``gravity`` is the field in base axes (m/s²) that was used, (3,) for all
    samples or (samples, 3).
    """

    robot: str
    recording: Recording
    model: Model
    gravity: FloatArray
    names: tuple[str, ...]
    units: tuple[str, ...]
    predicted: FloatArray
    notes: tuple[str, ...] = ()

    @property
    def residual(self) -> FloatArray | None:
        """Measured minus predicted torque (samples, n), or ``None`` where no torque was recorded."""
        return None if self.recording.tau is None else self.recording.tau - self.predicted

    @property
    def joint_errors(self) -> tuple[JointError, ...]:
        """The error of every joint; empty where no torque was recorded."""
        measured, residual = self.recording.tau, self.residual
        if measured is None or residual is None:
            return ()
        columns = zip(self.names, self.units, measured.T, residual.T, strict=True)
        return tuple(_joint_error(*column) for column in columns)

    @property
    def overall_error(self) -> float | None:
        """‖tau - tau_hat‖ / ‖tau‖ over all joints and samples, or ``None`` without measured torques."""
        residual = self.residual
        return None if residual is None else _relative(residual, self.recording.tau)


def replay(
    robot: ravengc.Robot,
    recording: Recording,
    *,
    model: Model = "gravity",
    gravity: npt.ArrayLike = LEVEL,
    span: float = DEFAULT_SPAN,
    threads: int = 1,
) -> Replay:
    """Torques of ``robot`` along ``recording``, whose columns are in the robot's order (see ``fit_to_robot``).

    ``model`` is ``"gravity"`` (positions alone) or ``"full"``: inverse dynamics on a base at rest. Velocities and
    accelerations that were not recorded are derived from what was, by parabolas fitted over ``span`` seconds
    (:mod:`ravengc.differentiation`). The robot's disturbance elements (cables, springs, friction) are added: at rest
    to gravity, with the velocities to the rest. ``gravity`` is the field in base axes (m/s²), one for all samples or
    one for each. Raises ArgumentError for arguments of another kind, ConfigError for a recording of another number of
    joints or one that is too short to differentiate.
    """
    as_count(threads, "threads", 0)
    _check(robot, recording, model, as_number(span, "span"))
    field = np.array(as_double(gravity, "gravity"))
    if field.shape not in {(3,), (recording.samples, 3)}:
        raise ConfigError(f"gravity has shape {field.shape}; expected (3,) or ({recording.samples}, 3)")
    predicted, notes = _predicted(robot, recording, model, field, span, threads)
    notes = (*notes, *_opposite(recording.tau, predicted))
    slides = sliding(robot.spec)
    return Replay(
        robot=robot.name,
        recording=recording,
        model=model,
        gravity=field,
        names=robot.joint_names,
        units=tuple("N" if slide else "N·m" for slide in slides),
        predicted=predicted,
        notes=notes,
    )


def _predicted(
    robot: ravengc.Robot, recording: Recording, model: Model, field: FloatArray, span: float, threads: int
) -> tuple[FloatArray, tuple[str, ...]]:
    """Torques (samples, n) of masses and disturbance elements, and notes on what they stand on."""
    qd: FloatArray | None = None
    notes: tuple[str, ...] = ()
    if model == "gravity":
        predicted = robot.gravity_torque_batch(recording.q, field, threads=threads)
    else:
        qd, qdd, notes = _motion(recording, span)
        base = _base_at_rest(field, recording.samples)
        predicted = robot.inverse_dynamics_batch(recording.q, qd, qdd, base, threads=threads)
    if elements := len(robot.spec.disturbances):
        predicted = predicted + robot.disturbance_torque_batch(recording.q, qd, threads=threads)
        at_rest = ", at rest" if qd is None else ""
        notes = (*notes, f"with the robot's disturbance elements ({elements}{at_rest})")
    return predicted, notes


def _opposite(measured: FloatArray | None, predicted: FloatArray) -> tuple[str, ...]:
    """A note where the measured torques are the predicted ones the other way round."""
    size = 0.0 if measured is None else float(np.linalg.norm(measured) * np.linalg.norm(predicted))
    correlation = 0.0 if measured is None or not 0.0 < size < np.inf else float((measured * predicted).sum()) / size
    if not correlation <= OPPOSITE:
        return ()
    said = f"the measured torques are opposite to the predicted ones (correlation {correlation:.2f})"
    return (f"{said}: is gravity upside down, or are they what the drives feel?",)


def _check(robot: ravengc.Robot, recording: Recording, model: Model, span: float) -> None:
    check_type(robot, Robot, "robot")
    check_type(recording, Recording, "recording")
    check_choice(model, MODELS, "model")
    if not (np.isfinite(span) and span >= 0.0):
        raise ConfigError(f"span of {span} s for derivatives; expected zero (three samples) or more")
    if recording.joints != robot.n:
        raise ConfigError(f"{recording.source} has {recording.joints} joints, but {robot.name} has {robot.n}")


def _base_at_rest(gravity: FloatArray, samples: int) -> FloatArray:
    """Specific force f = -g, and no rotation, for every sample: (samples, 9)."""
    base = np.zeros((samples, 9))
    base[:, :3] = -gravity
    return base


def _motion(recording: Recording, span: float) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Velocities, accelerations, and notes on where they come from."""
    if recording.qd is not None and recording.qdd is not None:
        return recording.qd, recording.qdd, ()
    if recording.samples < 3:
        raise ConfigError(f"{recording.source}: {recording.samples} samples; accelerations need at least 3")
    t = recording.t
    window = min(window_for(t, span), recording.samples - (recording.samples + 1) % 2)
    velocities_known = recording.qd is not None
    qd = recording.qd if recording.qd is not None else differentiate(t, recording.q, window)
    qdd = recording.qdd if recording.qdd is not None else differentiate(t, qd, window)
    derived = "accelerations" if velocities_known else "velocities and accelerations"
    return qd, qdd, (f"{derived} derived over {window} samples", *_gaps(t))


def _gaps(t: FloatArray) -> tuple[str, ...]:
    """A note on gaps in the stamps, across which a derivative is only rough."""
    steps = np.diff(t)
    longest = int(steps.argmax())
    if steps[longest] <= LONG_GAP * np.median(steps):
        return ()
    return (f"gap of {steps[longest]:.3g} s after t = {t[longest]:.6g} s: derivatives are rough there",)


def _joint_error(name: str, unit: str, measured: FloatArray, residual: FloatArray) -> JointError:
    return JointError(
        name=name,
        unit=unit,
        rms_measured=_rms(measured),
        rms_error=_rms(residual),
        max_error=float(np.abs(residual).max()),
        relative=_relative(residual, measured),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _relative(residual: FloatArray, measured: FloatArray | None) -> float | None:
    size = 0.0 if measured is None else float(np.linalg.norm(measured))
    return float(np.linalg.norm(residual)) / size if size > 0.0 else None
