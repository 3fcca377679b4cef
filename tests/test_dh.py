"""Robots from DH rows: the same as from TOML, the same errors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc
from ravengc.config import spec_from_dh, spec_from_toml, spec_to_toml
from ravengc.errors import ConfigError, ModelError, UnitsError
from ravengc.spec import CouplingSpec, DhRow, Pose, TransmissionSpec

if TYPE_CHECKING:
    from ravengc.errors import RavenGCError

ROW = {"alpha": 0.0, "a": 0.0, "d": 0.333, "theta": 0.0, "mass": 4.97}


def test_dh_rows_and_toml_say_the_same() -> None:
    rows = [
        dict(ROW, joint="revolute", com=(0.0, 0.1, 0.0), inertia=np.array([0.1, 0, 0, 0.1, 0, 0.1])),
        dict(ROW, joint="prismatic", name="slide", d="10 mm", limits={"lower": 0.0, "upper": np.float64(0.2)}),
        dict(ROW, parent="link1", mass=np.float32(0.5)),
    ]
    spec = spec_from_dh(rows, "standard", name="three", source="here", tip="slide")
    assert [link.name for link in spec.links] == ["link1", "slide", "link3"]
    assert [link.parent for link in spec.links] == [None, "link1", "link1"]
    assert spec.links[1].placement == DhRow(d=0.01)
    assert spec_from_toml(spec_to_toml(spec)) == spec


@pytest.mark.parametrize(
    ("rows", "error", "words"),
    [
        ([], ModelError, "0 moving links"),
        ([ROW] * 17, ModelError, "17 moving links"),
        ([dict(ROW, joint="fixed")], ModelError, "0 moving links"),
        ([dict(ROW, com=(0, 0))], ConfigError, "row 1: com: got (0, 0), expected 3 numbers"),
        ([dict(ROW, com=np.zeros((3, 3)))], ConfigError, "row 1: com[0]"),
        ([ROW, dict(ROW, alhpa=0)], ConfigError, "row 2: unknown key 'alhpa'; did you mean 'alpha'?"),
        ([dict(ROW, mass=None)], ConfigError, "row 1: mass: got None"),
        ([dict(ROW, mass=10**400)], UnitsError, "row 1: mass"),
        ([dict(ROW, alpha=math.nan)], ConfigError, "row 1: alpha: got nan"),
        ([dict(ROW, alpha=90)], ModelError, "alpha: 90 rad is more than a turn; angles without a unit are in rad"),
        ([dict(ROW, joint=1)], ConfigError, "row 1: joint: got 1"),
        ([{1: 2}], ConfigError, "row 1: unknown key 1"),
        ([3], ConfigError, "row 1: got 3"),
        ("rows", ConfigError, "expected a list of dicts"),
        (np.zeros((2, 4)), ConfigError, "0.], [0., 0., 0., 0.]]), expected a list of dicts, one per link, such as {"),
    ],
)
def test_bad_dh_rows_are_named(rows: list[dict[str, object]], error: type[RavenGCError], words: str) -> None:
    with pytest.raises(error) as caught:
        spec_from_dh(rows, "modified")
    assert words in str(caught.value)


def test_a_convention_is_standard_or_modified() -> None:
    with pytest.raises(ConfigError, match="did you mean 'modified'"):
        spec_from_dh([ROW], "Modified")  # type: ignore[arg-type]


def test_what_belongs_to_the_whole_robot_is_passed_on() -> None:
    given = {
        "name": "pair",
        "base": Pose(rotation=((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), translation=(0.0, 0.0, 0.5)),
        "tool": Pose(translation=(0.1, 0.0, 0.0)),
        "tip": "link1",
        "coupling": CouplingSpec(coordinates=("both",), matrix=((1.0,), (-1.0,)), offset=(0.0, 0.0)),
        "transmission": TransmissionSpec(motors=("m",), joint_per_motor=((0.01,),), offset=(0.0,)),
        "description": "two links",
        "source": "a table",
    }
    robot = ravengc.from_dh([ROW, ROW], "modified", **given)
    assert {name: getattr(robot.spec, name) for name in given} == given
    assert robot.spec == spec_from_dh([ROW, ROW], "modified", **given)
    assert robot.n == 1


@pytest.mark.parametrize("name", ["base", "tool", "coupling", "transmission", "tip", "name", "source"])
def test_parts_of_another_kind_are_refused(name: str) -> None:
    with pytest.raises(ModelError, match=f"{name}: got 5, expected a"):
        ravengc.from_dh([ROW, ROW], "modified", **{name: 5})
