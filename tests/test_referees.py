"""The compiled core against libraries that others wrote, on random robots and moving bases.

The bar is 1e-10 of the result's size. The bounds of :mod:`bounds` are generous, often a hundred times that size, so two
results are called equal when they differ by less than 1e-13 of the bound: an error of 1e-10 in a centre of mass shows.
Robots are built for each library in a module ``referee_*`` of its own; a library that is not installed is not asked.
"""

from __future__ import annotations

import csv
import json
import warnings
from dataclasses import replace
from importlib import import_module
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc
from bounds import Bounds, assert_close, bounds
from ravengc.spec import Pose, RobotSpec
from strategies import ACCELERATION, KINDS, POSE, Case, cases, coordinates, links

if TYPE_CHECKING:
    from ravengc.spec import Convention

agreement = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
DATA = Path(__file__).parent / "data"
DH: tuple[Convention, ...] = ("standard", "modified")


def referee_for(library: str, minversion: str | None = None) -> Any:
    """The class that answers for a library; the test is skipped without the library."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what the libraries say on import is not ours to mend
        pytest.importorskip(library, minversion=minversion)
        return import_module(f"referee_{library.lower()}").Referee


@pytest.fixture(scope="module", params=["mujoco", "pinocchio"])
def referee(request: pytest.FixtureRequest) -> Any:
    return referee_for(request.param)


@pytest.fixture(scope="module")
def pinocchio() -> Any:
    return referee_for("pinocchio")


@pytest.fixture(scope="module")
def toolbox() -> Any:
    return referee_for("roboticstoolbox", "1.4.4")


@pytest.fixture(scope="module")
def kdl() -> Any:
    return referee_for("PyKDL")


def base_of(case: Case) -> ravengc.BaseMotion:
    return ravengc.BaseMotion(specific_force=case.f, angular_velocity=case.w, angular_acceleration=case.dw)


def size(case: Case) -> Bounds:
    """Bounds of the motion in a world of 11 m/s² or less along each axis, as the referees that move the base have."""
    q, qd, qdd, f, w, dw = case.motion
    return bounds(case.spec, q, qd, qdd, np.abs(f) + 11.0, w, dw)


@agreement
@given(case=cases(), data=st.data())
def test_poses_and_jacobians(referee: Any, case: Case, data: st.DataObject) -> None:
    robot, theirs, scale = ravengc.Robot(case.spec), referee(case.spec), size(case)
    for frame in ("tool", data.draw(st.sampled_from([link.name for link in case.spec.links]))):
        assert_close(robot.forward_kinematics(case.q, frame), theirs.forward_kinematics(case.q, frame), scale.lever)
        for axes in ("base", "frame"):
            assert_close(robot.jacobian(case.q, frame, axes), theirs.jacobian(case.q, frame, axes), scale.jacobian)
    assert_close(robot.center_of_mass(case.q), theirs.center_of_mass(case.q), scale.lever)


@agreement
@given(case=cases())
def test_gravity_and_mass_matrix(referee: Any, case: Case) -> None:
    robot, theirs, scale = ravengc.Robot(case.spec), referee(case.spec), size(case)
    assert_close(robot.gravity_torque(case.q, case.g), theirs.gravity_torque(case.q, case.g), scale.torque)
    assert_close(robot.mass_matrix(case.q), theirs.mass_matrix(case.q), scale.mass_matrix)


@agreement
@given(case=cases())
def test_inverse_dynamics_and_base_wrench_on_a_moving_base(referee: Any, case: Case) -> None:
    robot, theirs, scale = ravengc.Robot(case.spec), referee(case.spec), size(case)
    q, qd, qdd, *_ = case.motion
    assert_close(robot.inverse_dynamics(q, qd, qdd, base_of(case)), theirs.inverse_dynamics(*case.motion), scale.torque)
    assert_close(robot.base_wrench(q, qd, qdd, base_of(case)), theirs.base_wrench(*case.motion), scale.moment)


@agreement
@given(case=cases())
def test_pinocchio_energy_and_stiffness(pinocchio: Any, case: Case) -> None:
    robot, theirs, scale = ravengc.Robot(case.spec), pinocchio(case.spec), size(case)
    assert_close(robot.potential_energy(case.q, case.g), theirs.potential_energy(case.q, case.g), scale.moment)
    assert_close(robot.gravity_stiffness(case.q, case.g), theirs.gravity_stiffness(case.q, case.g), scale.stiffness)


@agreement
@given(case=cases())
def test_pinocchio_on_a_base_that_begins_to_turn(pinocchio: Any, case: Case) -> None:
    """Another route to the angular acceleration: the angular part of Pinocchio's gravity."""
    case = replace(case, w=np.zeros(3))
    q, qd, qdd, f, _, dw = case.motion
    tau = ravengc.Robot(case.spec).inverse_dynamics(q, qd, qdd, base_of(case))
    assert_close(tau, pinocchio(case.spec).inverse_dynamics_spun_up(q, qd, qdd, f, dw), size(case).torque)


@agreement
@given(case=cases(most=7))
def test_pinocchio_regressors_and_parameters(pinocchio: Any, case: Case) -> None:
    robot, theirs, scale = ravengc.Robot(case.spec), pinocchio(case.spec), size(case)
    q, qd, qdd, *_ = case.motion
    full = robot.inverse_dynamics_regressor(q, qd, qdd, base_of(case))
    assert_close(full, theirs.inverse_dynamics_regressor(*case.motion), scale.regressor)
    still = np.zeros_like(q)
    static = theirs.inverse_dynamics_regressor(q, still, still, case.f, np.zeros(3), np.zeros(3))
    masses = static.reshape(robot.n, -1, 10)[:, :, :4].reshape(robot.n, -1)
    assert_close(robot.gravity_regressor(q, case.g), masses, scale.regressor)
    parameters = scale.mass * scale.lever**2 + scale.inertia
    assert_close(robot.inertial_parameters(), theirs.inertial_parameters(), parameters)


@agreement
@given(case=cases(solid=True, coupled=False), data=st.data())
def test_pinocchio_forward_dynamics(pinocchio: Any, case: Case, data: st.DataObject) -> None:
    """Accelerations differ by what a rounding error of the torques makes of them: at most |M⁻¹| times it."""
    case = replace(case, w=np.zeros(3))
    robot, theirs = ravengc.Robot(case.spec), pinocchio(case.spec)
    q, qd, _, f, _, dw = case.motion
    tau = data.draw(coordinates(case.spec, 50.0))
    qdd = robot.forward_dynamics(q, qd, tau, base_of(case))
    scale = yielding(robot, q) * (size(replace(case, qdd=qdd)).torque + np.abs(tau).max())
    assert_close(qdd, theirs.forward_dynamics_spun_up(q, qd, tau, f, dw), scale)


@agreement
@given(case=cases(solid=True, coupled=False))
def test_torques_and_base_wrench_move_a_free_base_as_told(pinocchio: Any, case: Case) -> None:
    """Both together drive Pinocchio's free tree: base and joints then accelerate as the core was asked for."""
    robot, theirs = ravengc.Robot(case.spec), pinocchio(case.spec)
    q, qd, qdd, f, w, dw = case.motion
    tau, wrench = (function(q, qd, qdd, base_of(case)) for function in (robot.inverse_dynamics, robot.base_wrench))
    base, joints = theirs.accelerations(q, qd, tau, wrench, f, w, dw)
    scale = yielding(robot, q) * size(case).moment
    assert_close(joints, qdd, scale)
    assert_close(base, [*f, *dw], scale)


def yielding(robot: ravengc.Robot, q: np.ndarray) -> float:
    """The largest acceleration per torque, 1 at least."""
    return max(1.0, float(np.linalg.norm(np.linalg.inv(robot.mass_matrix(q)), 2)))


@st.composite
def dh_arms(draw: st.DrawFn, convention: Convention) -> Case:
    """A serial arm of DH rows without fixed links, in motion."""
    names = [f"link{i}" for i in range(draw(st.integers(1, 7)))]
    kinds = [draw(st.sampled_from(KINDS)) for _ in names]
    parents = [None, *names]
    rows = [
        draw(links(name, parent, kind, convention, solid=False, empty=False))
        for name, parent, kind in zip(names, parents, kinds, strict=False)
    ]
    spec = RobotSpec(name="arm", convention=convention, links=tuple(rows), base=draw(POSE), tool=draw(POSE))
    q, qd, qdd = (draw(coordinates(spec, size)) for size in (np.pi, 3.0, 10.0))
    return Case(spec, q, qd, qdd, draw(ACCELERATION), np.zeros(3), np.zeros(3))


@pytest.mark.parametrize("convention", DH)
@agreement
@given(data=st.data())
def test_robotics_toolbox(toolbox: Any, convention: Convention, data: st.DataObject) -> None:
    case = data.draw(dh_arms(convention))
    robot, theirs, scale = ravengc.Robot(case.spec), toolbox(case.spec), size(case)
    assert_close(robot.forward_kinematics(case.q), theirs.forward_kinematics(case.q), scale.lever)
    assert_close(robot.jacobian(case.q), theirs.jacobian(case.q), scale.jacobian)
    agree_at_rest(robot, theirs, case)


@pytest.mark.parametrize("name", ["rrbot", "rrbot_modified", "dvrk_mtml", "panda", "raven2_gold"])
def test_kdl(kdl: Any, name: str) -> None:
    """Arms whose links are a chain, with base and tool left out: KDL's answers are in axes of frame 0."""
    robot, rng = ravengc.Robot(replace(ravengc.load(name).spec, base=Pose(), tool=Pose())), np.random.default_rng(3)
    theirs = kdl(robot.spec)
    for _ in range(10):
        q, qd, qdd = rng.uniform(-2.0, 2.0, (3, robot.n))
        case = Case(robot.spec, q, qd, qdd, rng.normal(0.0, 10.0, 3), np.zeros(3), np.zeros(3))
        assert_close(robot.forward_kinematics(q)[:3], theirs.forward_kinematics(q), size(case).lever)
        assert_close(robot.jacobian(q), theirs.jacobian(q), size(case).jacobian)
        agree_at_rest(robot, theirs, case)


def agree_at_rest(robot: ravengc.Robot, theirs: Any, case: Case) -> None:
    """Both find the same torques on a base at rest, and the same mass matrix."""
    q, qd, qdd, *_ = case.motion
    scale, gravity = size(case), ravengc.Gravity(*case.g)
    assert_close(robot.gravity_torque(q, gravity), theirs.gravity_torque(q, case.g), scale.torque)
    tau = robot.inverse_dynamics(q, qd, qdd, gravity)
    assert_close(tau, theirs.inverse_dynamics(q, qd, qdd, case.g), scale.torque)
    assert_close(robot.mass_matrix(q), theirs.mass_matrix(q), scale.mass_matrix)


def test_raven_torques_of_both_routes() -> None:
    """48 rows: both arms, six poses, four gravity vectors; by the paper's equations and by the energy's difference."""
    with (DATA / "raven2_gravity_ref.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 48
    for row in rows:
        q = [radians(float(row["J1_deg"])), radians(float(row["J2_deg"])), float(row["d3_m"])]
        tau = ravengc.load(f"raven2_{row['arm']}").gravity_torque(q, [float(row[key]) for key in ("gBx", "gBy", "gBz")])
        for route in ("eq", "grad"):
            expected = [float(row[f"{key}_{route}"]) for key in ("tau1", "tau2", "f3")]
            np.testing.assert_allclose(tau, expected, rtol=0.0, atol=1e-9)


DVRK = [
    (name, group, arm)
    for group, names in {
        "rrbot": {"rrbot": None, "rrbot_modified": None},
        "mtm": {"dvrk_mtml": "MTML", "dvrk_mtmr": "MTMR"},
        "psm_si": {"dvrk_psm_si": None},
        "ecm_si": {"dvrk_ecm_si": None},
    }.items()
    for name, arm in names.items()
]


@pytest.mark.parametrize(("name", "group", "arm"), DVRK)
def test_dvrk_torques_of_the_energy_gradient(name: str, group: str, arm: str | None) -> None:
    """Complex-step gradients; the file's gravity is in axes of frame 0."""
    robot, table = ravengc.load(name), json.loads((DATA / "dvrk_reference_torques.json").read_text())[group]
    rows = [row for row in table if arm in (None, row.get("arm"))]
    assert len(rows) >= 16
    g = np.array([row["g"] for row in rows]) @ np.transpose(robot.spec.base.rotation)
    tau = robot.gravity_torque_batch([row["q"] for row in rows], g)
    np.testing.assert_allclose(tau, [row["tau"] for row in rows], rtol=0.0, atol=1e-12)
