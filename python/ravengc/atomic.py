"""Files that appear whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["check_writable", "replacing"]


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a path in the same folder to write to; afterwards flush that file to the disk and rename it to ``path``.

    The folder is made if needed, a link is followed, and permissions of the old file are kept. When writing fails the
    old file, if any, stays, and OSError becomes ConfigError.
    """
    target = _behind_links(path)
    temporary = target.with_name(f".{secrets.token_hex(4)}{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        with temporary.open("rb") as file:
            os.fsync(file.fileno())
        if target.exists():
            temporary.chmod(target.stat().st_mode & 0o7777)
        temporary.replace(target)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {_reason(error, target)}") from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def check_writable(path: Path) -> None:
    """Raise ConfigError if a file could not be written at ``path``, before the work whose result it is to hold.

    Leaves everything as it is: tries a file in the folder, or in the nearest one above it that exists.
    """
    target = _behind_links(path)
    try:
        folder = next(parent for parent in target.parents if parent.exists())
        if not folder.is_dir():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(folder))
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        trial = folder / f".{secrets.token_hex(4)}"
        trial.touch()
        trial.unlink()
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {_reason(error, target)}") from error


def _behind_links(path: Path) -> Path:
    try:
        target = Path(os.path.realpath(path))
    except ValueError as error:  # a NUL in the path
        raise ConfigError(f"{path}: cannot be written: {error}") from error
    if not target.name:
        raise ConfigError(f"{path}: cannot be written: it is a folder")
    return target


def _reason(error: OSError, target: Path) -> str:
    if isinstance(error, PermissionError):
        return f"no permission to write in the folder '{target.parent}'; choose a file elsewhere"
    if isinstance(error, FileExistsError):  # where a folder was to be made
        return f"'{error.filename}' is not a folder"
    return error.strerror or str(error)
