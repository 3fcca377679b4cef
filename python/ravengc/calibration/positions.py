"""Positions in which a sensor lay still, how far around the sphere they reach, and which directions are missing.

A position's direction is that of its specific force: up, seen from the sensor. The coverage of positions is half the
opening of the narrowest cone that holds all their directions: the largest lean from the middle of them. Six faces of a
cube have 125 degrees, tilts of up to 20 degrees to every side have 20.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc.calibration.imu import FloatArray, ImuRecording, as_rows
from ravengc.calibration.rounding import rounding_error, step_of
from ravengc.calibration.still import StillLimits, quietest, still_segments
from ravengc.errors import CalibrationError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import numpy.typing as npt

    from ravengc.calibration.still import StillSegment

__all__ = [
    "FACES",
    "SAME_DEG",
    "Position",
    "angle_between",
    "coverage_deg",
    "different",
    "missing_faces",
    "rest_rate",
    "spread_deg",
    "still_positions",
]

FACES = {
    "+x": (1.0, 0.0, 0.0), "-x": (-1.0, 0.0, 0.0), "+y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0), "+z": (0.0, 0.0, 1.0), "-z": (0.0, 0.0, -1.0),
}  # fmt: skip
"""The sensor's axes, by the one that points up."""

SAME_DEG = 2.0
"""Rests whose directions differ by less are one position."""
UNSEEN_DEG = 50.0
"""An axis farther than this from every position was not seen."""
SHORTEST = 1e-9
MOST_EXACT = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Position:
    """A rest, or several in one direction: mean specific force (3,), m/s², and the standard error of each component.

    The error is that of noise and, where the sensor's steps are coarser than its noise, of rounding.
    ``begin`` and ``end`` (s) are those of the first rest, ``duration`` (s) is that of all of them.
    """

    force: FloatArray
    error: float
    begin: float
    end: float
    duration: float
    rests: int = 1


def still_positions(
    recording: ImuRecording, limits: StillLimits | None = None, *, same_deg: float = SAME_DEG, in_order: bool = False
) -> tuple[tuple[Position, ...], tuple[StillSegment, ...]]:
    """Return the positions of a recording and the rests they come from; CalibrationError if it never lies still.

    Rests less than ``same_deg`` degrees apart are one position; ``in_order`` joins only those that follow each other,
    for positions that are known by their order.
    """
    check_type(in_order, bool, "in_order")
    limits = StillLimits() if limits is None else limits
    segments = still_segments(recording, limits)
    if not segments:
        raise CalibrationError(f"{recording.source}: {_restless(recording, limits)}")
    rests = [recording.specific_force[segment.start : segment.stop] for segment in segments]
    rounding = rounding_error(rests, step_of(recording.specific_force))
    apart = as_number(same_deg, "same_deg")
    return _positions_from(segments, same_deg=apart, in_order=in_order, rounding=rounding), segments


def _restless(recording: ImuRecording, limits: StillLimits) -> str:
    """Why no rest was found: too short, or too noisy, and by how much."""
    if recording.duration < limits.shortest_s:
        lasts = f"it lasts {recording.duration:.3g} s ({recording.samples} samples)"
        return f"{lasts}; a rest takes at least {limits.shortest_s:g} s"
    force, rate = quietest(recording, limits)
    turning = "" if recording.angular_velocity is None else f" and {rate:.3g} rad/s (limit {limits.rate:g})"
    if force <= limits.force and limits.rate < rate < np.inf:
        turning += ", so it is the gyroscope that never rests, or its unit is another"
    return (
        f"it never lies still for {limits.shortest_s:g} s. In its quietest {limits.window_s:g} s the standard "
        f"deviation is {force:.3g} m/s² (limit {limits.force:g}){turning}. Hold every position still; if the sensor "
        "did rest, it is noisier than the limits allow: raise them"
    )


def _positions_from(
    segments: Sequence[StillSegment], *, same_deg: float, in_order: bool, rounding: float
) -> tuple[Position, ...]:
    """Rests whose directions are less than ``same_deg`` apart are joined, weighted by how long they are."""
    freedom = sum(segment.freedom for segment in segments)
    density = np.sqrt(sum(segment.freedom * segment.noise**2 for segment in segments) / max(freedom, 1))
    found: list[Position] = []
    for segment in segments:
        rest = Position(
            force=segment.force, error=0.0, begin=segment.begin, end=segment.end, duration=segment.end - segment.begin
        )
        near = np.flatnonzero(_angles(segment.force, [position.force for position in found]) < same_deg)
        if near.size and (not in_order or near[-1] == len(found) - 1):
            found[near[-1]] = _joined(found[near[-1]], rest)
        else:
            found.append(rest)
    return tuple(
        replace(position, error=float(np.hypot(density / np.sqrt(position.duration), rounding))) for position in found
    )


def _joined(position: Position, rest: Position) -> Position:
    duration = position.duration + rest.duration
    force = (position.force * position.duration + rest.force * rest.duration) / duration
    return replace(position, force=force, duration=duration, rests=position.rests + 1)


def rest_rate(segments: Iterable[StillSegment]) -> FloatArray | None:
    """Return what the gyroscope reads at rest (3,), rad/s, weighted by time; None without a gyroscope."""
    rates = [(segment.rate, segment.end - segment.begin) for segment in segments if segment.rate is not None]
    if not rates:
        return None
    return np.asarray(np.average([rate for rate, _ in rates], axis=0, weights=[time for _, time in rates]))


def angle_between(a: npt.ArrayLike, b: npt.ArrayLike) -> float:
    """Return the angle between two vectors (3,) in degrees, exact also where it is small."""
    return float(_angles(a, [b])[0])


def spread_deg(directions: npt.ArrayLike) -> float:
    """Return the largest angle between two of the directions (n, 3), n from 1, degrees."""
    e = _units(directions)
    return max(float(_angles(row, e).max()) for row in e)


def _angles(a: npt.ArrayLike, rows: Sequence[npt.ArrayLike] | FloatArray) -> FloatArray:
    """Angles between a vector and each of the rows, degrees."""
    one, many = np.asarray(a, dtype=np.float64), np.asarray(rows, dtype=np.float64).reshape(-1, 3)
    return np.asarray(np.degrees(np.arctan2(np.linalg.norm(np.cross(many, one), axis=1), many @ one)))


def coverage_deg(directions: npt.ArrayLike) -> float:
    """Return half the opening (degrees) of the narrowest cone that holds all directions (n, 3), n from 1.

    The cone of a few of them is found exactly; as long as directions lie outside, the farthest of these join the few.
    Should it take more than 20, as positions all around may, it is the cone of those: at least as narrow.
    """
    e = _units(directions)
    few = np.zeros(1, dtype=int)
    while True:
        axis, least = _narrowest(e[few])
        along = e @ axis
        along[few] = np.inf
        farthest = np.argsort(along)[: len(few)]
        outside = farthest[along[farthest] < least]
        if not len(outside) or len(few) + len(outside) > MOST_EXACT:
            return float(np.degrees(np.arccos(np.clip(least, -1.0, 1.0))))
        few = np.concatenate([few, outside])


def _narrowest(e: FloatArray) -> tuple[FloatArray, float]:
    """The axis u whose smallest u·e is largest, and that: midway between two, or as far from one as from two others."""
    axes = _axes(e)
    smallest = (axes @ e.T).min(axis=1)
    best = int(smallest.argmax())
    return axes[best], float(smallest[best])


def _axes(e: FloatArray) -> FloatArray:
    """All axes that the narrowest cone can have: directions, those midway between two, normals through three."""
    pairs, triples = (np.array(list(combinations(range(len(e)), k)), dtype=int).reshape(-1, k) for k in (2, 3))
    a, b, c = np.moveaxis(e[triples], 1, 0)
    across = np.cross(e[:, np.newaxis], np.eye(3)).reshape(-1, 3)  # for opposite directions, which have no middle
    between = np.vstack([e[pairs].sum(axis=1), np.cross(b - a, c - a), np.cross(c - a, b - a), across])
    lengths = np.linalg.norm(between, axis=1, keepdims=True)
    longer = lengths[:, 0] > SHORTEST
    return np.vstack([e, between[longer] / lengths[longer]])


def _units(vectors: npt.ArrayLike) -> FloatArray:
    rows = as_rows(vectors, "directions")
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    if not len(rows) or not lengths.all():
        raise CalibrationError("a position without specific force has no direction (free fall, or no data)")
    return np.asarray(rows / lengths)


def different(directions: npt.ArrayLike, apart_deg: float = SAME_DEG) -> int:
    """Return how many directions are left if those closer than ``apart_deg`` to one that counts do not count."""
    e = _units(directions)
    near = e @ e.T > np.cos(np.radians(apart_deg))
    counted: list[int] = []
    for index in range(len(e)):
        if not near[index, counted].any():
            counted.append(index)
    return len(counted)


def missing_faces(directions: npt.ArrayLike, within_deg: float = UNSEEN_DEG) -> tuple[str, ...]:
    """Return the axes (``"+x"``: x up) that are farther than ``within_deg`` from every direction."""
    e, limit = _units(directions), as_number(within_deg, "within_deg")
    nearest = np.degrees(np.arccos(np.clip((np.array(list(FACES.values())) @ e.T).max(axis=1), -1.0, 1.0)))
    return tuple(face for face, angle in zip(FACES, nearest, strict=True) if angle > limit)
