"""A plan as a file: a table to go through, or all of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from ravengc._convert import as_path
from ravengc.config.files import write_atomically
from ravengc.config.toml_values import toml_value
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from os import PathLike

    from ravengc.identify.base_parameters import BaseParameters
    from ravengc.identify.plan_prediction import Prediction
    from ravengc.identify.recording import FloatArray

__all__ = ["described", "write_plan"]


class Planned(Protocol):
    """What every plan has."""

    @property
    def robot(self) -> str: ...
    @property
    def joints(self) -> tuple[str, ...]: ...
    @property
    def noise(self) -> FloatArray: ...
    @property
    def condition(self) -> float: ...
    @property
    def base(self) -> BaseParameters: ...
    @property
    def predicted(self) -> Prediction: ...
    @property
    def level(self) -> Prediction: ...


def write_plan(
    path: str | PathLike[str],
    head: Sequence[str],
    rows: Callable[[], Iterable[Iterable[float]]],
    table: Callable[[], dict[str, Any]],
) -> None:
    """Write rows to a ``.csv`` or the table to a ``.toml``; ConfigError for other suffixes and failed writes."""
    target = as_path(path, "path")
    match target.suffix.lower():
        case ".csv":
            cells = (head, *([f"{value:.9g}" for value in row] for row in rows()))
            write_atomically(target, "".join(",".join(line) + "\n" for line in cells))
        case ".toml":
            write_atomically(target, "".join(_toml(table())))
        case _:
            raise ConfigError(f"{target}: unknown kind of plan; expected a name ending in .csv or .toml")


def _toml(table: dict[str, Any]) -> Iterator[str]:
    """Values first, then the tables and lists of tables that the table holds; these hold values."""
    inner = {key: value for key, value in table.items() if isinstance(value, dict) or _of_tables(value)}
    yield from (f"{key} = {toml_value(value)}\n" for key, value in table.items() if key not in inner)
    for key, value in inner.items():
        for one in [value] if isinstance(value, dict) else value:
            yield f"\n[{key}]\n" if isinstance(value, dict) else f"\n[[{key}]]\n"
            yield from (f"{name} = {toml_value(entry)}\n" for name, entry in one.items())


def _of_tables(value: object) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], dict)


def described(plan: Planned) -> dict[str, Any]:
    """What every plan has, as plain data: SI units, angles in rad; ``inf`` where a torque stays open."""
    return {
        "robot": plan.robot,
        "joints": list(plan.joints),
        "noise": plan.noise.tolist(),
        "condition": plan.condition,
        "identified": list(plan.base.names),
        "unidentifiable": list(plan.base.unidentifiable),
        "predicted": _prediction(plan.predicted),
        "level_only": _prediction(plan.level),
    }


def _prediction(prediction: Prediction) -> dict[str, Any]:
    return {"tilt": prediction.angles.tolist(), "sd": prediction.sd.tolist(), "worst": prediction.worst.tolist()}
