"""Robots as TOML: what is written is read back to the last bit, and whatever is wrong is named."""

from __future__ import annotations

import math
import os
import tomllib
from dataclasses import replace
from textwrap import dedent
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mutations import damaged
from ravengc.config import (
    bundled_names,
    bundled_path,
    spec_for,
    spec_from_toml,
    spec_to_toml,
    toml_reader,
    write_toml,
)
from ravengc.config.locate import line_numbers
from ravengc.errors import ConfigError, LimitError, ModelError, ParseError, RavenGCError, UnitsError
from ravengc.spec import (
    CouplingSpec,
    DhRow,
    JointLimits,
    JointOrigin,
    LinkSpec,
    Pose,
    RobotSpec,
    TransmissionSpec,
)
from strategies import robots

if TYPE_CHECKING:
    from pathlib import Path

ARM = """\
format = 1
name = "arm"
description = 'two "links"'
convention = "modified"
source = "a paper"

[base]
rotation = [
  [1, 0, 0], # first
  [0, 0, -1],
  [0, 1, 0],
]
translation = ["1 m", "20 cm", "-3 mm"]
source = "the drawing"

[[link]]
name = "one"
alpha = "90 deg"
theta = 0.25
mass = "494 g"
com = ["6.5 mm", "0 m", "-137.71 mm"]
inertia = [0.02, 0, 0, 0.02, 0, 0.001]
limits = { lower = "0 deg", upper = "90 deg", effort = "2 N*m" }

[[link]]
name = "two"
joint = "prismatic"
joint_name = "slide"
d = "13 mm"
a = 1e-3
mass = 1
com = [0.1,
       0.2, # a comment, with [ and "
       0.3]
limits = { lower = 0.1, upper = 0.2, velocity = "5 mm/s" }

[[link]]
name = "camera"
joint = "fixed"
parent = "one"
translation = [0, 0, 1]
rpy = ["0 deg", "90 deg", "0 deg"]
massless = true

[tool]
tip = "two"
translation = [0, 0, 0.1]

[coupling]
coordinates = ["a", "b"]
matrix = [[1, 0], [0, 0.5]]
offset = [0.1, 0.2] # rad, m
limits = [{ lower = 0, upper = 1 }, { lower = "0 m", upper = "10 mm" }]

[transmission]
motors = ["m1", "m2"]
motor_per_joint = [[2, 0], [1, 4]]

[mass_set.heavy.one]
mass = "2 kg"
source = "scales"
"""


def one(spec: RobotSpec, name: str) -> LinkSpec:
    return next(link for link in spec.links if link.name == name)


def test_a_file_is_read_as_it_stands() -> None:
    spec = spec_from_toml(ARM)
    assert spec.source == "a paper\nbase: the drawing"
    assert spec.base == Pose(rotation=((1, 0, 0), (0, 0, -1), (0, 1, 0)), translation=(1.0, 0.2, -0.003))
    assert one(spec, "one") == LinkSpec(
        name="one",
        placement=DhRow(alpha=math.pi / 2, theta=0.25),
        mass=0.494,
        com=(0.0065, 0.0, -0.13771),
        inertia=(0.02, 0, 0, 0.02, 0, 0.001),
        limits=JointLimits(lower=0.0, upper=math.pi / 2, effort=2.0),
    )
    assert one(spec, "two").parent == "one"
    assert one(spec, "two").limits == JointLimits(lower=0.1, upper=0.2, velocity=0.005)
    camera = one(spec, "camera").placement
    assert isinstance(camera, JointOrigin)
    np.testing.assert_allclose(camera.pose.rotation, [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-15)
    assert spec.tip == "two"
    assert spec.coupling == CouplingSpec(
        coordinates=("a", "b"),
        matrix=((1, 0), (0, 0.5)),
        offset=(0.1, 0.2),
        limits=(JointLimits(lower=0.0, upper=1.0), JointLimits(lower=0.0, upper=0.01)),
    )
    assert spec.transmission == TransmissionSpec(
        motors=("m1", "m2"), joint_per_motor=((0.5, 0), (-0.125, 0.25)), offset=(0, 0)
    )


def test_a_mass_set_replaces_what_it_gives() -> None:
    default, heavy = spec_from_toml(ARM), spec_from_toml(ARM, "heavy")
    assert default.mass_sets == heavy.mass_sets == ("default", "heavy")
    assert (default.mass_set, heavy.mass_set) == ("default", "heavy")
    assert one(heavy, "one") == replace(one(default, "one"), mass=2.0, source="scales")
    assert heavy.links[1:] == default.links[1:]
    written = spec_from_toml(spec_to_toml(heavy))
    assert written == replace(heavy, mass_set="default", mass_sets=("default",))


@given(robots())
def test_written_and_read_any_robot_is_the_same(spec: RobotSpec) -> None:
    assert spec_from_toml(spec_to_toml(spec)) == spec


def test_a_file_says_that_its_robot_is_for_a_level_base_only() -> None:
    spec = spec_from_toml(ARM)
    assert not spec.level_only
    assert "level_only" not in spec_to_toml(spec)
    marked = spec_from_toml(ARM.replace("format = 1", "format = 1\nlevel_only = true"))
    assert marked == replace(spec, level_only=True)
    assert spec_from_toml(spec_to_toml(marked), None).level_only
    with pytest.raises(ConfigError, match=r"line 2|:2: .*level_only.*got 1, expected true or false"):
        spec_from_toml(ARM.replace("format = 1", "format = 1\nlevel_only = 1"))
    with pytest.raises(ModelError, match="level_only: got 1, expected true or false"):
        spec_to_toml(replace(spec, level_only=1))  # type: ignore[arg-type]


@given(st.text(), st.text(), st.floats(-1e9, 1e9))
def test_any_text_and_any_float_survive(description: str, source: str, length: float) -> None:
    spec = spec_from_toml(ARM)
    link = replace(spec.links[0], source=source, placement=DhRow(a=length))
    spec = replace(spec, description=description, links=(link, *spec.links[1:]), mass_sets=("default",))
    assert spec_from_toml(spec_to_toml(spec)) == spec


def test_the_example_of_the_documentation_is_a_robot() -> None:
    text = dedent(toml_reader.__doc__.split("::\n")[1].split("\n\nFurther")[0])
    spec = spec_from_toml(text)
    assert (spec.name, spec.links[0].source) == ("one_link", "data sheet")


def test_a_mass_set_may_empty_or_fill_a_link() -> None:
    text = ARM.replace('mass = "2 kg"', "massless = true\nmass = 0\ninertia = [0, 0, 0, 0, 0, 0]")
    assert one(spec_from_toml(text, "heavy"), "one").massless
    text = ARM + "[mass_set.heavy.camera]\nmass = 0.1\n"
    assert one(spec_from_toml(text, "heavy"), "camera").mass == 0.1
    assert not one(spec_from_toml(text, "heavy"), "camera").massless


def test_text_and_file_say_the_same(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    spec = spec_from_toml(ARM)
    for data in (ARM.encode(), b"\xef\xbb\xbf" + ARM.encode(), ARM.replace("\n", "\r\n").encode()):
        path.write_bytes(data)
        assert spec_from_toml(path) == spec_from_toml(str(path)) == spec_for(path) == spec
    assert spec_from_toml(path).file == str(path)


def key_paths(value: object, path: tuple[str | int, ...] = ()) -> set[tuple[str | int, ...]]:
    """Every key and index of a parsed document."""
    if isinstance(value, dict):
        entries = list(value.items())
    else:
        entries = list(enumerate(value)) if isinstance(value, list) else []
    return {(*path, key) for key, _ in entries}.union(*(key_paths(entry, (*path, key)) for key, entry in entries))


@pytest.mark.parametrize("text", [ARM, *(bundled_path(name).read_text(encoding="utf-8") for name in bundled_names())])
def test_every_value_has_its_line(text: str) -> None:
    lines, found = text.split("\n"), line_numbers(text)
    assert set(found) == key_paths(tomllib.loads(text))
    for path, number in found.items():
        if isinstance(path[-1], str):
            assert path[-1] in lines[number - 1]


def test_lines_of_entries_in_arrays() -> None:
    found = line_numbers(ARM)
    numbers = [found["link", 1, "com", entry] for entry in range(3)]
    assert numbers == [numbers[0], numbers[0] + 1, numbers[0] + 2]
    assert found["base", "rotation", 2, 1] == found["base", "rotation"] + 3


BAD = [
    ("com = [0.1,", 'com = ["1 mm",', UnitsError, ["'two'", "com", "mixes"]),
    ("com = [0.1,", 'com = ["1 mm", "1 mm", "1 kg"]\nx = [', ConfigError, ["'two'", "unknown key 'x'"]),
    ("com = [0.1,", "com = [nan,", ConfigError, ["'two'", "com[0]", "nan", "finite"]),
    ('       0.2, # a comment, with [ and "\n', "", ConfigError, ["'two'", "com", "3 numbers"]),
    ('mass = "494 g"', 'mas = "494 g"', ConfigError, ["'one'", "unknown key 'mas'", "did you mean 'mass'"]),
    ('mass = "494 g"', 'mass = "494 gramm"', UnitsError, ["'one'", "mass", "unknown unit 'gramm'"]),
    ('mass = "494 g"', 'mass = "494 mm"', UnitsError, ["'one'", "is a length, expected a mass (kg)"]),
    ('mass = "494 g"', "mass = -1", ModelError, ["'one'", "mass", "-1.0", "0 or more"]),
    ('mass = "494 g"', "mass = 1e10", ModelError, ["'one'", "mass", "1e+09"]),
    ('mass = "494 g"', "mass = true", ConfigError, ["'one'", "mass", "True", "finite number"]),
    ('mass = "494 g"', "mass = inf", ConfigError, ["'one'", "mass", "inf"]),
    ('mass = "494 g"', "mass = 0", ModelError, ["'one'", "mass", "massless = true"]),
    ('mass = "494 g"', "mass = 1\nmassless = true", ModelError, ["'one'", "mass", "declared massless"]),
    ('mass = "494 g"', 'mass = 1\nmassless = "yes"', ConfigError, ["'one'", "massless", "true or false"]),
    ("0.02, 0, 0.001]", "0.02, 0, 0.05]", ModelError, ["'one'", "inertia", "principal moments 0.02, 0.02, 0.05"]),
    ("[0.02, 0, 0, 0.02, 0, 0.001]", "[0.02, 0.02, 0.001, 0, 0, 0]", ModelError, ["'one'", "order xx yy zz xy xz yz"]),
    ("[0.02, 0, 0, 0.02, 0, 0.001]", "[0.02, 0, 0.02]", ConfigError, ["'one'", "inertia", "6 numbers (inertia)"]),
    ("[0, 1, 0],", "[0, -1, 0],", ModelError, ["[base]: rotation", "mirror"]),
    ("[0, 1, 0],", "[0, 1.001, 0],", ModelError, ["[base]: rotation", "not orthonormal", "0.002"]),
    ("[0, 1, 0],", "[0, 1],", ConfigError, ["[base]: rotation", "three rows of three numbers"]),
    ("[0, 1, 0],", "0,", ConfigError, ["[base]: rotation", "row of numbers"]),
    ('upper = "90 deg"', 'upper = "-90 deg"', LimitError, ["'one'", "limits.lower", "0.0 is not below upper"]),
    ('upper = "90 deg"', "upper = 1.5", ConfigError, ["'one'", "limits", "both with a unit"]),
    ('upper = "90 deg"', 'uper = "1 deg"', ConfigError, ["'one'", "limits", "did you mean 'upper'"]),
    ('effort = "2 N*m"', 'effort = "2 N"', UnitsError, ["'one'", "effort", "is a force, expected a torque"]),
    ('effort = "2 N*m"', "effort = 0", LimitError, ["'one'", "limits.effort", "more than 0"]),
    ('joint = "prismatic"', 'joint = "prismtic"', ConfigError, ["'two'", "joint", "did you mean 'prismatic'"]),
    ('joint_name = "slide"', 'parent = "on"', ModelError, ["'two'", "parent", "did you mean 'one'"]),
    ('joint_name = "slide"', 'parent = "two"', ModelError, ["'two'", "parent", "cannot carry itself"]),
    ('joint_name = "slide"', 'parent = "camera"', ModelError, ["'two'", "parent", "comes later"]),
    ('name = "two"', 'name = "one"', ModelError, ["link 2", "name", "link 1 has it already"]),
    ('name = "two"', 'name = "tool"', ModelError, ["link 2", "name", "frame of this name"]),
    ('name = "two"', 'name = " "', ModelError, ["link 2", "name", "visible characters"]),
    ('name = "two"\n', "", ConfigError, ["link 2", "'name' is missing"]),
    ('alpha = "90 deg"', "alpha = 90", ModelError, ["'one'", "alpha: 90 rad is more than a turn", "90 deg are 1.5708"]),
    ("theta = 0.25", "theta = -45", ModelError, ["'one'", "theta: -45 rad is more than a turn", "are -0.785398"]),
    ('["0 deg", "90 deg", "0 deg"]', "[0, 90, 0]", ModelError, ["'camera'", "rpy[1]: 90 rad is more than a turn"]),
    ("translation = [0, 0, 1]", "a = 1\naxis = [0, 0, 1]", ConfigError, ["'camera'", "beside 'rpy'"]),
    ("translation = [0, 0, 1]", "axis = [0, 0, 0]", ModelError, ["'camera'", "axis", "no direction"]),
    ("translation = [0, 0, 1]", "rotation = [[1]]", ConfigError, ["'camera'", "either 'rotation' or 'rpy'"]),
    ('tip = "two"', 'tip = "too"', ModelError, ["[tool]: tip", "did you mean 'two'"]),
    ('["a", "b"]', '["a", "a"]', ModelError, ["coordinate", "'a' stands twice"]),
    ('["a", "b"]', "[]", ModelError, ["[coupling]: coordinates", "expected 1 to 2"]),
    ('["a", "b"]', "[1, 2]", ConfigError, ["[coupling]: coordinates[0]", "text in quotes"]),
    ("[[1, 0], [0, 0.5]]", "[[1, 0], [2, 0]]", ModelError, ["[coupling]: matrix", "linearly dependent"]),
    ("[[1, 0], [0, 0.5]]", "[[1, 0]]", ModelError, ["[coupling]: matrix", "1 rows of 2", "expected 2 rows of 2"]),
    ("offset = [0.1, 0.2]", "offset = [0.1]", ConfigError, ["[coupling]: offset", "2 numbers (angle, length)"]),
    ('{ lower = "0 m", upper = "10 mm" }', "{}, {}", ConfigError, ["[coupling]: limits", "one per coordinate"]),
    ('["m1", "m2"]', '["m1", "m1"]', ModelError, ["[transmission]: motors", "2 different names"]),
    ("[[2, 0], [1, 4]]", "[[2, 0], [1, 0]]", ModelError, ["[transmission]: motor_per_joint", "no inverse"]),
    ("[[2, 0], [1, 4]]", "[[2, 0]]", ConfigError, ["[transmission]: motor_per_joint", "2 rows of 2 numbers"]),
    ("motor_per_joint", "joint_per_motor = [[1, 0], [0, 1]]\nmotor_per_joint", ConfigError, ["exactly one of"]),
    ('mass = "2 kg"', "mass = -2", ModelError, ["'one'", "mass", "-2.0"]),
    ('mass = "2 kg"', "alpha = 2", ConfigError, ["heavy: one", "unknown key 'alpha'"]),
    ("heavy.one", "heavy.on", ConfigError, ["heavy: on", "did you mean 'one'"]),
    ("heavy.one", "default.one", ConfigError, ["default", "choose another name"]),
    ("format = 1", "format = 2", ConfigError, ["format", "got 2, expected 1"]),
    ('convention = "modified"', 'convention = "modifid"', ConfigError, ["convention", "did you mean 'modified'"]),
    ('convention = "modified"', 'convention = "frames"', ConfigError, ["'one'", "alpha", "convention 'frames'"]),
    ('name = "arm"', "name = 3", ConfigError, ["robot: name", "got 3, expected a text"]),
    ("[tool]", "[tol]", ConfigError, ["unknown key 'tol'", "did you mean 'tool'"]),
    ("[tool]", "[[tool]]", ConfigError, ["[tool]", "a table of keys and values"]),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "error", "words"), BAD)
def test_what_is_wrong_is_named_with_its_line(
    tmp_path: Path, old: str, new: str, error: type[RavenGCError], words: list[str]
) -> None:
    assert ARM.count(old) == 1 or old in {'convention = "modified"', "motor_per_joint"}
    path = tmp_path / "arm.toml"
    path.write_text(ARM.replace(old, new, 1))
    with pytest.raises(error) as caught:
        spec_from_toml(path)
    message = str(caught.value)
    assert type(caught.value) is error
    assert message.startswith(f"{path}:")
    assert [word for word in words if word not in message] == []


def test_the_line_named_is_the_line_changed(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    edits = {
        ('mass = "494 g"', "mass = -1"): "mass =",
        ("[0, 1, 0],", "[0, -1, 0],"): "rotation =",
        ("2 kg", "-2 kg"): "mass =",
    }
    for (old, new), start in edits.items():
        path.write_text(ARM.replace(old, new))
        with pytest.raises(ModelError) as caught:
            spec_from_toml(path)
        named = int(str(caught.value).removeprefix(f"{path}:").split(":")[0])
        assert named == ARM[: ARM.rindex(start, 0, ARM.index(old) + len(start))].count("\n") + 1


@pytest.mark.parametrize(
    ("data", "words", "line"),
    [
        (b"x = \n", "Invalid value", 1),
        (b'name = "a"\n\nname = "b"\n', "Cannot overwrite", 3),
        (b'a = """\n\n', "Unterminated", None),
        (b"a = 1\nb = \xff\n", "byte 0xff is not UTF-8", 2),
        (b"a = " + b"[" * 5000 + b"\n", "nested too deeply", None),
        (b"a" + b".a" * 200_000 + b" = 1\n", "more than 64 parts", 1),
        (b"a = " + b"9" * 5000 + b"\n", "not valid TOML", None),
        (b"#" * (8 * 1024 * 1024 + 1), "larger than 8 MiB", None),
    ],
)
def test_what_is_no_toml_is_a_parse_error(tmp_path: Path, data: bytes, words: str, line: int | None) -> None:
    path = tmp_path / "arm.toml"
    path.write_bytes(data)
    with pytest.raises(ParseError, match=words) as caught:
        spec_from_toml(path)
    assert caught.value.file == str(path)
    assert line is None or caught.value.line == line


@pytest.mark.parametrize("text", ["\n", "#" * (8 * 1024 * 1024) + "\n", "a = '\ud800'\n"])
def test_text_is_held_to_the_same_rules_as_a_file(text: str) -> None:
    with pytest.raises((ConfigError, ParseError), match="<text>"):
        spec_from_toml(text)


def test_a_path_that_cannot_be_read_is_a_parse_error(tmp_path: Path) -> None:
    for path in (tmp_path / "none.toml", tmp_path, "nul\0.toml"):
        with pytest.raises(ParseError, match="cannot be read"):
            spec_from_toml(path)


def test_an_unknown_robot_or_mass_set_is_told_the_near_ones() -> None:
    with pytest.raises(ConfigError, match=r"did you mean 'raven2_gold'\?.*'panda'"):
        spec_for("raven2_god")
    with pytest.raises(ConfigError, match=r"did you mean 'cad'\?.*'default', 'cad'"):
        spec_for("raven2_gold", "cda")
    for path in ("arm.yaml", "arm.urdf.xacro", "some/arm"):
        with pytest.raises(ConfigError, match=r"ends in \.toml or \.urdf"):
            spec_for(path)


def robot_or_none(text: str) -> RobotSpec | None:
    try:
        return spec_from_toml(text)
    except RavenGCError:
        return None


@given(damaged(ARM))
def test_any_damaged_text_is_a_robot_or_an_error_of_ours(text: str) -> None:
    spec = robot_or_none(text + "\n")
    assert spec is None or spec_from_toml(spec_to_toml(spec)) == replace(spec, mass_sets=("default",))


def test_any_truncated_text_is_a_robot_or_an_error_of_ours() -> None:
    outcomes = [robot_or_none(ARM[:end] + "\n") for end in range(len(ARM))]
    assert outcomes[0] is None
    assert any(outcomes)


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spec, path = spec_from_toml(ARM), tmp_path / "arm.toml"
    path.write_text("the old one")
    path.chmod(0o640)

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    for name in ("fsync", "replace"):
        with monkeypatch.context() as patch:
            patch.setattr(os, name, fail)
            with pytest.raises(ConfigError, match=r"arm\.toml: cannot be written: No space left"):
                write_toml(spec, path)
        assert path.read_text() == "the old one"
        assert list(tmp_path.iterdir()) == [path]
    write_toml(spec, path)
    assert spec_from_toml(path) == replace(spec, mass_sets=("default",))
    assert path.stat().st_mode & 0o777 == 0o640
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_to_a_file_stays_a_link(tmp_path: Path) -> None:
    real, link = tmp_path / "real.toml", tmp_path / "link.toml"
    real.write_text("")
    link.symlink_to(real)
    write_toml(spec_from_toml(ARM), link)
    assert link.is_symlink()
    assert real.read_text().startswith("# SI units")
