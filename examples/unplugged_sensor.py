"""A base sensor that is unplugged in the middle of a run and plugged in again, without any hardware.

`python examples/unplugged_sensor.py` sends checksummed lines at 100 Hz to a pseudo-terminal, runs `ravengc run` on it
for eight seconds, pulls the plug after three and a half, plugs it in again after five, and draws what the loop saw.
"""

from __future__ import annotations

import math
import os
import pty
import random
import sys
import tempfile
import threading
import time
import tty
from functools import reduce
from operator import xor
from pathlib import Path

from ravengc.cli import main as ravengc

PICTURE = Path("out/unplugged_sensor.png")


class PluggableImu(threading.Thread):
    """A sensor on a pseudo-terminal behind ``path``, which sends lines at 100 Hz while it is plugged in.

    ``plugged`` are times (s) from the start at which the plug goes in and out. The sensor is tilted by 15 degrees.
    """

    def __init__(self, path: Path, plugged: list[tuple[float, float]]) -> None:
        super().__init__(daemon=True)
        self.path, self.plugged, self.stop = path, plugged, threading.Event()

    def run(self) -> None:
        """Plug in and out, until it is stopped."""
        start = time.monotonic()
        for begin, end in self.plugged:
            if self.stop.wait(max(0.0, start + begin - time.monotonic())):
                return
            master, slave = pty.openpty()
            tty.setraw(slave)
            self.path.unlink(missing_ok=True)
            self.path.symlink_to(os.ttyname(slave))
            self._send(master, start, end)
            os.close(master)
            os.close(slave)

    def _send(self, master: int, start: float, end: float) -> None:
        while (now := time.monotonic() - start) < end and not self.stop.wait(0.01):
            os.write(master, line(now))


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
        imu = PluggableImu(Path(folder) / "imu", [(0.0, 3.5), (5.0, 60.0)])
        imu.start()
        while not imu.path.is_symlink():
            time.sleep(0.01)
        options = ["--duration", "8", "--base", "tilt:15", "--plot", str(PICTURE)]
        code = ravengc(["run", "--sensor", f"serial:{imu.path}?format=line", *options])
        imu.stop.set()
        imu.join()
    return code


if __name__ == "__main__":
    sys.exit(main())
