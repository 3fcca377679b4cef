"""All methods, and the switch between them."""

from __future__ import annotations

from math import exp
from typing import TYPE_CHECKING

import numpy as np

from ravengc.reference.prediction.autoregressive import Autoregressive
from ravengc.reference.prediction.fourier import Fourier
from ravengc.reference.prediction.kinematic import Kinematic
from ravengc.reference.prediction.periodic import Periodic
from ravengc.reference.prediction.spectrum import Spectrum

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Moving = tuple[NDArray[np.float64], NDArray[np.float64]]

__all__ = ["METHODS", "Predictor"]

METHODS = ("hold", "velocity", "acceleration", "periodic", "autoregressive", "fourier")
WAITING = 32
MEMORY = 20.0
FEWEST = 8
SHARPNESS = 8
SMALLEST = 1e-3


class Predictor:
    """Methods that are each held to what they said of the horizon, and weighed by how well they did (see ``ravengc.Predictor``)."""

    def __init__(
        self,
        rate_hz: float,
        horizon_s: float,
        *,
        band: tuple[float, float] = (0.08, 1.0),
        noise: float = 3e-4,
        harmonics: int = 2,
        start_s: float | None = None,
    ) -> None:
        self.horizon = horizon_s
        self.velocity, self.acceleration = Kinematic(1, noise), Kinematic(2, noise)
        self.periodic = Periodic(band, harmonics, noise)
        self.spectrum = Spectrum(band, harmonics, 0.96 / band[0] if start_s is None else start_s)
        self.autoregressive = Autoregressive(rate_hz, horizon_s)
        self.fourier = Fourier(band, noise)
        self.newest: NDArray[np.float64] | None = None
        self.said: list[tuple[float, list[Moving | None]]] = []
        self.errors = {name: (0.0, 0.0, 0) for name in METHODS}
        self.weights = dict.fromkeys(METHODS, 0.0)
        self.measured = 0.0

    def update(self, t: float, y: NDArray[np.float64]) -> None:
        """Take a sample: its time, s, and the position (axes,), m."""
        y = np.asarray(y, dtype=np.float64)
        self.newest = y
        self.measure(t, y)
        for method in (self.velocity, self.acceleration, self.periodic, self.autoregressive, self.fourier):
            method.update(t, y)
        self.spectrum.record(t, y)
        should_begin = np.isnan(self.periodic.time) or self.is_lost("periodic")
        cycles = self.spectrum.search(t) if should_begin else None
        if cycles:
            self.periodic.begin(t, cycles)
            self.errors["periodic"] = (0.0, 0.0, 0)
            self.weigh()
        about = t + self.horizon
        if not self.said or about - self.said[-1][0] >= self.horizon / (WAITING - 6):
            self.said = [*self.said, (about, [self.opinion(name, about) for name in METHODS])][-WAITING:]

    def is_lost(self, name: str) -> bool:
        """It has lately been worse than holding still."""
        return self.errors[name][2] >= FEWEST and self.errors[name][0] > self.errors["hold"][0]

    def measure(self, t: float, y: NDArray[np.float64]) -> None:
        """Hold the newest opinions that were about an earlier time to where the target is."""
        due = [i for i, (about, _) in enumerate(self.said) if about <= t]
        if not due:
            return
        about, opinions = self.said[due[-1]]
        self.said = self.said[due[-1] + 1 :]
        kept, self.measured = exp(-min(max(t - self.measured, 0.0), MEMORY) / MEMORY), t
        for name, opinion in zip(METHODS, opinions, strict=True):
            if opinion:
                error = opinion[0] + opinion[1] * (t - about) - y
                value, weight, count = self.errors[name]
                weight = kept * weight + 1
                self.errors[name] = value + (error @ error - value) / weight, weight, count + 1
        self.weigh()

    def weigh(self) -> None:
        """Weights by a high power of the inverse of the mean square errors."""
        heard = {name: value for name, (value, _, count) in self.errors.items() if count >= FEWEST}
        tiny, least = np.finfo(float).tiny, min(heard.values(), default=0.0)
        shares = {name: ((least + tiny) / (value + tiny)) ** SHARPNESS for name, value in heard.items()}
        self.weights = {name: share if (share := shares.get(name, 0.0)) >= SMALLEST else 0.0 for name in METHODS}

    def opinion(self, name: str, t: float) -> Moving | None:
        """What one method, or "switch", says of time ``t``."""
        if name == "switch":
            return self.blend(t)
        if name == "hold":
            return None if self.newest is None else (self.newest, np.zeros_like(self.newest))
        found: Moving | None = getattr(self, name).at(t)
        return found

    def blend(self, t: float) -> Moving | None:
        """The methods together, each with its weight."""
        said = [(w, opinion) for name, w in self.weights.items() if w > 0 and (opinion := self.opinion(name, t))]
        total = sum(w for w, _ in said)
        if not total:
            return None
        return sum(w * p for w, (p, _) in said) / total, sum(w * v for w, (_, v) in said) / total

    def predict(self, t: float, method: str = "switch") -> NDArray[np.float64]:
        """Where the target is at ``t``: (axes,), m. Another method stands in for one that cannot say."""
        opinion = self.opinion(method, t) or self.blend(t) or self.opinion("hold", t)
        if opinion is None:
            raise ValueError("there has been no sample yet")
        return opinion[0]
