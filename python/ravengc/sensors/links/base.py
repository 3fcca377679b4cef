"""What a link is: a source of bytes that can be waited for."""

from __future__ import annotations

from typing import Protocol

__all__ = ["LARGEST_READ", "Link"]

LARGEST_READ = 4096


class Link(Protocol):
    """Bytes in, and out where it can.

    ``name`` says which link it is. ``is_datagram``: each piece is a datagram. ``foreign`` counts datagrams from others
    than the sender. ``finished``: the end of a file was reached.
    """

    name: str
    is_datagram: bool
    foreign: int
    finished: bool

    def receive(self, timeout_s: float) -> bytes:
        """Wait at most ``timeout_s`` for bytes; empty if none came. SensorError when the link is gone."""

    def send(self, data: bytes) -> None:
        """Send what can be sent without waiting. SensorError when the link is gone."""

    def close(self) -> None:
        """Let go of the link; more than once is no error."""
