"""What every base sensor gives: samples of specific force, and the counts that say how well it is read.

Specific force is f = a - g in the sensor's own axes: +9.81 m/s^2 along whatever points up, at rest. Sources that send
the gravity vector instead are turned round where they are read, so nothing behind this module knows of another sign.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import NamedTuple, Protocol

__all__ = ["Measurement", "Sample", "Sensor", "Statistics", "Triple"]

Triple = tuple[float, float, float]


class Sample(NamedTuple):
    """One reading of a base sensor.

    ``seq`` rises strictly within a sensor and skips what the sensor's own counter says was lost. ``stamp_ns`` is the
    host's CLOCK_MONOTONIC (ns) when the reading was taken, or when it arrived where the sensor has no clock.
    ``specific_force`` (m/s^2) and ``angular_velocity`` (rad/s, None without a gyroscope) are in sensor axes. The
    numbers are what the sensor sent: they may be NaN, infinite or absurd.
    """

    seq: int
    stamp_ns: int
    specific_force: Triple
    angular_velocity: Triple | None = None


class Measurement(NamedTuple):
    """What one frame says: SI, sensor axes, before it has a stamp.

    ``clock_ns`` is the sensor's own clock (ns, from any zero, already unwrapped), None where it sends none. ``steps``
    is how far the sensor's own counter moved, 1 where it sends none.
    """

    specific_force: Triple
    angular_velocity: Triple | None = None
    clock_ns: int | None = None
    steps: int = 1


@dataclass(slots=True)
class Statistics:
    """Counts since a sensor was opened; nothing that arrives is left out of all of them."""

    samples: int = 0
    """Frames that became samples."""
    other_frames: int = 0
    """Good frames of another content, such as a heartbeat or a magnetometer."""
    bad_checksum: int = 0
    """Frames, or what looked like the start of one, with a wrong checksum."""
    bad_content: int = 0
    """Frames that arrived whole and make no sense: too few fields, text where a number belongs."""
    unconfirmed: int = 0
    """Frames with a weak checksum that came right behind garbage, and were left out for that."""
    resynchronisations: int = 0
    """How often a good frame was found behind bytes that belong to none."""
    bytes_received: int = 0
    bytes_skipped: int = 0
    """Bytes that belong to no good frame."""
    frames_lost: int = 0
    """Frames that the sensor's own counter says were sent and never came."""
    clock_restarts: int = 0
    """How often the sensor's own clock jumped, as it does when the sensor restarts."""
    foreign_datagrams: int = 0
    """Datagrams from another sender than the first."""

    def as_dict(self) -> dict[str, int]:
        """Counts by name."""
        return asdict(self)

    def add(self, other: Statistics) -> None:
        """Add the counts of another sensor, such as the same one before it was reopened."""
        for field in fields(self):
            setattr(self, field.name, getattr(self, field.name) + getattr(other, field.name))


class Sensor(Protocol):
    """Where samples come from.

    ``name`` says which sensor it is; ``statistics`` counts; ``remark`` has, in words, what was last wrong with the
    stream or what the sensor itself said last, "" if nothing; ``finished`` is true once there will never be another
    sample, at the end of a recording.
    """

    @property
    def name(self) -> str:
        """Which sensor it is."""

    @property
    def statistics(self) -> Statistics:
        """Counts since it was opened."""

    @property
    def remark(self) -> str:
        """What was last wrong with the stream, or what the sensor said last, in words."""

    @property
    def finished(self) -> bool:
        """Whether there will never be another sample."""

    def read(self, timeout_s: float) -> Sample | None:
        """Wait at most ``timeout_s`` for the next sample; None if there was none.

        Never raises for what the sensor sends. Raises SensorError when the link itself is gone.
        """

    def close(self) -> None:
        """Let go of the link; more than once is no error."""
