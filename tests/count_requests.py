"""Counts what reaches the C library's allocator during cycles. Run with benches/comparison/count_malloc.c preloaded.

``python count_requests.py CYCLES OTHER_CYCLES`` prints, as JSON, the requests of the process by name: of as many cycles
of the gravity torque, bound and with ``out=``, and of every other function, and those of as much work without a cycle.
"""

from __future__ import annotations

import ctypes
import gc
import json
import sys
from itertools import repeat
from typing import TYPE_CHECKING

import numpy as np

import ravengc as rg
from core_calls import BINDINGS, CALLS
from ravengc.control import LAWS, Controller, Drive

if TYPE_CHECKING:
    from collections.abc import Callable

    from core_calls import Call

REQUESTS = ctypes.CDLL(None).count_malloc_requests
REQUESTS.restype = ctypes.c_ulong


def during(cycle: Callable[[], object], cycles: int) -> int:
    """Requests while ``cycle`` is called so often."""
    before = REQUESTS()
    for _ in repeat(None, cycles):
        cycle()
    return REQUESTS() - before


def call_into(robot: rg.Robot, call: Call, cycles: int) -> int:
    """Requests of so many calls with ``out=``, arguments by position: a call by name makes a dictionary."""
    function, arguments, out = getattr(robot, call.name), call.arguments(), np.zeros(call.shape)
    options = {"frame": None} if call.name == "forward_kinematics" else {}
    options |= {"frame": "tool", "axes": "base"} if call.name == "jacobian" else {}
    positional = (*arguments.values(), *options.values(), out)
    before = REQUESTS()
    for _ in repeat(None, cycles):
        function(*positional)
    return REQUESTS() - before


def gravity_into(robot: rg.Robot, cycles: int) -> int:
    """Requests of so many calls of the gravity torque as a control loop writes them."""
    q, g, out = np.zeros(robot.n), np.array([0.0, 0.0, -9.81]), np.zeros(robot.n)
    before = REQUESTS()
    for _ in repeat(None, cycles):
        robot.gravity_torque(q, g, out)
    return REQUESTS() - before


def live(robot: rg.Robot, cycles: int) -> int:
    """Requests of so many cycles that step their sensor too, each after a sample was handed in."""
    q, chain, force, out = np.zeros(robot.n), rg.Accelerometer(), np.array((0.0, 0.0, 9.81)), np.zeros(robot.n)
    cycle, push = robot.bind(q=q, gravity=chain, out=out), chain.push
    before = REQUESTS()
    for _ in repeat(None, cycles):
        push(1, 1, force)
        cycle()
    return REQUESTS() - before


def predicted(cycles: int) -> int:
    """Requests of so many predictions, bound and with ``out=``, and of the samples that they are made from."""
    predictor, place, out, velocity = rg.Predictor(1000.0, horizon_s=0.01), np.ones(3), np.zeros(3), np.zeros(3)
    step, update, predict, t = predictor.bind(out=out, velocity=velocity), predictor.update, predictor.predict, 0.0
    before = REQUESTS()
    for _ in repeat(None, cycles):
        t += 0.001
        update(t, place)
        step(t)
        predict(t, out)
    return REQUESTS() - before


def elastic(robot: rg.Robot, cycles: int) -> dict[str, int]:
    """Requests of so many cycles of gravity compensation for elastic joints, bound and with ``out=``."""
    found = {}
    for variant in ("desired", "motor", "biased", "quasi_static", "link"):
        law = rg.ElasticGravity(robot, np.full(robot.n, 1e3), variant, kp=np.full(robot.n, 1e3))
        theta, goal, g, out, beyond = (np.full(size, 0.1) for size in (robot.n, robot.n, 3, robot.n, robot.n))
        cycle = law.bind(theta=theta, q_desired=goal, gravity=g, out=out, q=goal, theta_desired=beyond)
        found[f"{variant}, bound"] = during(cycle, cycles)
        before = REQUESTS()
        for _ in repeat(None, cycles):
            law.torque(theta, goal, g, goal, out)
        found[f"{variant}, out="] = REQUESTS() - before
    return found


def controlled(law: str, cycles: int) -> int:
    """Requests of so many updates of a control law with every limit, through its transmission, with a live sensor."""
    robot, force = rg.load("raven2_gold"), np.array((0.0, 0.0, 9.81))
    gains, chain = Drive(np.ones(3), np.ones(3), np.ones(3), "a count"), rg.Accelerometer()
    limits = {"tau_max": 5.0, "tau_rate_max": 100.0, "limits": "robot", "jump": 1.0, "wrap": 6.3, "ramp_s": 0.1}
    controller = Controller(robot, law, gains, accelerometer=chain, feedback="motor", differentiate=True, **limits)
    update, push = controller.update, chain.push
    before = REQUESTS()
    for _ in repeat(None, cycles):
        push(1, 1, force)
        update()
    return REQUESTS() - before


def count(cycles: int, others: int) -> dict[str, int]:
    """Requests by name."""
    robot = rg.load("panda")
    found = {"nothing": during(lambda: None, cycles), "out=": gravity_into(robot, cycles), "live": live(robot, cycles)}
    found["predicted"] = predicted(others)
    for binding in BINDINGS:
        step = binding.bind(robot, binding.arrays())
        found[binding.name] = during(step, cycles if binding.name == "bind" else others)
    for law in LAWS:
        found[law] = controlled(law, cycles if law == "pd+dg" else others)
    for call in CALLS:
        found[call.name] = call_into(robot, call, others)
    return found | elastic(robot, others)


def main() -> None:
    gc.disable()
    count(100, 100)
    print(json.dumps(count(int(sys.argv[1]), int(sys.argv[2]))))  # noqa: T201 -- its result


if __name__ == "__main__":
    main()
