"""Static poses from both sides: the mean of the torques on the way up and on the way down is without friction.

Coulomb and viscous friction, and any that is as large in one direction as in the other, have opposite signs on the two
ways at the same speed, and cancel in (tau+ + tau-)/2.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_number, check_type
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.identify.recording import BoolArray, FloatArray, Recording
from ravengc.messages import shown

if TYPE_CHECKING:
    import numpy.typing as npt

__all__ = ["both_ways"]


def both_ways(recording: Recording, *, tolerance: float = 0.01) -> Recording:
    """One sample per pose that was passed or approached in both directions, with the mean of both torques.

    Samples within ``tolerance`` (rad, m) in every joint, on a base that stands within that share of g alike, are one
    pose; the sign of ``qd`` says from where a joint came, and a joint that did not move there counts as both. A joint
    whose torque counts in no sample of a pose does not count there. Raises ArgumentError without velocities, and
    CalibrationError if no pose was approached from both sides.
    """
    check_type(recording, Recording, "recording")
    near = as_number(tolerance, "tolerance")
    if recording.qd is None:
        raise ArgumentError(f"{recording.source} has no velocities, which say from where a pose was approached")
    if not 0.0 < near < np.inf:
        raise ArgumentError(f"tolerance is {shown(tolerance)}; expected more than 0")
    means = [_mean(recording, rows) for rows in _poses(recording, near)]
    found = [mean for mean in means if mean is not None]
    if not found:
        raise CalibrationError(
            f"no pose of {recording.source} was approached from both sides; pass each up and down again"
        )
    q, tau, counted, base = (np.array(part) for part in zip(*found, strict=True))
    return replace(
        recording,
        stamps=np.arange(float(len(q))),
        q=q,
        tau=tau,
        qd=None,
        qdd=None,
        specific_force=base[:, :3],
        angular_velocity=None,
        angular_acceleration=None,
        counted=counted,
        cutoff_hz=None,
    )


def _poses(recording: Recording, near: float) -> list[npt.NDArray[np.intp]]:
    """Rows of each pose, in the order of their first samples."""
    places = np.hstack([recording.q, recording.base[:, :3] / 9.81])
    left = np.arange(recording.samples)
    poses = []
    while left.size:
        alike = np.abs(places[left] - places[left[0]]).max(axis=1) <= near
        poses.append(left[alike])
        left = left[~alike]
    return poses


def _mean(
    recording: Recording, rows: npt.NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, BoolArray, FloatArray] | None:
    """q, tau, counted and base of a pose, each way counting half; ``None`` if some joint came from one side only."""
    directions, torques, counts = np.sign(recording.velocity[rows]), recording.tau[rows], recording.counts[rows]
    tau: FloatArray = np.zeros(recording.joints)
    counted: BoolArray = np.asarray(counts.any(axis=0))
    for joint in np.flatnonzero(counted):
        signs, of_joint = directions[counts[:, joint], joint], torques[counts[:, joint], joint]
        up, down = of_joint[signs >= 0.0], of_joint[signs <= 0.0]
        if not up.size or not down.size:
            return None
        tau[joint] = 0.5 * (up.mean() + down.mean())
    return recording.q[rows].mean(axis=0), tau, counted, recording.base[rows].mean(axis=0)
