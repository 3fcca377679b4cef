"""The recursions of mechanics over a mechanism, in the links' frames J, each result named.

Outward: how each link moves. Inward: what it takes to move it. S is the joint's axis z, R and p the pose of J in the
frame that carries it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product as pairs
from math import cos, sin
from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import Expr, Triple, added, cosine, cross, dot, engine, exact, scaled, transposed, turned
from ravengc.symbolic.mechanism import numbers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.symbolic.mechanism import Body, Frame, Mechanism
    from ravengc.symbolic.parameters import Inertial
    from ravengc.symbolic.steps import Steps

__all__ = [
    "BaseMotion",
    "dynamics_regressor",
    "gravity_regressor",
    "gravity_torques",
    "inverse_dynamics",
    "jacobian",
    "pose",
]


@dataclass(frozen=True, slots=True)
class BaseMotion:
    """Motion of a body's origin in its own axes: specific force f = a - g, angular velocity w and acceleration dw."""

    f: Triple
    w: Triple
    dw: Triple


class Joints:
    """The poses of the frames J in those that carry them, at coordinates that are symbols."""

    def __init__(self, mechanism: Mechanism, steps: Steps) -> None:
        self.bodies = mechanism.bodies
        self._name = steps.names
        self._cosine: list[Expr] = []
        self._sine: list[Expr] = []
        for body in self.bodies:
            c, s = _direction(body)
            self._cosine.append(steps.name(c))
            self._sine.append(steps.name(s))

    def inward(self, index: int, v: Triple) -> Triple:
        """A vector of J in the axes of what carries it: R v."""
        x, y, z = v
        c, s = self._cosine[index], self._sine[index]
        return self._name(turned(self.bodies[index].joint.rotation, self._name((c * x - s * y, s * x + c * y, z))))

    def outward(self, index: int, v: Triple) -> Triple:
        """A vector of what carries J in the axes of J: Rᵀ v."""
        x, y, z = self._name(turned(transposed(self.bodies[index].joint.rotation), v))
        c, s = self._cosine[index], self._sine[index]
        return self._name((c * x + s * y, c * y - s * x, z))

    def origin(self, index: int) -> Triple:
        """The origin of J in the frame that carries it: p."""
        body = self.bodies[index]
        if body.turns:
            return body.joint.translation
        axis = transposed(body.joint.rotation)[2]
        return self._name(added(body.joint.translation, scaled(axis, body.motion)))


def _direction(body: Body) -> tuple[Expr, Expr]:
    """Cosine and sine of the joint's angle; numbers where no coordinate moves it."""
    sp = engine()
    if not body.turns:
        return sp.Integer(1), sp.Integer(0)
    if body.motion.free_symbols:
        return sp.cos(body.motion), sp.sin(body.motion)
    turn = float(body.motion)
    return exact(cosine(cos(turn))), exact(cosine(sin(turn)))


def gravity_torques(mechanism: Mechanism, bodies: Sequence[Inertial], g: Triple, steps: Steps) -> list[Expr]:
    """Torques that hold the joints against the gravity field g: gravity outward, mass and first moment inward."""
    joints = Joints(mechanism, steps)
    fields: list[Triple] = []
    for index, body in enumerate(mechanism.bodies):
        fields.append(joints.outward(index, g if body.parent is None else fields[body.parent]))
    masses, moments = [body.mass for body in bodies], [body.moment for body in bodies]
    torques = [engine().Integer(0)] * len(bodies)
    for index in reversed(range(len(bodies))):
        body, h, field = mechanism.bodies[index], moments[index], fields[index]
        torques[index] = steps.name(h[1] * field[0] - h[0] * field[1] if body.turns else -masses[index] * field[2])
        if body.parent is not None:
            arm = scaled(joints.origin(index), masses[index])
            carried = added(joints.inward(index, h), arm)
            masses[body.parent] = steps.name(masses[body.parent] + masses[index])
            moments[body.parent] = steps.names(added(moments[body.parent], carried))
    return mechanism.on_coordinates(torques)


def _motions(
    mechanism: Mechanism,
    joints: Joints,
    base: BaseMotion,
    rates: Sequence[Expr],
    accelerations: Sequence[Expr],
    steps: Steps,
) -> list[BaseMotion]:
    """Motion of every frame J: w and dw turn, and f of its origin is that of a point of the body that carries it."""
    motions: list[BaseMotion] = []
    z = (engine().Integer(0), engine().Integer(0), engine().Integer(1))
    for index, body in enumerate(mechanism.bodies):
        outer = base if body.parent is None else motions[body.parent]
        f = joints.outward(index, _at(outer, joints.origin(index), steps))
        w, dw = joints.outward(index, outer.w), joints.outward(index, outer.dw)
        along, more = scaled(z, rates[index]), scaled(z, accelerations[index])
        coriolis = cross(w, along)
        if body.turns:
            motions.append(BaseMotion(f, steps.names(added(w, along)), steps.names(added(added(dw, more), coriolis))))
        else:
            motions.append(BaseMotion(steps.names(added(added(f, more), scaled(coriolis, 2))), w, dw))
    return motions


def _at(motion: BaseMotion, p: Triple, steps: Steps) -> Triple:
    """Specific force of another point of a body: f + dw x p + w x (w x p)."""
    whirl = cross(motion.w, steps.names(cross(motion.w, p)))
    return steps.names(added(motion.f, added(cross(motion.dw, p), whirl)))


def inverse_dynamics(
    mechanism: Mechanism,
    bodies: Sequence[Inertial],
    base: BaseMotion,
    rates: Sequence[Expr],
    accelerations: Sequence[Expr],
    steps: Steps,
) -> list[Expr]:
    """Torques for a motion of the joints on a moving base: Newton and Euler, recursively."""
    joints = Joints(mechanism, steps)
    motions = _motions(mechanism, joints, base, rates, accelerations, steps)
    wrenches = [_wrench(body, motion, steps) for body, motion in zip(bodies, motions, strict=True)]
    torques = [engine().Integer(0)] * len(bodies)
    for index in reversed(range(len(bodies))):
        body, (force, moment) = mechanism.bodies[index], wrenches[index]
        torques[index] = (moment if body.turns else force)[2]
        if body.parent is not None:
            outer_force, outer_moment = wrenches[body.parent]
            force = joints.inward(index, force)
            about = added(joints.inward(index, moment), cross(joints.origin(index), force))
            total = steps.names(added(outer_force, force)), steps.names(added(outer_moment, about))
            wrenches[body.parent] = total
    return mechanism.on_coordinates(torques)


def _wrench(body: Inertial, motion: BaseMotion, steps: Steps) -> tuple[Triple, Triple]:
    """What moves a link, about the origin of J: F = m f + dw x h + w x (w x h), N = I dw + w x I w + h x f."""
    whirl = cross(motion.w, steps.names(cross(motion.w, body.moment)))
    force = added(scaled(motion.f, body.mass), added(cross(motion.dw, body.moment), whirl))
    spin = cross(motion.w, steps.names(turned(body.inertia, motion.w)))
    moment = added(added(turned(body.inertia, motion.dw), spin), cross(body.moment, motion.f))
    return steps.names(force), steps.names(moment)


def gravity_regressor(mechanism: Mechanism, g: Triple, steps: Steps) -> list[list[Expr]]:
    """Rows Y with tau = Y pi, pi = m, hx, hy, hz of every moving link in its own frame."""
    zero = engine().Integer(0)
    rest = BaseMotion(scaled(g, -1), (zero,) * 3, (zero,) * 3)
    still = [zero] * len(mechanism.bodies)
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
    motions = _motions(mechanism, joints, base, rates, accelerations, steps)
    axes: list[dict[int, tuple[Triple, Triple]]] = []
    columns: list[list[Expr]] = []
    zero = engine().Integer(0)
    for index, body in enumerate(mechanism.bodies):
        axes.append(_axes(index, body, {} if body.parent is None else axes[body.parent], joints, steps))
        own = _in_link_frame(motions[index], body.link, steps)
        seen = {joint: _screw_in_link_frame(screw, body.link, steps) for joint, screw in axes[index].items()}
        for unit in _unit_wrenches(own, steps)[:kinds]:
            power = [_power(seen[joint], unit) if joint in seen else zero for joint in range(len(mechanism.bodies))]
            columns.append(mechanism.on_coordinates([steps.name(entry) for entry in power]))
    return [list(row) for row in zip(*columns, strict=True)]


def _axes(
    index: int, body: Body, outer: dict[int, tuple[Triple, Triple]], joints: Joints, steps: Steps
) -> dict[int, tuple[Triple, Triple]]:
    """The joints that carry a link as twists of the origin of J per unit of rate: turning, then moving, in axes J."""
    zero, one = engine().Integer(0), engine().Integer(1)
    p = joints.origin(index)
    seen = {}
    for joint, (turning, going) in outer.items():
        moved = steps.names(added(going, cross(turning, p)))
        seen[joint] = joints.outward(index, turning), joints.outward(index, moved)
    still, along = (zero, zero, zero), (zero, zero, one)
    return {**seen, index: (along, still) if body.turns else (still, along)}


def _in_link_frame(motion: BaseMotion, link: Frame, steps: Steps) -> BaseMotion:
    back = transposed(link.rotation)
    f = _at(motion, link.translation, steps)
    return BaseMotion(*(steps.names(turned(back, v)) for v in (f, motion.w, motion.dw)))


def _screw_in_link_frame(screw: tuple[Triple, Triple], link: Frame, steps: Steps) -> tuple[Triple, Triple]:
    turning, going = screw
    back = transposed(link.rotation)
    moved = steps.names(added(going, cross(turning, link.translation)))
    return steps.names(turned(back, turning)), steps.names(turned(back, moved))


def _unit_wrenches(motion: BaseMotion, steps: Steps) -> list[tuple[Triple, Triple]]:
    """Force and moment about the link's origin per unit of m, hx, hy, hz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz."""
    zero, one = engine().Integer(0), engine().Integer(1)
    still, units = (zero, zero, zero), numbers([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    wrenches = [(motion.f, still)]
    for h in units:
        whirl = cross(motion.w, steps.names(cross(motion.w, h)))
        wrenches.append((steps.names(added(cross(motion.dw, h), whirl)), cross(h, motion.f)))
    for a, b in pairs(range(3), range(3)):
        if a <= b:
            inertia = tuple(
                tuple(one if {i, j} == {a, b} and (i == j) == (a == b) else zero for j in range(3)) for i in range(3)
            )
            spin = cross(motion.w, turned(inertia, motion.w))  # type: ignore[arg-type]
            wrenches.append((still, steps.names(added(turned(inertia, motion.dw), spin))))  # type: ignore[arg-type]
    return wrenches


def _power(screw: tuple[Triple, Triple], wrench: tuple[Triple, Triple]) -> Expr:
    return dot(screw[0], wrench[1]) + dot(screw[1], wrench[0])


def _poses(mechanism: Mechanism, joints: Joints, steps: Steps) -> list[tuple[list[Triple], Triple]]:
    """Axes (columns) and origin of every frame J, in B."""
    units = numbers([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    placed: list[tuple[list[Triple], Triple]] = []
    for index in range(len(mechanism.bodies)):
        columns, p = [joints.inward(index, unit) for unit in units], joints.origin(index)
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
