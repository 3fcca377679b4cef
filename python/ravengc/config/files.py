"""Files in and out: read whole with a size cap, written so that a failure half-way leaves the old file."""

from __future__ import annotations

import os
import stat
from typing import TYPE_CHECKING

from ravengc.errors import ConfigError, ParseError
from ravengc.messages import near_file

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["MAX_BYTES", "decode", "read_bytes", "refuse_oversized", "write_atomically"]

MAX_BYTES = 8 * 1024 * 1024
"""Largest robot file that is read."""


def read_bytes(path: Path) -> bytes:
    """Return the content of a file of at most 8 MiB; ParseError when it is larger or cannot be read.

    A pipe or a device, which could keep the reader waiting for ever, is refused.
    """
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            is_file = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
            data = file.read(MAX_BYTES + 1) if is_file else b""
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        near = near_file(path) if isinstance(error, FileNotFoundError) else ""
        raise ParseError(f"cannot be read: {_reason(error)}{near}", file=str(path)) from error
    if not is_file:
        raise ParseError("cannot be read: it is a pipe or a device, expected a file", file=str(path))
    refuse_oversized(data, str(path))
    return data


def refuse_oversized(data: bytes, file: str) -> None:
    """Raise ParseError when there are more bytes than a robot file may have."""
    if len(data) > MAX_BYTES:
        raise ParseError(f"larger than {MAX_BYTES // 2**20} MiB, the largest robot file that is read", file=file)


def decode(data: bytes, file: str) -> str:
    """Return UTF-8 text (a byte-order mark is dropped); ParseError with line and column at the first wrong byte."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        message = f"byte 0x{data[error.start]:02x} is not UTF-8 text"
        raise ParseError(message, file=file, line=line, column=column) from error


def write_atomically(path: Path, text: str) -> None:
    """Write UTF-8 text to ``path``, whole or not at all: after a failure (ConfigError) an old file is still there."""
    from ravengc.atomic import replacing

    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError as error:
        raise ConfigError(f"{path}: cannot be written: the text is not valid Unicode: {error.reason}") from error
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _reason(error: OSError | ValueError) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)
