"""Base motions as a word on a command line: ``rocking:10:20:1``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from ravengc._convert import check_type
from ravengc.errors import ConfigError
from ravengc.messages import shown
from ravengc.sim.base_file import read_recorded
from ravengc.sim.base_profiles import ProfiledBase, acceleration_step, elevator
from ravengc.sim.base_swings import BaseTrajectory, level, rocking, ship, tilted

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ravengc.sim.base_motion import Axis

__all__ = ["BASE_FORMS", "parse_base"]

RECORDED = "recorded:FILE"
SHIP = ("roll_deg", "roll_hz", "pitch_deg", "pitch_hz", "heave", "heave_hz")
ELEVATOR = ("speed", "acceleration", "jerk")


def _named(names: Sequence[str], numbers: Sequence[float]) -> dict[str, Any]:
    """The first of the names with the numbers there are."""
    return dict(zip(names, numbers, strict=False))


class Form(NamedTuple):
    """How a motion is written, how many numbers that may be, and what makes it of them, of an axis and of a pivot."""

    text: str
    counts: tuple[int, ...]
    make: Callable[[list[float], Axis, Sequence[float]], BaseTrajectory | ProfiledBase]


KINDS = {
    "level": Form("level", (0,), lambda _n, _a, _p: level()),
    "tilt": Form("tilt:DEG", (1,), lambda n, axis, _p: tilted(n[0], axis)),
    "rocking": Form(
        "rocking:LOW:HIGH:HZ", (3,), lambda n, axis, pivot: rocking(n[0], n[1], hz=n[2], axis=axis, pivot=pivot)
    ),
    "ship": Form("ship[:ROLL:HZ:PITCH:HZ:HEAVE:HZ]", (0, 6), lambda n, _a, _p: ship(**_named(SHIP, n))),
    "elevator": Form(
        "elevator:TRAVEL[:SPEED[:ACCELERATION[:JERK]]]",
        (1, 2, 3, 4),
        lambda n, _a, _p: elevator(n[0], **_named(ELEVATOR, n[1:])),
    ),
    "step": Form(
        "step:ACCELERATION:START:END", (3,), lambda n, axis, _p: acceleration_step(n[0], axis, start_s=n[1], end_s=n[2])
    ),
}
BASE_FORMS = (*(form.text for form in KINDS.values()), RECORDED)
"""How each kind of motion is written; angles in degrees, the rest in SI units."""


def parse_base(
    text: str, *, axis: Axis = "x", pivot: Sequence[float] = (0.0, 0.0, 0.0)
) -> BaseTrajectory | ProfiledBase:
    """Read one of :data:`BASE_FORMS`: ``tilt:20``, ``ship``, ``elevator:10``, ``step:2:1:3``, ``recorded:sea.csv``.

    ``axis`` is that of tilt, rocking and step, ``pivot`` that of rocking. ConfigError for anything else, ParseError
    for a file that cannot be read.
    """
    check_type(text, str, "text")
    kind, *words = text.split(":")
    if kind == "recorded" and any(words):
        return read_recorded(text.partition(":")[2])
    try:
        numbers = [float(word) for word in words]
        form = KINDS[kind]
    except (KeyError, ValueError):
        raise _unreadable(text) from None
    if len(numbers) not in form.counts:
        raise _unreadable(text)
    return form.make(numbers, axis, pivot)


def _unreadable(text: str) -> ConfigError:
    forms = f"{', '.join(BASE_FORMS[:-1])} or {BASE_FORMS[-1]}"
    return ConfigError(f"base {shown(text)}: write {forms}; for example tilt:20 or rocking:10:20:1")
