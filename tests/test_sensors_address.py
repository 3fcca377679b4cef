"""Addresses: what they mean, and for each thing that can be wrong with one the words that say so."""

from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ravengc.errors import ArgumentError, ConfigError, MissingExtraError, RavenGCError
from ravengc.sensors import FORMATS, KINDS, open_sensor, parse_address
from ravengc.sensors.kinds import KINDS as KIND_TABLE


@pytest.mark.parametrize("kind", KINDS)
def test_the_example_of_every_kind_is_read(kind: str) -> None:
    address = parse_address(KIND_TABLE[kind].example)
    assert address.kind == kind
    assert KIND_TABLE[kind].about


def test_a_place_may_have_colons_and_a_value_escaped_characters() -> None:
    address = parse_address("serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0?format=rosserial&topic=a%26b")
    assert address.place == "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0"
    assert address.options == {"format": "rosserial", "topic": "a&b"}


def test_quantities_may_have_units() -> None:
    options = parse_address("sim:level?rate=0.2kHz&latency=20ms&noise=3e-2&range=2gn").options
    assert options == {"rate": 200.0, "latency": 0.02, "noise": 0.03, "range": 19.6133}


def test_defaults_do_not_overrule_the_address_and_fall_where_they_fit() -> None:
    assert parse_address("serial:/dev/x?unit=g").with_defaults(unit="mg", rate=5.0).options == {"unit": "g"}
    assert parse_address("serial:/dev/x?format=bno08x").with_defaults(unit="mg").options == {"format": "bno08x"}
    assert parse_address("iio:adxl345").with_defaults(unit="mg", rate=5.0).options == {"rate": 5.0}


WRONG = [
    ("serail:/dev/ttyUSB0", "did you mean 'serial'"),
    ("/dev/ttyUSB0", "did you mean 'serial:/dev/ttyUSB0'"),
    ("recording.csv", "did you mean 'replay:recording.csv'"),
    ("serial", "a port is missing"),
    ("serial:", "a port is missing"),
    ("", "has no kind"),
    ("serial:/dev/x?fromat=line", "did you mean 'format'"),
    ("serial:/dev/x?format=lines", "did you mean 'line'"),
    ("serial:/dev/x?topic=gravity", "it belongs to format=rosserial"),
    ("serial:/dev/x?format=bno08x&unit=g", "it belongs to format=line"),
    ("serial:/dev/x?format", "is no key=value"),
    ("serial:/dev/x?unit=g&unit=mg", "stands there twice"),
    ("serial:/dev/x?unit=m/s2", "did you mean 'm/s^2'"),
    ("serial:/dev/x?baud=115201", "did you mean '115200'"),
    ("serial:/dev/x?axes=x,y,-z", "mirror image"),
    ("serial:/dev/x?axes=x,x,z", "each of x, y, z once"),
    ("C:\\data\\imu.csv", "did you mean 'replay:C:\\\\data\\\\imu.csv'"),
    ("imu.CSV?unit=g", "did you mean 'replay:imu.CSV'"),
    ("out/imu.bin?format=bno08x", "did you mean 'file:out/imu.bin'"),
    ("nonsense", "known: 'sim', 'replay', 'serial', 'udp', 'file', 'stdin', 'iio'"),
    ("nonsense", "write KIND:ADDRESS"),
    ("file:a%00b", "no character NUL"),
    ("udp:http", "expected PORT or HOST:PORT"),
    ("udp:00000170000", "a port from 1 to 65535"),
    ("udp:0", "a port from 1 to 65535"),
    ("udp:70000", "a port from 1 to 65535"),
    ("stdin:/dev/stdin", "nothing may stand behind"),
    ("sim:rock:1:2:3", "rocking:LOW:HIGH:HZ"),
    ("sim:tilt:x", "tilt:DEG"),
    ("sim:?rate=fast", "'fast' is no quantity"),
    ("sim:?latency=3kg", "is a mass, expected a time"),
    ("sim:?seed=-1", "a whole number from 0"),
    ("sim:?position=1,2", "three numbers"),
    ("iio:adxl345?mount=maybe", "yes or no"),
    ("replay:a.csv?sends=force", "choose 'specific_force', 'gravity'"),
    ("sim:\n", "cannot be printed"),
    ("sim:" + "a" * 5000, "too long"),
]


@pytest.mark.parametrize(("text", "words"), WRONG)
def test_what_is_wrong_is_said(text: str, words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_address(text)
    assert words in str(caught.value)


def test_values_that_only_the_sensor_can_judge_are_judged_before_it_is_opened() -> None:
    for text in (
        "sim:?rate=0",
        "iio:x?rate=0",
        "iio:x?rate=-5",
        "replay:example:xio?speed=0",
        f"file:{__file__}?speed=-1",
        f"file:{__file__}?rate=0",
        "serial:/dev/x?format=csv&columns=ax,ay",
        "serial:/dev/x?format=rosserial&topic=a,b",
    ):
        with pytest.raises(ConfigError):
            parse_address(text).prepare()


def test_an_address_is_a_text() -> None:
    with pytest.raises(ArgumentError, match="sensor is an int; expected a str"):
        parse_address(3)


@given(st.text(max_size=60), st.sampled_from(["", *(f"{kind}:" for kind in KINDS)]))
@settings(deadline=None)
def test_any_text_is_an_address_or_an_error_of_ours(text: str, kind: str) -> None:
    try:
        address = parse_address(kind + text)
    except RavenGCError:
        return
    assert address.kind in KINDS


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'ravengc\[mavlink\]'"):
        parse_address("udp:14550?format=mavlink").prepare()


def test_keys_of_formats_have_readers() -> None:
    for kind in KIND_TABLE.values():
        for form in FORMATS:
            assert set(kind.format_keys(form)) <= set(FORMATS[form].keys)


def test_the_package_loads_no_sensors_and_the_sensors_no_pymavlink() -> None:
    program = "import ravengc, sys; a = set(sys.modules); import ravengc.sensors; b = set(sys.modules) - a; print(a, b)"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True, text=True)  # noqa: S603
    before, after = run.stdout.split("} {")
    assert "ravengc.sensors" not in before
    assert "pymavlink" not in after
    assert "ravengc.sim" not in after


def test_defaults_reach_the_sensor() -> None:
    sensor = open_sensor("sim:level", rate=200.0)
    first, second = (sensor.read(5.0) for _ in range(2))
    assert first is not None
    assert second is not None
    assert second.stamp_ns - first.stamp_ns == 5_000_000
