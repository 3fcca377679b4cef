"""Certificates against time: random bases, arms and sensors, each certified and then simulated, and what disagrees.

Two kinds of cases: one link on a base of one degree, with every number of the model drawn; and bundled robots in random
poses on bases with random directions, turning ones among them. A case is near-marginal if its rightmost pole s has
abs(Re s) < 0.002 abs(s), or its high-frequency gain, where nothing filters it, is within 5 % of 1: its growth over the
simulated time would be too small to see. Those are counted apart, but none that is certified may grow either.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

import ravengc
from ravengc._convert import as_count
from ravengc.control import derived_drive
from ravengc.errors import ArgumentError
from ravengc.messages import kind_of
from ravengc.stability.counting import poles_right_of
from ravengc.stability.loop_margins import loci
from ravengc.stability.mount import Mount
from ravengc.stability.one_link import OneLink
from ravengc.stability.roots import poles
from ravengc.stability.sensing import Sensing
from ravengc.stability.simulation import simulate
from ravengc.stability.state_space import pade_poles
from ravengc.stability.system import linearise

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from ravengc.stability.system import System

__all__ = ["BAND", "KINDS", "Tally", "campaign"]

BAND = 0.002
"""abs(Re s) / abs(s) of the rightmost pole below which a case is near-marginal."""
KINDS = ("one link", "robots")
ROBOTS = ("raven2_gold", "rrbot", "panda", "pa10")
ROBOT_SHARE = 0.2
ENDLESS_BAND = 0.05
STEPS_PER_SWING = 24.0
"""Steps in one period of the fastest swing, of the arm or of the loop."""
SWINGS = 40.0
"""Periods of the slowest swing that are simulated, in so many steps at least and at most:"""
STEPS = (8_000, 60_000)
GRID = 150
CANDIDATES = 5
"""Frequencies at which the loop's gain is looked at, and poles among which the rightmost is."""
AUDIBLE = 0.4
"""A loop gain that can become an instability."""
BATCH = 10_000
LARGEST_GROUP = 500
MOST_CASES = 1_000_000


@dataclass(frozen=True, slots=True)
class Tally:
    """Numbers of cases of one kind. ``uncertain``: without a proof either way, counted with no side."""

    kind: str
    cases: int = 0
    certified: int = 0
    certified_grew: int = 0
    unstable: int = 0
    unstable_grew: int = 0
    near: int = 0
    near_certified_grew: int = 0
    near_unstable_grew: int = 0
    uncertain: int = 0

    @property
    def holds(self) -> bool:
        """Nothing certified grew."""
        return self.certified_grew == self.near_certified_grew == 0


@dataclass(frozen=True, slots=True)
class _Judged:
    kind: str
    certified: bool
    uncertain: bool
    near: bool
    grew: bool


def campaign(
    cases: int = 10_000, seed: int = 0, *, on_progress: Callable[[int, int], None] | None = None
) -> tuple[Tally, ...]:
    """Draw, certify and simulate ``cases`` systems, a fifth of them robots; the same seed draws the same ones.

    ``on_progress`` is called with how many are done, and of how many. Returns a :class:`Tally` of each kind.
    """
    if on_progress is not None and not callable(on_progress):
        raise ArgumentError(f"on_progress is {kind_of(on_progress)}; expected a function")
    cases = as_count(cases, "cases", 1, MOST_CASES)
    random = np.random.default_rng(as_count(seed, "seed", 0))
    judged: list[_Judged] = []
    for group in _groups(random, cases):
        judged += _judge(group)
        if on_progress is not None:
            on_progress(len(judged), cases)
    return tuple(_tally(kind, [one for one in judged if one.kind == kind]) for kind in KINDS)


def one_link(random: np.random.Generator) -> System:
    """Draw one link on a base: a tenth of its mass to ten times it, slower and faster than its joint."""

    def between(low: float, high: float) -> float:
        return float(np.exp(random.uniform(math.log(low), math.log(high))))

    mass, length = between(0.3, 10.0), between(0.1, 1.0)
    inertia = mass * length**2 * between(1.05, 3.0)
    joint = 2.0 * math.pi * between(1.0, 8.0)
    return OneLink(
        base_mass=mass * between(0.3, 10.0),
        base_frequency_hz=between(0.5, 8.0),
        base_damping_ratio=between(0.002, 0.05),
        mass=mass,
        length=length,
        inertia=inertia,
        kp=inertia * joint**2,
        kd=2.0 * between(0.1, 1.0) * inertia * joint,
        sensing=_sensing(random),
    ).system()


def robot(random: np.random.Generator) -> System:
    """Draw a bundled robot in a pose on a mount of one to three random directions."""
    name = str(random.choice(ROBOTS))
    arm = _arm(name)
    lower, upper = np.transpose([(limit.lower or -1.0, limit.upper or 1.0) for limit in arm.spec.coordinate_limits])
    q = random.uniform(lower, upper)
    m = int(random.integers(1, 4))
    twists = random.standard_normal((m, 6)) * np.where(random.random((m, 1)) < 0.3, 1.0, np.repeat((1.0, 0.0), 3))
    mount = Mount(
        directions=twists / np.linalg.norm(twists, axis=1, keepdims=True),
        mass=np.exp(random.uniform(math.log(1.0), math.log(30.0))),
        frequency_hz=random.uniform(0.8, 5.0, m),
        damping_ratio=np.exp(random.uniform(math.log(0.003), math.log(0.05), m)),
    )
    drive = derived_drive(arm, q, natural_frequency_hz=random.uniform(2.0, 6.0), damping_ratio=random.uniform(0.3, 1.0))
    law = str(random.choice(("pd+dg", "pd+bm")))
    return linearise(arm, q, drive, mount, _sensing(random), law=law, sensor=random.uniform(-0.3, 0.3, 3))


@cache
def _arm(name: str) -> ravengc.Robot:
    return ravengc.load(name)


def _sensing(random: np.random.Generator) -> Sensing:
    cutoff: float | None = random.uniform(5.0, 80.0)
    cutoff, order = ((None, 2), (cutoff, 1), (cutoff, 2))[int(random.integers(3))]
    return Sensing(
        rate_hz=float(random.choice((50.0, 100.0, 200.0, 500.0))),
        latency_s=random.uniform(0.0, 0.05),
        cutoff_hz=cutoff,
        order=order,
        gain=float(random.choice((1.0, 1.0, 0.7))),
    )


@dataclass(frozen=True, slots=True)
class _Case:
    """A system, and the step and the number of steps that show whether it grows."""

    kind: str
    system: System
    step_s: float
    steps: int


def _groups(random: np.random.Generator, cases: int) -> Iterator[list[_Case]]:
    """Draw the cases, and give them out in groups of the same sizes and similar lengths, simulated together."""
    for start in range(0, cases, BATCH):
        same: dict[Any, list[_Case]] = defaultdict(list)
        for _ in range(min(BATCH, cases - start)):
            kind = KINDS[int(random.random() < ROBOT_SHARE)]
            case = _case(kind, one_link(random) if kind == KINDS[0] else robot(random))
            sensing = case.system.sensing
            same[case.system.inputs.shape, 0 if sensing.cutoff_hz is None else sensing.order].append(case)
        for group in same.values():
            group.sort(key=lambda case: case.steps)
            yield from (group[i : i + LARGEST_GROUP] for i in range(0, len(group), LARGEST_GROUP))


def _case(kind: str, system: System) -> _Case:
    """Step: a part of the period of the fastest thing that happens, and of the lag; time: many of the slowest."""
    modes = np.sqrt(np.abs(np.linalg.eigvals(system.normal.stiffness)))
    w = np.geomspace(float(modes.min()), 20.0 / system.sensing.delay_s + 4.0 * float(modes.max()), GRID)
    beyond = system.high_frequency_gain
    threshold = AUDIBLE if beyond > 1.0 else max(AUDIBLE, 1.05 * beyond)
    with np.errstate(all="ignore"):
        loud = w[np.abs(loci(system, w)).max(axis=1) > threshold]
    loop = min(loud.max(initial=0.0), 12.0 / system.sensing.delay_s)
    step = 2.0 * math.pi / (STEPS_PER_SWING * max(float(modes.max()), loop))
    steps = SWINGS * 2.0 * math.pi / (float(modes.min()) * step) if beyond <= 1.0 else 0.0
    return _Case(kind, system, step, int(np.clip(steps, *STEPS)))


def _judge(group: list[_Case]) -> list[_Judged]:
    growths = simulate([case.system for case in group], [case.step_s for case in group], group[-1].steps)
    return [_judged(case.kind, case.system, grew=growth.grows) for case, growth in zip(group, growths, strict=True)]


def _judged(kind: str, system: System, *, grew: bool) -> _Judged:
    count = poles_right_of(system)
    if math.isinf(count.number):
        return _Judged(kind, False, False, system.high_frequency_gain < 1.0 + ENDLESS_BAND, grew)
    likely = pade_poles(system)
    likely = likely[likely.imag >= 0.0]
    found = poles(system, likely[np.argsort(-likely.real)[:CANDIDATES]])[:1]
    near = not bool((np.abs(found.real) >= BAND * np.abs(found)).any())
    return _Judged(kind, count.none, not count.proven, near, grew)


def _tally(kind: str, judged: list[_Judged]) -> Tally:
    def number(**wanted: bool) -> int:
        return sum(all(getattr(one, name) == value for name, value in wanted.items()) for one in judged)

    clear = {"near": False, "uncertain": False}
    near = {"near": True, "uncertain": False}
    return Tally(
        kind=kind,
        cases=len(judged),
        certified=number(certified=True, **clear),
        certified_grew=number(certified=True, grew=True, **clear),
        unstable=number(certified=False, **clear),
        unstable_grew=number(certified=False, grew=True, **clear),
        near=number(**near),
        near_certified_grew=number(certified=True, grew=True, **near),
        near_unstable_grew=number(certified=False, grew=True, **near),
        uncertain=number(uncertain=True),
    )
