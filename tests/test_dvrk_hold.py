"""An arm held in MuJoCo by computed torques alone, and not held by others."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc
from ravengc.disturbances import Polynomial
from ravengc.dvrk import hold, mtm_with_special_terms
from ravengc.dvrk.holding import random_poses
from ravengc.errors import ArgumentError, ModelError
from ravengc.sim import Plant
from ravengc.spec import JointLimits

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("mujoco")


@pytest.mark.parametrize("name", ["rrbot", "rrbot_modified", "dvrk_mtml", "dvrk_mtmr", "dvrk_psm_si"])
@pytest.mark.parametrize("tilt", [0.0, 35.0])
def test_arms_are_held(name: str, tilt: float) -> None:
    found = hold(ravengc.load(name), count=2, seconds=0.3, tilt_deg=tilt, axis="x")
    assert found.holds_all
    for one in found.holds:
        assert one.drift < 1e-9
        assert one.fall > 1e-3


def test_a_given_pose_has_the_known_torques() -> None:
    """(.3, .5): -7.080490, -3.166768 at g = 9.81."""
    found = hold(ravengc.load("rrbot"), [0.3, 0.5], seconds=0.1)
    scaled = found.holds[0].tau * 9.81 / ravengc.STANDARD_GRAVITY
    np.testing.assert_allclose(scaled, (-7.080490, -3.166768), atol=5e-7)


def test_wrong_torques_do_not_hold() -> None:
    """The plant is another arm's than the torques': one with a heavier second link."""
    robot = ravengc.load("rrbot")
    spec = robot.spec
    heavier = replace(spec, links=(spec.links[0], replace(spec.links[1], mass=1.01)))
    plant, tau = Plant(ravengc.Robot(heavier)), np.zeros(2)
    plant.reset((0.3, 0.5))
    for _ in range(500):
        robot.gravity_torque(plant.q, -plant.accelerometer(), out=tau)
        plant.step(tau, 0.001)
    assert np.abs(plant.q - (0.3, 0.5)).max() > 1e-3


def test_elements_act_in_the_plant_and_are_in_the_torques() -> None:
    found = hold(ravengc.Robot(mtm_with_special_terms()), count=2, seconds=0.2)
    assert found.holds_all


def test_what_flies_away_is_no_number_less() -> None:
    """A cable that pushes ever harder: without torques the arm is gone before it can be watched to the end."""
    spec = ravengc.load("rrbot").spec
    push = Polynomial(name="push", joint="joint1", coefficients=(0.0, 0.0, 0.0, 0.0, 0.0, -1e6))
    robot = ravengc.Robot(replace(spec, disturbances=(push,)))
    one = hold(robot, [0.5, 0.2], seconds=0.5).holds[0]
    assert np.isfinite(one.falling).all()
    assert one.fall > 0.1


def test_points_on_their_axes_get_rotors() -> None:
    assert hold(ravengc.load("dvrk_mtmr"), count=1, seconds=0.01).rotor_inertia == 0.001
    assert hold(ravengc.load("rrbot"), count=1, seconds=0.01).rotor_inertia == 0.0


@pytest.mark.parametrize(
    ("limits", "ends"),
    [
        ((None, None), (-np.pi, np.pi)),
        ((None, -5.0), (-5.0 - 2.0 * np.pi, -5.0)),
        ((5.0, None), (5.0, 5.0 + 2.0 * np.pi)),
        ((5.0, 6.0), (5.0, 6.0)),
    ],
)
def test_random_poses_are_within_the_limits_that_there_are(
    limits: tuple[float | None, float | None], ends: tuple[float, float]
) -> None:
    spec = ravengc.load("rrbot").spec
    first = replace(spec.links[0], limits=JointLimits(lower=limits[0], upper=limits[1]))
    robot = ravengc.Robot(replace(spec, links=(first, *spec.links[1:])))
    angles = random_poses(robot, 500, 0)[:, 0]
    assert ends[0] <= angles.min() < angles.max() <= ends[1]
    assert np.ptp(angles) > 0.9 * (ends[1] - ends[0])


def test_a_picture(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from ravengc.reports.dvrk_hold_plot import plot_holding

    path = tmp_path / "held.svg"
    plot_holding(path, hold(ravengc.load("rrbot"), count=2, seconds=0.05), ("joint1", "joint2"))
    assert path.stat().st_size > 1000


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"poses": [0.1]}, "expected \\(N, 2\\)"),
        ({"poses": [0.1, float("nan")]}, "finite"),
        ({"count": 0}, "count"),
        ({"seconds": 0.0}, "seconds"),
        ({"seconds": 1e6}, "seconds"),
        ({"tilt_deg": 1e3}, "tilt_deg"),
        ({"axis": "w"}, "axis"),
        ({"seed": -1}, "seed"),
        ({"robot": "rrbot"}, "robot is a str"),
    ],
)
def test_impossible_arguments(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        hold(**({"robot": ravengc.load("rrbot"), "seconds": 0.01} | wrong))  # type: ignore[arg-type]


def test_an_arm_without_masses_has_nothing_to_hold() -> None:
    with pytest.raises(ModelError, match="no masses"):
        hold(ravengc.load("dvrk_psm"))
