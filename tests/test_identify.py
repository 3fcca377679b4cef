"""Identification: what torques show, what they do not, and what a fit of them finds."""

from __future__ import annotations

import numpy as np
import pytest

import ravengc as rg
from ravengc import identify
from ravengc.identify import Model, Recording, base_parameters

LEVEL = 9.80665


def static(robot: rg.Robot, poses: int, tilt: float, noise: float = 0.0, seed: int = 0) -> Recording:
    """Random poses within the limits, on a base tilted by up to ``tilt`` rad, held by the torques of the robot's file."""
    random = np.random.default_rng(seed)
    q = np.array([random.uniform(limit.lower, limit.upper, poses) for limit in robot.spec.coordinate_limits]).T
    lean = random.uniform(-tilt, tilt, (2, poses))
    force = LEVEL * np.array([np.sin(lean[0]), np.cos(lean[0]) * np.sin(lean[1]), np.cos(lean[0]) * np.cos(lean[1])]).T
    tau = robot.gravity_torque_batch(q, -force) + noise * random.normal(size=q.shape)
    return Recording(stamps=np.arange(float(poses)), q=q, tau=tau, specific_force=np.ascontiguousarray(force))


@pytest.mark.parametrize(
    ("name", "level", "tilted"),
    [
        ("raven2_gold", 5, 5),
        ("pa10", 10, 12),
        ("panda", 12, 14),
        ("dvrk_mtml", 12, 14),
        ("dvrk_mtmr", 12, 14),
        ("dvrk_psm_si", 5, 5),
        ("dvrk_ecm_si", 5, 5),
        ("rrbot", 4, 4),
        ("rrbot_modified", 4, 4),
    ],
)
def test_gravity_shows_as_many_base_parameters_as_published(name: str, level: int, tilted: int) -> None:
    robot = rg.load(name)
    assert [base_parameters(robot, Model(), words).rank for words in ("level", "tilted")] == [level, tilted]


def test_gravity_along_joint_one_hides_two_of_ravens_five() -> None:
    robot = rg.load("raven2_gold")
    along = LEVEL * np.array([robot.base.rotation])[:, :, 2]
    assert base_parameters(robot, Model(), along).rank == 3
    assert base_parameters(robot, Model(), np.vstack([along, [0.0, 0.0, LEVEL]])).rank == 5


@pytest.mark.parametrize(("name", "ranks"), [("raven2_gold", (14, 14, 18)), ("panda", (43, 45, 49))])
def test_motion_shows_more_and_a_rocking_base_four_more_still(name: str, ranks: tuple[int, ...]) -> None:
    robot, model = rg.load(name), Model(kind="dynamics", friction=())
    assert tuple(base_parameters(robot, model, words).rank for words in ("level", "tilted", "rocking")) == ranks


def test_what_is_not_shown_is_named_with_what_would_show_it() -> None:
    found = base_parameters(rg.load("panda"), Model(), "level")
    tilt, never = found.unidentifiable
    assert tilt.startswith("panda_link1.hx; panda_link1.hy + panda_link2.hz: tilt the base")
    assert never.startswith("panda_link1.m, panda_link1.hz, panda_link2.m: no joint torque")


def test_the_base_parameters_predict_what_all_parameters_do() -> None:
    robot, model = rg.load("panda"), Model(kind="dynamics")
    found = base_parameters(robot, model, "level")
    random = np.random.default_rng(1)
    q, qd, qdd = random.normal(size=(3, 9, 7))
    recording = Recording(stamps=np.arange(9.0), q=q, qd=qd, qdd=qdd, tau=np.zeros((9, 7)))
    regressor, parameters = model.regressor(robot, recording), random.normal(size=len(found.columns))
    np.testing.assert_allclose(regressor[:, found.chosen] @ (found.K @ parameters), regressor @ parameters, atol=1e-8)


@pytest.mark.parametrize("estimator", ["ols", "wls", "huber"])
def test_exact_torques_give_the_parameters_of_the_file(estimator: str) -> None:
    robot = rg.load("raven2_gold")
    found = identify.identify(robot, static(robot, 40, 0.3), Model(), estimator)
    np.testing.assert_allclose(found.values, found.base.K @ Model().prior(robot), atol=1e-10)
    assert found.refused is None
    assert found.held_out.rms.max() < 1e-10


def test_formal_uncertainty_covers_white_noise() -> None:
    robot = rg.load("raven2_gold")
    found = identify.identify(robot, static(robot, 200, 0.3, noise=0.01), Model(), "ols")
    errors = (found.values - found.base.K @ Model().prior(robot)) / found.formal_sd
    assert np.abs(errors).max() < 4.0
    np.testing.assert_allclose(found.held_out.rms, 0.01, rtol=0.3)
