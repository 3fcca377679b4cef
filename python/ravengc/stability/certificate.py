"""The certificate: is what the accelerometer feeds back stable, how far is it from not being so, and what it costs."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from ravengc._convert import check_type
from ravengc.stability.counting import Count, poles_right_of
from ravengc.stability.loop_margins import Margins, Mode, base_modes, margins
from ravengc.stability.roots import Pole, rightmost_pole
from ravengc.stability.system import System

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["Certificate", "certify"]

LITTLE_DAMPING = 0.3
"""Share of a mode's damping below which a certificate comes with a caution."""
LITTLE_MARGIN_DB = 3.0


@dataclass(frozen=True, slots=True)
class Certificate:
    """What is known about one system.

    ``count`` of poles in the right half plane, the rightmost ``pole``, ``margins`` of the feedback, ``margin_db``
    (negative: the gain must fall by that much), and the base's ``modes``.
    """

    count: Count
    pole: Pole
    margins: Margins
    margin_db: float
    modes: tuple[Mode, ...]

    @property
    def certified(self) -> bool:
        """It is proven that nothing grows."""
        return self.count.none

    @property
    def verdict(self) -> str:
        """The outcome in a sentence."""
        if self.certified:
            return "certified: it is proven that no pole lies in the right half plane"
        if math.isinf(self.count.number):
            return "not certified: unstable for any delay, its high-frequency gain is above 1 and nothing filters it"
        if not self.count.proven:
            return "not certified: a pole lies on the imaginary axis, or too near to tell"
        growth, hz = self.pole.growth, self.pole.frequency_hz
        return f"not certified: {self.count.number} unstable poles; the base grows by {growth:.4g} 1/s at {hz:.4g} Hz"

    @property
    def cautions(self) -> tuple[str, ...]:
        """What to know about a system that is certified; empty for any other."""
        return tuple(self._cautions()) if self.certified else ()

    def _cautions(self) -> Iterator[str]:
        if self.margin_db < LITTLE_MARGIN_DB:
            yield f"the gain margin is only {self.margin_db:.2f} dB"
        for mode in self.modes:
            if mode.damping > 0.0 and mode.share < LITTLE_DAMPING:
                kept = f"{max(100.0 * mode.share, 0.0):.0f} %"
                yield f"the base keeps {kept} of its own damping at {mode.frequency_hz:.3g} Hz"

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain data, SI."""
        return {
            "certified": self.certified,
            "verdict": self.verdict,
            "cautions": list(self.cautions),
            "unstable_poles": self.count.number,
            "proven": self.count.proven,
            "pieces": self.count.pieces,
            "no_poles_beyond_rad_s": self.count.radius,
            "pole": {"real": self.pole.s.real, "imag": self.pole.s.imag, "rightmost_proven": self.pole.proven},
            "distance": self.margins.distance,
            "worst_hz": self.margins.worst_hz,
            "critical_gains": list(self.margins.critical_gains),
            "margin_db": self.margin_db,
            "modes": [
                {**asdict(mode), "share": mode.share, "effective_ratio": mode.effective_ratio} for mode in self.modes
            ],
        }


def certify(system: System) -> Certificate:
    """Count, find and measure; :class:`System` from :func:`linearise` or :meth:`OneLink.system`."""
    check_type(system, System, "system")
    count = poles_right_of(system)
    found = margins(system)
    margin = found.decibel(stable=count.none)
    return Certificate(count, rightmost_pole(system), found, margin, base_modes(system))
