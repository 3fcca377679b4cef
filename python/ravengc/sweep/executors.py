"""A Dask cluster on which the trials of a sweep run."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from ravengc._convert import check_type
from ravengc.errors import ConfigError, MissingExtraError
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Iterator
    from concurrent.futures import Executor
    from contextlib import AbstractContextManager

__all__ = ["dask"]

PATIENCE = "10s"


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
