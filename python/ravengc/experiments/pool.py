"""Several experiments at once on a pool of processes: their tasks in one queue, their outcomes in order.

Processes are started afresh (``spawn``), compute with one thread each, and leave Ctrl-C to the parent. Results do not
depend on how many there are: every task is a function of its settings alone.
"""

from __future__ import annotations

import os
import signal
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import closing, contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any

from ravengc._convert import as_count

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Sequence

    from ravengc.experiments.experiment import Experiment, Outcome, Settings

__all__ = ["Job", "default_jobs", "end_processes", "interrupts_held", "one_thread_each", "run_all"]

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
TIMED = "newton-euler"
"""It measures times, so it runs before the others begin."""

Job = tuple["Experiment", "Settings"]
Call = tuple["Callable[[Any], Any]", Any]
"""A function of an experiment and one of its tasks."""


def default_jobs() -> int:
    """As many processes as this process may use processors."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_all(
    jobs: Sequence[Job], *, processes: int, on_done: Callable[[int, int], None] | None = None
) -> dict[str, Outcome]:
    """Run experiments on ``processes`` processes (1: in this one); ``on_done`` hears how many tasks of all are done.

    Returns outcomes by name, in the order given. What a task raises, this raises, and the other tasks are abandoned.
    """
    as_count(processes, "processes", 1, 1024)
    tasks = [list(experiment.tasks(settings)) for experiment, settings in jobs]
    calls = [(job[0].run, task) for job, own in zip(jobs, tasks, strict=True) for task in own]
    timed = [i for i, (run, _) in enumerate(calls) if any(e.name == TIMED and e.run is run for e, _ in jobs)]
    others = [i for i in range(len(calls)) if i not in timed]
    results: dict[int, Any] = {}
    with closing(_shared_out(calls, others, processes)) as shared_out:
        for i, result in chain(_in_turn(calls, timed), shared_out):
            results[i] = result
            if on_done is not None:
                on_done(len(results), len(calls))
    in_order = iter([results[i] for i in range(len(calls))])
    return {
        experiment.name: experiment.combine(settings, [next(in_order) for _ in own])
        for (experiment, settings), own in zip(jobs, tasks, strict=True)
    }


def _shared_out(calls: Sequence[Call], order: Sequence[int], processes: int) -> Generator[tuple[int, Any], None, None]:
    return _in_turn(calls, order) if processes == 1 or not order else _on_pool(calls, order, processes)


def _in_turn(calls: Sequence[Call], order: Sequence[int]) -> Generator[tuple[int, Any], None, None]:
    """Numbers and results, one after the other."""
    for i in order:
        yield i, _call(calls[i])


def _on_pool(calls: Sequence[Call], order: Sequence[int], processes: int) -> Generator[tuple[int, Any], None, None]:
    """Numbers and results as they come. After an error or Ctrl-C nothing new begins, and the processes are ended."""
    import multiprocessing

    with one_thread_each():
        pool = ProcessPoolExecutor(min(processes, len(order)), multiprocessing.get_context("spawn"))
        try:
            with interrupts_held():  # submitting starts processes, which take this over
                numbers = {pool.submit(_call, calls[i]): i for i in order}
            for future in as_completed(numbers):
                yield numbers[future], future.result()
        except BaseException:
            end_processes(pool)
            raise
        pool.shutdown()


def _call(call: Call) -> Any:
    run, task = call
    return run(task)


def end_processes(pool: ProcessPoolExecutor) -> None:
    """Drop what has not begun, and end the processes in the middle of what they do."""
    workers = list((pool._processes or {}).values())  # noqa: SLF001 -- there is no public way before Python 3.14
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in workers:
        worker.terminate()
    for worker in workers:
        worker.join()


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Let Ctrl-C wait, here until the end, and for ever in processes started inside: the parent decides for them."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Let processes started inside compute with one thread each: they share the processors already."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
