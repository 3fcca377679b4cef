"""What a base does, as curves: the angles of its hinges, and how hard it accelerates where it slides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ravengc.sim import PrescribedBase

__all__ = ["BaseCurve", "base_curves"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BaseCurve:
    """One coordinate of a base: ``values`` (k,) in deg where it ``turns``, else in m/s^2; ``name`` says which it is."""

    name: str
    values: Array
    turns: bool


def base_curves(base: PrescribedBase, time: Array) -> tuple[BaseCurve, ...]:
    """Return what moves, or stands elsewhere than level, at the moments ``time`` (k,), s.

    A slide is shown by its acceleration along the world's axis, which is what the arm feels of it: a base that coasts
    far away stands still for the arm. A base that does nothing has one curve, the zero angle of its first hinge.
    """
    states = [base.state(t) for t in time.tolist()]
    angles = np.rad2deg([state.position[3:] for state in states]).reshape(-1, 3)
    accelerations = np.array([state.acceleration[:3] for state in states]).reshape(-1, 3)
    turning = [
        BaseCurve(f"about {_axis_name(axis, i)}", values, turns=True)
        for i, (axis, values) in enumerate(zip(base.axes, angles.T, strict=True))
    ]
    sliding = [BaseCurve(name, values, turns=False) for name, values in zip("xyz", accelerations.T, strict=True)]
    moving = tuple(curve for curve in (*turning, *sliding) if np.abs(curve.values).max(initial=0.0) > 0.0)
    return moving or tuple(turning[:1])


def _axis_name(axis: Array, hinge: int) -> str:
    """``x`` or ``-y`` for an axis of the base, else which hinge it is."""
    largest = int(np.abs(axis).argmax())
    if np.count_nonzero(axis) > 1:
        return f"axis {hinge + 1}"
    return "xyz"[largest] if axis[largest] > 0.0 else f"-{'xyz'[largest]}"
