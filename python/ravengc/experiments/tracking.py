"""What the two trajectory experiments share: one run of the test trajectory, and its errors in the paper's measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.experiments.raven import Path, raven, sinusoid_path
from ravengc.experiments.settings import Settings, setting
from ravengc.experiments.trial import Trial, rms, run_trial

if TYPE_CHECKING:
    from ravengc.loop import Record

__all__ = ["SHOWN_EVERY", "UNITS", "TrajectorySettings", "change", "measures", "run_measured", "trace_times"]

Array = NDArray[np.float64]

UNITS = np.array((180.0 / np.pi, 180.0 / np.pi, 1000.0))
"""Joint errors are shown in deg, deg, mm."""
SHOWN_EVERY = 20
"""Every so many cycles of a trace are kept for pictures."""


@dataclass(frozen=True, kw_only=True)
class TrajectorySettings(Settings):
    """Settings of the test trajectory."""

    amplitude: float = setting(0.5 * 3.1 * 0.0254, 0.001, 0.06, "m", "amplitude of the tool's sinusoids")
    period_s: float = setting(4.0, 0.5, 60.0, "s", "period")
    cycles: int = setting(2, 1, 20, "", "periods in each direction")

    @property
    def path(self) -> Path:
        """The set-points."""
        return sinusoid_path(self.amplitude, self.period_s, self.cycles)


def run_measured(trial: Trial) -> dict[str, Array]:
    """Run a trial and return :func:`measures` of its record."""
    return measures(run_trial(trial))


def measures(record: Record) -> dict[str, Array]:
    """The paper's measures over all cycles, and joint 1's error for a picture.

    ``error`` (3,): RMS error of the joints at the motors' encoders, deg, deg, mm. ``share`` (3,): RMS of the PD term
    over RMS of the total torque, %. ``tool`` (1,): RMS distance of the tool point from its set-point, mm.
    """
    error = record.q_desired - record.q
    distance = _tool(record.q_desired) - _tool(record.q)
    return {
        "error": rms(error) * UNITS,
        "share": 100.0 * rms(record.tau_pd) / rms(record.tau),
        "tool": 1e3 * np.sqrt((distance**2).sum(1).mean(keepdims=True)),
        "trace": UNITS[0] * error[::SHOWN_EVERY, 0],
    }


def trace_times(settings: TrajectorySettings) -> Array:
    """Times (s) of the trace in :func:`measures`."""
    path = settings.path
    return np.arange(0, len(path.q), SHOWN_EVERY) / path.rate_hz


def change(found: Any, base: Any, joint: int = 0) -> float:
    """How much smaller (negative) or larger the RMS error of a joint is than in ``base``, %."""
    return float(100.0 * (found["error"][joint] / base["error"][joint] - 1.0))


def _tool(q: Array) -> Array:
    return raven().forward_kinematics_batch(q, "tool")[:, :3, 3]
