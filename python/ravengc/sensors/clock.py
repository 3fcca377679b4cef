"""When a reading was taken: the sensor's own clock unwrapped and mapped to the host's, or arrival spread evenly.

The map rests on one fact: a reading cannot arrive before it is taken. With t the sensor's clock and A the arrival, the
least A - t seen is the zero of the sensor's clock plus the shortest way here; what a reading took longer is its age.
The least is let rise by 1 % of the time, so that it follows a clock that is slow (ceramic resonators: 0.5 %). A
constant delay cannot be seen from one side, here as anywhere.
"""

from __future__ import annotations

__all__ = ["ClockMap", "Unwrapper", "spread"]

AHEAD_NS = 1_000_000_000
"""A clock that is further ahead than the time that passed explains, and this much, has jumped."""
BACK_NS = 100_000_000
"""A clock that goes back further than datagrams overtake one another has started again."""
RISE = 100
"""The zero of the sensor's clock may rise by the time since the last reading divided by this."""


class Unwrapper:
    """A counter of ``bits`` bits that wraps, made into one that does not. The first value is kept as it is.

    Each step is taken as the shorter way round, so a counter may also go back a little.
    """

    def __init__(self, bits: int) -> None:
        self._span = 1 << bits
        self._last: int | None = None

    def unwrap(self, counter: int) -> int:
        """The counter without its wraps."""
        if self._last is None:
            self._last = counter % self._span
        step = (counter - self._last) % self._span
        self._last += step if step < self._span // 2 else step - self._span
        return self._last


class ClockMap:
    """From a sensor's clock to the host's, both ns. ``restarts`` counts jumps, after which the map starts again."""

    def __init__(self) -> None:
        self.restarts = 0
        self._zero = 0
        self._clock: int | None = None
        self._arrival = 0
        self._stamp = 0

    def stamp(self, clock_ns: int, arrival_ns: int) -> int:
        """When the reading with ``clock_ns`` was taken, never after its arrival.

        Readings in the sensor's order get stamps in that order; they move by at least half of the sensor's step while
        the map still learns. A reading out of order gets its own, earlier, stamp.
        """
        if self._clock is None or self._jumped(clock_ns - self._clock, arrival_ns - self._arrival):
            self._restart(clock_ns, arrival_ns)
        step = clock_ns - (self._clock or 0)
        self._zero = min(self._zero + max(arrival_ns - self._arrival, 0) // RISE, arrival_ns - clock_ns)
        stamp = clock_ns + self._zero
        if step > 0:
            stamp = min(max(stamp, self._stamp + step // 2), arrival_ns)
            self._clock, self._stamp = clock_ns, stamp
        self._arrival = max(arrival_ns, self._arrival)
        return stamp

    def _jumped(self, step: int, elapsed: int) -> bool:
        """Whether the clock went back or ahead by more than a late reading can explain."""
        return step < -BACK_NS or step - elapsed > AHEAD_NS

    def _restart(self, clock_ns: int, arrival_ns: int) -> None:
        self.restarts += self._clock is not None
        self._clock, self._zero = clock_ns, arrival_ns - clock_ns
        self._arrival = self._stamp = arrival_ns


def spread(count: int, before_ns: int, arrival_ns: int) -> list[int]:
    """Stamps of ``count`` readings that came together, spread evenly over the time since those ``before_ns``.

    They rise strictly, and the last is the arrival.
    """
    gap = max(arrival_ns - before_ns, count)
    return [before_ns + gap * number // count for number in range(1, count + 1)]
