"""The pose of a frame, and its Jacobian."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import Expr, Triple, added, cross, engine, scaled, transposed, units
from ravengc.symbolic.recursions import Joints

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.symbolic.mechanism import Body, Mechanism
    from ravengc.symbolic.steps import Steps

__all__ = ["jacobian", "pose"]


def _poses(mechanism: Mechanism, joints: Joints, steps: Steps) -> list[tuple[list[Triple], Triple]]:
    """Axes (columns) and origin of every frame J, in B."""
    placed: list[tuple[list[Triple], Triple]] = []
    for index in range(len(mechanism.bodies)):
        columns, p = [joints.inward(index, unit) for unit in units()], joints.origin(index)
        outer = mechanism.bodies[index].parent
        if outer is not None:
            axes, origin = placed[outer]
            columns = [steps.names(_combined(axes, column)) for column in columns]
            p = steps.names(added(origin, _combined(axes, p)))
        placed.append((columns, p))
    return placed


def _combined(columns: Sequence[Triple], v: Triple) -> Triple:
    """A matrix, given by its columns, times a vector."""
    return added(added(scaled(columns[0], v[0]), scaled(columns[1], v[1])), scaled(columns[2], v[2]))


def pose(mechanism: Mechanism, frame: str, steps: Steps) -> list[list[Expr]]:
    """The pose (4x4) of a frame in B."""
    index, inner = mechanism.frames[frame]
    zero, one = engine().Integer(0), engine().Integer(1)
    if index is None:
        columns, p = list(transposed(inner.rotation)), inner.translation
    else:
        axes, origin = _poses(mechanism, Joints(mechanism, steps), steps)[index]
        columns = [steps.names(_combined(axes, column)) for column in transposed(inner.rotation)]
        p = steps.names(added(origin, _combined(axes, inner.translation)))
    rows = zip(*columns, p, strict=True)
    return [*(list(row) for row in rows), [zero, zero, zero, one]]


def jacobian(mechanism: Mechanism, frame: str, steps: Steps) -> list[list[Expr]]:
    """The Jacobian (6 rows) of a frame's origin in base axes: z x (p - o) and z, or z and 0 where the joint slides."""
    index, inner = mechanism.frames[frame]
    zero = engine().Integer(0)
    columns = [[zero] * 6 for _ in mechanism.bodies]
    if index is not None:
        placed = _poses(mechanism, Joints(mechanism, steps), steps)
        tip = steps.names(added(placed[index][1], _combined(placed[index][0], inner.translation)))
        joint: int | None = index
        while joint is not None:
            columns[joint] = _column(mechanism.bodies[joint], placed[joint], tip, steps)
            joint = mechanism.bodies[joint].parent
    return [mechanism.on_coordinates(row) for row in zip(*columns, strict=True)]


def _column(body: Body, placed: tuple[list[Triple], Triple], tip: Triple, steps: Steps) -> list[Expr]:
    (_, _, z), origin = placed
    if not body.turns:
        return [*z, *[engine().Integer(0)] * 3]
    return [*steps.names(cross(z, steps.names(added(tip, scaled(origin, -1))))), *z]
