"""What a sweep runs: which trials there are, and the settings and the seed that each of them has.

Trial ``i`` is at point ``i // trials`` of the grid (the last key turns fastest) and is the draw ``i % trials`` there.
Its seed and its draws are words of ``SeedSequence(seed, spawn_key=(i,))``, whose output NumPy keeps for good.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_count, check_type
from ravengc.errors import ArgumentError, ConfigError
from ravengc.experiments import EXPERIMENTS, Experiment, Settings, settings_from
from ravengc.experiments.files import experiment_named
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["MOST_TRIALS", "SEED", "Draw", "Plan", "experiment_for", "plan_sweep"]

MOST_TRIALS = 1_000_000
SEED = "seed"
"""The setting that holds an experiment's seed, where it has one; every trial gets its own unless it is swept itself."""
LARGEST_SEED = 2**63 - 1


@dataclass(frozen=True)
class Draw:
    """Random values from ``low`` to ``high``, uniform or with a uniform logarithm; of whole numbers, both ends count.

    Raises ConfigError unless both are finite, ``low`` the smaller, and positive for a logarithm.
    """

    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        """Check the range."""
        check_type(self.log, bool, "log")
        for name in ("low", "high"):
            value = getattr(self, name)
            is_number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
            if not is_number or not abs(value) <= LARGEST_SEED:
                raise ConfigError(f"{name} is {shown(value)}; expected a finite number")
            object.__setattr__(self, name, value.item() if isinstance(value, np.generic) else value)
        if not self.low < self.high:
            raise ConfigError(f"draws from {self.low:g} to {self.high:g}; expected a lower and a higher end")
        if self.log and self.low <= 0:
            raise ConfigError(f"logarithmic draws from {self.low:g}; expected a positive lower end")

    def value(self, share: float, *, whole: bool) -> float:
        """Return the value at a share of the range from 0 to below 1."""
        low, high = self.low, self.high + 1 if whole else self.high
        if self.log:
            found = math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
        else:
            found = low + share * (high - low)
        found = math.floor(found) if whole else found
        return min(max(found, self.low), self.high)


@dataclass(frozen=True)
class Plan:
    """A sweep, all of it checked: made by :func:`plan_sweep`."""

    experiment: Experiment
    settings: Settings
    grid: dict[str, tuple[Any, ...]]
    random: dict[str, Draw]
    trials: int
    seed: int

    @property
    def swept(self) -> tuple[str, ...]:
        """Keys of the grid, then those that are drawn."""
        return (*self.grid, *self.random)

    @property
    def total(self) -> int:
        """Number of trials."""
        return math.prod(len(values) for values in self.grid.values()) * self.trials

    @property
    def seeded(self) -> bool:
        """Tell whether every trial gets a seed of its own."""
        return SEED in _fields(self.experiment) and SEED not in self.swept

    def changes(self, index: int) -> dict[str, Any]:
        """Return the settings of trial ``index`` that are not those of all: seed first, then what is swept."""
        point, _ = divmod(index, self.trials)
        words = np.random.SeedSequence(self.seed, spawn_key=(index,)).generate_state(1 + len(self.random), np.uint64)
        seed, *drawn = (int(word) for word in words)
        found: dict[str, Any] = {SEED: seed >> 1} if self.seeded else {}
        places = np.unravel_index(point, tuple(len(values) for values in self.grid.values())) if self.grid else ()
        found |= {key: values[place] for (key, values), place in zip(self.grid.items(), places, strict=True)}
        return found | {key: self._drawn(key, word) for key, word in zip(self.random, drawn, strict=True)}

    def _drawn(self, key: str, word: int) -> Any:
        like = _fields(self.experiment)[key].default
        single = like[0] if isinstance(like, tuple) else like
        value = self.random[key].value((word >> 11) * 2.0**-53, whole=isinstance(single, int))
        return (value,) if isinstance(like, tuple) else value


def plan_sweep(
    experiment: Experiment | str,
    *,
    grid: Mapping[str, Sequence[Any]] | None = None,
    random: Mapping[str, Draw] | None = None,
    trials: int = 1,
    seed: int = 0,
    settings: Settings | None = None,
) -> Plan:
    """Check what a sweep is to run; see :func:`ravengc.sweep.sweep` for the arguments.

    Raises ConfigError for a key that the experiment does not have, a value outside its range, and a sweep of nothing
    or of more than a million trials; ArgumentError for arguments of the wrong kind.
    """
    found = experiment_for(experiment)
    base = found.settings() if settings is None else settings
    check_type(base, found.settings, "settings")
    points = {} if grid is None else grid
    draws = {} if random is None else random
    for name, table in (("grid", points), ("random", draws)):
        check_type(table, Mapping, name)
        if not all(isinstance(key, str) for key in table):
            raise ArgumentError(f"{name} has keys that are no texts: {shown(list(table))}")
    if both := [key for key in points if key in draws]:
        raise ConfigError(f"{both[0]} is both in the grid and drawn at random; expected one of them")
    plan = Plan(
        experiment=found,
        settings=base,
        grid={key: _points(found, key, values) for key, values in points.items()},
        random={key: _checked_draw(found, key, draw) for key, draw in draws.items()},
        trials=as_count(trials, "trials", 1, MOST_TRIALS),
        seed=as_count(seed, "seed", 0, LARGEST_SEED),
    )
    _check_size(plan)
    return plan


def experiment_for(experiment: Experiment | str) -> Experiment:
    """Return the experiment itself or the one of this name; ConfigError where there is none."""
    if isinstance(experiment, str):
        experiment_named(experiment)
        return EXPERIMENTS[experiment]
    check_type(experiment, Experiment, "experiment")
    return experiment


def _fields(experiment: Experiment) -> dict[str, dataclasses.Field[Any]]:
    return {field.name: field for field in dataclasses.fields(experiment.settings)}


def _points(experiment: Experiment, key: str, values: object) -> tuple[Any, ...]:
    """The values of one key of the grid, each as its setting has it."""
    if isinstance(values, np.ndarray):
        values = values.tolist()
    if not isinstance(values, (list, tuple, range)) or not values:
        raise ConfigError(f"grid: {key} is {shown(values)}; expected a list of values")
    if len(values) > MOST_TRIALS:
        raise ConfigError(f"grid: {key} has {len(values)} values; expected at most {MOST_TRIALS}")
    found = tuple(_value(experiment, key, value, "grid") for value in values)
    if len(set(found)) < len(found):
        twice = next(value for place, value in enumerate(found) if value in found[:place])
        raise ConfigError(f"grid: {key} has the value {shown(twice)} twice")
    return found


def _checked_draw(experiment: Experiment, key: str, draw: object) -> Draw:
    """A draw whose ends are both in the range of their setting, which is a number or a list of any length."""
    check_type(draw, Draw, f"random[{key!r}]")
    assert isinstance(draw, Draw)
    field = _fields(experiment).get(key)
    if field is None:
        settings_from(experiment.settings, {key: None}, "random")
    assert field is not None
    single = field.default[0] if isinstance(field.default, tuple) else field.default
    if isinstance(single, (bool, str)) or field.metadata["count"]:
        raise ConfigError(f"random: {key} is not a single number; give its values in the grid")
    for end in (draw.low, draw.high):
        _value(experiment, key, end, "random")
    return draw


def _value(experiment: Experiment, key: str, value: Any, where: str) -> Any:
    """One value as its setting has it, whatever the others are."""
    cls = experiment.settings
    alone = type(cls.__name__, (cls,), {"check": lambda _: None})
    return getattr(settings_from(alone, {key: value}, where), key)


def _check_size(plan: Plan) -> None:
    if not plan.swept and plan.trials == 1:
        raise ConfigError(f"nothing to sweep: give a grid or random draws of settings of {plan.experiment.name}")
    if plan.total > MOST_TRIALS:
        sizes = " x ".join(str(len(values)) for values in plan.grid.values())
        raise ConfigError(
            f"the sweep has {plan.total} trials (grid {sizes or 1}, {plan.trials} at every point); "
            f"expected at most {MOST_TRIALS}"
        )
    if plan.trials > 1 and not plan.random and not plan.seeded:
        raise ConfigError(
            f"{plan.trials} trials at every point would all be the same: nothing is drawn at random, and "
            f"{plan.experiment.name} gets no seed of its own; expected 1"
        )
