"""The recursions of mechanics over a mechanism, in the links' frames J, each result named.

Outward: how each link moves. Inward: what it takes to move it. S is the joint's axis z, R and p the pose of J in the
frame that carries it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

from ravengc.symbolic.algebra import (
    Expr,
    Triple,
    added,
    cosine,
    cross,
    engine,
    exact,
    scaled,
    transposed,
    turned,
    units,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.symbolic.mechanism import Body, Mechanism
    from ravengc.symbolic.parameters import Inertial
    from ravengc.symbolic.steps import Steps

__all__ = [
    "BaseMotion",
    "Joints",
    "gravity_torques",
    "inverse_dynamics",
    "motions_of",
    "of_point",
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


def motions_of(
    mechanism: Mechanism,
    joints: Joints,
    base: BaseMotion,
    rates: Sequence[Expr],
    accelerations: Sequence[Expr],
    steps: Steps,
) -> list[BaseMotion]:
    """Motion of every frame J: w and dw turn, and f of its origin is that of a point of the body that carries it."""
    motions: list[BaseMotion] = []
    z = units()[2]
    for index, body in enumerate(mechanism.bodies):
        outer = base if body.parent is None else motions[body.parent]
        f = joints.outward(index, of_point(outer, joints.origin(index), steps))
        w, dw = joints.outward(index, outer.w), joints.outward(index, outer.dw)
        along, more = scaled(z, rates[index]), scaled(z, accelerations[index])
        coriolis = cross(w, along)
        if body.turns:
            motions.append(BaseMotion(f, steps.names(added(w, along)), steps.names(added(added(dw, more), coriolis))))
        else:
            motions.append(BaseMotion(steps.names(added(added(f, more), scaled(coriolis, 2))), w, dw))
    return motions


def of_point(motion: BaseMotion, p: Triple, steps: Steps) -> Triple:
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
    motions = motions_of(mechanism, joints, base, rates, accelerations, steps)
    wrenches = [_wrench(body, motion, steps) for body, motion in zip(bodies, motions, strict=True)]
    torques = [engine().Integer(0)] * len(bodies)
    for index in reversed(range(len(bodies))):
        body, (force, moment) = mechanism.bodies[index], wrenches[index]
        torques[index] = (moment if body.turns else force)[2]
        if body.parent is not None:
            outer_force, outer_moment = wrenches[body.parent]
            force = joints.inward(index, force)
            about = added(joints.inward(index, moment), cross(joints.origin(index), force))
            wrenches[body.parent] = steps.names(added(outer_force, force)), steps.names(added(outer_moment, about))
    return mechanism.on_coordinates(torques)


def _wrench(body: Inertial, motion: BaseMotion, steps: Steps) -> tuple[Triple, Triple]:
    """What moves a link, about the origin of J: F = m f + dw x h + w x (w x h), N = I dw + w x I w + h x f."""
    whirl = cross(motion.w, steps.names(cross(motion.w, body.moment)))
    force = added(scaled(motion.f, body.mass), added(cross(motion.dw, body.moment), whirl))
    spin = cross(motion.w, steps.names(turned(body.inertia, motion.w)))
    moment = added(added(turned(body.inertia, motion.dw), spin), cross(body.moment, motion.f))
    return steps.names(force), steps.names(moment)
