"""A file's bytes, whole and with a limit; bundled files by ``example:NAME``."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ravengc._convert import as_path, check_choice
from ravengc.errors import ParseError
from ravengc.messages import did_you_mean

__all__ = ["CLOUDS", "MOTIONS", "file_at", "read_file"]

PREFIX = "example:"
CLOUDS = {"organ": "organ_phantom/organ.ply"}
MOTIONS = {"breathing": "breathing_marker/marker.csv", "heart": "beating_heart/heart.csv"}
LARGEST_BYTES = 512 * 2**20


def file_at(source: str | os.PathLike[str], bundled: dict[str, str], what: str) -> Path:
    """Return the path that ``source`` names: a file's, or that of a bundled one; ConfigError for an unknown name."""
    text = str(as_path(source, what))
    if not text.startswith(PREFIX):
        return Path(text)
    name = text.removeprefix(PREFIX)
    check_choice(name, bundled, f"bundled {what}")
    return Path(__file__).parent.parent / "examples" / bundled[name]


def read_file(path: Path) -> bytes:
    """Return a regular file's bytes; ParseError for none, an empty one, a folder, a pipe, and beyond 512 MiB."""
    try:
        data = _bytes_of(path)
    except ParseError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        reason = getattr(error, "strerror", None) or str(error)
        raise ParseError(f"cannot be read: {reason}{_near(path)}", file=str(path)) from error
    if not data:
        raise ParseError("empty", file=str(path))
    return data


def _bytes_of(path: Path) -> bytes:
    """A pipe or a device could keep the reader waiting for ever, and a huge file fill the memory."""
    with open(path, "rb", opener=_without_waiting) as file:
        state = os.fstat(file.fileno())
        if not stat.S_ISREG(state.st_mode):
            raise ParseError("cannot be read: it is a pipe or a device, expected a file", file=str(path))
        if state.st_size > LARGEST_BYTES:
            size = f"{state.st_size / 2**20:.0f} MiB; at most {LARGEST_BYTES // 2**20} MiB are read"
            raise ParseError(size, file=str(path))
        return file.read(LARGEST_BYTES)


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _near(path: Path) -> str:
    """The file that was meant: of the same kind, or the same name with another ending."""
    try:
        beside = [] if path.exists() else list(path.parent.iterdir())
        alike = [entry.name for entry in beside if path.suffix == entry.suffix or path.stem == entry.stem]
        return did_you_mean(path.name, alike)
    except (OSError, ValueError):
        return ""
