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
SHARPNESS = 4
SMALLEST = 1e-3
TIE = 1e-3
LOST = (0.5, 2.0)
LEAST_SHARE = 0.2
TRUST_IN_HOLD = 0.8
PATIENCE = 15.0
TINY = float(np.finfo(float).tiny)


class Predictor:
    """Methods that are held to what they said of the horizon, and weighed by how well they did."""

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
        self.horizon, self.noise = horizon_s, noise
        self.velocity, self.acceleration = Kinematic(1, noise), Kinematic(2, noise)
        self.periodic = Periodic(band, harmonics, noise)
        self.spectrum = Spectrum(band, harmonics, 0.96 / band[0] if start_s is None else start_s)
        self.autoregressive = Autoregressive(rate_hz, horizon_s)
        self.fourier = Fourier(band, noise)
        self.newest: NDArray[np.float64] | None = None
        self.said: list[tuple[float, list[Moving | None]]] = []
        self.errors = dict.fromkeys(METHODS, (0.0, 0.0, 0))
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
        begun = self.periodic.begun
        should_begin = np.isnan(begun) or (self.is_lost("periodic") and self.periodic.time - begun > PATIENCE)
        cycles = self.spectrum.search(t) if should_begin else None
        if cycles:
            self.periodic.begin(t, cycles)
            self.errors["periodic"] = (0.0, 0.0, 0)
            self.weigh()
        about = t + self.horizon
        if not self.said or about - self.said[-1][0] >= self.horizon / (WAITING - 6):
            self.said = [*self.said, (about, [self.opinion(name, about) for name in METHODS])][-WAITING:]

    def is_lost(self, name: str) -> bool:
        """It has lately been little better than holding still, and much worse than the best."""
        value, _, count = self.errors[name]
        return count >= FEWEST and value > max(LOST[0] * self.errors["hold"][0], LOST[1] * min(self.heard().values()))

    def heard(self) -> dict[str, float]:
        """Mean square errors of the methods that were measured often enough."""
        return {name: value for name, (value, _, count) in self.errors.items() if count >= FEWEST}

    def measure(self, t: float, y: NDArray[np.float64]) -> None:
        """Hold the newest opinions that were about an earlier time to where the target is."""
        due = [i for i, (about, _) in enumerate(self.said) if about <= t + TIE * self.horizon]
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
                value += (float(error @ error) - value) / weight
                self.errors[name] = value, weight, count + 1
        self.weigh()

    def weigh(self) -> None:
        """Weights by a high power of the inverse of the mean square errors."""
        noise = (0 if self.newest is None else len(self.newest)) * self.noise**2
        own = {name: max(value - noise, LEAST_SHARE * value) + TINY for name, value in self.heard().items()}
        trusted = own | {"hold": TRUST_IN_HOLD * own["hold"]} if own else own
        shares = {name: (min(own.values()) / value) ** SHARPNESS for name, value in trusted.items()}
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
        position = np.sum([w * p for w, (p, _) in said], axis=0) / total
        return position, np.sum([w * v for w, (_, v) in said], axis=0) / total

    def predict(self, t: float, method: str = "switch") -> NDArray[np.float64]:
        """Where the target is at ``t``: (axes,), m. Another method stands in for one that cannot say."""
        opinion = self.opinion(method, t) or self.blend(t) or self.opinion("hold", t)
        if opinion is None:
            raise ValueError("there has been no sample yet")
        return opinion[0]
