"""Theorems of mechanics for the compiled core as Python calls it: they hold whoever computes, so no numbers are needed.

Where a derivative is wanted it is a fourth-order difference; :mod:`bounds` says how large the terms are.
"""

from __future__ import annotations

import pickle
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc
from bounds import assert_close, bounds
from ravengc.config import bundled_names
from ravengc.spec import JointOrigin, LinkSpec, Pose
from strategies import ACCELERATION, PAYLOAD, POSE, SPIN, UNIT_VECTOR, Case, cases

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.reference import Payload
    from ravengc.spec import Vector

theorem = settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
DIFFERENCE = 1e-10
STEP = 3e-3
ANGLE = st.floats(-np.pi, np.pi)
JOINTS = st.tuples(ANGLE, ANGLE, st.floats(0.0, 0.5))
RATES = st.tuples(*[st.floats(-3.0, 3.0)] * 3)
NAMES = bundled_names()
RAVENS = ["raven2_gold", "raven2_green", "raven2_gold_wrist", "raven2_green_wrist"]
GEARED = [*RAVENS, "dvrk_mtml", "dvrk_mtmr", "dvrk_psm"]
HELD_AT_A_POINT = [*RAVENS, "dvrk_psm", "dvrk_ecm"]
REST = np.zeros(3)


def moving(f: np.ndarray, w: np.ndarray = REST, dw: np.ndarray = REST) -> ravengc.BaseMotion:
    return ravengc.BaseMotion(specific_force=f, angular_velocity=w, angular_acceleration=dw)


def slope(function: Callable[[float], Any], rate: float) -> np.ndarray:
    """Derivative at 0 of a function that changes in times of 1 / rate."""
    h = STEP / rate
    near, far = (np.subtract(function(k * h), function(-k * h)) for k in (1, 2))
    return (8.0 * near - far) / (12.0 * h)


def energy_slope(robot: ravengc.Robot, q: np.ndarray, g: np.ndarray) -> list[np.ndarray]:
    """∂U/∂q, joint by joint."""
    return [slope(lambda t, unit=unit: robot.potential_energy(q + t * unit, g), 1.0) for unit in np.eye(robot.n)]


@pytest.mark.parametrize("name", NAMES)
def test_gravity_torque_is_inverse_dynamics_at_rest_and_the_slope_of_energy(name: str) -> None:
    robot, rng = ravengc.load(name), np.random.default_rng(4)
    still = np.zeros(robot.n)
    for _ in range(5):
        q, g, other = rng.uniform(-2.0, 2.0, robot.n), *rng.normal(0.0, 10.0, (2, 3))
        scale = bounds(robot.spec, q, f=np.abs(g) + np.abs(other)).torque
        tau = robot.gravity_torque(q, g)
        assert_close(robot.inverse_dynamics(q, still, still, ravengc.Gravity(*g)), tau, scale)
        assert_close(energy_slope(robot, q, g), tau, scale, DIFFERENCE)
        assert_close(robot.gravity_torque(q, 2.0 * g - other), 2.0 * tau - robot.gravity_torque(q, other), 3.0 * scale)
        assert not robot.gravity_torque(q, REST).any()


@pytest.mark.parametrize("name", NAMES)
def test_the_jacobian_is_the_slope_of_the_pose(name: str) -> None:
    robot, rng = ravengc.load(name), np.random.default_rng(5)
    for frame in robot.frame_names:
        q, qd = rng.uniform(-2.0, 2.0, (2, robot.n))
        scale, rate = bounds(robot.spec, q), 1.0 + np.abs(qd).sum()
        turn = robot.forward_kinematics(q, frame)[:3, :3]
        change = slope(lambda t: robot.forward_kinematics(q + t * qd, frame), rate)  # noqa: B023
        spin = change[:3, :3] @ turn.T  # S(w) = dR/dt Rᵀ
        twist = np.array([*change[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])
        assert_close(robot.jacobian(q, frame) @ qd, twist, scale.jacobian * rate, DIFFERENCE)
        own = np.concatenate([turn.T @ twist[:3], turn.T @ twist[3:]])
        assert_close(robot.jacobian(q, frame, "frame") @ qd, own, scale.jacobian * rate, DIFFERENCE)


@theorem
@given(cases(most=7), PAYLOAD)
def test_torques_are_linear_in_the_masses(case: Case, payload: Payload) -> None:
    robot = ravengc.Robot(case.spec)
    robot.set_payload(*payload)
    scale, parameters = bounds(case.spec, *case.motion, payload).torque, robot.inertial_parameters()
    q, qd, qdd, *base = case.motion
    full = robot.inverse_dynamics_regressor(q, qd, qdd, moving(*base))
    assert_close(full @ parameters, robot.inverse_dynamics(q, qd, qdd, moving(*base)), scale)
    first_moments = parameters.reshape(-1, 10)[:, :4].ravel()
    assert_close(robot.gravity_regressor(q, case.g) @ first_moments, robot.gravity_torque(q, case.g), scale)


@theorem
@given(cases(), PAYLOAD)
def test_a_payload_is_one_more_link_fixed_to_the_tool(case: Case, payload: Payload) -> None:
    mass, com, inertia = payload
    end = case.spec.tip or case.spec.links[-1].name
    place = JointOrigin(pose=case.spec.tool)
    held = LinkSpec(name="held", joint="fixed", parent=end, placement=place, mass=mass, com=com, inertia=inertia)
    longer = ravengc.Robot(replace(case.spec, links=(*case.spec.links, held)))
    loaded = ravengc.Robot(case.spec)
    loaded.set_payload(*payload)
    scale = bounds(case.spec, *case.motion, payload)
    q, qd, qdd, *base = case.motion
    for name, bound in (("inverse_dynamics", scale.torque), ("base_wrench", scale.moment)):
        one, other = (getattr(robot, name)(q, qd, qdd, moving(*base)) for robot in (longer, loaded))
        assert_close(one, other, bound)
    assert_close(longer.gravity_torque(q, case.g), loaded.gravity_torque(q, case.g), scale.torque)
    assert_close(longer.mass_matrix(q), loaded.mass_matrix(q), scale.mass_matrix)
    assert_close(longer.center_of_mass(q), loaded.center_of_mass(q), scale.lever)


@theorem
@given(cases(coupled=False, most=15), st.sampled_from(("revolute", "prismatic")), POSE, UNIT_VECTOR, POSE, RATES)
def test_a_rocking_base_is_one_more_joint_that_nobody_commands(
    case: Case, kind: str, pivot: Pose, axis: Vector, mount: Pose, rocking: tuple[float, ...]
) -> None:
    """A massless joint under the arm, on a floor that moves: the arm feels the motion of its base, and the joint what
    the mount exerts.
    """
    below = [
        LinkSpec(name="rocker", joint=kind, placement=JointOrigin(pose=pivot, axis=axis), massless=True),
        LinkSpec(name="B", parent="rocker", joint="fixed", placement=JointOrigin(pose=mount), massless=True),
        LinkSpec(name="0", parent="B", joint="fixed", placement=JointOrigin(pose=case.spec.base), massless=True),
    ]
    arm = [replace(link, parent=link.parent or "0") for link in case.spec.links]
    spec = replace(case.spec, links=(*below, *arm), tip=case.spec.tip or arm[-1].name, base=Pose())
    whole, alone = ravengc.Robot(spec), ravengc.Robot(case.spec)
    _, v, a = rocking
    q, qd, qdd = ([first, *rest] for first, rest in zip(rocking, case.motion[:3], strict=True))
    f, w, dw = case.motion[3:]

    pose, twist = whole.forward_kinematics(q, "B"), whole.jacobian(q, "B")[:, 0]
    turn, r, linear, angular = pose[:3, :3], pose[:3, 3], twist[:3], twist[3:]
    relative = linear * a + np.cross(angular, linear) * v**2 + 2.0 * np.cross(w, linear) * v
    felt = f + np.cross(dw, r) + np.cross(w, np.cross(w, r)) + relative
    spun = dw + angular * a + np.cross(w, angular) * v
    base = moving(turn.T @ felt, turn.T @ (w + angular * v), turn.T @ spun)

    scale = bounds(spec, q, qd, qdd, f, w, dw).torque
    tau = whole.inverse_dynamics(q, qd, qdd, moving(f, w, dw))
    assert_close(alone.inverse_dynamics(*case.motion[:3], base), tau[1:], scale)
    wrench = alone.base_wrench(*case.motion[:3], base)
    assert_close(twist @ np.concatenate([turn @ wrench[:3], turn @ wrench[3:]]), tau[0], scale)


def floating_mass_matrix(robot: ravengc.Robot, q: np.ndarray) -> np.ndarray:
    """H(q), (6 + n) x (6 + n): the mount's wrench and the torques for each unit acceleration of base and joints."""
    still = np.zeros(robot.n)

    def column(unit: np.ndarray) -> np.ndarray:
        motion = q, still, unit[6:], moving(unit[:3], REST, unit[3:6])
        return np.concatenate([robot.base_wrench(*motion), robot.inverse_dynamics(*motion)])

    return np.transpose([column(unit) for unit in np.eye(6 + robot.n)])


@theorem
@given(cases(most=6), SPIN)
def test_joints_and_mount_together_pay_for_the_kinetic_energy(case: Case, v: np.ndarray) -> None:
    """dT/dt = tauᵀ qd + base power, T = yᵀ H y / 2, y = (v, w, qd) in base axes; gravity is part of ``f``."""
    robot = ravengc.Robot(case.spec)
    q, qd, qdd, f, w, dw = case.motion
    y, change = np.concatenate([v, w, qd]), np.concatenate([f - np.cross(w, v), dw, qdd])
    scale, speed = bounds(case.spec, q, qd, qdd, np.abs(f) + np.abs(v), w, dw), 1.0 + np.abs(y).sum()
    rate = scale.gain * (1.0 + np.abs(qd).sum())
    mass = floating_mass_matrix(robot, q)
    assert_close(mass, mass.T, scale.mass_matrix)
    mass_rate = slope(lambda t: floating_mass_matrix(robot, q + t * qd), rate)
    wrench, tau = (call(q, qd, qdd, moving(f, w, dw)) for call in (robot.base_wrench, robot.inverse_dynamics))
    power = wrench @ y[:6] + tau @ qd
    size = scale.torque * speed + scale.mass_matrix * speed**2 * rate
    assert_close(y @ mass @ change + y @ mass_rate @ y / 2.0, power, size, DIFFERENCE)


@pytest.mark.parametrize("mass_set", ["default", "cad"])
@theorem
@given(q=JOINTS, qd=RATES, qdd=RATES, f=ACCELERATION, w=SPIN, dw=SPIN)
def test_gold_and_green_mirror_each_other_in_motion(mass_set: str, q, qd, qdd, f, w, dw) -> None:
    """The mirror turns y of forces and accelerations, and x and z of moments and angular rates."""
    polar, axial = np.array((1.0, -1.0, 1.0)), np.array((-1.0, 1.0, -1.0))
    gold, green = (ravengc.load(f"raven2_{arm}", mass_set) for arm in ("gold", "green"))
    seen, mirrored = moving(f, w, dw), moving(polar * f, axial * w, axial * dw)
    scale = bounds(gold.spec, q, qd, qdd, f, w, dw)
    assert_close(gold.gravity_torque(q, f), green.gravity_torque(q, polar * f), scale.torque)
    motion = q, qd, qdd
    assert_close(gold.inverse_dynamics(*motion, seen), green.inverse_dynamics(*motion, mirrored), scale.torque)
    wrench = np.concatenate([polar, axial]) * green.base_wrench(*motion, mirrored)
    assert_close(gold.base_wrench(*motion, seen), wrench, scale.moment)
    assert_close(gold.mass_matrix(q), green.mass_matrix(q), scale.mass_matrix)
    twist = np.concatenate([polar, axial])[:, None] * green.jacobian(q)
    assert_close(gold.jacobian(q), twist, scale.jacobian)


@pytest.mark.parametrize("name", HELD_AT_A_POINT)
@theorem
@given(data=st.data())
def test_the_tool_axis_meets_the_remote_centre_at_rest_and_in_motion(name: str, data: st.DataObject) -> None:
    """The instrument's axis passes the origin of B, and what is there of the instrument moves along the axis only."""
    robot = ravengc.load(name)
    q = np.array([*data.draw(JOINTS), *data.draw(st.tuples(*[ANGLE] * (robot.n - 3)))])
    carriage = next(link.name for link in robot.spec.links if link.joint == "prismatic")
    pose, twist = robot.forward_kinematics(q, carriage), robot.jacobian(q, carriage)
    axis, place = pose[:3, 2], pose[:3, 3]
    scale = bounds(robot.spec, q).lever
    assert_close(np.cross(axis, place), REST, scale)
    at_centre = twist[:3] - np.cross(twist[3:], place, axis=0)
    assert_close(np.cross(axis, at_centre, axis=0), np.zeros((3, robot.n)), scale)
    assert_close(axis @ at_centre, np.eye(robot.n)[2], scale)


def assert_one_arm(one: ravengc.Robot, other: ravengc.Robot, frames: dict[str, str]) -> None:
    """Torques, mass matrices and the origins of ``frames`` (one's to the other's) agree on a moving base."""
    rng = np.random.default_rng(6)
    for _ in range(20):
        q, qd, qdd = rng.uniform(-2.0, 2.0, (3, one.n))
        f, w, dw = rng.normal(0.0, 5.0, (3, 3))
        scale = bounds(one.spec, q, qd, qdd, f, w, dw)
        tau, same = (robot.inverse_dynamics(q, qd, qdd, moving(f, w, dw)) for robot in (one, other))
        assert_close(tau, same, scale.torque)
        assert_close(one.gravity_torque(q, f), other.gravity_torque(q, f), scale.torque)
        assert_close(one.mass_matrix(q), other.mass_matrix(q), scale.mass_matrix)
        for frame, its in frames.items():
            places = one.forward_kinematics(q, frame)[:3, 3], other.forward_kinematics(q, its)[:3, 3]
            assert_close(*places, scale.lever)
            assert_close(one.jacobian(q, frame), other.jacobian(q, its), scale.jacobian)


@pytest.mark.parametrize("mass_set", ["default", "box"])
def test_the_two_tables_of_rrbot_are_one_arm(mass_set: str) -> None:
    one, other = (ravengc.load(name, mass_set) for name in ("rrbot", "rrbot_modified"))
    assert_one_arm(one, other, {"tool": "tool"})


RIGHT = np.pi / 2
MTM_MODIFIED = [
    {"theta": RIGHT},
    {"alpha": -RIGHT, "theta": -RIGHT},
    {"a": -0.2794, "theta": RIGHT},
    {"alpha": RIGHT, "a": -0.3645, "d": 0.1506},
    {"alpha": -RIGHT},
    {"alpha": RIGHT, "theta": RIGHT},
    {"alpha": RIGHT, "theta": RIGHT},
]
"""Modified DH of the same page as the bundled standard table ("Control Gravity Compensation", appendix I)."""


@pytest.mark.parametrize("name", ["dvrk_mtml", "dvrk_mtmr"])
def test_the_two_tables_of_the_masters_are_one_arm(name: str) -> None:
    """Their axes are the same; each centre of mass is carried from its frame to the other table's at q = 0."""
    one, zero = ravengc.load(name), np.zeros(7)
    table = ravengc.from_dh([{"a": 0.0, **row, "massless": True} for row in MTM_MODIFIED], "modified")
    rows = []
    for row, link, its in zip(MTM_MODIFIED, one.spec.links, table.spec.links, strict=True):
        frames = one.forward_kinematics(zero, link.name), table.forward_kinematics(zero, its.name)
        com = np.linalg.solve(frames[1], frames[0] @ [*link.com, 1.0])[:3]
        rows.append({**row, "mass": link.mass, "com": com, "massless": link.massless})
    assert_one_arm(one, ravengc.from_dh(rows, "modified"), {"wrist_platform": "link4", "wrist_roll": "link7"})


@pytest.mark.parametrize("name", GEARED)
def test_a_transmission_loses_no_power(name: str) -> None:
    robot, rng = ravengc.load(name), np.random.default_rng(9)
    for motors, rates, tau in rng.normal(size=(10, 3, robot.n)):
        q, ahead = robot.joint_positions(motors), robot.joint_positions(motors + rates)
        assert robot.actuator_torque(tau) @ rates == pytest.approx(tau @ (ahead - q), rel=1e-10, abs=1e-12)
        np.testing.assert_allclose(robot.motor_positions(q), motors, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(robot.joint_torque(robot.actuator_torque(tau)), tau, rtol=0.0, atol=1e-9)


def everything(robot: ravengc.Robot, case: Case) -> bytes:
    """Bits of all results for one motion."""
    q, qd, qdd, f, w, dw = case.motion
    base = moving(f, w, dw)
    results = [
        *(robot.forward_kinematics(q, frame) for frame in robot.frame_names),
        *chain.from_iterable(
            (robot.jacobian(q, frame), robot.jacobian(q, frame, "frame")) for frame in ("base", "tool")
        ),
        *(getattr(robot, name)(q, case.g) for name in ("gravity_torque", "gravity_stiffness", "potential_energy")),
        *(getattr(robot, name)(q, qd, qdd, base) for name in ("inverse_dynamics", "forward_dynamics", "base_wrench")),
        robot.inverse_dynamics_regressor(q, qd, qdd, base),
        robot.gravity_regressor(q, case.g),
        robot.mass_matrix(q),
        robot.center_of_mass(q),
    ]
    return b"".join(np.asarray(result).tobytes() for result in results)


@theorem
@given(cases(most=8), st.data(), PAYLOAD, POSE)
def test_the_same_inputs_give_the_same_bits(case: Case, data: st.DataObject, payload: Payload, moved: Pose) -> None:
    """Whatever was computed, loaded or moved in between, and for every copy of the robot."""
    robot = ravengc.Robot(case.spec)
    first = everything(robot, case)
    other = replace(case, q=case.qd, qd=case.q, f=case.dw, w=data.draw(SPIN))
    everything(robot, other)
    assert everything(robot, case) == first
    robot.set_payload(*payload)
    robot.set_base(moved.rotation, moved.translation)
    everything(robot, other)
    robot.clear_payload()
    robot.set_base(case.spec.base.rotation, case.spec.base.translation)
    assert everything(robot, case) == first
    for copy in (ravengc.Robot(case.spec), pickle.loads(pickle.dumps(robot)), ravengc.from_toml(robot.to_toml())):  # noqa: S301
        assert everything(copy, case) == first
