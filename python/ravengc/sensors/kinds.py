"""The kinds of sensors: what stands behind the colon, which keys each takes, and how it is opened."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.errors import ConfigError, ParseError
from ravengc.messages import listed, shown
from ravengc.sensors.decoders import FORMATS, make_decoder
from ravengc.sensors.options import (
    choice,
    quantity,
    read_baud,
    read_flag,
    read_text,
    read_triple,
    read_whole,
)
from ravengc.sensors.units import ACCELERATION_UNITS, AXES, RATE_UNITS, SENDS, parse_axes

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from ravengc.sensors.decoders.base import Decoder
    from ravengc.sensors.options import Reader
    from ravengc.sensors.sample import Sensor
    from ravengc.sim import CarriedBase

__all__ = ["DEFAULT_FORMAT", "KINDS", "Kind"]

DEFAULT_FORMAT = "line"
LARGEST_PORT = 65535
SIMULATED_NOISE = 0.02
"""m/s²: without any, a sensor repeats itself bit by bit, which is a fault."""

_FORMAT_KEYS: dict[str, Reader] = {
    "unit": choice(ACCELERATION_UNITS),
    "sends": choice(SENDS),
    "gyro_unit": choice(RATE_UNITS),
    "columns": read_text,
    "topic": read_text,
    "message": read_text,
}
"""Keys of decoders; which format takes which stands in FORMATS."""
_STREAM: dict[str, Reader] = {"format": choice(FORMATS), "axes": parse_axes}
_PLAYING: dict[str, Reader] = {"speed": quantity("number", infinite=True), "repeat": read_flag}


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind: ``prepare(place, options)`` gives a function that opens the sensor, ``check`` looks at the place."""

    about: str
    example: str
    prepare: Callable[[str, dict[str, Any]], Callable[[], Sensor]]
    check: Callable[[str], object]
    keys: Mapping[str, Reader] = field(default_factory=dict)
    has_formats: bool = False
    is_recorded: Callable[[str], bool] = lambda _: False
    """Whether what stands at the place is a recording."""
    defaults_as: Mapping[str, str] = field(default_factory=dict)
    """What a key is called when it is a default and no word of the address."""

    def format_keys(self, form: str | None) -> dict[str, Reader]:
        """The keys that a format adds, None being the default format."""
        if not self.has_formats:
            return {}
        return {key: _FORMAT_KEYS[key] for key in FORMATS[form or DEFAULT_FORMAT].keys}

    def owner(self, key: str) -> str | None:
        """The format that a key belongs to, if there is one."""
        return next((name for name, form in FORMATS.items() if self.has_formats and key in form.keys), None)


def _required(what: str) -> Callable[[str], None]:
    def check(place: str) -> None:
        if not place:
            raise ConfigError(f"{what} is missing behind the colon")
        if "\0" in place:
            raise ConfigError(f"{what} has no character NUL in its name")

    return check


def _decoder_maker(options: dict[str, Any]) -> Callable[[], Decoder]:
    """What makes a new decoder for each opening; tried once, so that wrong values show now."""
    form = options.get("format", DEFAULT_FORMAT)
    chosen = {key: options[key] for key in FORMATS[form].keys if key in options}
    make_decoder(form, **chosen)
    return lambda: make_decoder(form, **chosen)


def _prepare_serial(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.links import open_serial
    from ravengc.sensors.stream import StreamSensor

    decoder, axes = _decoder_maker(options), options.get("axes", AXES)
    baud = options.get("baud", FORMATS[options.get("format", DEFAULT_FORMAT)].baud)
    return lambda: StreamSensor(open_serial(place, baud), decoder(), axes=axes)


def _prepare_udp(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.links import UdpLink
    from ravengc.sensors.stream import StreamSensor

    decoder, axes = _decoder_maker(options), options.get("axes", AXES)
    host, port = _host_and_port(place)
    return lambda: StreamSensor(UdpLink(port, host), decoder(), axes=axes)


def _prepare_file(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    """A file is decoded here; a pipe is a stream."""
    from ravengc.sensors.recorded import near_file

    if not Path(place).exists():
        raise ParseError(f"no such file{near_file(place)}", file=place)
    return _prepare_capture(place, options) if _is_file(place) else _prepare_pipe(place, options)


def _prepare_capture(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.captured import CapturedSensor, read_capture

    rate = options.get("rate", options.get("fallback_rate"))
    reading = {} if rate is None else {"rate_hz": rate}
    playing = {key: options[key] for key in ("speed", "repeat", "axes") if key in options}
    capture = read_capture(place, _decoder_maker(options)(), **reading)
    CapturedSensor(capture, **playing)
    return lambda: CapturedSensor(capture, **playing)


def _prepare_pipe(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.links import open_file
    from ravengc.sensors.stream import StreamSensor

    if pacing := {"rate", "speed", "repeat"} & set(options):
        raise ConfigError(f"{place} comes at its own pace; leave out {listed(sorted(pacing))}, which are for files")
    decoder, axes = _decoder_maker(options), options.get("axes", AXES)
    return lambda: StreamSensor(open_file(place), decoder(), axes=axes)


def _prepare_stdin(_: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.links import open_stdin
    from ravengc.sensors.stream import StreamSensor

    decoder, axes = _decoder_maker(options), options.get("axes", AXES)
    return lambda: StreamSensor(open_stdin(), decoder(), axes=axes)


def _prepare_iio(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.iio import IioSensor, check_rate

    renamed = {"rate_hz" if key == "rate" else key: value for key, value in options.items()}
    check_rate(renamed.get("rate_hz", 1.0))
    return lambda: IioSensor(place, **renamed)


def _prepare_replay(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.recorded import read_recording
    from ravengc.sensors.replay import ReplaySensor

    names = {"acc": "accelerometer", "gyro": "gyroscope", "rate": "rate_hz"}
    playing = {key: options[key] for key in ("speed", "repeat", "axes") if key in options}
    reading = {names.get(key, key): value for key, value in options.items() if key not in playing}
    recording = read_recording(place, **reading)
    ReplaySensor(recording, **playing)
    return lambda: ReplaySensor(recording, **playing)


def _prepare_sim(place: str, options: dict[str, Any]) -> Callable[[], Sensor]:
    from ravengc.sensors.simulated import from_base

    names = {"rate": "rate_hz", "latency": "latency_s", "range": "full_scale"}
    base = _base(place, options.pop("axis", "x"))
    renamed = {"noise": SIMULATED_NOISE} | {names.get(key, key): value for key, value in options.items()}
    from_base(base, **renamed)
    return lambda: from_base(base, name=f"sim:{place}", **renamed)


def _base(place: str, axis: str = "x") -> CarriedBase:
    from ravengc.sim import parse_base

    return parse_base(place or "level", axis=axis)


def _host_and_port(place: str) -> tuple[str, int]:
    from ravengc.sensors.links.udp import LOOPBACK

    host, _, port = place.rpartition(":")
    if not (port.isascii() and port.isdecimal() and len(port) <= 5 and 0 < int(port) <= LARGEST_PORT):
        raise ConfigError(f"got {shown(place)}, expected PORT or HOST:PORT with a port from 1 to {LARGEST_PORT}")
    return host.removeprefix("[").removesuffix("]") or LOOPBACK, int(port)


def _is_file(place: str) -> bool:
    return Path(place).is_file()


def _check_empty(place: str) -> None:
    if place:
        raise ConfigError(f"nothing may stand behind 'stdin:', not {shown(place)}")


KINDS: dict[str, Kind] = {
    "sim": Kind(
        "computed, with some noise: level, tilt:DEG or rocking:LOW:HIGH:HZ",
        "sim:rocking:10:20:1?noise=0.03",
        _prepare_sim,
        _base,
        {
            "rate": quantity("frequency"),
            "noise": quantity("acceleration"),
            "gyro_noise": quantity("angular velocity"),
            "quantisation": quantity("acceleration"),
            "range": quantity("acceleration"),
            "latency": quantity("time"),
            "seed": read_whole,
            "axis": choice(("x", "y", "z")),
            "position": read_triple,
            "gyro": read_flag,
        },
    ),
    "replay": Kind(
        "a recording in a CSV file, or example:xio",
        "replay:example:xio?speed=2",
        _prepare_replay,
        _required("a file"),
        is_recorded=lambda _: True,
        keys={
            "unit": choice(ACCELERATION_UNITS),
            "gyro_unit": choice(RATE_UNITS),
            "sends": choice(SENDS),
            "time": read_text,
            "acc": read_text,
            "gyro": read_text,
            "rate": quantity("frequency"),
            "axes": parse_axes,
            **_PLAYING,
        },
        defaults_as={"unit": "fallback_unit"},
    ),
    "serial": Kind(
        "a serial port",
        "serial:/dev/ttyUSB0?format=line&baud=115200",
        _prepare_serial,
        _required("a port"),
        {**_STREAM, "baud": read_baud},
        has_formats=True,
    ),
    "udp": Kind(
        "datagrams to [HOST:]PORT, on loopback unless a host is given",
        "udp:14550?format=mavlink",
        _prepare_udp,
        _host_and_port,
        _STREAM,
        has_formats=True,
    ),
    "file": Kind(
        "the bytes that were kept in a file, or come through a named pipe",
        "file:imu.bin?format=bno08x&rate=100",
        _prepare_file,
        _required("a file"),
        {**_STREAM, **_PLAYING, "rate": quantity("frequency")},
        has_formats=True,
        is_recorded=_is_file,
        defaults_as={"rate": "fallback_rate"},
    ),
    "stdin": Kind(
        "the bytes on standard input, as they come",
        "stdin:?format=csv",
        _prepare_stdin,
        _check_empty,
        _STREAM,
        has_formats=True,
    ),
    "iio": Kind(
        "an accelerometer that Linux drives, by name, folder or number",
        "iio:adxl345?rate=100",
        _prepare_iio,
        _required("a device"),
        {"rate": quantity("frequency"), "gyro": read_text, "mount": read_flag, "root": read_text},
    ),
}
