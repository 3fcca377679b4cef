"""The numbers of a run: how punctual the loop was, how well the joints followed, and who gave the torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ravengc.monitored import STATES

if TYPE_CHECKING:
    from ravengc.loop import Record

__all__ = ["RunSummary", "Spread", "rms", "summarise"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Spread:
    """Median, 99.9th percentile and largest of a set of durations, in microseconds."""

    p50: float
    p99_9: float
    max: float


@dataclass(frozen=True, slots=True)
class RunSummary:
    """What a :class:`ravengc.loop.Record` amounts to; joints in the robot's order, rad or m, N m or N.

    ``compute_us`` is the control law with its bound gravity cycle, ``lateness_us`` the start of a cycle after its
    deadline. ``pd_share`` is RMS(PD) / RMS(total torque) of each joint, ``pd_share_revolute`` the same with the
    revolute joints' RMS torques taken together as the lengths of two vectors (NaN for an arm without any).
    ``sensor_seconds`` is how long the base sensor was in each state.
    """

    cycles: int
    late_cycles: int
    skipped_cycles: int
    compute_us: Spread
    lateness_us: Spread
    rms_error: Array
    rms_pd: Array
    rms_gravity: Array
    rms_disturbance: Array
    rms_torque: Array
    pd_share: Array
    pd_share_revolute: float
    sensor_seconds: dict[str, float]
    finite: bool


def summarise(record: Record, slides: NDArray[np.bool_]) -> RunSummary:
    """Summarise a record; ``slides`` (n,) says which coordinates slide rather than turn."""
    rows = slice(0, record.count)
    rms_pd, rms_torque = rms(record.tau_pd[rows]), rms(record.tau[rows])
    return RunSummary(
        cycles=record.count,
        late_cycles=int(record.late[rows].sum()),
        skipped_cycles=record.skipped,
        compute_us=_spread(record.compute_ns[rows]),
        lateness_us=_spread(record.lateness_ns[rows]),
        rms_error=rms(record.q_desired[rows] - record.q[rows]),
        rms_pd=rms_pd,
        rms_gravity=rms(record.tau_gravity[rows]),
        rms_disturbance=rms(record.tau_disturbance[rows]),
        rms_torque=rms_torque,
        pd_share=_ratio(rms_pd, rms_torque),
        pd_share_revolute=float(_ratio(np.linalg.norm(rms_pd[~slides]), np.linalg.norm(rms_torque[~slides]))),
        sensor_seconds=_durations(record),
        finite=bool(np.isfinite(record.q[rows]).all() and np.isfinite(record.tau[rows]).all()),
    )


def _durations(record: Record) -> dict[str, float]:
    """Seconds in each state of the sensor; a cycle lasts until the next one."""
    time, state = record.time[: record.count], record.sensor_state[: record.count]
    lasted = np.diff(time, append=time[-1:])
    return {name: float(lasted[state == number].sum()) for number, name in enumerate(STATES)}


def rms(values: Array) -> Array:
    """Root mean square over the rows, (rows, n) -> (n,); zero for no rows."""
    return np.sqrt(np.mean(np.square(values), axis=0)) if len(values) else np.zeros(values.shape[1:])


def _ratio(part: Array | np.floating, whole: Array | np.floating) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(part) / np.asarray(whole)


def _spread(nanoseconds: NDArray[np.int64]) -> Spread:
    if not len(nanoseconds):
        return Spread(0.0, 0.0, 0.0)
    p50, p99_9, largest = np.percentile(nanoseconds, (50.0, 99.9, 100.0)) / 1e3
    return Spread(float(p50), float(p99_9), float(largest))
