"""Several experiments at once on a pool of processes: their tasks in one queue, their outcomes in order.

Processes are started afresh (``spawn``), compute with one thread each, leave Ctrl-C to the parent, and end with it.
Results do not depend on how many there are: every task is a function of its settings alone.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import closing, contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any

from ravengc._convert import as_count

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Sequence
    from contextlib import AbstractContextManager

    from ravengc.experiments.experiment import Experiment, Outcome, Settings

__all__ = ["Job", "default_jobs", "processes", "run_all"]

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

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
    alone = [experiment.timed for (experiment, _), own in zip(jobs, tasks, strict=True) for _ in own]
    timed, others = ([i for i in range(len(calls)) if alone[i] is first] for first in (True, False))
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


def _shared_out(calls: Sequence[Call], order: Sequence[int], count: int) -> Generator[tuple[int, Any], None, None]:
    return _in_turn(calls, order) if count == 1 or not order else _on_pool(calls, order, count)


def _in_turn(calls: Sequence[Call], order: Sequence[int]) -> Generator[tuple[int, Any], None, None]:
    """Numbers and results, one after the other."""
    for i in order:
        yield i, _call(calls[i])


def _on_pool(calls: Sequence[Call], order: Sequence[int], count: int) -> Generator[tuple[int, Any], None, None]:
    """Numbers and results as they come. After an error or Ctrl-C nothing new begins, and the processes are ended."""
    with processes(min(count, len(order))) as pool:
        numbers = {pool.submit(_call, calls[i]): i for i in order}
        for future in as_completed(numbers):
            yield numbers[future], future.result()


def _call(call: Call) -> Any:
    run, task = call
    return run(task)


def processes(jobs: int) -> AbstractContextManager[Executor]:
    """Give an executor of so many processes, each computing with one thread; an error or Ctrl-C inside ends them.

    They are started afresh (``spawn``), so a script uses them behind ``if __name__ == "__main__":``. They leave Ctrl-C
    to this process, and end with it, also when it is killed.
    """
    return _processes(as_count(jobs, "jobs", 1, 1024))


@contextmanager
def _processes(jobs: int) -> Iterator[Executor]:
    pool = _Processes(jobs)
    try:
        yield pool
    except BaseException:
        _end_processes(pool)
        raise
    pool.shutdown()


class _Processes(ProcessPoolExecutor):
    """Processes that are started as they are needed: submitting is what starts them."""

    def __init__(self, jobs: int) -> None:
        super().__init__(jobs, multiprocessing.get_context("spawn"), initializer=_end_with_parent)

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        with _one_thread_each(), _interrupts_held():
            return super().submit(function, *args, **kwargs)


def _end_with_parent() -> None:
    """A process that waits for work does not see that the one that gave it is gone."""
    threading.Thread(target=_wait_for_parent, daemon=True).start()


def _wait_for_parent() -> None:
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)


def _end_processes(pool: ProcessPoolExecutor) -> None:
    """Drop what has not begun, and end the processes in the middle of what they do."""
    workers = list((pool._processes or {}).values())  # noqa: SLF001 -- there is no public way before Python 3.14
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in workers:
        worker.terminate()
    for worker in workers:
        worker.join()


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Let Ctrl-C wait, here until the end, and for ever in processes started inside: the parent decides for them."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread_each() -> Iterator[None]:
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
