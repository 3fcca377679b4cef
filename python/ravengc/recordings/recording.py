"""A motion recording: what was measured along a motion, checked once and immutable after that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_count, as_double, as_texts, check_type
from ravengc.errors import ArgumentError

__all__ = ["BASE", "FloatArray", "Recording"]

FloatArray = npt.NDArray[np.float64]
OPTIONAL = ("qd", "qdd", "tau")
BASE = ("gravity", "angular_velocity")
"""What is the base's, three numbers per sample."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """Joint positions along a motion, with the velocities, accelerations and torques that were recorded.

    ``t`` (s) has shape (samples,) and increases strictly; ``q``, ``qd``, ``qdd``, ``tau`` have shape (samples, joints),
    rad or m and their derivatives, N·m or N; ``gravity`` (m/s²) and ``angular_velocity`` (rad/s) of the base have shape
    (samples, 3), in its axes. All arrays are finite and read-only. ``names`` name the joints, empty where the source
    gives none. ``skipped`` counts the rows that were left out, by reason; ``notes`` say what a reader of the numbers
    should know. Raises ArgumentError for arrays that do not fit together.
    """

    t: FloatArray
    q: FloatArray
    qd: FloatArray | None = None
    qdd: FloatArray | None = None
    tau: FloatArray | None = None
    gravity: FloatArray | None = None
    angular_velocity: FloatArray | None = None
    names: tuple[str, ...] = ()
    source: str = "recording"
    skipped: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they fit together."""
        for name in ("t", "q", *OPTIONAL, *BASE):
            values = getattr(self, name)
            if values is not None or name in {"t", "q"}:
                object.__setattr__(self, name, _frozen(values, name))
        object.__setattr__(self, "names", as_texts(self.names, "names"))
        object.__setattr__(self, "notes", as_texts(self.notes, "notes"))
        check_type(self.source, str, "source")
        check_type(self.skipped, Mapping, "skipped")
        object.__setattr__(self, "skipped", MappingProxyType(dict(self.skipped)))
        _check_shapes(self)
        _check_values(self)

    @property
    def samples(self) -> int:
        """Number of samples."""
        return int(self.q.shape[0])

    @property
    def joints(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    @property
    def duration(self) -> float:
        """Time from the first to the last sample (s)."""
        return float(self.t[-1] - self.t[0])

    @property
    def columns(self) -> tuple[str, ...]:
        """A name for every joint: its own, or its number from 1."""
        return self.names or tuple(str(number + 1) for number in range(self.joints))

    def arrays(self) -> dict[str, FloatArray]:
        """The per-joint arrays that are present, by name: q, and qd, qdd, tau where recorded."""
        return self._present(("q", *OPTIONAL))

    def base_arrays(self) -> dict[str, FloatArray]:
        """The arrays of the base that are present, by name: gravity and angular_velocity, each (samples, 3)."""
        return self._present(BASE)

    def _present(self, names: Sequence[str]) -> dict[str, FloatArray]:
        found = {name: getattr(self, name) for name in names}
        return {name: values for name, values in found.items() if values is not None}

    def select(self, joints: Sequence[int]) -> Recording:
        """The same recording with the joints at these places (from 0), in this order."""
        check_type(joints, Sequence, "joints")
        places = [as_count(joint, "joint", 0, self.joints - 1) for joint in joints]
        chosen: dict[str, Any] = {name: values[:, places] for name, values in self.arrays().items()}
        names = tuple(self.names[place] for place in places) if self.names else ()
        return replace(self, names=names, **chosen)

    def with_notes(self, *notes: str) -> Recording:
        """The same recording with more notes."""
        return replace(self, notes=(*self.notes, *notes))


def _frozen(values: npt.ArrayLike, name: str) -> FloatArray:
    array = np.array(as_double(values, name))
    array.setflags(write=False)
    return array


def _check_shapes(recording: Recording) -> None:
    if recording.t.ndim != 1 or recording.t.size == 0:
        raise ArgumentError(f"t has shape {recording.t.shape}; expected (samples,) with at least one sample")
    q = recording.q
    if q.ndim != 2 or q.shape[0] != recording.t.size or q.shape[1] == 0:
        raise ArgumentError(f"q has shape {q.shape}; expected ({recording.t.size}, joints)")
    for name, values in recording.arrays().items():
        if values.shape != q.shape:
            raise ArgumentError(f"{name} has shape {values.shape}; expected {q.shape}, the shape of q")
    for name, values in recording.base_arrays().items():
        if values.shape != (recording.t.size, 3):
            raise ArgumentError(f"{name} has shape {values.shape}; expected ({recording.t.size}, 3)")
    if recording.names and len(recording.names) != q.shape[1]:
        raise ArgumentError(f"{len(recording.names)} names for {q.shape[1]} joints")


def _check_values(recording: Recording) -> None:
    for name, values in {"t": recording.t, **recording.arrays(), **recording.base_arrays()}.items():
        if not np.isfinite(values).all():
            row = int(np.argwhere(~np.isfinite(values))[0][0])
            raise ArgumentError(f"{name} is not finite in row {row}; leave such rows out")
    backwards = np.flatnonzero(np.diff(recording.t) <= 0.0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise ArgumentError(
            f"t does not increase at row {row}: {recording.t[row]:.9g} after {recording.t[row - 1]:.9g}"
        )
