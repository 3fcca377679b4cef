"""How large a rounding error may be: the scale of each result.

A torque is a sum of terms that may cancel; its rounding error is a small multiple of the machine epsilon times the sum
of the terms' sizes, whatever the sum itself comes to. :class:`Bounds` bounds that sum from above with four sizes of the
robot: its mass, the longest lever from any joint (or the base origin) to any mass, the trace of its inertias, and the
gain of its coupling. The bound is generous, often ten times the sum it bounds, so two results are called equal when
they differ by less than 1e-13 of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc import reference as ref

if TYPE_CHECKING:
    import numpy.typing as npt

    from ravengc.spec import RobotSpec

TOLERANCE = 1e-13
NOTHING = (0.0, (0.0, 0.0, 0.0), (0.0,) * 6)


@dataclass(frozen=True)
class Bounds:
    """Bounds of the sums of terms behind each result. SI; metres and radians count alike, so levers are 1 or more."""

    mass: float
    lever: float
    inertia: float
    gain: float
    acceleration: float
    angular: float

    @property
    def moment(self) -> float:
        """Moment (or force) of the mass under the largest specific force, and of the links' own rotation; also -U."""
        return self.mass * self.acceleration * self.lever + self.inertia * self.angular

    @property
    def torque(self) -> float:
        """Torque on the user's coordinates."""
        return self.gain * self.moment

    @property
    def stiffness(self) -> float:
        """Derivative of the torque with respect to a coordinate."""
        return self.gain * self.torque

    @property
    def mass_matrix(self) -> float:
        """Entries of the mass matrix."""
        return self.gain**2 * (self.mass * self.lever**2 + self.inertia)

    @property
    def jacobian(self) -> float:
        """Entries of the Jacobian."""
        return self.gain * self.lever

    @property
    def regressor(self) -> float:
        """Torque of a unit mass, first moment or inertia."""
        return self.gain * (self.acceleration * self.lever + self.angular)


def bounds(
    spec: RobotSpec,
    q: npt.ArrayLike,
    qd: npt.ArrayLike = 0.0,
    qdd: npt.ArrayLike = 0.0,
    f: npt.ArrayLike = 0.0,
    w: npt.ArrayLike = 0.0,
    dw: npt.ArrayLike = 0.0,
    payload: ref.Payload | None = None,
) -> Bounds:
    """Bounds for a motion on a moving base: the arguments of inverse dynamics (gravity may stand for ``f``)."""
    mass, com, inertia = payload or NOTHING
    matrix = np.abs(spec.coupling.matrix) if spec.coupling else np.eye(len(spec.moving_links))
    n = matrix.shape[1]
    turn = length(w) + (matrix @ np.broadcast_to(np.abs(qd), n)).sum()
    angular = length(dw) + (matrix @ np.broadcast_to(np.abs(qdd), n)).sum() + turn**2
    lever = max(1.0, reach(spec, q) + length(com))
    return Bounds(
        mass=mass + sum(link.mass for link in spec.links),
        lever=lever,
        inertia=trace(inertia) + sum(trace(link.inertia) for link in spec.links),
        gain=max(1.0, float(matrix.sum(axis=0).max())),
        acceleration=float(length(f) + 2 * angular * lever),
        angular=float(angular),
    )


def reach(spec: RobotSpec, q: npt.ArrayLike) -> float:
    """Longest path from the base origin, along the link origins, to a centre of mass or the tool."""
    origins: dict[str | None, np.ndarray] = {None: np.asarray(spec.base.translation)}
    origins.update((name, frame[:3, 3]) for name, frame in ref.link_frames(spec, q).items())
    path: dict[str | None, float] = {None: length(spec.base.translation)}
    for link in spec.links:
        path[link.name] = path[link.parent] + length(origins[link.name] - origins[link.parent])
    to_tool = path[spec.tip or spec.links[-1].name] + length(spec.tool.translation)
    return max(to_tool, *(path[link.name] + length(link.com) for link in spec.links))


def length(vector: npt.ArrayLike) -> float:
    """Euclidean length."""
    return math.hypot(*np.ravel(vector))


def trace(inertia: tuple[float, ...]) -> float:
    """Trace of an inertia given as xx xy xz yy yz zz."""
    xx, _, _, yy, _, zz = inertia
    return xx + yy + zz


def assert_close(actual: npt.ArrayLike, expected: npt.ArrayLike, bound: float, tolerance: float = TOLERANCE) -> None:
    """Equal shapes, and no entry farther off than ``tolerance`` of the bound."""
    assert np.shape(actual) == np.shape(expected)
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=tolerance * bound)
