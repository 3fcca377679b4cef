"""Calibration with a live sensor: ask for a position, wait until it lies still, keep that, ask for the next.

The sensor is a function ``read(timeout_s)`` that returns a sample or None; the questions go to a function ``ask(text)``
that returns what the user typed. What is kept becomes an ordinary recording with pauses in it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ravengc.calibration.ellipsoid import FEWEST_POSITIONS, LEAST_COVERAGE_DEG
from ravengc.calibration.imu import ImuRecording, check_unit, from_samples
from ravengc.calibration.positions import FACES, coverage_deg, different, missing_faces
from ravengc.calibration.refusal import CalibrationError
from ravengc.calibration.six import nearest_face
from ravengc.calibration.still import StillLimits, is_still, quietest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from ravengc.calibration.imu import FloatArray
    from ravengc.sensors.sample import Sample

    Read = Callable[[float], Sample | None]
    Ask = Callable[[str], str]

__all__ = ["ask_for_faces", "ask_for_positions", "ask_for_tilts", "record", "wait_until_still"]

HOLD_S = 2.0
"""How long a position is measured; a rest loses a quarter of a window at each end."""
CHECK_S = 0.1
PATIENCE_S = 30.0
READ_S = 0.5
SILENT_READS = 10
PAUSE_S = 10.0
MOST_BUFFERED = 100_000
MOST_POSITIONS = 200
TRIES = 5
DONE = ("q", "quit", "done", "finish")
"""What a user types instead of Enter when there are enough free positions."""


def ask_for_faces(read: Read, ask: Ask, limits: StillLimits | None = None) -> ImuRecording:
    """Return a recording of six positions, each axis up once and down once; a wrong face is asked for again."""
    return _joined(_face(read, ask, face, limits or StillLimits()) for face in FACES)


def ask_for_tilts(read: Read, ask: Ask, count: int, limits: StillLimits | None = None) -> ImuRecording:
    """Return a recording of ``count`` positions of the base, in the order of their known tilts."""
    parts = []
    for number in range(1, count + 1):
        ask(f"Tilt {number} of {count}: hold the base still and press Enter")
        parts.append(wait_until_still(read, limits or StillLimits()))
    return _joined(parts)


def ask_for_positions(read: Read, ask: Ask, limits: StillLimits | None = None) -> ImuRecording:
    """Return a recording of free positions, as many as the user makes; the question says what is still missing."""
    parts: list[ImuRecording] = []
    while len(parts) < MOST_POSITIONS:
        seen = np.array([part.specific_force.mean(axis=0) for part in parts]).reshape(-1, 3)
        answer = ask(f"{_progress(seen)}: turn it, hold it still and press Enter, or q when done")
        if answer.strip().lower() in DONE:
            break
        parts.append(wait_until_still(read, limits or StillLimits()))
    return _joined(parts)


def record(read: Read, seconds: float) -> ImuRecording:
    """Return what arrives within ``seconds`` by the samples' stamps; CalibrationError where no sample comes."""
    _drain(read)
    samples = [_next(read)]
    while samples[-1].stamp_ns - samples[0].stamp_ns < seconds * 1e9:
        samples.append(_next(read))
    return from_samples(samples)


def wait_until_still(read: Read, limits: StillLimits, patience_s: float = PATIENCE_S) -> ImuRecording:
    """Return the first two seconds in which the sensor lies still, from what arrives after the call.

    Raises CalibrationError after ``patience_s`` of samples without such a rest and where no sample comes, UnitsError
    for a norm that is far from g.
    """
    _drain(read)
    first = _next(read)
    kept, check_ns = deque([first]), first.stamp_ns + round(HOLD_S * 1e9)
    while True:
        sample = _next(read)
        kept.append(sample)
        if sample.stamp_ns < check_ns:
            continue
        check_ns = sample.stamp_ns + round(CHECK_S * 1e9)
        while kept[0].stamp_ns < sample.stamp_ns - round(HOLD_S * 1e9):
            kept.popleft()
        recent = from_samples(kept)
        if recent.duration > 0.9 * HOLD_S and is_still(recent, limits):
            check_unit(recent)
            return recent
        if sample.stamp_ns - first.stamp_ns > patience_s * 1e9:
            raise CalibrationError(_restless(recent, limits, patience_s))


def _face(read: Read, ask: Ask, face: str, limits: StillLimits) -> ImuRecording:
    question = f"{face} up: put it there, hold it still and press Enter"
    for _ in range(TRIES):
        ask(question)
        part = wait_until_still(read, limits)
        found = nearest_face(part.specific_force.mean(axis=0))
        if found == face:
            return part
        question = f"That was {found} up. {face} up: turn it, hold it still and press Enter"
    raise CalibrationError(f"{face} up was not shown in {TRIES} attempts: are the axes those of the sensor?")


def _progress(seen: FloatArray) -> str:
    if not len(seen):
        return f"Position 1 of {FEWEST_POSITIONS} or more"
    missing = missing_faces(seen)
    near = f", none near {', '.join(missing)} up" if missing else ""
    so_far = f"{different(seen)} different so far, coverage {coverage_deg(seen):.0f} of {LEAST_COVERAGE_DEG:g} degrees"
    return f"Position {len(seen) + 1} of {FEWEST_POSITIONS} or more ({so_far}{near})"


def _drain(read: Read) -> None:
    """Drop what waited in buffers while the user read the question."""
    for _ in range(MOST_BUFFERED):
        if read(0.0) is None:
            return


def _next(read: Read) -> Sample:
    for _ in range(SILENT_READS):
        sample = read(READ_S)
        if sample is not None:
            return sample
    raise CalibrationError(
        f"the sensor sent nothing for {SILENT_READS * READ_S:g} s: is it connected, at this address?"
    )


def _restless(recent: ImuRecording, limits: StillLimits, patience_s: float) -> str:
    if recent.duration <= 0.9 * HOLD_S:
        return f"only {recent.samples} good samples in {HOLD_S:g} s; expected a steady stream"
    force, rate = quietest(recent, limits)
    turning = f", {rate:.3g} rad/s (limit {limits.rate:g})" if np.isfinite(rate) else ""
    return (
        f"it did not lie still within {patience_s:g} s: the standard deviation is {force:.3g} m/s² (limit "
        f"{limits.force:g}){turning}; lay it down, or raise the limits if the sensor is that noisy"
    )


def _joined(parts: Iterable[ImuRecording]) -> ImuRecording:
    """One recording of all parts, with pauses between them."""
    start, shifted = 0.0, []
    for part in parts:
        shifted.append(replace(part, t=part.t + start))
        start += part.duration + PAUSE_S
    rates = [part.angular_velocity for part in shifted if part.angular_velocity is not None]
    return ImuRecording(
        t=np.concatenate([np.zeros(0), *(part.t for part in shifted)]),
        specific_force=np.concatenate([np.zeros((0, 3)), *(part.specific_force for part in shifted)]),
        angular_velocity=np.concatenate(rates) if rates and len(rates) == len(shifted) else None,
        source="live sensor",
    )
