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

What the sensor is and how the base moves, as :class:`ravengc.Accelerometer` has it; absent: its own defaults::

    gyro_range = "2000 deg/s"               # or rad/s, full scale of the gyroscope
    bandwidth_hz = 40.0                     # of the sensor's own filter
    noise = 0.03                            # m/s², standard deviation of a sample at rest
    stuck_count = 8                         # equal samples that say it is stuck; 0: never
    up = [0, 0, 1]                          # base axes, when the base is level
    pose_limit = "45 deg"                   # or rad: how far up may be from that
    tilt_limit = "15 deg"                   # or rad: how far a level found anew may be from the average
    norm = [3.0, 18.0]                      # m/s², least and largest specific force that the base feels
    jerk = 150.0                            # m/s³, how fast the specific force changes
    linear_acceleration = 1.5               # m/s², of the base origin; used where there is a gyroscope
    moving_base = false                     # true: it may fall freely and accelerate for long (aircraft, boat)
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
from ravengc.config.toml_reader import ACCELEROMETER_FLAGS, ACCELEROMETER_KEYS
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.spec import IDENTITY, ZERO, Matrix, Pose, Vector

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping
    from pathlib import Path

__all__ = ["KEYS", "TABLE", "AccelerometerBlock", "read_block", "write_block"]

TABLE = "accelerometer"
POLICIES = ("paper", "strict")
KEYS = ACCELEROMETER_KEYS
OF_THE_SENSOR = ("gyro_range", "bandwidth_hz", "noise", "stuck_count")
OF_THE_BASE = ("up", "pose_limit", "tilt_limit", "norm", "jerk", "linear_acceleration", "moving_base")
"""Declarations that :class:`ravengc.Accelerometer` checks and has defaults for."""
SLOWEST_HZ, FASTEST_HZ = 1.0, 1e5
MOST_EQUAL = 10_000
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
    gyro_range: float | None = None
    bandwidth_hz: float | None = None
    noise: float | None = None
    stuck_count: int | None = None
    up: Vector | None = None
    pose_limit: float | None = None
    tilt_limit: float | None = None
    norm: tuple[float, float] | None = None
    jerk: float | None = None
    linear_acceleration: float | None = None
    moving_base: bool | None = None
    given: frozenset[str] = field(default=frozenset(), compare=False)

    def as_dict(self) -> dict[str, Any]:
        """Return the values by key, all but ``given``."""
        values = asdict(self)
        del values["given"]
        return values

    @property
    def of_the_sensor(self) -> dict[str, Any]:
        """What the table declares of the sensor itself, as settings of :class:`ravengc.Accelerometer`."""
        return {key: getattr(self, key) for key in OF_THE_SENSOR if key in self.given}

    @property
    def of_the_base(self) -> dict[str, Any]:
        """What the table declares of the base and its motion, as settings of :class:`ravengc.Accelerometer`."""
        return {key: getattr(self, key) for key in OF_THE_BASE if key in self.given}


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
    if key in ACCELEROMETER_FLAGS and isinstance(value, bool):
        return value
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
        **_declared(table, rate or 100.0),
    )


def _declared(table: Table, rate_hz: float) -> dict[str, Any]:
    """What the table declares of the sensor and the base, each as a chain of this rate takes it."""
    from ravengc.monitored import chain_for

    readers: dict[str, Callable[[str], Any]] = {
        "gyro_range": lambda key: table.number(key, "angular velocity"),
        "bandwidth_hz": lambda key: table.number(key, "frequency"),
        "noise": lambda key: table.number(key, "acceleration"),
        "stuck_count": lambda key: _count(table, key),
        "up": lambda key: table.vector(key, ("number",) * 3),
        "pose_limit": lambda key: table.number(key, "angle"),
        "tilt_limit": lambda key: table.number(key, "angle"),
        "norm": lambda key: table.vector(key, ("acceleration",) * 2),
        "jerk": lambda key: table.number(key, "number"),
        "linear_acceleration": lambda key: table.number(key, "acceleration"),
        "moving_base": table.flag,
    }
    declared = {key: read(key) for key, read in readers.items() if key in table}
    for key, value in declared.items():
        try:
            chain_for(max(rate_hz, SLOWEST_HZ), **{key: value})
        except ConfigError as error:
            raise ConfigError(f"{table.place.at(key)}: {error}") from None
    return declared


def _count(table: Table, key: str) -> int:
    value = table.number(key, "number")
    if value not in range(MOST_EQUAL + 1):
        raise table.complaint(key, f"a whole number from 0 to {MOST_EQUAL}")
    return int(value)


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
