"""The framings that are understood, by the name that ``format=`` gives them. Each is imported when it is asked for."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, NamedTuple

from ravengc._convert import check_choice

if TYPE_CHECKING:
    from ravengc.sensors.decoders.base import Decoder

__all__ = ["FORMATS", "Format", "make_decoder"]


class Format(NamedTuple):
    """A framing: the class that reads it, the keys it takes, and the baud rate its sensors come with."""

    module: str
    decoder: str
    keys: tuple[str, ...]
    baud: int
    about: str


FORMATS = {
    "line": Format("line", "LineDecoder", ("unit", "sends"), 115200, "A,<t_us>,ax,ay,az[,gx,gy,gz]*XX"),
    "csv": Format("csv", "CsvDecoder", ("unit", "sends", "gyro_unit", "columns"), 115200, "lines of plain numbers"),
    "rosserial": Format("rosserial", "RosserialDecoder", ("topic", "unit", "sends"), 57600, "Arduino with ros_lib"),
    "bno08x": Format("bno08x", "Bno08xDecoder", (), 115200, "BNO080/085/086 in UART-RVC mode"),
    "vectornav": Format("vectornav", "VectorNavDecoder", (), 115200, "VectorNav ASCII messages"),
    "witmotion": Format("witmotion", "WitMotionDecoder", (), 9600, "WitMotion WT61, WT901 and kin"),
    "mavlink": Format("mavlink", "MavlinkDecoder", ("message",), 57600, "autopilots, through pymavlink"),
}


def make_decoder(name: str, **options: Any) -> Decoder:
    """Make the decoder of the format ``name`` with its options.

    Raises ConfigError for an unknown format or a value it cannot take, MissingExtraError if its package is missing.
    """
    check_choice(name, FORMATS, "format")
    found = FORMATS[name]
    module = importlib.import_module(f"ravengc.sensors.decoders.{found.module}")
    decoder: Decoder = getattr(module, found.decoder)(**options)
    return decoder
