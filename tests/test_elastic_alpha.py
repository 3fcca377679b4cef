"""How stiff gravity can be: what is proven is never too small, what is found is attained."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastic_arm as arm
import ravengc as rg
from ravengc import config, elastic
from ravengc.coordinates import sliding
from ravengc.elastic.alpha import proven_alpha
from ravengc.errors import ArgumentError, ConfigError
from ravengc.spec import CouplingSpec, DhRow, JointLimits, LinkSpec, RobotSpec
from strategies import coordinates, robots

G = rg.STANDARD_GRAVITY
SERIAL = ("raven2_gold", "raven2_green_wrist", "panda", "pa10", "rrbot", "dvrk_ecm", "dvrk_mtml")


def limited(spec: RobotSpec, reach: float = math.pi) -> RobotSpec:
    """The robot with limits on everything that it has."""
    limits = JointLimits(lower=-reach, upper=reach)
    links = tuple(replace(link, limits=limits) if link.joint != "fixed" else link for link in spec.links)
    coupling = spec.coupling and replace(spec.coupling, limits=(limits,) * len(spec.coupling.coordinates))
    return replace(spec, links=links, coupling=coupling)


def stiffness(robot: rg.Robot, q: np.ndarray, gravity: np.ndarray) -> float:
    return float(np.linalg.norm(robot.gravity_stiffness(q, gravity), 2))


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_gravity_is_never_stiffer_than_proven(data: st.DataObject) -> None:
    """Any tree of bodies, coupled or not, anywhere within its limits, on a base that stands anyhow."""
    spec = limited(data.draw(robots()))
    robot, q = rg.Robot(spec), data.draw(coordinates(spec))
    direction = np.array(data.draw(st.tuples(*[st.floats(-1.0, 1.0)] * 3)))
    gravity = G * direction / max(1.0, np.linalg.norm(direction))
    proven = proven_alpha(robot)
    assert stiffness(robot, q, gravity) <= proven * (1.0 + 1e-9) + 1e-11
    level = proven_alpha(robot, tilt="level")
    assert stiffness(robot, q, np.array((0.0, 0.0, -G))) <= level * (1.0 + 1e-9) + 1e-11
    assert level <= proven * (1.0 + 1e-9)


@pytest.mark.parametrize("name", SERIAL)
def test_what_is_found_is_attained_and_near_what_is_proven(name: str) -> None:
    robot = rg.load(name)
    for tilt, slack in (("level", 2.0), ("any", 2.2)):
        found = elastic.stiffest_gravity(robot, tilt=tilt)
        assert stiffness(robot, found.q, found.gravity) == pytest.approx(found.found, rel=1e-12)
        assert np.linalg.norm(found.gravity) == pytest.approx(G, rel=1e-12)
        assert found.found <= found.proven <= slack * found.found
        if tilt == "level":
            assert tuple(found.gravity) == (0.0, 0.0, -G)
        for limit, x, slides in zip(robot.spec.coordinate_limits, found.q, sliding(robot.spec), strict=True):
            assert not slides or limit.lower <= x <= limit.upper


@pytest.mark.parametrize("name", ["raven2_gold", "rrbot", "pa10"])
def test_no_random_pose_is_stiffer_than_the_one_found(name: str) -> None:
    """A climb from many poses: 100,000 others are no stiffer."""
    robot, draw, samples = rg.load(name), np.random.default_rng(1), 100_000
    limits, slides = robot.spec.coordinate_limits, sliding(robot.spec)
    low = np.where(slides, [limit.lower or 0.0 for limit in limits], -math.pi)
    high = np.where(slides, [limit.upper or 0.0 for limit in limits], math.pi)
    q, down = draw.uniform(low, high, (samples, robot.n)), draw.normal(size=(samples, 3))
    gravity = G * down / np.linalg.norm(down, axis=1, keepdims=True)
    largest = np.abs(np.linalg.eigvalsh(robot.gravity_stiffness_batch(q, gravity))).max()
    assert largest <= elastic.stiffest_gravity(robot).found * (1.0 + 1e-9)


def test_an_arm_in_a_plane_attains_what_is_proven() -> None:
    robot = arm.two_links()
    for tilt in ("level", "any"):
        found = elastic.stiffest_gravity(robot, tilt=tilt, field=9.81)
        assert found.found == pytest.approx(arm.ALPHA, abs=1e-8)
        assert found.proven == pytest.approx(arm.ALPHA, abs=1e-8)


def test_alpha_grows_with_the_field_the_payload_and_the_tilt() -> None:
    robot = rg.load("panda")
    one = elastic.stiffest_gravity(robot, tilt="level", searches=4)
    twice = elastic.stiffest_gravity(robot, tilt="level", searches=4, field=2.0 * G)
    assert (twice.proven, twice.found) == pytest.approx((2.0 * one.proven, 2.0 * one.found), rel=1e-9)
    assert elastic.stiffest_gravity(robot, searches=4).found > one.found
    robot.set_payload(3.0, (0.0, 0.0, 0.1))
    loaded = elastic.stiffest_gravity(robot, tilt="level", searches=4)
    assert loaded.proven > one.proven + 3.0 * G * 0.1
    assert loaded.found > one.found
    robot.clear_payload()
    assert elastic.stiffest_gravity(robot, tilt="level", searches=4).proven == one.proven
    # A base that is mounted on a wall is no longer level to gravity.
    robot.set_base(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))
    assert elastic.stiffest_gravity(robot, tilt="level", searches=4).proven > one.proven


def test_no_gravity_is_not_stiff() -> None:
    robot = rg.load("panda")
    assert elastic.stiffest_gravity(robot, field=0.0).proven == 0.0
    assert rg.ElasticGravity(robot, np.full(7, 1.0), field=0.0).condition.holds


def test_a_search_is_repeatable() -> None:
    robot = rg.load("raven2_gold")
    one, same = elastic.stiffest_gravity(robot, seed=7), elastic.stiffest_gravity(robot, seed=7)
    assert one.found == same.found
    assert (one.q == same.q).all()


def sliding_arm(limits: JointLimits) -> RobotSpec:
    """A slide on a turning link: the farther out, the stiffer."""
    turn = LinkSpec(name="turn", joint_name="pivot", placement=DhRow(alpha=math.pi / 2), mass=1.0, com=(0.1, 0.0, 0.0))
    slide = LinkSpec(name="slide", joint_name="rail", parent="turn", joint="prismatic", mass=2.0, limits=limits,
                     placement=DhRow(alpha=math.pi / 2, a=0.2))  # fmt: skip
    return RobotSpec(name="rail", convention="modified", links=(turn, slide))


def test_shifts_need_limits() -> None:
    with pytest.raises(ConfigError, match=r"no bound: 'rail' can slide without limits; give lower and upper"):
        elastic.stiffest_gravity(rg.Robot(sliding_arm(JointLimits(lower=0.0))))
    found = elastic.stiffest_gravity(rg.Robot(sliding_arm(JointLimits(lower=0.0, upper=1.5))))
    assert found.q[1] == pytest.approx(1.5)
    # |d2g1/dq1| = g |m c + 2 (a, d)|: both the offset and the shift count.
    assert found.found >= G * math.hypot(0.1 + 2.0 * 0.2, 2.0 * 1.5) * (1.0 - 1e-9)
    assert found.proven <= 1.3 * found.found


def test_a_coupled_shift_slides_as_far_as_its_coordinates_let_it() -> None:
    spec = sliding_arm(JointLimits())
    coupling = CouplingSpec(coordinates=("a", "b"), matrix=((1.0, 0.0), (0.5, 2.0)), offset=(0.0, 0.1))
    with pytest.raises(ConfigError, match="'a', 'b' can slide without limits"):
        elastic.stiffest_gravity(rg.Robot(replace(spec, coupling=coupling)))
    limits = (JointLimits(lower=-1.0, upper=1.0), JointLimits(lower=0.0, upper=0.5))
    robot = rg.Robot(replace(spec, coupling=replace(coupling, limits=limits)))
    most = elastic.stiffest_gravity(robot)
    assert most.found <= most.proven < math.inf


@pytest.mark.parametrize("name", config.bundled_names())
def test_every_bundled_robot_has_a_bound(name: str) -> None:
    assert 0.0 <= elastic.stiffest_gravity(rg.load(name), searches=1).proven < 1e3


def test_what_cannot_be_meant_is_refused() -> None:
    robot = rg.load("rrbot")
    with pytest.raises(ArgumentError, match="searches is 0; expected a whole number from 1"):
        elastic.stiffest_gravity(robot, searches=0)
    with pytest.raises(ArgumentError, match=r"seed is 0\.5; expected a whole number"):
        elastic.stiffest_gravity(robot, seed=0.5)
    with pytest.raises(ConfigError, match="tilt 'flat' is unknown"):
        elastic.stiffest_gravity(robot, tilt="flat")
    with pytest.raises(ArgumentError, match="field is inf; expected the largest gravity"):
        elastic.stiffest_gravity(robot, field=math.inf)
