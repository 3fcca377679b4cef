"""Where bytes come from: serial ports, UDP, files, pipes and standard input."""

from __future__ import annotations

from ravengc.sensors.links.base import Link
from ravengc.sensors.links.descriptor import open_file, open_stdin
from ravengc.sensors.links.serial_port import BAUD_RATES, open_serial
from ravengc.sensors.links.udp import UdpLink

__all__ = ["BAUD_RATES", "Link", "UdpLink", "open_file", "open_serial", "open_stdin"]
