"""Where the surface is taken to be: predicted from late pictures, where it was seen last, or the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, cast

import numpy as np

import ravengc

if TYPE_CHECKING:
    from ravengc.track.approach import Triple
    from ravengc.track.camera import Camera
    from ravengc.track.settings import PredictorName, TrackSettings

__all__ = ["Belief", "belief"]

NOWHERE = (0.0, 0.0, 0.0)
NOTHING_COUNTED: dict[str, int] = {}
LONGEST_S, FARTHEST_S = 1.0, 2.0
"""How far ahead, at least, a prediction goes on before it stands still; and for which age of pictures it can be meant.
"""


class Belief(Protocol):
    """Displacement and velocity of the surface as a tracker takes them; ``seen`` is False until there is something."""

    seen: bool

    @property
    def counters(self) -> dict[str, int]:
        """The predictor's counters; none where nothing is predicted."""

    def update(self, stamp_s: float, position: Triple) -> None:
        """Take a picture's measurement, which may be late, repeated, or before the last one."""

    def at(self, t: float, truth: Triple, rate: Triple) -> tuple[Triple, Triple]:
        """Displacement (m) and velocity (m/s) for the time ``t`` of now; the truth is for the oracle alone."""


class _LastSeen:
    """The newest picture, as if nothing moved."""

    counters = NOTHING_COUNTED

    def __init__(self) -> None:
        self.seen = False
        self._stamp, self._position = -np.inf, NOWHERE

    def update(self, stamp_s: float, position: Triple) -> None:
        if stamp_s > self._stamp:
            self.seen, self._stamp, self._position = True, stamp_s, position

    def at(self, t: float, truth: Triple, rate: Triple) -> tuple[Triple, Triple]:  # noqa: ARG002
        return self._position, NOWHERE


class _Truth:
    """What no camera knows."""

    seen = True
    counters = NOTHING_COUNTED

    def __init__(self, *, moving: bool) -> None:
        self._moving = moving

    def update(self, stamp_s: float, position: Triple) -> None:
        """Pictures tell nothing new."""

    def at(self, t: float, truth: Triple, rate: Triple) -> tuple[Triple, Triple]:  # noqa: ARG002
        return truth, rate if self._moving else NOWHERE


class _Predicted:
    """The predictor's."""

    def __init__(self, settings: TrackSettings, camera: Camera) -> None:
        self.seen = False
        self._moving = settings.feed_forward
        self._fastest = settings.speed_max
        # A picture is used from its arrival to that of the next one.
        horizon = min(camera.latency_s + (camera.jitter_s + 1.0 / camera.rate_hz) / 2.0, FARTHEST_S)
        self.predictor = ravengc.Predictor(
            camera.rate_hz,
            axes=3,
            method=cast("PredictorName", settings.predictor),
            horizon_s=horizon,
            band=settings.band_hz,
            harmonics=settings.harmonics,
            longest_s=max(LONGEST_S, horizon),
            noise=max(camera.noise_m, 1e-6),
        )
        self._position, self._velocity = np.zeros(3), np.zeros(3)
        self._picture = np.zeros(3)

    @property
    def counters(self) -> dict[str, int]:
        return self.predictor.counters

    def update(self, stamp_s: float, position: Triple) -> None:
        self._picture[:] = position
        self.seen = self.predictor.update(stamp_s, self._picture) or self.seen

    def at(self, t: float, truth: Triple, rate: Triple) -> tuple[Triple, Triple]:  # noqa: ARG002
        x, y, z = self.predictor.predict(t, out=self._position).tolist()
        if not self._moving:
            return (x, y, z), NOWHERE
        a, b, c = self.predictor.velocity(t, out=self._velocity).tolist()
        speed = (a * a + b * b + c * c) ** 0.5
        factor = min(1.0, self._fastest / speed) if speed > 0.0 else 0.0
        return (x, y, z), (factor * a, factor * b, factor * c)


def belief(settings: TrackSettings, camera: Camera) -> Belief:
    """The belief of the settings' method."""
    if settings.method == "oracle":
        return _Truth(moving=settings.feed_forward)
    return _LastSeen() if settings.method == "naive" else _Predicted(settings, camera)
