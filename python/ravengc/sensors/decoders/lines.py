"""Lines out of bytes, and numbers out of lines."""

from __future__ import annotations

import re
from abc import abstractmethod
from typing import TYPE_CHECKING

from ravengc.sensors.decoders.base import Decoder

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.sensors.sample import Measurement, Statistics, Triple

__all__ = ["LONGEST", "Lines", "TextDecoder", "marked", "numbers", "triple", "xor"]

LONGEST = 512
_NUMBER = re.compile(rb" *([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?|[+-]?(?:nan|inf|NAN|INF|ovf)) *")
_WORDS = {b"ovf": b"inf"}
"""What an Arduino prints for a number that is too large for it."""


class Lines:
    """Cuts a stream at its line feeds. Of a line without end, the last LONGEST bytes are kept."""

    def __init__(self, statistics: Statistics) -> None:
        self._statistics = statistics
        self._rest = b""

    @property
    def held(self) -> int:
        """Bytes of the line that is not complete."""
        return len(self._rest)

    def lines(self, data: bytes) -> list[bytes]:
        """Take bytes in and give the lines that they complete, stripped of white space, and not the empty ones."""
        *whole, rest = (self._rest + data).split(b"\n")
        self._rest = self._cut(rest)
        return [stripped for line in whole if (stripped := self._cut(line).strip())]

    def _cut(self, line: bytes) -> bytes:
        self._statistics.bytes_skipped += max(len(line) - LONGEST, 0)
        return line[-LONGEST:]


class TextDecoder(Decoder):
    """Reads a stream line by line."""

    is_text = True

    def __init__(self) -> None:
        super().__init__()
        self._lines = Lines(self.statistics)

    @property
    def held(self) -> int:
        """Bytes of the line that is not complete."""
        return self._lines.held

    def feed(self, data: bytes) -> list[Measurement]:
        """Take bytes in and give a measurement for every good line."""
        return self._measurements(self._lines.lines(data))

    def _measurements(self, lines: list[bytes]) -> list[Measurement]:
        found = (self._measurement(line) for line in lines)
        return [measurement for measurement in found if measurement is not None]

    @abstractmethod
    def _measurement(self, line: bytes) -> Measurement | None:
        """What a line says; None, counted, if it says nothing that is asked for."""


def marked(line: bytes, mark: bytes, statistics: Statistics) -> tuple[bytes, bytes] | None:
    """Body and checksum text of ``<mark>body*checksum``, from the last mark in the line; None, counted, without both.

    What stands before the mark is garbage that lacked a line end.
    """
    start, star = line.rfind(mark), line.rfind(b"*")
    if not 0 <= start < star:
        statistics.bytes_skipped += len(line)
        return None
    statistics.bytes_skipped += start
    statistics.resynchronisations += start > 0
    return line[start:star], line[star + 1 :]


def xor(data: bytes) -> int:
    """All bytes under exclusive or, as NMEA 0183 has it."""
    result = 0
    for byte in data:
        result ^= byte
    return result


def numbers(fields: Sequence[bytes]) -> list[float] | None:
    """The fields as numbers, NaN and infinity among them; None if one of them is no number.

    Stricter than float(): no ``1_0``, no ``infinity``, no digits of other scripts.
    """
    matches = [_NUMBER.fullmatch(field) for field in fields]
    if not all(matches):
        return None
    return [float(_WORDS.get(match[1], match[1])) for match in matches if match]


def triple(values: Sequence[float], factor: float) -> Triple:
    """Three numbers times a factor."""
    x, y, z = values
    return (factor * x, factor * y, factor * z)
