"""What a watch says of a stream: the unit to set in every case, where up is, and why nothing came."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ravengc as rg
from ravengc.sensors import parse_address
from ravengc.sensors.decoders.base import SAYS
from ravengc.sensors.sample import Sample
from ravengc.sensors.seen import MOST, Watch
from ravengc.sensors.units import ACCELERATION_UNITS, RATE_UNITS, mistaken_unit, parse_axes
from ravengc.sensors.verdicts import TURNS, size_words, verdicts

G = 9.80665
UNITS = sorted(ACCELERATION_UNITS)
TWINS = {"mg", "cm/s^2"}
"""1000 and 981 for one gravity."""


def shown(sent: str, declared: str) -> float:
    """The norm of gravity, m/s², sent in one unit and taken for another."""
    return G / ACCELERATION_UNITS[sent] * ACCELERATION_UNITS[declared]


@pytest.mark.parametrize(("sent", "declared"), list(product(UNITS, UNITS)))
def test_the_unit_to_set_is_the_one_that_is_sent(sent: str, declared: str) -> None:
    """With the norm as the sensor sent it, so that a reader recognises the number."""
    words = size_words(shown(sent, declared), parse_address(f"serial:/dev/x?unit={declared}"), None)
    if sent == declared or {sent, declared} == TWINS:
        assert words == ""
    else:
        assert words.startswith(f"norm {G / ACCELERATION_UNITS[sent]:.4g}: looks like {sent}, not ")
        assert f"not {declared.replace('^2', '²')}: set unit = {sent}" in words
        assert ("the two are 2 % apart" in words) == (sent in TWINS)


@pytest.mark.parametrize(("sent", "declared"), list(product(UNITS, UNITS)))
def test_the_unit_is_found_where_nobody_knows_which_was_declared(sent: str, declared: str) -> None:
    """A recording whose header names it: what was sent follows from the size all the same."""
    mistake = mistaken_unit(shown(sent, declared))
    if sent == declared or {sent, declared} == TWINS:
        assert mistake is None
    else:
        assert mistake is not None
        assert mistake[1] == sent


@given(st.floats(allow_nan=True, allow_infinity=True), st.sampled_from(["", *UNITS]))
def test_no_size_is_beyond_words(norm: float, declared: str) -> None:
    mistake = mistaken_unit(norm, declared)
    assert mistake is None or mistake[0] != mistake[1]
    words = size_words(norm, None, "raw counts")
    assert (words == "") == (not norm / G > 0.0 or abs(norm / G - 1.0) <= 0.15)


@pytest.mark.parametrize(
    ("norm", "address", "likely", "words"),
    [
        (2 * G, "serial:/dev/x", None, "2 times gravity: the sensor is set to another range"),
        (G / 4, "serial:/dev/x?format=bno08x", None, "0.25 times gravity"),
        (1.0, "serial:/dev/x?format=bno08x", None, "norm 1 m/s², gravity has 9.81: another unit or scale"),
        (4096.0, "serial:/dev/x", "raw counts", "looks like raw counts, which cannot be set as unit: convert it"),
        (32.17, "replay:x.csv", "ft/s^2", "looks like ft/s^2, which cannot be set"),
        (32.17 * G, "serial:/dev/x?unit=g", "mm/s^2", "another unit or scale"),
    ],
)
def test_what_cannot_be_set_is_not_told_to_be(norm: float, address: str, likely: str | None, words: str) -> None:
    said = size_words(norm, parse_address(address), likely)
    assert words in said
    assert "set unit" not in said


def watched(address: str, forces: list[tuple[float, float, float]], *, alarms: tuple[str, ...] = ()) -> Watch:
    found = Watch(100.0, parse_address(address))
    for number, force in enumerate(forces):
        found.take(0.01 * number, Sample(number, 0, force))
    found.alarm_names.update(alarms)
    return found


@pytest.mark.parametrize(("axis", "turn"), [(axis, TURNS.get(axis, "x,y,z")) for axis in ("x", "-x", "y", "-y", "-z")])
def test_the_turn_that_is_named_makes_up_the_z_axis(axis: str, turn: str) -> None:
    up = [0.0, 0.0, 0.0]
    up["xyz".index(axis[-1])] = -G if axis.startswith("-") else G
    assert parse_axes(turn).turn((up[0], up[1], up[2])) == (0.0, 0.0, G)
    found = watched("serial:/dev/x?format=bno08x", [(up[0], up[1], up[2])] * 30, alarms=("axes",))
    assert any(f"up is along {axis} of the sensor: axes={turn} makes it z" in words for words in verdicts(found))


def test_gravity_instead_of_specific_force_is_suggested_where_it_can_be_set() -> None:
    upside_down = [(0.0, 0.0, -G)] * 30
    (said,) = [words for words in verdicts(watched("serial:/dev/x", upside_down, alarms=("sign",))) if "up is" in words]
    assert "sends=gravity" in said
    turned = verdicts(watched("udp:14550?format=vectornav&axes=x,-y,-z", upside_down, alarms=("sign",)))
    (said,) = [words for words in turned if "up is" in words]
    assert "sends=gravity" not in said
    assert "axes=x,-y,-z" not in said, "it is turned already"


def rocked(address: str, factor: float, *, noise: float = 0.03, alarms: tuple[str, ...] = ("turn",)) -> Watch:
    """Ten seconds of a base that rocks about x by 10 degrees at 1 Hz, its angular velocity (rad/s) times a factor."""
    random, found = np.random.default_rng(7), Watch(100.0, parse_address(address))
    for k in range(1000):
        angle, rate = (math.radians(10.0) * f for f in (math.sin(0.0628 * k), 6.28 * math.cos(0.0628 * k)))
        x, y, z = random.normal((0.0, G * math.sin(angle), G * math.cos(angle)), noise)
        found.take(0.01 * k, Sample(k, 0, (x, y, z), (factor * rate, 0.0, 0.0)))
    found.alarm_names.update(alarms)
    return found


@pytest.mark.parametrize(("sent", "declared"), list(product(RATE_UNITS, RATE_UNITS)))
def test_the_unit_of_the_angular_velocity_follows_from_how_gravity_turned(sent: str, declared: str) -> None:
    found = rocked(f"replay:x.csv?gyro_unit={declared}", RATE_UNITS[declared] / RATE_UNITS[sent])
    said = [words for words in verdicts(found) if "gyro_unit" in words]
    assert len(said) == (sent != declared)
    assert all(f"looks like {sent}, not {declared}: set gyro_unit = {sent}" in words for words in said)


def test_a_rate_in_another_unit_is_said_where_it_cannot_be_set_and_not_without_an_alarm() -> None:
    degrees = 180.0 / math.pi
    (said,) = [words for words in verdicts(rocked("serial:/dev/x?format=line", degrees)) if "gyroscope says" in words]
    assert "looks like deg/s, not rad/s: convert it to rad/s where it is sent" in said
    for found in (
        rocked("replay:x.csv", degrees, alarms=()),
        rocked("replay:x.csv", -1.0),
        rocked("replay:x.csv", 5.0),
        rocked("replay:x.csv", 0.0),
        rocked("replay:x.csv", math.nan),
        rocked("replay:x.csv", degrees, noise=30.0),
    ):
        assert not any("gyroscope says" in words for words in verdicts(found))


@pytest.mark.parametrize("size", [0.0, 5e-324, 1e200, 1.7e308, math.inf, math.nan])
def test_no_angular_velocity_is_beyond_a_watch(size: float) -> None:
    found = watched("replay:x.csv", [(0.0, 0.0, G)] * 3, alarms=("gyro",))
    for k in range(3, 9):
        found.take(0.01 * k, Sample(k, 0, (size, -size * (k % 2), G), (size, size, -size)))
    assert not any("gyroscope says" in words for words in verdicts(found))


@pytest.mark.parametrize(
    ("address", "link", "remark", "words"),
    [
        ("serial:/dev/x", {}, "", "not one byte: is the sensor on, and its TX on our RX?"),
        ("serial:/dev/x", {}, "failed: serial port '/dev/x': not there", "no sample came"),
        ("serial:/dev/x", {"bytes_received": 77}, "", "77 bytes, but no frame of this format in them; try another"),
        ("serial:/dev/x", {"bytes_received": 77}, "", "format= or baud="),
        ("udp:14550", {}, "", "udp:0.0.0.0:PORT"),
        ("udp:14550", {"bytes_received": 77}, "", "try another format="),
        ("udp:14550?format=mavlink", {"bytes_received": 77, "other_frames": 3}, "", "3 good frames, but none with"),
        ("iio:adxl345", {}, "", "no sample came"),
    ],
)
def test_silence_has_a_reason(address: str, link: dict[str, int], remark: str, words: str) -> None:
    found = watched(address, [])
    found.link, found.remark = link, remark
    said = verdicts(found)
    assert words in said[-1]
    assert said[:-1] == ([remark] if remark else [])
    assert "baud" not in said[-1] or address.startswith("serial")


def healthy(address: str) -> Watch:
    found = watched(address, [(0.0, 0.0, G)] * 300)
    found.state, found.seconds["live"] = "live", 2.0
    return found


def test_a_greeting_is_nothing_wrong_and_an_advice_is() -> None:
    found = healthy("serial:/dev/x")
    assert verdicts(found) == ["nothing wrong was seen"]
    found.remark = f"{SAYS}ADXL345"
    assert verdicts(found) == [found.remark, "nothing wrong was seen"]
    found.remark = "it measures 13 times per second and is read 100 times"
    assert verdicts(found) == [found.remark]


def test_a_stream_that_was_joined_in_the_middle_of_a_frame_is_healthy_and_a_bad_cable_is_not() -> None:
    found = healthy("serial:/dev/x")
    found.link = {"bad_checksum": 2, "frames_lost": 3, "bytes_received": 9999}
    assert verdicts(found) == ["nothing wrong was seen"]
    found.link = {"bad_checksum": 20, "bad_content": 5, "frames_lost": 30, "foreign_datagrams": 4}
    said = " ".join(verdicts(found))
    assert "25 frames with a wrong checksum or content: a bad cable" in said
    assert "30 frames that the sensor counted did not come" in said
    assert "4 datagrams of another sender" in said


def test_what_was_never_live_is_not_called_well() -> None:
    found = watched("serial:/dev/x", [(0.0, 0.0, G)])
    assert verdicts(found) == ["at the end the sensor was not live but nominal: 1 samples had come"]
    assert math.isnan(found.rate_hz)
    assert math.isnan(found.jitter_s)


@pytest.mark.parametrize("gap_ms", [1, 9, 11, 40, 3000])
def test_an_alarm_that_stands_is_one_however_seldom_it_is_looked_at(gap_ms: int) -> None:
    chain, found = rg.Accelerometer(), Watch(100.0)
    for step in range(40):
        chain.step(step * gap_ms * 1_000_000)
        found.note(1e-3 * step * gap_ms, chain)
    if 39 * gap_ms > 80:
        assert found.alarms == 1
        assert found.episodes[0].end == pytest.approx(39e-3 * gap_ms)
    chain.acknowledge()
    found.note(200.0, chain)
    chain.step(200_000_000_000)
    found.note(200.1, chain)
    assert len(found.episodes) == found.alarms == 1 + (39 * gap_ms > 80), "one that went and came again is another"


def test_a_watch_of_days_keeps_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ravengc.sensors.seen.MOST", 100)
    assert MOST >= 10_000
    found = watched("serial:/dev/x", [(0.0, 0.0, 5.0), *[(0.0, 0.0, G)] * 1000])
    assert found.count == 1001
    assert len(found.stamps) == len(found.norms) <= 200
    assert found.lowest == 5.0
    assert found.rate_hz == pytest.approx(100.0)
    for number in range(1000):
        found._alarm(float(number), ("age",))
    assert found.alarms == 1000
    assert len(found.episodes) <= 200
