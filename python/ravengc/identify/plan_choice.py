"""Which of many candidates to measure: D-optimal, first one by one, then by exchanges.

A candidate is a block of rows Y in units of the noise; the information of those chosen is M = Σ YᵀY, and the volume of
the parameters' uncertainty shrinks as log det M grows. One more candidate adds log det(1 + Y M⁻¹ Yᵀ) (Fedorov, Theory
of Optimal Experiments, 1972).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.identify.recording import FloatArray

__all__ = ["Choice", "choose"]

START = 1e-6
"""Information that is there before the first choice, in columns of unit size: what rows do not show stays there."""
LEAST_GAIN = 1e-3
"""Of log det for which a candidate is exchanged: a thousandth of the volume."""
MOST_ROUNDS = 10


@dataclass(frozen=True, slots=True)
class Choice:
    """The ``chosen`` places of candidates, and log det M after the greedy choice and after every exchange."""

    chosen: tuple[int, ...]
    history: tuple[float, ...]


def choose(blocks: FloatArray, count: int, on_step: Callable[[int, int], object] | None = None) -> Choice:
    """Choose ``count`` of the blocks (c, r, b), each at most once.

    ``on_step(done, total)`` is called after every choice and every exchange that was tried in the first round.
    """
    tell = (lambda _, __: None) if on_step is None else on_step
    search = _Search(blocks)
    for step in range(count):
        search.add()
        tell(step + 1, 2 * count)
    for round_ in range(MOST_ROUNDS):
        changed = False
        for place in range(count):
            changed |= search.exchange(place)
            if round_ == 0:
                tell(count + place + 1, 2 * count)
        if not changed:
            break
    return Choice(tuple(search.chosen), tuple(search.history))


class _Search:
    """The choice so far and its information."""

    def __init__(self, blocks: FloatArray) -> None:
        self.blocks, self.chosen = blocks, list[int]()
        self.information = START * np.eye(blocks.shape[2])
        self.history = [self._volume()]

    def add(self) -> None:
        """Take the candidate that gains most; the history starts when all are taken."""
        gains = self._gains(self.information)
        gains[self.chosen] = -np.inf
        self.chosen.append(int(gains.argmax()))
        self.information += self._of(self.chosen[-1])
        self.history = [self._volume()]

    def exchange(self, place: int) -> bool:
        """Put the best candidate in the place of a chosen one, if it is better."""
        old = self.chosen[place]
        without = self.information - self._of(old)
        gains = self._gains(without)
        own = float(gains[old])
        gains[self.chosen] = -np.inf
        best = int(gains.argmax())
        if not gains[best] > own + LEAST_GAIN:
            return False
        self.chosen[place] = best
        self.information = without + self._of(best)
        self.history.append(self._volume())
        return True

    def _of(self, place: int) -> FloatArray:
        return np.asarray(self.blocks[place].T @ self.blocks[place])

    def _gains(self, information: FloatArray) -> FloatArray:
        """Gain log det(1 + Y M⁻¹ Yᵀ) of every candidate, (c,)."""
        lower = np.linalg.cholesky(information + 1e-3 * START * np.eye(len(information)))
        rows, columns = self.blocks.shape[1:]
        across = (self.blocks.reshape(-1, columns) @ np.linalg.inv(lower).T).reshape(-1, rows, columns)
        gains = np.linalg.slogdet(np.eye(rows) + across @ across.transpose(0, 2, 1))[1]
        return np.asarray(gains)

    def _volume(self) -> float:
        return float(np.linalg.slogdet(self.information)[1])
