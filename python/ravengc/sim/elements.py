"""A robot's disturbance elements in its plant: friction that sticks exactly, everything else as its formula says."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeGuard

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc.disturbances import Friction

if TYPE_CHECKING:
    from ravengc.disturbances import Disturbance

__all__ = ["PlantElements"]

Array = NDArray[np.float64]


class PlantElements:
    """What acts on a plant's coordinates beside its masses.

    Friction along one coordinate becomes ``coulomb`` and ``viscous`` (n,), for the plant's own friction model: an arm
    sticks where a law only has a dead band, and all of it rubs, whatever ``ratio`` a law compensates. With Stribeck
    friction, along a combination of coordinates or below zero it stays an element; those give :meth:`torque`.
    """

    def __init__(self, robot: ravengc.Robot, *, present: bool) -> None:
        elements = robot.spec.disturbances if present else ()
        self.coulomb, self.viscous = np.zeros((2, robot.n))
        for element in filter(_rubs, elements):
            joint = robot.joint_names.index(str(element.joint))
            self.coulomb[joint] += element.coulomb
            self.viscous[joint] += element.viscous
        rest = tuple(element for element in elements if not _rubs(element))
        self._robot = ravengc.Robot(replace(robot.spec, disturbances=rest)) if rest else None
        self._torque = np.zeros(robot.n)

    @property
    def present(self) -> bool:
        """Whether any element gives a torque."""
        return self._robot is not None

    def torque(self, q: Array, qd: Array) -> Array:
        """Torque (n,) of the elements at ``q`` and ``qd`` (n,), N m or N; overwritten by the next call."""
        return self._torque if self._robot is None else self._robot.disturbance_torque(q, qd, self._torque)


def _rubs(element: Disturbance) -> TypeGuard[Friction]:
    """Tell whether an element is friction as a plant has it: Coulomb and viscous, along one coordinate."""
    if not isinstance(element, Friction) or not isinstance(element.joint, str):
        return False
    along_one = element.of is None or element.of == element.joint
    return along_one and element.stribeck == 0.0 and element.coulomb >= 0.0 and element.viscous >= 0.0
