"""``ElasticGravity``: its conditions, its cycle, and what it makes of bad numbers."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastic_arm as arm
import ravengc as rg
from ravengc import elastic
from ravengc.elastic.alpha import proven_alpha
from ravengc.errors import ArgumentError, ConfigError, RavenGCError
from strategies import ACCELERATION, coordinates, robots

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.spec import RobotSpec

ROBOT = arm.two_links()
RAVEN, POSE = rg.load("raven2_gold"), np.array((math.pi / 4, math.pi / 2, 0.33))


def law(variant: str = "quasi_static", **options: Any) -> rg.ElasticGravity:
    given = {"robot": ROBOT, "stiffness": arm.STIFFNESS, "kp": arm.KP, **arm.LEVEL, **options}
    return rg.ElasticGravity(given.pop("robot"), given.pop("stiffness"), variant, **given)


def turning(spec: RobotSpec) -> RobotSpec:
    """The robot with a turning joint for every sliding one."""
    turns = (replace(link, joint="revolute") if link.joint == "prismatic" else link for link in spec.links)
    return replace(spec, links=tuple(turns))


def turned(degrees: float) -> np.ndarray:
    """Gravity for a base that is turned about the axis of the RAVEN's first joint."""
    axis, angle = np.array(RAVEN.base.rotation)[:, 2], math.radians(degrees)
    down = np.array((0.0, 0.0, -9.81))
    return down * math.cos(angle) - np.cross(axis, down) * math.sin(angle)


# Conditions


def test_the_numbers_of_the_arm_of_two_links() -> None:
    condition = law("biased").condition
    assert condition is not None
    assert condition.holds
    assert condition.alpha == pytest.approx(arm.ALPHA, abs=1e-9)
    assert condition.least == pytest.approx(17.537887, abs=1e-6)
    assert condition.spring == pytest.approx(80.0, rel=1e-14)
    assert condition.contraction == pytest.approx(0.2120, abs=5e-5)
    assert elastic.least_gain(arm.ALPHA, 80.0) == pytest.approx(38.483377, abs=1e-6)
    local = ROBOT.gravity_stiffness(arm.GOAL, arm.GRAVITY) / arm.STIFFNESS[:, None]
    assert np.abs(np.linalg.eigvals(local)).max() == pytest.approx(0.0811, abs=5e-4)
    theta_d = law().theta_desired(arm.GOAL, arm.GRAVITY)
    assert theta_d == pytest.approx((0.442778235, 0.5320376226), abs=1e-9)


@given(st.floats(0.1, 100.0), st.floats(1.01, 1e6))
def test_the_closed_form_is_the_condition_for_one_joint(alpha: float, ratio: float) -> None:
    spring = ratio * alpha
    gain = elastic.least_gain(alpha, spring)
    assert elastic.condition_for("biased", [spring], alpha, [gain]).least == pytest.approx(alpha, rel=1e-9)
    assert elastic.least_spring(alpha, gain) == pytest.approx(spring, rel=1e-6)
    # The same gain on every joint suffices where no spring is softer.
    several = elastic.condition_for("desired", [spring, 3.0 * spring], alpha, [1.001 * gain, 1.001 * gain])
    assert several.holds


@given(st.lists(st.floats(-1.0, 1.0), min_size=18, max_size=18))
def test_the_least_eigenvalue_is_that_of_the_matrix(entries: list[float]) -> None:
    a, b = np.reshape(entries, (2, 3, 3))
    springs, gains = a @ a.T + np.eye(3), 0.3 * b @ b.T + 0.1 * np.eye(3)
    found = elastic.condition_for("biased", springs, 1.0, gains)
    both = np.block([[springs, -springs], [-springs, springs + gains]])
    assert found.least == pytest.approx(np.linalg.eigvalsh(both)[0], rel=1e-9)
    assert found.spring == pytest.approx(np.linalg.eigvalsh(springs)[0], rel=1e-9)


def test_rigid_joints_need_twice_alpha() -> None:
    assert elastic.condition_for("biased", [math.inf], 3.0, [6.01]).holds
    assert not elastic.condition_for("biased", [math.inf], 3.0, [5.99]).holds
    assert elastic.least_gain(3.0, math.inf) == 6.0
    assert elastic.condition_for("quasi_static", [math.inf], 3.0).contraction == 0.0


@pytest.mark.parametrize("variant", ["desired", "motor", "biased"])
def test_a_gain_too_weak_is_refused_with_one_that_would_do(variant: str) -> None:
    says = r"\[\[K, -K\], \[-K, K \+ K_P\]\] is 9.377\d* N m/rad, gravity's stiffness is up to 16.9602; K_P of 38.48"
    with pytest.raises(ConfigError, match=says) as refused:
        law(variant, kp=0.5 * arm.KP)
    gain, rest = str(refused.value).split("K_P of ")[1].split(" on every joint would do, or ")
    factor = float(rest.split(" times")[0])
    assert law(variant, kp=[float(gain)] * 2).condition.holds
    assert law(variant, kp=0.5 * factor * arm.KP).condition.holds
    assert not elastic.condition_for(variant, arm.STIFFNESS, arm.ALPHA, 0.4999 * factor * arm.KP).holds
    assert law(variant, kp=0.5 * arm.KP, allow_unproven=True).condition.holds is False


def test_springs_softer_than_gravity_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"no K_P helps: the least eigenvalue of K, 15, must itself exceed 16.96\d+"):
        law("biased", stiffness=[100.0, 15.0])
    with pytest.raises(ConfigError, match=r"K is 15 N m/rad, .* up to 16.9602; springs of 16.9604 would do"):
        law(stiffness=[100.0, 15.0])
    assert law(stiffness=[100.0, 15.0], alpha=14.0).condition.holds
    assert law(stiffness=[100.0, 15.0], allow_unproven=True).condition.contraction > 1.0


def test_springs_that_would_do_are_named_where_there_are_some() -> None:
    with pytest.raises(ConfigError, match="or springs of") as refused:
        law("biased", stiffness=[40.0, 40.0], kp=[45.0, 45.0])
    spring = float(str(refused.value).split("springs of ")[1].split(" ")[0])
    assert law("biased", stiffness=[spring] * 2, kp=[45.0, 45.0]).condition.holds


def test_a_base_that_accelerates_needs_more() -> None:
    assert law("biased").condition.holds
    with pytest.raises(ConfigError, match=r"gravity's stiffness is up to 18.67\d+"):
        law("biased", field=10.8)


def test_gains_are_asked_for_where_the_condition_needs_them() -> None:
    with pytest.raises(ConfigError, match="variant 'biased' is proven stable for strong enough gains only: give kp"):
        law("biased", kp=None)
    assert law("biased", kp=None, allow_unproven=True).condition is None
    assert "not weighed" in repr(law("motor", kp=None, allow_unproven=True))
    assert law("quasi_static", kp=None).condition.holds
    assert "least eigenvalue of K is 80" in repr(law("link", kp=None))


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        ({"robot": RAVEN.spec}, ArgumentError, "robot is a RobotSpec; expected a Robot"),
        ({"variant": "tomei"}, ConfigError, "variant 'tomei' is unknown: choose 'desired', 'motor'"),
        ({"variant": "quasi-static"}, ConfigError, "did you mean 'quasi_static'"),
        ({"stiffness": [1.0]}, ConfigError, r"stiffness has shape \(1,\); expected 2 numbers or \(2, 2\)"),
        ({"stiffness": [100.0, 0.0]}, ConfigError, "stiffness is .*; expected positive numbers"),
        ({"stiffness": [100.0, 1e-320]}, ConfigError, "stiffness is .*; expected positive numbers"),
        ({"stiffness": [[1.0, 2.0], [0.0, 1.0]]}, ConfigError, "stiffness is no symmetric matrix"),
        ({"stiffness": [[1.0, 2.0], [2.0, 1.0]]}, ConfigError, "not positive definite: its least eigenvalue is -1"),
        ({"stiffness": "stiff"}, ArgumentError, "stiffness has dtype"),
        ({"kp": [math.nan, 1.0]}, ConfigError, "kp is .*; expected positive numbers"),
        ({"tilt": "some"}, ConfigError, "tilt 'some' is unknown: choose 'level', 'any'"),
        ({"field": -1.0}, ArgumentError, "field is -1.0; expected the largest gravity that occurs"),
        ({"field": math.nan}, ArgumentError, "field is nan"),
        ({"alpha": -1.0}, ArgumentError, "alpha is -1.0; expected gravity's stiffness"),
        ({"iterations": 65}, ArgumentError, "iterations is 65; expected a whole number from 1 to 64"),
        ({"tolerance": math.nan}, ArgumentError, "tolerance is nan; expected rad"),
        ({"allow_unproven": 1}, ArgumentError, "allow_unproven is an int; expected a bool"),
    ],
)
def test_what_cannot_be_meant_is_refused(change: dict[str, Any], kind: type[RavenGCError], message: str) -> None:
    with pytest.raises(kind, match=message):
        law(**change)


def test_the_core_refuses_the_same() -> None:
    """The compiled class is public under its own name too."""
    from ravengc import _core

    make: Callable[..., Any] = _core.ElasticGravity
    for stiffness in ([1.0, 0.0], [[1.0, 2.0], [2.0, 1.0]], [[1.0, 0.1], [0.0, 1.0]], [[1.0, 0.0], [0.0, math.inf]]):
        with pytest.raises(ConfigError, match="stiffness: "):
            make(ROBOT, stiffness, "motor", 0.1, 5, 1e-9)
    with pytest.raises(ConfigError, match=r"variant is 'moter'; choose .*; did you mean 'motor'"):
        make(ROBOT, [1.0, 1.0], "moter", 0.1, 5, 1e-9)
    with pytest.raises(ArgumentError, match=r"stiffness has shape \(3,\)"):
        make(ROBOT, [1.0, 1.0, 1.0], "motor", 0.1, 5, 1e-9)


# The cycle


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_the_torque_is_gravity_where_the_variant_takes_it(data: st.DataObject) -> None:
    spec = data.draw(robots(most=6))
    robot = rg.Robot(spec)
    theta, goal, q = (data.draw(coordinates(spec)) for _ in range(3))
    gravity = data.draw(ACCELERATION)
    springs = 1e3 * (1.0 + np.abs(robot.gravity_torque(goal, gravity)))
    sag = robot.gravity_torque(goal, gravity) / springs
    places = {"desired": goal, "motor": theta, "biased": theta - sag, "link": q}
    for variant, place in places.items():
        made = rg.ElasticGravity(robot, springs, variant, alpha=1.0, allow_unproven=True)
        found = made.torque(theta, goal, gravity, q)
        wanted = robot.gravity_torque(place, gravity)
        assert found == pytest.approx(wanted, abs=1e-9 * (1.0 + np.abs(wanted).max()))
        assert made.theta_desired(goal, gravity) == pytest.approx(goal + sag, abs=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_the_fixed_point_solves_its_equation_to_its_bound(data: st.DataObject) -> None:
    """Any arm that turns, any tilt, any springs that the condition takes: q = theta - K^-1 g(q) as close as is said."""
    spec = turning(data.draw(robots(most=6)))
    robot, gravity = rg.Robot(spec), data.draw(ACCELERATION)
    theta, field = data.draw(coordinates(spec)), float(np.linalg.norm(gravity))
    alpha = proven_alpha(robot, field=field)
    ratios = data.draw(st.lists(st.floats(1.05, 100.0), min_size=robot.n, max_size=robot.n))
    springs = (alpha + 1e-9) * np.array(ratios)
    tolerance = data.draw(st.sampled_from((0.0, 1e-9, 1e-4)))
    made = rg.ElasticGravity(robot, springs, field=field, iterations=64, tolerance=tolerance)
    torque = made.torque(theta, theta, gravity)
    q = made.link_position(theta, gravity)
    assert made.iterations <= 64
    left = np.linalg.norm(theta - robot.gravity_torque(q, gravity) / springs - q)
    assert left <= (1.0 + made.condition.contraction) * made.error_bound + 1e-11
    again = robot.gravity_torque(q, gravity)
    assert torque == pytest.approx(again, abs=alpha * 2.0 * made.error_bound + 1e-11 * (1.0 + np.abs(again).max()))


def test_stiffer_joints_make_the_variants_one() -> None:
    theta = arm.GOAL + 0.01
    rigid = ROBOT.gravity_torque(theta, arm.GRAVITY)
    for stiff in (1e3, 1e5, 1e7, math.inf):
        off = [
            np.abs(law(variant, stiffness=[stiff, stiff]).torque(theta, arm.GOAL, arm.GRAVITY, theta) - rigid).max()
            for variant in ("motor", "biased", "quasi_static", "link")
        ]
        assert max(off) <= 300.0 / stiff


def test_encoders_on_the_motors_do_not_see_the_cables() -> None:
    """PD + dynamic gravity on a RAVEN whose first joint's cables give 1 rad per 2000 N m: what is left of the link."""
    for spring, level, tilted in ((2000.0, 0.026, 0.055), (500.0, 0.106, 0.220)):
        cables = rg.ElasticGravity(RAVEN, [spring, 1e9, 1e9])
        for gravity, degrees in ((turned(0.0), level), (turned(20.0), tilted)):
            off = POSE - cables.link_position(POSE, gravity)
            assert abs(math.degrees(off[0])) == pytest.approx(degrees, abs=1.1e-3)
            assert off[1:] == pytest.approx((0.0, 0.0), abs=1e-8)
            # Motors aimed where the law says leave nothing of it.
            theta_d = cables.theta_desired(POSE, gravity)
            assert cables.link_position(theta_d, gravity) == pytest.approx(POSE, abs=1e-9)


def test_gravity_may_be_any_that_the_core_takes() -> None:
    made = law()
    wanted = made.torque(arm.GOAL, arm.GOAL, arm.GRAVITY)
    for gravity in (rg.Gravity(0.0, 0.0, -9.81), rg.SpecificForce(0.0, 0.0, 9.81), np.array(arm.GRAVITY)):
        made.reset()
        assert (made.torque(arm.GOAL, arm.GOAL, gravity) == wanted).all()


def test_a_warm_start_takes_fewer_steps_and_reset_forgets_it() -> None:
    made = law(tolerance=1e-6)
    made.torque(arm.GOAL, arm.GOAL, arm.GRAVITY)
    cold = made.iterations
    made.torque(arm.GOAL, arm.GOAL, arm.GRAVITY)
    assert made.iterations == 1 < cold
    assert made.error_bound <= 1e-6
    made.reset()
    assert (made.iterations, made.error_bound) == (0, 0.0)
    made.torque(arm.GOAL, arm.GOAL, arm.GRAVITY)
    assert made.iterations == cold


def test_a_field_beyond_the_declared_one_shows_in_the_bound() -> None:
    made = law(iterations=1)
    bounds = []
    for strength in (1.0, 4.0, 4.8):
        made.reset()
        made.torque(arm.GOAL, arm.GOAL, strength * np.array(arm.GRAVITY))
        bounds.append(made.error_bound)
    assert bounds[0] < bounds[1] / 4.0 < math.inf
    assert bounds[2] == math.inf


@pytest.mark.parametrize("variant", elastic.VARIANTS)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_bad_cycle_has_no_torque_and_leaves_no_trace(variant: str, bad: float) -> None:
    made, twin = law(variant), law(variant)
    for each in (made, twin):
        each.torque(arm.GOAL, arm.GOAL, arm.GRAVITY, arm.GOAL)
    broken = np.array((bad, 0.5))
    assert np.isnan(made.torque(broken, broken, arm.GRAVITY, broken)).any()
    assert np.isnan(made.torque(arm.GOAL, arm.GOAL, (0.0, bad, -9.81), arm.GOAL)).any()
    good = made.torque(arm.GOAL, arm.GOAL, arm.GRAVITY, arm.GOAL)
    assert np.isfinite(good).all()
    assert (good == twin.torque(arm.GOAL, arm.GOAL, arm.GRAVITY, arm.GOAL)).all()
    assert (made.iterations, made.error_bound) == (twin.iterations, twin.error_bound)


def test_the_links_are_asked_for_where_they_are_read() -> None:
    with pytest.raises(ArgumentError, match="variant 'link' takes gravity where the links are: give their positions q"):
        law("link").torque(arm.GOAL, arm.GOAL, arm.GRAVITY)
    array = np.zeros(2)
    with pytest.raises(ArgumentError, match="give their positions q"):
        law("link").bind(theta=array, q_desired=np.zeros(2), gravity=np.zeros(3), out=np.zeros(2))


# Bound to arrays


def arrays(**more: np.ndarray) -> dict[str, np.ndarray]:
    theta, goal = arm.GOAL + 0.1, arm.GOAL.copy()
    return {"theta": theta, "q_desired": goal, "gravity": np.array(arm.GRAVITY), "out": np.zeros(2), **more}


@pytest.mark.parametrize("variant", elastic.VARIANTS)
def test_a_bound_cycle_computes_as_calls_do(variant: str) -> None:
    bound, called = law(variant), law(variant)
    held = arrays(q=np.array((0.2, 0.4)), theta_desired=np.zeros(2))
    cycle = bound.bind(**held)
    for _ in range(3):
        cycle()
        wanted = called.torque(held["theta"], held["q_desired"], held["gravity"], held["q"])
        assert (held["out"] == wanted).all()
        assert (held["theta_desired"] == called.theta_desired(held["q_desired"], held["gravity"])).all()
        assert bound.iterations == called.iterations
        held["theta"] += 0.01
        held["gravity"] += 0.1


def test_a_bound_cycle_holds_its_arrays_to_what_they_were() -> None:
    held = arrays()
    cycle = law().bind(**held)
    held["theta"].resize(3, refcheck=False)
    with pytest.raises(ArgumentError, match="bind again"):
        cycle()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"out": np.zeros(3)}, r"out has shape \(3,\)"),
        ({"gravity": np.zeros(2)}, r"gravity has shape \(2,\)"),
        ({"theta": [0.0, 0.0]}, "theta is a list; expected a float64 array"),
        ({"theta_desired": np.zeros(2, dtype=np.float32)}, "theta_desired has dtype float32"),
    ],
)
def test_arrays_that_cannot_be_bound_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        law().bind(**{**arrays(), **change})


def test_gravity_from_a_live_sensor_in_the_same_call() -> None:
    chain, held = rg.Accelerometer(start_count=1, gravity_rate=1e6), arrays()
    law("motor").bind(**{**held, "gravity": chain})()
    level = law("motor").torque(held["theta"], held["q_desired"], rg.Gravity.level())
    np.testing.assert_allclose(held["out"], level, rtol=1e-12)
    assert chain.counters["no_sensor"] == 0


def test_outputs_have_memory_of_their_own() -> None:
    held, shared = arrays(), np.zeros(2)
    for change in (
        {"out": held["theta"]},
        {"theta_desired": held["q_desired"]},
        {"out": shared, "theta_desired": shared},
    ):
        with pytest.raises(ArgumentError, match="shares memory"):
            law().bind(**{**held, **change})
    theta = arm.GOAL.copy()
    with pytest.raises(ArgumentError, match="out shares memory"):
        law().torque(theta, arm.GOAL, arm.GRAVITY, out=theta)
    out = np.zeros(2)
    assert law().torque(theta, arm.GOAL, arm.GRAVITY, None, out) is out
    assert law().theta_desired(theta, arm.GRAVITY, out) is out
    assert law().link_position(theta, arm.GRAVITY, out) is out


def test_the_front_opens_the_door() -> None:
    assert rg.ElasticGravity is elastic.ElasticGravity
    assert rg.elastic is elastic
