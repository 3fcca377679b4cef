"""What a decoder is: bytes in, measurements out, counts kept, nothing raised."""

from __future__ import annotations

from abc import ABC, abstractmethod

from ravengc.sensors.sample import Measurement, Statistics

__all__ = ["SAYS", "Decoder", "quoted"]

SAYS = "the sensor says: "
LONGEST_SAYING = 200


class Decoder(ABC):
    """Turns the bytes of one framing into measurements.

    A decoder never raises for any bytes, holds a bounded number of them, and gives the same measurements however the
    bytes are cut. ``remark`` says in words what is wrong with the stream. Where ``is_text`` is true, the end of a
    datagram ends a line.
    """

    is_text = False

    def __init__(self) -> None:
        self.statistics = Statistics()
        self.remark = ""

    @property
    @abstractmethod
    def held(self) -> int:
        """Bytes that are kept until more of them come."""

    @abstractmethod
    def feed(self, data: bytes) -> list[Measurement]:
        """Take bytes in and give the measurements that they complete."""

    def outgoing(self, now_ns: int) -> bytes:  # noqa: ARG002 - for those who answer
        """What to send to the sensor at ``now_ns`` (CLOCK_MONOTONIC)."""
        return b""

    def farewell(self) -> bytes:
        """What to send before the link is closed."""
        return b""


def quoted(text: bytes) -> str:
    """What a sensor said in words, as a remark: cut short, and without anything that a terminal would obey."""
    words = text.decode("utf-8", "replace").strip()[:LONGEST_SAYING]
    return SAYS + "".join(letter if letter.isprintable() else "?" for letter in words)
