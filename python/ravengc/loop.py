"""The paced control loop, from Python: absolute deadlines, a record of every cycle, and nothing allocated on purpose.

Deadlines lie on a grid of CLOCK_MONOTONIC. Python 3.11 has no ``time.clock_nanosleep``, and ``time.sleep`` returns 80
us late (median) to 500 us late (p99.9) at 1 kHz on a stock Linux kernel; so the loop sleeps until 200 us before the
deadline and watches the clock for the rest, which leaves 1 us (median). Where the system allows it, the loop's thread
has a real-time priority meanwhile (SCHED_FIFO). A cycle that is not done at the next deadline is late: the loop skips
to the next grid point that it can meet, counts what it skipped, and the plant goes on under the last torque.
"""

from __future__ import annotations

import contextlib
import gc
import math
import os
import time
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc._convert import as_count, as_number, check_members, check_type
from ravengc.control import CONTROLLER_STATES, Controller
from ravengc.errors import ArgumentError, TimingError
from ravengc.messages import kind_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["ControlLoop", "Plant", "Record", "Sensor", "Trajectory", "check_timing"]

Array = NDArray[np.float64]

SLOWEST_HZ, FASTEST_HZ = 1.0, 20_000.0
MOST_CYCLES = 1e7
"""Every cycle is remembered: 1e7 cycles of seven joints are 4 GB."""
SPIN_NS = 200_000
FIFO_PRIORITY = 50


class Plant(Protocol):
    """What the loop drives: :class:`ravengc.sim.Plant`, or anything with these members."""

    q: Array
    qd: Array

    def step(self, tau: Array, dt: float) -> None:
        """Hold ``tau`` for ``dt`` seconds."""


class Sensor(Protocol):
    """Where gravity comes from: the vector (3,) in base axes, updated in place, its age (s), and how far to trust it.

    ``state`` is a number of :data:`ravengc.monitored.STATES`, ``status`` a word of alarms. A law that takes how the
    base turns also needs ``angular_velocity`` and ``angular_acceleration`` (3,), updated in place, or the
    ``accelerometer`` whose chain says them.
    """

    gravity: Array
    age: float
    state: int
    status: int

    def update(self, time: float) -> None:
        """Take what is due at ``time`` (s)."""


class Trajectory(Protocol):
    """Where the joints should be."""

    def at(self, t: float, q: Array, qd: Array) -> None:
        """Write positions and velocities at ``t`` (s) into the arrays."""


class Record:
    """Every cycle that ran, one row each, in arrays made before the loop starts.

    ``time`` (s), ``q``, ``qd``, ``q_desired`` (rad, m, per s), ``tau_pd``, ``tau_gravity``, ``tau_disturbance`` and
    ``tau`` (N m, N), ``gravity`` (m/s^2, base axes, as used), ``sensor_age`` (s, NaN before the first sample),
    ``sensor_state``, ``sensor_status`` (as :class:`Sensor` says), ``controller_state`` (a number of
    :data:`ravengc.control.CONTROLLER_STATES`), ``controller_status`` (its word of events), ``compute_ns`` (the control
    law alone), ``lateness_ns`` (start after the deadline), ``late`` (the next deadline was missed).
    """

    def __init__(self, cycles: int, n: int) -> None:
        cycles, n = as_count(cycles, "cycles", 0, int(MOST_CYCLES)), as_count(n, "n", 1, ravengc.MAX_JOINTS)
        self.time = np.zeros(cycles)
        self.q, self.qd, self.q_desired = np.zeros((3, cycles, n))
        self.tau_pd, self.tau_gravity, self.tau_disturbance, self.tau = np.zeros((4, cycles, n))
        self.gravity = np.zeros((cycles, 3))
        self.sensor_age = np.zeros(cycles)
        self.sensor_state = np.zeros(cycles, dtype=np.int8)
        self.sensor_status = np.zeros(cycles, dtype=np.int64)
        self.controller_state = np.zeros(cycles, dtype=np.int8)
        self.controller_status = np.zeros(cycles, dtype=np.int64)
        self.compute_ns = np.zeros(cycles, dtype=np.int64)
        self.lateness_ns = np.zeros(cycles, dtype=np.int64)
        self.late = np.zeros(cycles, dtype=np.bool_)
        self.count = 0
        self.skipped = 0
        self.interrupted = False
        self.real_time = False

    def columns(self) -> dict[str, NDArray[np.generic]]:
        """The rows that were written, as arrays by name."""
        return {name: array[: self.count] for name, array in vars(self).items() if isinstance(array, np.ndarray)}


class ControlLoop:
    """Runs ``controller`` on ``plant`` at ``rate_hz`` for ``duration_s`` seconds of plant time.

    ``paced`` keeps to the clock; otherwise cycles follow one another as fast as they can and none is late.
    ``on_tick`` gets the number of cycles that have passed and their total, ten times a second of plant time.
    A controller with feedback from the motors gets the positions of the plant's motors as the robot's transmission has
    them there, one with elastic joints also those of the links; its torques go to the joints.
    Raises ArgumentError for parts that do not have what :class:`Plant`, :class:`Sensor` or :class:`Trajectory` has, and
    TimingError for a rate or duration that cannot be kept, or a rate that is not the controller's.
    """

    def __init__(
        self,
        plant: Plant,
        controller: Controller,
        sensor: Sensor,
        trajectory: Trajectory,
        *,
        rate_hz: float = 1000.0,
        duration_s: float = 10.0,
        paced: bool = True,
        on_tick: Callable[[int, int], None] | None = None,
    ) -> None:
        _check_parts(plant, controller, sensor, trajectory, on_tick)
        rate_hz, duration_s = check_timing(rate_hz, duration_s)
        _check_controller(controller, rate_hz)
        self.slots = max(1, round(duration_s * rate_hz))
        self.record = Record(self.slots, len(controller.q))
        self._plant, self.controller, self._sensor, self._trajectory = plant, controller, sensor, trajectory
        self._period_ns = round(1e9 / rate_hz)
        self._period_s = 1.0 / rate_hz
        self._measure = _measuring(plant, controller)
        self._turning = _turning(sensor, controller) if controller.law.turning else None
        self._paced = paced
        self._on_tick = on_tick
        self._tick_slots = max(1, round(rate_hz / 10.0))

    def run(self) -> Record:
        """Run to the end, or until Ctrl-C, and return the record of the cycles that ran."""
        with _collector_frozen(), _real_time_priority(self._paced) as allowed, contextlib.suppress(KeyboardInterrupt):
            self.record.real_time = allowed
            self.record.interrupted = True
            self._run()
            self.record.interrupted = False
        return self.record

    def _run(self) -> None:
        start = time.monotonic_ns() + self._period_ns
        slot = 0
        while slot < self.slots:
            lateness = _wait_until(start + slot * self._period_ns) if self._paced else 0
            self._cycle(slot * self._period_s, lateness)
            following = self._step_to_next(start, slot)
            if self._on_tick is not None and following // self._tick_slots > slot // self._tick_slots:
                self._on_tick(following, self.slots)
            slot = following

    def _cycle(self, now: float, lateness: int) -> None:
        """One control cycle: read, compute, remember."""
        controller = self.controller
        self._sensor.update(now)
        self._trajectory.at(now, controller.q_desired, controller.qd_desired)
        begun = time.perf_counter_ns()
        self._measure()
        if controller.law.gravity == "dynamic":
            np.copyto(controller.gravity, self._sensor.gravity)
        if self._turning is not None:
            self._turning()
        controller.update()
        self._remember(now, time.perf_counter_ns() - begun, lateness)

    def _remember(self, now: float, compute_ns: int, lateness: int) -> None:
        record, row, controller = self.record, self.record.count, self.controller
        record.time[row] = now
        record.q[row] = self._plant.q
        record.qd[row] = self._plant.qd
        record.q_desired[row] = controller.q_desired
        record.tau_pd[row] = controller.tau_pd
        record.tau_gravity[row] = controller.tau_gravity
        record.tau_disturbance[row] = controller.tau_disturbance
        record.tau[row] = controller.tau
        record.gravity[row] = controller.gravity
        record.sensor_age[row] = self._sensor.age
        record.sensor_state[row] = self._sensor.state
        record.sensor_status[row] = self._sensor.status
        record.controller_state[row] = CONTROLLER_STATES.index(controller.state)
        record.controller_status[row] = controller.status
        record.compute_ns[row] = compute_ns
        record.lateness_ns[row] = lateness
        record.count = row + 1

    def _step_to_next(self, start: int, slot: int) -> int:
        """Step the plant to the next slot that can be met, and say which; slots whose time has passed are skipped."""
        self._plant.step(self.controller.tau, self._period_s)
        following = slot + 1
        while self._paced and following < self.slots and (due := self._first_future_slot(start)) > following:
            due = min(due, self.slots)
            self._plant.step(self.controller.tau, (due - following) * self._period_s)
            self.record.late[self.record.count - 1] = True
            self.record.skipped += due - following
            self.controller.skip(due - following)
            following = due
        return following

    def _first_future_slot(self, start: int) -> int:
        return math.ceil((time.monotonic_ns() - start) / self._period_ns)


def check_timing(rate_hz: float, duration_s: float) -> tuple[float, float]:
    """Return rate and duration of a loop; TimingError for those that cannot be kept."""
    rate_hz, duration_s = as_number(rate_hz, "rate_hz"), as_number(duration_s, "duration_s")
    if not (SLOWEST_HZ <= rate_hz <= FASTEST_HZ and 0.0 < duration_s * rate_hz <= MOST_CYCLES):
        raise TimingError(
            f"rate {rate_hz:g} Hz, duration {duration_s:g} s: the rate must be from {SLOWEST_HZ:g} to "
            f"{FASTEST_HZ:g} Hz, the duration positive, and their product, the cycles, at most {MOST_CYCLES:g}"
        )
    return rate_hz, duration_s


def _check_parts(plant: object, controller: Controller, sensor: object, trajectory: object, on_tick: object) -> None:
    """Refuse what a cycle would stumble over."""
    check_type(controller, Controller, "controller")
    check_members(plant, ("q", "qd", "step"), "plant")
    for name in ("q", "qd"):
        if (shape := np.shape(getattr(plant, name))) != controller.q.shape:
            raise ArgumentError(f"plant.{name} has shape {shape}; expected {controller.q.shape} as the controller's")
    check_members(sensor, ("gravity", "age", "state", "status", "update"), "sensor")
    check_members(trajectory, ("at",), "trajectory")
    if on_tick is not None and not callable(on_tick):
        raise ArgumentError(f"on_tick is {kind_of(on_tick)}; expected a function of two numbers, or None")


def _check_controller(controller: Controller, rate_hz: float) -> None:
    """Refuse a controller that would mean something else in this loop."""
    if controller.output != "joint":
        raise ArgumentError("the controller's torques go to the motors; make it with output='joint' to drive a plant")
    if controller.timed and not math.isclose(controller.rate_hz, rate_hz, rel_tol=1e-9):
        raise TimingError(
            f"the controller counts {controller.rate_hz:g} updates per second for its ramps, rates and differences, "
            f"the loop makes {rate_hz:g}; make it with rate_hz={rate_hz:g}"
        )


def _measuring(plant: Plant, controller: Controller) -> Callable[[], None]:
    """Positions and velocities of the plant where the controller wants them: its links', or its motors'."""
    at_links = controller.elastic is None and controller.feedback == "joint"
    q, qd = ("motor_q", "motor_qd") if hasattr(plant, "motor_q") and not at_links else ("q", "qd")

    def at_joints() -> None:
        np.copyto(controller.q, getattr(plant, q))
        np.copyto(controller.qd, getattr(plant, qd))
        np.copyto(controller.q_link, plant.q)

    def at_motors() -> None:
        motors(getattr(plant, q), controller.q)
        np.subtract(motors(getattr(plant, qd), controller.qd), zero, out=controller.qd)
        np.copyto(controller.q_link, plant.q)

    if controller.feedback == "joint":
        return at_joints
    motors = controller.robot.motor_positions
    zero = motors(np.zeros(controller.robot.n))
    return at_motors


def _turning(sensor: Any, controller: Controller) -> Callable[[], None]:
    """How the base turns, from the sensor's arrays, or from its chain."""

    def from_arrays() -> None:
        np.copyto(controller.angular_velocity, sensor.angular_velocity)
        np.copyto(controller.angular_acceleration, sensor.angular_acceleration)

    def from_chain() -> None:
        motion = sensor.accelerometer.base_motion
        controller.angular_velocity[:] = motion.angular_velocity
        controller.angular_acceleration[:] = motion.angular_acceleration

    if hasattr(sensor, "angular_velocity") and hasattr(sensor, "angular_acceleration"):
        return from_arrays
    check_members(sensor, ("accelerometer",), "sensor")
    return from_chain


def _wait_until(deadline: int) -> int:
    """Sleep, then watch the clock, until ``deadline`` (ns, CLOCK_MONOTONIC); return how late it is (ns)."""
    rest = deadline - SPIN_NS - time.monotonic_ns()
    if rest > 0:
        time.sleep(rest * 1e-9)
    while (now := time.monotonic_ns()) < deadline:
        pass
    return now - deadline


@contextlib.contextmanager
def _collector_frozen() -> Iterator[None]:
    """No garbage collection inside: a full one takes longer than many cycles."""
    enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if enabled:
            gc.enable()


@contextlib.contextmanager
def _real_time_priority(wanted: bool) -> Iterator[bool]:
    """Give this thread SCHED_FIFO inside, if ``wanted`` and allowed; says whether it has it."""
    if not wanted or not hasattr(os, "sched_setscheduler"):
        yield False
        return
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(FIFO_PRIORITY))
    except OSError:
        yield False
        return
    try:
        yield True
    finally:
        os.sched_setscheduler(0, *before)
