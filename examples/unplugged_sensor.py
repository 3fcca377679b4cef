"""A base sensor that is unplugged in the middle of a run and plugged in again, without any hardware.

`python examples/unplugged_sensor.py` sends checksummed lines at 100 Hz to a pseudo-terminal, runs `ravengc run` on it
for eight seconds, pulls the plug after about three, plugs it in again after about five, and draws what the loop saw.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import pty
import random
import sys
import tempfile
import termios
import threading
import time
import tty
from functools import reduce
from operator import xor
from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli import main as ravengc

if TYPE_CHECKING:
    from collections.abc import Callable

PICTURE = Path("out/unplugged_sensor.png")


class PluggableImu(threading.Thread):
    """A sensor on a pseudo-terminal behind ``path``, which sends lines at 100 Hz while it is plugged in.

    ``plugged`` says whether it is, at a time (s) from when somebody first opened the port on, so that it does not
    matter how long the simulator takes to load. The sensor is tilted by 15 degrees.
    """

    def __init__(self, path: Path, plugged: Callable[[float], bool]) -> None:
        super().__init__(daemon=True)
        self.path, self.plugged, self.stop = path, plugged, threading.Event()
        self.born, self.opened = time.monotonic(), math.inf

    @property
    def is_plugged(self) -> bool:
        """Whether it is plugged in now."""
        return self.plugged(max(0.0, time.monotonic() - self.opened))

    def run(self) -> None:
        """Plug in and out, until it is stopped."""
        while not self.stop.wait(0.01):
            if not self.is_plugged:
                continue
            master, slave = pty.openpty()
            tty.setraw(slave)
            os.set_blocking(master, False)
            self.path.unlink(missing_ok=True)
            self.path.symlink_to(os.ttyname(slave))
            self._send(master)
            os.close(master)
            os.close(slave)

    def _send(self, master: int) -> None:
        while self.is_plugged and not self.stop.wait(0.01):
            if self.opened == math.inf and termios.tcgetattr(master)[5] == termios.B115200:
                self.opened = time.monotonic()  # whoever opened it has set its rate
            with contextlib.suppress(BlockingIOError):  # nobody reads
                os.write(master, line(time.monotonic() - self.born))


def line(now: float) -> bytes:
    """A line of the sensor: ``A,<t_us>,ax,ay,az*XX`` with the exclusive or of what stands before the star."""
    angle = math.radians(15.0)
    noisy = (9.80665 * part + random.gauss(0.0, 0.02) for part in (math.sin(angle), 0.0, math.cos(angle)))
    body = f"A,{round(1e6 * now)}," + ",".join(f"{x:.4f}" for x in noisy)
    return f"{body}*{reduce(xor, body.encode()):02X}\r\n".encode()


def main() -> int:
    """Run, unplug, plug in, draw."""
    PICTURE.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        imu = PluggableImu(Path(folder) / "imu", lambda seconds: not 3.0 <= seconds < 4.5)
        imu.start()
        while not imu.path.is_symlink():
            time.sleep(0.01)
        options = ["--duration", "8", "--base", "tilt:15", "--plot", str(PICTURE)]
        code = ravengc(["run", "--sensor", f"serial:{imu.path}?format=line", *options])
        imu.stop.set()
        imu.join()
    return code


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    sys.exit(main())
