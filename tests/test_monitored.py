"""A monitored sensor tells what its chain is, after every step of any stream, however little it asks."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc.errors import ArgumentError
from ravengc.monitored import STATES, MonitoredSensor, chain_for

MS = 1_000_000
FORCES = st.one_of(
    st.just(None),
    st.tuples(*[st.floats(-0.05, 0.05)] * 3).map(lambda noise: (noise[0], noise[1], 9.80665 + noise[2])),
    st.sampled_from([(math.nan, 0.0, 0.0), (0.0, 0.0, 1e300), (0.0, 0.0, -9.8), (0.0, 0.0, 0.98), (7.0, 0.0, 7.0)]),
)
"""A good sample mostly, none, or one of several faults."""
STEPS = st.lists(st.tuples(FORCES, st.sampled_from([1, 5, 10, 10, 10, 60, 700]), st.booleans()), max_size=120)


def healthy(sensor: MonitoredSensor, count: int, start: int = 0) -> int:
    """Step through good samples 10 ms apart, and return the time."""
    for number in range(start, start + count):
        noise = 0.01 * math.sin(number)
        sensor.accelerometer.push(number, 10 * MS * number, (noise, -noise, 9.80665 + noise))
        sensor.step(10 * MS * number)
    return 10 * MS * (start + count - 1)


def agrees(sensor: MonitoredSensor) -> None:
    chain = sensor.accelerometer
    assert STATES[sensor.state] == chain.state
    assert sensor.status == chain.status
    assert math.isnan(sensor.age) if chain.age_ns is None else sensor.age == 1e-9 * chain.age_ns
    assert tuple(sensor.gravity) == (chain.gravity.x, chain.gravity.y, chain.gravity.z)


@pytest.mark.parametrize("policy", ["paper", "strict"])
@given(steps=STEPS, elsewhere=st.booleans())
@settings(deadline=None)
def test_state_age_status_and_gravity_are_the_chains(
    policy: str, steps: list[tuple[tuple[float, float, float] | None, int, bool]], elsewhere: bool
) -> None:
    """Also when somebody acknowledges, or steps the chain in between."""
    sensor = MonitoredSensor(chain_for(100.0, policy=policy))
    agrees(sensor)
    now = healthy(sensor, 30)
    assert STATES[sensor.state] == "live"
    for number, (force, wait, acknowledged) in enumerate(steps, start=30):
        now += wait * MS
        if force is not None:
            sensor.accelerometer.push(number, now, force)
        if elsewhere and acknowledged:
            sensor.accelerometer.step(now - MS // 2)
        if acknowledged:
            sensor.accelerometer.acknowledge()
        sensor.step(now)
        agrees(sensor)


def test_every_state_is_passed_and_told() -> None:
    sensor = MonitoredSensor(chain_for(100.0, policy="strict"))
    now, told = healthy(sensor, 30), []
    for wait in (10, 35, 20, 500):
        now += wait * MS
        sensor.step(now)
        agrees(sensor)
        told.append(STATES[sensor.state])
    assert told == ["live", "held", "degraded", "fault"]


def test_a_slow_sensor_has_time() -> None:
    """At 5 Hz, a sample that is 300 ms old is no reason for an alarm; at 100 Hz it is."""
    for rate_hz, state in ((5.0, "live"), (100.0, "held")):
        chain = chain_for(rate_hz)
        for number in range(40):
            stamp = round(1e9 * number / rate_hz)
            chain.push(number, stamp, (0.01 * math.sin(number), 0.01 * math.cos(number), 9.8 + 0.01 * math.sin(number)))
            chain.step(stamp)
        assert chain.state == "live"
        chain.step(stamp + 300 * MS)
        assert chain.state == state


def test_what_is_no_chain_is_refused() -> None:
    with pytest.raises(ArgumentError, match="accelerometer"):
        MonitoredSensor(3)
    for rate_hz in (-1.0, 0.0, math.nan, math.inf):
        with pytest.raises(rg.errors.ConfigError, match="rate_hz"):
            chain_for(rate_hz)
