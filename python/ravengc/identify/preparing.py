"""From a recording as it was taken to one that a model can be fitted to: poses averaged, motions filtered.

A model of gravity takes poses, from both sides where they were approached so; one with friction or inertia takes a
motion, low-passed without a delay, with its accelerations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc.errors import ArgumentError, CalibrationError, ConfigError
from ravengc.identify.model import Model
from ravengc.identify.recording import Recording
from ravengc.identify.rests import rests
from ravengc.identify.smoothing import smoothed
from ravengc.identify.static import both_ways
from ravengc.messages import shown

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["parted", "prepared"]

FASTEST_POSES = 2.0
"""Samples per second (median) up to which a log counts as poses one after the other, not as a motion."""
HIGHEST_CUTOFF, PER_CUTOFF = 10.0, 10.0
"""Hz, and samples per period of the cutoff: the default filter."""
EDGE = 1.5
"""Periods of the cutoff that are left out at both ends."""
FEWEST_RESTS = 8
"""Rests of a motion from which on they count, and what lies between them does not."""
UP_AND_DOWN = "pass every pose up and down again"
LONGEST_GAP = 10.0
"""Steps without a sample across which nothing is filled in."""


def prepared(recording: Recording, model: Model, cutoff_hz: float | Literal["auto"] | None = "auto") -> Recording:
    """The recording that ``model`` is fitted to; what was done to it is in its notes.

    ``"auto"`` filters a motion at 10 Hz or a tenth of its rate, and averages poses that were approached from both
    sides for a model of gravity; a number filters there; ``None`` leaves everything as it is. Raises ConfigError for a
    motion with a gap, and for accelerations that are needed and neither recorded nor worked out.
    """
    check_type(recording, Recording, "recording")
    check_type(model, Model, "model")
    if isinstance(cutoff_hz, str):
        if cutoff_hz != "auto":
            raise ArgumentError(f"cutoff_hz is {shown(cutoff_hz)}; expected 'auto', a number of Hz, or None")
        return _by_itself(recording, model)
    return _as_it_is(recording, model) if cutoff_hz is None else _filtered(recording, as_number(cutoff_hz, "cutoff_hz"))


def _by_itself(recording: Recording, model: Model) -> Recording:
    if model.kind == "gravity":
        return _rested(recording) if _is_motion(recording) else _averaged(recording)
    return _filtered(recording, _cutoff(recording)) if _is_motion(recording) else _as_it_is(recording, model)


def parted(recording: Recording, share: float) -> tuple[Recording, Recording]:
    """What to fit and what to hold out: the last share of a motion, or this share of poses, evenly spread.

    So every tilt of the base that many poses were taken on is in both. Raises ArgumentError for too few samples, and
    for a share that is not from 0.05 to 0.9.
    """
    check_type(recording, Recording, "recording")
    part = as_number(share, "share")
    if not 0.05 <= part <= 0.9:
        raise ArgumentError(f"share is {shown(share)}; expected one from 0.05 to 0.9")
    number = np.arange(1, recording.samples + 1)
    if _is_motion(recording):
        held: npt.NDArray[np.bool_] = number > round(recording.samples * (1.0 - part))
    else:
        held = np.diff(np.floor(part * number + 1e-9), prepend=0.0) > 0.0
    if held.all() or not held.any():
        raise ArgumentError(f"{recording.source} has {recording.samples} samples; too few to hold out {part:g} of them")
    return recording.take(~held), recording.take(held)


def _is_motion(recording: Recording) -> bool:
    steps = np.diff(recording.stamps)
    return steps.size >= 8 and float(np.median(steps)) < 1.0 / FASTEST_POSES


def _cutoff(recording: Recording) -> float:
    rate = 1.0 / float(np.median(np.diff(recording.stamps)))
    return min(HIGHEST_CUTOFF, rate / PER_CUTOFF)


def _averaged(recording: Recording) -> Recording:
    """One sample per pose with the mean of both directions, where there are such poses; else all samples."""
    if recording.qd is None:
        return recording.with_notes(f"no velocities: friction is in the torques; {UP_AND_DOWN} and record them")
    try:
        poses = both_ways(recording)
    except CalibrationError:
        return recording.with_notes(
            f"no pose was approached from both sides: friction is in the torques; {UP_AND_DOWN}"
        )
    return poses.with_notes(f"{poses.samples} poses approached from both sides: friction cancels in their mean torques")


def _rested(recording: Recording) -> Recording:
    """The rests of a motion as poses, if there are enough of them; else the motion."""
    try:
        poses = rests(recording)
    except ArgumentError:
        poses = recording.take(slice(0, 1))
    if poses.samples < FEWEST_RESTS:
        return recording.with_notes(
            "a motion, taken sample by sample: friction and inertia are in the torques; stop in every pose for half a"
            " second, come to each from both sides, or identify gravity+friction"
        )
    return _averaged(poses.with_notes(f"the arm rests {poses.samples} times: taken as poses"))


def _filtered(recording: Recording, cutoff: float) -> Recording:
    if not 0.0 < cutoff < np.inf:
        raise ArgumentError(f"cutoff_hz is {cutoff:g}; expected more than 0 Hz")
    steps = np.diff(recording.stamps)
    step = float(np.median(steps)) if steps.size else 1.0
    if steps.size and float(steps.max()) > max(LONGEST_GAP * step, 1.0 / cutoff):
        row = int(steps.argmax())
        raise ConfigError(
            f"{recording.source}: {steps[row]:.3g} s without a sample after {recording.stamps[row]:.6g} s: no filter"
            " reaches across; give the parts before and after as two logs, or poses without a filter (--cutoff none)"
        )
    calm = smoothed(recording, cutoff, trim=EDGE / cutoff)
    velocities = "" if recording.qd is not None else ", velocities from positions"
    return calm.with_notes(f"low-passed at {cutoff:g} Hz forwards and backwards{velocities}")


def _as_it_is(recording: Recording, model: Model) -> Recording:
    turning = recording.angular_velocity is not None and recording.angular_acceleration is None
    if model.kind == "dynamics" and turning:
        raise ConfigError(
            f"{recording.source}: the base's angular velocity without its angular acceleration, which a model of"
            " dynamics needs; let it be worked out (a cutoff in Hz), or record it"
        )
    missing = [name for name in ("qd", "qdd") if getattr(recording, name) is None]
    if model.kind == "gravity" or not missing or (model.kind == "gravity+friction" and missing == ["qdd"]):
        return recording
    what = "velocities and accelerations" if len(missing) == 2 else "velocities" if "qd" in missing else "accelerations"
    raise ConfigError(
        f"{recording.source}: no {what}, which a model of {model.kind} needs; record a motion with many samples per"
        " second and let them be worked out (a cutoff in Hz), or record them"
    )
