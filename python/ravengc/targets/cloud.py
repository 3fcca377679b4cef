"""A cloud of points with normals, and what it takes to make one of the rows of a file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_count, as_vector
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ParseError
from ravengc.sim.hinges import rotations
from ravengc.targets.normals import estimated_normals
from ravengc.targets.thinning import evenly, first_of_each
from ravengc.targets.words import left_out

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Cloud", "RawCloud", "cleaned", "with_normals"]

Array = NDArray[np.float64]

SHORTEST_NORMAL = 1e-6
STRAIGHT = 1e-12
"""Sine of the angle below which two directions are the same, or opposite."""
SUPPORT = 20_000
"""As many points of a larger cloud give normals to the others."""
UPWARDS = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Cloud:
    """``points`` (n, 3), m, and unit ``normals`` (n, 3), in the axes of the file or, once placed, of the robot's base.

    ``notes`` says in sentences what was taken for granted, left out or estimated.
    """

    points: Array
    normals: Array
    name: str
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    @property
    def middle(self) -> Array:
        """The middle of the box around the points, m."""
        middle: Array = 0.5 * (self.points.min(axis=0) + self.points.max(axis=0))
        return middle

    def placed(self, at: Sequence[float] | None = None, turn_deg: Sequence[float] = (0.0, 0.0, 0.0)) -> Cloud:
        """Return the cloud turned about its middle by roll, pitch, yaw (Rx Ry Rz), its middle then ``at`` (3,), m."""
        angles = np.deg2rad(as_vector(turn_deg, "turn_deg", 3, LARGEST))
        x, y, z = (rotations(angles[i : i + 1, None] * np.eye(3)[i])[0] for i in range(3))
        middle = self.middle
        to = middle if at is None else as_vector(at, "at", 3, LARGEST)
        rotation = x @ y @ z
        return replace(self, points=(self.points - middle) @ rotation.T + to, normals=self.normals @ rotation.T)

    def faced(self, towards: Sequence[float]) -> Cloud:
        """Return the cloud turned about its middle, the shortest way, until its mean normal points ``towards`` (3,)."""
        target = as_vector(towards, "towards", 3, LARGEST)
        mean = self.normals.mean(axis=0)
        if not target.any() or not mean.any():
            raise ArgumentError("a direction of length zero; expected one to turn to, and normals with a mean")
        rotation = _shortest_turn(mean / np.linalg.norm(mean), target / np.linalg.norm(target))
        middle = self.middle
        points = (self.points - middle) @ rotation.T + middle
        return replace(self, points=points, normals=self.normals @ rotation.T)

    def thinned(self, most: int) -> Cloud:
        """Return at most ``most`` of the points, spread evenly; says so in its notes."""
        count = as_count(most, "most", 1)
        if len(self) <= count:
            return self
        kept = evenly(self.points, count)
        note = f"{len(kept)} of {len(self)} points are kept, spread evenly"
        return replace(self, points=self.points[kept], normals=self.normals[kept], notes=(*self.notes, note))


def _shortest_turn(start: Array, end: Array) -> Array:
    """The rotation (3, 3) that leads from one unit vector to another about the axis across both."""
    across = np.cross(start, end)
    size = float(np.linalg.norm(across))
    if size < STRAIGHT:
        across, size = np.cross(start, np.eye(3)[np.abs(start).argmin()]), 1.0
        across /= np.linalg.norm(across)
    angle = float(np.arctan2(np.linalg.norm(np.cross(start, end)), start @ end))
    turn: Array = rotations((across / size * angle)[None, :])[0]
    return turn


@dataclass(frozen=True, eq=False)
class RawCloud:
    """What a file holds: ``points`` (n, 3), m; ``normals`` (n, 3) or None; ``lines`` (n,) of a text; notes so far."""

    points: Array
    normals: Array | None
    lines: NDArray[np.int64] | None
    file: str
    notes: tuple[str, ...]

    def noted(self, *notes: str) -> RawCloud:
        """Return the same with more notes."""
        return replace(self, notes=(*self.notes, *notes))

    def keep(self, rows: NDArray[np.int64] | NDArray[np.bool_], *notes: str) -> RawCloud:
        """Return these rows."""
        normals = None if self.normals is None else self.normals[rows]
        lines = None if self.lines is None else self.lines[rows]
        return replace(self, points=self.points[rows], normals=normals, lines=lines, notes=(*self.notes, *notes))

    def line(self, row: int) -> int | None:
        """Return the line of a row, where there are lines."""
        return None if self.lines is None else int(self.lines[row])

    def fault(self, what: str, row: int) -> ParseError:
        """Return an error at a row: its line, or else its number."""
        line = self.line(row)
        return ParseError(what if line else f"point {row + 1}: {what}", file=self.file, line=line)


def cleaned(raw: RawCloud, *, strict: bool) -> RawCloud:
    """Return the points that are some, each once; ``strict`` refuses a file with others. ParseError if none is left."""
    usable = np.abs(raw.points).max(axis=1) <= LARGEST  # false for NaN
    if strict and not usable.all():
        raise raw.fault("a coordinate is missing, not finite or beyond 1e9", int(np.argmin(usable)))
    raw = raw.keep(usable, *_noted(int((~usable).sum()), "without three finite coordinates"))
    if not len(raw.points):
        raise ParseError("no point with three finite coordinates", file=raw.file)
    first = first_of_each(raw.points)
    if strict and len(first) < len(raw.points):
        again = np.setdiff1d(np.arange(len(raw.points)), first)[0]
        raise raw.fault("the same point as one before", int(again))
    return raw.keep(first, *_noted(len(raw.points) - len(first), "repeating another"))


def _noted(count: int, which: str) -> tuple[str, ...]:
    return (left_out(count, "point", which),) if count else ()


def with_normals(raw: RawCloud, rows: NDArray[np.int64], *, facing: Array, strict: bool) -> Cloud:
    """Return these rows with unit normals: the file's, or estimated from the neighbours among all rows.

    Raises ParseError, with the line, for a point that has no normal and too few neighbours to estimate it, and for any
    without a normal if ``strict``.
    """
    known = _known_normals(raw)
    lacking = rows[~known[rows].any(axis=1)]
    notes = list(raw.notes)
    if lacking.size:
        if strict:
            raise raw.fault("no normal, or one of length zero", int(lacking[0]))
        side = "as those around them" if known.any() else f"towards ({', '.join(f'{x:g}' for x in facing)})"
        known[lacking] = _estimates(raw, known, lacking, facing)
        notes.append(_estimated_note(len(lacking), len(rows), side))
    return Cloud(raw.points[rows], known[rows], raw.file, tuple(notes))


def _known_normals(raw: RawCloud) -> Array:
    """The file's normals at unit length, zeros where it has none."""
    if raw.normals is None:
        return np.zeros_like(raw.points)
    with np.errstate(all="ignore"):
        length = np.linalg.norm(raw.normals, axis=1, keepdims=True)
        usable = np.isfinite(length) & (length > SHORTEST_NORMAL)
        unit: Array = np.where(usable, raw.normals / length, 0.0)
    return unit


def _estimates(raw: RawCloud, known: Array, lacking: NDArray[np.int64], facing: Array) -> Array:
    support = evenly(raw.points, SUPPORT)
    found = estimated_normals(raw.points[lacking], raw.points[support], known[support], facing)
    missing = np.isnan(found).any(axis=1)
    if missing.any():
        what = "no normal, and no three neighbours off a line to estimate it from; give it nx, ny, nz"
        raise raw.fault(what, int(lacking[np.argmax(missing)]))
    return found


def _estimated_note(count: int, total: int, side: str) -> str:
    which = "no normals" if count == total else f"{count} of {total} normals are missing or zero"
    return f"{which}: estimated from the nearest points, turned {side}"
