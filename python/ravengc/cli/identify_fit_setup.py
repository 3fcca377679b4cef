"""From the options of ``ravengc identify fit`` to an identification: logs read, prepared and parted, and the fit."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from ravengc.cli.common import quantity
from ravengc.cli.identify_logs import logs_from
from ravengc.cli.identify_model import model_from
from ravengc.errors import CalibrationError, ConfigError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

    from ravengc.identify import Bounds, Identification, Model, Recording
    from ravengc.robot import Robot

    Recordings = tuple[Recording, ...]

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
    tilts, held_tilt = _tilts(args)
    read = logs_from(args, robot, args.logs, tilts, advance)
    train, held = _parted(args, robot, model, read, held_tilt)
    found = identify.identify(robot, train, model, args.estimator, held_out=held, bounds=bounds)
    advance("identified")
    return Fit(found, tuple(read), train, held, _why_no_file(found, args.friction_share))


def _parted(
    args: argparse.Namespace, robot: Robot, model: Model, read: list[Recording], held_tilt: list[str]
) -> tuple[Recordings, Recordings]:
    """What is fitted to and what is held out, both prepared for the model."""
    from ravengc import identify

    cutoff = _cutoff(args.cutoff)
    whole = tuple(identify.prepared(one, model, cutoff) for one in read)
    share = _share(args.held_out)
    if share is not None:
        train, held = zip(*(identify.parted(one, share) for one in whole), strict=True)
        return train, held
    other = logs_from(args, robot, [args.held_out], held_tilt)
    return whole, tuple(identify.prepared(one, model, cutoff) for one in other)


def _tilts(args: argparse.Namespace) -> tuple[list[str], list[str]]:
    """Tilts of the logs, and of the one that is held out, which is said last."""
    if _share(args.held_out) is not None:
        return args.tilt, []
    if os.path.realpath(args.held_out) in map(os.path.realpath, args.logs):
        raise ConfigError(f"--held-out {args.held_out} is one of the logs; what is fitted to tests nothing")
    if len(args.tilt) < 2:
        return args.tilt, args.tilt
    if len(args.tilt) != len(args.logs) + 1:
        logs = f"{len(args.logs)} logs and the one held out"
        raise ConfigError(f"{len(args.tilt)} x --tilt for {logs}; expected one for all, or one for each")
    return args.tilt[:-1], args.tilt[-1:]


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
