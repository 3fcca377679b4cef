"""What is kept from the fit, and the verdicts on it: errors of every joint, excitation, and refusal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc._convert import as_number
from ravengc.errors import ArgumentError, CalibrationError
from ravengc.identify.ranks import triangle
from ravengc.identify.recording import BoolArray, FloatArray, Recording, as_recordings
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy.typing as npt

    from ravengc.identify.base_parameters import BaseParameters
    from ravengc.identify.reduction import Reduction

__all__ = ["JointErrors", "excitation", "joint_errors", "misfit", "refusal", "split"]

UNEXCITED = 1e-7
"""Share of a column, across all others, below which a recording says nothing about its parameter."""
WORSE = 1.01
"""A fit is worse than one without some columns if its held-out error is more than 1 % larger: less is chance."""


@dataclass(frozen=True, slots=True, eq=False)
class JointErrors:
    """RMS error ``rms`` (n,) and RMS ``torque`` (n,) of every joint, N·m or N, over its ``samples`` (n,) that count.

    NaN for a joint of which no sample counts.
    """

    rms: FloatArray
    torque: FloatArray
    samples: npt.NDArray[np.int64]

    @property
    def relative(self) -> FloatArray:
        """RMS errors over RMS torques, (n,); NaN where there is no torque."""
        return self.rms / np.where(self.torque > 0.0, self.torque, np.nan)

    @property
    def overall(self) -> float:
        """|error| over |torque| of all joints together."""
        error, torque = (float(np.linalg.norm(np.nan_to_num(part))) for part in (self.rms, self.torque))
        return error / max(torque, 1e-300)


def joint_errors(reduction: Reduction, parameters: FloatArray) -> JointErrors:
    """Errors of these parameters on reduced rows."""
    samples = np.where(reduction.samples > 0, reduction.samples, np.nan)
    rms, torque = (np.sqrt(squares / samples) for squares in (reduction.squares(parameters), reduction.energy))
    return JointErrors(rms, torque, reduction.samples)


def split(
    recordings: tuple[Recording, ...], held_out: float | Recording | Sequence[Recording], joints: int
) -> tuple[tuple[Recording, ...], tuple[Recording, ...]]:
    """Recordings to fit, and those held out: the last share of each, or recordings of their own."""
    if isinstance(held_out, (Recording, list, tuple)):
        return recordings, as_recordings(held_out, "held_out", joints)
    share = as_number(held_out, "held_out")
    if not 0.05 <= share <= 0.9:
        raise ArgumentError(f"held_out is {shown(held_out)}; expected a share from 0.05 to 0.9, or a Recording")
    train, test = zip(*(_parted(one, share) for one in recordings), strict=True)
    return train, test


def _parted(recording: Recording, share: float) -> tuple[Recording, Recording]:
    first = round(recording.samples * (1.0 - share))
    if not 0 < first < recording.samples:
        raise ArgumentError(
            f"{recording.source} has {recording.samples} samples; too few to hold out {share:g} of them"
        )
    return recording.take(slice(0, first)), recording.take(slice(first, None))


def excitation(base: BaseParameters, reduction: Reduction) -> None:
    """Raise CalibrationError if the rows say nothing about some base parameter."""
    R = np.concatenate([triangle_[:, base.chosen] for triangle_ in reduction.triangles])
    missing = [base.names[place] for place in _unseen(triangle(R))]
    if missing:
        some = "; ".join(missing[:6]) + (f"; and {len(missing) - 6} more" if len(missing) > 6 else "")
        what = "record a motion, or poses, in which every joint moves far, and not all together"
        raise CalibrationError(
            f"the recording says nothing about {len(missing)} of {base.rank} parameters: {some}; {what}"
        )


def _unseen(R: FloatArray) -> list[int]:
    """Columns that are, to rounding, sums of those before them, or zero."""
    lengths = np.linalg.norm(R, axis=0)
    scaled = R / np.where(lengths > 0.0, lengths, 1.0)
    left = np.abs(np.diag(np.linalg.qr(scaled, mode="r")))
    return [int(place) for place in np.flatnonzero((left < UNEXCITED) | (lengths == 0.0))]


def refusal(
    groups: tuple[str, ...], parameters: FloatArray, errors: Callable[[BoolArray], tuple[float, float]]
) -> str | None:
    """Why the fit must not be used: extra columns with which it predicts worse than without; ``None`` if it may.

    ``groups`` names every column's group; ``errors`` gives the held-out errors of the fit and of one without the marked
    columns.
    """
    said = []
    for group in dict.fromkeys(groups):
        marked = np.array([one == group for one in groups])
        if group == "links" or not parameters[marked].any():
            continue
        error, without = errors(marked)
        if error > WORSE * without:
            said.append(f"{group} (held-out error {error:.4g} sigma with, {without:.4g} without)")
    if not said:
        return None
    return f"it predicts worse than without {' and '.join(said)}; leave that out, or record more"


def misfit(test: Reduction, parameters: FloatArray, weights: FloatArray) -> float:
    """RMS over the joints that count of their RMS errors times their weights: in units of their sigma in the fit."""
    seen = test.samples > 0
    squares = (weights**2 * test.squares(parameters))[seen] / test.samples[seen]
    return float(np.sqrt(squares.mean()))
