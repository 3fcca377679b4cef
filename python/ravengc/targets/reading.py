"""Read a cloud of points from a file: PLY, or rows of numbers (XYZ, CSV, TXT, PTS)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_count, as_vector, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ParseError
from ravengc.messages import listed
from ravengc.targets.cloud import UPWARDS, Cloud, RawCloud, cleaned, with_normals
from ravengc.targets.columns import find_columns, found_in
from ravengc.targets.files import CLOUDS, file_at, read_file
from ravengc.targets.lengths import LENGTH_UNITS, unit_in, unit_of
from ravengc.targets.ply import read_ply
from ravengc.targets.table import Table, read_table
from ravengc.targets.thinning import evenly
from ravengc.targets.words import left_unused

if TYPE_CHECKING:
    import os
    from collections.abc import Sequence
    from pathlib import Path

__all__ = ["read_cloud"]

Array = NDArray[np.float64]

SIZES = (2.0, 20.0)
"""A cloud for an arm is no more than so many metres across, and no fewer millimetres."""
UNIT_LENGTHS = (0.9, 1.1)
FEWEST_COUNTED = 4


def read_cloud(
    source: str | os.PathLike[str],
    *,
    units: str | None = None,
    most: int | None = None,
    facing: Sequence[float] = UPWARDS,
    strict: bool = False,
) -> Cloud:
    """Return the cloud in a .ply file or a table of x y z [nx ny nz], or ``example:NAME``; at most ``most`` points.

    ``units`` ("m", "cm", "mm") overrules what the size suggests. Points without finite coordinates and repeated ones
    are left out; missing, zero and non-finite normals are estimated from the neighbours and end on the side of
    ``facing`` (3,) where no neighbour has one; ``strict`` refuses all that instead. What was done stands in the
    cloud's notes. Raises ParseError (file, line), ConfigError (units), ArgumentError.
    """
    check_type(strict, bool, "strict")
    if units is not None:
        check_type(units, str, "units")
    count = None if most is None else as_count(most, "most", 1)
    side = as_vector(facing, "facing", 3, LARGEST)
    if not side.any():
        raise ArgumentError("facing is (0, 0, 0); expected the direction in which normals point")
    path = file_at(source, CLOUDS, "cloud")
    raw = cleaned(_in_metres(_raw(path), units), strict=strict)
    rows = np.arange(len(raw.points)) if count is None else evenly(raw.points, count)
    if len(rows) < len(raw.points):
        raw = raw.noted(f"{len(rows)} of {len(raw.points)} points are kept, spread evenly")
    return with_normals(raw, rows, facing=side, strict=strict)


def _raw(path: Path) -> tuple[RawCloud, str | None]:
    """The numbers as they stand in the file, and the unit that the file states."""
    data = read_file(path)
    if path.suffix.lower() == ".ply" or data.startswith((b"ply\n", b"ply\r")):
        found = read_ply(data, path)
        normals = found.numbers[:, 3:] if found.numbers.shape[1] == 6 else None
        return RawCloud(found.numbers[:, :3], normals, found.lines, str(path), ()), unit_in(found.comments)
    table = read_table(data, path, "a table of numbers (XYZ, CSV, TXT) or a PLY file")
    return _of_named(table, path) if table.names else _of_unnamed(table, path)


def _of_named(table: Table, path: Path) -> tuple[RawCloud, str | None]:
    found = find_columns(table.names, str(path))
    if missing := [axis for axis in "xyz" if axis not in found]:
        message = f"no column {', '.join(missing)} (columns: {listed(table.names)}); expected x,y,z or x,y,z,nx,ny,nz"
        raise ParseError(message, file=str(path), line=None)
    points = table.numbers[:, [found[axis].place for axis in "xyz"]]
    axes = ("nx", "ny", "nz")
    has_normals = all(axis in found for axis in axes)
    normals = table.numbers[:, [found[axis].place for axis in axes]] if has_normals else None
    raw = RawCloud(points, normals, table.lines, str(path), ())
    return raw, found_in(found, str(path)) or unit_in(table.comments)


def _of_unnamed(table: Table, path: Path) -> tuple[RawCloud, str | None]:
    """Columns without names: x y z first, then, behind them or at the end, three that are normals."""
    width = table.numbers.shape[1]
    if width < 3:
        message = f"{width} numbers in a row; expected x y z, or x y z nx ny nz"
        raise ParseError(message, file=str(path), line=int(table.lines[0]))
    if width > 3 and _is_count(table.numbers[:, 0]):
        message = "the first column counts the rows; leave it out, or put names above the columns (such as i x y z)"
        raise ParseError(message, file=str(path), line=int(table.lines[0]))
    starts = [place for place in (3, width - 3) if place >= 3 and _are_normals(table.numbers[:, place : place + 3])]
    if width == 6 and not _are_colours(table.numbers[:, 3:]):
        starts = [3]
    start = starts[0] if starts else 0
    normals = table.numbers[:, start : start + 3] if start else None
    unused = width - (6 if start else 3)
    notes = (left_unused(unused),) if unused else ()
    return RawCloud(table.numbers[:, :3], normals, table.lines, str(path), notes), unit_in(table.comments)


def _is_count(column: Array) -> bool:
    """Tell whether these are whole numbers one after the other, from 0 or 1 on."""
    return len(column) >= FEWEST_COUNTED and bool(
        (column == column[0] + np.arange(len(column))).all() and column[0] in {0.0, 1.0}
    )


def _are_normals(three: Array) -> bool:
    """Tell whether most rows are of unit length, and the others mostly zero or missing."""
    if three.shape[1] < 3:
        return False
    with np.errstate(all="ignore"):
        length = np.linalg.norm(three, axis=1)
    low, high = UNIT_LENGTHS
    return bool(np.mean((length > low) & (length < high)) > 0.5)


def _are_colours(three: Array) -> bool:
    """Tell whether all numbers are whole ones up to 255, and not just zeros and ones."""
    return bool((np.isin(three, np.arange(256.0))).all() and three.max() > 1.0 and len(three) > 1)


def _in_metres(found: tuple[RawCloud, str | None], given: str | None) -> RawCloud:
    raw, stated = found
    usable = raw.points[(np.abs(raw.points) <= LARGEST).all(axis=1)]
    if not len(usable):
        raise ParseError("no point with three finite coordinates", file=raw.file)
    across = float(np.linalg.norm(np.ptp(usable, axis=0)))
    what = "the cloud's diagonal" if across else "the point's distance from the origin"
    size = across or float(np.linalg.norm(usable[0]))
    unit = unit_of(size, given, stated, what=f"{raw.file}: {what}", between=SIZES)
    scaled = RawCloud(raw.points * LENGTH_UNITS[unit], raw.normals, raw.lines, raw.file, raw.notes)
    if given is not None or stated is not None:
        return scaled
    how = f"{size * LENGTH_UNITS[unit]:.3g} m {'across' if across else 'from the origin'}"
    return scaled.noted(f"lengths are taken as {unit}: the cloud is {how}")
