"""What an identification is fed with: a motion, its torques, and how the base stood and moved meanwhile."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_double, as_number, as_texts, check_type
from ravengc._core import STANDARD_GRAVITY
from ravengc.errors import ArgumentError
from ravengc.messages import shown
from ravengc.recordings import Recording as Motion

__all__ = ["BoolArray", "FloatArray", "Recording", "from_motion"]

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
PER_JOINT = ("q", "qd", "qdd", "tau")
OF_THE_BASE = ("specific_force", "angular_velocity", "angular_acceleration")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """Joint torques along a motion, or in poses, on a base that may stand or move in any way.

    ``stamps`` (N,) s increase strictly; ``q``, ``qd``, ``qdd``, ``tau`` are (N, n), rad or m and their derivatives,
    N·m or N on the joint side; ``specific_force`` (N, 3) m/s², ``angular_velocity`` rad/s and
    ``angular_acceleration`` rad/s² are in base axes. Without a specific force the base is level, without the others
    it does not turn; missing velocities and accelerations are zero. ``counted`` (N, n) marks the torques that count,
    all where ``None``: those that were not measured do not, nor those of a protocol that trains one joint at a time but
    its own. ``cutoff_hz`` says that the torques were low-passed there, as :func:`~ravengc.identify.smoothed` does; the
    columns of a model then are as well. ``source`` says where it comes from, ``robot`` whose it is, ``skipped`` counts
    the rows of the source that were left out, by reason, and ``notes`` say what a reader of the numbers should know.
    Arrays are finite and read-only. Raises ArgumentError for arrays that do not fit together.
    """

    stamps: FloatArray
    q: FloatArray
    tau: FloatArray
    qd: FloatArray | None = None
    qdd: FloatArray | None = None
    specific_force: FloatArray | None = None
    angular_velocity: FloatArray | None = None
    angular_acceleration: FloatArray | None = None
    counted: BoolArray | None = None
    cutoff_hz: float | None = None
    source: str = "recording"
    robot: str | None = None
    skipped: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they fit together."""
        for name in ("stamps", *PER_JOINT, *OF_THE_BASE):
            values = getattr(self, name)
            if values is not None or name in {"stamps", "q", "tau"}:
                object.__setattr__(self, name, _frozen(values, name))
        if self.counted is not None:
            object.__setattr__(self, "counted", _marks(self.counted))
        check_type(self.source, str, "source")
        if self.cutoff_hz is not None:
            object.__setattr__(self, "cutoff_hz", as_number(self.cutoff_hz, "cutoff_hz"))
        if self.robot is not None:
            check_type(self.robot, str, "robot")
        check_type(self.skipped, Mapping, "skipped")
        object.__setattr__(self, "skipped", MappingProxyType(dict(self.skipped)))
        object.__setattr__(self, "notes", as_texts(self.notes, "notes"))
        _check_shapes(self)
        _check_values(self)

    @property
    def samples(self) -> int:
        """Number of samples, N."""
        return int(self.q.shape[0])

    @property
    def joints(self) -> int:
        """Number of joints, n."""
        return int(self.q.shape[1])

    @property
    def velocity(self) -> FloatArray:
        """Joint velocities (N, n); zero where none were recorded."""
        return np.zeros_like(self.q) if self.qd is None else self.qd

    @property
    def acceleration(self) -> FloatArray:
        """Joint accelerations (N, n); zero where none were recorded."""
        return np.zeros_like(self.q) if self.qdd is None else self.qdd

    @property
    def base(self) -> FloatArray:
        """Specific force, angular velocity and angular acceleration of the base, (N, 9)."""
        motion = np.zeros((self.samples, 9))
        motion[:, 2] = STANDARD_GRAVITY
        for place, name in enumerate(OF_THE_BASE):
            values = getattr(self, name)
            if values is not None:
                motion[:, 3 * place : 3 * place + 3] = values
        return motion

    @property
    def counts(self) -> BoolArray:
        """Which torques count, (N, n)."""
        return np.ones(self.q.shape, dtype=bool) if self.counted is None else self.counted

    def take(self, rows: slice | npt.NDArray[Any]) -> Recording:
        """The same recording with these samples alone: a slice, a mask, or increasing sample numbers."""
        arrays = {name: getattr(self, name) for name in ("stamps", *PER_JOINT, *OF_THE_BASE, "counted")}
        return replace(self, **{name: values[rows] for name, values in arrays.items() if values is not None})

    def counting(self, joints: npt.ArrayLike) -> Recording:
        """The same recording in which the torques of these joints alone count: their places from 0."""
        places = np.array(joints)
        if places.ndim != 1 or not set(places.tolist()) <= set(range(self.joints)):
            raise ArgumentError(f"joints are {shown(joints)}; expected places from 0 to {self.joints - 1}")
        of_these = np.isin(np.arange(self.joints), places)
        return replace(self, counted=self.counts & of_these)

    def with_notes(self, *notes: str) -> Recording:
        """The same recording with more notes."""
        return replace(self, notes=(*self.notes, *notes))


def from_motion(motion: Motion, *, robot: str | None = None) -> Recording:
    """The recording of a motion that was read by :mod:`ravengc.recordings`: its gravity becomes the specific force.

    Raises ArgumentError for a motion without torques.
    """
    check_type(motion, Motion, "motion")
    if motion.tau is None:
        raise ArgumentError(f"{motion.source} has no torques; an identification needs a column of tau for every joint")
    force = None if motion.gravity is None else -motion.gravity
    return Recording(
        stamps=motion.t,
        q=motion.q,
        tau=motion.tau,
        qd=motion.qd,
        qdd=motion.qdd,
        specific_force=force,
        angular_velocity=motion.angular_velocity,
        source=motion.source,
        robot=robot,
        skipped=motion.skipped,
        notes=motion.notes,
    )


def _frozen(values: npt.ArrayLike, name: str) -> FloatArray:
    array = np.array(as_double(values, name))
    array.setflags(write=False)
    return array


def _marks(values: npt.ArrayLike) -> BoolArray:
    marks = np.array(values)
    if marks.dtype != np.bool_:
        raise ArgumentError(f"counted has numbers of type {marks.dtype}; expected True and False")
    marks.setflags(write=False)
    return marks


def _check_shapes(recording: Recording) -> None:
    stamps, q = recording.stamps, recording.q
    if stamps.ndim != 1 or stamps.size == 0:
        raise ArgumentError(f"stamps has shape {stamps.shape}; expected (N,) with at least one sample")
    if q.ndim != 2 or q.shape[0] != stamps.size or q.shape[1] == 0:
        raise ArgumentError(f"q has shape {q.shape}; expected ({stamps.size}, joints)")
    wanted: list[tuple[tuple[str, ...], tuple[int, ...]]] = [
        ((*PER_JOINT, "counted"), q.shape),
        (OF_THE_BASE, (stamps.size, 3)),
    ]
    for names, shape in wanted:
        for name in names:
            values = getattr(recording, name)
            if values is not None and values.shape != shape:
                raise ArgumentError(f"{name} has shape {values.shape}; expected {shape}")


def _check_values(recording: Recording) -> None:
    for part in fields(recording):
        values = getattr(recording, part.name)
        if isinstance(values, np.ndarray) and not np.isfinite(values).all():
            row = int(np.argwhere(~np.isfinite(values))[0][0])
            raise ArgumentError(f"{part.name} is not finite in row {row}; leave such rows out")
    backwards = np.flatnonzero(np.diff(recording.stamps) <= 0.0)
    if backwards.size:
        row = int(backwards[0]) + 1
        times = f"{recording.stamps[row]:.9g} after {recording.stamps[row - 1]:.9g}"
        raise ArgumentError(f"stamps do not increase at row {row}: {times}")


def as_recordings(recordings: object, name: str, joints: int) -> tuple[Recording, ...]:
    """One recording or several, of a robot with this many joints; ArgumentError for anything else."""
    several = recordings if isinstance(recordings, (list, tuple)) else (recordings,)
    if not several:
        raise ArgumentError(f"{name} is empty; expected at least one Recording")
    for one in several:
        check_type(one, Recording, name)
        if one.joints != joints:
            raise ArgumentError(f"{one.source} has {one.joints} joints; expected {joints}, those of the robot")
    return tuple(several)
