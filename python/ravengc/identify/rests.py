"""The poses in which an arm came to rest during a log that was recorded throughout: one sample each.

A recorder runs while the arm goes from pose to pose; only where it rests are the torques those of gravity and friction
alone, and only the way by which it came says which sign the friction has.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ravengc._convert import as_number, check_type
from ravengc.errors import ArgumentError
from ravengc.identify.recording import FloatArray, Recording

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["rests"]

SETTLING = 0.25
"""Share of a rest at its beginning that is left out: the arm may still swing."""


def rests(recording: Recording, *, shortest_s: float = 0.3, tolerance: float = 0.002) -> Recording:
    """One sample per rest: the means of its last three quarters, and as ``qd`` the sign of the way by which it came.

    A torque counts that does throughout a rest. An arm rests while every joint stays within ``tolerance`` (rad, m) for
    ``shortest_s`` seconds. Raises ArgumentError where it never does.
    """
    check_type(recording, Recording, "recording")
    shortest, near = as_number(shortest_s, "shortest_s"), as_number(tolerance, "tolerance")
    if not (0.0 < shortest < np.inf and 0.0 < near < np.inf):
        raise ArgumentError(f"shortest_s is {shortest:g} and tolerance {near:g}; expected more than 0")
    runs = _runs(recording, shortest, near)
    if not runs:
        raise ArgumentError(f"{recording.source}: the arm never rests for {shortest:g} s within {near:g} rad or m")
    parts = {"q": recording.q, "tau": recording.tau, "base": recording.base}
    means = {name: np.array([_mean(values, *run) for run in runs]) for name, values in parts.items()}
    return replace(
        recording,
        stamps=np.array([recording.stamps[first] for first, _ in runs]),
        q=means["q"],
        tau=means["tau"],
        qd=np.array([_came(recording.q[:first], at, near) for (first, _), at in zip(runs, means["q"], strict=True)]),
        qdd=None,
        specific_force=means["base"][:, :3],
        angular_velocity=None,
        angular_acceleration=None,
        counted=np.array([recording.counts[first:past].all(axis=0) for first, past in runs]),
        cutoff_hz=None,
    )


def _runs(recording: Recording, shortest: float, near: float) -> list[tuple[int, int]]:
    """First and past-last samples of every rest."""
    steps = np.diff(recording.stamps)
    width = max(3, round(shortest / float(np.median(steps)))) if steps.size else 3
    if recording.samples <= width:
        return []
    still = np.ones(recording.samples - width + 1, dtype=bool)
    for column in recording.q.T:
        window = sliding_window_view(column, width)
        still &= window.max(axis=1) - window.min(axis=1) <= near
    resting = np.zeros(recording.samples + 2, dtype=int)
    resting[1:-1] = np.convolve(still, np.ones(width)) > 0.5
    edges = np.diff(resting)
    return list(zip(np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist(), strict=True))


def _mean(values: FloatArray, first: int, past: int) -> FloatArray:
    start = first + int(SETTLING * (past - first))
    return np.asarray(values[start:past].mean(axis=0))


def _came(before: FloatArray, at: FloatArray, near: float) -> FloatArray:
    """From which side every joint came: +1 from below, -1 from above, 0 where it was never elsewhere."""
    signs = np.zeros(len(at))
    for joint, place in enumerate(at):
        away: NDArray[np.intp] = np.flatnonzero(np.abs(before[:, joint] - place) > 2.0 * near)
        if away.size:
            signs[joint] = np.sign(place - before[away[-1], joint])
    return signs
