"""One control cycle after another: pictures in, where the surface is, the tool's velocity, the joints' velocities."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.coordinates import sliding
from ravengc.resolved_rate import ResolvedRate
from ravengc.track.approach import Approach, Triple
from ravengc.track.belief import belief
from ravengc.track.hindsight import Hindsight
from ravengc.track.motions import sampled
from ravengc.track.recording import Recorder

if TYPE_CHECKING:
    from ravengc.robot import Robot
    from ravengc.track.camera import Camera
    from ravengc.track.motions import Motion
    from ravengc.track.settings import TrackSettings

__all__ = ["Aim", "Follower", "Miss"]

Array = NDArray[np.float64]

BLOCK = 1024
"""Cycles for which the true motion is computed at once."""
TIMED_EVERY = 16


class Aim(NamedTuple):
    """A point of the surface at rest with its outward normal; how far above it the tool shall be, and how fast rise."""

    point: Triple
    normal: Triple
    above: float = 0.0
    rising: float = 0.0


class Miss(NamedTuple):
    """Distances of the tool from its aim (m, rad): as believed, and in truth; the direction is the same in both.

    ``place`` is the displacement of the surface with which the tool would be on its aim.
    """

    believed: float
    true: float
    turn: float
    place: Triple


class Follower:
    """An arm with ideal velocity servos that follows points of a moving surface, and all that it has met."""

    def __init__(
        self,
        robot: Robot,
        motion: Motion,
        camera: Camera,
        settings: TrackSettings,
        start: Array,
        upright: Triple | None = None,
    ) -> None:
        self.robot, self.motion, self._settings = robot, motion, settings
        self._shoulder, self._reach = reach_of(robot, start)
        self.stream = camera.stream(motion)
        self.belief = belief(settings, camera)
        self.hindsight = Hindsight(settings, camera)
        self.rate = ResolvedRate(
            robot, task="pointing", null_space="limits", null_gain=settings.null_gain, rate_hz=settings.rate_hz
        )
        self.approach = Approach(settings)
        self._upright = upright
        self._near, self._span = settings.upright_near_m, settings.upright_far_m - settings.upright_near_m
        self.dt = 1.0 / settings.rate_hz
        self.cycle = 0
        self.q, self._qd = start.copy(), np.zeros(robot.n)
        self._pose, self._twist = np.eye(4), np.zeros(6)
        self.record = Recorder(robot, settings)
        self._truth: list[Triple] = []
        self._rates: list[Triple] = []
        self.look_until(settings.lead_in_s)

    @property
    def now(self) -> float:
        """Time since the begin of the lead-in, s."""
        return self._settings.lead_in_s + self.cycle * self.dt

    def look_until(self, t: float) -> None:
        """Take the pictures that have arrived by ``t`` (s)."""
        stream = self.stream
        while stream.arrival <= t:
            picture = stream.next()
            if picture is not None:
                _, stamp, seen = picture
                self.belief.update(stamp, seen)
                self.hindsight.saw(stamp, seen)
                self.record.picture(stamp, seen)

    def follow(self, aim: Aim) -> Miss:
        """Do one cycle towards the aim, and return by how much the tool was off it when the cycle began."""
        t = self.now
        truth, rate = self._true_motion()
        begin = time.perf_counter_ns() if self.cycle % TIMED_EVERY == 0 else 0
        self.look_until(t)
        (px, py, pz), (vx, vy, vz) = self.belief.at(t, truth, rate)
        r0, r1, r2, _ = self.robot.forward_kinematics(self.q, out=self._pose).tolist()
        (ax, ay, az), (nx, ny, nz), above = aim.point, aim.normal, aim.above
        ax, ay, az = ax + above * nx - r0[3], ay + above * ny - r1[3], az + above * nz - r2[3]
        error = (ax + px, ay + py, az + pz)
        distance = _length(error)
        wanted = (-nx, -ny, -nz) if distance <= self._near else self._leaning(aim.normal, distance)
        turn, angle = _turn((r0[2], r1[2], r2[2]), wanted)
        carried = (vx + aim.rising * nx, vy + aim.rising * ny, vz + aim.rising * nz)
        if self.belief.seen:
            self._move(error, turn, carried)
        if begin:
            self.record.cost(time.perf_counter_ns() - begin)
        off = (ax + truth[0], ay + truth[1], az + truth[2])
        miss = Miss(distance, _length(off), angle, (-ax, -ay, -az))
        places = (r0[3], r1[3], r2[3], r0[2], r1[2], r2[2], *off, *truth, px, py, pz)
        self.record.cycle(t, self.q, self._qd, places, self.rate.scale, self.rate.sigma_min)
        self.cycle += 1
        return miss

    def _leaning(self, normal: Triple, distance: float) -> Triple:
        """Where the tool points on a long way: more and more against the mean normal.

        An arm that goes straight from one steep side to another may pass a singularity of its wrist, be thrown into
        another posture there and meet a joint's limit. Over the middle directions it stays in the posture it has.
        """
        x, y, z = normal
        if self._upright is not None:
            share = min(1.0, (distance - self._near) / self._span)
            a, b, c = self._upright
            x, y, z = x + share * (a - x), y + share * (b - y), z + share * (c - z)
        length = _length((x, y, z)) or 1.0
        return (-x / length, -y / length, -z / length)

    def within_reach(self, aim: Aim) -> bool:
        """Whether the aim, where it is believed to be now, is not farther off than the arm is long."""
        truth, rate = self._true_motion()
        (px, py, pz), _ = self.belief.at(self.now, truth, rate)
        (x, y, z), (a, b, c), above = aim.point, aim.normal, aim.above
        x0, y0, z0 = self._shoulder
        return _length((x + above * a + px - x0, y + above * b + py - y0, z + above * c + pz - z0)) <= self._reach

    def _move(self, error: Triple, turn: Triple, carried: Triple) -> None:
        approach, twist = self.approach, self._twist
        approach.close_in(error, turn, carried)
        (ux, uy, uz), (vx, vy, vz) = approach.u, approach.v
        twist[:] = (ux + vx, uy + vy, uz + vz, *approach.w)
        self.rate.step(self.q, twist, self.dt, out=self._qd)
        scale = self.rate.scale
        if scale < 1.0:
            approach.slowed(scale)
        self.q += self.dt * self._qd

    def _true_motion(self) -> tuple[Triple, Triple]:
        place = self.cycle % BLOCK
        if place == 0:
            cycles = np.arange(self.cycle, self.cycle + BLOCK, dtype=np.float64)
            times = self._settings.lead_in_s + cycles * self.dt
            self._truth, self._rates = (triples(rows) for rows in sampled(self.motion, times))
        return self._truth[place], self._rates[place]


def reach_of(robot: Robot, q: Array) -> tuple[Triple, float]:
    """The first point of the arm that stays (m, base axes), and how far from it the tool can be: the links' lengths.

    Infinite for coordinates that slide, and for robots whose coordinates are coupled: their links' distances change.
    """
    frames = [*_links_to(robot.tip, {link.name: link.parent for link in robot.spec.links}), "tool"]
    path = [np.array(robot.base.translation), *(robot.forward_kinematics(q, frame)[:3, 3] for frame in frames)]
    turned = robot.forward_kinematics(q + 1.0, frames[0])[:3, 3]
    places = np.array(path[1:] if np.allclose(path[1], turned) else path)
    x, y, z = places[0].tolist()
    fixed = robot.spec.coupling is None and not sliding(robot.spec).any()
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    return (x, y, z), float(lengths.sum()) if fixed else math.inf


def _links_to(tip: str, parents: dict[str, str | None]) -> list[str]:
    """The links from the base to this one."""
    names: list[str] = []
    name: str | None = tip
    while name in parents:
        names.insert(0, name)
        name = parents[name]
    return names


def triples(rows: Array) -> list[Triple]:
    """Rows (k, 3) as tuples, which a cycle takes apart much faster."""
    return [(x, y, z) for x, y, z in rows.tolist()]


def _turn(axis: Triple, wanted: Triple) -> tuple[Triple, float]:
    """The shortest rotation vector (rad) that lays ``axis`` on ``wanted``, both unit, and its angle."""
    (ax, ay, az), (bx, by, bz) = axis, wanted
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(sine, ax * bx + ay * by + az * bz)
    if sine < 1e-9:
        if angle < 1.0:
            return (0.0, 0.0, 0.0), angle
        x, y, z = _perpendicular(axis)
        sine = 1.0
    factor = angle / sine
    return (factor * x, factor * y, factor * z), angle


def _perpendicular(axis: Triple) -> Triple:
    """A unit vector across ``axis``, for a tool that points exactly the wrong way."""
    x, y, z = axis
    if abs(z) < 0.9:
        length = math.hypot(x, y)
        return (-y / length, x / length, 0.0)
    length = math.hypot(y, z)
    return (0.0, -z / length, y / length)


def _length(vector: Triple) -> float:
    x, y, z = vector
    return math.sqrt(x * x + y * y + z * z)
