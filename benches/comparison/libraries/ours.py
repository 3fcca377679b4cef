"""ravengc: bound to arrays, with ``out=``, and returning a fresh array."""

from __future__ import annotations

from time import monotonic_ns
from typing import TYPE_CHECKING, Any

import numpy as np

import ravengc as rg
from comparison.arm import KD, KP, LEVEL, TAU_MAX
from comparison.call import Call
from ravengc.control import Controller, Drive

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from comparison.arm import Arm, Array

BIND, OUT, FRESH = "bind", "out=", "fresh array"


def calls(arm: Arm) -> Iterator[Call]:
    """All operations."""
    robot = rg.Robot(arm.spec)
    yield from gravity(robot, arm)
    yield from kinematics(robot, arm)
    yield from dynamics(robot, arm)
    yield from moving_base(robot, arm)
    yield from control(robot, arm)
    yield from live(robot, arm)


def call(operation: str, way: str, run: Callable[[int], Any], fetches: int, out: Any = None, **bound: Any) -> Call:
    """A call whose result is in ``out``, or is what it returns."""
    value = np.asarray if out is None else lambda _: out.copy()
    return Call("ravengc", operation, way, run, fetches, value, **bound)


def bound(
    operation: str, cycle: Callable[[], None], out: Array, arrays: list[tuple[Array, list[Array]]]
) -> Iterator[Call]:
    """A cycle whose arrays something else fills (that is not counted), and the same with filling them from Python.

    What a cycle costs does not depend on the numbers (`benches/instructions.py`): alone it is timed with the same ones.
    """

    def fill(k: int) -> None:
        for array, samples in arrays:
            array[:] = samples[k]

    def filled(k: int) -> None:
        for array, samples in arrays:
            array[:] = samples[k]
        cycle()

    yield call(operation, BIND, filled, len(arrays), out, fill=fill, alone=cycle)
    yield call(operation, "bind, arrays filled", filled, len(arrays), out)


def gravity(robot: rg.Robot, arm: Arm) -> Iterator[Call]:
    Q, G, out, torque = arm.q, arm.g, np.empty(arm.n), robot.gravity_torque
    q, g = np.empty(arm.n), np.empty(3)
    yield from bound("gravity", robot.bind(q=q, gravity=g, out=out), out, [(q, Q), (g, G)])
    yield call("gravity", OUT, lambda k: torque(Q[k], G[k], out), 2)
    yield call("gravity", FRESH, lambda k: torque(Q[k], G[k]), 2)


def kinematics(robot: rg.Robot, arm: Arm) -> Iterator[Call]:
    Q, q, pose, matrix = arm.q, np.empty(arm.n), np.empty((4, 4)), np.empty((6, arm.n))
    fk, jacobian = robot.forward_kinematics, robot.jacobian
    yield from bound("kinematics", robot.bind_forward_kinematics(q=q, out=pose), pose, [(q, Q)])
    yield call("kinematics", OUT, lambda k: fk(Q[k], out=pose), 1)
    yield call("kinematics", FRESH, lambda k: fk(Q[k]), 1)
    yield from bound("jacobian", robot.bind_jacobian(q=q, out=matrix), matrix, [(q, Q)])
    yield call("jacobian", OUT, lambda k: jacobian(Q[k], out=matrix), 1)
    yield call("jacobian", FRESH, lambda k: jacobian(Q[k]), 1)


def dynamics(robot: rg.Robot, arm: Arm) -> Iterator[Call]:
    Q, V, A, level = arm.q, arm.qd, arm.qdd, rg.Gravity.level()
    tau, matrix, rows = np.empty(arm.n), np.empty((arm.n, arm.n)), np.empty((arm.n, 10 * arm.n))
    torque, mass, regressor = robot.inverse_dynamics, robot.mass_matrix, robot.inverse_dynamics_regressor
    yield call("inverse_dynamics", OUT, lambda k: torque(Q[k], V[k], A[k], level, tau), 3)
    yield call("inverse_dynamics", FRESH, lambda k: torque(Q[k], V[k], A[k], level), 3)
    yield call("mass_matrix", OUT, lambda k: mass(Q[k], matrix), 1)
    yield call("mass_matrix", FRESH, lambda k: mass(Q[k]), 1)
    yield call("regressor", OUT, lambda k: regressor(Q[k], V[k], A[k], level, rows), 3)
    yield call("regressor", FRESH, lambda k: regressor(Q[k], V[k], A[k], level), 3)


def moving_base(robot: rg.Robot, arm: Arm) -> Iterator[Call]:
    Q, V, A, F, W, D, out = arm.q, arm.qd, arm.qdd, arm.f, arm.w, arm.dw, np.empty(arm.n)
    names = ("q", "qd", "qdd", "specific_force", "angular_velocity", "angular_acceleration")
    arrays = {name: np.empty(len(samples[0])) for name, samples in zip(names, (Q, V, A, F, W, D), strict=True)}
    cycle = robot.bind_inverse_dynamics(**arrays, out=out)
    yield from bound("moving_base", cycle, out, list(zip(arrays.values(), (Q, V, A, F, W, D), strict=True)))

    torque, motion = robot.inverse_dynamics, rg.BaseMotion

    def built(k: int) -> rg.BaseMotion:
        return motion(specific_force=F[k], angular_velocity=W[k], angular_acceleration=D[k])

    motions = [built(k) for k in range(len(Q))]
    yield call("moving_base", OUT, lambda k: torque(Q[k], V[k], A[k], motions[k], out), 4)

    def new_motion(k: int) -> Any:
        base = motion(specific_force=F[k], angular_velocity=W[k], angular_acceleration=D[k])
        return torque(Q[k], V[k], A[k], base, out)

    yield call("moving_base", "out=, motion built in the call", new_motion, 6)
    yield call("moving_base", FRESH, lambda k: torque(Q[k], V[k], A[k], motions[k]), 4)


def control(robot: rg.Robot, arm: Arm) -> Iterator[Call]:
    """The bound step alone and with its arrays filled; and with a live sensor, which at rest feels what is level."""
    Q, V, T, G, n = arm.q, arm.qd, arm.target, arm.g, arm.n
    gains = Drive(np.full(n, KP), np.full(n, KD), np.zeros(n), "this comparison")
    law = Controller(robot, "pd+dg", gains, tau_max=TAU_MAX)
    arrays = [(law.q, Q), (law.qd, V), (law.q_desired, T), (law.gravity, G)]
    yield from bound("control", law.update, law.tau, arrays)

    chain = rg.Accelerometer(cutoff_hz=None, start_count=1, stuck_count=0, axis_stuck_count=0)
    live, up = Controller(robot, "pd+dg", gains, tau_max=TAU_MAX, accelerometer=chain), -LEVEL
    inputs, update = [(live.q, Q), (live.qd, V), (live.q_desired, T)], live.update

    def fill(k: int) -> None:
        for array, samples in inputs:
            array[:] = samples[k]
        chain.push(monotonic_ns(), monotonic_ns(), up)

    def filled(k: int) -> None:
        fill(k)
        update()

    yield call("control_live", BIND, filled, 3, live.tau, fill=fill, alone=update)


def live(robot: rg.Robot, arm: Arm) -> Iterator[Call]:
    """Gravity from a base sensor at rest: the chain's step is in the cycle, without a new sample and with one each."""
    chain = rg.Accelerometer(cutoff_hz=20.0, stuck_count=0, axis_stuck_count=0)
    Q, q, out, rest, push = arm.q, np.empty(arm.n), np.empty(arm.n), -LEVEL, chain.push
    cycle = robot.bind(q=q, gravity=chain, out=out)

    def sampled() -> None:
        now = monotonic_ns()
        push(now, now, rest)
        cycle()

    def fill(k: int) -> None:
        q[:] = Q[k]

    for way, alone in (("bind to a sensor", cycle), ("bind to a sensor, a new sample", sampled)):

        def filled(k: int, alone: Callable[[], None] = alone) -> None:
            fill(k)
            alone()

        yield call("live", way, filled, 1, out, fill=fill, alone=alone)
