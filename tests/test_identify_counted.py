"""Torques that do not count: not measured, or of joints that a protocol does not train there."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from identify_logs import moved
from ravengc import identify
from ravengc.errors import ArgumentError
from ravengc.identify import Model, Recording, base_parameters, both_ways, predict_uncertainty, smoothed
from ravengc.identify.repeatability import repeatability
from test_identify import static

if TYPE_CHECKING:
    from collections.abc import Callable

RAVEN, MTM = rg.load("raven2_gold"), rg.load("dvrk_mtmr")
LEVEL = 9.80665


def spoilt(recording: Recording, counted: np.ndarray) -> Recording:
    """The recording with absurd torques where they do not count."""
    return replace(recording, tau=np.where(counted, recording.tau, 1e6), counted=counted)


@pytest.mark.parametrize("estimator", ["ols", "wls", "huber", "consistent"])
def test_what_does_not_count_changes_nothing(estimator: str) -> None:
    """A third of the torques, whatever they are, may be left out: the others give the parameters of the file."""
    if estimator == "consistent":
        pytest.importorskip("clarabel")
    exact = static(RAVEN, 90, 0.3)
    counted = np.random.default_rng(4).uniform(size=exact.q.shape) > 0.3
    found = identify.identify(RAVEN, spoilt(exact, counted), Model(), estimator)
    atol = 1e-4 if estimator == "consistent" else 1e-9
    np.testing.assert_allclose(found.values, found.base.K @ Model().prior(RAVEN), atol=atol)
    assert found.refused is None
    assert (found.train.samples + found.held_out.samples).tolist() == counted.sum(axis=0).tolist()


def test_a_mask_that_leaves_nothing_out_changes_nothing() -> None:
    noisy = static(RAVEN, 60, 0.3, noise=0.05)
    plain, masked = (
        identify.identify(RAVEN, one, Model(), "wls") for one in (noisy, replace(noisy, counted=np.ones((60, 3), bool)))
    )
    np.testing.assert_array_equal(plain.parameters, masked.parameters)
    np.testing.assert_array_equal(plain.cross_covariance, masked.cross_covariance)
    np.testing.assert_array_equal(plain.held_out.relative, masked.held_out.relative)


def test_a_joint_that_never_counts_has_no_error_and_hides_what_only_it_shows() -> None:
    exact = static(MTM, 80, 0.3)
    found = identify.identify(MTM, exact.counting([1, 2, 3, 4, 5, 6]), Model())
    assert found.rank == 12
    assert found.base.unidentifiable[0].endswith(": measure the torque of 'outer_yaw' too")
    assert np.isnan(found.held_out.rms[0])
    assert np.isnan(found.held_out.relative[0])
    assert np.isfinite(found.held_out.rms[1:]).all()
    assert found.held_out.overall < 1e-9
    assert "12 base parameters, base tilted" in found.provenance
    assert "held-out error -, 0.0" in found.provenance
    assert base_parameters(MTM, Model(), "tilted", counted=np.arange(7) > 0).rank == 12


def test_no_torque_that_counts_is_refused() -> None:
    exact = static(RAVEN, 40, 0.3)
    with pytest.raises(ArgumentError, match="held_out: no torque counts"):
        identify.identify(RAVEN, exact, Model(), held_out=exact.counting([]))
    with pytest.raises(ArgumentError, match="recordings: no torque counts"):
        identify.identify(RAVEN, exact.counting([]), Model(), held_out=exact)


def test_a_prediction_from_some_rows_is_that_of_these_rows() -> None:
    """Poses of which one joint counts each are worth as much as these joints' rows, and no more."""
    every = static(RAVEN, 60, 0.3)
    whole = predict_uncertainty(RAVEN, Model(), every).worst
    trained = np.arange(60)[:, np.newaxis] % 3 == np.arange(3)
    some = predict_uncertainty(RAVEN, Model(), replace(every, counted=trained)).worst
    again = [every.take(np.arange(joint, 60, 3)).counting([joint]) for joint in range(3)]
    q, force, counted = (
        np.vstack([getattr(one, name) for one in again]) for name in ("q", "specific_force", "counted")
    )
    joined = Recording(stamps=np.arange(60.0), q=q, tau=0.0 * q, specific_force=force, counted=counted)
    np.testing.assert_allclose(predict_uncertainty(RAVEN, Model(), joined).worst, some, rtol=1e-9)
    assert np.all(some > 1.3 * whole)


def test_the_trained_joints_rows_alone_leave_a_tilted_shoulder_less_sure() -> None:
    """Level, joint by joint: tenths of a newton metre at 10 degrees of tilt, more from each joint's own rows."""
    names = MTM.spec.coordinate_names
    model = Model(
        elements=tuple(identify.polynomial(name, (0, 1) if name == names[1] else range(5)) for name in names[:6]),
        links=names[:6],
    )
    parts = [sweep(joint) for joint in range(6)]
    q, counted = (np.vstack([getattr(one, name) for one in parts]) for name in ("q", "counted"))
    alone = Recording(stamps=np.arange(float(len(q))), q=q, tau=0.0 * q, counted=counted)
    used = q[::20]
    worst = [predict_uncertainty(MTM, model, one, poses=used).worst[1] for one in (alone, replace(alone, counted=None))]
    assert worst[0] > 1.2 * worst[1] > 0.1


@pytest.mark.parametrize("estimator", ["ols", "wls"])
def test_a_warning_is_about_what_counts(estimator: str) -> None:
    """A joint whose torque never counts takes no part in what is hardly told apart, nor in what would help."""
    names = MTM.spec.coordinate_names
    model = Model(elements=(identify.polynomial(names[1], (0, 1)),))
    level = static(MTM, 120, 0.0, noise=1e-3)
    few = replace(level, q=0.2 * level.q, tau=0.0 * level.tau)
    few = replace(few, tau=MTM.gravity_torque_batch(few.q, -few.base[:, :3]) + 1e-3 * level.q)
    found = identify.identify(MTM, few.counting([1, 2, 3, 4, 5, 6]), model, estimator)
    (said,) = found.warnings
    assert f"{names[1]}.cable" in said
    then = float(said.rpartition("(condition then about ")[2].rstrip(")"))
    assert 1.0 < then < 0.5 * found.condition


def sweep(joint: int) -> Recording:
    """Of the protocol of the dVRK: a joint over its range at five places of the next one; its own torque counts."""
    spans = ((-40, 8), (-11, 16), (-15, 11), (-80, 190), (-85, 175), (-40, 40))
    other = (1, 2, 1, 2, 2, 4)[joint]
    poses = np.zeros((5, 28, 7))
    poses[:, :, 4] = np.pi / 2
    poses[:, :, other] = np.radians(np.linspace(0.0, (0, 0, 5, 20, 20, 90)[joint], 5))[:, np.newaxis]
    poses[:, :, joint] = np.radians(np.linspace(*spans[joint], 28))
    q = poses.reshape(-1, 7)
    return Recording(stamps=np.arange(140.0), q=q, tau=0.0 * q).counting([joint])


def test_both_ways_take_the_mean_of_what_counts() -> None:
    q = np.repeat(np.linspace(-0.2, 0.2, 4)[:, np.newaxis] * np.ones(3), 2, axis=0)
    way = np.tile([[1.0], [-1.0]], (4, 1)) * np.ones(3)
    counted = np.ones((8, 3), dtype=bool)
    counted[:, 2] = False  # never measured
    counted[1, 0] = False  # one way only at the first pose
    recording = Recording(stamps=np.arange(8.0), q=q, qd=way, tau=q + 0.5 * way, counted=counted)
    poses = both_ways(recording)
    assert poses.samples == 3
    np.testing.assert_allclose(poses.tau[:, :2], q[2::2, :2], atol=1e-12)
    assert poses.counts.tolist() == [[True, True, False]] * 3


def test_a_filter_keeps_joints_that_count_apart_from_those_that_do_not() -> None:
    table = moved(RAVEN)
    motion = Recording(stamps=table["t"], q=table["q"], qd=table["dq"], tau=table["tau"])
    assert smoothed(motion.counting([0, 2]), 5.0).counts.all(axis=0).tolist() == [True, False, True]
    uneven = replace(motion, stamps=motion.stamps + 0.004 * (np.arange(600) % 2)).counting([1])
    assert smoothed(uneven, 5.0).counts.all(axis=0).tolist() == [False, True, False]
    counted = np.ones((600, 3), dtype=bool)
    counted[50:60, 1] = False
    with pytest.raises(ArgumentError, match="of joint 2 some torques count and others do not"):
        smoothed(replace(motion, counted=counted), 5.0)


def test_a_floor_needs_all_torques() -> None:
    t = np.arange(0.0, 12.0, 0.02)
    q = np.sin(2.0 * np.pi * 0.25 * t)[:, np.newaxis] * np.ones(3)
    floor = repeatability(Recording(stamps=t, q=q, tau=q).counting([0, 1]))
    assert floor is not None
    assert np.isnan(floor).tolist() == [False, False, True]


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (lambda one: replace(one, counted=np.ones((40, 3), dtype=int)), "expected True and False"),
        (lambda one: replace(one, counted=np.ones((40, 2), dtype=bool)), r"counted has shape \(40, 2\)"),
        (lambda _: base_parameters(RAVEN, Model(), counted=[1, 0, 1]), "True or False for each of 3 joints"),
        (lambda one: one.counting([3]), "expected places from 0 to 2"),
        (lambda one: identify.mounting(RAVEN, one.counting([1])), "not every torque counts"),
        (lambda one: identify.payload(RAVEN, one, one.counting([1])), "name those that were measured"),
    ],
)
def test_masks_that_are_none(act: Callable[[Recording], object], said: str) -> None:
    with pytest.raises(ArgumentError, match=said):
        act(static(RAVEN, 40, 0.3))
