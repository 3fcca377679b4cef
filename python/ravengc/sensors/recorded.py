"""A recording of an inertial sensor, read whole from delimited text: which column is what, in which unit.

Columns are found by their header, as most loggers write it: ``Accelerometer X (g)``, ``acc_x [m/s^2]``, ``ax``,
``linear_acceleration.x``, ``Gyroscope X (deg/s)``, ``Time (s)``, ``t_us``; or they are named. A row that is no row of
numbers is left out and counted, an empty cell is NaN. Files may be gzipped.
"""

from __future__ import annotations

import gzip
import re
import zlib
from array import array
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import check_choice
from ravengc.errors import ConfigError, ParseError
from ravengc.inertial_units import name_and_unit
from ravengc.messages import did_you_mean, listed, shown
from ravengc.sensors.units import ACCELERATION_UNITS, RATE_UNITS, SENDS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

__all__ = ["EXAMPLES", "Recording", "example_path", "near_file", "read_recording"]

Array = NDArray[np.float64]

EXAMPLES = {"xio": "xio_imu/sensor_data.csv.gz"}
PREFIX = "example:"
LARGEST_TEXT = 512 * 2**20
DELIMITERS = (";", "\t", ",")
LONGEST_LINE = 65536
TIME_UNITS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}
NAMES = {
    "force": r"acc|accel|accelerometer|acceleration|linear[ _]acceleration|specific[ _]force|a|f",
    "rate": r"gyr|gyro|gyroscope|angular[ _](?:velocity|rate)|g|w|omega",
}
TIME = re.compile(r"(?:t|time|timestamp|stamp)(?:_(?P<suffix>ns|us|ms|s))?", re.IGNORECASE)


class Column(NamedTuple):
    """Where a number stands in a row, and the unit its header names, "" if none."""

    place: int
    unit: str


class Layout(NamedTuple):
    """The columns of time, specific force and angular velocity."""

    time: Column | None
    force: tuple[Column, ...]
    rate: tuple[Column, ...]


@dataclass(frozen=True, slots=True)
class Recording:
    """Samples in the order they were recorded: ``time_ns`` (n,) from the first on, ``force`` (n, 3) m/s^2, specific.

    ``rate`` (n, 3) rad/s, or None without a gyroscope. ``skipped`` counts rows that could not be read.
    """

    file: str
    time_ns: NDArray[np.int64]
    force: Array
    rate: Array | None
    skipped: int


@dataclass(slots=True)
class _Rows:
    """The numbers of all rows, one after the other."""

    width: int
    places: list[int]
    numbers: array[float] = field(default_factory=lambda: array("d"))
    skipped: int = 0

    def add(self, cells: Sequence[str]) -> None:
        if len(cells) != self.width:
            self.skipped += 1
            return
        try:
            row = [float(cells[place].strip() or "nan") for place in self.places]
        except ValueError:
            self.skipped += 1
            return
        self.numbers.extend(row)


def example_path(name: str) -> Path:
    """Where the bundled recording ``name`` lies; ConfigError for an unknown name."""
    check_choice(name, EXAMPLES, "bundled sensor recording")
    return Path(__file__).parent.parent / "examples" / EXAMPLES[name]


def read_recording(
    source: str,
    *,
    unit: str = "",
    fallback_unit: str = "m/s^2",
    gyro_unit: str = "",
    sends: str = "specific_force",
    time: str = "",
    accelerometer: str = "",
    gyroscope: str = "",
    rate_hz: float | None = None,
) -> Recording:
    """The recording in a file or ``example:NAME``.

    ``unit`` and ``gyro_unit`` say what the header does not, and must not contradict it; where neither does, it is
    ``fallback_unit`` and rad/s. ``time``, ``accelerometer`` and ``gyroscope`` name the columns (one, and three with
    commas), by header or by number from 1. ``rate_hz`` gives the times where there is no column of them. Raises
    ParseError (file, line) for what cannot be read and ConfigError for settings that do not fit.
    """
    lines = _lines(_existing(source), source)
    header, number = _header(lines, source)
    layout = _layout(header, (time, accelerometer, gyroscope), f"{source}:{number}")
    scales = _scales(layout, (unit, fallback_unit), gyro_unit, SENDS[sends], source)
    rows = _Rows(len(header), [column.place for column in _used(layout)])
    for _, cells in lines:
        rows.add(cells)
    with np.errstate(over="ignore"):  # what becomes infinite is looked at below, or by the gate
        table = np.frombuffer(rows.numbers).reshape(-1, len(rows.places)) * scales
    return _recording(source, table, layout, rows.skipped, rate_hz)


def _existing(source: str) -> Path:
    path = example_path(source.removeprefix(PREFIX)) if source.startswith(PREFIX) else Path(source)
    if path.is_file():
        return path
    raise ParseError("not a file" if path.exists() else f"no such file{near_file(source)}", file=source)


def near_file(path: str) -> str:
    """What a path that leads nowhere may have meant: a file beside it, or one in the user's folder."""
    try:
        if path.startswith("~"):  # no shell replaces it in the middle of a word, as behind a colon
            return f"; did you mean {str(Path(path).expanduser())!r}?"
        return did_you_mean(Path(path).name, [entry.name for entry in Path(path).parent.iterdir()])
    except (OSError, ValueError, RuntimeError):
        return ""


def _used(layout: Layout) -> tuple[Column, ...]:
    return (*(() if layout.time is None else (layout.time,)), *layout.force, *layout.rate)


def _recording(source: str, table: Array, layout: Layout, skipped: int, rate_hz: float | None) -> Recording:
    if len(table) == 0:
        raise ParseError("no row of numbers below the header", file=source)
    start = 0 if layout.time is None else 1
    if layout.time is not None:
        times = _times(table[:, 0], source)
    elif rate_hz:
        times = np.round(np.arange(len(table)) * (1e9 / rate_hz)).astype(np.int64)
    else:
        raise ConfigError(f"{source}: there is no column of times; give time=COLUMN or rate=HZ")
    force, rate = table[:, start : start + 3], table[:, start + 3 :]
    return Recording(source, times, force, rate if layout.rate else None, skipped)


def _times(nanoseconds: Array, source: str) -> NDArray[np.int64]:
    since = nanoseconds - nanoseconds[0]
    if not np.isfinite(since).all() or np.abs(since).max() > 2.0**62:
        raise ParseError("a time that is missing or not finite", file=source)
    times: NDArray[np.int64] = np.round(since).astype(np.int64)
    return times


def _lines(path: Path, source: str) -> Iterator[tuple[int, list[str]]]:
    """Numbered rows of cells, cut at the first delimiter that the header has; empty lines and comments left out."""
    delimiter, size = "", 0
    try:
        with gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb") as file:
            for number in range(1, LARGEST_TEXT):
                line = file.readline(LONGEST_LINE)
                size += len(line)
                if not line:
                    return
                if size > LARGEST_TEXT:
                    raise ParseError(f"more than {LARGEST_TEXT // 2**20} MiB of text; cut it into parts", file=source)
                text = line.decode("utf-8-sig" if number == 1 else "utf-8", "replace").strip()
                if not text or text.startswith("#"):
                    continue
                delimiter = delimiter or next((mark for mark in DELIMITERS if mark in text), ",")
                yield number, text.split(delimiter)
    except (OSError, EOFError, zlib.error, ValueError) as error:
        raise ParseError(f"cannot be read: {getattr(error, 'strerror', None) or error}", file=source) from error


def _header(lines: Iterator[tuple[int, list[str]]], source: str) -> tuple[list[str], int]:
    for number, cells in lines:
        return [" ".join(cell.strip().strip('"').split()) for cell in cells], number
    raise ParseError("empty; expected a header and rows of numbers", file=source)


def _layout(header: list[str], named: tuple[str, str, str], where: str) -> Layout:
    time, force, rate = named
    return Layout(
        _column(time, header, where) if time else _find_time(header),
        _three(force, header, where) if force else _find(header, "force", where),
        _three(rate, header, where) if rate else _find(header, "rate", where),
    )


def _column(name: str, header: list[str], where: str) -> Column:
    """A column by its header, with or without the unit, or by its number from 1."""
    plain = [name_and_unit(cell)[0] for cell in header]
    if name.isdecimal() and 1 <= int(name) <= len(header):
        place = int(name) - 1
    elif name in header or name in plain:
        place = header.index(name) if name in header else plain.index(name)
    else:
        near = did_you_mean(name, header)
        raise ConfigError(f"{where}: no column {shown(name)}{near} (columns: {listed(header)}, or 1 to {len(header)})")
    return Column(place, name_and_unit(header[place])[1])


def _three(names: str, header: list[str], where: str) -> tuple[Column, ...]:
    columns = tuple(_column(name.strip(), header, where) for name in names.split(","))
    if len(columns) != 3:
        raise ConfigError(f"{where}: {shown(names)} names {len(columns)} columns; expected three: x,y,z")
    return columns


def _find_time(header: list[str]) -> Column | None:
    for place, cell in enumerate(header):
        name, unit = name_and_unit(cell)
        if match := TIME.fullmatch(name):
            return Column(place, unit or match["suffix"] or "s")
    return None


def _find(header: list[str], role: str, where: str) -> tuple[Column, ...]:
    """The columns x, y, z of one quantity; none of them, for an angular velocity alone, is well."""
    found: dict[str, Column] = {}
    for place, cell in enumerate(header):
        name, unit = name_and_unit(cell)
        match = re.fullmatch(rf"(?:.*[/.:])?(?:{NAMES[role]})[ ._]?(?P<axis>[xyz])", name, re.IGNORECASE)
        if match:
            found.setdefault(match["axis"].lower(), Column(place, unit))
    if set(found) == set("xyz"):
        return tuple(found[axis] for axis in "xyz")
    if found or role == "force":
        raise ParseError(
            f"no columns {role} x, y, z among {listed(header)}; name them: --columns X Y Z, or behind the address of a"
            f" sensor {'acc' if role == 'force' else 'gyro'}=X,Y,Z",
            file=where,
        )
    return ()


def _scales(layout: Layout, unit: tuple[str, str], gyro_unit: str, sign: float, source: str) -> Array:
    """A factor for every column that is used."""
    scales = [] if layout.time is None else [_factor(layout.time, TIME_UNITS, "", "s", source)]
    scales += [sign * _factor(column, ACCELERATION_UNITS, *unit, source) for column in layout.force]
    scales += [_factor(column, RATE_UNITS, gyro_unit, "rad/s", source) for column in layout.rate]
    return np.array(scales)


def _factor(column: Column, known: dict[str, float], given: str, default: str, source: str) -> float:
    if given and column.unit and given != column.unit:
        raise ConfigError(f"{source}: column {column.place + 1} is in {column.unit} by its header, not in {given}")
    check_choice(column.unit or given or default, known, f"{source}: unit of column {column.place + 1}:")
    return known[column.unit or given or default]
