"""From a log file to a recording that may be identified from: in SI, at the joints, in the robot's order, and checked.

Rows that hold no number, that repeat a stamp, or that repeat the readings of the row before are left out and counted;
what only a wrong unit, a wrong side of the gears or a turned sign explains is an error that names it.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ravengc._convert import as_texts, as_vector, check_type
from ravengc._core import STANDARD_GRAVITY
from ravengc.coordinates import sliding
from ravengc.errors import ConfigError
from ravengc.identify.recording import Recording, from_motion
from ravengc.identify.suspicions import (
    check_force,
    check_positions,
    check_torques,
    check_velocities,
    still_torques,
)
from ravengc.identify.turning import checked_turning
from ravengc.inertial_units import ACCELERATION_UNITS, RATE_UNITS
from ravengc.messages import did_you_mean, listed, shown
from ravengc.recordings import fit_to_robot, joint_side, read_recording
from ravengc.robot import Robot

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import numpy.typing as npt

    from ravengc.recordings import Recording as Motion
    from ravengc.recordings.recording import FloatArray

__all__ = ["UNITS", "counting", "read_log"]

Word = Literal[
    "rad", "deg", "m", "mm", "Nm", "mNm", "m/s^2", "g", "mg", "cm/s^2", "rad/s", "mrad/s", "deg/s", "joint", "motor"
]
UNITS: tuple[tuple[str, ...], ...] = (
    ("rad", "deg"),
    ("m", "mm"),
    ("Nm", "mNm"),
    tuple(ACCELERATION_UNITS),
    tuple(RATE_UNITS),
    ("joint", "motor"),
)
"""What may be said of a file; the first of each line is taken for granted, and checked."""
REPEATED = "row that repeats the readings of the one before"
HARDLY = np.radians(0.5)
"""A base whose attitude is so close to its mean (RMS) counts as standing still there."""
NEEDED = "expected a column for every joint, tau1 tau2 ... or NAME_effort: torques at the joints, or current x constant"


def read_log(
    robot: Robot,
    source: str | Path,
    units: Collection[Word] = (),
    *,
    topic: str | None = None,
    joints: Sequence[str] | None = None,
    rate_hz: float | None = None,
    gravity: npt.ArrayLike | None = None,
    counted: Sequence[str] | None = None,
    sensor_axes: bool = False,
    strict: bool = False,
) -> Recording:
    """The recording in a file (CSV, npz, bag), ready for :func:`~ravengc.identify.identify`.

    ``units`` says what the file is in where that is not SI at the joints, by words of :data:`UNITS`. ``gravity`` (3,)
    m/s², base axes, is the field during the whole log, for a base that stood still and had no sensor; ``counted`` names
    the joints whose torques count, all unless given; ``sensor_axes`` says that the columns of gravity are in the axes
    of a sensor whose mounting is sought. The other arguments are those of
    :func:`~ravengc.recordings.read_recording`. Raises ConfigError for missing torques and for numbers that only
    another unit explains, and the errors of reading.
    """
    check_type(robot, Robot, "robot")
    check_type(sensor_axes, bool, "sensor_axes")
    check_type(strict, bool, "strict")
    said = _said(units)
    known = (
        as_texts(joints, "joints") if joints is not None else (_motors(robot) if "motor" in said else robot.joint_names)
    )
    motion = read_recording(source, topic=topic, joints=known, rate_hz=rate_hz, strict=strict)
    if motion.tau is None:
        raise ConfigError(f"{motion.source}: no torques; {NEEDED}")
    motion = _with_field(_in_si(motion, said), gravity)
    notes = list(check_force(motion, said))
    motion, turning = checked_turning(motion)
    notes += turning
    motion = _without_repeats(_at_joints(motion, robot, said, joints))
    notes += check_positions(motion, robot, said)
    check_velocities(motion, robot)
    recording = counting(from_motion(motion, robot=robot.name).with_notes(*notes), robot, counted)
    if sensor_axes:
        return recording
    check_torques(recording, robot, said)
    recording = recording.with_notes(*still_torques(recording, robot))
    return _standing(recording, robot)


def counting(recording: Recording, robot: Robot, counted: Sequence[str] | None) -> Recording:
    """The recording in which the torques of the named joints alone count, or all; ConfigError for an unknown name."""
    if counted is None:
        return recording
    names = robot.spec.coordinate_names
    for name in as_texts(counted, "counted"):
        if name not in names:
            near = did_you_mean(name, names)
            raise ConfigError(f"{robot.name} has no joint {shown(name)}{near}; it has {listed(names)}")
    return recording.counting([names.index(name) for name in counted])


def _said(units: Collection[str]) -> tuple[str, ...]:
    check_type(units, Collection, "units")
    words = as_texts(units, "units")
    known = [word for line in UNITS for word in line]
    for word in words:
        if word not in known:
            raise ConfigError(f"unit {shown(word)} is unknown: choose of {listed(known)}{did_you_mean(word, known)}")
    for line in UNITS:
        if len(both := [word for word in words if word in line]) > 1:
            raise ConfigError(f"units {listed(both)} exclude each other: say one of them")
    return words


def _motors(robot: Robot) -> tuple[str, ...]:
    return robot.spec.transmission.motors if robot.spec.transmission else robot.joint_names


def _in_si(motion: Motion, said: tuple[str, ...]) -> Motion:
    """What the base did in SI; torques and positions are converted where it is known what turns and what slides."""
    factors = {"gravity": ACCELERATION_UNITS, "angular_velocity": RATE_UNITS}
    scaled: dict[str, Any] = {
        name: values * next((factors[name][word] for word in said if word in factors[name]), 1.0)
        for name, values in motion.base_arrays().items()
    }
    return replace(motion, **scaled)


def _with_field(motion: Motion, gravity: npt.ArrayLike | None) -> Motion:
    """The motion with the field of a base that stood still; its turning counts only beside a field of its own."""
    if gravity is not None and motion.gravity is not None:
        raise ConfigError(f"{motion.source}: has gravity columns of its own; a tilt of the base would contradict them")
    if motion.angular_velocity is not None and motion.gravity is None:
        why = "the base stood still" if gravity is not None else "no columns say where gravity points meanwhile"
        motion = replace(motion, angular_velocity=None).with_notes(f"angular velocity of the base not used: {why}")
    if gravity is None:
        return motion
    return replace(motion, gravity=np.tile(as_vector(gravity, "gravity", 3), (motion.samples, 1)))


def _at_joints(motion: Motion, robot: Robot, said: tuple[str, ...], joints: Sequence[str] | None) -> Motion:
    """The motion at the joints, in the robot's order, SI."""
    if "motor" in said:
        if {"deg", "mm"} & set(said):
            raise ConfigError("units: motor positions are in rad; convert the file, or leave out deg and mm")
        return _torques_in_si(joint_side(motion, robot, joints=joints), robot, said)
    fitted = fit_to_robot(
        motion,
        robot.spec,
        joints=joints,
        angle_unit="deg" if "deg" in said else "rad",
        length_unit="mm" if "mm" in said else "m",
    )
    return _torques_in_si(fitted, robot, said)


def _torques_in_si(motion: Motion, robot: Robot, said: tuple[str, ...]) -> Motion:
    if "mNm" not in said or motion.tau is None:
        return motion
    return replace(motion, tau=motion.tau * np.where(sliding(robot.spec), 1.0, 1e-3))


def _without_repeats(motion: Motion) -> Motion:
    """Without the rows in which nothing but the stamp is new: the recorder was faster than the robot."""
    arrays = motion.arrays()
    if motion.samples < 2:
        return motion
    same = np.all([(np.diff(values, axis=0) == 0.0).all(axis=1) for values in arrays.values()], axis=0)
    fresh = np.concatenate([[True], ~same])
    if fresh.all():
        return motion
    kept: dict[str, Any] = {name: values[fresh] for name, values in {**arrays, **motion.base_arrays()}.items()}
    return replace(motion, t=motion.t[fresh], skipped={**motion.skipped, REPEATED: int(np.count_nonzero(same))}, **kept)


def _standing(recording: Recording, robot: Robot) -> Recording:
    """The recording of a base that hardly tilts, with its mean attitude throughout: noise is no tilt.

    Gravity that is along the axis of joint 1 to within the sensor's accuracy counts as along it, where two of the first
    moments do not show; else their values would be made of noise.
    """
    force = recording.specific_force
    if force is None:
        return recording
    mean = force.mean(axis=0)
    off = float(np.sqrt((_angles(force, mean) ** 2).mean()))
    if not 0.0 < off < HARDLY or recording.angular_velocity is not None:
        return recording
    axis = _first_axis(robot)
    along = axis is not None and abs(float(axis @ mean)) > np.cos(2.0 * HARDLY) * float(np.linalg.norm(mean))
    direction = mean if axis is None or not along else axis * np.sign(axis @ mean)
    still = np.tile(STANDARD_GRAVITY * direction / np.linalg.norm(direction), (len(force), 1))
    where = "there, with gravity along the axis of joint 1" if along else "there"
    note = f"the base stays within {np.degrees(off):.2f} deg (RMS) of one attitude: taken as standing {where}"
    return replace(recording, specific_force=still).with_notes(note)


def _first_axis(robot: Robot) -> FloatArray | None:
    """The axis of joint 1 in base axes, if it turns and nothing else turns with it."""
    axis = robot.jacobian(np.zeros(robot.n), frame=robot.spec.moving_links[0].name)[3:, 0]
    length = float(np.linalg.norm(axis))
    return axis / length if length > 0.5 else None


def _angles(force: FloatArray, mean: FloatArray) -> FloatArray:
    """Angle of every force to the mean, rad."""
    across = np.linalg.norm(np.cross(force, mean), axis=1)
    return np.asarray(np.arctan2(across, force @ mean))
