"""Frames out of bytes: found by their first byte, believed for their checksum, lost and found again within one frame.

Every place where a frame could start is remembered until it is refuted, and the frame that is complete first wins.
So a false start in front of a good frame, whatever length it claims, delays nothing and swallows nothing, and how the
bytes are cut into pieces changes no result. Memory is bounded by the longest frame and the piece that is given.
"""

from __future__ import annotations

import re
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.sensors.sample import Statistics

__all__ = ["INCOMPLETE", "NO_FRAME", "Framer"]

T = TypeVar("T")

INCOMPLETE = 0
"""The length of a frame whose header is not there yet."""
NO_FRAME = -1
"""The length where no frame starts."""


class Framer(Generic[T]):
    """Cuts a stream into frames.

    ``starts`` holds the bytes a frame can start with. ``length(buffer, start)`` gives the whole length of a frame that
    starts there, INCOMPLETE or NO_FRAME; ``parse(frame)`` what is in it, or None if its checksum is wrong. ``grid`` is
    the length of all frames where the checksum is a mere sum of 8 bits: there, garbage passes once in 256 times, so a
    frame right behind garbage that does not keep to the grid is counted as unconfirmed and left out.
    """

    def __init__(
        self,
        starts: bytes,
        length: Callable[[bytes, int], int],
        parse: Callable[[bytes], T | None],
        statistics: Statistics,
        *,
        grid: int | None = None,
    ) -> None:
        self._start = re.compile(b"[" + re.escape(starts) + b"]")
        self._length = length
        self._parse = parse
        self._statistics = statistics
        self._grid = grid
        self._buffer = b""
        self._used = 0
        self._scanned = 0
        self._gap = 0
        self._open: list[tuple[int, int]] = []  # heap of (end, start): frames that may be

    @property
    def held(self) -> int:
        """Bytes that are kept for frames that are not complete."""
        return len(self._buffer)

    def frames(self, data: bytes) -> list[T]:
        """Take the bytes in and give what is in every frame that they complete."""
        self._buffer += data
        contents = []
        while (found := self._next()) is not None:
            start, end, content = found
            if self._accept(start, end):
                contents.append(content)
        self._forget()
        return contents

    def _next(self) -> tuple[int, int, T] | None:
        """The good frame that ends first, and where; None if none is complete."""
        while self._scan() <= len(self._buffer):
            end, start = heappop(self._open)
            content = self._parse(self._buffer[start:end])
            if content is not None:
                return start, end, content
            self._statistics.bad_checksum += 1
        return None

    def _scan(self) -> int:
        """Find starts up to where the first open frame ends, and return that end, beyond the buffer if there is none.

        A start further on cannot be complete any sooner.
        """
        while True:
            limit = self._open[0][0] if self._open else len(self._buffer) + 1
            found = self._start.search(self._buffer, self._scanned, limit)
            length = NO_FRAME if found is None else self._length(self._buffer, found.start())
            if found is None or length == INCOMPLETE:
                self._scanned = found.start() if found else max(self._scanned, min(limit, len(self._buffer)))
                return limit
            self._scanned = found.start() + 1
            if length != NO_FRAME:
                heappush(self._open, (found.start() + length, found.start()))

    def _accept(self, start: int, end: int) -> bool:
        """Put the frame behind us, and tell whether it can be believed."""
        gap = self._gap + start - self._used
        self._statistics.bytes_skipped += start - self._used
        self._statistics.resynchronisations += gap > 0
        self._used = self._scanned = end
        self._gap = 0
        self._open.clear()
        confirmed = self._grid is None or gap % self._grid == 0
        self._statistics.unconfirmed += not confirmed
        return confirmed

    def _forget(self) -> None:
        """Let go of all bytes that can be part of no frame any more."""
        cut = min((start for _, start in self._open), default=self._scanned)
        skipped = cut - self._used
        self._gap += skipped
        self._statistics.bytes_skipped += skipped
        self._buffer = self._buffer[cut:]
        self._open = [(end - cut, start - cut) for end, start in self._open]
        self._scanned -= cut
        self._used = 0
