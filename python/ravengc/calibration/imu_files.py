"""Read what an accelerometer measured: a delimited table, a NumPy archive, or a bundled recording.

Tables are read by :mod:`ravengc.sensors.recorded`, which finds the columns by their names. An archive holds ``t`` (n,),
``specific_force`` (n, 3) and, where recorded, ``angular_velocity`` (n, 3). Rows with a missing, non-finite or huge
number and repeated stamps are left out and counted.
"""

from __future__ import annotations

import os
import warnings
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_number, as_path, as_texts, check_choice, check_type
from ravengc.calibration.imu import FORCE_UNITS, FloatArray, ImuRecording
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.messages import did_you_mean, listed
from ravengc.sensors.recorded import read_recording
from ravengc.sensors.units import RATE_UNITS, SENDS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["ReadOptions", "read_imu"]

LARGEST_BYTES = 512 * 2**20
COLUMN_COUNTS = {3: (0, False), 4: (1, False), 6: (0, True), 7: (1, True)}
"""Whether a list of so many columns begins with the time, and ends with the angular velocity."""
TIME_KEYS = ("t", "time")
FORCE_KEYS = ("specific_force", "acceleration", "accelerometer", "linear_acceleration", "acc", "f", "a")
RATE_KEYS = ("angular_velocity", "angular_rate", "gyroscope", "gyro", "w", "omega")


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadOptions:
    """What the file does not say.

    ``unit`` and ``rate_unit``: None as the header has them, else m/s² and rad/s. ``columns`` are the names, or numbers
    from 1, of [time] x y z [wx wy wz]. ``rate_hz`` stands in for a missing time column. ``sends`` is "specific_force"
    (+9.81 upwards at rest) or "gravity". Raises ConfigError for values that are none of these.
    """

    unit: str | None = None
    rate_unit: str | None = None
    columns: Sequence[str] | None = None
    rate_hz: float | None = None
    sends: str = "specific_force"

    def __post_init__(self) -> None:
        """Refuse what no file could be read with."""
        if self.unit is not None:
            check_choice(self.unit, FORCE_UNITS, "unit")
        if self.rate_unit is not None:
            check_choice(self.rate_unit, RATE_UNITS, "rate_unit")
        check_choice(self.sends, SENDS, "sends")
        if self.columns is not None and len(as_texts(self.columns, "columns")) not in COLUMN_COUNTS:
            raise ConfigError(
                f"{len(self.columns)} columns are named; expected 3 (specific force x y z), 4 (time first), 6 (angular "
                "velocity x y z behind) or 7 (both)"
            )
        if self.rate_hz is not None and not 0.0 < as_number(self.rate_hz, "rate_hz") <= LARGEST:
            raise ConfigError(f"the sample rate is {self.rate_hz} Hz; expected a positive number up to {LARGEST:g}")

    def names(self) -> dict[str, str]:
        """Return the columns as the reader of tables takes them."""
        if self.columns is None:
            return {}
        first, has_rate = COLUMN_COUNTS[len(self.columns)]
        names = {"time": "".join(self.columns[:first]), "accelerometer": ",".join(self.columns[first : first + 3])}
        return names | {"gyroscope": ",".join(self.columns[-3:])} if has_rate else names


def read_imu(source: str | os.PathLike[str], options: ReadOptions | None = None) -> ImuRecording:
    """Return the recording in a file (.npz, or a table, which may be gzipped), or in ``example:NAME``.

    Raises ParseError (file, line) for what cannot be read, ConfigError for columns, arrays and units that are not there
    or contradict the header.
    """
    options = ReadOptions() if options is None else options
    check_type(options, ReadOptions, "options")
    name = source if isinstance(source, str) else str(as_path(source, "source"))
    if not name:
        raise ArgumentError("source is empty; expected a file, or example:NAME")
    if Path(name).suffix.lower() == ".npz":
        return _npz(Path(name), options)
    _check_there(name)
    table = read_recording(
        name,
        unit=options.unit or "",
        gyro_unit=options.rate_unit or "",
        sends=options.sends,
        rate_hz=options.rate_hz,
        **options.names(),
    )
    return _screened(
        name, np.multiply(table.time_ns, 1e-9, dtype=np.float64), table.force, table.rate, options, table.skipped
    )


def _check_there(name: str) -> None:
    """Name the file that was probably meant where there is none."""
    path = Path(name)
    try:
        if name.startswith("example:") or "\0" in name or path.exists() or not path.parent.is_dir():
            return
        near = did_you_mean(path.name, os.listdir(path.parent))  # noqa: PTH208 -- names are all that is wanted
    except OSError as error:
        raise ParseError(f"cannot be read: {error.strerror or error}", file=name) from error
    raise ParseError(f"no such file{near}", file=name)


def _npz(path: Path, options: ReadOptions) -> ImuRecording:
    arrays = _arrays(path)
    t, force, rate = (_array_of(keys, arrays) for keys in (TIME_KEYS, FORCE_KEYS, RATE_KEYS))
    if force is None:
        found = f"the archive holds {listed(arrays) or 'nothing'}"
        raise ConfigError(f"{path}: no specific force; expected specific_force (n, 3); {found}")
    if t is None and options.rate_hz is None:
        raise ConfigError(f"{path}: no stamps t; say how many samples there are per second")
    stamps = _grid(len(force), options.rate_hz or 1.0) if t is None else t
    shapes = [array.shape for array in (stamps, force, rate) if array is not None]
    if shapes != [stamps.shape[:1], *[(len(stamps), 3)] * (len(shapes) - 1)]:
        expected = "expected (n,) stamps and (n, 3) numbers"
        raise ParseError(f"arrays of shape {', '.join(map(str, shapes))}; {expected}", file=str(path))
    factor = FORCE_UNITS[options.unit or "m/s^2"] * SENDS[options.sends]
    turned = None if rate is None else rate * RATE_UNITS[options.rate_unit or "rad/s"]
    return _screened(str(path), stamps, force * factor, turned, options, 0)


def _grid(samples: int, rate_hz: float) -> FloatArray:
    return np.asarray(np.arange(samples) / rate_hz, dtype=np.float64)


def _arrays(path: Path) -> dict[str, Any]:
    """The arrays of an archive, which must not unpack to more than may be read; no pickles."""
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(member.file_size for member in archive.infolist())
        if size <= LARGEST_BYTES:
            with path.open("rb") as file, warnings.catch_warnings(action="ignore"):
                loaded = np.load(file, allow_pickle=False)
                return {key: array for key in loaded.files if isinstance(array := loaded[key], np.ndarray)}
    except OSError as error:
        raise ParseError(f"cannot be read: {error.strerror or error}", file=str(path)) from error
    except Exception as error:  # damage surfaces as any error of the archive, its compression or NumPy's header
        raise ParseError(f"not a readable NumPy archive: {error or type(error).__name__}", file=str(path)) from error
    raise ParseError(f"unpacks to {size / 2**20:.0f} MiB; at most {LARGEST_BYTES / 2**20:.0f} are read", file=str(path))


def _array_of(keys: Sequence[str], arrays: Mapping[str, Any]) -> FloatArray | None:
    for key, array in arrays.items():
        if key.lower() in keys and array.dtype.kind in "fiu" and array.ndim:
            return np.asarray(array, dtype=np.float64)
    return None


def _screened(
    source: str, stamps: FloatArray, force: FloatArray, rate: FloatArray | None, options: ReadOptions, skipped: int
) -> ImuRecording:
    """Leave out rows that cannot be used, and count them; refuse time that runs backwards."""
    with np.errstate(invalid="ignore"):
        t = stamps - next(iter(stamps[np.isfinite(stamps)]), 0.0)
        table = np.column_stack([t, force, *([] if rate is None else [rate])])
        usable = np.flatnonzero((np.abs(table) <= LARGEST).all(axis=1))
    steps = np.diff(t[usable], prepend=-np.inf)
    if (steps < 0.0).any():
        row = usable[int((steps < 0.0).argmax())] + 1
        raise ParseError(f"time runs backwards at sample {row}; cut the recording there", file=source)
    kept = usable[steps > 0.0]
    left_out = {
        "row that is no row of numbers": skipped,
        "missing, non-finite or huge number": len(t) - len(usable),
        "repeated stamp": len(usable) - len(kept),
    }
    return ImuRecording(
        t=t[kept],
        specific_force=force[kept],
        angular_velocity=None if rate is None else rate[kept],
        unit=options.unit or "m/s^2",
        source=source,
        notes=tuple(f"left out: {count} x {reason}" for reason, count in left_out.items() if count),
    )
