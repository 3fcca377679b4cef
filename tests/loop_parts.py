"""Parts of a control loop that tests look into: a plant, a sensor, a trajectory."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

import ravengc
from ravengc.control import Controller, Drive
from ravengc.loop import ControlLoop
from ravengc.monitored import STATES
from ravengc.trajectory import JointSwing

if TYPE_CHECKING:
    from collections.abc import Callable

TILTED = np.array((3.0, -1.0, -9.0))
GAINS = Drive(np.array((100.0, 50.0)), np.array((10.0, 5.0)), np.zeros(2), "a test")


class Integrator:
    """A plant of two unit masses that remembers how long it was stepped, and does ``at_step`` every time."""

    def __init__(self, at_step: Callable[[int], None] = lambda _: None) -> None:
        self.q, self.qd = np.array((0.5, -0.5)), np.zeros(2)
        self.time = 0.0
        self.steps = 0
        self._at_step = at_step

    def step(self, tau: np.ndarray, dt: float) -> None:
        self._at_step(self.steps)
        self.steps += 1
        self.time += dt
        self.qd += dt * tau
        self.q += dt * self.qd


class Tilted:
    """A sensor that always says the same."""

    def __init__(self) -> None:
        self.gravity, self.age, self.state, self.status = TILTED.copy(), 0.0, STATES.index("live"), 0

    def update(self, time: float) -> None:
        self.age = time % 0.01


def still() -> JointSwing:
    return JointSwing(np.zeros(2), np.zeros(2), np.ones(2))


def loop_on(plant: Integrator, law: str = "pd", **options: object) -> ControlLoop:
    controller = Controller(ravengc.load("rrbot"), law, GAINS)
    return ControlLoop(plant, controller, Tilted(), still(), **{"duration_s": 0.1, "paced": False, **options})
