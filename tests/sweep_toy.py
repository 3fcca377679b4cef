"""An experiment that costs nothing, for sweeps of it; processes import it from here."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ravengc.errors import ConfigError, MissingExtraError
from ravengc.experiments import Experiment, Outcome, Settings, setting

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True)
class Toy(Settings):
    x: float = setting(0.5, 0.0, 10.0, "m", "a number")
    y: float = setting(0.1, 0.001, 1e3, "s", "another")
    n: int = setting(3, 1, 100, "", "a whole number")
    kind: str = setting("plain", doc="a text", choices=("plain", "odd"))
    flag: bool = setting(default=False, doc="a flag")
    pair: tuple[float, ...] = setting((1.0, 2.0), 0.0, 9.0, "N", "two numbers", count=2)
    many: tuple[float, ...] = setting((1.0, 2.0), 0.0, 9.0, "N", "some numbers")
    seed: int = setting(0, 0, 2**63 - 1, "", "a seed")

    def check(self) -> None:
        if self.x >= 5.0 and self.flag:
            raise ConfigError("x and flag do not fit together")


def _tasks(settings: Toy) -> list[Toy]:
    return [settings]


def _run(settings: Toy) -> dict[str, float]:
    if settings.n == 13:
        raise ConfigError("thirteen brings\nbad luck")
    if settings.n == 66:
        os._exit(1)
    if settings.n == 77:
        raise MissingExtraError("nothing", "sim", "seventy-seven")
    if settings.n == 88:
        raise ZeroDivisionError("a bug")
    numbers = {"product": settings.x * settings.y * sum(settings.many), "dice": settings.seed / 2**63, "n": 1.0}
    if settings.n == 2:
        numbers |= {"only_two": 1.0, "nothing": math.nan, "endless": -math.inf}
    return numbers


def _combine(_: Toy, results: Sequence[dict[str, float]]) -> Outcome:
    return Outcome(results[0])


def _draw(figure: Figure, outcome: Outcome) -> None:
    figure.suptitle(str(outcome.numbers))


TOY = Experiment("toy", "Toy", "nowhere", "Nothing.", Toy, _tasks, _run, _combine, _draw)


@dataclass(frozen=True, kw_only=True)
class Plain(Settings):
    x: float = setting(0.5, 0.0, 10.0, "m", "a number")


def _plain_run(settings: Plain) -> dict[str, float]:
    return {"x2": 2.0 * settings.x}


UNSEEDED = Experiment("plain", "Plain", "nowhere", "No seed.", Plain, _tasks, _plain_run, _combine, _draw)
