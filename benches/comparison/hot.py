"""Calls back to back: chunks of all calls in random order, round after round, so that all see the same machine."""

from __future__ import annotations

import random
from statistics import median
from time import perf_counter_ns
from typing import TYPE_CHECKING, Any

import numpy as np

from comparison.arm import SAMPLES

if TYPE_CHECKING:
    from collections.abc import Callable

    from comparison.arm import Array
    from comparison.call import Call

CHUNK_NS = 150_000
"""How long a chunk takes: short enough that most are not interrupted."""

SLOW_NS = 400_000
"""A call slower than this takes part in fewer rounds."""


def fetchers(inputs: list[Array]) -> dict[int, Callable[[int], Any]]:
    """Functions that fetch from so many lists and do nothing: what a call costs before the library is called."""
    a = b = c = d = e = f = inputs

    def fetch_0(_: int) -> Any:
        return None

    def fetch_1(k: int) -> Any:
        return a[k]

    def fetch_2(k: int) -> Any:
        _ = a[k]
        return b[k]

    def fetch_3(k: int) -> Any:
        _ = a[k]
        _ = b[k]
        return c[k]

    def fetch_4(k: int) -> Any:
        _ = a[k]
        _ = b[k]
        _ = c[k]
        return d[k]

    def fetch_6(k: int) -> Any:
        _ = a[k]
        _ = b[k]
        _ = c[k]
        _ = d[k]
        _ = e[k]
        return f[k]

    return {0: fetch_0, 1: fetch_1, 2: fetch_2, 3: fetch_3, 4: fetch_4, 6: fetch_6}


def chunk(run: Callable[[int], Any], order: range) -> float:
    """Time of one call in ns, from a chunk of them."""
    run(order[0])
    run(order[-1])
    begin = perf_counter_ns()
    for k in order:
        run(k)
    return (perf_counter_ns() - begin) / len(order)


class Racer:
    """A call or a fetcher, how many of it fill a chunk, and what each round measured (NaN where it paused)."""

    def __init__(self, run: Callable[[int], Any], rounds: int) -> None:
        self.run = run
        ns = median(chunk(run, range(2)) for _ in range(5))
        self.size = int(min(SAMPLES, max(1, CHUNK_NS // ns)))
        self.every = max(1, round(ns / SLOW_NS))
        self.ns = np.full(rounds, np.nan)

    def go(self, number: int) -> None:
        if number % self.every == 0:
            start = random.randrange(SAMPLES - self.size + 1)  # noqa: S311
            self.ns[number] = chunk(self.run, range(start, start + self.size))


def race(calls: list[Call], inputs: list[Array], rounds: int) -> dict[str, Array]:
    """Time of each call in every round, ns, without the cost of fetching its inputs."""
    bare = {count: Racer(run, rounds) for count, run in fetchers(inputs).items()}
    timed = {call.key: call.hot for call in calls}
    racers = {key: Racer(run, rounds) for key, (run, _) in timed.items()}
    field = [*bare.values(), *racers.values()]
    for number in range(rounds):
        random.shuffle(field)
        for racer in field:
            racer.go(number)
    return {key: racers[key].ns - bare[fetches].ns for key, (_, fetches) in timed.items()}


def ratio(slow: Array, fast: Array) -> float:
    """How many times slower: the median over the rounds in which both ran."""
    return float(np.nanmedian(slow / fast))
