"""What sees the surface move: a camera that is slow, late and noisy, and leaves pictures out."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc.experiments.settings import Settings, setting
from ravengc.track.motions import sampled

if TYPE_CHECKING:
    from ravengc.track.motions import Motion

__all__ = ["Camera", "CameraStream", "Picture"]

BLOCK = 256
"""Pictures taken at a time."""

Picture = tuple[float, float, tuple[float, float, float]]
"""When it arrives (s), when it was taken (s), and the displacement that it shows (m)."""


@dataclass(frozen=True, kw_only=True)
class Camera(Settings):
    """A camera that measures the displacement of the surface. ConfigError for numbers outside their range.

    A picture taken at time s arrives at s + ``latency_s`` + up to ``jitter_s``, so that jitter longer than a period
    swaps pictures. In the gaps, and in ``drop_fraction`` of the pictures at random, nothing arrives.
    """

    rate_hz: float = setting(30.0, 2.0, 1000.0, "Hz", "pictures per second")
    noise_m: float = setting(0.3e-3, 0.0, 1.0, "m", "standard deviation of a measurement, per axis")
    latency_s: float = setting(0.06, 0.0, 2.0, "s", "age of a picture when it arrives")
    jitter_s: float = setting(0.0, 0.0, 2.0, "s", "how much later it may arrive, evenly spread")
    drop_fraction: float = setting(0.0, 0.0, 1.0, "", "pictures that never arrive")
    gap_starts_s: tuple[float, ...] = setting((0.0,), 0.0, 1e6, "s", "when nothing is seen for a while")
    gap_lengths_s: tuple[float, ...] = setting((0.0,), 0.0, 1e6, "s", "for how long each time, as many numbers")
    seed: int = setting(0, 0, 2**63 - 1, "", "seed of noise, drops and jitter")

    def check(self) -> None:
        """Raise ConfigError unless every gap has a begin and a length."""
        from ravengc.errors import ConfigError

        if len(self.gap_starts_s) != len(self.gap_lengths_s):
            counts = f"{len(self.gap_starts_s)} and {len(self.gap_lengths_s)} numbers"
            raise ConfigError(f"gap_starts_s and gap_lengths_s have {counts}; expected as many")

    def stream(self, motion: Motion) -> CameraStream:
        """Begin to take pictures of a surface that moves so, from time zero on."""
        return CameraStream(self, motion)


class CameraStream:
    """The pictures of one run in the order in which they arrive; ``arrival`` is when the next one does (s)."""

    def __init__(self, camera: Camera, motion: Motion) -> None:
        self._camera, self._motion = camera, motion
        self._noise, self._fate = (np.random.default_rng(word) for word in (camera.seed, (camera.seed, 1)))
        self._waiting: list[Picture] = []
        self._taken = 0
        self._fill()

    @property
    def arrival(self) -> float:
        """When the next picture arrives, s; later than any time where the camera sees nothing any more."""
        return self._waiting[0][0] if self._waiting else self._seen_until

    def next(self) -> Picture | None:
        """The next picture, or None if the block that was looked at has none."""
        picture = heapq.heappop(self._waiting) if self._waiting else None
        if not self._waiting or self._waiting[0][0] > self._seen_until:
            self._fill()
        return picture

    def _fill(self) -> None:
        """Take another block of pictures."""
        camera = self._camera
        stamps = np.arange(self._taken, self._taken + BLOCK) / camera.rate_hz
        self._taken += BLOCK
        seen = sampled(self._motion, stamps)[0] + camera.noise_m * self._noise.standard_normal((BLOCK, 3))
        kept = self._fate.random(BLOCK) >= camera.drop_fraction
        arrivals = stamps + camera.latency_s + camera.jitter_s * self._fate.random(BLOCK)
        for start, length in zip(camera.gap_starts_s, camera.gap_lengths_s, strict=True):
            kept &= ~((stamps >= start) & (stamps < start + length))
        rows = zip(arrivals[kept].tolist(), stamps[kept].tolist(), seen[kept].tolist(), strict=True)
        for arrival, stamp, (x, y, z) in rows:
            heapq.heappush(self._waiting, (arrival, stamp, (x, y, z)))
        self._seen_until = self._taken / camera.rate_hz + camera.latency_s
