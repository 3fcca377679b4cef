"""Read a recording from a NumPy archive.

It holds t (samples,), q and, where recorded, qd, qdd, tau (samples, joints), and of the base gravity or
specific_force, and angular_velocity (samples, 3), or ax, ay, az and so on as in a table. The names in
:data:`ravengc.recordings.columns.KEYS` are accepted for each; ``names`` or ``joint_names`` may hold the joints' names.
Pickled objects are refused.
"""

from __future__ import annotations

import warnings
import zipfile
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ravengc.errors import ConfigError, ParseError
from ravengc.messages import listed
from ravengc.recordings.base_columns import base_columns
from ravengc.recordings.columns import KEYS
from ravengc.recordings.recording import BASE
from ravengc.recordings.screening import RawTable, check_time, enumerated

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from ravengc.recordings.recording import FloatArray

__all__ = ["read_npz"]

NAME_KEYS = ("names", "joint_names")
BASE_KEYS = (
    ("gravity", -1.0, ("specific_force", "accelerometer", "accel", "linear_acceleration")),
    ("angular_velocity", 1.0, ("gyro", "gyroscope", "gyr", "omega", "w", "angular_rate")),
)
"""Other names for what the base did, (samples, 3), and the factor that makes it that."""


def read_npz(path: Path, *, largest: int, rate_hz: float | None = None) -> RawTable:
    """The table in an .npz archive of at most ``largest`` bytes when unpacked; ``rate_hz`` replaces a missing t.

    Raises ParseError for a damaged archive or an array of the wrong kind, ConfigError for missing arrays and for a rate
    beside a t.
    """
    arrays = _arrays(path, largest)
    found = {role: key for role in (*KEYS, *BASE) if (key := _key_of(role, arrays, str(path)))}
    if "q" not in found:
        raise ConfigError(
            f"{path}: no joint positions; the archive holds {listed(arrays) or 'nothing'}; expected q (samples, joints)"
        )
    values = {role: _numbers(arrays[key], key, str(path)) for role, key in found.items()}
    of_base, their_keys = _of_the_base(
        {key: array for key, array in arrays.items() if key not in found.values()}, str(path)
    )
    values = {**of_base, **values}
    check_time(f"array '{found['t']}'" if "t" in found else None, rate_hz, str(path))
    t = values.pop("t", None)
    for role, array in values.items():
        values[role] = array[:, np.newaxis] if array.ndim == 1 and role not in BASE else array
    table = RawTable(
        file=str(path),
        t=_stamps(path, t, values["q"].shape[0], rate_hz),
        arrays=values,
        names=_names(arrays, values["q"], str(path)),
    )
    used = {*found.values(), *their_keys, *NAME_KEYS}
    if unused := [key for key in arrays if key not in used]:
        table.notes.append(f"arrays not used: {enumerated(unused)}")
    return table


def _of_the_base(arrays: Mapping[str, npt.NDArray[Any]], file: str) -> tuple[dict[str, FloatArray], set[str]]:
    """Gravity and angular velocity under other names, or axis by axis as in a table, and the arrays that hold them."""
    whole = {
        key: (role, sign)
        for role, sign, names in BASE_KEYS
        for key, array in arrays.items()
        if key.lower() in names and array.ndim == 2 and array.shape[1] == 3
    }
    found = {role: sign * _numbers(arrays[key], key, file) for key, (role, sign) in whole.items()}
    single = [key for key, array in arrays.items() if array.ndim == 1 and key not in whole]
    used = set(whole)
    for role, columns in base_columns(single, file=file, line=None).items():
        if role not in found:
            keys = [single[column.place] for column in columns]
            parts = [
                column.factor * _numbers(arrays[key], key, file) for column, key in zip(columns, keys, strict=True)
            ]
            found[role] = _stacked(parts, keys, file)
            used |= set(keys)
    return found, used


def _stacked(parts: list[FloatArray], keys: list[str], file: str) -> FloatArray:
    if len({part.shape for part in parts}) > 1:
        raise ParseError(f"arrays {listed(keys)} differ in length", file=file)
    return np.column_stack(parts)


def _arrays(path: Path, largest: int) -> dict[str, npt.NDArray[Any]]:
    try:
        _refuse_oversized(path, largest)
        with path.open("rb") as file, warnings.catch_warnings(action="ignore"):
            loaded = np.load(file, allow_pickle=False)
            arrays = {key: loaded[key] for key in loaded.files}
    except ParseError:
        raise
    except Exception as error:  # damage surfaces as any error of the archive, its compression or NumPy's header
        raise ParseError(f"not a readable NumPy archive: {error or type(error).__name__}", file=str(path)) from error
    return {key: array for key, array in arrays.items() if isinstance(array, np.ndarray)}  # no member of another kind


def _refuse_oversized(path: Path, largest: int) -> None:
    with zipfile.ZipFile(path) as archive:
        size = sum(member.file_size for member in archive.infolist())
    if size > largest:
        message = f"unpacks to {size / 2**20:.0f} MiB; at most {largest / 2**20:.0f} MiB are read"
        raise ParseError(message, file=str(path))


def _key_of(role: str, arrays: Mapping[str, object], file: str) -> str | None:
    present = [key for key in arrays if key.lower() in KEYS.get(role, (role,))]
    if len(present) > 1:
        raise ParseError(f"several arrays for {role}: {', '.join(present)}; keep one", file=file)
    return present[0] if present else None


def _numbers(array: npt.NDArray[Any], key: str, file: str) -> FloatArray:
    if array.dtype.kind not in "fiu":
        raise ParseError(f"array '{key}' has type {array.dtype}; expected real numbers", file=file)
    if array.ndim == 0:
        raise ParseError(f"array '{key}' is a single number; expected one for every sample", file=file)
    with np.errstate(over="ignore"):  # a longer float beyond the range of float64 becomes infinite
        return np.asarray(array, dtype=np.float64)


def _stamps(path: Path, t: FloatArray | None, samples: int, rate_hz: float | None) -> FloatArray:
    if t is None:
        return np.arange(samples) / (rate_hz or 1.0)
    if t.ndim != 1:
        raise ParseError(f"t has shape {t.shape}; expected (samples,)", file=str(path))
    return t


def _names(arrays: Mapping[str, npt.NDArray[Any]], q: FloatArray, file: str) -> tuple[str, ...]:
    key = next((key for key in NAME_KEYS if key in arrays), None)
    if key is None:
        return ()
    array = arrays[key]
    if array.dtype.kind != "U" or array.ndim != 1:
        raise ParseError(
            f"array '{key}' has type {array.dtype}, shape {array.shape}; expected a list of text", file=file
        )
    names = tuple(str(name) for name in array)
    if q.ndim == 2 and (len(names) != q.shape[1] or len(set(names)) != len(names)):
        raise ParseError(
            f"array '{key}' holds {listed(names)}; expected {q.shape[1]} different names, one per joint", file=file
        )
    return names
