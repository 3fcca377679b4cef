"""The NumPy reference checked against itself: every test is a theorem of mechanics.

Two of its routes to the same torque share nothing but the link frames: the paper's equations and the energy's gradient.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bounds import assert_close, bounds, reach
from ravengc import reference as ref
from ravengc.spec import DhRow, JointOrigin, LinkSpec, Pose, RobotSpec
from strategies import (
    ACCELERATION,
    CONVENTIONS,
    PAYLOAD,
    PLACEMENTS,
    SPIN,
    Case,
    cases,
    coordinates,
    pose,
    robots,
)

if TYPE_CHECKING:
    from collections.abc import Callable

STEP = 1e-30
REST = np.zeros(3)
SLOW_DRAWS = [HealthCheck.too_slow, HealthCheck.data_too_large]
theorem = settings(max_examples=40, deadline=None, suppress_health_check=SLOW_DRAWS)


def at_rest(case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The pose, with rates and accelerations zero."""
    return case.q, np.zeros_like(case.q), np.zeros_like(case.q)


def rate(function: Callable[..., Any], *moving_arguments: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Time derivative of a function whose arguments are given as (value, rate), by complex step."""
    return np.asarray(function(*(value + 1j * STEP * speed for value, speed in moving_arguments))).imag / STEP


@theorem
@given(cases())
def test_equations_1_to_3_are_the_energy_gradient_and_inverse_dynamics_at_rest(case: Case) -> None:
    tau = ref.gravity_torque(case.spec, case.q, case.g)
    scale = bounds(case.spec, case.q, f=case.f).torque
    assert_close(ref.gravity_torque_from_energy(case.spec, case.q, case.g), tau, scale)
    assert_close(ref.inverse_dynamics(case.spec, *at_rest(case), case.f), tau, scale)


@theorem
@given(cases(most=8))
def test_inverse_dynamics_is_what_lagrange_says(case: Case) -> None:
    newton_euler = ref.inverse_dynamics(case.spec, case.q, case.qd, case.qdd, case.f)
    lagrange = ref.lagrangian_torque(case.spec, case.q, case.qd, case.qdd, case.g)
    assert_close(lagrange, newton_euler, bounds(case.spec, *case.motion).torque)


@theorem
@given(cases())
def test_free_fall_needs_no_torque(case: Case) -> None:
    assert not ref.gravity_torque(case.spec, case.q, REST).any()
    assert not ref.inverse_dynamics(case.spec, *at_rest(case), REST).any()


@theorem
@given(cases(), ACCELERATION, st.floats(-3.0, 3.0))
def test_gravity_torque_is_linear_in_gravity(case: Case, other: np.ndarray, factor: float) -> None:
    torque = partial(ref.gravity_torque, case.spec, case.q)
    scale = bounds(case.spec, case.q, f=np.abs(case.g) + 3.0 * np.abs(other)).torque
    assert_close(torque(case.g + factor * other), torque(case.g) + factor * torque(other), scale)


@theorem
@given(cases(), PAYLOAD, st.floats(0.1, 3.0))
def test_torque_is_linear_in_the_masses(case: Case, payload: ref.Payload, factor: float) -> None:
    def scaled(link: LinkSpec, by: float) -> LinkSpec:
        return replace(link, mass=by * link.mass, inertia=tuple(by * part for part in link.inertia))

    heavier = replace(case.spec, links=tuple(scaled(link, factor) for link in case.spec.links))
    empty = replace(case.spec, links=tuple(scaled(link, 0.0) for link in case.spec.links))
    total = ref.inverse_dynamics(heavier, *case.motion, payload)
    parts = factor * ref.inverse_dynamics(case.spec, *case.motion) + ref.inverse_dynamics(empty, *case.motion, payload)
    assert_close(total, parts, bounds(heavier, *case.motion, payload).torque)


@theorem
@given(cases(), PAYLOAD)
def test_a_payload_is_one_more_link_fixed_to_the_tool(case: Case, payload: ref.Payload) -> None:
    mass, com, inertia = payload
    held = LinkSpec(
        name="held",
        joint="fixed",
        parent=case.spec.tip or case.spec.links[-1].name,
        placement=JointOrigin(pose=case.spec.tool),
        mass=mass,
        com=com,
        inertia=inertia,
    )
    spec = replace(case.spec, links=(*case.spec.links, held), tip="held")
    scale = bounds(case.spec, *case.motion, payload)
    assert_close(
        ref.gravity_torque(spec, case.q, case.g), ref.gravity_torque(case.spec, case.q, case.g, payload), scale.torque
    )
    assert_close(
        ref.inverse_dynamics(spec, *case.motion), ref.inverse_dynamics(case.spec, *case.motion, payload), scale.torque
    )
    assert_close(ref.mass_matrix(spec, case.q), ref.mass_matrix(case.spec, case.q, payload), scale.mass_matrix)


@theorem
@given(cases(), st.data())
def test_jacobian_is_the_derivative_of_the_pose(case: Case, data: st.DataObject) -> None:
    frame = data.draw(st.sampled_from(("base", *(link.name for link in case.spec.links), "tool")))
    turn = ref.forward_kinematics(case.spec, case.q, frame)[:3, :3]
    pose_rate = rate(lambda q: ref.forward_kinematics(case.spec, q, frame), (case.q, case.qd))
    spin = pose_rate[:3, :3] @ turn.T  # S(w) = dR/dt Rᵀ
    twist = np.array([*pose_rate[:3, 3], spin[2, 1], spin[0, 2], spin[1, 0]])
    scale = bounds(case.spec, case.q).jacobian * (1.0 + np.abs(case.qd).sum())
    assert_close(ref.jacobian(case.spec, case.q, frame) @ case.qd, twist, scale)
    own = np.concatenate([turn.T @ twist[:3], turn.T @ twist[3:]])
    assert_close(ref.jacobian(case.spec, case.q, frame, axes="frame") @ case.qd, own, scale)


@theorem
@given(cases(solid=True))
def test_mass_matrix_is_symmetric_and_positive_definite(case: Case) -> None:
    mass = ref.mass_matrix(case.spec, case.q)
    assert_close(mass, mass.T, bounds(case.spec, case.q).mass_matrix)
    assert np.linalg.eigvalsh((mass + mass.T) / 2).min() > 0.0
    energy = ref.kinetic_energy(case.spec, case.q, case.qd)
    assert energy == pytest.approx(case.qd @ mass @ case.qd / 2, rel=1e-9, abs=1e-12)


@theorem
@given(cases(solid=True))
def test_forward_dynamics_undoes_inverse_dynamics(case: Case) -> None:
    q, qd, _, *base = case.motion
    tau = ref.inverse_dynamics(case.spec, *case.motion)
    found = ref.forward_dynamics(case.spec, q, qd, tau, *base)
    scale = bounds(case.spec, q, qd, found, *base).torque
    assert_close(ref.inverse_dynamics(case.spec, q, qd, found, *base), tau, scale, 1e-10)


@theorem
@given(cases(), SPIN)
def test_power_balance_on_a_moving_base(case: Case, v: np.ndarray) -> None:
    """The joints' power and the mount's is the rate of the kinetic energy (gravity being part of ``f``)."""
    q, qd, qdd, f, w, dw = case.motion
    energy = partial(ref.kinetic_energy, case.spec)
    energy_rate = rate(energy, (q, qd), (qd, qdd), (v, f - np.cross(w, v)), (w, dw))  # v and w in axes that turn with w
    wrench = ref.base_wrench(case.spec, *case.motion)
    power = ref.inverse_dynamics(case.spec, *case.motion) @ qd + wrench @ np.concatenate([v, w])
    speed = np.abs(qd).sum() + np.abs(v).sum() + np.abs(w).sum() + 1.0
    assert_close(energy_rate, power, bounds(case.spec, *case.motion).torque * speed)


@theorem
@given(cases())
def test_power_balance_with_gravity(case: Case) -> None:
    def energy(q: np.ndarray, qd: np.ndarray) -> complex:
        return ref.kinetic_energy(case.spec, q, qd) + ref.potential_energy(case.spec, q, case.g)

    tau = ref.inverse_dynamics(case.spec, case.q, case.qd, case.qdd, case.f)
    scale = bounds(case.spec, *case.motion).torque * (1.0 + np.abs(case.qd).sum())
    assert_close(rate(energy, (case.q, case.qd), (case.qd, case.qdd)), tau @ case.qd, scale)


@theorem
@given(cases(most=6))
def test_rate_of_the_mass_matrix_minus_twice_coriolis_is_skew(case: Case) -> None:
    """C from the Christoffel symbols of M is also the C of Newton-Euler, and dM/dt - 2C is skew."""
    q, qd, *_ = case.motion
    n = len(q)
    mass_slopes = np.stack([rate(partial(ref.mass_matrix, case.spec), (q, unit)) for unit in np.eye(n)])  # dM/dq_k
    product = np.tensordot(qd, mass_slopes, axes=(0, 0))
    coriolis = (product + np.einsum("jik,k->ij", mass_slopes, qd) - np.einsum("ijk,k->ij", mass_slopes, qd)) / 2
    scale = bounds(case.spec, q, qd).torque + bounds(case.spec, q).mass_matrix * (1.0 + np.abs(qd).sum())
    assert_close(ref.inverse_dynamics(case.spec, q, qd, np.zeros(n), REST), coriolis @ qd, scale)
    skew = product - 2 * coriolis
    assert_close(skew, -skew.T, scale)


@theorem
@given(cases(coupled=False, most=15), st.data())
def test_a_rocking_base_is_one_more_joint_nobody_commands(case: Case, data: st.DataObject) -> None:
    """A massless link under the arm moves; the arm on it feels exactly the base motion that its pose and rates give."""
    spec = case.spec
    kind = data.draw(st.sampled_from(("revolute", "prismatic")))
    rocker = LinkSpec(name="rocker", joint=kind, placement=data.draw(PLACEMENTS[spec.convention]), massless=True)
    on_rocker = tuple(replace(link, parent=link.parent or "rocker") for link in spec.links)
    whole = replace(spec, links=(rocker, *on_rocker), base=pose((0.0, 0.0, 1.0), 0.3, (0.1, -0.2, 0.3)))
    x, v, a = data.draw(st.tuples(*[st.floats(-3.0, 3.0)] * 3))

    q = np.array([x, *case.q])
    tau = ref.inverse_dynamics(whole, q, [v, *case.qd], [a, *case.qdd], case.f)

    z, o = ref.joint_axes(whole, q)[0]
    frame = ref.link_frames(whole, q)["rocker"] @ np.linalg.inv(homogeneous(spec.base))  # world <- the arm's B
    turn, r = frame[:3, :3], frame[:3, 3] - o
    spin = z if kind == "revolute" else REST
    w, dw = spin * v, spin * a
    acceleration = np.cross(dw, r) + np.cross(w, np.cross(w, r)) if kind == "revolute" else z * a
    base = (turn.T @ (case.f + acceleration), turn.T @ w, turn.T @ dw)

    scale = bounds(whole, q, [v, *case.qd], [a, *case.qdd], case.f).torque
    assert_close(ref.inverse_dynamics(spec, case.q, case.qd, case.qdd, *base), tau[1:], scale)
    wrench = ref.base_wrench(spec, case.q, case.qd, case.qdd, *base)
    force, moment = turn @ wrench[:3], turn @ wrench[3:]
    needed = z @ (moment + np.cross(r, force)) if kind == "revolute" else z @ force
    assert_close(needed, tau[0], scale)


@theorem
@given(cases())
def test_base_wrench_at_rest_is_the_weight_of_all_links_at_their_centers(case: Case) -> None:
    frames = ref.link_frames(case.spec, case.q)
    weight, moment = np.zeros(3), np.zeros(3)
    for link in case.spec.links:
        center = frames[link.name] @ [*link.com, 1.0]
        weight += link.mass * case.f
        moment += np.cross(center[:3], link.mass * case.f)
    wrench = ref.base_wrench(case.spec, *at_rest(case), case.f)
    assert_close(wrench, [*weight, *moment], bounds(case.spec, case.q, f=case.f).moment)


@theorem
@given(cases())
def test_potential_energy_is_that_of_the_moving_mass_at_its_center(case: Case) -> None:
    mass = ref.inertial_parameters(case.spec).reshape(-1, 10)[:, 0].sum()
    center = ref.center_of_mass(case.spec, case.q)
    scale = bounds(case.spec, case.q, f=case.f).moment
    assert_close(ref.potential_energy(case.spec, case.q, case.g), -mass * case.g @ center, scale)


@theorem
@given(cases(most=8))
def test_gravity_stiffness_is_the_slope_of_the_torque(case: Case) -> None:
    stiffness = ref.gravity_stiffness(case.spec, case.q, case.g)
    scale = bounds(case.spec, case.q, f=case.f).stiffness
    assert_close(stiffness, stiffness.T, scale)
    step = 1e-5
    ahead, behind = (ref.gravity_torque(case.spec, case.q + sign * step * case.qd, case.g) for sign in (1, -1))
    assert_close(stiffness @ case.qd, (ahead - behind) / (2 * step), scale * (1.0 + np.abs(case.qd).sum()) ** 3, 1e-8)


@theorem
@given(cases(most=8), PAYLOAD)
def test_regressors_times_parameters_are_the_torques(case: Case, payload: ref.Payload) -> None:
    parameters = ref.inertial_parameters(case.spec, payload)
    scale = bounds(case.spec, *case.motion, payload).torque
    full = ref.inverse_dynamics_regressor(case.spec, *case.motion)
    assert_close(full @ parameters, ref.inverse_dynamics(case.spec, *case.motion, payload), scale)
    masses_and_moments = parameters.reshape(-1, 10)[:, :4].ravel()
    still = ref.gravity_regressor(case.spec, case.q, case.g)
    assert_close(still @ masses_and_moments, ref.gravity_torque(case.spec, case.q, case.g, payload), scale)


@theorem
@given(cases())
def test_turning_the_base_turns_gravity(case: Case) -> None:
    turn = np.array(case.spec.base.rotation)
    level = replace(case.spec, base=pose((0.0, 0.0, 1.0), 0.0, (0.0, 0.0, 0.0)))
    scale = bounds(case.spec, case.q, f=case.f).torque
    assert_close(
        ref.gravity_torque(level, case.q, turn.T @ case.g), ref.gravity_torque(case.spec, case.q, case.g), scale
    )


@theorem
@given(cases())
def test_a_coupling_loses_no_power(case: Case) -> None:
    free = replace(case.spec, coupling=None)
    joints = len(free.moving_links)
    matrix, offset = (
        (np.eye(joints), np.zeros(joints))
        if case.spec.coupling is None
        else (np.array(case.spec.coupling.matrix), np.array(case.spec.coupling.offset))
    )
    q, qd, qdd, *base = case.motion
    tau = ref.inverse_dynamics(case.spec, *case.motion)
    joint_tau = ref.inverse_dynamics(free, matrix @ q + offset, matrix @ qd, matrix @ qdd, *base)
    scale = bounds(case.spec, *case.motion).torque * (1.0 + np.abs(qd).sum())
    assert_close(tau @ qd, joint_tau @ (matrix @ qd), scale)


@theorem
@given(cases(convention="standard"))
def test_standard_and_modified_tables_of_one_arm_agree(case: Case) -> None:
    """The modified link frame is the standard one before its Tx(a) Rx(alpha), which the next row then begins with."""
    other = modified(case.spec)
    scale = bounds(case.spec, *case.motion)
    args = case.motion
    assert_close(ref.gravity_torque(other, case.q, case.g), ref.gravity_torque(case.spec, case.q, case.g), scale.torque)
    assert_close(ref.inverse_dynamics(other, *args), ref.inverse_dynamics(case.spec, *args), scale.torque)
    assert_close(ref.jacobian(other, case.q), ref.jacobian(case.spec, case.q), scale.jacobian)
    assert_close(ref.forward_kinematics(other, case.q), ref.forward_kinematics(case.spec, case.q), scale.lever)


@theorem
@given(robots(), st.data())
def test_longdouble_is_kept_and_agrees(spec: RobotSpec, data: st.DataObject) -> None:
    q, g = data.draw(coordinates(spec)), data.draw(ACCELERATION)
    tau = ref.gravity_torque(spec, q.astype(np.longdouble), g)
    assert tau.dtype == np.longdouble
    assert_close(ref.gravity_torque(spec, q, g), tau, bounds(spec, q, f=g).torque)


def test_every_convention_reaches_the_frames_it_names() -> None:
    for convention in CONVENTIONS:
        placement = JointOrigin() if convention == "frames" else DhRow()
        arm = LinkSpec(name="arm", placement=placement, mass=1.0)
        spec = RobotSpec(name="one", convention=convention, links=(arm,))
        assert set(ref.link_frames(spec, [0.0])) == {"base", "arm", "tool"}
        assert reach(spec, [0.0]) == 0.0


def homogeneous(frame: Pose) -> np.ndarray:
    """A pose as a 4x4 matrix."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = frame.rotation, frame.translation
    return matrix


def modified(spec: RobotSpec) -> RobotSpec:
    """The same arm in modified DH: COM, inertia and tool move by Tx(a) Rx(alpha) into the new link frames."""
    tail = {link.name: pose((1.0, 0.0, 0.0), link.placement.alpha, (link.placement.a, 0.0, 0.0)) for link in spec.links}
    row = {link.name: link.placement for link in spec.links}

    def converted(link: LinkSpec) -> LinkSpec:
        before = row[link.parent] if link.parent else DhRow()
        turn, shift = np.array(tail[link.name].rotation), np.array(tail[link.name].translation)
        inertia = np.zeros((3, 3))
        inertia[np.triu_indices(3)] = link.inertia
        inertia = turn @ (inertia + np.triu(inertia, 1).T) @ turn.T
        return replace(
            link,
            placement=replace(link.placement, alpha=before.alpha, a=before.a),
            com=tuple(turn @ link.com + shift),
            inertia=tuple(inertia[np.triu_indices(3)]),
        )

    end = spec.tip or spec.links[-1].name
    tool = homogeneous(tail[end]) @ homogeneous(spec.tool)
    return replace(
        spec,
        convention="modified",
        links=tuple(converted(link) for link in spec.links),
        tool=replace(spec.tool, rotation=tuple(map(tuple, tool[:3, :3])), translation=tuple(tool[:3, 3])),
    )
