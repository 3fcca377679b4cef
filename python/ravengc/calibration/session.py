"""Calibration with a live sensor: ask for a position, wait until it lies still, keep that, ask for the next.

The sensor is a function ``read(timeout_s)`` that returns a sample or None; the questions go to a function ``ask(text)``
that returns what the user typed. A position that is not as it should be is asked for again, with the reason, so that
those before it are not lost. What is kept becomes an ordinary recording with pauses in it.
"""

from __future__ import annotations

from collections import deque
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_count, as_number, check_type
from ravengc.calibration.ellipsoid import FEWEST_POSITIONS, LEAST_COVERAGE_DEG
from ravengc.calibration.imu import ImuRecording, check_unit, from_samples
from ravengc.calibration.positions import FACES, angle_between, coverage_deg, different, missing_faces
from ravengc.calibration.six import nearest_face
from ravengc.calibration.still import StillLimits, quietest, still_segments
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.messages import kind_of
from ravengc.sensors.sample import Sample

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ravengc.calibration.imu import FloatArray

    Read = Callable[[float], Sample | None]
    Ask = Callable[[str], str]

__all__ = ["ask_for_faces", "ask_for_positions", "ask_for_tilts", "record", "wait_until_still"]

HOLD_S = 2.0
"""How long a position is measured, if the shortest rest is not longer; a rest loses a quarter of a window at each end.
"""
CHECK_S = 0.1
PATIENCE_S = 30.0
LONGEST_S = 3600.0
READ_S = 0.5
SILENT_READS = 10
MOST_STUCK = 1000
PAUSE_S = 10.0
MOST_BUFFERED = 100_000
MOST_POSITIONS = 200
TRIES = 5
MOST_LEAN_DEG = 25.0
"""A face that leans by 10 degrees, read with a bias of a quarter of g."""
DONE = ("q", "quit", "done", "finish")
"""What a user types instead of Enter when there are enough free positions, or to give up."""


def ask_for_faces(read: Read, ask: Ask, limits: StillLimits | None = None) -> ImuRecording:
    """Return a recording of six positions, each axis up once and down once; a wrong face is asked for again.

    Raises CalibrationError for a face that is not shown in five attempts.
    """
    session = _Session(read, ask, limits)
    for face in FACES:
        session.demand(f"{face} up", "put it there, hold it still and press Enter", partial(_wrong, face))
    return session.recording()


def ask_for_tilts(read: Read, ask: Ask, count: int, limits: StillLimits | None = None) -> ImuRecording:
    """Return a recording of ``count`` positions of the base, in the order of their known tilts."""
    session = _Session(read, ask, limits)
    last = as_count(count, "count", 1, MOST_POSITIONS)
    for number in range(1, last + 1):
        session.demand(f"Tilt {number} of {last}", "hold the base still and press Enter")
    return session.recording()


def ask_for_positions(read: Read, ask: Ask, limits: StillLimits | None = None) -> ImuRecording:
    """Return a recording of free positions, as many as the user makes; the question says what is still missing."""
    session = _Session(read, ask, limits)
    while len(session.parts) < MOST_POSITIONS:
        if not session.take(_progress(session.parts), "turn it, hold it still and press Enter, or q when done"):
            break
    return session.recording()


def record(read: Read, seconds: float) -> ImuRecording:
    """Return what arrives within ``seconds`` by the samples' stamps; CalibrationError where no sample comes."""
    _check_function(read, "read")
    span = as_number(seconds, "seconds")
    if not 0.0 < span <= LONGEST_S:
        raise ArgumentError(f"seconds is {span:g}; expected a number above 0, up to {LONGEST_S:g}")
    _drain(read)
    samples = [_next(read)]
    while samples[-1].stamp_ns - samples[0].stamp_ns < span * 1e9:
        samples.append(_later(read, samples[-1]))
    return from_samples(samples)


def wait_until_still(read: Read, limits: StillLimits, patience_s: float = PATIENCE_S) -> ImuRecording:
    """Return the first seconds in which the sensor lies still, from what arrives after the call.

    It is two, or the shortest rest and a window if that is longer; they are one rest by :func:`still_segments`. Raises
    CalibrationError after ``patience_s`` of samples without such a rest and where no sample comes, UnitsError for a
    norm that is far from g.
    """
    hold_s = max(HOLD_S, limits.shortest_s + limits.window_s)
    _drain(read)
    first = _next(read)
    kept, check_ns = deque([first]), first.stamp_ns + round(hold_s * 1e9)
    while True:
        sample = _later(read, kept[-1])
        kept.append(sample)
        if sample.stamp_ns < check_ns:
            continue
        check_ns = sample.stamp_ns + round(CHECK_S * 1e9)
        while kept[0].stamp_ns < sample.stamp_ns - round(hold_s * 1e9):
            kept.popleft()
        recent = from_samples(kept)
        if _is_rest(recent, limits, hold_s):
            check_unit(recent)
            return recent
        if sample.stamp_ns - first.stamp_ns > (patience_s + hold_s) * 1e9:
            raise CalibrationError(_restless(recent, limits, hold_s, patience_s))


class _Session:
    """The positions that a user was asked for, so far."""

    def __init__(self, read: Read, ask: Ask, limits: StillLimits | None) -> None:
        _check_function(read, "read")
        _check_function(ask, "ask")
        self._read, self._ask = read, ask
        self._limits = StillLimits() if limits is None else limits
        check_type(self._limits, StillLimits, "limits")
        self.parts: list[ImuRecording] = []

    def demand(self, name: str, what: str, complaint: Callable[[FloatArray], str] = lambda _: "") -> None:
        """Take a position that must not be left out."""
        if not self.take(name, what, complaint):
            raise CalibrationError(f"{name}: the user gave up; all positions are needed")

    def take(self, name: str, what: str, complaint: Callable[[FloatArray], str] = lambda _: "") -> bool:
        """Ask until the sensor lies still and its mean force gives no ``complaint``; False if the user is done.

        Raises CalibrationError after five attempts.
        """
        problem = ""
        for _ in range(TRIES):
            answer = self._ask(f"{problem} {name}: {what}".lstrip())
            check_type(answer, str, "the answer to a question")
            if answer.strip().lower() in DONE:
                return False
            try:
                part = wait_until_still(self._read, self._limits)
                problem = complaint(part.specific_force.mean(axis=0))
            except CalibrationError as error:
                problem = f"Not taken ({error})."
            if not problem:
                self.parts.append(part)
                return True
        raise CalibrationError(f"{name} was not taken in {TRIES} attempts. {problem}")

    def recording(self) -> ImuRecording:
        """One recording of all positions, with pauses between them."""
        starts = np.cumsum([0.0, *(part.duration + PAUSE_S for part in self.parts)])
        rates = [part.angular_velocity for part in self.parts if part.angular_velocity is not None]
        notes = [f"position {n}: {note}" for n, part in enumerate(self.parts, start=1) for note in part.notes]
        return ImuRecording(
            t=np.concatenate(
                [np.zeros(0), *(part.t + start for part, start in zip(self.parts, starts[:-1], strict=True))]
            ),
            specific_force=np.concatenate([np.zeros((0, 3)), *(part.specific_force for part in self.parts)]),
            angular_velocity=np.concatenate(rates) if rates and len(rates) == len(self.parts) else None,
            source="live sensor",
            notes=tuple(notes),
        )


def _wrong(face: str, force: FloatArray) -> str:
    """What is wrong with a force that should be along a face; "" if nothing."""
    found = nearest_face(force)
    if found != face:
        return f"That was {found} up (the axes are the sensor's)."
    lean = angle_between(force, FACES[face])
    return f"It leans by {lean:.0f} degrees: set it on its face." if lean > MOST_LEAN_DEG else ""


def _progress(parts: Sequence[ImuRecording]) -> str:
    if not parts:
        return f"Position 1 of {FEWEST_POSITIONS} or more"
    seen = np.array([part.specific_force.mean(axis=0) for part in parts])
    missing = missing_faces(seen)
    near = f", none near {', '.join(missing)} up" if missing else ""
    so_far = f"{different(seen)} different so far, coverage {coverage_deg(seen):.0f} of {LEAST_COVERAGE_DEG:g} degrees"
    return f"Position {len(seen) + 1} of {FEWEST_POSITIONS} or more ({so_far}{near})"


def _is_rest(recent: ImuRecording, limits: StillLimits, hold_s: float) -> bool:
    """Whether all of it, but for the ends, is one rest."""
    rests = still_segments(recent, limits)
    return len(rests) == 1 and rests[0].end - rests[0].begin >= hold_s - limits.window_s


def _check_function(x: object, name: str) -> None:
    if not callable(x):
        raise ArgumentError(f"{name} is {kind_of(x)}; expected a function")


def _drain(read: Read) -> None:
    """Drop what waited in buffers while the user read the question."""
    for _ in range(MOST_BUFFERED):
        if read(0.0) is None:
            return


def _next(read: Read) -> Sample:
    for _ in range(SILENT_READS):
        sample = read(READ_S)
        if sample is not None:
            check_type(sample, Sample, "what read returns")
            return sample
    raise CalibrationError(
        f"the sensor sent nothing for {SILENT_READS * READ_S:g} s: is it connected, at this address?"
    )


def _later(read: Read, last: Sample) -> Sample:
    """The next sample with a later stamp."""
    for _ in range(MOST_STUCK):
        sample = _next(read)
        if sample.stamp_ns > last.stamp_ns:
            return sample
    raise CalibrationError(f"the stamps of {MOST_STUCK} samples do not move on: does the sensor's clock stand still?")


def _restless(recent: ImuRecording, limits: StillLimits, hold_s: float, patience_s: float) -> str:
    if recent.duration <= 0.9 * hold_s:
        return f"only {recent.samples} good samples in {hold_s:g} s; expected a steady stream"
    force, rate = quietest(recent, limits)
    turning = f", {rate:.3g} rad/s (limit {limits.rate:g})" if np.isfinite(rate) else ""
    return (
        f"it did not lie still within {patience_s:g} s: the standard deviation is {force:.3g} m/s² (limit "
        f"{limits.force:g}){turning}; lay it down, or raise the limits if the sensor is that noisy"
    )
