"""Fit a recording to a robot: its joints in the robot's order, in rad and m."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_texts, check_choice, check_type
from ravengc.coordinates import sliding
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed
from ravengc.recordings.recording import Recording
from ravengc.robot import Robot
from ravengc.spec import RobotSpec

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.spec import JointLimits

__all__ = ["AngleUnit", "LengthUnit", "fit_to_robot", "joint_side"]

AngleUnit = Literal["auto", "rad", "deg"]
LengthUnit = Literal["auto", "m", "mm"]
ANGLE_UNITS = ("auto", "rad", "deg")
LENGTH_UNITS = ("auto", "m", "mm")

FARTHEST_ANGLE = 4.0 * math.pi
FARTHEST_SLIDE = 10.0


def fit_to_robot(
    recording: Recording,
    robot: RobotSpec,
    *,
    joints: Sequence[str] | None = None,
    angle_unit: AngleUnit = "auto",
    length_unit: LengthUnit = "auto",
) -> Recording:
    """The recording with one column per coordinate of ``robot``, in its order, in SI.

    ``joints`` names the recording's columns to take, in the robot's order (numbers from 1 where it has no names).
    Otherwise columns follow the robot's joint names if the recording knows them, else they are taken as they stand.
    ``"auto"`` takes rad and m but refuses positions that only degrees or millimetres explain. Torques are never
    converted. Raises ConfigError for joints that do not fit and for suspect units.
    """
    check_type(recording, Recording, "recording")
    check_type(robot, RobotSpec, "robot")
    check_choice(angle_unit, ANGLE_UNITS, "angle_unit")
    check_choice(length_unit, LENGTH_UNITS, "length_unit")
    chosen = _columns(recording, robot.name, robot.coordinate_names, joints)
    scale = _scales(sliding(robot), angle_unit, length_unit)
    scaled: dict[str, Any] = {name: values * scale for name, values in chosen.arrays().items() if name != "tau"}
    fitted = replace(chosen, **scaled) if (scale != 1.0).any() else chosen
    _suspect_units(fitted, robot, angle_unit, length_unit)
    return fitted


def joint_side(recording: Recording, robot: Robot, *, joints: Sequence[str] | None = None) -> Recording:
    """The recording of motor positions and torques, seen at the joints: q = C m + c0, tau = C⁻ᵀ tau_motor.

    Columns are the motors of the robot's transmission, by name or in order, in SI. Raises ConfigError for a robot
    without a transmission and for columns that do not fit.
    """
    check_type(recording, Recording, "recording")
    check_type(robot, Robot, "robot")
    offset = robot.joint_positions(np.zeros(robot.n))
    transmission = robot.spec.transmission
    motors = transmission.motors if transmission else ()
    chosen = _columns(recording, f"the transmission of {robot.name}", motors, joints)
    joint_per_motor = np.column_stack([robot.joint_positions(unit) - offset for unit in np.eye(robot.n)])
    moved: dict[str, Any] = {
        name: values @ joint_per_motor.T for name, values in chosen.arrays().items() if name != "tau"
    }
    moved["q"] = moved["q"] + offset
    if chosen.tau is not None:
        torque_per_motor = np.column_stack([robot.joint_torque(unit) for unit in np.eye(robot.n)])
        moved["tau"] = chosen.tau @ torque_per_motor.T
    note = "measured at the motors; taken to the joints through the robot's transmission"
    return replace(chosen, names=robot.spec.coordinate_names, **moved).with_notes(note)


def _columns(recording: Recording, whose: str, wanted: Sequence[str], joints: Sequence[str] | None) -> Recording:
    if joints is not None and (chosen := as_texts(joints, "joints")):
        return recording.select(_named(recording, chosen, whose, wanted))
    return _matched(recording, whose, wanted)


def _named(recording: Recording, joints: Sequence[str], whose: str, wanted: Sequence[str]) -> list[int]:
    if len(joints) != len(wanted):
        raise ConfigError(f"{len(joints)} joints chosen, but {whose} has {len(wanted)}: {listed(wanted)}")
    places = {name: place for place, name in enumerate(recording.columns)}
    if len(set(joints)) != len(joints):
        raise ConfigError(f"joints {listed(joints)}: one is chosen twice; every joint has a column of its own")
    for name in joints:
        if name not in places:
            near = did_you_mean(name, places)
            raise ConfigError(f"{recording.source} has no joint '{name}'{near}; it has {listed(places)}")
    return [places[name] for name in joints]


def _matched(recording: Recording, whose: str, wanted: Sequence[str]) -> Recording:
    places = {name.lower(): place for place, name in enumerate(recording.names)}
    if all(name.lower() in places for name in wanted):
        left_out = sorted(set(places) - {name.lower() for name in wanted})
        notes = [f"joints not used: {', '.join(left_out)}"] if left_out else []
        return recording.select([places[name.lower()] for name in wanted]).with_notes(*notes)
    if recording.joints != len(wanted):
        have = listed(recording.names) if recording.names else "without names"
        raise ConfigError(
            f"{recording.source} has {recording.joints} joints ({have}), but {whose} has {len(wanted)}"
            f" ({listed(wanted)}); choose the columns in the robot's order with --joints"
        )
    known = [name for name in wanted if name.lower() in places]
    if known:
        missing = listed(name for name in wanted if name.lower() not in places)
        raise ConfigError(
            f"{recording.source} names {listed(known)} as {whose} does, but not {missing}; it has"
            f" {listed(recording.names)}; choose the columns in the robot's order with --joints"
        )
    if not recording.names:
        return recording
    pairs = ", ".join(f"{theirs} = {ours}" for theirs, ours in zip(recording.names, wanted, strict=True))
    return recording.with_notes(f"joint names differ from the robot's; taken in the recording's order: {pairs}")


def _scales(slides: npt.NDArray[np.bool_], angle_unit: AngleUnit, length_unit: LengthUnit) -> npt.NDArray[np.float64]:
    angle = math.pi / 180.0 if angle_unit == "deg" else 1.0
    length = 1e-3 if length_unit == "mm" else 1.0
    return np.where(slides, length, angle)


def _suspect_units(recording: Recording, robot: RobotSpec, angle_unit: AngleUnit, length_unit: LengthUnit) -> None:
    rows = zip(robot.coordinate_names, sliding(robot), robot.coordinate_limits, recording.q.T, strict=True)
    for name, slides, limits, values in rows:
        unit, given, farthest = ("m", length_unit, FARTHEST_SLIDE) if slides else ("rad", angle_unit, FARTHEST_ANGLE)
        extreme = float(values[np.abs(values).argmax()])
        if given != "auto" or abs(extreme) <= farthest or _within(limits, extreme):
            continue
        other, option = ("millimetres", "--length-unit mm") if slides else ("degrees", "--angle-unit deg")
        raise ConfigError(
            f"{recording.source}: joint '{name}' reaches {extreme:.4g}, far outside +-{farthest:.4g} {unit};"
            f" if the file is in {other}, say so with {option}; if it is right, say {option.split()[0]} {unit}"
        )


def _within(limits: JointLimits, value: float) -> bool:
    """Whether the robot says itself that it goes there."""
    if limits.lower is None or limits.upper is None:
        return False
    return limits.lower <= value <= limits.upper
