"""What an identification admits: columns that do not help, its uncertainty, the floor, where numbers come from."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from ravengc import identify
from ravengc.errors import CalibrationError
from ravengc.identify import Model, Recording
from ravengc.identify.plan_space import directions, joint_ranges, poses_within, standing
from test_identify import moving, static

if TYPE_CHECKING:
    from pathlib import Path

ESTIMATORS = ("ols", "wls", "huber", "consistent")


def fitted(recording: Recording, model: Model, estimator: str) -> identify.Identification:
    if estimator == "consistent":
        pytest.importorskip("clarabel")
    return identify.identify(rg.load("raven2_gold"), recording, model, estimator)


def wilder(recording: Recording) -> Recording:
    """With a wild torque in every thirtieth sample."""
    tau = recording.tau.copy()
    tau[::30] += 50.0
    return replace(recording, tau=tau)


def bent(names: tuple[str, ...], degrees: range) -> Model:
    return Model(elements=tuple(identify.polynomial(name, degrees, scale=0.5) for name in names))


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_cables_that_are_not_there_are_refused_whatever_the_estimator(estimator: str, tmp_path: Path) -> None:
    names = rg.load("raven2_gold").spec.coordinate_names
    found = fitted(static(rg.load("raven2_gold"), 44, 0.3, noise=0.05), bent(names, range(1, 8)), estimator)
    assert found.refused is not None
    assert "worse than without" in found.refused
    with pytest.raises(CalibrationError, match="refused"):
        found.write(tmp_path / "arm.toml")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_cable_that_is_there_is_kept_whatever_the_estimator(estimator: str) -> None:
    recording = static(rg.load("raven2_gold"), 200, 0.3, noise=0.05)
    pulled = replace(recording, tau=recording.tau + np.column_stack([np.zeros(200), recording.q[:, 1], np.zeros(200)]))
    found = fitted(pulled, bent(("elbow",), range(1, 2)), estimator)
    assert found.refused is None
    assert found.coefficients["elbow.cable.p1"] == pytest.approx(0.5, abs=0.2)


def pulled(span: float, tilt: float, axes: int) -> Recording:
    """An elbow with a spring along it, in poses over a share of its range on a base that leans about so many axes."""
    robot, random = rg.load("raven2_gold"), np.random.default_rng(2)
    ranges = np.array([(limit.lower, limit.upper) for limit in robot.spec.coordinate_limits])
    middle, half = ranges.mean(axis=1), 0.5 * span * np.ptp(ranges, axis=1)
    q = random.uniform(middle - half, middle + half, (120, 3))
    lean = tilt * random.uniform(-1.0, 1.0, (2, 120)) * [[1.0], [float(axes > 1)]]
    up = [np.sin(lean[1]), -np.sin(lean[0]) * np.cos(lean[1]), np.cos(lean[0]) * np.cos(lean[1])]
    force = 9.80665 * np.column_stack(up)
    tau = robot.gravity_torque_batch(q, -force) + 1e-3 * random.normal(size=q.shape)
    tau[:, 1] += 0.5 + q[:, 1]
    return Recording(stamps=np.arange(120.0), q=q, tau=tau, specific_force=force)


@pytest.mark.parametrize(
    ("span", "tilt", "axes", "remedy"),
    [
        (0.05, 0.0, 1, "over the whole range of every joint"),
        (0.05, 0.02, 1, "over the whole range of every joint"),
        (1.0, 0.2, 2, None),
    ],
)
def test_what_is_hardly_told_apart_is_named_with_what_to_record(
    span: float, tilt: float, axes: int, remedy: str | None
) -> None:
    found = identify.identify(rg.load("raven2_gold"), pulled(span, tilt, axes), bent(("elbow",), range(2)))
    if remedy is None:
        assert not found.warnings
        assert found.condition < 50.0
    else:
        assert remedy in found.warnings[0], found.warnings
        assert found.condition > 50.0


def test_what_is_told_to_be_recorded_mends_the_condition() -> None:
    """A master arm near one pose with cables: with what is told in addition the condition becomes what is said."""
    robot = rg.load("dvrk_mtmr")
    names = robot.spec.coordinate_names[1:3]
    model = Model(elements=tuple(identify.polynomial(name, (0, 1)) for name in names))
    near = poses_within(joint_ranges(robot.spec, dict.fromkeys(names, (-0.2, 0.2))), 150, np.random.default_rng(0))
    anywhere = poses_within(joint_ranges(robot.spec, None), 150, np.random.default_rng(1))
    level, one_axis = held_on(near, np.zeros((1, 2))), held_on(near, np.radians([[2.0, 0.0], [-2.0, 0.0]]))
    more = held_on(anywhere, directions(np.radians(10.0), 4))
    for before, tilting in (
        (level, "tilt the base by 10 degrees or more to four sides"),
        (one_axis, "tilt the base about a second axis too: it was tilted about one only"),
    ):
        found = identify.identify(robot, before, model, held_out=more)
        remedy, _, then = found.warnings[0].partition(" (condition then about ")
        assert remedy.endswith(f"record poses over the whole range of 'shoulder_pitch', 'elbow_pitch', and {tilting}")
        after = identify.identify(robot, [before, more], model, held_out=more)
        assert not after.warnings
        assert after.condition == pytest.approx(float(then.rstrip(")")), rel=0.2)


def held_on(q: np.ndarray, sides: np.ndarray) -> Recording:
    """Poses of the master arm on tilts in turn, with the torques that hold them."""
    stood = standing(q, sides[np.arange(len(q)) % len(sides)])
    return replace(stood, tau=rg.load("dvrk_mtmr").gravity_torque_batch(q, -stood.base[:, :3]))


def test_no_recording_tells_powers_of_a_short_way_apart() -> None:
    robot = rg.load("raven2_gold")
    found = identify.identify(robot, static(robot, 200, 0.3, noise=1e-3), bent(("shoulder",), range(1, 9)))
    assert found.condition > 50.0
    assert "leave some of them out" in found.warnings[0] or "record poses" in found.warnings[0]


def test_wild_torques_hide_nothing_from_huber() -> None:
    """Squares of wild held-out torques would drown what the extra columns do."""
    names = rg.load("raven2_gold").spec.coordinate_names
    recording = static(rg.load("raven2_gold"), 44, 0.3, noise=0.05)
    assert fitted(wilder(recording), bent(names, range(1, 8)), "huber").refused is not None
    more = static(rg.load("raven2_gold"), 300, 0.3, noise=0.05)
    assert fitted(wilder(more), Model(), "huber").refused is None


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_the_cross_validated_uncertainty_covers_the_error(estimator: str) -> None:
    robot = rg.load("raven2_gold")
    off = []
    for seed in range(8):
        found = fitted(static(robot, 100, 0.3, noise=0.05, seed=seed), Model(), estimator)
        off.append((found.values - found.base.K @ Model().prior(robot)) / found.cross_sd)
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 2.0


def test_the_cross_validated_uncertainty_of_huber_does_not_follow_wild_torques() -> None:
    recording = static(rg.load("raven2_gold"), 300, 0.3, noise=0.01)
    plain, robust = (fitted(wilder(recording), Model(), estimator).cross_sd for estimator in ("ols", "huber"))
    assert np.all(robust < 0.05 * plain)


def test_the_cross_validated_uncertainty_sees_what_noise_does_not_explain() -> None:
    """Friction that a gravity model leaves out is no noise: leaving out fifths shows it, the formal sd does not."""
    robot = rg.load("panda")
    recording = moving(robot, 20.0)
    rubbed = replace(recording, tau=recording.tau + 2.0 * np.sign(recording.qd))
    found = identify.identify(robot, rubbed, Model(kind="dynamics", friction=()))
    off = np.abs(found.values - found.base.K @ Model(kind="dynamics", friction=()).prior(robot))
    assert np.median(off / found.formal_sd) > np.median(off / found.cross_sd)


def test_the_floor_is_found_where_the_held_out_part_is_shorter_than_a_period() -> None:
    robot = rg.load("panda")
    recording = moving(robot, 25.0)
    noisy = replace(recording, tau=recording.tau + 0.02 * np.random.default_rng(0).normal(size=recording.q.shape))
    found = identify.identify(robot, noisy, Model(kind="dynamics"))
    np.testing.assert_allclose(found.floor, 0.02, rtol=0.15)


def test_the_file_says_where_its_numbers_come_from(tmp_path: Path) -> None:
    robot = rg.load("dvrk_mtmr")
    level = replace(static(robot, 60, 0.0), source="monday.csv")
    found = identify.identify(robot, level, Model())
    assert "monday.csv" in found.provenance
    assert "base level" in found.provenance
    assert "2 sums of parameters not shown" in found.provenance
    tilted = identify.identify(robot, replace(static(robot, 60, 0.3), source="tuesday.csv"), Model())
    assert "base tilted by up to " in tilted.provenance
    tilted.write(tmp_path / "arm.toml")
    written = rg.load(tmp_path / "arm.toml")
    assert "tuesday.csv (gravity, estimator ols, 14 base parameters" in written.spec.source
    assert all("tuesday.csv" in link.source for link in written.spec.moving_links)
    assert [path.name for path in tmp_path.iterdir()] == ["arm.toml"]
