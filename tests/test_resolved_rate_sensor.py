"""Resolved rate on a base whose turning the base's own sensor says: what it holds, and what it says when it cannot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from rate_arms import DT, HOME, PANDA, rotation_about
from ravengc.errors import ArgumentError
from ravengc.resolved_rate import ResolvedRate

if TYPE_CHECKING:
    from collections.abc import Callable

AXIS = np.array((1.0, 0.5, 0.0)) / math.sqrt(1.25)
PIVOT = np.array((0.1, -0.05, -0.3))
MS = 1_000_000
FAST: dict[str, Any] = {"rate_hz": 1000.0, "cutoff_hz": None}
"""A gyroscope of 1 kHz that is not filtered."""


class Rocking:
    """A base that comes to rock about a pivot at 1 Hz, and the sensor at its origin."""

    def __init__(self, degrees: float, glides: float = 0.0) -> None:
        self.swing, self.glides = math.radians(degrees), glides

    def pose(self, t: float) -> np.ndarray:
        """B in the world."""
        grown = min(max(t - 0.3, 0.0), 1.0)
        size = self.swing * grown**3 * (10.0 - 15.0 * grown + 6.0 * grown**2)
        R, pose = rotation_about(AXIS, size * math.sin(2.0 * math.pi * t)), np.eye(4)
        pose[:3, :3], pose[:3, 3] = R, PIVOT - R @ PIVOT + self.drift(t)
        return pose

    def drift(self, t: float) -> np.ndarray:
        """The pivot's own way in the world."""
        return self.glides * np.array((1.0 - math.cos(t), 0.0, 0.0))

    def rates(self, t: float, h: float = 1e-5) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Specific force, angular velocity and the pivot's velocity in base axes."""
        (before, now, after), g = (self.pose(t + k * h) for k in (-1, 0, 1)), np.array((0, 0, -rg.STANDARD_GRAVITY))
        R = now[:3, :3]
        W = R.T @ (after[:3, :3] - before[:3, :3]) / (2.0 * h)
        big = 1e-4
        ends = [self.pose(t + k * big)[:3, 3] for k in (-1, 0, 1)]
        a = (ends[0] - 2.0 * ends[1] + ends[2]) / big**2
        u = (self.drift(t + h) - self.drift(t - h)) / (2.0 * h)
        return R.T @ (a - g), np.array((W[2, 1], W[0, 2], W[1, 0])), R.T @ u


def sensor_of(**chosen: object) -> rg.Accelerometer:
    # No noise: the same bits again are no fault. The origin of the base accelerates by far more than that of a table.
    given = {"stuck_count": 0, "axis_stuck_count": 0, "linear_acceleration": 12.0, "jerk": 400.0, "norm": (1.0, 25.0)}
    return rg.Accelerometer(**(given | chosen))


def held(base: Rocking, sensor: rg.Accelerometer, every: int = 1, stepped: int = 1, noise: float = 0.0) -> float:
    """How far the tool gets from where it was in the world, m, from the sensor alone; it is read each ``every`` ms."""
    random = np.random.default_rng(0)
    rate = ResolvedRate(PANDA, midpoint=True, q_min=-np.inf, q_max=np.inf, qd_max=20.0)
    q, qd, velocity, worst = HOME.copy(), np.empty(7), np.zeros(3), 0.0
    cycle = rate.bind(q=q, twist=np.zeros(6), out=qd, base_twist=sensor, pivot=PIVOT, base_velocity=velocity)
    start = (base.pose(0.0) @ PANDA.forward_kinematics(q))[:3, 3]
    for k in range(3000):
        force, w, velocity[:] = base.rates(k * DT)
        if k % every == 0:
            sensor.push(k + 1, k * MS, force, w + noise * random.standard_normal(3))
        if k % stepped == 0:
            sensor.step(k * MS)
        cycle()
        q += DT * qd
        tool = (base.pose((k + 1) * DT) @ PANDA.forward_kinematics(q))[:3, 3]
        worst = max(worst, float(np.linalg.norm(tool - start)))
    assert sensor.state == "live", sensor.alarms
    assert "base_sensor" not in rate.seen
    return worst


@pytest.mark.parametrize("degrees", [10.0, 20.0])
def test_a_gyroscope_alone_holds_the_tool_while_the_base_rocks(degrees: float) -> None:
    """Open loop: nothing sees the tool."""
    assert held(Rocking(degrees), sensor_of(**FAST)) < 1e-4


def test_the_pivot_may_glide() -> None:
    assert held(Rocking(10.0, glides=0.2), sensor_of(**FAST)) < 3e-4


def test_what_is_old_or_filtered_is_carried_on() -> None:
    slow = held(Rocking(10.0), sensor_of(rate_hz=200.0, cutoff_hz=None), every=5)
    filtered = held(Rocking(10.0), sensor_of(rate_hz=1000.0, cutoff_hz=40.0))
    assert slow < 1e-3, slow  # ω as it came would be 2.5 ms late: 2 mm
    assert filtered < 2e-3, filtered  # and 5.6 ms: 5 mm


def test_a_poor_gyroscope_of_100_hz_holds_the_tool_within_millimetres() -> None:
    assert held(Rocking(20.0), sensor_of(rate_hz=100.0), every=10, noise=0.005) < 4e-3


@pytest.mark.parametrize("stepped", [2, 5])
def test_a_sensor_may_be_stepped_less_often_than_the_cycle(stepped: int) -> None:
    assert held(Rocking(10.0), sensor_of(**FAST), stepped=stepped) < 5e-4


def resting(sensor: rg.Accelerometer, rate: ResolvedRate, **bound: Any) -> Callable[[], np.ndarray]:
    """A cycle with the tool told to stay."""
    q, out = HOME.copy(), np.empty(7)
    cycle = rate.bind(q=q, twist=np.zeros(6), out=out, base_twist=sensor, **bound)

    def run() -> np.ndarray:
        cycle()
        return out.copy()

    return run


def test_a_sensor_that_is_not_trusted_is_said() -> None:
    sensor, rate = sensor_of(**FAST), ResolvedRate(PANDA)
    cycle = resting(sensor, rate, pivot=PIVOT)
    sensor.step(0)
    assert not cycle().any()
    assert rate.seen == ("base_sensor",)
    assert "not trusted" in rate.reason
    for k in range(1, 100):  # it comes to be trusted, without a gyroscope
        sensor.push(k, k * MS, (0.0, 0.0, rg.STANDARD_GRAVITY))
        sensor.step(k * MS)
        cycle()
    assert sensor.state == "live"
    assert rate.seen == ("base_sensor",)


def test_a_sensor_that_nobody_steps_fades() -> None:
    sensor, rate, base = sensor_of(**FAST), ResolvedRate(PANDA, qd_max=20.0), Rocking(10.0)
    cycle = resting(sensor, rate, pivot=PIVOT)
    for k in range(1, 1400):
        force, w, _ = base.rates(k * DT)
        sensor.push(k, k * MS, force, w)
        sensor.step(k * MS)
        before = cycle()
    assert before.any()
    assert not rate.seen
    steps = np.array([before, *(cycle() for _ in range(65))])
    assert np.abs(np.diff(steps, axis=0)).max() <= 0.025 * np.abs(before).max()
    assert not steps[-1].any()
    assert rate.seen == ("base_sensor",)


@pytest.mark.parametrize("dies", [2.0, 2.125, 2.25, 2.4])
def test_a_sensor_that_dies_in_mid_motion_is_left_without_a_jump_and_found_again(dies: float) -> None:
    """The base goes on rocking; for a while nobody measures it."""
    sensor, rate, base = sensor_of(**FAST), ResolvedRate(PANDA, qd_max=20.0), Rocking(20.0)
    cycle = resting(sensor, rate, pivot=PIVOT)
    rates, seen, states = [], [], []
    for k in range(1, 3000):
        force, w, _ = base.rates(k * DT)
        if not dies <= k * DT < dies + 0.2:
            sensor.push(k, k * MS, force, w)
        sensor.step(k * MS)
        rates.append(cycle())
        seen.append(rate.seen)
        states.append(sensor.state)
    fastest, changes = np.abs(rates[1500:2000]).max(), np.abs(np.diff(rates, axis=0)).max(axis=1)
    assert changes[: round(1000 * dies) + 150].max() <= 0.025 * fastest
    assert changes.max() <= 0.045 * fastest  # the sensor's own output is on its way back too
    assert not rates[round(1000 * dies) + 150].any()
    assert {seen[k] for k in range(len(seen)) if states[k] != "live"} == {("base_sensor",)}
    assert {seen[k] for k in range(60, len(seen)) if set(states[k - 60 : k + 1]) == {"live"}} == {()}


def test_what_a_sensor_cannot_say_has_to_be_given() -> None:
    sensor, rate = sensor_of(**FAST), ResolvedRate(PANDA)
    with pytest.raises(ArgumentError, match="how the base turns, not how fast its origin moves"):
        resting(sensor, rate)
    with pytest.raises(ArgumentError, match="pivot is"):
        resting(sensor, rate, pivot=(0.0, math.nan, 0.0))
    with pytest.raises(ArgumentError, match="belong to a base_twist that is an Accelerometer"):
        rate.bind(q=HOME.copy(), twist=np.zeros(6), out=np.empty(7), base_twist=np.zeros(6), pivot=PIVOT)
    with pytest.raises(ArgumentError, match="base_velocity"):
        resting(sensor, rate, base_velocity=np.zeros(6))
    for dt in (math.nan, 0.0, -DT, 2.0):
        with pytest.raises(ArgumentError, match="it should be a time step"):
            resting(sensor, rate, pivot=PIVOT, dt=dt)
