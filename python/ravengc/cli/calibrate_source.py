"""Where ``ravengc calibrate`` has its readings from: a recording, or a live sensor whose user is asked to turn it."""

from __future__ import annotations

import math
import os
from contextlib import closing
from dataclasses import replace
from typing import TYPE_CHECKING

from ravengc.cli.common import waiting
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, shown

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Iterator

    from ravengc.calibration import AccelerometerBlock, ImuRecording, StillLimits
    from ravengc.sensors import Address, Sample, Sensor

    OpenSensor = Callable[[Address], Sensor]
    Ask = Callable[[str], str]

__all__ = ["measured", "rocked"]

ROCKING_S = 20.0
ROCK = (
    "Rock the base about the point that stays put, by 10 degrees or more, about once a second, about two axes in "
    f"turn; press Enter, and go on for {ROCKING_S:g} s"
)
OPTIONS = {"unit": "--unit", "gyro_unit": "--gyro-unit", "sends": "--sends", "rate": "--rate"}
"""Keys of a sensor's address, and what the command calls them."""


def measured(
    args: argparse.Namespace,
    block: AccelerometerBlock,
    limits: StillLimits,
    tilts: int,
    opener: OpenSensor | None,
    ask: Ask,
) -> ImuRecording:
    """Return the recording that the source names, or what a live sensor measured in the positions asked for.

    With ``tilts`` there are so many, in their order; else six faces, or free positions for the method ellipsoid.
    """
    from ravengc.calibration import ask_for_faces, ask_for_positions, ask_for_tilts

    address = _live(args, block)
    if address is None:
        return _recorded(args)
    with _opened(address, opener) as sensor:
        if tilts and args.method != "ellipsoid":
            recording = ask_for_tilts(sensor.read, ask, tilts, limits)
        elif args.method == "ellipsoid":
            recording = ask_for_positions(sensor.read, ask, limits)
        else:
            recording = ask_for_faces(sensor.read, ask, limits)
        return replace(recording, source=sensor.name)


def rocked(args: argparse.Namespace, block: AccelerometerBlock, opener: OpenSensor | None, ask: Ask) -> ImuRecording:
    """Return the recording that the source names, or twenty seconds of a live sensor on a base that is rocked."""
    from ravengc.calibration import record

    address = _live(args, block)
    if address is None:
        return _recorded(args)
    with _opened(address, opener) as sensor:
        ask(ROCK)
        with waiting(f"recording {sensor.name}"):
            return replace(record(sensor.read, ROCKING_S), source=sensor.name)


def _opened(address: Address, opener: OpenSensor | None = None) -> closing[Sensor]:
    return closing(address.open() if opener is None else opener(address))


def _live(args: argparse.Namespace, block: AccelerometerBlock) -> Address | None:
    """The live sensor that the source names, in the unit of the robot's file; None for a recording."""
    if not _has_kind(args.source):
        return None
    address = _address(args)
    if _is_recorded(address):
        return None
    if address.kind == "stdin":
        raise ConfigError("stdin: carries the answers to questions; give the sensor's bytes by a named pipe: file:PIPE")
    if args.rate is not None:
        raise ConfigError("--rate: a live sensor has its own; its address may set it")
    return address.with_defaults(unit=block.unit) if "unit" in block.given else address


def _recorded(args: argparse.Namespace) -> ImuRecording:
    """A recording, read as the options say, or as its address does."""
    from ravengc.calibration import ReadOptions, from_samples, read_imu

    with waiting(f"reading {args.source}"):
        plain = args.source.removeprefix("replay:")
        if "?" in plain or _has_kind(plain):
            address = _address(args)
            return from_samples(_all_samples(address), address.place)
        options = ReadOptions(
            unit=args.unit,
            rate_unit=args.gyro_unit,
            columns=args.columns,
            rate_hz=args.rate,
            sends=args.sends or "specific_force",
        )
        return read_imu(plain, options)


def _all_samples(address: Address) -> Iterator[Sample]:
    """The samples of a recording, without waiting."""
    with _opened(replace(address, options={**address.options, "speed": math.inf, "repeat": False})) as sensor:
        while not sensor.finished:
            if (sample := sensor.read(0.0)) is not None:
                yield sample


def _has_kind(source: str) -> bool:
    """Whether the source begins with the kind of a sensor; ConfigError for one that is misspelt."""
    from ravengc.sensors import KINDS, parse_address

    kind, colon, _ = source.partition(":")
    if colon and kind not in KINDS and kind != "example" and did_you_mean(kind, KINDS) and not os.path.exists(source):  # noqa: PTH110 -- never raises
        parse_address(source)
    return bool(colon) and kind in KINDS


def _is_recorded(address: Address) -> bool:
    from ravengc.sensors import KINDS

    return KINDS[address.kind].is_recorded(address.place)


def _address(args: argparse.Namespace) -> Address:
    """The sensor that the source names, with what the options say of it."""
    from ravengc.sensors import parse_address

    address = parse_address(args.source)
    given = {key: value for key in OPTIONS if (value := getattr(args, key)) is not None}
    for key, value in given.items():
        if not address.takes(key):
            raise ConfigError(f"{OPTIONS[key]}: sensor {shown(args.source)} does not take it")
        if address.options.get(key, value) != value:
            raise ConfigError(f"{OPTIONS[key]} {value}: sensor {shown(args.source)} says {address.options[key]}")
    if args.columns is not None:
        raise ConfigError("--columns: a sensor's address names the columns itself")
    return replace(address, options={**given, **address.options})
