"""A machine as quiet as it lets us make it."""

from __future__ import annotations

import gc
import os
import platform
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import ravengc as rg

if TYPE_CHECKING:
    from collections.abc import Iterator

PRIORITY = 10
PACKAGES = ("ravengc", "numpy", "pin", "dynibo", "mujoco", "roboticstoolbox-python")


@contextmanager
def quiet(*, first: bool = True) -> Iterator[list[str]]:
    """Run on one core, ``first`` before all ordinary processes, without collecting; yields what was not allowed."""
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield [*pin(), *precede()] if first else []
    finally:
        gc.enable()
        gc.unfreeze()


def pin() -> list[str]:
    try:
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    except (AttributeError, OSError) as error:
        return [f"not pinned to a core ({error}): expect more noise"]
    return []


def precede() -> list[str]:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (AttributeError, OSError) as error:
        return [f"no real-time priority ({error}): expect more noise"]
    return []


@contextmanager
def all_cores() -> Iterator[None]:
    """Let threads spread for a while."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    pinned = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        yield
    finally:
        os.sched_setaffinity(0, pinned)


def facts() -> dict[str, object]:
    """What the numbers depend on."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "instructions": rg.INSTRUCTIONS,
        "versions": dict(filter(all, ((package, installed(package)) for package in PACKAGES))),
        "longdouble_eps": float(np.finfo(np.longdouble).eps),
    }


def processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())


def installed(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
