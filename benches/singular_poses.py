"""Resolved rate at a million random and constructed singular poses: no rate beyond its limit, no number that is none.

`python benches/singular_poses.py` steps each way of damping and of keeping limits through poses of a Panda: random
ones within and beyond its limits, and singular ones (stretched, wrists aligned, shoulder over the base) that are
disturbed by 1e-12 to 1e-2 rad; twists from 1e-3 to 1e3 m/s and rad/s. Ends with 1 if a rate was beyond its limit.
"""

from __future__ import annotations

import argparse
import itertools
import math
from typing import Any

import numpy as np
from comparison import command
from rich.progress import track
from rich.table import Table

import ravengc as rg
from ravengc.resolved_rate import DAMPINGS, LIMITS, ResolvedRate

SINGULAR = np.array(
    (
        np.zeros(7),
        (0.0, 0.0, 0.0, -1e-3, 0.0, 0.0, 0.0),
        (0.0, 0.2, 0.0, -2.1, 0.0, 0.0, 0.0),
        (0.0, math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0, -math.pi / 2, 0.0, math.pi / 2, 0.0),
        np.full(7, math.pi / 2),
    )
)

BLOCK = 10_000
"""Poses that are drawn at once: what is in memory does not grow with their number."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=1_000_000, help="poses of each row (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    robot = rg.load("panda")
    most = np.array([limit.velocity for limit in robot.spec.coordinate_limits])
    table = Table("damping", "limits", "poses", "largest rate / limit", "beyond", "singular", title="singular poses")
    bad = 0
    for damping, limits in itertools.product(DAMPINGS, LIMITS):
        random = np.random.default_rng(arguments.seed)
        ways: dict[str, Any] = {"damping": damping, "limits": limits}
        rate = ResolvedRate(robot, **ways)
        largest, beyond = run(rate, most, random, arguments.poses, f"{damping}, {limits}")
        bad += beyond
        share = f"{100.0 * rate.counters['singular'] / arguments.poses:.1f} %"
        table.add_row(damping, limits, str(arguments.poses), f"{largest:.12f}", str(beyond), share)
    command.console().print(table)
    return 1 if bad else 0


def run(rate: ResolvedRate, most: np.ndarray, random: np.random.Generator, poses: int, title: str) -> tuple[float, int]:
    """The largest rate as a share of its limit, and how many steps had one beyond it or none at all; block by block."""
    q, twist, out = np.empty(7), np.empty(6), np.empty(7)
    cycle = rate.bind(q=q, twist=twist, out=out)
    largest, beyond = 0.0, 0
    for begin in track(range(0, poses, BLOCK), title):
        count = min(BLOCK, poses - begin)
        at, moves, rates = drawn(random, count), twists(random, count), np.empty((count, 7))
        for row in range(count):
            q[:], twist[:] = at[row], moves[row]
            cycle()
            rates[row] = out
        shares = np.abs(rates) / most
        largest = max(largest, float(np.nanmax(shares, initial=0.0)))
        beyond += int(np.count_nonzero(~(shares <= 1.0).all(axis=1)))  # what is no number is beyond
    return largest, beyond


def drawn(random: np.random.Generator, count: int) -> np.ndarray:
    """Half of them anywhere, half of them singular but for a little."""
    anywhere = random.uniform(-math.pi, math.pi, (count, 7))
    little = 10.0 ** random.uniform(-12.0, -2.0, (count, 1)) * random.standard_normal((count, 7))
    singular = SINGULAR[random.integers(len(SINGULAR), size=count)] + little
    return np.where(random.random((count, 1)) < 0.5, anywhere, singular)


def twists(random: np.random.Generator, count: int) -> np.ndarray:
    return 10.0 ** random.uniform(-3.0, 3.0, (count, 1)) * random.standard_normal((count, 6))


if __name__ == "__main__":
    raise SystemExit(main())
