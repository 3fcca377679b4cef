"""Links over a file descriptor: ports, pipes and files, read without blocking."""

from __future__ import annotations

import contextlib
import math
import os
import select
import stat
import sys
from pathlib import Path

from ravengc.errors import SensorError
from ravengc.sensors.links.base import LARGEST_READ

__all__ = ["DescriptorLink", "open_file", "open_stdin", "wait_readable"]


def wait_readable(descriptor: int, timeout_s: float) -> bool:
    """Wait until there is something to read, an end or an error."""
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(math.ceil(1000.0 * max(timeout_s, 0.0))))


class DescriptorLink:
    """Reads a descriptor that is set to non-blocking. ``ends``: its end is the end of a file, not a lost port."""

    def __init__(self, descriptor: int, name: str, *, ends: bool) -> None:
        self.name = name
        self.is_datagram = False
        self.foreign = 0
        self.finished = False
        self._descriptor: int | None = descriptor
        self._ends = ends

    def receive(self, timeout_s: float) -> bytes:
        """Wait at most ``timeout_s`` for bytes; empty if none came, or at the end of a file."""
        descriptor = self._open()
        try:
            if not wait_readable(descriptor, timeout_s):
                return b""
            data = os.read(descriptor, LARGEST_READ)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise SensorError(f"{self.name}: lost while reading: {error.strerror or error}") from error
        if not data:
            self._end()
        return data

    def send(self, data: bytes) -> None:
        """Write what fits into the port's buffer."""
        descriptor = self._open()
        try:
            os.write(descriptor, data)
        except BlockingIOError:
            return
        except OSError as error:
            raise SensorError(f"{self.name}: lost while writing: {error.strerror or error}") from error

    def close(self) -> None:
        """Close the descriptor, once."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(descriptor)

    def _open(self) -> int:
        if self._descriptor is None:
            raise SensorError(f"{self.name}: closed")
        return self._descriptor

    def _end(self) -> None:
        if not self._ends:
            raise SensorError(f"{self.name}: unplugged, or closed from the other side")
        self.finished = True


class _ReadOnlyLink(DescriptorLink):
    """A file: what would be sent to a sensor goes nowhere."""

    def send(self, data: bytes) -> None:
        """Send nothing."""


def open_file(path: str) -> DescriptorLink:
    """A file of recorded bytes, read to its end, or a named pipe, which outlives those who write to it."""
    try:
        kind = Path(path).stat().st_mode
        flags = os.O_RDWR if stat.S_ISFIFO(kind) else os.O_RDONLY
        descriptor = os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)
    except (OSError, ValueError) as error:
        raise SensorError(f"file {path!r} cannot be opened: {getattr(error, 'strerror', None) or error}") from error
    if stat.S_ISDIR(kind):
        os.close(descriptor)
        raise SensorError(f"file {path!r} is a folder")
    return _ReadOnlyLink(descriptor, f"file:{path}", ends=stat.S_ISREG(kind))


def open_stdin() -> DescriptorLink:
    """Standard input, to its end."""
    try:
        descriptor = os.dup(sys.stdin.fileno())
    except (OSError, ValueError, AttributeError) as error:
        raise SensorError(f"standard input cannot be read: {error}") from error
    return _ReadOnlyLink(descriptor, "stdin:", ends=True)
