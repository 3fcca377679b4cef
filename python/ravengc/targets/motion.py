"""Read how something moved from a file: a table of t x y z, or an archive; markers, ultrasound, a tracked tool.

A table (.csv, .txt, .tsv) has names above its numbers, such as ``t,x,y,z``, ``time_ms;x_mm;y_mm;z_mm`` or
``Frame;Timestamp;x;y;z``, or is four columns t x y z without; axes that it lacks do not move. An archive (.npz) holds
``t`` (k,), s, and ``displacement`` or ``position`` (k, 3), m unless the caller gives a unit. Units that nothing states
are guessed from the rate and the size, and said so.
"""

from __future__ import annotations

import io
import warnings
import zipfile
from bisect import bisect_right
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc._convert import as_array, as_number, check_type
from ravengc.config.physical import LARGEST
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.messages import listed
from ravengc.targets.columns import TIME_UNITS, Found, find_columns, found_in
from ravengc.targets.files import MOTIONS, file_at, read_file
from ravengc.targets.lengths import LENGTH_UNITS, unit_in, unit_of
from ravengc.targets.table import read_table
from ravengc.targets.words import left_out

if TYPE_CHECKING:
    import os
    from pathlib import Path

__all__ = ["Recording", "read_motion"]

Array = NDArray[np.float64]

FEWEST = 10
SLOWEST_HZ, FASTEST_HZ = 0.02, 1e5
SIZES = (0.3, 1.0)
"""A target moves no more than so many metres, and no fewer millimetres, or its unit is asked for."""
INTERVALS_S = (4e-4, 2.5)
"""Between two samples. The unit of time is the largest with which the median interval is in this range."""
LIKELY_S = (1e-5, 60.0)
"""The same where the unit is known."""
GAP = 5.0
"""An interval of so many medians is a gap."""
STRAY = 0.05
"""No more than this share of the rows is left out because their times are out of order."""
SHIFTS = ("displacement", "position", "positions", "points", "xyz")
UNPACKED_BYTES = 512 * 2**20
LONGEST_REASON = 120


@dataclass(frozen=True, eq=False)
class Recording:
    """``displacement`` (k, 3), m, from its mean, at ``stamps`` (k,), s, from zero on and increasing.

    ``notes`` says in sentences what was taken for granted or left out.
    """

    stamps: Array
    displacement: Array
    name: str
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.stamps)

    @property
    def duration_s(self) -> float:
        """From the first sample to the last, s."""
        return float(self.stamps[-1])

    @property
    def rate_hz(self) -> float:
        """Samples per second: one over the median interval."""
        return float(1.0 / np.median(np.diff(self.stamps)))

    @property
    def span_m(self) -> float:
        """The diagonal of the box in which it moves, m."""
        return float(np.linalg.norm(np.ptp(self.displacement, axis=0)))


@dataclass(frozen=True, eq=False)
class _Raw:
    """Numbers as they stand in the file, the units it states, and where its rows and the first one left out stand."""

    times: Array | None
    places: Array
    time_unit: str | None
    unit: str | None
    lines: NDArray[np.int64] | None
    file: str
    notes: tuple[str, ...] = ()
    lost: int | None = None

    def keep(self, rows: NDArray[np.bool_], why: str) -> _Raw:
        """Return these rows, with a note if that leaves any out."""
        if rows.all():
            return self
        lines = None if self.lines is None else self.lines[rows]
        times = None if self.times is None else self.times[rows]
        notes = (*self.notes, left_out(int((~rows).sum()), "row", why))
        lost = int(self.lines[~rows][0]) if self.lost is None and self.lines is not None else self.lost
        return replace(self, times=times, places=self.places[rows], lines=lines, notes=notes, lost=lost)


def read_motion(
    source: str | os.PathLike[str], *, units: str | None = None, rate_hz: float | None = None, strict: bool = False
) -> Recording:
    """Return the motion recorded in a table or an archive as this module describes, or ``example:NAME``.

    ``units`` ("m", "cm", "mm") of its lengths overrules what the size suggests; ``rate_hz`` stands in for a missing
    time column. Rows with a number missing, rows of zeros at the end, single rows out of order in time, and repeated
    stamps are left out; ``strict`` refuses a file with such. Raises ParseError (file, line), also for time that runs
    backwards in more than a twentieth of the rows, ConfigError (units, rate), ArgumentError.
    """
    check_type(strict, bool, "strict")
    if units is not None:
        check_type(units, str, "units")
    if rate_hz is not None and not SLOWEST_HZ <= as_number(rate_hz, "rate_hz") <= FASTEST_HZ:
        raise ConfigError(f"rate_hz is {rate_hz}; expected {SLOWEST_HZ:g} to {FASTEST_HZ:g}")
    path = file_at(source, MOTIONS, "motion")
    data = read_file(path)
    raw = _archive(data, path, units) if path.suffix.lower() == ".npz" else _table(data, path)
    raw = _without_padding(_timed(raw, rate_hz))
    raw = raw.keep(_finite(raw), "with a number that is missing, not finite or beyond 1e9")
    raw = _in_seconds(_increasing(raw))
    if strict and (left_out := [note for note in raw.notes if "left out" in note]):
        raise ParseError(f"{left_out[0]}, and strict reading was asked for", file=raw.file, line=raw.lost)
    return _recording(_in_metres(raw, units))


def _table(data: bytes, path: Path) -> _Raw:
    table = read_table(data, path, "a table of numbers (CSV, TXT, TSV) or an archive (.npz)")
    width = table.numbers.shape[1]
    if table.names:
        found = find_columns(table.names, str(path))
    elif width in {3, 4}:
        found = {role: Found(place, "") for place, role in enumerate("txyz"[4 - width :])}
    else:
        message = f"{width} columns without names; expected t x y z, or names above them"
        raise ParseError(message, file=str(path), line=int(table.lines[0]))
    axes = [axis for axis in "xyz" if axis in found]
    if not axes:
        raise ParseError(f"no column x, y or z (columns: {listed(table.names)})", file=str(path))
    places = np.zeros((len(table.numbers), 3))
    places[:, ["xyz".index(axis) for axis in axes]] = table.numbers[:, [found[axis].place for axis in axes]]
    missing = [axis for axis in "xyz" if axis not in axes]
    notes = (f"no column {', '.join(missing)}: nothing moves along it",) if missing else ()
    times = table.numbers[:, found["t"].place] if "t" in found else None
    time_unit = (found["t"].unit or None) if "t" in found else None
    unit = found_in(found, str(path)) or unit_in(table.comments)
    return _Raw(times, places, time_unit, unit, table.lines, str(path), notes)


def _archive(data: bytes, path: Path, units: str | None) -> _Raw:
    arrays = _arrays(data, path)
    name = next((key for key in SHIFTS if key in arrays), "")
    if not name:
        message = f"no array 'displacement' or 'position' (arrays: {listed(arrays) or 'none'})"
        raise ParseError(message, file=str(path))
    places = arrays[name]
    times = next((arrays[key] for key in ("t", "time", "stamps") if key in arrays), None)
    count = len(places) if places.ndim else 0
    if places.shape != (count, 3) or (times is not None and times.shape != (count,)):
        shapes = f"{name} has shape {places.shape}" + ("" if times is None else f", the times {times.shape}")
        raise ParseError(f"{shapes}; expected (k, 3) and (k,)", file=str(path))
    return _Raw(times, places, "s", units or "m", None, str(path))


def _arrays(data: bytes, path: Path) -> dict[str, Array]:
    """The arrays of an archive, none of them if it would unpack to more than fits."""
    try:
        size = sum(member.file_size for member in zipfile.ZipFile(io.BytesIO(data)).infolist())
        with warnings.catch_warnings(action="ignore"):
            loaded = np.load(io.BytesIO(data), allow_pickle=False)
            names = loaded.files if size <= UNPACKED_BYTES else ()
            arrays = {name: as_array(loaded[name], name).astype(np.float64) for name in names}
    except Exception as error:  # damage surfaces as any error of the archive, its compression or NumPy's header
        reason = str(error)[:LONGEST_REASON] or type(error).__name__
        raise ParseError(f"not a readable NumPy archive: {reason}", file=str(path)) from error
    if size > UNPACKED_BYTES:
        message = f"{size / 2**20:.0f} MiB unpacked; at most {UNPACKED_BYTES // 2**20} MiB are read"
        raise ParseError(message, file=str(path))
    return arrays


def _timed(raw: _Raw, rate_hz: float | None) -> _Raw:
    if raw.times is None and rate_hz is None:
        raise ConfigError(f"{raw.file}: no column of times; call one 't', or give the samples per second")
    if raw.times is not None and rate_hz is not None:
        raise ConfigError(f"{raw.file}: has times, which a rate of {rate_hz:g} Hz would contradict; leave the rate out")
    if raw.times is not None:
        return raw
    return replace(raw, times=np.arange(len(raw.places)) / (rate_hz or 1.0), time_unit="s")


def _without_padding(raw: _Raw) -> _Raw:
    """Leave out rows of zeros, time included, at the end: a recorder's buffer that was not full."""
    filled = raw.places.any(axis=1) | (_times(raw) != 0.0)
    last = len(filled) - int(np.argmax(filled[::-1])) if filled.any() else len(filled)
    return raw.keep(np.arange(len(filled)) < last, "of zeros at the end")


def _times(raw: _Raw) -> Array:
    return np.zeros(len(raw.places)) if raw.times is None else raw.times


def _finite(raw: _Raw) -> NDArray[np.bool_]:
    usable: NDArray[np.bool_] = np.isfinite(_times(raw)) & (np.abs(raw.places) <= LARGEST).all(axis=1)
    return usable


def _increasing(raw: _Raw) -> _Raw:
    raw = _in_order(raw)
    steps = np.diff(_times(raw))
    raw = raw.keep(np.concatenate(([True], steps > 0.0))[: len(raw.places)], "repeating the stamp before")
    if len(raw.places) < FEWEST:
        why = "".join(f" ({note})" for note in raw.notes if "left out" in note)
        raise ParseError(f"{len(raw.places)} usable samples{why}; expected {FEWEST} at least", file=raw.file)
    return raw


def _in_order(raw: _Raw) -> _Raw:
    """Leave out the fewest rows without which time never runs backwards, if they are few."""
    times = _times(raw)
    backwards = np.diff(times) < 0.0
    if not backwards.any():
        return raw
    kept = _longest_ascent(times)
    if (~kept).mean() <= STRAY:
        return raw.keep(kept, "out of order in time")
    row = int(np.argmax(backwards)) + 1
    line = None if raw.lines is None else int(raw.lines[row])
    where = "" if line else f" at row {row + 1}"
    message = f"time runs backwards{where}: {times[row]:.9g} after {times[row - 1]:.9g}"
    raise ParseError(f"{message}; sort the rows, or cut there", file=raw.file, line=line)


def _longest_ascent(times: Array) -> NDArray[np.bool_]:
    """The rows of a longest selection in which no time is before the one above it."""
    ends: list[float] = []
    rows: list[int] = []
    before: list[int] = []
    for row, time in enumerate(times.tolist()):
        place = bisect_right(ends, time)
        before.append(rows[place - 1] if place else -1)
        ends[place : place + 1] = [time]
        rows[place : place + 1] = [row]
    kept = np.zeros(len(times), dtype=np.bool_)
    row = rows[-1]
    while row >= 0:
        kept[row] = True
        row = before[row]
    return kept


def _in_seconds(raw: _Raw) -> _Raw:
    times = _times(raw)
    interval = float(np.median(np.diff(times)))
    unit = raw.time_unit or _likely_unit(interval, raw.file)
    apart = interval * TIME_UNITS[unit]
    shortest, longest = LIKELY_S
    if not shortest <= apart <= longest:
        message = f"samples are {apart:.4g} s apart, taken as {unit}; expected {shortest:g} to {longest:g} s"
        raise ParseError(f"{message}: check the unit of its times", file=raw.file)
    notes = raw.notes
    if raw.time_unit is None:
        notes = (*notes, f"times are taken as {unit}: {1.0 / apart:.4g} samples per second")
    with np.errstate(over="ignore"):
        seconds = (times - times[0]) * TIME_UNITS[unit]
    gap = float(np.diff(seconds).max())
    if gap > GAP * apart:
        notes = (*notes, f"the longest gap is {gap:.3g} s, filled by a smooth curve")
    return replace(raw, times=seconds, time_unit="s", notes=notes)


def _likely_unit(interval: float, file: str) -> str:
    """The largest unit of time in which samples are as far apart as those of a target."""
    low, high = INTERVALS_S
    unit = next((name for name, factor in TIME_UNITS.items() if low <= interval * factor <= high), None)
    if unit is None:
        message = f"samples are {interval:g} apart, in no likely unit; name the column t_s, t_ms, t_us or t_ns"
        raise ParseError(message, file=file)
    return unit


def _in_metres(raw: _Raw, given: str | None) -> _Raw:
    size = float(np.linalg.norm(np.ptp(raw.places, axis=0)))
    unit = unit_of(size, given, raw.unit, what=f"{raw.file}: the motion", between=SIZES)
    note: tuple[str, ...] = ()
    if given is None and raw.unit is None:
        note = (f"lengths are taken as {unit}: it moves within {1e3 * size * LENGTH_UNITS[unit]:.3g} mm",)
    return replace(raw, places=raw.places * LENGTH_UNITS[unit], notes=(*raw.notes, *note))


def _recording(raw: _Raw) -> Recording:
    with np.errstate(over="ignore", invalid="ignore"):
        shifts = raw.places - raw.places.mean(axis=0)
    if not np.isfinite(_times(raw)).all() or not np.isfinite(shifts).all():
        raise ArgumentError(f"{raw.file}: its numbers are too large")
    return Recording(_times(raw), shifts, raw.file, raw.notes)
