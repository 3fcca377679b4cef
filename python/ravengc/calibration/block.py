"""The ``[accelerometer]`` table of a robot file: the whole chain of its base sensor.

::

    [accelerometer]
    sensor = "serial:/dev/ttyUSB0?format=line&baud=115200"   # KIND:ADDRESS[?key=value&...]
    rate_hz = 100.0                         # declared sample rate
    range = 19.6                            # m/s², full scale per axis
    unit = "m/s^2"                          # what the sensor sends: "m/s^2", "g", "mg", "cm/s^2"
    rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]     # R_BS: base axes <- sensor axes
    position = [0.0, 0.0, 0.0]              # m, place of the sensor in base axes
    bias = [0.0, 0.0, 0.0]                  # m/s², sensor axes
    correction = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]   # S: f = S (s - bias)
    gyro_bias = [0.0, 0.0, 0.0]             # rad/s, sensor axes
    cutoff_hz = 20.0                        # low-pass; absent: none
    policy = "paper"                        # or "strict"
"""

from __future__ import annotations

import tomllib
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ravengc._convert import as_path, check_members
from ravengc.config.fields import Table, read_vector
from ravengc.config.files import decode, read_bytes, write_atomically
from ravengc.config.locate import Place, TextPlaces
from ravengc.config.physical import LARGEST, check_pose
from ravengc.config.toml_reader import ACCELEROMETER_KEYS
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.spec import IDENTITY, ZERO, Matrix, Pose, Vector

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping
    from pathlib import Path

__all__ = ["KEYS", "TABLE", "AccelerometerBlock", "read_block", "write_block"]

TABLE = "accelerometer"
POLICIES = ("paper", "strict")
KEYS = ACCELEROMETER_KEYS
FASTEST_HZ = 1e5
LARGEST_RANGE, LARGEST_BIAS, LARGEST_RATE, FARTHEST = 5000.0, 50.0, 10.0, 100.0
"""m/s², m/s², rad/s, m: beyond these a number is a slip, mostly of its unit."""
CORRECTION_WINDOW = (0.5, 2.0)
"""Singular values of a correction: sensors are within a few percent of 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AccelerometerBlock:
    """What the table says, in SI, with the defaults of what it leaves out; ``given`` are the keys that it has."""

    sensor: str | None = None
    rate_hz: float | None = None
    range: float | None = None
    unit: str = "m/s^2"
    rotation: Matrix = IDENTITY
    position: Vector = ZERO
    bias: Vector = ZERO
    correction: Matrix = IDENTITY
    gyro_bias: Vector = ZERO
    cutoff_hz: float | None = None
    policy: str = "paper"
    given: frozenset[str] = field(default=frozenset(), compare=False)

    def as_dict(self) -> dict[str, Any]:
        """Return the values by key, all but ``given``."""
        values = asdict(self)
        del values["given"]
        return values


def read_block(path: str | os.PathLike[str]) -> AccelerometerBlock | None:
    """Return the table of a TOML file, or None where it has none.

    Raises ParseError for what cannot be read, ConfigError (unknown keys with the near one), UnitsError and ModelError
    (a rotation that is none) for what it says; each names file, line and key.
    """
    file = as_path(path, "path")
    return _block(_text(file), str(file))


def write_block(path: str | os.PathLike[str], values: Mapping[str, Any]) -> AccelerometerBlock:
    """Set keys of the table in a TOML file, leave every other byte as it is, and return the whole table.

    A file, or a table, that is not there is made. What comes out is checked as by :func:`read_block` before anything is
    written; the file is replaced whole or not at all. Lists, tuples and arrays are taken for vectors and matrices.
    """
    from ravengc.calibration.toml_edit import set_keys

    file = as_path(path, "path")
    if file.suffix.lower() != ".toml":
        raise ConfigError(f"{file}: the table [{TABLE}] is written to a file ending in .toml")
    check_members(values, ("items",), "values")
    plain = {key: _plain(key, value) for key, value in values.items()}
    old = _decoded(file) if file.exists() else ""
    mark, text = ("\ufeff", old[1:]) if old.startswith("\ufeff") else ("", old)
    if text:
        _block(text, str(file))
    new = set_keys(text, TABLE, plain, file=str(file))
    block = _block(new, str(file))
    if block is None:
        raise ConfigError(f"{file}: nothing to write")
    write_atomically(file, mark + new)
    return block


def _plain(key: str, value: Any) -> Any:
    if key not in KEYS:
        raise ConfigError(f"[{TABLE}]: unknown key {shown(key)}{did_you_mean(key, KEYS)} (known: {listed(KEYS)})")
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, (list, tuple)):
        return [_plain(key, entry) for entry in value]
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ArgumentError(f"[{TABLE}]: {key} is {shown(value)}; expected a number, a text, or a list of numbers")
    if not isinstance(value, str) and not abs(value) <= LARGEST:
        raise ArgumentError(f"[{TABLE}]: {key} is {shown(value)}; expected a finite number of at most {LARGEST:g}")
    return value


def _text(file: Path) -> str:
    return decode(read_bytes(file), str(file))


def _decoded(file: Path) -> str:
    """The text with its byte-order mark, if it has one."""
    data = read_bytes(file)
    decode(data, str(file))
    return data.decode("utf-8")


def _block(text: str, file: str) -> AccelerometerBlock | None:
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ParseError(f"not valid TOML: {error}", file=file) from error
    if TABLE not in document:
        return None
    table = Table(document[TABLE], Place(f"[{TABLE}]", (TABLE,), TextPlaces(file, text)), KEYS)
    return _checked(table)


def _checked(table: Table) -> AccelerometerBlock:
    from ravengc.sensors.units import ACCELERATION_UNITS

    rate = _within(table, "rate_hz", "frequency", FASTEST_HZ)
    cutoff = _within(table, "cutoff_hz", "frequency", FASTEST_HZ)
    if rate is not None and cutoff is not None and not cutoff < rate / 2.0:
        raise table.complaint("cutoff_hz", f"less than half of rate_hz, {rate / 2.0:g}")
    return AccelerometerBlock(
        sensor=_sensor(table),
        rate_hz=rate,
        range=_within(table, "range", "acceleration", LARGEST_RANGE),
        unit=table.choice("unit", tuple(ACCELERATION_UNITS), "m/s^2"),
        rotation=_rotation(table),
        position=_small(table, "position", FARTHEST, "m", read_vector(table, "position")),
        bias=_small(table, "bias", LARGEST_BIAS, "m/s²", _vector(table, "bias", "acceleration")),
        correction=_correction(table),
        gyro_bias=_small(table, "gyro_bias", LARGEST_RATE, "rad/s", _vector(table, "gyro_bias", "angular velocity")),
        cutoff_hz=cutoff,
        policy=table.choice("policy", POLICIES, "paper"),
        given=frozenset(table.names()),
    )


def _sensor(table: Table) -> str | None:
    from ravengc.sensors.address import parse_address

    if "sensor" not in table:
        return None
    address = table.text("sensor")
    try:
        parse_address(address)
    except ConfigError as error:
        raise ConfigError(f"{table.place.at('sensor')}: {error}") from None
    return address


def _within(table: Table, key: str, dimension: Any, most: float) -> float | None:
    value = table.optional_number(key, dimension)
    if value is not None and not 0.0 < value <= most:
        raise table.complaint(key, f"more than 0 and at most {most:g}")
    return value


def _vector(table: Table, key: str, dimension: Any) -> Vector:
    if key not in table:
        return ZERO
    x, y, z = table.vector(key, (dimension,) * 3)
    return (x, y, z)


def _small(table: Table, key: str, most: float, unit: str, vector: Vector) -> Vector:
    if max(map(abs, vector)) > most:
        raise table.complaint(key, f"components of at most {most:g} {unit}")
    return vector


def _matrix(table: Table, key: str) -> Matrix:
    rows = table.matrix(key)
    if [len(row) for row in rows] != [3, 3, 3]:
        raise table.complaint(key, "three rows of three numbers")
    return cast("Matrix", rows)


def _rotation(table: Table) -> Matrix:
    if "rotation" not in table:
        return IDENTITY
    rotation = _matrix(table, "rotation")
    check_pose(Pose(rotation=rotation), table.place)
    return rotation


def _correction(table: Table) -> Matrix:
    if "correction" not in table:
        return IDENTITY
    correction = _matrix(table, "correction")
    values = np.linalg.svd(np.array(correction), compute_uv=False)
    low, high = CORRECTION_WINDOW
    if not (low <= values[-1] and values[0] <= high and np.linalg.det(correction) > 0.0):
        raise table.complaint(
            "correction", f"a matrix near the identity (singular values {low:g} to {high:g}, no mirror)"
        )
    return correction
