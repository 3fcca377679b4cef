"""What a log must not be: in other units than it seems, measured at the motors, or with a sign turned round.

Every check has a margin in which it says nothing: it speaks only where a factor such as 57.3, 1000 or a gear explains
what the numbers are, and says that factor.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ravengc._core import STANDARD_GRAVITY
from ravengc.coordinates import sliding
from ravengc.errors import ConfigError
from ravengc.identify.smoothing import slope

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from ravengc.identify.recording import Recording
    from ravengc.recordings import Recording as Motion
    from ravengc.recordings.recording import FloatArray
    from ravengc.robot import Robot
    from ravengc.spec import JointLimits

__all__ = ["check_force", "check_positions", "check_torques", "check_velocities", "still_torques"]

TURN, THOUSAND = 180.0 / np.pi, 1000.0
LONG = {"deg": "degrees", "mm": "millimetres"}
FARTHEST_ANGLE, FARTHEST_SLIDE = 4.0 * np.pi, 10.0
"""rad and m: beyond them no joint goes whose limits are unknown."""
MOVES = {"deg": 3.0, "mm": 5.0}
"""By less no joint moves all along a recording that is in this unit."""
BEYOND = 0.1
"""Share of its range by which a joint may be beyond its limits before its unit is asked about."""
ALIKE = 0.9
"""Correlation from which on two signals count as one up to a factor."""
FITS = 0.7
"""Correlation of measured with computed torques from which on their ratio means something."""
APART = 20.0
"""Ratio of torques that no wrong mass explains."""
FEWEST, SMALLEST = 5, 1e-6
"""Rows in which a torque that never changes is no chance, and the change (N·m, N) of gravity's own that would show."""
REST_NORM = (0.94 * STANDARD_GRAVITY, 1.06 * STANDARD_GRAVITY)
OFF_SCALE = 0.01
FORCE_UNITS = {1.0: "g", 1000.0: "mg", 100.0 * STANDARD_GRAVITY: "cm/s^2"}


def check_positions(motion: Motion, robot: Robot, units: Collection[str]) -> Iterator[str]:
    """Notes on joints beyond their limits; ConfigError where another unit or the motor side explains that."""
    spec = robot.spec
    rows = zip(spec.coordinate_names, sliding(spec), spec.coordinate_limits, motion.q.T, strict=True)
    _refuse_small_degrees(motion, robot, units)
    beyond = [row for row in rows if _beyond(row[2], row[3], slides=bool(row[1]))]
    for name, slides, limits, values in beyond:
        word, plain, factor = ("mm", "m", THOUSAND) if slides else ("deg", "rad", TURN)
        if word in units or plain in units:
            continue
        fits = np.ptp(values) > MOVES[word] and not _beyond(limits, values / factor, slides=slides)
        causes = [f"in {LONG[word]} (--units {word})"] if fits else []
        causes += ["at the motors (--units motor)"] if "joint" not in units and _at_motors(motion, robot) else []
        if causes:
            raise ConfigError(
                f"{motion.source}: joint '{name}' runs from {values.min():.4g} to {values.max():.4g} {plain}, far"
                f" beyond {_range(limits)}, but is within it if the file is {' or '.join(causes)}; if not,"
                f" --units {plain}"
            )
    for name, _, limits, values in beyond:
        yield (
            f"joint '{name}' runs from {values.min():.4g} to {values.max():.4g}, beyond {_range(limits)}:"
            " is its zero that of the robot's file, and are the columns in its order?"
        )


def _refuse_small_degrees(motion: Motion, robot: Robot, units: Collection[str]) -> None:
    """Raise ConfigError where degrees that were said make next to no motion, and rad one within all limits."""
    turning = [not slides for slides in sliding(robot.spec)]
    limits = [limit for limit, turns in zip(robot.spec.coordinate_limits, turning, strict=True) if turns]
    degrees = np.rad2deg(motion.q[:, turning])
    if "deg" not in units or not limits or motion.samples < 2:
        return
    moved = float(np.median(np.ptp(degrees, axis=0)))
    if 0.2 < moved < 2.0 * np.pi and not any(
        _beyond(limit, values, slides=False) for limit, values in zip(limits, degrees.T, strict=True)
    ):
        raise ConfigError(
            f"{motion.source}: half of the joints move by no more than {moved:.2g} degrees, but all stay within their"
            " limits if the file is in rad: leave out 'deg'"
        )


def _beyond(limits: JointLimits, values: FloatArray, *, slides: bool) -> bool:
    lower, upper = _reach(limits, slides=slides)
    slack = BEYOND * (upper - lower)
    return bool(values.min() < lower - slack or values.max() > upper + slack)


def _reach(limits: JointLimits, *, slides: bool) -> tuple[float, float]:
    """The limits, or how far any joint goes."""
    if limits.lower is None or limits.upper is None:
        return (-FARTHEST_SLIDE, FARTHEST_SLIDE) if slides else (-FARTHEST_ANGLE, FARTHEST_ANGLE)
    return limits.lower, limits.upper


def _range(limits: JointLimits) -> str:
    if limits.lower is None or limits.upper is None:
        return "what joints do"
    return f"its limits [{limits.lower:.4g}, {limits.upper:.4g}]"


def _at_motors(motion: Motion, robot: Robot) -> bool:
    """Whether the positions are within all limits once they are taken through the transmission."""
    if robot.spec.transmission is None:
        return False
    joints = np.array([robot.joint_positions(row) for row in motion.q[:: max(1, motion.samples // 500)]])
    rows = zip(robot.spec.coordinate_limits, joints.T, sliding(robot.spec), strict=True)
    return not any(_beyond(limits, q, slides=bool(slides)) for limits, q, slides in rows)


def check_velocities(motion: Motion, robot: Robot) -> None:
    """Raise ConfigError where the velocities are those of the positions times a factor, as of another unit."""
    if motion.qd is None or motion.samples < 20:
        return
    step = float(np.median(np.diff(motion.t)))
    even = np.abs(np.diff(motion.t) / step - 1.0) < 0.5
    rates = slope(motion.q, step)[1:-1]
    usable = even[1:] & even[:-1]
    rows = zip(
        robot.spec.coordinate_names, sliding(robot.spec), rates[usable].T, motion.qd[1:-1][usable].T, strict=True
    )
    for name, slides, rate, said in rows:
        size = float(np.linalg.norm(rate) * np.linalg.norm(said))
        correlation = float(rate @ said) / size if size > 0.0 else 0.0
        if abs(correlation) < ALIKE:
            continue
        factor = float(rate @ said) / float(rate @ rate)
        if not 0.5 < factor < 2.0:
            raise ConfigError(
                f"{motion.source}: the velocities of joint '{name}' are {factor:.4g} times the slope of its positions:"
                f" {_why(factor, slides=slides)}"
            )


def _why(factor: float, *, slides: bool) -> str:
    for known, word in ((THOUSAND, "mm"),) if slides else ((TURN, "deg"),):
        if 0.9 < factor / known < 1.1:
            return f"they are in {word}/s and the positions are not; convert one of them ('dq1 [{word}/s]' in a header)"
        if 0.9 < factor * known < 1.1:
            return f"the positions are in {word} and they are not; convert one of them ('q1 [{word}]' in a header)"
    if factor < 0.0:
        return "one of them has its sign turned round"
    return (
        "one of them is at the motor side, or the stamps are wrong; record both at the joints, in SI, with true stamps"
    )


def check_torques(recording: Recording, robot: Robot, units: Collection[str]) -> None:
    """Raise ConfigError where measured torques are those of the robot's own masses times -1, or far too large or small.

    Says nothing where the two do not resemble each other: that the masses are unknown is why one identifies them; nor
    of torques that do not count.
    """
    if {"joint", "motor"} & set(units):
        return
    computed = np.where(recording.counts, robot.gravity_torque_batch(recording.q, -recording.base[:, :3]), 0.0)
    measured = np.where(recording.counts, recording.tau, 0.0)
    whole = _resemblance(measured, computed)[0]  # with the means: they hold the arm up
    if whole <= -FITS:
        has_columns = recording.specific_force is not None
        cause = ", or the gravity columns hold the specific force (call them ax ay az)" if has_columns else ""
        raise ConfigError(
            f"{recording.source}: the torques are opposite to what holds the arm up (correlation {whole:.2f}):"
            f" record what the drives exert, not what they feel; or the base is upside down{cause}. If it is right,"
            " --units joint"
        )
    for name, slides, one, other in zip(
        robot.spec.coordinate_names, sliding(robot.spec), measured.T, computed.T, strict=True
    ):
        correlation, ratio = _resemblance(one - one.mean(), other - other.mean())
        if correlation >= FITS and not 1.0 / APART < ratio < APART:
            raise ConfigError(f"{recording.source}: {_too_far(name, ratio, slides=slides)}")


def still_torques(recording: Recording, robot: Robot) -> Iterator[str]:
    """Notes on joints whose torques count and never change, though what hangs on them does."""
    computed = robot.gravity_torque_batch(recording.q, -recording.base[:, :3])
    rows = zip(robot.spec.coordinate_names, recording.counts.T, recording.tau.T, computed.T, strict=True)
    for name, counts, measured, expected in rows:
        seen = measured[counts]
        if len(seen) >= FEWEST and not np.ptp(seen) and np.ptp(expected[counts]) > SMALLEST:
            yield (
                f"the torque of joint '{name}' is {seen[0] + 0.0:.4g} in all {len(seen)} rows: if it was not recorded,"
                " let those of the other joints count alone (--at JOINT ...)"
            )


def _resemblance(one: FloatArray, other: FloatArray) -> tuple[float, float]:
    """Correlation, and the ratio of the sizes; 0 and 1 where there is nothing to compare."""
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    if size < 1e-12:
        return 0.0, 1.0
    return float((one * other).sum()) / size, float(np.linalg.norm(one) / np.linalg.norm(other))


def _too_far(name: str, ratio: float, *, slides: bool) -> str:
    said = f"the torques of joint '{name}' are {ratio:.3g} times those of the robot's own masses, of the same shape"
    if not slides and 0.2 < ratio / THOUSAND < 5.0:
        return f"{said}: if they are in mN·m say --units mNm, if they are right --units joint"
    if ratio > 1.0:
        return f"{said}: they are raw counts, or the robot's masses are far off; if they are right say --units joint"
    return (
        f"{said}: they are motor torques or currents; multiply by gear ratio and torque constant, or say --units motor"
        " for a robot with a transmission; if they are right say --units joint"
    )


def check_force(motion: Motion, units: Collection[str]) -> Iterator[str]:
    """Notes on the norm of the gravity columns; ConfigError for another unit, or what is no gravity."""
    if motion.gravity is None:
        return
    norm = float(np.median(np.linalg.norm(motion.gravity, axis=1)))
    if REST_NORM[0] <= norm <= REST_NORM[1]:
        if abs(norm / STANDARD_GRAVITY - 1.0) > OFF_SCALE:
            yield (
                f"the base's accelerometer reads {norm:.4g} m/s² at rest: its scale is {norm / STANDARD_GRAVITY:.3f}."
                " All masses come out wrong by that factor; torques cannot tell (ravengc calibrate accelerometer can)"
            )
        return
    unit = min(FORCE_UNITS, key=lambda unit: abs(norm / unit - 1.0))
    if REST_NORM[0] <= norm / unit * STANDARD_GRAVITY <= REST_NORM[1] and not {*FORCE_UNITS.values()} & set(units):
        word = FORCE_UNITS[unit]
        raise ConfigError(
            f"{motion.source}: the norm of the gravity columns is {norm:.4g}, not 9.81 m/s²: say --units {word}"
        )
    raise ConfigError(
        f"{motion.source}: the norm of the gravity columns is {norm:.4g} m/s² (median), not 9.81: record the base at"
        " rest, with a calibrated sensor, or leave the columns out and say --tilt"
    )
