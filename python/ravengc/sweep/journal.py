"""The journal of a sweep: a line of JSON per finished trial, on the disk before the next one is asked for.

A process that is killed leaves at most a torn last line, which is dropped. One process at a time may write.
"""

from __future__ import annotations

import errno
import fcntl
import json
import math
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ravengc.errors import ConfigError, ParseError
from ravengc.messages import shown

if TYPE_CHECKING:
    from pathlib import Path
    from types import TracebackType
    from typing import Self

__all__ = ["Journal", "Result", "read_journal"]


@dataclass(frozen=True)
class Result:
    """What came of a trial: its numbers, or the message of the error that ended it."""

    numbers: dict[str, float] = field(default_factory=dict)
    error: str = ""


class Journal:
    """A journal that is open for a sweep of ``total`` trials; ``results`` has what it knew when it was opened.

    Raises ConfigError where it cannot be written or another sweep is at it, ParseError for lines that are not its own.
    """

    def __init__(self, path: Path, total: int) -> None:
        self._path = path
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        except OSError as error:
            raise ConfigError(f"{path}: cannot be written: {error.strerror}") from error
        try:
            self._lock()
            self.results, kept = read_journal(path, total)
            os.ftruncate(self._file, kept)
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._file)

    def add(self, index: int, result: Result) -> None:
        """Append a trial and flush it to the disk; ConfigError where that fails, with nothing appended."""
        line = (json.dumps(_line(index, result), allow_nan=False) + "\n").encode()
        before = os.fstat(self._file).st_size
        try:
            if os.write(self._file, line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))  # noqa: TRY301 -- handled as the others are
            os.fsync(self._file)
        except OSError as error:
            os.ftruncate(self._file, before)
            raise ConfigError(f"{self._path}: cannot be written: {error.strerror}") from error

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise ConfigError(f"{self._path}: another sweep is at work in this folder") from None


def read_journal(path: Path, total: int) -> tuple[dict[int, Result], int]:
    """Return the results by trial, and how many bytes of whole lines there are: a torn last line is left out.

    Raises ParseError, with file and line, for a line that is not one of a journal of ``total`` trials.
    """
    results: dict[int, Result] = {}
    kept = 0
    try:
        with path.open("rb") as file:
            for number, line in enumerate(file, start=1):
                if not line.endswith(b"\n"):
                    break
                index, result = _parsed(line, total, str(path), number)
                results.setdefault(index, result)
                kept += len(line)
    except OSError as error:
        raise ParseError(f"cannot be read: {error.strerror}", file=str(path)) from error
    return results, kept


def _line(index: int, result: Result) -> dict[str, Any]:
    if result.error:
        return {"trial": index, "error": result.error}
    return {"trial": index, "numbers": {name: _written(value) for name, value in result.numbers.items()}}


def _written(value: float) -> float | str:
    """JSON has no numbers that are not finite."""
    return value if math.isfinite(value) else repr(value)


def _parsed(line: bytes, total: int, file: str, number: int) -> tuple[int, Result]:
    try:
        entry = json.loads(line)
        index = entry["trial"]
        numbers = {str(name): float(value) for name, value in entry.get("numbers", {}).items()}
        error = entry.get("error", "")
        sound = type(index) is int and 0 <= index < total and isinstance(error, str) and len(entry) == 2
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        sound = False
    if not sound:
        expected = f"expected a finished trial from 0 to {total - 1}; remove this line to run its trial again"
        raise ParseError(f"{shown(line.decode(errors='replace').rstrip())}; {expected}", file=file, line=number)
    return index, Result(numbers, error)
