"""Real descriptors for the sensors' tests: pseudo terminals that are plugged and unplugged, threads that send."""

from __future__ import annotations

import contextlib
import os
import select
import termios
import threading
import time
import tty
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from ravengc.sensors import Sample, Sensor

PATIENCE_S = 20.0
"""How long to wait for what must happen; nothing is asserted about how soon it does."""


def wait_for(condition: Callable[[], object]) -> None:
    """Wait until the condition holds."""
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(0.005)


def read_samples(sensor: Sensor, count: int) -> list[Sample]:
    """The next samples."""
    found: list[Sample] = []

    def enough() -> bool:
        while len(found) < count and (sample := sensor.read(0.05)) is not None:
            found.append(sample)
        return len(found) >= count

    wait_for(enough)
    return found


class Board:
    """A device on a pseudo terminal, at a path that stays the same when it is plugged in again."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._ends: tuple[int, ...] = ()
        self.plug()

    def plug(self) -> None:
        """Appear."""
        with self._lock:
            self._ends = os.openpty()
            tty.setraw(self._ends[0])
            os.set_blocking(self._ends[0], False)
            self.path.unlink(missing_ok=True)
            self.path.symlink_to(os.ttyname(self._ends[1]))

    def unplug(self) -> None:
        """Vanish: whoever has the port open gets an error."""
        with self._lock:
            self.path.unlink(missing_ok=True)
            for end in self._ends:
                os.close(end)
            self._ends = ()

    def send(self, data: bytes) -> None:
        """Send, as far as there is somebody who reads."""
        with self._lock, contextlib.suppress(OSError):
            if self._ends:
                os.write(self._ends[0], data)

    def receive(self, timeout_s: float = 0.02) -> bytes:
        """What the host has sent."""
        if not select.select([self._ends[0]], [], [], timeout_s)[0]:
            return b""
        return os.read(self._ends[0], 4096)

    def speed(self) -> int:
        """The rate that the host has set."""
        return int(termios.tcgetattr(self._ends[0])[5])


class Sender:
    """Calls ``step(number)`` again and again in a thread until it is left."""

    def __init__(self, step: Callable[[int], object], period_s: float = 0.002) -> None:
        self._step, self._period_s = step, period_s
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        number = 0
        while not self._done.wait(self._period_s):
            self._step(number)
            number += 1

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()
