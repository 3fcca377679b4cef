"""The chain of the base's accelerometer from Python: settings, states, alarms, threads, and the cycle bound to it."""

from __future__ import annotations

import ast
import math
import re
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc.errors import ArgumentError, ConfigError, ModelError

MS = 1_000_000
LEVEL = np.array((0.0, 0.0, rg.STANDARD_GRAVITY))
STEP = 50.0 * 1e-3
"""How far the output may move in a millisecond, m/s^2, with the default rate."""


class Bench:
    """A chain stepped every millisecond, with a 100 Hz sensor whose samples a test makes up."""

    def __init__(self, **chosen: object) -> None:
        self.chain = rg.Accelerometer(**chosen)
        self.random = np.random.default_rng(1)
        self.now = 0
        self.seq = 0
        self.states: list[str] = []
        self.gravity = [self._gravity()]

    def _gravity(self) -> np.ndarray:
        g = self.chain.gravity
        return np.array((g.x, g.y, g.z))

    def run(self, seconds: float, force: object = LEVEL, noise: float = 0.03) -> None:
        """Step for so long; ``force`` (3,), a function of time, or None for silence."""
        for _ in range(round(1000 * seconds)):
            self.now += MS
            if force is not None and self.now % (10 * MS) == 0:
                self.seq += 1
                f = force(1e-9 * self.now) if callable(force) else force
                assert self.chain.push(self.seq, self.now, f + noise * self.random.standard_normal(3))
            self.chain.step(self.now)
            if not self.states or self.states[-1] != self.chain.state:
                self.states.append(self.chain.state)
            self.gravity.append(self._gravity())

    def steps(self) -> np.ndarray:
        """How far the output moved in each step."""
        return np.linalg.norm(np.diff(self.gravity, axis=0), axis=1)


def tilted(degrees: float) -> np.ndarray:
    angle = math.radians(degrees)
    return rg.STANDARD_GRAVITY * np.array((math.sin(angle), 0.0, math.cos(angle)))


def test_the_papers_rule_holds_the_last_value_and_recovers_by_itself() -> None:
    bench = Bench()
    assert bench.chain.state == "nominal"
    assert bench.chain.gravity == rg.Gravity.level()
    assert bench.chain.age_ns is None
    bench.run(1.0, tilted(20.0))
    assert bench.chain.state == "live"
    before = bench.gravity[-1]
    np.testing.assert_allclose(before, -tilted(20.0), atol=0.2)
    bench.run(0.6, None)
    assert bench.chain.state == "held"
    assert "age" in bench.chain.alarms
    np.testing.assert_allclose(bench.gravity[-1], before, atol=0.2)
    bench.run(1.0, tilted(20.0))
    assert bench.states == ["nominal", "live", "held", "live"]
    assert not bench.chain.alarms
    assert bench.steps().max() <= STEP * (1 + 1e-9)


def test_an_interruption_alarms_within_50_ms() -> None:
    bench = Bench()
    bench.run(1.0)
    bench.run(0.05, None)
    assert bench.chain.alarms == ("age",)


def test_the_strict_rule_bleeds_latches_and_waits_for_an_acknowledgement() -> None:
    bench = Bench(policy="strict")
    assert bench.chain.state == "no_data"
    assert not bench.chain.armable
    bench.run(1.0, tilted(10.0))
    assert bench.chain.armable
    bench.run(1.0, None)
    bench.run(1.0, tilted(10.0))
    assert bench.states == ["no_data", "live", "held", "degraded", "fault"]
    assert not bench.chain.armable
    bench.chain.acknowledge()
    bench.run(1.0, tilted(10.0))
    assert bench.chain.state == "live"
    assert bench.chain.armable
    assert bench.steps().max() <= STEP * (1 + 1e-9)


def test_a_stream_of_nan_is_never_healthy_and_never_younger() -> None:
    bench = Bench()
    bench.run(1.0)
    bench.run(0.5, np.full(3, math.nan))
    assert bench.chain.state == "held"
    assert "not_finite" in bench.chain.alarms
    assert bench.chain.age_ns is not None
    assert bench.chain.age_ns >= 490 * MS
    assert np.isfinite(bench.gravity).all()
    assert bench.chain.counters["not_finite"] == 50


@pytest.mark.parametrize(
    ("unit", "size"), [("g", rg.STANDARD_GRAVITY), ("mg", rg.STANDARD_GRAVITY / 1e3), ("cm/s^2", 0.01)]
)
def test_a_declared_unit_is_converted_and_an_undeclared_one_named(unit: str, size: float) -> None:
    declared, wrong = Bench(unit=unit), Bench()
    for bench in (declared, wrong):
        bench.run(1.0, tilted(5.0) / size, noise=0.003 / size)
    assert declared.chain.state == "live"
    np.testing.assert_allclose(declared.gravity[-1], -tilted(5.0), atol=0.05)
    assert wrong.chain.state == "nominal"
    if unit == "g":
        assert wrong.chain.likely_unit == "g"
    assert wrong.chain.alarms


def test_calibration_and_mounting_are_applied() -> None:
    random = np.random.default_rng(3)
    rotation = np.linalg.qr(random.standard_normal((3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    bias, correction = np.array((0.3, -0.2, 0.1)), np.eye(3) + 0.02 * random.standard_normal((3, 3))
    sent = np.linalg.solve(correction, rotation.T @ tilted(15.0)) + bias
    bench = Bench(rotation=rotation, bias=bias, correction=correction, cutoff_hz=None)
    bench.run(2.0, sent, noise=1e-6)
    np.testing.assert_allclose(bench.gravity[-1], -tilted(15.0), atol=1e-4)


def test_a_gyroscope_takes_out_the_lever_arm() -> None:
    position, rate = np.array((0.3, 0.0, 0.0)), np.array((0.0, 0.0, 1.5))
    felt = LEVEL + np.cross(rate, np.cross(rate, position))
    chain = rg.Accelerometer(position=position)
    for k in range(3000):
        if k % 10 == 0:
            chain.push(k, k * MS, felt + 1e-9 * k, rate + 1e-9 * k)
        chain.step(k * MS)
    assert chain.state == "live"
    motion = chain.base_motion
    np.testing.assert_allclose((motion.specific_force.x, motion.specific_force.y), 0.0, atol=1e-3)
    np.testing.assert_allclose(motion.angular_velocity, rate, atol=1e-3)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, 2**64 - 1),
            st.integers(-(2**63), 2**63 - 1),
            st.lists(st.floats(width=64), min_size=3, max_size=3),
            st.none() | st.lists(st.floats(width=64), min_size=3, max_size=3),
            st.integers(-(2**63), 2**63 - 1),
        ),
        max_size=50,
    )
)
def test_whatever_comes_in_the_output_is_finite_bounded_and_steady(samples: list) -> None:
    chain, out = rg.Accelerometer(), np.zeros(3)
    before = np.array((0.0, 0.0, -rg.STANDARD_GRAVITY))
    for seq, stamp, force, rate, now in samples:
        chain.push(seq, stamp, force, rate)
        chain.step(now, out)
        assert np.isfinite(out).all()
        assert np.linalg.norm(out - before) <= 10 * STEP * (1 + 1e-9)
        before = out.copy()


def test_counters_and_status_speak_of_the_same_faults() -> None:
    bench = Bench()
    bench.run(1.0)
    bench.run(0.2, None)
    assert list(rg.FAULTS) == [name for name in bench.chain.counters if name in rg.FAULTS]
    bits = {name: 1 << bit for bit, name in enumerate(rg.FAULTS)}
    assert bench.chain.status & 0xFFFF_FFFF == sum(bits[name] for name in bench.chain.alarms)
    assert bench.chain.counters["received"] == 100
    assert all(rg.FAULTS.values())


def test_a_bound_cycle_steps_its_sensor() -> None:
    robot = rg.load("panda")
    chain, q, tau = rg.Accelerometer(), np.linspace(0.1, 0.7, 7), np.empty(7)
    cycle = robot.bind(q=q, gravity=chain, out=tau)
    cycle()
    np.testing.assert_array_equal(tau, robot.gravity_torque(q, rg.Gravity.level()))
    deadline = time.monotonic() + 20.0
    for seq in range(10**9):
        force = tilted(20.0) + 0.02 * np.sin(seq + np.arange(3.0))
        chain.push(seq, time.monotonic_ns(), force)
        end = time.monotonic() + 0.01
        while time.monotonic() < end:
            cycle()
        if (chain.state == "live" and seq > 60) or time.monotonic() > deadline:
            break
    assert chain.state == "live"
    np.testing.assert_array_equal(tau, robot.gravity_torque(q, chain.gravity))


def test_threads_hand_in_samples_while_the_cycle_runs() -> None:
    """Two writers hammer; the output is always made of whole samples."""
    chain = rg.Accelerometer(cutoff_hz=None, stuck_count=0, axis_stuck_count=0)
    stop, out = threading.Event(), np.zeros(3)
    done = [0, 0]

    def write(which: int) -> None:
        force = tilted(20.0)
        while not stop.is_set():
            done[which] += chain.push(time.monotonic_ns(), time.monotonic_ns(), force)

    writers = [threading.Thread(target=write, args=(which,)) for which in (0, 1)]
    for writer in writers:
        writer.start()
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        chain.step(None, out)
        assert np.isfinite(out).all()
        assert abs(np.cross(out, -tilted(20.0))[0]) < 1e-9  # level and tilted lie in a plane, and so does the way
    stop.set()
    for writer in writers:
        writer.join()
    assert chain.counters["received"] <= sum(done)
    assert chain.counters["turned_away"] >= 0


def known_settings() -> list[str]:
    with pytest.raises(ConfigError) as refused:
        rg.Accelerometer(no_such_setting=1)
    listed = re.search(r"\(known: (.*)\)", str(refused.value))
    assert listed is not None
    return listed[1].split(", ")


def test_every_setting_is_typed_and_documented_and_taken_where_it_is_listed() -> None:
    stub = ast.parse((Path(rg.__file__).parent / "_core.pyi").read_text())
    (typed,) = (node for node in stub.body if isinstance(node, ast.ClassDef) and node.name == "_AccelerometerSettings")
    known = known_settings()
    assert [entry.target.id for entry in typed.body] == known
    places = [rg.Accelerometer.__doc__.find(name) for name in known]
    assert min(places) >= 0
    for name in known:
        with pytest.raises(ArgumentError, match=name):
            rg.Accelerometer(**{name: object()})


def test_an_axis_that_turns_against_the_gyroscope_is_an_alarm() -> None:
    chain = rg.Accelerometer()
    for k in range(8000):
        angle, rate = 0.4 * math.sin(1e-3 * k * math.tau), 0.4 * math.tau * math.cos(1e-3 * k * math.tau)
        sign = 1.0 if k < 6000 else -1.0
        if k % 10 == 0:
            force = rg.STANDARD_GRAVITY * np.array((0.0, sign * math.sin(angle), math.cos(angle))) + 1e-6 * k
            chain.push(k, k * MS, force, (rate + 1e-9 * k, 0.0, 0.0))
        chain.step(k * MS)
        assert (chain.state == "live") <= (k < 6400)
    assert "turn" in chain.alarms
    assert chain.counters["gyro"] == 0


@pytest.mark.parametrize(
    ("chosen", "error", "words"),
    [
        ({"rat_hz": 100.0}, ConfigError, "did you mean 'rate_hz'"),
        ({"policy": "papr"}, ConfigError, "'paper' or 'strict'"),
        ({"unit": "ft"}, ConfigError, "'m/s^2', 'g', 'mg' or 'cm/s^2'"),
        ({"rate_hz": "fast"}, ArgumentError, "rate_hz is 'fast'; expected a number"),
        ({"rate_hz": math.nan}, ConfigError, "rate_hz is NaN"),
        ({"cutoff_hz": 80.0}, ConfigError, "cutoff_hz is 80"),
        ({"max_age_s": 0.001}, ConfigError, "max_age_s is 0.001"),
        ({"hold_s": 0.01}, ConfigError, "hold_s is 0.01"),
        ({"bias": (90.0, 0.0, 0.0)}, ConfigError, "bias is 90"),
        ({"bias": (1.0, 2.0)}, ArgumentError, "bias"),
        ({"rotation": np.diag((1.0, 1.0, -1.0))}, ModelError, "mirror"),
        ({"norm": 3.0}, ArgumentError, "norm is 3.0"),
        ({"start_count": -1}, ArgumentError, "start_count is -1"),
        ({"moving_base": "yes"}, ArgumentError, "moving_base is 'yes'"),
    ],
)
def test_a_setting_that_cannot_be_meant_is_refused(chosen: dict, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=re.escape(words)):
        rg.Accelerometer(**chosen)


@pytest.mark.parametrize("force", [None, "x", (1.0, 2.0), np.zeros((3, 1))])
def test_a_sample_of_the_wrong_shape_is_refused(force: object) -> None:
    with pytest.raises(ArgumentError, match="specific_force"):
        rg.Accelerometer().push(0, 0, force)


@pytest.mark.parametrize(
    ("numbered", "words"),
    [
        ((-1, 0), "seq is -1; expected a whole number of 0 to 2^64 - 1"),
        ((0.5, 0), "seq is 0.5"),
        ((2**64, 0), "seq is 18446744073709551616"),
        ((0, 2**63), "stamp_ns is 9223372036854775808; expected whole nanoseconds"),
        ((0, "now"), "stamp_ns is 'now'"),
    ],
)
def test_a_number_or_stamp_that_is_none_is_named(numbered: tuple, words: str) -> None:
    with pytest.raises(ArgumentError, match=re.escape(words)):
        rg.Accelerometer().push(*numbered, (0.0, 0.0, 9.81))
