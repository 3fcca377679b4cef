"""The disturbance elements of the robot's own file: known, and taken off the torques, or columns of the model."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.disturbances import PiecewiseCable, Polynomial, SpringBetween
from ravengc.errors import CalibrationError
from ravengc.identify.smoothing import low_passed

if TYPE_CHECKING:
    from ravengc.disturbances import Disturbance
    from ravengc.identify.recording import FloatArray, Recording
    from ravengc.robot import Robot
    from ravengc.spec import RobotSpec

__all__ = ["filled", "filtered", "own_columns", "own_groups", "own_rows", "own_torque"]


def own_columns(robot: RobotSpec) -> tuple[str, ...]:
    """Names of the columns, ``NAME.LABEL``."""
    return tuple(f"{element.name}.{label}" for element in robot.disturbances for label in element.labels)


def own_groups(robot: RobotSpec) -> tuple[str, ...]:
    """For every column the element with which it is left out."""
    return tuple(element.name for element in robot.disturbances for _ in element.labels)


def own_rows(robot: Robot, recording: Recording) -> FloatArray:
    """The columns (N, n, k) at every sample."""
    rows = np.empty((recording.samples, robot.n, len(robot.disturbance_columns)))
    for q, qd, row in zip(recording.q, recording.velocity, rows, strict=True):
        robot.disturbance_regressor(q, qd, row)
    return rows


def own_torque(robot: Robot, recording: Recording) -> FloatArray:
    """The torque (N, n) of the elements as the robot has them, filtered as the recording was."""
    torque = np.zeros_like(recording.q)
    if robot.spec.disturbances:
        for q, qd, row in zip(recording.q, recording.velocity, torque, strict=True):
            robot.disturbance_torque(q, qd, row)
        torque = filtered(torque, recording)
    return torque


def filtered(values: FloatArray, recording: Recording) -> FloatArray:
    """Columns (N, k) through the filter that the torques of the recording went through, if they did."""
    if recording.cutoff_hz is None or recording.samples < 2:
        return values
    return low_passed(values, recording.cutoff_hz * float(np.median(np.diff(recording.stamps))))


def filled(robot: RobotSpec, values: FloatArray, source: str) -> tuple[Disturbance, ...]:
    """The robot's elements with these parameters; CalibrationError for a spring that would push."""
    ends = np.cumsum([0, *(len(element.labels) for element in robot.disturbances)])
    parts = (tuple(values[first:last].tolist()) for first, last in pairwise(ends.tolist()))
    return tuple(_with(element, part, source) for element, part in zip(robot.disturbances, parts, strict=True))


def _with(element: Disturbance, values: tuple[float, ...], source: str) -> Disturbance:
    match element:
        case Polynomial():
            return replace(element, coefficients=values, source=source)
        case PiecewiseCable():
            ends = np.cumsum([0, *(len(piece) for piece in element.pieces)]).tolist()
            return replace(element, pieces=tuple(values[a:b] for a, b in pairwise(ends)), source=source)
        case SpringBetween() if values[0] < 0.0:
            remedy = "identify with estimator='consistent', or leave it out of the robot's file"
            raise CalibrationError(f"spring '{element.name}' would have a stiffness of {values[0]:.4g} N/m; {remedy}")
        case _:
            coefficients: dict[str, Any] = dict(zip(element.labels, values, strict=True))
            return replace(element, source=source, **coefficients)
