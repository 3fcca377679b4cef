"""The compiled core against the NumPy reference on random robots: every function of it, single and batch.

The scale of each comparison is explained in :mod:`bounds`; accuracy is measured against an 80-bit evaluation.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc
from bounds import assert_close, bounds, length
from ravengc import reference as ref
from ravengc.config.bundled import bundled_names
from ravengc.reference.kinematics import PlacedLink, moving, place
from strategies import ACCELERATION, PAYLOAD, POSE, Case, cases, coordinates

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.spec import Pose, RobotSpec

SLOW_DRAWS = [HealthCheck.too_slow, HealthCheck.data_too_large]
agreement = settings(max_examples=60, deadline=None, suppress_health_check=SLOW_DRAWS)
regressors = settings(max_examples=40, deadline=None, suppress_health_check=SLOW_DRAWS)
EPS = np.finfo(float).eps
SAMPLES = 5
needs_longdouble = pytest.mark.skipif(
    np.finfo(np.longdouble).eps >= EPS, reason="longdouble is no more precise than float64 here"
)


def base_of(case: Case) -> ravengc.BaseMotion:
    """The base motion of a case as the core takes it."""
    return ravengc.BaseMotion(specific_force=case.f, angular_velocity=case.w, angular_acceleration=case.dw)


def check(method: Callable[..., Any], *args: Any, expected: np.ndarray, bound: float, **options: Any) -> None:
    """The method's result is the expected one, and the same bits with ``out=``."""
    result = method(*args, **options)
    assert_close(result, expected, bound)
    out = np.full(np.shape(expected), np.nan)
    method(*args, out=out, **options)
    np.testing.assert_array_equal(out, result)


@agreement
@given(cases())
def test_names_and_sizes(case: Case) -> None:
    robot = ravengc.Robot(case.spec)
    assert robot.n == len(case.spec.coordinate_names) == len(robot.joint_names)
    assert robot.body_count == len(case.spec.moving_links)
    assert set(robot.frame_names) == set(ref.link_frames(case.spec, case.q))
    assert robot.spec == case.spec


@agreement
@given(cases(), st.data())
def test_kinematics(case: Case, data: st.DataObject) -> None:
    robot, scale = ravengc.Robot(case.spec), bounds(case.spec, case.q)
    frame = data.draw(st.sampled_from(("base", *(link.name for link in case.spec.links), "tool")))
    pose = ref.forward_kinematics(case.spec, case.q, frame)
    check(robot.forward_kinematics, case.q, frame, expected=pose, bound=scale.lever)
    check(robot.forward_kinematics, case.q, expected=ref.forward_kinematics(case.spec, case.q), bound=scale.lever)
    for axes in ("base", "frame"):
        expected = ref.jacobian(case.spec, case.q, frame, axes)
        check(robot.jacobian, case.q, frame, axes, expected=expected, bound=scale.jacobian)


@agreement
@given(cases())
def test_gravity(case: Case) -> None:
    robot, scale = ravengc.Robot(case.spec), bounds(case.spec, case.q, f=case.f)
    tau = ref.gravity_torque(case.spec, case.q, case.g)
    for gravity in (case.g, tuple(case.g.tolist()), ravengc.Gravity(*case.g), ravengc.SpecificForce(*case.f)):
        check(robot.gravity_torque, case.q, gravity, expected=tau, bound=scale.torque)
    check(
        robot.gravity_stiffness,
        case.q,
        case.g,
        expected=ref.gravity_stiffness(case.spec, case.q, case.g),
        bound=scale.stiffness,
    )
    check(robot.center_of_mass, case.q, expected=ref.center_of_mass(case.spec, case.q), bound=scale.lever)
    energy = ref.potential_energy(case.spec, case.q, case.g)
    assert_close(robot.potential_energy(case.q, case.g), energy, scale.moment)


@agreement
@given(cases())
def test_inverse_dynamics_on_a_moving_base(case: Case) -> None:
    robot, base, scale = ravengc.Robot(case.spec), base_of(case), bounds(case.spec, *case.motion)
    q, qd, qdd, *_ = case.motion
    check(
        robot.inverse_dynamics,
        q,
        qd,
        qdd,
        base,
        expected=ref.inverse_dynamics(case.spec, *case.motion),
        bound=scale.torque,
    )
    check(robot.base_wrench, q, qd, qdd, base, expected=ref.base_wrench(case.spec, *case.motion), bound=scale.moment)


@agreement
@given(cases())
def test_inverse_dynamics_on_a_base_at_rest(case: Case) -> None:
    robot, scale = ravengc.Robot(case.spec), bounds(case.spec, *case.motion).torque
    tau = ref.inverse_dynamics(case.spec, case.q, case.qd, case.qdd, case.f)
    for base in (ravengc.Gravity(*case.g), ravengc.SpecificForce(*case.f)):
        check(robot.inverse_dynamics, case.q, case.qd, case.qdd, base, expected=tau, bound=scale)


@agreement
@given(cases())
def test_mass_matrix(case: Case) -> None:
    check(
        ravengc.Robot(case.spec).mass_matrix,
        case.q,
        expected=ref.mass_matrix(case.spec, case.q),
        bound=bounds(case.spec, case.q).mass_matrix,
    )


@agreement
@given(cases(solid=True), st.data())
def test_forward_dynamics(case: Case, data: st.DataObject) -> None:
    """The accelerations need the torques that were given, and are the reference's as far as M⁻¹ lets torques tell."""
    robot, base = ravengc.Robot(case.spec), base_of(case)
    q, qd, _, *moving = case.motion
    tau = data.draw(coordinates(case.spec, 50.0))
    qdd = robot.forward_dynamics(q, qd, tau, base)
    out = np.full_like(qdd, np.nan)
    robot.forward_dynamics(q, qd, tau, base, out=out)
    np.testing.assert_array_equal(out, qdd)
    scale = bounds(case.spec, q, qd, qdd, *moving).torque + np.abs(tau).max()
    assert_close(ref.inverse_dynamics(case.spec, q, qd, qdd, *moving), tau, scale)
    yielding = np.linalg.norm(np.linalg.inv(ref.mass_matrix(case.spec, q)), 2)
    assert_close(qdd, ref.forward_dynamics(case.spec, q, qd, tau, *moving), yielding * scale)


@regressors
@given(cases())
def test_gravity_regressor_and_parameters(case: Case) -> None:
    robot, scale = ravengc.Robot(case.spec), bounds(case.spec, case.q, f=case.f)
    expected = ref.gravity_regressor(case.spec, case.q, case.g)
    check(robot.gravity_regressor, case.q, case.g, expected=expected, bound=scale.regressor)
    parameters = ref.inertial_parameters(case.spec)
    assert_close(robot.inertial_parameters(), parameters, scale.mass * scale.lever**2 + scale.inertia)


@regressors
@given(cases(most=7))
def test_inverse_dynamics_regressor(case: Case) -> None:
    robot, scale = ravengc.Robot(case.spec), bounds(case.spec, *case.motion)
    expected = ref.inverse_dynamics_regressor(case.spec, *case.motion)
    check(
        robot.inverse_dynamics_regressor,
        case.q,
        case.qd,
        case.qdd,
        base_of(case),
        expected=expected,
        bound=scale.regressor,
    )


@agreement
@given(cases(), PAYLOAD)
def test_payload(case: Case, payload: ref.Payload) -> None:
    robot, scale = ravengc.Robot(case.spec), bounds(case.spec, *case.motion, payload)
    before = robot.gravity_torque(case.q, case.g)
    robot.set_payload(*payload)
    check(
        robot.gravity_torque,
        case.q,
        case.g,
        expected=ref.gravity_torque(case.spec, case.q, case.g, payload),
        bound=scale.torque,
    )
    check(
        robot.inverse_dynamics,
        case.q,
        case.qd,
        case.qdd,
        base_of(case),
        expected=ref.inverse_dynamics(case.spec, *case.motion, payload),
        bound=scale.torque,
    )
    check(
        robot.base_wrench,
        case.q,
        case.qd,
        case.qdd,
        base_of(case),
        expected=ref.base_wrench(case.spec, *case.motion, payload),
        bound=scale.moment,
    )
    check(robot.mass_matrix, case.q, expected=ref.mass_matrix(case.spec, case.q, payload), bound=scale.mass_matrix)
    check(robot.center_of_mass, case.q, expected=ref.center_of_mass(case.spec, case.q, payload), bound=scale.lever)
    parameters = ref.inertial_parameters(case.spec, payload)
    assert_close(robot.inertial_parameters(), parameters, scale.mass * scale.lever**2 + scale.inertia)
    robot.clear_payload()
    np.testing.assert_array_equal(robot.gravity_torque(case.q, case.g), before)


@agreement
@given(cases(), POSE, POSE)
def test_base_and_tool_can_change(case: Case, base: Pose, tool: Pose) -> None:
    robot = ravengc.Robot(case.spec)
    robot.set_base(base.rotation, base.translation)
    robot.set_tool(tool.rotation, tool.translation)
    spec = replace(case.spec, base=base, tool=tool)
    scale = bounds(spec, *case.motion)
    check(robot.forward_kinematics, case.q, expected=ref.forward_kinematics(spec, case.q), bound=scale.lever)
    check(robot.jacobian, case.q, expected=ref.jacobian(spec, case.q), bound=scale.jacobian)
    check(
        robot.inverse_dynamics,
        case.q,
        case.qd,
        case.qdd,
        base_of(case),
        expected=ref.inverse_dynamics(spec, *case.motion),
        bound=scale.torque,
    )


@agreement
@given(cases(), st.data())
def test_gravity_torque_batch(case: Case, data: st.DataObject) -> None:
    robot = ravengc.Robot(case.spec)
    q = np.array([data.draw(coordinates(case.spec)) for _ in range(SAMPLES)])
    g = np.array([data.draw(ACCELERATION) for _ in range(SAMPLES)])
    scale = max(
        bounds(case.spec, row, f=case.f).torque + bounds(case.spec, row, f=one).torque
        for row, one in zip(q, g, strict=True)
    )
    threads = data.draw(st.integers(1, 3))
    common = np.array([ref.gravity_torque(case.spec, row, case.g) for row in q])
    check(robot.gravity_torque_batch, q, case.g, expected=common, bound=scale, threads=threads)
    own = np.array([ref.gravity_torque(case.spec, row, one) for row, one in zip(q, g, strict=True)])
    check(robot.gravity_torque_batch, q, g, expected=own, bound=scale, threads=threads)


@agreement
@given(cases(most=8), st.integers(2, 5))
def test_threads_change_no_bit(case: Case, threads: int) -> None:
    robot = ravengc.Robot(case.spec)
    q = case.q + np.linspace(-3.0, 3.0, 1303)[:, None]
    alone = robot.gravity_torque_batch(q, case.g)
    np.testing.assert_array_equal(robot.gravity_torque_batch(q, case.g, threads=threads), alone)
    np.testing.assert_array_equal(robot.gravity_torque_batch(q, case.g, threads=0), alone)


@agreement
@given(cases(), st.integers(0, 12))
def test_batches_are_the_single_calls_row_by_row(case: Case, samples: int) -> None:
    """Every other function: the batch runs the same kernel, so the bits are the same."""
    robot, base = ravengc.Robot(case.spec), base_of(case)
    shift = np.linspace(-1.0, 1.0, samples)[:, None]
    q, qd, qdd = case.q + shift, case.qd - shift, case.qdd + 2.0 * shift
    calls: dict[str, tuple[Any, ...]] = {
        "forward_kinematics": (q,),
        "jacobian": (q,),
        "inverse_dynamics": (q, qd, qdd, base),
        "base_wrench": (q, qd, qdd, base),
        "mass_matrix": (q,),
        "forward_dynamics": (q, qd, qdd, base),
        "gravity_regressor": (q, case.g),
        "inverse_dynamics_regressor": (q, qd, qdd, base),
        "gravity_stiffness": (q, case.g),
        "potential_energy": (q, case.g),
        "center_of_mass": (q,),
    }
    for name, arguments in calls.items():
        batch = getattr(robot, f"{name}_batch")(*arguments)
        assert len(batch) == samples
        for k, row in enumerate(batch):
            single = getattr(robot, name)(*(a[k] if np.ndim(a) == 2 else a for a in arguments))
            np.testing.assert_array_equal(row, single, err_msg=f"{name}_batch, row {k}")


@agreement
@given(cases())
def test_a_bound_cycle_computes_the_same_bits(case: Case) -> None:
    robot, q, g = ravengc.Robot(case.spec), case.q.copy(), case.g.copy()
    out = np.full(robot.n, np.nan)
    cycle = robot.bind(q=q, gravity=g, out=out)
    cycle()
    np.testing.assert_array_equal(out, robot.gravity_torque(q, g))
    q += 0.1
    g *= 0.5
    cycle()
    np.testing.assert_array_equal(out, robot.gravity_torque(q, g))


@needs_longdouble
@agreement
@given(cases(coupled=False))
def test_gravity_torque_is_accurate_to_8_eps(case: Case) -> None:
    """Within 8 eps Σ m_k |g| ℓ_ik of an 80-bit evaluation of the paper's equations, joint by joint.

    But for torques so small that float64 has fewer digits for them.
    """
    error, paths, _ = accuracy(case.spec, case.q, case.g)
    assert (error <= 8 * EPS * paths + np.finfo(float).tiny).all()


@needs_longdouble
@pytest.mark.parametrize("name", bundled_names())
def test_bundled_robots_are_accurate_to_8_eps(name: str) -> None:
    """The same with the straight distances |r_k - o_i|: no pose of these arms folds a mass onto a distant axis."""
    spec, rng = replace(ravengc.load(name).spec, coupling=None), np.random.default_rng(7)
    for _ in range(20):
        q, g = rng.uniform(-np.pi, np.pi, len(spec.moving_links)), rng.normal(0.0, 10.0, 3)
        error, _, distances = accuracy(spec, q, g)
        assert (error <= 8 * EPS * distances).all()


@pytest.mark.parametrize("name", bundled_names())
def test_bundled_robots_agree(name: str) -> None:
    robot, rng = ravengc.load(name), np.random.default_rng(8)
    for _ in range(5):
        q, qd, qdd = rng.uniform(-2.0, 2.0, (3, robot.n))
        case = Case(robot.spec, q, qd, qdd, *rng.normal(0.0, 5.0, (3, 3)))
        scale = bounds(case.spec, *case.motion).torque
        tau = ref.inverse_dynamics(case.spec, *case.motion)
        check(robot.inverse_dynamics, q, qd, qdd, base_of(case), expected=tau, bound=scale)
        check(robot.gravity_torque, q, case.g, expected=ref.gravity_torque(case.spec, q, case.g), bound=scale)


def accuracy(spec: RobotSpec, q: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Error of each joint's gravity torque, and the two scales for it: Σ m_k |g| ℓ_ik and Σ m_k |g| |r_k - o_i|.

    ℓ_ik is the length of the path from joint i's axis along the link origins to the centre of mass k. For a stretched
    arm it is the distance |r_k - o_i|; for a folded one it still counts what lies between. A sliding joint
    has Σ m_k |g| as both scales.
    """
    tau = ravengc.Robot(spec).gravity_torque(q, g)
    error = np.abs(tau - ref.gravity_torque(spec, q.astype(np.longdouble), g)).astype(float)
    placed = place(spec, q)
    scales = np.array([levers(placed, i, joint) for i, joint in enumerate(moving(placed))])
    return error, *(np.linalg.norm(g) * scales.T)


def levers(placed: list[PlacedLink], i: int, joint: PlacedLink) -> tuple[float, float]:
    """Σ m_k ℓ_ik and Σ m_k |r_k - o_i| over the links that joint i carries; Σ m_k twice if it slides."""
    links = [body for body in placed if i in body.joints]
    if joint.link.joint == "prismatic":
        mass = sum(body.link.mass for body in links)
        return mass, mass
    path, origin = {joint.link.parent: 0.0}, {joint.link.parent: joint.o}
    for body in links:
        origin[body.link.name] = body.frame[:3, 3]
        path[body.link.name] = path[body.link.parent] + length(body.frame[:3, 3] - origin[body.link.parent])
    return (
        sum(body.link.mass * (path[body.link.name] + length(body.link.com)) for body in links),
        sum(body.link.mass * length(body.com - joint.o) for body in links),
    )
