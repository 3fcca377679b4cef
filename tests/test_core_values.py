"""What goes with a call: gravity and base motion with their signs, frames, payload, base and tool, builds."""

from __future__ import annotations

import copy
import json
import math
import os
import pickle
import re
import subprocess
import sys
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import ravengc as rg
from core_calls import CALLS, LEVEL, ROCKING, VALUES, Call, N
from ravengc.errors import ArgumentError, ConfigError, ModelError

if TYPE_CHECKING:
    from collections.abc import Callable

Q, G = VALUES["q"], VALUES["gravity"]


# Gravity and base motion


def test_gravity_and_specific_force_are_opposite_views(panda: rg.Robot) -> None:
    g = (0.5, -1.0, -9.5)
    expected = panda.gravity_torque(Q, np.array(g))
    for same in (g, list(g), rg.Gravity(*g), rg.SpecificForce(-0.5, 1.0, 9.5), rg.Gravity(*g).as_specific_force()):
        np.testing.assert_array_equal(panda.gravity_torque(Q, same), expected)
        assert panda.potential_energy(Q, same) == panda.potential_energy(Q, g)
        np.testing.assert_array_equal(panda.gravity_stiffness(Q, same), panda.gravity_stiffness(Q, g))
    assert np.abs(panda.gravity_torque(Q, rg.SpecificForce(*g)) + expected).max() < 1e-12


def test_a_level_base(panda: rg.Robot) -> None:
    assert tuple(rg.Gravity.level()) == (0.0, 0.0, -rg.STANDARD_GRAVITY)
    assert tuple(rg.SpecificForce.level()) == (0.0, 0.0, rg.STANDARD_GRAVITY)
    assert rg.STANDARD_GRAVITY == 9.80665
    held = [panda.gravity_torque(Q, level) for level in (rg.Gravity.level(), rg.SpecificForce.level())]
    np.testing.assert_array_equal(*held)


@given(st.floats(-6.28, 6.28), st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3))
def test_a_tilted_base_feels_gravity_turned_the_other_way(angle: float, axis: list[float]) -> None:
    assume(np.linalg.norm(axis) > 1e-3)
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K
    np.testing.assert_allclose(tuple(rg.Gravity.tilted(angle, axis)), R.T @ tuple(rg.Gravity.level()), atol=1e-13)
    assert rg.SpecificForce.tilted(angle, axis).as_gravity() == rg.Gravity.tilted(angle, axis)


def test_axes_have_names_and_angles_are_no_degrees() -> None:
    for name, axis in zip("xyz", np.eye(3), strict=True):
        assert rg.Gravity.tilted(0.3, name) == rg.Gravity.tilted(0.3, axis)
    assert rg.Gravity.tilted(math.pi / 2, "x").y == pytest.approx(-rg.STANDARD_GRAVITY)
    for angle in (20.0, math.nan):
        with pytest.raises(ArgumentError, match="expected at most a turn"):
            rg.Gravity.tilted(angle, "x")
    with pytest.raises(ConfigError, match="axis is 'w'; choose 'x', 'y' or 'z'"):
        rg.Gravity.tilted(0.1, "w")  # type: ignore[arg-type]
    for axis in ((0.0, 0.0, 0.0), (math.nan, 0.0, 1.0), (math.inf, 0.0, 1.0)):
        with pytest.raises(ArgumentError, match="expected a direction"):
            rg.Gravity.tilted(0.1, axis)


def test_a_constant_cannot_be_bound(panda: rg.Robot) -> None:
    for constant, remedy in ((rg.Gravity.level(), "[*gravity]"), (rg.SpecificForce.level(), "as_gravity()]")):
        with pytest.raises(ArgumentError, match=f"never changes; .*{re.escape(remedy)}"):
            panda.bind(q=np.zeros(N), gravity=constant, out=np.zeros(N))  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", [rg.Gravity, rg.SpecificForce])
def test_vectors_with_a_sign_are_values(kind: type) -> None:
    one = kind(1.0, -2.0, 0.0)
    assert (one.x, one.y, one.z) == tuple(one) == (1.0, -2.0, 0.0)
    assert one == kind([1.0, -2.0, 0.0]) == kind(np.array([1, -2, 0]))
    with pytest.raises(ArgumentError, match="takes x, y and z"):
        kind(1.0, -2.0)
    assert one == kind(1.0, -2.0, -0.0)
    assert hash(one) == hash(kind(1.0, -2.0, -0.0))
    assert one != kind(1.0, -2.0, 1.0)
    assert rg.Gravity(1.0, -2.0, 0.0) != rg.SpecificForce(1.0, -2.0, 0.0)
    assert eval(repr(one), vars(rg)) == one  # noqa: S307 -- a repr is an expression
    assert pickle.loads(pickle.dumps(one)) == one  # noqa: S301 -- our own pickle
    assert copy.deepcopy(one) == one


def test_a_base_at_rest_is_a_gravity_vector(panda: rg.Robot) -> None:
    g = rg.Gravity(*LEVEL)
    bases = (
        g,
        g.as_specific_force(),
        rg.BaseMotion.at_rest(g),
        rg.BaseMotion.at_rest(LEVEL),
        rg.BaseMotion(specific_force=g),
        rg.BaseMotion(specific_force=(0.0, 0.0, 9.75)),
    )
    still = np.zeros(N)
    for base in bases:
        tau = panda.inverse_dynamics(Q, still, still, base)
        np.testing.assert_allclose(tau, panda.gravity_torque(Q, g), atol=1e-13)
    assert bases[2] == bases[3] == bases[4] == bases[5]


@pytest.mark.parametrize("bare", [(0.0, 0.0, 9.81), [0.0, 0.0, 9.81], np.zeros(3), None, "level"])
@pytest.mark.parametrize("call", [call for call in CALLS if "base" in call.inputs], ids=str)
def test_a_bare_vector_is_no_base(panda: rg.Robot, call: Call, bare: object) -> None:
    with pytest.raises(ArgumentError, match=r"base is a .*expected a BaseMotion, a Gravity or a SpecificForce"):
        call(panda, base=bare)


@pytest.mark.parametrize("value", [ROCKING, rg.Mounting(np.diag([1.0, -1.0, -1.0]), (0.5, 0.25, 1.0))])
@pytest.mark.parametrize("duplicate", [lambda value: pickle.loads(pickle.dumps(value)), copy.deepcopy])  # noqa: S301
def test_what_a_sensor_says_is_copied_as_it_is(value: object, duplicate: Callable[[object], object]) -> None:
    assert duplicate(value) == value
    assert repr(duplicate(value)) == repr(value)


def test_a_base_motion_says_what_it_is() -> None:
    base = rg.BaseMotion(specific_force=(1, 2, 3), angular_velocity=[4, 5, 6], angular_acceleration=np.array([7, 8, 9]))
    assert tuple(base.specific_force) == (1.0, 2.0, 3.0)
    assert isinstance(base.specific_force, rg.SpecificForce)
    assert base.angular_velocity == (4.0, 5.0, 6.0)
    assert base.angular_acceleration == (7.0, 8.0, 9.0)
    assert base != ROCKING
    assert "specific_force=(1.0, 2.0, 3.0)" in repr(base)
    with pytest.raises(ArgumentError, match=r"angular_velocity has shape \(2,\)"):
        rg.BaseMotion(specific_force=(1, 2, 3), angular_velocity=(1, 2))


def test_an_imu_sample_is_brought_to_the_base_origin() -> None:
    """A sensor turned half round about x at r = (0, 0, 2) on a base that spins about y."""
    w, dw, r = np.array([0.0, 3.0, 0.0]), np.array([0.0, 0.5, 0.0]), np.array([0.0, 0.0, 2.0])
    turned = np.diag([1.0, -1.0, -1.0])
    there = np.array([0.0, 0.0, 9.75]) + np.cross(dw, r) + np.cross(w, np.cross(w, r))
    base = rg.BaseMotion.from_imu(
        specific_force=turned @ there,
        angular_velocity=turned @ w,
        angular_acceleration=turned @ dw,
        mounting=rg.Mounting(turned, position=r),
    )
    np.testing.assert_allclose(tuple(base.specific_force), (0.0, 0.0, 9.75), atol=1e-14)
    assert (base.angular_velocity, base.angular_acceleration) == (tuple(w), tuple(dw))
    assert rg.BaseMotion.from_imu(specific_force=(1, 2, 3)) == rg.BaseMotion(specific_force=(1, 2, 3))


def test_a_mirrored_mounting_is_refused() -> None:
    with pytest.raises(ModelError, match=r"mirror \(determinant -1\)"):
        rg.Mounting(np.diag([1.0, 1.0, -1.0]))


# Frames, payload, base, tool, transmission


@pytest.mark.parametrize("function", ["forward_kinematics", "jacobian"])
def test_an_unknown_frame_lists_the_known_ones(panda: rg.Robot, function: str) -> None:
    with pytest.raises(ArgumentError) as refused:
        getattr(panda, function)(Q, frame="gripper")
    assert "no frame 'gripper' in panda" in str(refused.value)
    assert ", ".join(panda.frame_names) in str(refused.value)


def test_unknown_axes_list_the_known_ones(panda: rg.Robot) -> None:
    with pytest.raises(ArgumentError, match="axes is 'world'; expected 'base' or 'frame'"):
        panda.jacobian(Q, axes="world")


def test_a_payload_counts_until_it_is_taken_off(robot: rg.Robot) -> None:
    before, parameters = robot.gravity_torque(Q, G), robot.inertial_parameters()
    robot.set_payload(2.0, (0.0, 0.0, 0.1), (0.01, 0.0, 0.0, 0.01, 0.0, 0.01))
    assert robot.inertial_parameters()[-10] == parameters[-10] + 2.0
    moment = robot.jacobian(Q)[:3].T @ (-2.0 * G)
    lever = robot.jacobian(Q)[3:].T @ np.cross(robot.forward_kinematics(Q)[:3, 2] * 0.1, -2.0 * G)
    np.testing.assert_allclose(robot.gravity_torque(Q, G), before + moment + lever, atol=1e-12)
    robot.clear_payload()
    np.testing.assert_array_equal(robot.gravity_torque(Q, G), before)


def test_a_base_turns_gravity_and_moves_the_tool(robot: rg.Robot) -> None:
    turned, pose = np.diag([1.0, -1.0, -1.0]), robot.forward_kinematics(Q)
    expected = robot.gravity_torque(Q, turned.T @ G)
    robot.set_base(turned, (1.0, 2.0, 3.0))
    np.testing.assert_allclose(robot.gravity_torque(Q, G), expected, atol=1e-12)
    np.testing.assert_allclose(robot.forward_kinematics(Q)[:3, 3], turned @ pose[:3, 3] + (1, 2, 3), atol=1e-14)


def test_a_tool_on_any_link(robot: rg.Robot) -> None:
    link = robot.frame_names[3]
    robot.set_tool(np.eye(3), (0.0, 0.0, 0.5), link=link)
    expected = robot.forward_kinematics(Q, link) @ [0.0, 0.0, 0.5, 1.0]
    np.testing.assert_allclose(robot.forward_kinematics(Q)[:, 3], expected, atol=1e-14)


@pytest.mark.parametrize(
    ("change", "error", "problem"),
    [
        (lambda robot: robot.set_payload(-1.0, (0, 0, 0)), ModelError, "payload: mass is -1 kg"),
        (lambda robot: robot.set_payload(np.nan, (0, 0, 0)), ModelError, "payload: mass is not finite"),
        (lambda robot: robot.set_payload(1.0, (0, np.inf, 0)), ModelError, "payload: com"),
        (lambda robot: robot.set_payload(1.0, (0, 0)), ArgumentError, "com has shape"),
        (lambda robot: robot.set_payload(1.0, (0, 0, 0), [1, 0, 0, 1, 0]), ArgumentError, "inertia has shape"),
        (lambda robot: robot.set_payload(1.0, (0, 0, 0), [1, 0, 0, 1, 0, 3]), ModelError, "belong to no body"),
        (lambda robot: robot.set_payload(0.0, (0, 0, 0), [1, 0, 0, 1, 0, 1]), ModelError, "inertia without mass"),
        (lambda robot: robot.set_base(np.diag([1, 1, -1])), ModelError, "base is a mirror"),
        (lambda robot: robot.set_base(2 * np.eye(3)), ModelError, "base is not a rotation"),
        (lambda robot: robot.set_base(np.eye(4)), ArgumentError, "rotation has shape"),
        (lambda robot: robot.set_base(np.eye(3), (0, 0, np.nan)), ModelError, "base is not finite"),
        (lambda robot: robot.set_tool(np.eye(3), (0, 0)), ArgumentError, "translation has shape"),
        (lambda robot: robot.set_tool(np.full((3, 3), np.nan)), ModelError, "tool is not finite"),
        (lambda robot: robot.set_tool(np.eye(3), link="gripper"), ArgumentError, "no frame 'gripper'"),
    ],
)
def test_an_impossible_change_is_refused_and_changes_nothing(
    robot: rg.Robot, change: Callable[[rg.Robot], None], error: type[Exception], problem: str
) -> None:
    before = robot.gravity_torque(Q, G), robot.forward_kinematics(Q)
    with pytest.raises(error, match=problem):
        change(robot)
    np.testing.assert_array_equal(robot.gravity_torque(Q, G), before[0])
    np.testing.assert_array_equal(robot.forward_kinematics(Q), before[1])


def test_motors_and_coordinates() -> None:
    raven = rg.load("raven2_gold")
    m, tau = np.array([0.5, -0.25, 0.125]), np.array([3.0, -2.0, 1.0])
    q = raven.joint_positions(m)
    np.testing.assert_allclose(raven.motor_positions(q), m, atol=1e-13)
    tau_motor = raven.actuator_torque(tau)
    np.testing.assert_allclose(raven.joint_torque(tau_motor), tau, atol=1e-13)
    np.testing.assert_allclose(tau_motor @ m, tau @ (q - raven.joint_positions(np.zeros(3))), atol=1e-13)
    out = np.zeros(3)
    assert raven.actuator_torque(tau, out=out) is out
    with pytest.raises(ArgumentError, match="out shares memory"):
        raven.actuator_torque(tau, out=tau)
    with pytest.raises(ArgumentError, match=r"motors has shape \(2,\)"):
        raven.joint_positions([0.0, 1.0])


def test_without_a_transmission_there_are_no_motors(panda: rg.Robot) -> None:
    with pytest.raises(ConfigError, match=r"panda has no transmission; give its file a \[transmission\] table"):
        panda.actuator_torque(Q)


# Builds


PORTABLE = """
import json, numpy as np, ravengc as rg
from core_calls import CALLS
robot = rg.load("panda")
print(json.dumps([rg.INSTRUCTIONS, {call.name: call(robot).tolist() for call in CALLS}]))
"""


def results_at(level: str) -> tuple[str, dict[str, list[float]]]:
    """The instructions in use and all results in a process that is told to use no more than ``level``."""
    folder = os.path.dirname(__file__)  # noqa: PTH120 -- an environment variable is text
    environment = {**os.environ, "RAVENGC_LEVEL": level, "PYTHONPATH": folder}
    command = [sys.executable, "-c", PORTABLE]
    result = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)  # noqa: S603
    return tuple(json.loads(result.stdout))


@pytest.mark.parametrize("level", ["portable", "avx2"])
def test_lower_builds_agree(panda: rg.Robot, level: str) -> None:
    name, results = results_at(level)
    assert name in {level, "portable"}
    for call in CALLS:
        expected = call(panda)
        np.testing.assert_allclose(results[call.name], expected, rtol=0, atol=1e-13 * max(1.0, np.abs(expected).max()))
