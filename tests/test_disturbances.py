"""Disturbance elements: the core is the reference, springs are gradients, nothing steps but what is said to step."""

from __future__ import annotations

import copy
import io
import json
import pickle
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from rich.console import Console

import ravengc as rg
from bounds import bounds, length
from disturbance_elements import blends, cables, elements, some, springs
from ravengc import reference as ref
from ravengc.cli import main
from ravengc.cli.info_tables import show_robot
from ravengc.config import spec_from_toml, spec_to_toml
from ravengc.disturbances import (
    Constant,
    Friction,
    Jump,
    LinearSpring,
    PiecewiseCable,
    Polynomial,
    SpringBetween,
)
from ravengc.reference.disturbances import distance
from strategies import Case, cases

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from ravengc.disturbances import Disturbance
    from ravengc.spec import RobotSpec

theorem = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
MEETING = 1e-4
"""Ends of a spring closer than this (m) have a direction that is mostly rounding."""

ELBOW = {"name": "elbow", "joint": "joint2"}


def rrbot(*disturbances: Disturbance) -> rg.Robot:
    return rg.Robot(replace(rg.load("rrbot").spec, disturbances=disturbances))


def with_elements(case: Case, data: st.DataObject) -> RobotSpec:
    spec = replace(case.spec, disturbances=data.draw(some(case.spec)))
    assume(all(far(spec, element, case.q) for element in spec.disturbances))
    return spec


def far(spec: RobotSpec, element: Disturbance, q: np.ndarray) -> bool:
    """A spring with a rest length whose ends are apart, or anything else."""
    is_spring = isinstance(element, SpringBetween) and element.rest_length > 0.0
    return not is_spring or length(distance(spec, element, q)) > MEETING


def scale(spec: RobotSpec, case: Case) -> float:
    """Sum of the sizes of all terms: |Y| |p|, and levers of springs."""
    largest = bounds(spec, case.q)
    columns = np.abs(ref.disturbance_regressor(spec, case.q, case.qd)) @ np.abs(ref.disturbance_parameters(spec))
    lever = max([1.0, largest.lever, *(abs(x) for e in spec.disturbances for x in getattr(e, "point_a", ()))])
    stiff = sum(e.stiffness * (1.0 + e.rest_length / MEETING) for e in spec.disturbances if hasattr(e, "rest_length"))
    steep = 1.0 + sum(np.abs(e.parameters).sum() for e in spec.disturbances) * np.exp(2.0 * length(case.q))
    return float(columns.max(initial=0.0) + stiff * largest.gain * lever**2 + steep)


@theorem
@given(cases(), st.data())
def test_the_core_is_the_reference(case: Case, data: st.DataObject) -> None:
    spec = with_elements(case, data)
    robot, bound = rg.Robot(spec), 1e-12 * scale(spec, case)
    for qd in (case.qd, None):
        expected = ref.disturbance_torque(spec, case.q, qd)
        np.testing.assert_allclose(robot.disturbance_torque(case.q, qd), expected, rtol=1e-11, atol=bound)
        columns = ref.disturbance_regressor(spec, case.q, qd)
        np.testing.assert_allclose(robot.disturbance_regressor(case.q, qd), columns, rtol=1e-11, atol=bound)
    np.testing.assert_array_equal(robot.disturbance_parameters(), ref.disturbance_parameters(spec))
    assert len(robot.disturbance_columns) == len(set(robot.disturbance_columns)) == columns.shape[1]


@theorem
@given(cases(), st.data())
def test_torque_is_the_regressor_times_the_parameters(case: Case, data: st.DataObject) -> None:
    spec = with_elements(case, data)
    robot = rg.Robot(spec)
    torque = robot.disturbance_torque(case.q, case.qd)
    product = robot.disturbance_regressor(case.q, case.qd) @ robot.disturbance_parameters()
    np.testing.assert_allclose(product, torque, rtol=1e-11, atol=1e-12 * scale(spec, case))
    for method, result in ((robot.disturbance_torque, torque), (robot.disturbance_regressor, None)):
        fresh = method(case.q, case.qd)
        out = np.full(fresh.shape, np.nan)
        assert method(case.q, case.qd, out) is out
        np.testing.assert_array_equal(out, fresh if result is None else result)


@theorem
@given(cases(), st.data())
def test_springs_are_the_gradient_of_their_energy(case: Case, data: st.DataObject) -> None:
    """τ = ∂U/∂q by central differences of the reference's energy, whatever joints lie between the ends."""
    spring = data.draw(springs(case.spec, "spring"))
    line = LinearSpring(name="line", joint=case.spec.coordinate_names[0], stiffness=3.0, rest=0.25)
    spec = replace(case.spec, disturbances=(spring, line))
    assume(length(distance(spec, spring, case.q)) > 0.05)
    h = 1e-5
    energies = [
        [float(ref.spring_energy(spec, case.q + sign * h * unit)) for sign in (1.0, -1.0)]
        for unit in np.eye(len(case.q))
    ]
    slope = [(up - down) / (2.0 * h) for up, down in energies]
    size = bounds(spec, case.q)
    bound = 1e-6 * (1.0 + 300.0 * size.gain**3 * (1.0 + size.lever) ** 3)
    np.testing.assert_allclose(rg.Robot(spec).disturbance_torque(case.q), slope, rtol=1e-6, atol=bound)


@theorem
@given(cases(), st.data())
def test_springs_do_virtual_work(case: Case, data: st.DataObject) -> None:
    """τᵀ q̇ is the force in the spring times the rate of its length."""
    spring = data.draw(springs(case.spec, "spring"))
    spec = replace(case.spec, disturbances=(spring,))
    d = distance(spec, spring, case.q)
    assume(length(d) > 0.05)
    robot = rg.Robot(spec)
    rate = velocity(robot, spring.body_b, spring.point_b, case) - velocity(robot, spring.body_a, spring.point_a, case)
    power = spring.stiffness * (length(d) - spring.rest_length) * (d @ rate) / length(d)
    size = bounds(spec, case.q)
    bound = 1e-11 * (1.0 + 300.0 * size.gain * (1.0 + size.lever) ** 2 * (1.0 + length(case.qd)))
    assert robot.disturbance_torque(case.q) @ case.qd == pytest.approx(power, rel=1e-9, abs=bound)


def velocity(robot: rg.Robot, body: str, point: tuple[float, ...], case: Case) -> np.ndarray:
    """Velocity (3,) of a point of a body, in B."""
    if body == "base":
        return np.zeros(3)
    linear, angular = np.split(robot.jacobian(case.q, body) @ case.qd, 2)
    return linear + np.cross(angular, robot.forward_kinematics(case.q, body)[:3, :3] @ point)


@theorem
@given(cases(), st.data())
def test_elements_do_not_turn_with_the_base(case: Case, data: st.DataObject) -> None:
    spec = with_elements(case, data)
    robot, bound = rg.Robot(spec), 1e-12 * scale(spec, case)
    before = robot.disturbance_torque(case.q, case.qd)
    robot.set_base([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], (0.5, -1.0, 0.25))
    robot.set_payload(2.0, (0.0, 0.1, 0.0))
    np.testing.assert_allclose(robot.disturbance_torque(case.q, case.qd), before, rtol=1e-10, atol=2.0 * bound)


@theorem
@given(cases(), st.data())
def test_copies_pickles_and_files_keep_the_elements(case: Case, data: st.DataObject) -> None:
    robot = rg.Robot(replace(case.spec, disturbances=data.draw(some(case.spec))))
    torque = robot.disturbance_torque(case.q, case.qd)
    for twin in (copy.copy(robot), copy.deepcopy(robot), pickle.loads(pickle.dumps(robot))):  # noqa: S301 -- our own
        np.testing.assert_array_equal(twin.disturbance_torque(case.q, case.qd), torque)
        assert twin.disturbance_columns == robot.disturbance_columns
    assert spec_from_toml(spec_to_toml(robot.spec)).disturbances == robot.spec.disturbances


# The direction of motion


def published(v: float, dead_band: float, saturation: float, ratio: float) -> float:
    """α of dvrk-gravity-compensation, controller.m (BSD, H. Lin, V. Hui, S. Au): its own five cases."""
    if v >= saturation:
        return 0.5 + 0.5 * ratio
    if v <= -saturation:
        return 0.5 - 0.5 * ratio
    if -dead_band <= v <= dead_band:
        return 0.5
    if v > dead_band:
        return 0.5 * ratio * (v - dead_band) / (saturation - dead_band) + 0.5
    return -0.5 * ratio * (-v - dead_band) / (saturation - dead_band) + 0.5


@theorem
@given(st.floats(-0.6, 0.6), st.sampled_from((0.008, 0.01, 0.02)), st.sampled_from((0.2, 0.4)), st.floats(0.0, 1.0))
def test_directions_blend_as_the_published_controller_does(v: float, db: float, sat: float, ratio: float) -> None:
    limits = {"dead_band": db, "saturation": sat, "ratio": ratio}
    pair = [
        Polynomial(name=way, joint="joint2", coefficients=(value,), direction=way, **limits)
        for way, value in (("positive", 1.0), ("negative", -1.0))
    ]
    alpha = published(v, db, sat, ratio)
    assert rrbot(pair[0]).disturbance_torque((0.0, 0.0), (0.0, v))[1] == alpha
    assert rrbot(*pair).disturbance_torque((0.0, 0.0), (0.0, v))[1] == alpha - (1.0 - alpha)


@theorem
@given(blends(), st.floats(-1.0, 1.0))
def test_friction_is_odd_continuous_and_still_at_rest(blend: dict[str, float], v: float) -> None:
    robot = rrbot(Friction(**ELBOW, coulomb=2.0, stribeck=1.0, stribeck_velocity=0.3, viscous=0.5, **blend))

    def torque(v: float) -> float:
        return float(robot.disturbance_torque((0.0, 0.0), (0.0, v))[1])

    assert torque(-v) == -torque(v)
    assert torque(0.0) == 0.0
    steepest = 0.5 + blend["ratio"] * (3.0 / (blend["saturation"] - blend["dead_band"]) + 1.0 / 0.3)
    assert abs(torque(v + 1e-6) - torque(v)) <= 1.01e-6 * steepest + 1e-15
    if abs(v) <= blend["dead_band"]:
        assert torque(v) == pytest.approx(0.5 * v, abs=1e-15)


# Ranges and knots


@theorem
@given(st.floats(-5.0, 5.0), st.data())
def test_beyond_the_trained_range_the_torque_stays(q: float, data: st.DataObject) -> None:
    coefficients = tuple(data.draw(st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=10)))
    robot = rrbot(Polynomial(**ELBOW, coefficients=coefficients, range=(-0.4, 0.6)))
    inside = min(0.6, max(-0.4, q))
    expected = np.polynomial.polynomial.polyval(inside, coefficients)
    assert robot.disturbance_torque((0.0, q))[1] == pytest.approx(expected, rel=1e-12, abs=1e-13)
    np.testing.assert_array_equal(robot.disturbance_torque((0.0, q)), robot.disturbance_torque((0.0, inside)))


@theorem
@given(st.data())
def test_a_cable_steps_where_it_says_and_nowhere_else(data: st.DataObject) -> None:
    cable = replace(data.draw(cables(dict(ELBOW))), range=None)
    robot, h = rrbot(cable), 1e-9
    jumps = dict(cable.jumps())
    for knot in cable.knots:
        right, left = (float(robot.disturbance_torque((0.0, q))[1]) for q in (knot, knot - h))
        assert right - left == pytest.approx(jumps.get(knot, 0.0), abs=1e-6)


def test_the_cable_of_the_published_page() -> None:
    """``if (q[3] < 0.05) tau[3] += ((q[3] - 0.05) * 0.1 - 0.07)``: a step of 0.07 N·m at 0.05 rad."""
    cable = PiecewiseCable(**ELBOW, knots=[0.05], pieces=[[-0.07, 0.1], [0.0]])
    assert cable.jumps() == (Jump(0.05, 0.07),)
    robot = rrbot(cable)
    for q, torque in ((-0.95, -0.17), (0.049, -0.0701), (0.05, 0.0), (1.0, 0.0)):
        assert robot.disturbance_torque((0.0, q)) == pytest.approx([0.0, torque], abs=1e-15)


def test_a_continuous_cable_has_no_jumps() -> None:
    assert PiecewiseCable(**ELBOW, knots=(0.0, 0.3), pieces=((0.1, 0.2), (0.1,), (0.1, -1.0, 3.0))).jumps() == ()


def test_the_forearm_of_a_parallelogram_moves_with_the_sum() -> None:
    spring = LinearSpring(name="forearm", joint="joint1", of=(1.0, 1.0), stiffness=2.0)
    np.testing.assert_allclose(rrbot(spring).disturbance_torque((0.25, 0.5)), (1.5, 0.0))


def test_a_spring_whose_ends_meet_has_no_torque() -> None:
    ends = {"body_a": "base", "point_a": (0.0, 0.0, 0.0), "body_b": "link1", "point_b": (-0.9, 0.0, 0.0)}
    robot = rrbot(SpringBetween(name="s", **ends, stiffness=100.0, rest_length=0.1))
    assert np.isfinite(robot.disturbance_torque((0.3, 0.4))).all()


# Any input


@theorem
@given(cases(), st.data())
def test_a_nan_in_what_an_element_reads_is_a_nan_in_what_it_does(case: Case, data: st.DataObject) -> None:
    element = data.draw(elements(case.spec, "element"))
    robot = rg.Robot(replace(case.spec, disturbances=(element,)))
    bad = np.full(robot.n, np.nan)
    acts = np.abs(
        ref.disturbance_regressor(
            replace(robot.spec, disturbances=(Constant(name="c", joint=element.joint, torque=1.0),)), case.q
        )
    )
    if isinstance(element, Constant):
        assert np.isfinite(robot.disturbance_torque(bad, bad)).all()
    else:
        assert np.isnan(robot.disturbance_torque(bad, bad)[acts[:, 0] > 0.0]).all()
    for wild in (np.inf, -np.inf, 1e308, -0.0, 1e-320):
        robot.disturbance_torque(np.full(robot.n, wild), np.full(robot.n, -wild))


def test_a_robot_without_elements_has_no_columns() -> None:
    robot = rg.load("rrbot")
    assert robot.disturbance_columns == ()
    assert robot.disturbance_regressor((0.1, 0.2)).shape == (2, 0)
    assert robot.disturbance_parameters().shape == (0,)
    np.testing.assert_array_equal(robot.disturbance_torque((0.1, 0.2)), (0.0, 0.0))
    np.testing.assert_array_equal(ref.disturbance_torque(robot.spec, (0.1, 0.2)), (0.0, 0.0))
    assert ref.disturbance_regressor(robot.spec, (0.1, 0.2)).shape == (2, 0)


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda robot: robot.disturbance_torque((0.1,)), "q has shape (1,)"),
        (lambda robot: robot.disturbance_torque((0.1, 0.2), (0.1, "x")), "qd"),
        (lambda robot: robot.disturbance_regressor((0.1, 0.2), out=np.zeros((2, 5))), "out has shape (2, 5)"),
        (lambda robot: robot.disturbance_torque(*np.zeros((2, 2)), out=np.zeros(2, np.float32)), "dtype float32"),
        (lambda robot: ref.disturbance_torque(robot.spec, (0.1,)), "q has shape (1,)"),
        (lambda robot: ref.disturbance_torque(robot.spec, (0.1, 0.2), (1.0,)), "qd has shape (1,)"),
    ],
)
def test_wrong_arguments_are_named(call: Callable[[rg.Robot], object], problem: str) -> None:
    with pytest.raises(rg.errors.ArgumentError) as caught:
        call(rrbot(Constant(**ELBOW, torque=1.0)))
    assert problem in str(caught.value)


def test_out_may_not_be_an_input() -> None:
    q, qd = np.zeros((2, 2))
    robot = rrbot(Constant(**ELBOW, torque=1.0))
    for shared in (q, qd):
        with pytest.raises(rg.errors.ArgumentError, match="shares memory"):
            robot.disturbance_torque(q, qd, shared)


# What is shown


def test_info_shows_the_elements(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    forearm = LinearSpring(name="forearm", joint="joint1", of=(1.0, 1.0), stiffness=2.0, source="made up")
    coil = {"body_a": "base", "point_a": (0.0, 0.0, 0.3), "body_b": "link2", "point_b": (0.0, 0.1, 0.0)}
    robot = rrbot(
        PiecewiseCable(**ELBOW, knots=(0.05,), pieces=((-0.07, 0.1), (0.0,)), range=(-1.0, 1.0)),
        Polynomial(name="push", joint="joint1", coefficients=(0.1, 0.2), direction="positive"),
        SpringBetween(name="coil", **coil, stiffness=271.0),
        forearm,
    )
    path = tmp_path / "arm.toml"
    robot.to_toml(path)
    assert main(["info", str(path)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    for text in ("beside the masses", "elbow", "JUMPS", "0.07", "positive", "271", "link2", "forearm", "made up"):
        assert text in shown
    assert main(["info", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["disturbances"]
    assert [element["kind"] for element in found] == ["cable", "polynomial", "spring", "linear_spring"]
    assert found[3]["of"] == [1.0, 1.0]


@theorem
@given(cases(), st.data())
def test_any_robot_with_elements_can_be_shown(case: Case, data: st.DataObject) -> None:
    spec = replace(case.spec, disturbances=data.draw(some(case.spec)))
    out = io.StringIO()
    show_robot(Console(width=300, file=out), rg.Robot(spec))
    assert all(element.name in out.getvalue() for element in spec.disturbances)


@theorem
@given(cases(), st.data())
def test_a_batch_is_the_single_call_for_every_sample(case: Case, data: st.DataObject) -> None:
    robot = rg.Robot(replace(case.spec, disturbances=data.draw(some(case.spec))))
    q, qd = case.q + np.linspace(-1.0, 1.0, 5)[:, np.newaxis], case.qd * np.linspace(-1.0, 1.0, 5)[:, np.newaxis]
    for single, batch in (
        (robot.disturbance_torque, robot.disturbance_torque_batch),
        (robot.disturbance_regressor, robot.disturbance_regressor_batch),
    ):
        together = batch(q, qd, threads=2)
        np.testing.assert_array_equal(together, [single(*row) for row in zip(q, qd, strict=True)])
        np.testing.assert_array_equal(batch(q), [single(row) for row in q])
        out = np.full_like(together, np.nan)
        assert batch(q, qd, out) is out
        np.testing.assert_array_equal(out, together)
