"""What an error suggests: the name that was meant, all of them where several begin so, and none where none is near."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from ravengc.errors import ConfigError, ParseError
from ravengc.messages import did_you_mean, kind_of, shown

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize(
    ("word", "options", "expected"),
    [
        ("roll", ("pitch", "roll_hz", "roll_deg"), "; did you mean 'roll_hz' or 'roll_deg'?"),
        ("mas", ("mass", "com"), "; did you mean 'mass'?"),
        ("degs", ("deg", "deg/s", "rad"), "; did you mean 'deg'?"),
        ("Panda", ("panda", "ur5"), "; did you mean 'panda'?"),
        ("joint9", tuple(f"joint{i}" for i in range(9)), "; did you mean 'joint8'?"),
        ("arm", ("arm1", "arm2", "arm3", "arm4", "arm5"), "; did you mean 'arm5'?"),
        ("a", ("alpha", "axis"), ""),
        ("tool", ("mass",), ""),
        ("", ("mass",), ""),
        (7, ("7",), ""),
    ],
)
def test_the_name_that_was_meant_is_suggested(word: object, options: tuple[str, ...], expected: str) -> None:
    assert did_you_mean(word, options) == expected


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("ur", "did you mean 'ur10' or 'ur5'? (bundled: "),
        ("franka", "did you mean 'panda' (Franka Emika Panda)? (bundled: "),
        ("kuka", "there is no robot 'kuka' (bundled: "),
        ("dvrk", "did you mean 'dvrk_"),
        ("", "there is no robot '' (bundled: "),
    ],
)
def test_a_robot_is_suggested_by_its_name_or_its_maker(name: str, words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        rg.load(name)
    assert words in str(caught.value)


def test_the_file_that_was_meant_is_suggested(tmp_path: Path) -> None:
    (tmp_path / "my_arm.urdf").touch()
    with pytest.raises(ParseError, match=r"myarm\.urdf: cannot be read: .*; did you mean 'my_arm\.urdf'\?$"):
        rg.load(tmp_path / "myarm.urdf")
    with pytest.raises(ParseError, match=r"arm\.toml: cannot be read: [^;]*$"):
        rg.load(tmp_path / "nowhere" / "arm.toml")


def test_kinds_have_their_article() -> None:
    assert [kind_of(value) for value in ("", 1, ())] == ["a str", "an int", "a tuple"]


def test_a_value_is_shown_on_one_line() -> None:
    assert shown(np.eye(2)) == "array([[1., 0.], [0., 1.]])"
    assert shown("two\n  lines") == r"'two\n  lines'"
