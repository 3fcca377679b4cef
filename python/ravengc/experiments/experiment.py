"""What an experiment is: settings in, independent pieces of work, and from their results numbers, tables and findings.

    outcome = run_experiment(EXPERIMENTS["rocking"], settings)

``tasks`` splits the work into units that any process can run (plain picklable data), ``run`` does one of them,
``combine`` puts their results together in the order of the tasks, and ``draw`` makes the picture. An experiment is
deterministic: the same settings (a seed is one of them) give the same outcome, in one process or in many.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from ravengc._convert import check_type
from ravengc.experiments.settings import Settings, setting, settings_from, settings_table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from matplotlib.figure import Figure
    from numpy.typing import NDArray

__all__ = [
    "Experiment",
    "Finding",
    "Outcome",
    "Settings",
    "Table",
    "Verdict",
    "finding",
    "run_experiment",
    "setting",
    "settings_from",
    "settings_table",
]

Verdict = Literal["reproduced", "not reproduced", "no number stated"]


@dataclass(frozen=True)
class Table:
    """A table of the report: rows of texts and numbers, as wide as ``columns``."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]
    note: str = ""


@dataclass(frozen=True)
class Finding:
    """One statement of the paper (``stated``, empty where it makes none) beside what the experiment found.

    ``expected`` and ``tolerance`` are the number that this project holds the experiment to, in ``unit``; None where
    there is none. ``verdict`` is about the paper's statement, :attr:`holds` about the expected number.
    """

    quantity: str
    stated: str
    value: float
    unit: str
    expected: float | None
    tolerance: float | None
    verdict: Verdict
    why: str

    @property
    def holds(self) -> bool:
        """Tell whether the value is the expected one within its tolerance; True where nothing is expected."""
        if self.expected is None or self.tolerance is None:
            return True
        return abs(self.value - self.expected) <= self.tolerance


@dataclass(frozen=True)
class Outcome:
    """What an experiment found: ``numbers`` (flat, by name), tables, findings, and the ``series`` its picture shows."""

    numbers: dict[str, float]
    tables: tuple[Table, ...] = ()
    findings: tuple[Finding, ...] = ()
    series: dict[str, NDArray[Any]] = field(default_factory=dict)

    @property
    def holds(self) -> bool:
        """Tell whether every finding holds."""
        return all(finding.holds for finding in self.findings)


@dataclass(frozen=True)
class Experiment:
    """A named experiment: ``settings`` is its :class:`Settings` class, ``source`` the paper and figure it repeats.

    ``height`` (in) is that of its picture. An experiment that is ``timed`` measures times: nothing else runs meanwhile.
    """

    name: str
    title: str
    source: str
    about: str
    settings: type[Settings]
    tasks: Callable[[Any], Sequence[Any]]
    run: Callable[[Any], Any]
    combine: Callable[[Any, Sequence[Any]], Outcome]
    draw: Callable[[Figure, Outcome], None]
    height: float = 4.2
    timed: bool = False


def finding(
    quantity: str,
    value: float,
    unit: str = "",
    *,
    stated: str = "",
    expected: float | None = None,
    tolerance: float | None = None,
    verdict: Verdict = "no number stated",
    why: str = "",
) -> Finding:
    """Write down a finding; see :class:`Finding`."""
    return Finding(quantity, stated, float(value), unit, expected, tolerance, verdict, why)


def run_experiment(
    experiment: Experiment,
    settings: Settings | None = None,
    *,
    mapper: Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]] = map,
) -> Outcome:
    """Run one experiment, with its default settings if none are given; ``mapper`` may be an executor's ``map``.

    Raises ArgumentError unless the settings are those of this experiment.
    """
    check_type(experiment, Experiment, "experiment")
    settings = experiment.settings() if settings is None else settings
    check_type(settings, experiment.settings, "settings")
    return experiment.combine(settings, list(mapper(experiment.run, experiment.tasks(settings))))
