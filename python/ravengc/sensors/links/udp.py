"""Datagrams on a UDP port: from the first sender alone, for as long as it speaks."""

from __future__ import annotations

import contextlib
import errno
import socket
import time
from typing import Any

from ravengc.errors import SensorError
from ravengc.sensors.links.descriptor import wait_readable

__all__ = ["LOOPBACK", "UdpLink"]

LOOPBACK = "127.0.0.1"
LARGEST_DATAGRAM = 65535
SILENCE_NS = 1_000_000_000


class UdpLink:
    """Receives on ``host:port``; ``host`` is loopback unless another is asked for, so that nobody outside is heard.

    Datagrams of others than the sender are counted and dropped until the sender has been silent for a second. Whoever
    can forge the sender's address is heard as the sender: a host other than loopback belongs on a network of its own.
    """

    def __init__(self, port: int, host: str = LOOPBACK) -> None:
        self.name = f"udp:{host}:{port}"
        self.is_datagram = True
        self.foreign = 0
        self.finished = False
        self._sender: Any = None
        self._heard_ns = 0
        try:
            family = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0][0]
            self._socket = socket.socket(family, socket.SOCK_DGRAM)
        except (OSError, ValueError) as error:
            raise SensorError(f"{self.name}: {getattr(error, 'strerror', None) or error}") from error
        self._bind(host, port)

    def _bind(self, host: str, port: int) -> None:
        try:
            self._socket.setblocking(False)
            self._socket.bind((host, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise SensorError(f"{self.name}: {_reason(error)}") from error

    @property
    def port(self) -> int:
        """The port that is listened to, also where port 0 asked for any."""
        number: int = self._socket.getsockname()[1]
        return number

    def receive(self, timeout_s: float) -> bytes:
        """Wait at most ``timeout_s`` for a datagram of the sender; empty if none came."""
        deadline = time.monotonic() + timeout_s
        while True:
            data = self._datagram(deadline - time.monotonic())
            if data or time.monotonic() >= deadline:
                return data

    def _datagram(self, timeout_s: float) -> bytes:
        try:
            if not wait_readable(self._socket.fileno(), timeout_s):
                return b""
            data, sender = self._socket.recvfrom(LARGEST_DATAGRAM)
        except (BlockingIOError, ConnectionRefusedError):  # the second: somebody did not want our last answer
            return b""
        except (OSError, ValueError) as error:
            raise SensorError(f"{self.name}: lost while reading: {error}") from error
        return data if self._is_ours(sender) else b""

    def _is_ours(self, sender: Any) -> bool:
        now = time.monotonic_ns()
        if sender != self._sender and self._sender is not None and now - self._heard_ns < SILENCE_NS:
            self.foreign += 1
            return False
        self._sender, self._heard_ns = sender, now
        return True

    def send(self, data: bytes) -> None:
        """Answer the sender, if there is one yet."""
        if self._sender is None:
            return
        with contextlib.suppress(OSError):
            self._socket.sendto(data, self._sender)

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def _reason(error: OSError | OverflowError) -> str:
    number = error.errno if isinstance(error, OSError) else None
    if number == errno.EADDRINUSE:
        return "busy: another program has the port"
    if number == errno.EADDRNOTAVAIL:
        return "no address of this machine: give one that it has, or 0.0.0.0 for all of them"
    if number == errno.EACCES:
        return "not permitted; ports from 1024 on are free to all"
    return str(error)
