"""The experiments that need no simulated plant, in full, and what the others stand on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc
from ravengc import sim
from ravengc.experiments import EXPERIMENTS, Outcome, run_experiment, settings_from
from ravengc.experiments.base_rows import Rocking
from ravengc.experiments.moving_base_terms import REFERENCE, WAYS
from ravengc.experiments.newton_euler import on_ship
from ravengc.experiments.one_link_run import growth_of, swing
from ravengc.experiments.raven import base_axes, held_pose, raven, sinusoid_path, tool_joints
from ravengc.experiments.ship import REFERENCE as SHIP_REFERENCE
from ravengc.experiments.ship import Ship, ship_motion
from ravengc.experiments.static_poses import StaticPoses, predicted_share
from ravengc.stability import OneLink, Sensing, rightmost_pole


def outcome_of(name: str, **changes: object) -> Outcome:
    experiment = EXPERIMENTS[name]
    return run_experiment(experiment, settings_from(experiment.settings, changes))


# What the experiments stand on


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(j1=st.floats(0.0, 90.0), j2=st.floats(45.0, 135.0), d3=st.floats(0.23, 0.46))
def test_inverse_kinematics_undoes_forward_kinematics(j1: float, j2: float, d3: float) -> None:
    q = held_pose(j1, j2, d3)
    assert np.abs(tool_joints(raven().forward_kinematics(q)[:3, 3]) - q).max() < 1e-9


def test_the_path_is_sinusoids_of_the_tool_along_each_axis_in_turn() -> None:
    path = sinusoid_path(0.03, 2.0, 1, 500.0)
    middle = raven().forward_kinematics(held_pose())[:3, 3]
    tool = (raven().forward_kinematics_batch(path.q)[:, :3, 3] - middle) @ base_axes().T
    swing_along = 0.03 * np.sin(np.pi * np.arange(1000) / 500.0)
    for axis in range(3):
        rows = slice(1000 * axis, 1000 * (axis + 1))
        assert np.abs(tool[rows, axis] - swing_along).max() < 1e-12
        assert np.abs(np.delete(tool[rows], axis, axis=1)).max() < 1e-12
    inside = np.r_[1:999, 1001:1999, 2001:2999]
    slope = 250.0 * (path.q[inside + 1] - path.q[inside - 1])
    assert np.abs(slope - path.qd[inside]).max() < 1e-3


def test_a_rocking_base_is_that_of_the_simulator() -> None:
    axis, pivot = base_axes()[2], np.array((0.1, 0.2, -0.3))
    up = np.array((0.0, 0.0, ravengc.STANDARD_GRAVITY))
    motion = Rocking(axis, pivot, up, mean=0.2, amplitude=0.1, hz=1.5, samples=40)
    base = sim.BaseTrajectory(
        offset=0.2 * np.eye(6)[3], amplitude=0.1 * np.eye(6)[3], hz=1.5 * np.eye(6)[3],
        axes=sim.tilted(0.0, tuple(axis)).axes, pivot=pivot,
    )  # fmt: skip
    for row, t in zip(motion.rows(), motion.time, strict=True):
        assert np.abs(row - np.concatenate(base.motion_at(t, np.zeros(3)))).max() < 1e-12


def test_a_ship_is_that_of_the_simulator() -> None:
    ship = Ship(gravity=ravengc.STANDARD_GRAVITY)
    amplitude = [0.0, 0.0, ship.heave, *np.deg2rad((ship.roll_deg, ship.pitch_deg, 0.0))]
    hz = [0.0, 0.0, ship.heave_hz, ship.roll_hz, ship.pitch_hz, 0.0]
    base = sim.oscillating(amplitude=amplitude, hz=hz, pivot=-np.array(ship.place))
    time = np.linspace(0.0, 20.0, 23)
    for row, t in zip(ship_motion(ship, time)[0], time, strict=True):
        assert np.abs(row - np.concatenate(base.motion_at(t, np.zeros(3)))).max() < 1e-11


@pytest.mark.parametrize("delay", [0.0, 0.02])
def test_the_nonlinear_link_swings_as_the_linear_one(delay: float) -> None:
    link = OneLink(
        base_mass=10.0, base_frequency_hz=2.5, base_damping_ratio=0.02, mass=2.0, length=0.4, inertia=0.37, kp=300.0,
        kd=3.0, sensing=Sensing(rate_hz=None, latency_s=delay, cutoff_hz=20.0, order=1),
    )  # fmt: skip
    found = growth_of(swing(link, start=1e-5, duration_s=15.0))
    assert found == pytest.approx(rightmost_pole(link.system()).s.real, abs=0.02)


# The closed-form experiments at full


@pytest.fixture(scope="module")
def terms() -> Outcome:
    return outcome_of("moving-base-terms")


@pytest.mark.parametrize("scene", REFERENCE)
@pytest.mark.parametrize("way", WAYS)
def test_the_table_of_terms_is_within_a_tenth_of_a_point(terms: Outcome, scene: str, way: str) -> None:
    found = [terms.numbers[f"{scene}_{way}_j{j}"] for j in (1, 2, 3)]
    assert found == pytest.approx(REFERENCE[scene][way], abs=0.1)


def test_what_the_paper_leaves_out_grows_with_the_square_of_the_frequency(terms: Outcome) -> None:
    ratio = terms.numbers["neglected_2hz_j1"] / terms.numbers["neglected_1hz_j1"]
    assert ratio == pytest.approx(4.0, rel=1e-9)
    assert terms.holds


def test_full_motion_leaves_nothing_in_any_scene() -> None:
    found = outcome_of("moving-base-terms", hz=3.0, mean_deg=-20.0, lever=1.0, samples=64)
    assert max(value for key, value in found.numbers.items() if "_full_" in key) < 1e-9
    assert found.holds


@pytest.mark.parametrize("way", SHIP_REFERENCE)
def test_the_ship_row(way: str) -> None:
    reference, tolerance = SHIP_REFERENCE[way]
    found = outcome_of("ship")
    assert [found.numbers[f"{way}_j{j + 1}"] for j in range(5)] == pytest.approx(reference, abs=tolerance)
    assert found.holds


def test_the_base_wrench_gives_the_torques() -> None:
    found = outcome_of("base-wrench", states=40)
    assert max(value for key, value in found.numbers.items() if key.endswith(("_rest", "_moving"))) < 1e-12
    assert found.numbers["rocking_level_j1"] < 1e-9
    assert found.numbers["rocking_level_j2"] > 10.0 > found.numbers["rocking_accelerometer_j2"]


def test_newton_and_lagrange_agree_on_a_ship() -> None:
    found = outcome_of("newton-euler", states=4, repeats=1)
    assert max(found.numbers.values()) < 1e-10


def test_the_ship_as_joints_carries_the_arm_where_the_ship_does() -> None:
    pa10 = ravengc.load("pa10")
    extended = ravengc.Robot(on_ship(pa10.spec, (3.0, 1.0, 4.0)))
    arm = (0.3, 0.6, -1.0, 0.2, 0.5, 0.1)
    level = extended.forward_kinematics((0.5, 0.0, 0.0, *arm))
    assert level[:3, 3] == pytest.approx(pa10.forward_kinematics(arm)[:3, 3] + (3.0, 1.0, 4.5))
    assert level[:3, :3] == pytest.approx(pa10.forward_kinematics(arm)[:3, :3])


def test_the_feedback_of_the_base() -> None:
    found = outcome_of("base-feedback")
    numbers = found.numbers
    assert found.holds
    assert numbers["unstable_growth"] == pytest.approx(0.1696, abs=1e-4)
    assert numbers["unstable_rate"] == pytest.approx(15.201, abs=1e-3)
    assert [numbers[f"{name}_certified"] for name in ("unstable", "prompt", "damped", "stiff", "static")] == [
        0.0, 1.0, 1.0, 1.0, 1.0,
    ]  # fmt: skip
    assert numbers["simulated_growth"] == pytest.approx(numbers["unstable_growth"], abs=5e-3)


def test_shares_without_friction_are_geometry() -> None:
    shares = [predicted_share(StaticPoses(), tilt) for tilt in (0.0, 5.0, 10.0, 15.0, 20.0, 25.0)]
    assert shares == pytest.approx([0.0, 13.0, 24.4, 34.2, 42.6, 49.8], abs=0.1)
