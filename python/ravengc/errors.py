"""The errors that ravengc raises: one type per kind, all under :class:`RavenGCError`.

Every message says what was wrong, where, and what would be right. Nothing is raised inside a control cycle whose
arguments were accepted once: a bound cycle computes and writes.
"""

from __future__ import annotations

__all__ = [
    "ArgumentError",
    "CalibrationError",
    "ConfigError",
    "LimitError",
    "MissingExtraError",
    "ModelError",
    "ParseError",
    "RavenGCError",
    "SensorError",
    "TimingError",
    "UnitsError",
]


class RavenGCError(Exception):
    """Base class of every error that ravengc raises on purpose."""


class ModelError(RavenGCError, ValueError):
    """A robot that cannot exist: an impossible mass, inertia, frame, tree, coupling or name."""


class UnitsError(RavenGCError, ValueError):
    """A quantity with an unknown unit, a unit of the wrong kind, or units mixed within one vector."""


class ConfigError(RavenGCError, ValueError):
    """A setting that is unknown, missing, of the wrong type or outside its range."""


class LimitError(RavenGCError, ValueError):
    """A joint, torque or rate limit that is not a limit (for example lower above upper)."""


class ArgumentError(RavenGCError, ValueError):
    """An argument of a call with the wrong length, dtype, layout or overlap."""


class CalibrationError(RavenGCError, ValueError):
    """Data that do not determine a calibration, or determine one that no working sensor has.

    The message says what was found, what is missing, and what to record.
    """


class TimingError(RavenGCError, ValueError):
    """A rate, deadline or time stamp that cannot be kept or ordered."""


class SensorError(RavenGCError, OSError):
    """A sensor that cannot be opened or read."""


class MissingExtraError(RavenGCError, ImportError):
    """An optional package is missing; the message names the command that installs it."""

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        self.package = package
        self.extra = extra
        self.purpose = purpose
        super().__init__(f"{purpose} needs the package '{package}': pip install 'ravengc[{extra}]'")

    def __reduce__(self) -> tuple[type[MissingExtraError], tuple[str, str, str]]:
        return type(self), (self.package, self.extra, self.purpose)


class ParseError(RavenGCError, ValueError):
    """A file or text that cannot be read.

    ``file``, ``line`` and ``column`` (both from 1, ``None`` where unknown) say where.
    """

    def __init__(
        self, message: str, *, file: str | None = None, line: int | None = None, column: int | None = None
    ) -> None:
        self.message = message
        self.file = file
        self.line = line
        self.column = column
        where = ":".join(str(part) for part in (file, line, column) if part is not None)
        super().__init__(f"{where}: {message}" if where else message)
