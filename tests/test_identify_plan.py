"""Plans of an identification: what they choose, what they predict, and that this is what then happens."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc as rg
from ravengc import identify
from ravengc.errors import ArgumentError, CalibrationError, ConfigError
from ravengc.identify import Model, plan, plan_trajectory, predict_uncertainty
from ravengc.identify.plan_choice import START, choose
from ravengc.identify.plan_order import short_moves, travel
from ravengc.identify.plan_space import directions, forces, standing
from ravengc.recordings import read_recording
from ravengc.spec import DhRow, JointLimits, LinkSpec, RobotSpec

if TYPE_CHECKING:
    from pathlib import Path

TEN = np.radians(10.0)
LEVEL = 9.80665


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 12))
def test_an_exchange_never_lowers_the_determinant(seed: int, count: int) -> None:
    blocks = np.random.default_rng(seed).normal(size=(40, 2, 5))
    choice = choose(blocks, count)
    assert len(set(choice.chosen)) == count
    assert np.all(np.diff(choice.history) > 0.0)
    information = START * np.eye(5) + sum(blocks[place].T @ blocks[place] for place in choice.chosen)
    assert choice.history[-1] == pytest.approx(np.linalg.slogdet(information)[1], abs=1e-6)


def test_no_single_exchange_is_left_that_would_help() -> None:
    blocks = np.random.default_rng(5).normal(size=(25, 2, 4))
    choice = choose(blocks, 6)
    for place in range(6):
        for other in set(range(25)) - set(choice.chosen):
            changed = [*choice.chosen[:place], other, *choice.chosen[place + 1 :]]
            information = START * np.eye(4) + sum(blocks[one].T @ blocks[one] for one in changed)
            assert np.linalg.slogdet(information)[1] < choice.history[-1] + 2e-3


def test_chosen_poses_show_more_than_random_ones() -> None:
    robot = rg.load("panda")
    planned = plan(robot, poses=20)
    random = np.random.default_rng(0)
    q = random.uniform(planned.ranges[:, 0], planned.ranges[:, 1], (20, 7))
    sides = directions(TEN)[random.integers(0, 8, 20)]
    worst = predict_uncertainty(robot, Model(), standing(q, sides)).worst
    assert np.all(planned.predicted.worst < worst)
    assert planned.condition < 4.0  # random ones have 5 and more


def test_poses_lie_within_limits_and_ranges_and_efforts() -> None:
    robot = rg.load("dvrk_mtmr")
    narrow = {"elbow_pitch": (-0.2, 0.3)}
    planned = plan(robot, poses=25, ranges=narrow)
    for place, (limit, name) in enumerate(zip(robot.spec.coordinate_limits, planned.joints, strict=True)):
        lower, upper = narrow.get(name, (limit.lower, limit.upper))
        assert lower <= planned.q[:, place].min() <= planned.q[:, place].max() <= upper
    torques = robot.gravity_torque_batch(planned.q, -forces(planned.tilts))
    assert np.all(np.abs(torques) <= [limit.effort for limit in robot.spec.coordinate_limits])
    assert len(planned.q) == len(planned.tilts) == 25
    up = forces(planned.tilts)[:, 2] / LEVEL
    assert np.all(up > np.cos(TEN) - 1e-12)


def test_a_base_that_is_not_tilted_leaves_joint_one_of_the_mtm_open_and_a_tilted_one_does_not() -> None:
    planned = plan(rg.load("dvrk_mtmr"), poses=20)
    assert np.isinf(planned.level.worst[0])
    assert np.isfinite(planned.level.worst[1:]).all()
    assert planned.level.sd[0, 0] < 1e-12  # level it carries nothing
    assert planned.predicted.worst.max() < 0.02
    assert planned.base.rank == 14
    assert "no joint torque" in planned.base.unidentifiable[0]
    level = plan(rg.load("dvrk_mtmr"), poses=20, tilt=0.0)
    assert level.base.rank == 12
    assert "tilt the base" in level.base.unidentifiable[0]
    assert np.isinf(level.predicted.worst[0])
    assert level.attitudes.tolist() == [[0.0, 0.0]]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("limits", [JointLimits(), JointLimits(lower=0.0, upper=0.3)])
def test_a_slide_that_lies_level_is_open_on_a_level_base(limits: JointLimits) -> None:
    """Gravity's part along it is the rounding of cos 90 degrees, which shows nothing; it may have no limits."""
    turning = LinkSpec(name="a", placement=DhRow(), mass=1.0, com=(0.1, 0.0, 0.0))
    sliding = LinkSpec(
        name="b", parent="a", joint="prismatic", placement=DhRow(alpha=np.pi / 2.0), mass=1.0, limits=limits
    )
    robot = rg.Robot(RobotSpec(name="slider", convention="modified", links=(turning, sliding)))
    found = plan(robot, Model(), ranges={"b": (0.0, 0.3)}, tilt=TEN, candidates=60)
    assert np.isinf(found.level.worst).all()
    assert (found.predicted.worst < 0.1).all()


def cables(robot: rg.Robot) -> Model:
    """Cables as in the identification that Lin et al. published for the MTM."""
    names = robot.spec.coordinate_names[:6]
    degrees = {name: (0, 1) if name == "shoulder_pitch" else (0, 1, 2, 3, 4) for name in names}
    return Model(elements=tuple(identify.polynomial(name, some) for name, some in degrees.items()))


def test_cables_hide_gravity_on_a_level_base_alone() -> None:
    """The shoulder's gravity and its cable look alike over the few degrees that the published calibration sweeps."""
    robot = rg.load("dvrk_mtmr")
    planned = plan(robot, cables(robot), poses=30, ranges={"shoulder_pitch": tuple(np.radians([-11.0, 16.0]))})
    assert planned.predicted.worst[1] < 0.01
    assert planned.level.worst[1] > 0.3
    assert planned.level.sd[0, 1] < 0.01


@pytest.mark.parametrize("name", ["raven2_gold", "dvrk_mtmr"])
def test_the_predicted_uncertainty_is_what_noise_does(name: str) -> None:
    """Simulated: torques of the plan with white noise, identified, against the true torques at the worst tilt."""
    robot = rg.load(name)
    noise = np.linspace(0.01, 0.03, robot.n)
    planned = plan(robot, poses=15, noise=noise)
    clean = planned.recording()
    exact = robot.gravity_torque_batch(clean.q, -clean.specific_force)
    random = np.random.default_rng(2)
    q = random.uniform(planned.ranges[:, 0], planned.ranges[:, 1], (30, robot.n))
    whole = predict_uncertainty(robot, Model(), clean, noise=noise, poses=q).sd[-1]
    sides = [standing(q, np.tile(side, (30, 1))) for side in directions(TEN)]
    base = identify.base_parameters(robot, Model(), "tilted")
    X = Model().regressor(robot, clean)[:, base.chosen] / np.tile(noise, 15)[:, np.newaxis]
    pinv = np.linalg.pinv(X)
    errors = []
    for _ in range(400):
        tau = exact + noise * random.normal(size=exact.shape)
        values = pinv @ (tau / noise).ravel() - base.K @ Model().prior(robot)
        errors.append([(Model().regressor(robot, side)[:, base.chosen] @ values).reshape(30, -1) for side in sides])
    spread = np.sqrt((np.array(errors) ** 2).mean(axis=(0, 2))).max(axis=0)
    np.testing.assert_allclose(spread, whole, rtol=0.1)


def test_poses_on_one_tilt_follow_each_other_in_short_moves() -> None:
    planned = plan(rg.load("panda"), poses=24)
    assert len(planned.attitudes) == len(np.unique(planned.tilts, axis=0)) <= 5
    random = np.random.default_rng(1)
    for attitude in planned.attitudes:
        here = planned.q[(planned.tilts == attitude).all(axis=1)]
        shuffled = np.mean([travel(random.permutation(here), planned.ranges) for _ in range(20)])
        assert travel(here, planned.ranges) <= shuffled + 1e-12


def test_short_moves_go_along_a_line() -> None:
    line = np.linspace(0.0, 1.0, 9)[:, np.newaxis]
    mixed = line[np.random.default_rng(3).permutation(9)]
    order = short_moves(mixed, np.array([[0.0, 1.0]]), np.zeros(1))
    np.testing.assert_array_equal(mixed[order], line)


def test_the_same_seed_gives_the_same_plan_and_progress_ends() -> None:
    robot, seen = rg.load("raven2_gold"), []
    one = plan(robot, poses=8, seed=3, on_progress=lambda done, total: seen.append((done, total)))
    two = plan(robot, poses=8, seed=3)
    np.testing.assert_array_equal(one.q, two.q)
    assert seen[-1][0] == seen[-1][1]
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


def test_a_plan_is_written_whole(tmp_path: Path) -> None:
    planned = plan(rg.load("raven2_gold"), poses=6)
    planned.write(tmp_path / "poses.csv")
    planned.write(tmp_path / "plan.toml")
    lines = (tmp_path / "poses.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "pose,roll,pitch,gx,gy,gz,q.shoulder,q.elbow,q.insertion"
    numbers = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    np.testing.assert_allclose(numbers[:, 6:], planned.q, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(numbers[:, 3:6], axis=1), LEVEL, atol=1e-7)
    table = tomllib.loads((tmp_path / "plan.toml").read_text(encoding="utf-8"))
    assert table["robot"] == "raven2_gold"
    assert len(table["pose"]) == 6
    with pytest.raises(ConfigError, match=r"\.csv or \.toml"):
        planned.write(tmp_path / "plan.txt")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.toml", "poses.csv"]


@pytest.mark.parametrize("name", ["raven2_gold", "panda", "dvrk_mtmr"])
def test_a_motion_keeps_to_its_limits_and_starts_and_ends_at_rest(name: str) -> None:
    robot = rg.load(name)
    planned = plan_trajectory(robot, rounds=20, harmonics=3, acceleration=2.0)
    q, qd, qdd = planned.at(np.linspace(0.0, planned.period, 5001))
    assert np.all(q >= planned.ranges[:, 0])
    assert np.all(q <= planned.ranges[:, 1])
    assert np.all(np.abs(qd) <= planned.velocity)
    assert np.all(np.abs(qdd) <= 2.0)
    for place, limit in enumerate(robot.spec.coordinate_limits):
        assert limit.lower <= planned.ranges[place, 0] < planned.ranges[place, 1] <= limit.upper
        assert planned.velocity[place] <= (limit.velocity or np.inf)
    np.testing.assert_allclose([qd[0], qd[-1], qdd[0], qdd[-1]], 0.0, atol=1e-10)
    np.testing.assert_allclose(q[0], q[-1], atol=1e-10)


def test_velocities_and_accelerations_of_a_motion_are_its_derivatives() -> None:
    planned = plan_trajectory(rg.load("raven2_gold"), rounds=0, harmonics=3)
    t = np.linspace(0.0, 20.0, 20_001)
    q, qd, qdd = planned.at(t)
    np.testing.assert_allclose(np.gradient(q, t, axis=0)[1:-1], qd[1:-1], atol=1e-5)
    np.testing.assert_allclose(np.gradient(qd, t, axis=0)[1:-1], qdd[1:-1], atol=1e-5)


def test_the_search_lowers_the_condition() -> None:
    robot = rg.load("raven2_gold")
    planned = plan_trajectory(robot, rounds=150)
    assert planned.condition < 0.5 * planned.start_condition
    again = plan_trajectory(robot, rounds=300)
    assert again.condition < 0.4 * again.start_condition


def test_a_motion_on_tilts_shows_what_the_level_one_does_not() -> None:
    robot = rg.load("panda")
    planned = plan_trajectory(robot, tilt=TEN, rounds=5)
    assert planned.base.rank == 45 + 7 * 3  # friction
    assert np.isinf(planned.level.worst[0])
    assert np.isfinite(planned.predicted.worst).all()
    whole = planned.recording()
    assert whole.samples == 5 * 200
    simulated = replace(whole, tau=robot.inverse_dynamics_batch(whole.q, whole.qd, whole.qdd, whole.base))
    found = identify.identify(robot, simulated, Model(kind="dynamics"))
    assert found.held_out.overall < 1e-8


def test_a_motion_is_written_so_that_it_can_be_read_as_one(tmp_path: Path) -> None:
    planned = plan_trajectory(rg.load("raven2_gold"), rounds=0, period=10.0)
    planned.write(tmp_path / "motion.csv")
    planned.write(tmp_path / "motion.toml")
    read = read_recording(tmp_path / "motion.csv")
    np.testing.assert_allclose(read.q, planned.at(read.t)[0], atol=1e-8)
    table = tomllib.loads((tmp_path / "motion.toml").read_text(encoding="utf-8"))
    assert np.array(table["motion"]["sines"]).shape == (3, 5)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"poses": 0}, ArgumentError, "poses is 0"),
        ({"tilt": 10.0}, ArgumentError, "tilt is 10.0; expected 0 to 1.571 rad"),
        ({"noise": 0.0}, ArgumentError, "noise is 0.0; expected one positive number, or 3"),
        ({"ranges": {"elbo": (0, 1)}}, ConfigError, "did you mean 'elbow'"),
        ({"ranges": {"elbow": (1, 0)}}, ArgumentError, "expected the least before the most"),
        ({"ranges": {"elbow": (0.9, 9)}}, ConfigError, "the joint's limits are"),
        ({"tilts": [[0.1, 0.2, 0.3]]}, ArgumentError, "expected .k, 2., roll and pitch"),
        ({"candidates": [[0.0, 0.0]]}, ArgumentError, r"expected \(c, 3\)"),
        ({"candidates": [[9.0, 9.0, 9.0]]}, CalibrationError, "widen the ranges, or tilt less"),
        ({"candidates": 3, "poses": 99}, ArgumentError, "there are"),
        ({"model": Model(friction=("coulomb",), links=())}, ArgumentError, "no parameter that poses"),
    ],
)
def test_plans_that_cannot_be_are_refused(options: dict[str, object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        plan(rg.load("raven2_gold"), **options)


def test_friction_is_not_planned_for_at_rest() -> None:
    planned = plan(rg.load("raven2_gold"), Model(kind="gravity+friction"), poses=12)
    assert not any("coulomb" in name for name in planned.base.names)
    assert "record a motion" in planned.base.unidentifiable[0]
    assert "coulomb" in planned.base.unidentifiable[0]
