"""Where the trials of a sweep run: fresh processes of this machine, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ravengc._convert import as_count, check_type
from ravengc.errors import ConfigError, MissingExtraError
from ravengc.experiments.pool import end_processes, interrupts_held, one_thread_each
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

__all__ = ["dask", "processes"]

PATIENCE = "10s"


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
        end_processes(pool)
        raise
    pool.shutdown()


def dask(address: str) -> AbstractContextManager[Executor]:
    """Give an executor that runs on the Dask cluster whose scheduler is at ``address``, as ``tcp://host:8786``.

    Its scheduler and workers need ravengc, of this version. Raises, where it is entered, MissingExtraError without the
    package distributed and ConfigError where there is no scheduler.
    """
    check_type(address, str, "address")
    return _dask(address)


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingExtraError("distributed", "sweep", "a sweep on a Dask cluster") from error
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(f"no Dask scheduler at {shown(address)}: {error}; expected tcp://host:port") from error
    try:
        yield client.get_executor()
    finally:
        client.close()


class _Processes(ProcessPoolExecutor):
    """Processes that are started as they are needed: submitting is what starts them."""

    def __init__(self, jobs: int) -> None:
        super().__init__(jobs, multiprocessing.get_context("spawn"), initializer=_end_with_parent)

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        with one_thread_each(), interrupts_held():
            return super().submit(function, *args, **kwargs)


def _end_with_parent() -> None:
    """A process that waits for work does not see that the one that gave it is gone."""
    threading.Thread(target=_wait_for_parent, daemon=True).start()


def _wait_for_parent() -> None:
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)
