"""Heap allocations per call, counted by a preloaded malloc in a process of its own.

`python -m comparison.allocations CYCLES` counts; it needs the library that :func:`count` compiles and preloads.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comparison.arm import SAMPLES, panda
from comparison.libraries import all_calls

if TYPE_CHECKING:
    from collections.abc import Callable

FOLDER = Path(__file__).parent
OTHERS = 200
"""Cycles that are counted where a few tell all."""


def count(cycles: int) -> tuple[dict[str, float], list[str]]:
    """Allocations per call by name, over so many cycles of our gravity torques; or a note why they were not counted."""
    compiler = shutil.which("cc")
    if compiler is None:
        return {}, ["no C compiler (cc): allocations not counted"]
    with tempfile.TemporaryDirectory() as folder:
        library = str(Path(folder, "count_malloc.so"))
        built = execute([compiler, "-O2", "-fPIC", "-shared", "-o", library, str(FOLDER / "count_malloc.c")], {})
        if built.returncode:
            return {}, [f"allocations not counted: {built.stderr.strip()}"]
        counted = execute([sys.executable, "-m", "comparison.allocations", str(cycles)], {"LD_PRELOAD": library})
    if counted.returncode:
        return {}, [f"allocations not counted: {counted.stderr.strip()}"]
    return json.loads(counted.stdout), []


def execute(command: list[str], environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Run a program beside this package, with more in its environment."""
    merged = {**os.environ, **environment}
    return subprocess.run(command, cwd=FOLDER.parent, env=merged, capture_output=True, text=True, check=False)  # noqa: S603


def requests() -> int:
    """Requests for memory so far, of the whole process."""
    counter = ctypes.CDLL(None).count_malloc_requests
    counter.restype = ctypes.c_ulong
    return int(counter())


def during(run: Callable[[int], Any], cycles: int) -> int:
    """Requests for memory while ``run`` runs, without those of asking."""
    requests()
    first, before = requests(), requests()
    for _ in range(cycles // SAMPLES):
        for k in range(SAMPLES):
            run(k)
    for k in range(cycles % SAMPLES):
        run(k)
    return max(0, requests() - before - (before - first))


def per_call(run: Callable[[int], Any], cycles: int) -> float:
    """Requests per cycle: the fewest of three counts, as the interpreter asks for itself now and then."""
    during(run, OTHERS)
    fewest = during(run, cycles)
    for _ in range(2):
        if fewest:
            fewest = min(fewest, during(run, cycles))
    return fewest / cycles


def main() -> None:
    gc.disable()
    found = {}
    for call in all_calls(panda())[0]:
        long = call.library == "ravengc" and call.operation in {"gravity", "live"}
        found[call.key] = per_call(call.run, int(sys.argv[1]) if long else OTHERS)
    print(json.dumps(found))


if __name__ == "__main__":
    main()
