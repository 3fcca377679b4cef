"""Serial ports by the standard library's termios: raw bytes, eight bits, no parity, one stop bit, for us alone.

Opening an Arduino's port raises DTR, which restarts most boards; the first samples come some two seconds later. HUPCL
is cleared, so that closing the port does not drop DTR and the next opening restarts nothing.
"""

from __future__ import annotations

import errno
import fcntl
import os
import termios
from pathlib import Path

from ravengc.errors import ConfigError, SensorError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.sensors.links.descriptor import DescriptorLink

__all__ = ["BAUD_RATES", "open_serial"]

BAUD_RATES = {
    int(name[1:]): int(value)
    for name, value in vars(termios).items()
    if name[0] == "B" and name[1:].isdecimal() and int(name[1:]) >= 1200
}
"""Rates that the system has a name for, and that name."""
PORTS = ("serial/by-id/*", "ttyUSB*", "ttyACM*", "ttyAMA*", "ttyS?")
"""In /dev."""
MOST_PORTS = 8


def open_serial(path: str, baud: int = 115200) -> DescriptorLink:
    """Open a port, set it up and forget what had come before.

    Raises ConfigError for a rate that the system does not know, SensorError for a port that is missing, busy, not
    permitted or none.
    """
    if baud not in BAUD_RATES:
        raise ConfigError(f"baud {shown(baud)} is no rate of a serial port: choose {listed(map(str, BAUD_RATES))}")
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except (OSError, ValueError) as error:
        raise SensorError(f"serial port {path!r}: {_reason(error, path)}") from error
    try:
        _take(descriptor)
        _set_up(descriptor, BAUD_RATES[baud])
    except (OSError, termios.error) as error:
        os.close(descriptor)
        raise SensorError(f"serial port {path!r}: {_reason(error, path)}") from error
    return DescriptorLink(descriptor, f"serial:{path}", ends=False)


def _take(descriptor: int) -> None:
    """Keep others out: TIOCEXCL for those who open, the lock for the superuser, whom it does not stop."""
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    fcntl.ioctl(descriptor, termios.TIOCEXCL)


def _set_up(descriptor: int, rate: int) -> None:
    """Raw, 8N1. VMIN 1: a read that finds nothing is told from one of a port that is gone, which gives no bytes."""
    modes = termios.tcgetattr(descriptor)
    control = modes[2] & ~(termios.CSIZE | termios.PARENB | termios.CSTOPB | termios.HUPCL | termios.CRTSCTS)
    characters: list[bytes | int] = [b"\0"] * len(modes[6])
    characters[termios.VMIN] = 1
    modes[:] = [0, 0, control | termios.CS8 | termios.CREAD | termios.CLOCAL, 0, rate, rate, characters]
    termios.tcsetattr(descriptor, termios.TCSANOW, modes)
    if termios.tcgetattr(descriptor)[5] != rate:  # tcsetattr is content when anything at all could be set
        raise OSError(errno.EOPNOTSUPP, "the port cannot run at this baud rate")
    termios.tcflush(descriptor, termios.TCIFLUSH)


def _reason(error: Exception, path: str) -> str:
    number, *words = error.args or (None,)
    if number == errno.ENOENT:
        there = [str(port) for pattern in PORTS for port in sorted(Path("/dev").glob(pattern))]
        return f"not there{did_you_mean(path, there)} (ports: {listed(there[:MOST_PORTS]) or 'none'})"
    if number == errno.EACCES:
        return "not permitted; members of the group 'dialout' may open it (usermod -aG dialout USER, then log in again)"
    if number in (errno.EBUSY, errno.EWOULDBLOCK):
        return "busy: another program has it"
    if number in (errno.ENOTTY, errno.EINVAL, errno.EISDIR):
        return "no serial port"
    if number in (errno.EIO, errno.ENXIO, errno.ENODEV):
        return "there is no device behind it"
    return str(words[0] if words else error)
