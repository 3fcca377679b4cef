"""What an accelerometer, with or without a gyroscope, measured over some time, in SI and in the sensor's own axes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc import STANDARD_GRAVITY
from ravengc._convert import as_double, as_number, as_texts, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError, UnitsError
from ravengc.messages import kind_of, listed, shown
from ravengc.sensors.sample import Sample
from ravengc.sensors.units import ACCELERATION_UNITS

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = [
    "FORCE_UNITS",
    "STANDARD_GRAVITY",
    "FloatArray",
    "ImuRecording",
    "as_gravity",
    "as_rows",
    "check_unit",
    "from_samples",
]

FloatArray = NDArray[np.float64]

FORCE_UNITS = ACCELERATION_UNITS
"""What accelerometers send, with the factor to m/s²."""

NORM_WINDOW = (0.45, 1.6)
"""How far the norm of the readings may be from g: a bias of 0.3 g and a scale of 0.8 to 1.25 stay inside."""
LIKELY_WINDOW = (0.8, 1.25)
"""How far it may be for the guess that a file's header names the wrong unit."""

GRAVITY_WINDOW = (9.7, 9.9)


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuRecording:
    """Samples of one sensor: stamps (n,), s, increasing; specific force (n, 3), m/s², f = a - g: +9.81 upwards at rest.

    ``angular_velocity`` is (n, 3), rad/s, or None. ``unit`` is what the specific force was taken for before it
    became SI. Raises ArgumentError for other shapes, numbers that are not finite, and stamps that do not increase.
    """

    t: FloatArray
    specific_force: FloatArray
    angular_velocity: FloatArray | None = None
    unit: str = "m/s^2"
    source: str = "samples"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check what was given, and keep it as float64."""
        t = as_double(self.t, "t")
        if t.ndim != 1 or not np.isfinite(t).all() or not (np.diff(t) > 0.0).all():
            raise ArgumentError(f"t is {shown(t)}; expected finite stamps (n,) that increase")
        check_type(self.source, str, "source")
        if not isinstance(self.unit, str) or self.unit not in FORCE_UNITS:
            raise UnitsError(f"unit {shown(self.unit)} is unknown: choose {listed(FORCE_UNITS)}")
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "specific_force", as_rows(self.specific_force, "specific_force", t.size))
        if self.angular_velocity is not None:
            object.__setattr__(self, "angular_velocity", as_rows(self.angular_velocity, "angular_velocity", t.size))
        object.__setattr__(self, "notes", as_texts(self.notes, "notes"))

    @property
    def samples(self) -> int:
        """How many there are."""
        return self.t.size

    @property
    def duration(self) -> float:
        """From the first stamp to the last, s."""
        return float(self.t[-1] - self.t[0]) if self.t.size else 0.0

    @property
    def period(self) -> float:
        """Median time between two samples, s; NaN where there are fewer than two."""
        return float(np.median(np.diff(self.t))) if self.t.size > 1 else float("nan")


def as_gravity(x: Any) -> float:
    """Return a local g, m/s²; ConfigError for what it is nowhere on Earth, where it is 9.76 to 9.84."""
    gravity = as_number(x, "gravity")
    low, high = GRAVITY_WINDOW
    if not low <= gravity <= high:
        raise ConfigError(f"gravity is {gravity:g} m/s²; on Earth it is 9.76 to 9.84 ({STANDARD_GRAVITY} by default)")
    return gravity


def as_rows(x: npt.ArrayLike, name: str, count: int | None = None) -> FloatArray:
    """Return finite numbers (count, 3), any number of rows where ``count`` is None; ArgumentError for anything else."""
    rows = as_double(x, name)
    if rows.ndim != 2 or rows.shape[1] != 3 or count not in {None, len(rows)}:
        raise ArgumentError(f"{name} has shape {rows.shape}; expected ({'n' if count is None else count}, 3)")
    bad = np.flatnonzero(~(np.abs(rows) <= LARGEST).all(axis=1))
    if bad.size:
        raise ArgumentError(
            f"{name}[{bad[0]}] is {shown(rows[bad[0]].tolist())}; expected finite numbers of at most {LARGEST:g}"
        )
    return rows


def from_samples(samples: Iterable[Sample], source: str = "samples") -> ImuRecording:
    """Return the recording of a sensor's samples; angular velocity if every one of them has it.

    Samples with a number that is not finite, or larger than 1e9, and those whose stamp does not increase, are left out
    and counted.
    """
    if not isinstance(samples, Iterable):
        raise ArgumentError(f"samples is {kind_of(samples)}; expected samples, one after the other")
    kept: list[Sample] = []
    left_out = 0
    for sample in samples:
        check_type(sample, Sample, "sample")
        numbers = (*sample.specific_force, *(sample.angular_velocity or ()))
        if not all(abs(number) <= LARGEST for number in numbers) or (kept and sample.stamp_ns <= kept[-1].stamp_ns):
            left_out += 1
        else:
            kept.append(sample)
    rates = [sample.angular_velocity for sample in kept if sample.angular_velocity is not None]
    first = kept[0].stamp_ns if kept else 0
    return ImuRecording(
        t=np.array([(sample.stamp_ns - first) * 1e-9 for sample in kept]),
        specific_force=np.array([sample.specific_force for sample in kept], dtype=np.float64).reshape(-1, 3),
        angular_velocity=np.array(rates) if kept and len(rates) == len(kept) else None,
        source=source,
        notes=(f"{left_out} samples not finite, huge or not in order: left out",) if left_out else (),
    )


def check_unit(recording: ImuRecording, gravity: float = STANDARD_GRAVITY) -> None:
    """Raise UnitsError, naming the unit it looks like, if the readings' median norm is far from ``gravity`` (m/s²)."""
    norm = float(np.median(np.linalg.norm(recording.specific_force, axis=1))) if recording.samples else STANDARD_GRAVITY
    low, high = (bound * as_gravity(gravity) for bound in NORM_WINDOW)
    if low <= norm <= high:
        return
    raise UnitsError(f"{recording.source}: the norm is {_likely_unit(norm, recording.unit, low, high)}")


def _likely_unit(norm: float, unit: str, low: float, high: float) -> str:
    """What unit makes a norm (m/s²) about g: another than it was taken for, here or, by its header, in the file."""
    raw = norm / FORCE_UNITS[unit]
    if fitting := _fitting(raw, low, high):
        return f"{raw:.4g}, taken as {unit}; it looks like {fitting}: set the unit"
    near, far = (bound * STANDARD_GRAVITY for bound in LIKELY_WINDOW)
    for taken, factor in FORCE_UNITS.items():
        if fitting := _fitting(norm / factor, near, far):
            return f"{norm:.4g} m/s²; it looks like {fitting} taken for {taken}: does the header name the right unit?"
    return f"{raw:.4g}, taken as {unit}; no known unit makes that about 1 g (known: {listed(FORCE_UNITS)})"


def _fitting(raw: float, low: float, high: float) -> str:
    return " or ".join(unit for unit, factor in FORCE_UNITS.items() if low <= raw * factor <= high)
