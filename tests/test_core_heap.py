"""A cycle from Python takes nothing from the heap: an allocator that counts sees nothing in a million cycles."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
SHIM = TESTS.parent / "benches" / "comparison" / "count_malloc.c"
CYCLES, OTHER_CYCLES = 1_000_000, 20_000

FROM_LISTS = """
import ctypes, ravengc
read, robot = ctypes.CDLL(None).count_malloc_requests, ravengc.load("panda")
q = robot.center_of_mass([0.0] * 7)
before = read()
kept = [robot.potential_energy([0.0] * 7, q) for _ in range(1000)]
print(read() - before)
"""


@pytest.fixture(scope="module")
def shim(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A library to preload, which counts malloc, calloc, realloc and their aligned kin."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler (cc) to build the counting allocator with")
    if not sys.platform.startswith("linux"):
        pytest.skip("the counting allocator is preloaded in the way of Linux")
    library = str(tmp_path_factory.mktemp("shim") / "count_malloc.so")
    subprocess.run([compiler, "-O2", "-fPIC", "-shared", "-o", library, str(SHIM)], check=True)  # noqa: S603
    return library


def requests(shim: str, cycles: int, others: int, allocator: str) -> dict[str, int]:
    """Requests that reach the C library in a process of its own, by name."""
    command = [sys.executable, str(TESTS / "count_requests.py"), str(cycles), str(others)]
    environment = {**os.environ, "LD_PRELOAD": shim, "PYTHONMALLOC": allocator}
    result = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)  # noqa: S603
    return dict(json.loads(result.stdout))


@pytest.mark.parametrize("allocator", ["pymalloc", "malloc"])
def test_cycles_request_no_memory(shim: str, allocator: str) -> None:
    """With PYTHONMALLOC=malloc even Python's small objects are counted: a cycle makes none either.

    What reading the counter itself takes is the same whether there were no cycles or a million.
    """
    none = requests(shim, 0, 0, allocator)
    many = requests(shim, CYCLES, OTHER_CYCLES, allocator)
    assert many == none
    if allocator == "pymalloc":
        assert set(many.values()) == {0}


def test_the_counter_counts(shim: str) -> None:
    """Lists have to be converted, and that takes memory."""
    environment = {**os.environ, "LD_PRELOAD": shim, "PYTHONMALLOC": "malloc"}
    command = [sys.executable, "-c", FROM_LISTS]
    result = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)  # noqa: S603
    assert int(result.stdout) >= 1000
