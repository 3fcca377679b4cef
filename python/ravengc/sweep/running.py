"""A sweep at work: trials that are not in the journal go to the executor, and to the journal when they come back."""

from __future__ import annotations

import dataclasses
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from ravengc._convert import as_path, check_type
from ravengc.errors import ArgumentError, ConfigError, MissingExtraError, RavenGCError
from ravengc.experiments.experiment import run_experiment
from ravengc.messages import kind_of
from ravengc.sweep.folder import open_journal, versions, write_tables
from ravengc.sweep.journal import Journal, Result
from ravengc.sweep.plan import plan_sweep
from ravengc.sweep.table import SweepTable, sweep_table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from ravengc.experiments import Experiment, Settings
    from ravengc.sweep.plan import Draw, Plan

__all__ = ["Progress", "sweep"]

LOST = (
    "the executor lost its workers: one may have needed more memory than there is; what is finished is kept, and the "
    "same sweep goes on from there"
)
AT_ONCE = 4096
"""No more trials than this wait in the executor."""


@dataclass(frozen=True)
class Progress:
    """How far a sweep is: trials done of how many, how many of them were there already, and how many failed."""

    done: int
    total: int
    already: int
    failed: int


def sweep(
    experiment: Experiment | str,
    *,
    out: str | Path,
    grid: Mapping[str, Sequence[Any]] | None = None,
    random: Mapping[str, Draw] | None = None,
    trials: int = 1,
    seed: int = 0,
    settings: Settings | None = None,
    executor: Executor | None = None,
    on_progress: Callable[[Progress], object] | None = None,
) -> SweepTable:
    """Run an experiment at every point of a grid, ``trials`` times at each with random draws, and return the table.

    ``grid`` has values by setting, ``random`` ranges; all other settings are those of ``settings``, or the defaults. A
    setting ``seed`` that is not swept gets a value of its own in every trial. Trial and seed decide a trial alone.

    ``out`` is a folder for the journal, ``sweep.json`` and the table: ``sweep.csv`` and, with pyarrow, a Parquet file.
    Called again in the same way, the sweep goes on where it stopped, however it did. ``executor`` is any
    ``concurrent.futures.Executor`` (:func:`processes`, :func:`dask`); None: in this process.

    A trial that ends with an error of ravengc is a row with its message. Raises ConfigError for settings that do not
    exist or are out of range and for a folder of another sweep, MissingExtraError where the experiment lacks a package,
    RavenGCError when the executor lost its workers, and what else a trial raises; the finished trials are kept.
    """
    plan = plan_sweep(experiment, grid=grid, random=random, trials=trials, seed=seed, settings=settings)
    folder = as_path(out, "out")
    if executor is not None:
        check_type(executor, Executor, "executor")
    if on_progress is not None and not callable(on_progress):
        raise ArgumentError(f"on_progress is {kind_of(on_progress)}; expected a function of a Progress")
    with open_journal(plan, folder) as journal:
        results = journal.results
        recorder = _Recorder(journal, plan.total, on_progress)
        missing = (index for index in range(plan.total) if index not in results)
        if executor is None:
            for index in list(missing):
                recorder.add(index, _run_trial(plan.experiment, plan.settings, plan.changes(index)))
        else:
            _run_on(executor, plan, list(missing), recorder)
        table = sweep_table(plan, results)
        write_tables(table, folder)
    return table


class _Recorder:
    """Keeps results, in the journal and in memory, and tells how far the sweep is."""

    def __init__(self, journal: Journal, total: int, on_progress: Callable[[Progress], object] | None) -> None:
        self._journal, self._total, self._on_progress = journal, total, on_progress
        self._already = len(journal.results)
        self._failed = sum(result.error != "" for result in journal.results.values())
        self._tell()

    def add(self, index: int, result: Result) -> None:
        self._journal.add(index, result)
        self._journal.results[index] = result
        self._failed += result.error != ""
        self._tell()

    def _tell(self) -> None:
        if self._on_progress is not None:
            self._on_progress(Progress(len(self._journal.results), self._total, self._already, self._failed))


def _run_on(executor: Executor, plan: Plan, missing: list[int], recorder: _Recorder) -> None:
    """Run trials on an executor; when something ends that, what is finished by then is kept and the rest is dropped."""
    finished: SimpleQueue[Future[Result]] = SimpleQueue()
    waiting: dict[Future[Result], int] = {}

    def keep(future: Future[Result]) -> None:
        recorder.add(waiting.pop(future), future.result())

    try:
        for index in missing:
            while len(waiting) >= AT_ONCE:
                keep(finished.get())
            future = executor.submit(_run_trial, plan.experiment, plan.settings, plan.changes(index), versions())
            waiting[future] = index
            future.add_done_callback(finished.put)
            for done in _at_hand(finished):
                keep(done)
        while waiting:
            keep(finished.get())
    except BaseException as error:
        _keep_finished(waiting, recorder)
        if (told := _executor_fault(error)) is not None:
            raise told from error
        raise


def _executor_fault(error: BaseException) -> RavenGCError | None:
    """What to say where it is not a trial that failed but what was to run it; None for all else."""
    said = (str(error).partition("\n")[0] or type(error).__name__)[:200]
    if isinstance(error, (BrokenExecutor, CancelledError)) or type(error).__module__.startswith("distributed."):
        return RavenGCError(f"{LOST} ({said})")
    unreadable = isinstance(error, RuntimeError) and "deserialization" in said
    if unreadable or (isinstance(error, ImportError) and not isinstance(error, RavenGCError)):
        return ConfigError(f"the executor's processes cannot run a trial: {said}; expected {_told(versions())} there")
    return None


def _at_hand(finished: SimpleQueue[Future[Result]]) -> Iterator[Future[Result]]:
    while True:
        try:
            yield finished.get_nowait()
        except Empty:
            return


def _keep_finished(waiting: dict[Future[Result], int], recorder: _Recorder) -> None:
    for future, index in waiting.items():
        if not future.cancel() and future.done() and not future.cancelled() and future.exception() is None:
            recorder.add(index, future.result())


def _run_trial(
    experiment: Experiment, base: Settings, changes: dict[str, Any], expected: dict[str, str] | None = None
) -> Result:
    """One trial, in whatever process; ``expected`` are the versions of the one that asks."""
    if expected is not None and expected != versions():
        raise ConfigError(f"a worker has {_told(versions())}; expected {_told(expected)}, as the process that asks")
    try:
        outcome = run_experiment(experiment, dataclasses.replace(base, **changes))
    except MissingExtraError:  # it is this machine that fails, not the trial
        raise
    except RavenGCError as error:
        return Result(error=str(error) or type(error).__name__)
    return Result({name: float(value) for name, value in outcome.numbers.items()})


def _told(found: dict[str, str]) -> str:
    return ", ".join(f"{name} {text}" for name, text in found.items())
