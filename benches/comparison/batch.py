"""A million configurations at once: ours on one and two threads and in each build, pinocchio's own, NumPy's best.

`python -m comparison.batch SAMPLES ROUNDS` prints the rates of this process's build alone, in millions per second.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

import ravengc as rg
from comparison.arm import LEVEL, Array, panda
from comparison.libraries import left_out

if TYPE_CHECKING:
    from collections.abc import Callable

    from comparison.arm import Arm

CHUNK = 8192
"""Configurations that NumPy takes at a time: its temporaries stay in the cache."""


def ours(arm: Arm, q: Array, threads: int) -> Callable[[], Array]:
    robot, out = rg.Robot(arm.spec), np.zeros_like(q)
    return lambda: robot.gravity_torque_batch(q, LEVEL, out, threads)


def pinocchio(arm: Arm, q: Array) -> Callable[[], Array]:
    import pinocchio as pin

    from comparison.libraries.pinocchio import build

    pool = pin.ModelPool(build(arm)[0], 1)
    positions = np.asfortranarray(q.T)
    still, out = np.zeros_like(positions), np.zeros_like(positions)

    def run() -> Array:
        pin.rneaInParallel(1, pool, positions, still, still, out)
        return out.T

    return run


def vectorised(arm: Arm, q: Array) -> Callable[[], Array]:
    """The same recursion as the compiled core's, with a row of NumPy arrays for every number."""
    placements = [arm.placement(link) for link in arm.spec.links]
    out = np.zeros_like(q)

    def run() -> Array:
        for first in range(0, len(q), CHUNK):
            part = slice(first, first + CHUNK)
            out[part] = gravity_rows(arm, placements, q[part].T).T
        return out

    return run


def gravity_rows(arm: Arm, placements: list[Array], q: Array) -> Array:
    """g outward, first moments inward: tau_i = u_y g_x - u_x g_y, for q (n, samples)."""
    c, s = np.cos(q), np.sin(q)
    g, field = [], np.broadcast_to(LEVEL[:, None], (3, q.shape[1]))
    for i, pose in enumerate(placements):
        x, y, z = pose[:3, :3].T @ field
        field = np.stack([c[i] * x + s[i] * y, c[i] * y - s[i] * x, z])
        g.append(field)
    tau, beyond, carried = np.empty_like(q), np.zeros((3, q.shape[1])), 0.0
    for i in reversed(range(len(q))):
        link, pose = arm.spec.links[i], placements[i]
        x, y, z = beyond + (link.mass * np.array(link.com))[:, None]
        tau[i] = y * g[i][0] - x * g[i][1]
        carried += link.mass
        turned = np.stack([c[i] * x - s[i] * y, s[i] * x + c[i] * y, z])
        beyond = pose[:3, :3] @ turned + carried * pose[:3, 3:]
    return tau


def positions(samples: int) -> Array:
    return np.random.default_rng(2).uniform(-3.0, 3.0, (samples, 7))


def rates(runs: dict[str, Callable[[], Array]], samples: int, rounds: int) -> dict[str, list[float]]:
    """Millions of configurations per second, every round, in random order."""
    found: dict[str, list[float]] = {name: [] for name in runs}
    order = list(runs)
    for _ in range(rounds):
        random.shuffle(order)
        for name in order:
            begin = perf_counter()
            runs[name]()
            found[name].append(samples / (perf_counter() - begin) / 1e6)
    return found


def compare(samples: int, rounds: int) -> tuple[dict[str, list[float]], list[str]]:
    """Rates of all in this process, checked against each other, and notes on who is missing."""
    arm, q = panda(), positions(samples)
    runs = {"ravengc, 1 thread": ours(arm, q, 1), "ravengc, 2 threads": ours(arm, q, 2)}
    notes = []
    if left_out("pinocchio") is None:
        if hasattr(import_module("pinocchio"), "rneaInParallel"):
            runs["pinocchio, rneaInParallel, 1 thread"] = pinocchio(arm, q)
        else:
            notes.append("pinocchio without rneaInParallel: left out of the batch")
    runs["numpy, vectorised"] = vectorised(arm, q)
    wanted = runs["ravengc, 1 thread"]().copy()
    for name, run in runs.items():
        off = float(np.abs(run() - wanted).max())
        if not off <= 1e-10:
            raise SystemExit(f"{name} differs from ravengc, 1 thread, by {off:.1e} N m")
    return rates(runs, samples, rounds), notes


def at_level(level: str, samples: int, rounds: int) -> list[float]:
    """Our rates on one thread in a process of its own that is held to one build of the kernels."""
    command = [sys.executable, "-m", "comparison.batch", str(samples), str(rounds)]
    environment = {**os.environ, "RAVENGC_LEVEL": level}
    folder = Path(__file__).parents[1]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=True)  # noqa: S603
    found: list[float] = json.loads(done.stdout)
    return found


def main() -> None:
    samples, rounds = map(int, sys.argv[1:])
    run = ours(panda(), positions(samples), 1)
    run()
    print(json.dumps(rates({"": run}, samples, rounds)[""]))


if __name__ == "__main__":
    main()
