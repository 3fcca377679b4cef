"""What importing each library costs after NumPy, in fresh processes."""

from __future__ import annotations

import random
import subprocess
import sys
from statistics import median

PROGRAM = """
from time import perf_counter
begin = perf_counter()
import numpy
middle = perf_counter()
import {module}
print(middle - begin, perf_counter() - middle)
"""


def seconds(module: str) -> tuple[float, float]:
    """Time of importing NumPy, then the module."""
    command = [sys.executable, "-c", PROGRAM.format(module=module)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    numpy, after = map(float, done.stdout.split())
    return numpy, after


def compare(modules: list[str], rounds: int) -> dict[str, float]:
    """Median time in ms of each module after NumPy, and of NumPy itself."""
    found: dict[str, list[float]] = {name: [] for name in ("numpy", *modules)}
    order = list(modules)
    for _ in range(rounds):
        random.shuffle(order)
        for module in order:
            numpy, after = seconds(module)
            found["numpy"].append(numpy)
            found[module].append(after)
    return {name: 1e3 * median(values) for name, values in found.items()}
