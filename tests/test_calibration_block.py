"""The table ``[accelerometer]``: read, refused and written, with every other byte of the file as it was."""

from __future__ import annotations

import errno
import os
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from calibration_scenes import rotation
from ravengc.calibration import AccelerometerBlock, read_block, write_block
from ravengc.calibration.block import KEYS
from ravengc.calibration.toml_edit import set_keys
from ravengc.config import bundled_names, bundled_path
from ravengc.errors import ArgumentError, ConfigError, ModelError, ParseError, RavenGCError, UnitsError

WHOLE = """\
# an arm
[accelerometer]
sensor = "serial:/dev/ttyUSB0?format=line&baud=115200"
rate_hz = 100.0   # declared
range = "2 gn"
unit = "g"
rotation = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
position = ["10 mm", "0 mm", "-0.3 m"]
bias = [0.1, 0.2, 0.3]
correction = [
  [1.01, 0, 0], # x
  [0, 0.99, 0],
  [0, 0, 1],
]
gyro_bias = ["1 deg/s", "0 deg/s", "0 deg/s"]
cutoff_hz = 20
policy = "strict"
gyro_range = "250 deg/s"
bandwidth_hz = 22.5
noise = 0.05
stuck_count = 0
up = [0, 0, 2]
pose_limit = "70 deg"
tilt_limit = 0.5
norm = [0.5, 39.2266]
jerk = 500
linear_acceleration = 4
moving_base = true

[tool] # after it
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "arm.toml"
    path.write_text(WHOLE)
    return path


def text_of(*lines: str) -> str:
    return "\n".join(["[accelerometer]", *lines, ""])


# Reading


def test_the_whole_table_is_read_in_si(file: Path) -> None:
    block = read_block(file)
    assert block is not None
    assert block.sensor == "serial:/dev/ttyUSB0?format=line&baud=115200"
    assert (block.rate_hz, block.unit, block.cutoff_hz, block.policy) == (100.0, "g", 20.0, "strict")
    assert block.range == pytest.approx(19.6133)
    assert block.rotation == ((0, -1, 0), (1, 0, 0), (0, 0, 1))
    assert block.position == (0.01, 0.0, -0.3)
    assert block.correction[0] == (1.01, 0, 0)
    assert block.gyro_bias == pytest.approx((0.0174532925, 0.0, 0.0))
    assert block.of_the_sensor == pytest.approx(
        {"gyro_range": np.deg2rad(250.0), "bandwidth_hz": 22.5, "noise": 0.05, "stuck_count": 0}
    )
    assert isinstance(block.stuck_count, int)
    assert (block.up, block.norm) == ((0.0, 0.0, 2.0), pytest.approx((0.5, 39.2266)))
    assert (block.pose_limit, block.tilt_limit) == pytest.approx((np.deg2rad(70.0), 0.5))
    assert (block.jerk, block.linear_acceleration, block.moving_base) == (500.0, 4.0, True)
    assert block.given == frozenset(KEYS)


def test_what_is_left_out_has_its_default(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("[accelerometer]\n")
    assert read_block(tmp_path / "a.toml") == AccelerometerBlock()
    (tmp_path / "a.toml").write_text("[tool]\n")
    assert read_block(tmp_path / "a.toml") is None
    assert set(AccelerometerBlock().as_dict()) == set(KEYS)


WRONG: list[tuple[str, type[RavenGCError], str]] = [
    ("biass = [0, 0, 0]", ConfigError, "unknown key 'biass'; did you mean 'bias'?"),
    ("bias = [0, 0]", ConfigError, "3 numbers"),
    ("bias = [0, 0, nan]", ConfigError, "finite"),
    ("bias = [0, 0, 98]", ConfigError, "at most 50 m/s²"),
    ('bias = ["0 m", "0 m", "0 m"]', UnitsError, "acceleration"),
    ("gyro_bias = [57, 0, 0]", ConfigError, "at most 10 rad/s"),
    ("position = [300, 0, 0]", ConfigError, "at most 100 m"),
    ("rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]", ModelError, "a mirror"),
    ("rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1.1]]", ModelError, "not orthonormal"),
    ("rotation = [[1, 0, 0], [0, 1, 0]]", ConfigError, "three rows"),
    ("correction = [[0, 1, 0], [1, 0, 0], [0, 0, 1]]", ConfigError, "near the identity"),
    ("correction = [[9.8, 0, 0], [0, 9.8, 0], [0, 0, 9.8]]", ConfigError, "near the identity"),
    ('unit = "G"', ConfigError, "did you mean 'g'?"),
    ('policy = "strikt"', ConfigError, "did you mean 'strict'?"),
    ("rate_hz = 0", ConfigError, "more than 0"),
    ("rate_hz = 100\ncutoff_hz = 50", ConfigError, "less than half of rate_hz, 50"),
    ("range = -2", ConfigError, "more than 0"),
    ("rate_hz = true", ConfigError, "finite number"),
    ('sensor = "/dev/ttyUSB0"', ConfigError, "did you mean 'serial:/dev/ttyUSB0'?"),
    ('sensor = "serial:/dev/ttyUSB0?fromat=line"', ConfigError, "'format'"),
    ("sensor = 5", ConfigError, "a text in quotes"),
    ("jerk = 0", ConfigError, "jerk is 0.0; it should be 1 to 1e6 m/s^3"),
    ("pose_limit = 60", ConfigError, "0.01 to pi rad"),
    ("norm = [18, 3]", ConfigError, "norm (lower end)"),
    ("rate_hz = 50\nbandwidth_hz = 40", ConfigError, "at most half the rate"),
    ("up = [0, 0, 0]", ConfigError, "a direction in base axes"),
    ("stuck_count = 2.5", ConfigError, "a whole number from 0"),
    ("stuck_count = -1", ConfigError, "a whole number from 0"),
    ("stuck_count = 1", ConfigError, "0 for never, or 2 to 10000 samples"),
    ("moving_base = 1", ConfigError, "true or false"),
    ("gyro_range = 0.01", ConfigError, "a full scale of 0.1"),
    ("noise = 5", ConfigError, "zero to 1 m/s^2"),
    ("moving_bas = true", ConfigError, "did you mean 'moving_base'?"),
]


@pytest.mark.parametrize(("line", "kind", "message"), WRONG)
def test_what_is_wrong_is_named_with_file_and_line(tmp_path: Path, line: str, kind: type, message: str) -> None:
    path = tmp_path / "arm.toml"
    path.write_text("# one\n" + text_of(line))
    with pytest.raises(kind) as caught:
        read_block(path)
    assert message in str(caught.value)
    assert f"{path}:{2 + len(line.splitlines())}: " in str(caught.value)


@pytest.mark.parametrize("text", ["[accelerometer", "a = \x00", "[accelerometer]\nbias = [", "x = " + "[" * 5000])
def test_what_is_no_toml_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "arm.toml").write_text(text)
    for action in (
        lambda: read_block(tmp_path / "arm.toml"),
        lambda: write_block(tmp_path / "arm.toml", {"rate_hz": 9}),
    ):
        with pytest.raises(ParseError, match="not valid TOML"):
            action()
    assert (tmp_path / "arm.toml").read_text() == text


def test_another_form_of_table_is_refused(tmp_path: Path) -> None:
    for text in ("[[accelerometer]]\n", "accelerometer = 5\n"):
        (tmp_path / "arm.toml").write_text(text)
        with pytest.raises(ConfigError, match="expected a table"):
            read_block(tmp_path / "arm.toml")


# Writing


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    bias=st.tuples(*[st.floats(-50, 50)] * 3),
    position=st.tuples(*[st.floats(-100, 100)] * 3),
    seed=st.integers(0, 1000),
    cutoff=st.floats(1e-3, 49.9),
)
def test_what_is_written_is_read_back_to_the_last_bit(
    tmp_path: Path, bias: Any, position: Any, seed: int, cutoff: Any
) -> None:
    path = tmp_path / f"{seed}.toml"
    values = {
        "bias": bias,
        "position": np.array(position),
        "rotation": rotation(seed),
        "cutoff_hz": cutoff,
        "unit": "mg",
    }
    written = write_block(path, values)
    assert read_block(path) == written
    assert written.bias == bias
    assert written.position == position
    assert np.array_equal(written.rotation, rotation(seed))
    assert (written.cutoff_hz, written.unit) == (cutoff, "mg")
    path.unlink()


def test_declarations_of_sensor_and_base_are_written_back(tmp_path: Path) -> None:
    declared = {
        "gyro_range": 8.7,
        "bandwidth_hz": 40.0,
        "noise": 0.05,
        "stuck_count": 12,
        "up": [0.0, 1.0, 0.0],
        "pose_limit": 1.2,
        "tilt_limit": 0.4,
        "norm": np.array([0.0, 30.0]),
        "jerk": 500.0,
        "linear_acceleration": 3.0,
        "moving_base": True,
    }
    block = write_block(tmp_path / "arm.toml", declared)
    assert block == read_block(tmp_path / "arm.toml")
    assert block.given == frozenset(declared)
    assert {**block.of_the_sensor, **block.of_the_base} == {**declared, "up": (0.0, 1.0, 0.0), "norm": (0.0, 30.0)}


@pytest.mark.parametrize("name", bundled_names())
def test_a_robot_gets_its_table_behind_all_it_had(tmp_path: Path, name: str) -> None:
    path, old = tmp_path / "arm.toml", bundled_path(name).read_bytes()
    path.write_bytes(old)
    write_block(path, {"bias": [0.1, 0.2, 0.3]})
    assert path.read_bytes() == old + b"\n[accelerometer]\nbias = [0.1, 0.2, 0.3]\n"
    write_block(path, {"bias": [1, 2, 3], "rate_hz": 100.0})
    assert path.read_bytes() == old + b"\n[accelerometer]\nbias = [1, 2, 3]\nrate_hz = 100.0\n"


def test_only_the_values_change(file: Path) -> None:
    write_block(file, {"bias": [1.5, 2.5, 3.5], "correction": np.eye(3), "rate_hz": 200.0, "policy": "paper"})
    expected = (
        WHOLE.replace("[0.1, 0.2, 0.3]", "[1.5, 2.5, 3.5]")
        .replace("100.0   # declared", "200.0   # declared")
        .replace('"strict"', '"paper"')
    )
    start, end = expected.index("correction"), expected.index("gyro_bias")
    one = "correction = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\n"
    assert file.read_text() == expected[:start] + one + expected[end:]


def test_new_keys_come_below_the_last_of_the_table(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    text = '[accelerometer] # here\nunit = "g" # sent\n# the end\n\n[tool]\ntranslation = [0, 0, 1]\n'
    path.write_text(text)
    write_block(path, {"rate_hz": 50.0})
    assert path.read_text() == text.replace("# sent\n", "# sent\nrate_hz = 50.0\n")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "[accelerometer]\nrate_hz = 1.0\n"),
        ("a = 1", "a = 1\n\n[accelerometer]\nrate_hz = 1.0\n"),
        ("[accelerometer]", "[accelerometer]\nrate_hz = 1.0\n"),
        ("[accelerometer]\r\nrange = 9\r\n", "[accelerometer]\r\nrange = 9\r\nrate_hz = 1.0\r\n"),
        ("a = 1\r\n", "a = 1\r\n\r\n[accelerometer]\r\nrate_hz = 1.0\r\n"),
        ("\ufeffa = 1\n", "\ufeffa = 1\n\n[accelerometer]\nrate_hz = 1.0\n"),
        ("[ 'accelerometer' ]\n\"rate_hz\"=2#c\n", "[ 'accelerometer' ]\n\"rate_hz\"=1.0#c\n"),
        ("[accelerometer]\nrate_hz = 2", "[accelerometer]\nrate_hz = 1.0"),
        ('x = """\n[accelerometer]\nrate_hz = 5\n"""\n', None),
        (
            "x = '''\n[accelerometer]\n'''\n[accelerometer]\nrate_hz = 3\n",
            "x = '''\n[accelerometer]\n'''\n[accelerometer]\nrate_hz = 1.0\n",
        ),
        ("# [accelerometer]\n# rate_hz = 7\n", None),
        ("x = [ # [accelerometer]\n  1, # ]\n]\n", None),
    ],
)  # fmt: skip
def test_texts_of_every_shape(tmp_path: Path, text: str, expected: str | None) -> None:
    path = tmp_path / "arm.toml"
    path.write_bytes(text.encode())
    write_block(path, {"rate_hz": 1.0})
    wanted = text + "\n[accelerometer]\nrate_hz = 1.0\n" if expected is None else expected
    assert path.read_bytes() == wanted.encode()


@pytest.mark.parametrize(
    "text",
    ["accelerometer = { rate_hz = 2 }\n", "accelerometer.rate_hz = 2\n", "[x]\ny = 1\n[accelerometer.a]\nb = 1\n"],
)
def test_a_table_in_another_form_is_refused_and_left(tmp_path: Path, text: str) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=r"write its table as \[accelerometer\]|unknown key"):
        write_block(path, {"rate_hz": 1.0})
    assert path.read_text() == text


NAME = st.sampled_from(["a", "b-c", '"d e"', "'f'", "x1"])
VALUE = st.sampled_from(
    [
        "1",
        "-2.5e3",
        '"[accelerometer]"',
        "'''\n[accelerometer]\nbias = 1\n'''",
        "[1, [2, 3], # c\n 4]",
        "{ p = 1 }",
        '"\\"#"',
    ]
)
COMMENT = st.sampled_from(["", "  # note", "#[accelerometer]", " # bias = 3 \"'"])
LINES = st.lists(st.tuples(NAME, VALUE, COMMENT), unique_by=lambda line: line[0].strip("\"'"), max_size=4)
GAP = st.sampled_from(["", "\n", "# between\n", "\t\n  # [x]\n"])


@settings(max_examples=150, deadline=None)
@given(
    top=LINES,
    inner=LINES,
    after=LINES,
    gaps=st.tuples(GAP, GAP, GAP),
    ending=st.sampled_from(["\n", "\r\n"]),
    has=st.booleans(),
)
def test_any_document_keeps_all_but_the_value(
    top: Any, inner: Any, after: Any, gaps: Any, ending: str, has: bool
) -> None:
    def lines(entries: Any) -> str:
        return "".join(f"{key} = {value}{comment}\n" for key, value, comment in entries)

    bias = "bias = [0, # x\n 1, 2] # was measured\n" if has else ""
    before = lines(top) + gaps[0] + "[accelerometer] # mine\n" + lines(inner)
    behind = gaps[1] + "[[link]]\n" + lines(after) + gaps[2]
    text = (before + bias + behind).replace("\n", ending)
    new = set_keys(text, "accelerometer", {"bias": [7.0, 8.0, 9.0]}, file="arm.toml")
    line = "bias = [7.0, 8.0, 9.0]" + (" # was measured" if has else "")
    assert new == (before + line + "\n" + behind).replace("\n", ending)
    assert tomllib.loads(new)["accelerometer"]["bias"] == [7.0, 8.0, 9.0]


# Failures leave the old file


@pytest.mark.parametrize(
    ("values", "kind", "message"),
    [
        ({"biass": [0, 0, 0]}, ConfigError, "did you mean 'bias'?"),
        ({"bias": [0, 0, 1e9]}, ConfigError, "at most 50"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, ModelError, "a mirror"),
        ({"bias": None}, ArgumentError, "bias is None"),
        ({"bias": [True, 0, 0]}, ArgumentError, "bias is True"),
        ({"bias": [np.nan, 0, 0]}, ArgumentError, "bias is nan; expected a finite number"),
        ({"moving_base": 1}, ConfigError, "true or false"),
        ({"jerk": True}, ArgumentError, "jerk is True"),
        ({"rate_hz": 10**5000}, ArgumentError, "rate_hz is a very large int; expected a finite number"),
        ({"bias": [10**400, 0, 0]}, ArgumentError, "expected a finite number"),
    ],
)
def test_what_would_be_refused_is_not_written(file: Path, values: Any, kind: type[Exception], message: str) -> None:
    with pytest.raises(kind) as caught:
        write_block(file, values)
    assert message in str(caught.value)
    assert file.read_text() == WHOLE


def test_a_file_that_holds_a_nan_elsewhere_is_edited(tmp_path: Path) -> None:
    """A NaN is unlike itself, and is left as it is all the same."""
    (tmp_path / "arm.toml").write_text("[notes]\nbest = nan\n")
    write_block(tmp_path / "arm.toml", {"rate_hz": 1.0})
    assert (tmp_path / "arm.toml").read_text() == "[notes]\nbest = nan\n\n[accelerometer]\nrate_hz = 1.0\n"


def test_a_link_stays_a_link_and_permissions_stay(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    target, link = tmp_path / "robots" / "arm.toml", tmp_path / "arm.toml"
    target.write_text(WHOLE)
    target.chmod(0o640)
    link.symlink_to(Path("robots") / "arm.toml")
    write_block(link, {"rate_hz": 50.0})
    assert link.is_symlink()
    assert target.read_text() == WHOLE.replace("100.0   # declared", "50.0   # declared")
    assert target.stat().st_mode & 0o777 == 0o640
    assert sorted(path.name for path in target.parent.iterdir()) == ["arm.toml"]
    dangling = tmp_path / "new.toml"
    dangling.symlink_to(Path("robots") / "made.toml")
    write_block(dangling, {"rate_hz": 50.0})
    assert (tmp_path / "robots" / "made.toml").read_text() == "[accelerometer]\nrate_hz = 50.0\n"


@pytest.mark.parametrize("place", ["/proc/self/arm.toml", "/dev/null/arm.toml", "folder.toml"])
def test_a_place_that_cannot_be_written_is_named(tmp_path: Path, place: str) -> None:
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(RavenGCError, match=f"{re.escape(place)}: cannot be"):
        write_block(tmp_path / place, {"rate_hz": 1.0})


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_an_interrupted_write_leaves_the_old_file(file: Path, step: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(*((os, "fsync") if step == "fsync" else (Path, "replace")), fail)
    with pytest.raises(ConfigError, match="No space left on device"):
        write_block(file, {"bias": [0, 0, 1]})
    assert file.read_text() == WHOLE
    assert list(file.parent.iterdir()) == [file]


def test_ctrl_c_leaves_the_old_file(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_block(file, {"bias": [0, 0, 1]})
    assert file.read_text() == WHOLE
    assert list(file.parent.iterdir()) == [file]


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"ending in \.toml"):
        write_block(tmp_path / "arm.urdf", {"rate_hz": 1.0})
    with pytest.raises(ParseError, match="No such file"):
        read_block(tmp_path / "none.toml")
