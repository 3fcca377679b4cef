"""Pickles that no robot made become a robot, or an error that says what is wrong, and nothing in between."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc.errors import ArgumentError, ModelError, RavenGCError
from robot_settings import LOAD, bits, moving, words

IDENTITY = np.eye(3)


def state() -> dict[str, Any]:
    robot = rg.load("rrbot")
    robot.set_payload(*LOAD)
    return robot.__getstate__()


def but(**changes: object) -> dict[str, Any]:
    return {**state(), **changes}


def carrying(**changes: object) -> dict[str, Any]:
    return but(payload={**state()["payload"], **changes})


SKEWED = {"rotation": ((1.0, 0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), "translation": (0.0, 0.0, 0.0)}
FAR = {"rotation": tuple(map(tuple, IDENTITY.tolist())), "translation": (0.0, 0.0, 1e10)}


@pytest.mark.parametrize(
    ("garbage", "error", "problem"),
    [
        (None, ArgumentError, "state of rrbot: .*NoneType.*expected base, tool, tip and payload as __getstate__ of"),
        (b"abc", ArgumentError, "state of rrbot"),
        ([], ArgumentError, "state of rrbot"),
        ({}, ArgumentError, "state of rrbot: KeyError: 'base'"),
        (but(base=None), ArgumentError, r"field State\.base: .*NoneType"),
        (but(base={"rotation": "no", "translation": (0, 0, 0)}), ArgumentError, r"PoseState\.rotation"),
        (but(tool={"rotation": ((1, 0), (0, 1)), "translation": (0, 0, 0)}), ArgumentError, r"PoseState\.rotation"),
        (but(tool={"rotation": IDENTITY, "translation": (0, 0)}), ArgumentError, r"PoseState\.translation"),
        (but(tip=3), ArgumentError, r"State\.tip"),
        (but(tip="\ud800"), ArgumentError, r"State\.tip: UnicodeEncodeError"),
        (but(tip="gripper"), ArgumentError, r"no frame 'gripper' in rrbot \(there are base, "),
        (but(tip="tool"), ArgumentError, "tip is 'tool'; a tool frame stands on a link or on 'base'"),
        (but(payload=0), ArgumentError, r"State\.payload"),
        (but(base=SKEWED), ModelError, "base is not a rotation"),
        (but(tool=SKEWED), ModelError, "tool is not a rotation"),
        (but(base=FAR), ModelError, "base: translation: got 1e10"),
        (but(tool={**FAR, "translation": (np.nan, 0, 0)}), ModelError, "tool is not finite"),
        (carrying(mass=10**400), ArgumentError, r"PayloadState\.mass: OverflowError"),
        (carrying(mass=-1.0), ModelError, "payload: mass is -1 kg"),
        (carrying(com=(np.inf, 0, 0)), ModelError, "payload: com: got inf"),
        (carrying(inertia=(1, 0, 0, 1, 0, 3)), ModelError, "belong to no body"),
        (carrying(tool=SKEWED), ModelError, "payload's tool is not a rotation"),
        (carrying(tip="gripper"), ArgumentError, "no frame 'gripper'"),
    ],
)
def test_garbage_is_refused_and_changes_nothing(garbage: object, error: type[Exception], problem: str) -> None:
    robot = rg.load("rrbot")
    case, before = moving(robot.spec), words(robot)
    expected = bits(robot, case)
    with pytest.raises(error, match=problem):
        robot.__setstate__(garbage)
    assert (words(robot), bits(robot, case)) == (before, expected)


class Forged:
    """Pickles as a robot of this description in this state."""

    def __init__(self, spec: object, forged: object) -> None:
        self.parts = rg.Robot, (spec,), forged

    def __reduce__(self) -> tuple[object, ...]:
        return self.parts


def test_a_pickle_for_another_robot_is_refused() -> None:
    panda, rrbot = rg.load("panda"), rg.load("rrbot")
    forged = pickle.dumps(Forged(panda.spec, rrbot.__getstate__()))
    with pytest.raises(ArgumentError, match=r"no frame '.*' in panda"):
        pickle.loads(forged)  # noqa: S301 -- our own pickle


def test_a_pickle_without_a_state_is_the_robot_as_described() -> None:
    robot = rg.load("panda")
    again = pickle.loads(pickle.dumps(Forged(robot.spec, None)))  # noqa: S301 -- our own pickle
    assert words(again) == words(robot)


NUMBER = st.floats() | st.integers(-(2**70), 2**70)
SCRAP = (
    st.none() | st.booleans() | NUMBER | st.text(max_size=3) | st.binary(max_size=3) | st.sampled_from(("base", "tool"))
)
JUNK = st.recursive(
    SCRAP,
    lambda inner: (
        st.lists(inner, max_size=6)
        | st.lists(inner, max_size=6).map(tuple)
        | st.dictionaries(st.sampled_from(("base", "tool", "tip", "payload", "rotation", "translation")), inner)
    ),
    max_leaves=12,
)


def with_junk(value: Any, draw: st.DrawFn) -> Any:
    """``value`` with something in it replaced by junk."""
    if isinstance(value, dict) and draw(st.integers(0, 5)):
        key = draw(st.sampled_from(sorted(value)))
        return {**value, key: with_junk(value[key], draw)}
    if isinstance(value, tuple) and draw(st.integers(0, 3)):
        index = draw(st.integers(0, len(value) - 1))
        return (*value[:index], with_junk(value[index], draw), *value[index + 1 :])
    return draw(JUNK)


@settings(max_examples=400, deadline=None)
@given(st.data())
def test_any_state_is_a_robots_or_refused(data: st.DataObject) -> None:
    forged = pickle.dumps(Forged(rg.load("rrbot").spec, with_junk(state(), data.draw)))
    try:
        robot = pickle.loads(forged)  # noqa: S301 -- our own pickle
    except RavenGCError:
        return
    case = moving(robot.spec)
    assert bits(copy.deepcopy(robot), case) == bits(robot, case)
