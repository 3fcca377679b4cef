"""One call per millisecond, asleep in between: what a control loop pays, on caches gone cold.

Alone, a library has the ticks of a block to itself: a loop that does nothing else. Among others, each tick belongs to
another library, in random order: between two calls of one the processor has slept and has run other code, as in a loop
that also reads sensors, sends and logs.
"""

from __future__ import annotations

import random
import time
from time import perf_counter_ns
from typing import TYPE_CHECKING, Any

import numpy as np

from comparison.call import Call

if TYPE_CHECKING:
    from collections.abc import Callable

    from comparison.arm import Array

PERIOD_NS = 1_000_000

ALONE = 50
"""Ticks in a row that one library has to itself."""

INPUTS = 8
"""Inputs in use: a loop keeps its arrays."""


def next_tick() -> None:
    """Sleep to the next multiple of the period."""
    time.sleep((PERIOD_NS - perf_counter_ns() % PERIOD_NS) / 1e9)


def timed(run: Callable[[int], Any], k: int) -> int:
    begin = perf_counter_ns()
    run(k)
    return perf_counter_ns() - begin


def pace(calls: list[Call], inputs: list[Array], turns: int, block: int) -> dict[str, Array]:
    """Time of every call in ns, under "nothing" that of fetching an input and returning; blocks of ticks, shuffled."""
    nothing = Call("nothing", "", "", lambda k: inputs[k], 1)
    order = [*calls, nothing]
    times: dict[str, list[int]] = {call.key: [] for call in order}
    for first in range(0, turns, block):
        random.shuffle(order)
        for call in order:
            times[call.key] += [tick(call, number % INPUTS) for number in range(first, first + block)]
    times["nothing"] = times.pop(nothing.key)
    return {key: np.array(values, dtype=np.float64) for key, values in times.items()}


def tick(call: Call, k: int) -> int:
    """The time that the call takes after sleeping to the next millisecond."""
    run = call.ready(k)
    next_tick()
    return timed(run, k)
