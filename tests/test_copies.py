"""Copies of a robot as it is now: base, tool and payload go with it, to the last bit, in memory, pickles and files."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
import threading
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ravengc as rg
from ravengc.config import bundled_names, spec_to_toml
from ravengc.errors import ConfigError, ModelError
from ravengc.robot import Payload
from robot_settings import HANGING, LOAD, TURNED, bits, change, moving, set_base, set_tool, settled, theorem, words
from strategies import POSE, Case, cases, robots

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from ravengc.spec import Pose, RobotSpec

IDENTITY = np.eye(3)


def pickled(protocol: int) -> Callable[[rg.Robot], rg.Robot]:
    return lambda robot: pickle.loads(pickle.dumps(robot, protocol))  # noqa: S301 -- our own pickle


WAYS = (copy.copy, copy.deepcopy, *map(pickled, range(pickle.HIGHEST_PROTOCOL + 1)))


# Copies


@theorem
@given(settled(), st.data())
def test_a_copy_is_the_robot_as_it_is(drawn: tuple[rg.Robot, Case], data: st.DataObject) -> None:
    robot, case = drawn
    expected, said = bits(robot, case), words(robot)
    for duplicate in WAYS:
        twin = duplicate(robot)
        assert type(twin) is rg.Robot
        assert twin.spec == robot.spec
        assert words(twin) == said
        assert bits(twin, case) == expected
        change(twin, data.draw)
        assert bits(duplicate(twin), case) == bits(twin, case)
    assert (words(robot), bits(robot, case)) == (said, expected)


@pytest.mark.parametrize("name", bundled_names())
@pytest.mark.parametrize("duplicate", WAYS)
def test_every_bundled_robot_is_copied(name: str, duplicate: Callable[[rg.Robot], rg.Robot]) -> None:
    """Among them robots with a coupling and with a transmission."""
    robot, plain = rg.load(name), rg.load(name)
    case = moving(robot.spec)
    set_tool(robot, TURNED)
    robot.set_payload(*LOAD)
    set_tool(robot, HANGING, robot.frame_names[1])
    set_base(robot, TURNED)
    twin = duplicate(robot)
    assert bits(twin, case) == bits(robot, case) != bits(plain, case)
    if robot.spec.transmission is not None:
        np.testing.assert_array_equal(twin.actuator_torque(case.q), plain.actuator_torque(case.q))


@pytest.mark.parametrize("duplicate", WAYS)
@pytest.mark.parametrize("name", ["panda", "dvrk_psm_si"])
def test_what_stands_on_the_base_is_copied(name: str, duplicate: Callable[[rg.Robot], rg.Robot]) -> None:
    """A payload on the base burdens the mount alone, and stays in B when frame 0 moves."""
    robot, plain = rg.load(name), rg.load(name)
    case = moving(robot.spec)
    set_tool(robot, TURNED, "base")
    robot.set_payload(*LOAD)
    for each in (robot, plain):
        set_base(each, HANGING)
    twin = duplicate(robot)
    assert bits(twin, case) == bits(robot, case)
    assert twin.tip == twin.payload.tip == "base"
    still, g = np.zeros(robot.n), rg.Gravity.level()
    held = [each.base_wrench(case.q, still, still, g)[2] for each in (twin, plain)]
    assert held[0] - held[1] == pytest.approx(1.5 * rg.STANDARD_GRAVITY)
    np.testing.assert_allclose(twin.forward_kinematics(case.q)[:3, 3], TURNED.translation)


def test_a_copy_is_another_robot() -> None:
    robot = rg.load("panda")
    q, g, out = np.linspace(0.0, 1.0, 7), np.array([1.0, 0.0, -9.0]), np.zeros(7)
    cycle, before = robot.bind(q=q, gravity=g, out=out), robot.gravity_torque(q, g)
    robot.set_payload(*LOAD)
    twin = copy.copy(robot)
    robot.clear_payload()
    cycle()
    np.testing.assert_array_equal(out, before)
    assert (robot.payload, twin.payload[:3]) == (None, LOAD)
    twin.bind(q=q, gravity=g, out=out)()
    np.testing.assert_array_equal(out, twin.gravity_torque(q, g))


class Named(rg.Robot):
    """A robot with more to it."""


@pytest.mark.parametrize("duplicate", WAYS)
def test_a_copy_is_of_the_same_class(duplicate: Callable[[rg.Robot], rg.Robot]) -> None:
    robot = Named(rg.load("rrbot").spec)
    robot.set_payload(*LOAD)
    assert type(duplicate(robot)) is Named
    assert words(duplicate(robot)) == words(robot)


ELSEWHERE = """
import pickle, sys
robot = pickle.loads(sys.stdin.buffer.read())
print(robot.gravity_torque(range(robot.n), (1.0, 2.0, -9.0)).tobytes().hex(), robot.payload.mass, robot.tip)
"""


def test_a_pickle_is_read_in_another_process() -> None:
    robot = rg.load("dvrk_psm_si")
    set_base(robot, TURNED)
    robot.set_payload(*LOAD)
    told = subprocess.run([sys.executable, "-c", ELSEWHERE], input=pickle.dumps(robot), check=True, capture_output=True)  # noqa: S603
    torque = robot.gravity_torque(range(robot.n), (1.0, 2.0, -9.0)).tobytes().hex()
    assert told.stdout.decode().split() == [torque, "1.5", robot.tip]


def test_a_copy_is_never_half_of_one_setting_and_half_of_another() -> None:
    robot = rg.load("rrbot")
    light = robot.__getstate__()
    set_tool(robot, TURNED)
    robot.set_payload(*LOAD)
    set_base(robot, HANGING)
    heavy, stop = robot.__getstate__(), threading.Event()

    def change_over() -> None:
        while not stop.is_set():
            robot.__setstate__(light)
            robot.__setstate__(heavy)

    thread = threading.Thread(target=change_over)
    thread.start()
    try:
        seen = [copy.copy(robot).__getstate__() for _ in range(300)]
    finally:
        stop.set()
        thread.join()
    assert all(state in (light, heavy) for state in seen)


# What a robot says of itself


@pytest.mark.parametrize("name", bundled_names())
def test_a_robot_begins_as_it_was_described(name: str) -> None:
    robot = rg.load(name)
    spec = robot.spec
    assert words(robot) == (spec.base, spec.tool, spec.tip or spec.links[-1].name, None)


def test_a_robot_says_what_it_was_given() -> None:
    """To the last digit, in the words of the setters."""
    robot = rg.load("panda")
    third = 1.0 / 3.0
    robot.set_payload(third, (third, -0.0, 0.7), (0.0,) * 6)
    assert robot.payload == Payload(third, (third, -0.0, 0.7), (0.0,) * 6, robot.spec.tool, "panda_link7")
    set_tool(robot, TURNED, "panda_link4")
    set_base(robot, HANGING)
    assert (robot.base, robot.tool, robot.tip) == (HANGING, TURNED, "panda_link4")
    assert (robot.payload.tool, robot.payload.tip) == (robot.spec.tool, "panda_link7")
    robot.set_payload(2, np.zeros(3))
    assert robot.payload == (2.0, (0.0,) * 3, (0.0,) * 6, TURNED, "panda_link4")
    robot.clear_payload()
    assert robot.payload is None
    set_tool(robot, robot.spec.tool)
    assert robot.tip == "panda_link7"


@pytest.mark.parametrize("name", ["base", "tool", "tip", "payload", "spec"])
def test_what_a_robot_says_is_not_assigned_to(name: str) -> None:
    robot = rg.load("rrbot")
    with pytest.raises(AttributeError):
        setattr(robot, name, getattr(robot, name))


@theorem
@given(cases(most=4), POSE, POSE)
def test_a_tool_is_moved_from_where_it_is(case: Case, first: Pose, second: Pose) -> None:
    robot = rg.Robot(case.spec)
    set_tool(robot, first)
    before, tip = robot.forward_kinematics(case.q), robot.tip
    set_tool(robot, second, "tool")
    step = np.vstack([np.column_stack([second.rotation, second.translation]), (0.0, 0.0, 0.0, 1.0)])
    np.testing.assert_allclose(robot.forward_kinematics(case.q), before @ step, atol=1e-14 * 20)
    assert robot.tip == tip
    assert bits(copy.copy(robot), case) == bits(robot, case)


def test_a_tool_that_has_lost_its_right_angles_is_refused() -> None:
    """Each step is a rotation to 1e-9; what many of them make must be one too, or no copy could be given it."""
    robot, step = rg.load("rrbot"), IDENTITY * (1.0 + 4e-10)
    robot.set_tool(step)
    before = words(robot)
    with pytest.raises(ModelError, match=r"tool is not a rotation: .* by 1\.6"):
        robot.set_tool(step, link="tool")
    assert words(robot) == before
    robot.set_tool(IDENTITY, (7.5e8, 0.0, 0.0))
    with pytest.raises(ModelError, match=r"tool: translation: got 1\.5e9, expected at most 1e9"):
        robot.set_tool(IDENTITY, (7.5e8, 0.0, 0.0), link="tool")
    assert robot.tool.translation == (7.5e8, 0.0, 0.0)


# Files


@theorem
@given(robots(most=6), st.data())
def test_a_file_holds_base_and_tool_of_now(spec: RobotSpec, data: st.DataObject) -> None:
    robot, case = rg.Robot(spec), moving(spec)
    assert robot.to_toml() == spec_to_toml(spec)
    robot.set_payload(*LOAD)
    set_base(robot, data.draw(POSE))
    set_tool(robot, data.draw(POSE), data.draw(st.sampled_from([link.name for link in spec.links])))
    robot.clear_payload()
    again = rg.from_toml(robot.to_toml())
    assert words(again) == words(robot)
    assert replace(again.spec, base=spec.base, tool=spec.tool, tip=spec.tip) == spec
    np.testing.assert_array_equal(again.inertial_parameters(), robot.inertial_parameters())
    q, still, g = case.q, np.zeros(robot.n), rg.Gravity(*case.g)
    np.testing.assert_array_equal(again.gravity_torque(q, g), robot.gravity_torque(q, g))
    np.testing.assert_array_equal(again.forward_kinematics(q), robot.forward_kinematics(q))
    np.testing.assert_array_equal(again.base_wrench(q, still, still, g), robot.base_wrench(q, still, still, g))


def test_a_file_leaves_nothing_out(tmp_path: Path) -> None:
    """A robot that a file cannot hold whole is not written."""
    robot, path = rg.load("rrbot"), tmp_path / "arm.toml"
    robot.set_payload(*LOAD)
    with pytest.raises(ConfigError, match=r"rrbot carries a payload of 1\.5 kg, .*; clear_payload\(\) takes it off"):
        robot.to_toml(path)
    robot.clear_payload()
    set_tool(robot, TURNED, "base")
    with pytest.raises(ConfigError, match=r"the tool of rrbot stands on 'base'.*set_tool\(\.\.\., link=NAME\) with"):
        robot.to_toml(path)
    assert not path.exists()
    set_tool(robot, robot.spec.tool, robot.spec.tip)
    assert robot.to_toml(path) == path.read_text(encoding="utf-8") == spec_to_toml(robot.spec)
