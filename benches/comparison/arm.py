"""The arm that all libraries compute, and the inputs of a few hundred cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import ravengc as rg
from ravengc.reference.kinematics import link_transform
from ravengc.spec import DhRow

if TYPE_CHECKING:
    from ravengc.spec import LinkSpec, RobotSpec

Array = NDArray[np.float64]

SAMPLES = 256
KP, KD, TAU_MAX = 50.0, 2.0, 80.0
"""Gains (N m/rad, N m s/rad) and limit (N m) of the control step, the same at every joint."""
LEVEL = np.array([0.0, 0.0, -rg.STANDARD_GRAVITY])


@dataclass(frozen=True)
class Arm:
    """The bundled Panda, whose link frames are its joints' frames (modified DH), z along the axis.

    Inputs are lists of small arrays, one per cycle, as a control loop has them: ``q``, ``qd``, ``qdd`` (n,), ``target``
    where the joints should be at rest, and, for a base that moves, ``f``, ``w``, ``dw`` (3,); ``g`` is -f.
    """

    spec: RobotSpec
    q: list[Array]
    qd: list[Array]
    qdd: list[Array]
    g: list[Array]
    f: list[Array]
    w: list[Array]
    dw: list[Array]
    target: list[Array]

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.spec.links)

    def placement(self, link: LinkSpec) -> Array:
        """Pose (4x4) of a link's frame in its parent's at coordinate zero."""
        return np.asarray(link_transform(self.spec, link, np.float64(0.0)))

    @property
    def tool(self) -> Array:
        """Place of the tool in the last link's frame; its axes are parallel."""
        return np.array(self.spec.tool.translation)


def panda() -> Arm:
    """The arm with the same random inputs every time; the base tilts, shakes and turns."""
    spec = rg.load("panda").spec
    random = np.random.default_rng(1)
    n = len(spec.links)

    def samples(size: int, scale: float) -> list[Array]:
        return [random.uniform(-scale, scale, size) for _ in range(SAMPLES)]

    g = [LEVEL + tilt for tilt in samples(3, 3.0)]
    motion = {"q": samples(n, 3.0), "qd": samples(n, 2.0), "qdd": samples(n, 5.0)}
    turning = {"w": samples(3, 1.0), "dw": samples(3, 2.0)}
    return Arm(spec=spec, **motion, g=g, f=[-one for one in g], **turning, target=samples(n, 3.0))


def along_a_path(arm: Arm) -> list[Array]:
    """Poses of an arm that moves as arms do, on a small round trip from its first pose."""
    turns = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    return [arm.q[0] + 0.1 * np.sin(turn + np.arange(arm.n)) for turn in turns]


def dh_row(link: LinkSpec) -> DhRow:
    """The link's row of the Denavit-Hartenberg table, for libraries that take nothing else."""
    assert isinstance(link.placement, DhRow)
    return link.placement


def inertia_matrix(link: LinkSpec) -> Array:
    """Inertia (3, 3) about the centre of mass."""
    xx, xy, xz, yy, yz, zz = link.inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
