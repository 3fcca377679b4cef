"""From the options of ``ravengc identify fit`` to an identification: logs read, prepared and parted, and the fit."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeVar

from ravengc.cli.common import quantity
from ravengc.cli.identify_logs import logs_from
from ravengc.cli.identify_model import model_from
from ravengc.errors import CalibrationError, ConfigError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

    from ravengc.identify import Bounds, Identification, Model, Recording

    Recordings = tuple[Recording, ...]

T = TypeVar("T")

__all__ = ["Fit", "fitted"]


@dataclass(frozen=True)
class Fit:
    """What was identified, from which recordings as they were read, fitted to and tested, and why it is no file."""

    found: Identification
    read: Recordings
    train: Recordings
    held: Recordings
    why_no_file: str | None

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the numbers should know, with the log in front where there are several."""
        several = len({one.source for one in (*self.read, *self.held)}) > 1
        found = ((one.source, note) for one in (*self.read, *self.train, *self.held) for note in one.notes)
        return tuple(dict.fromkeys(f"{source}: {note}" if several else note for source, note in found))

    @property
    def skipped(self) -> dict[str, int]:
        """Rows that were left out, by reason, of all logs."""
        total: dict[str, int] = {}
        for one in self.read:
            for reason, rows in one.skipped.items():
                total[reason] = total.get(reason, 0) + rows
        return total


def fitted(args: argparse.Namespace, advance: Callable[[str], None]) -> Fit:
    """Read, prepare, part and identify; ``advance`` is called after every log and after the fit."""
    import ravengc
    from ravengc import identify

    robot = ravengc.load(args.robot)
    model, bounds = model_from(args, robot), _bounds(args)
    _check_held_out(args)
    (tilts, held_tilt), (counted, held_counted) = _apart(args, args.tilt, "--tilt"), _apart(args, args.at, "--at")
    read = logs_from(args, robot, args.logs, tilts, advance, counted=counted)
    other = logs_from(args, robot, _held_out_log(args), held_tilt, counted=held_counted)
    train, held = _parted(args, model, read, other)
    found = identify.identify(robot, train, model, args.estimator, held_out=held, bounds=bounds)
    advance("identified")
    return Fit(found, tuple(read), train, held, _why_no_file(found, args.friction_share))


def _parted(
    args: argparse.Namespace, model: Model, read: list[Recording], other: list[Recording]
) -> tuple[Recordings, Recordings]:
    """What is fitted to and what is held out, both prepared for the model."""
    from ravengc import identify

    cutoff = _cutoff(args.cutoff)
    whole, held = (tuple(identify.prepared(one, model, cutoff) for one in logs) for logs in (read, other))
    share = _share(args.held_out)
    if share is None:
        return whole, held
    train, held = zip(*(identify.parted(one, share) for one in whole), strict=True)
    return train, held


def _check_held_out(args: argparse.Namespace) -> None:
    if os.path.realpath(args.held_out) in map(os.path.realpath, args.logs):
        raise ConfigError(f"--held-out {args.held_out} is one of the logs; what is fitted to tests nothing")


def _held_out_log(args: argparse.Namespace) -> list[str]:
    return [] if _share(args.held_out) is not None else [args.held_out]


def _apart(args: argparse.Namespace, given: list[T], option: str) -> tuple[list[T], list[T]]:
    """What was said of the logs, and of the one that is held out, of which it is said last."""
    if not _held_out_log(args):
        return given, []
    if len(given) < 2:
        return given, given
    if len(given) != len(args.logs) + 1:
        logs = f"{len(args.logs)} logs and the one held out"
        raise ConfigError(f"{len(given)} x {option} for {logs}; expected one for all, or one for each")
    return given[:-1], given[-1:]


def _share(text: str) -> float | None:
    """The share that is held out; ``None`` for a file."""
    try:
        return float(text)
    except ValueError:
        return None


def _cutoff(text: str) -> float | Literal["auto"] | None:
    if text == "auto":
        return "auto"
    if text == "none":
        return None
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"--cutoff {text!r}: expected a number of Hz, auto or none") from None


def _bounds(args: argparse.Namespace) -> Bounds | None:
    from ravengc.identify import Bounds

    if args.estimator != "consistent":
        if args.total_mass is not None or args.reach is not None:
            raise ConfigError("--total-mass and --reach bound the estimator consistent; say --estimator consistent")
        return None
    reach = 1.0 if args.reach is None else quantity(args.reach, "length", "--reach")
    mass = None if args.total_mass is None else quantity(args.total_mass, "mass", "--total-mass")
    return Bounds(reach=reach, total_mass=mass)


def _why_no_file(found: Identification, friction_share: float) -> str | None:
    """Why no robot has these parameters; ``None`` if one does."""
    try:
        found.robot(friction_share)
    except CalibrationError as error:
        return str(error)
    return None
