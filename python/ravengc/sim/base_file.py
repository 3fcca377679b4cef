"""Base motions in files: a table of poses or of an inertial sensor's samples, ``.csv`` or ``.npz``.

``.csv``: a line of names, then rows of numbers with commas between; lines that start with ``#`` are comments, though
the names may stand behind one. Columns, in any order:

    t                                            s
    x y z                                        m, the position of the base origin; zero if left out
    qw qx qy qz  or  roll pitch yaw (_deg)       orientation: a unit quaternion, or R = Rx(roll) Ry(pitch) Rz(yaw)
    fx fy fz wx wy wz                            instead of a pose: specific force (m/s^2), angular velocity (rad/s)

``.npz``: the same names as arrays, or ``position`` (k, 3), ``quaternion`` (k, 4), ``specific_force`` (k, 3),
``angular_velocity`` (k, 3).
"""

from __future__ import annotations

import warnings
import zipfile
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_array, as_path
from ravengc.errors import ArgumentError, ParseError
from ravengc.messages import listed
from ravengc.sim.base_recorded import recorded, recorded_imu
from ravengc.sim.hinges import rotations

if TYPE_CHECKING:
    import os
    from pathlib import Path

    from ravengc.sim.base_profiles import ProfiledBase

__all__ = ["read_recorded"]

Array = NDArray[np.float64]
Columns = dict[str, Array]

LARGEST_FILE = 256 * 2**20
GROUPS = {
    "position": ("x", "y", "z"),
    "quaternion": ("qw", "qx", "qy", "qz"),
    "angles": ("roll", "pitch", "yaw"),
    "angles_deg": ("roll_deg", "pitch_deg", "yaw_deg"),
    "specific_force": ("fx", "fy", "fz"),
    "angular_velocity": ("wx", "wy", "wz"),
}
EXPECTED = "t with qw,qx,qy,qz or roll,pitch,yaw (and x,y,z), or t with fx,fy,fz,wx,wy,wz"


def read_recorded(path: str | os.PathLike[str]) -> ProfiledBase:
    """Read a base motion from a file as this module describes; ParseError, with file and line, where it is none."""
    source = as_path(path, "path")
    _refuse(source)
    columns = _archive(source) if source.suffix.lower() == ".npz" else _table(source)
    try:
        return _motion(columns, source)
    except ArgumentError as error:
        raise ParseError(f"not a motion of a base: {error}", file=str(source)) from error


def _motion(columns: Columns, source: Path) -> ProfiledBase:
    groups = {name: group for name in GROUPS if (group := _group(columns, name)) is not None}
    what = f"recorded in {source.name}"
    if "t" in columns and "specific_force" in groups and "angular_velocity" in groups:
        force, rate = groups["specific_force"], groups["angular_velocity"]
        return recorded_imu(columns["t"], force, rate, description=what)
    turned = next((name for name in ("quaternion", "angles", "angles_deg") if name in groups), None)
    if "t" not in columns or turned is None:
        raise ParseError(f"columns {listed(columns)}; expected {EXPECTED}", file=str(source))
    rotation = _rotations(turned, groups[turned])
    return recorded(columns["t"], groups.get("position", np.zeros((len(rotation), 3))), rotation, description=what)


def _group(columns: Columns, name: str) -> Array | None:
    if name in columns:
        return columns[name]
    parts = [columns[part] for part in GROUPS[name] if part in columns]
    return np.stack(parts, axis=-1) if len(parts) == len(GROUPS[name]) else None


def _rotations(kind: str, values: Array) -> Array:
    """Rotation matrices (k, 3, 3) of unit quaternions (k, 4), or of angles (k, 3) in rad or deg."""
    if values.ndim != 2 or values.shape[1] != (4 if kind == "quaternion" else 3):
        raise ArgumentError(f"{kind} has shape {values.shape}; expected a row of {len(GROUPS[kind])} for each time")
    if kind == "quaternion":
        return _of_quaternions(values)
    angles = np.deg2rad(values) if kind == "angles_deg" else values
    first, second, third = (rotations(angles[:, i : i + 1] * np.eye(3)[i]) for i in range(3))
    return first @ second @ third


def _of_quaternions(values: Array) -> Array:
    length = np.linalg.norm(values, axis=1)
    if wrong := np.flatnonzero(~(np.abs(length - 1.0) <= 0.01)).tolist():
        raise ArgumentError(f"quaternion {wrong[0]} has the length {length[wrong[0]]:g}; expected 1")
    w, x, y, z = (values / length[:, None]).T
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.array(rows).transpose(2, 0, 1)


def _refuse(path: Path) -> None:
    """A pipe could keep the reader waiting for ever, and a huge file fill the memory."""
    if not path.is_file():
        raise ParseError("no such file; expected a .csv or .npz with a base motion", file=str(path))
    size = path.stat().st_size
    if path.suffix.lower() == ".npz" and zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            size = sum(member.file_size for member in archive.infolist())
    if size > LARGEST_FILE:
        raise ParseError(f"{size / 2**20:.0f} MiB; at most {LARGEST_FILE / 2**20:.0f} MiB are read", file=str(path))


def _archive(path: Path) -> Columns:
    try:
        with path.open("rb") as file, warnings.catch_warnings(action="ignore"):
            loaded = np.load(file, allow_pickle=False)
            arrays = {name: loaded[name] for name in loaded.files}
    except Exception as error:  # damage surfaces as any error of the archive, its compression or NumPy's header
        raise ParseError(f"not a readable NumPy archive: {error or type(error).__name__}", file=str(path)) from error
    known = {"t", *GROUPS, *(part for parts in GROUPS.values() for part in parts)}
    try:
        return {name: as_array(array, name).astype(np.float64) for name, array in arrays.items() if name in known}
    except ArgumentError as error:
        raise ParseError(str(error), file=str(path)) from error


def _table(path: Path) -> Columns:
    names: list[str] = []
    rows: list[list[float]] = []
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ParseError(f"not UTF-8 text near byte {error.start}", file=str(path)) from error
    for number, line in enumerate(lines, start=1):
        cells = [cell.strip() for cell in line.lstrip("# ").split(",")]
        if not names and "t" in cells:
            names = cells
        elif line.strip() and not line.startswith("#"):
            rows.append(_numbers(cells, names, path, number))
    table = np.array(rows).reshape(len(rows), len(names))
    return {name: table[:, place] for place, name in enumerate(names)}


def _numbers(cells: list[str], names: list[str], path: Path, number: int) -> list[float]:
    if not names:
        raise ParseError(f"no line of names before the numbers; expected {EXPECTED}", file=str(path), line=number)
    if len(cells) != len(names):
        raise ParseError(f"{len(cells)} cells, expected {len(names)}", file=str(path), line=number)
    try:
        return [float(cell) for cell in cells]
    except ValueError as error:
        raise ParseError(f"a cell is no number: {error}", file=str(path), line=number) from error
