"""Regressors: the rows Y of tau = Y pi, for parameters pi in which torques are linear.

What moves a link per unit of each of its parameters, in the link's own frame, seen along the axes of the joints that
carry it: tau = w . N + v . F for an axis that turns the link with w and moves its origin with v.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import Expr, Matrix, Triple, added, cross, dot, engine, scaled, transposed, turned, units
from ravengc.symbolic.recursions import BaseMotion, Joints, motions_of, of_point

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.symbolic.mechanism import Body, Frame, Mechanism
    from ravengc.symbolic.steps import Steps

__all__ = ["dynamics_regressor", "gravity_regressor"]

Pair = tuple[Triple, Triple]
"""A joint's axis as the rates w and v that it gives a link, or a wrench as force and moment."""


def gravity_regressor(mechanism: Mechanism, g: Triple, steps: Steps) -> list[list[Expr]]:
    """Rows Y with tau = Y pi, pi = m, hx, hy, hz of every moving link in its own frame."""
    rest = BaseMotion(scaled(g, -1), scaled(g, 0), scaled(g, 0))
    still = [engine().Integer(0)] * len(mechanism.bodies)
    return _regressor(mechanism, rest, still, still, 4, steps)


def dynamics_regressor(
    mechanism: Mechanism, base: BaseMotion, rates: Sequence[Expr], accelerations: Sequence[Expr], steps: Steps
) -> list[list[Expr]]:
    """Rows Y with tau = Y pi, pi = m, hx, hy, hz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz about the origin of the link's frame."""
    return _regressor(mechanism, base, rates, accelerations, 10, steps)


def _regressor(
    mechanism: Mechanism,
    base: BaseMotion,
    rates: Sequence[Expr],
    accelerations: Sequence[Expr],
    kinds: int,
    steps: Steps,
) -> list[list[Expr]]:
    """For every link, what moves it per unit of each parameter, seen along the axes of the joints that carry it."""
    joints = Joints(mechanism, steps)
    motions = motions_of(mechanism, joints, base, rates, accelerations, steps)
    axes: list[dict[int, Pair]] = []
    columns: list[list[Expr]] = []
    zero = engine().Integer(0)
    for index, body in enumerate(mechanism.bodies):
        axes.append(_axes(index, body, {} if body.parent is None else axes[body.parent], joints, steps))
        own = _motion_in(body.link, motions[index], steps)
        seen = {joint: _axis_in(body.link, axis, steps) for joint, axis in axes[index].items()}
        for force, moment in _unit_wrenches(own, steps)[:kinds]:
            powers = {joint: steps.name(dot(w, moment) + dot(v, force)) for joint, (w, v) in seen.items()}
            columns.append(mechanism.on_coordinates([powers.get(k, zero) for k in range(len(mechanism.bodies))]))
    return [list(row) for row in zip(*columns, strict=True)]


def _axes(index: int, body: Body, outer: dict[int, Pair], joints: Joints, steps: Steps) -> dict[int, Pair]:
    """The joints that carry a link, by what they do to the origin of J per unit of rate, in axes J."""
    p, z, still = joints.origin(index), units()[2], scaled(units()[2], 0)
    seen = {}
    for joint, (w, v) in outer.items():
        seen[joint] = joints.outward(index, w), joints.outward(index, steps.names(added(v, cross(w, p))))
    return {**seen, index: (z, still) if body.turns else (still, z)}


def _motion_in(link: Frame, motion: BaseMotion, steps: Steps) -> BaseMotion:
    """Motion of the link's own frame, from that of J."""
    back, f = transposed(link.rotation), of_point(motion, link.translation, steps)
    return BaseMotion(*(steps.names(turned(back, v)) for v in (f, motion.w, motion.dw)))


def _axis_in(link: Frame, axis: Pair, steps: Steps) -> Pair:
    """An axis at the origin of the link's own frame, from that at the origin of J."""
    (w, v), back = axis, transposed(link.rotation)
    moved = steps.names(added(v, cross(w, link.translation)))
    return steps.names(turned(back, w)), steps.names(turned(back, moved))


def _unit_wrenches(motion: BaseMotion, steps: Steps) -> list[Pair]:
    """Force and moment about the link's origin per unit of m, hx, hy, hz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz."""
    still = scaled(motion.f, 0)
    wrenches = [(motion.f, still)]
    for h in units():
        whirl = cross(motion.w, steps.names(cross(motion.w, h)))
        wrenches.append((steps.names(added(cross(motion.dw, h), whirl)), cross(h, motion.f)))
    for inertia in _unit_inertias():
        spin = cross(motion.w, turned(inertia, motion.w))
        wrenches.append((still, steps.names(added(turned(inertia, motion.dw), spin))))
    return wrenches


def _unit_inertias() -> list[Matrix]:
    """Symmetric matrices with one entry, xx xy xz yy yz zz, and its mirror image."""
    found: list[Matrix] = []
    for a, b in combinations_with_replacement(range(3), 2):
        rows = [scaled(unit, 0) for unit in units()]
        rows[a] = units()[b]
        rows[b] = units()[a]
        found.append((rows[0], rows[1], rows[2]))
    return found
