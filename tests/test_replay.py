"""Replay: the published Panda model against a real Panda, and theorems about derivatives and residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc
from ravengc.differentiation import differentiate, window_for
from ravengc.disturbances import Friction, LinearSpring
from ravengc.errors import ArgumentError, ConfigError
from ravengc.recordings import Recording, read_recording
from ravengc.replay import replay
from strategies import robots

PANDA = ravengc.load("panda")
LEVEL = (0.0, 0.0, -9.80665)
FEW = settings(max_examples=25, deadline=None)


def recorded(samples: int, joints: int, seed: int, **more: object) -> Recording:
    random = np.random.default_rng(seed)
    t = np.cumsum(random.uniform(0.01, 0.03, samples))
    return Recording(**{"t": t, "q": random.normal(size=(samples, joints)), "source": "log"} | more)


# --- a real arm


def test_gravity_alone_explains_a_real_panda() -> None:
    """Nothing fitted: the published parameters on a recording that they were not made from."""
    result = replay(PANDA, read_recording("example:panda"))
    assert round(result.overall_error, 4) == 0.0803
    relative = {error.name: round(error.relative, 4) for error in result.joint_errors}
    assert relative["panda_joint2"] == 0.0614
    assert relative["panda_joint3"] == 0.0531
    assert relative["panda_joint4"] == 0.0860
    assert relative["panda_joint1"] == 1.0  # a vertical axis: gravity explains nothing


def test_full_dynamics_explain_more_of_it() -> None:
    recording = read_recording("example:panda")
    full = replay(PANDA, recording, model="full")
    assert full.overall_error < 0.061
    assert full.notes == ("accelerations derived over 9 samples",)
    without_rates = Recording(t=recording.t, q=recording.q, tau=recording.tau)
    derived = replay(PANDA, without_rates, model="full")
    assert derived.overall_error < 0.062
    assert derived.notes == ("velocities and accelerations derived over 9 samples",)


# --- residuals


def test_disturbance_elements_are_predicted_too() -> None:
    spring = LinearSpring(name="coil", joint="joint1", stiffness=2.0, rest=0.25)
    friction = Friction(name="rub", joint="joint2", coulomb=0.5, viscous=0.1)
    plain = ravengc.load("rrbot")
    robot = ravengc.Robot(replace(plain.spec, disturbances=(spring, friction)))
    random = np.random.default_rng(3)
    recording = recorded(40, 2, 3, qd=random.normal(size=(40, 2)), qdd=random.normal(size=(40, 2)))
    for model, qd in (("gravity", None), ("full", recording.qd)):
        found, bare = (replay(one, recording, model=model) for one in (robot, plain))
        beside = robot.disturbance_torque_batch(recording.q, qd)
        np.testing.assert_array_equal(found.predicted, bare.predicted + beside)
        assert np.abs(beside).max() > 0.5
        assert found.notes[-1] == f"with the robot's disturbance elements (2{', at rest' if qd is None else ''})"
        assert bare.notes == ()


@given(spec=robots(most=5), seed=st.integers(0, 2**32 - 1))
@FEW
def test_a_robot_that_is_its_own_model_leaves_no_residual(spec, seed: int) -> None:
    robot = ravengc.Robot(spec)
    random = np.random.default_rng(seed)
    q, gravity = random.normal(size=(6, robot.n)), random.normal(size=(6, 3))
    tau = np.array([robot.gravity_torque(*pair) for pair in zip(q, gravity, strict=True)])
    result = replay(robot, recorded(6, robot.n, seed, q=q, tau=tau), gravity=gravity)
    np.testing.assert_allclose(result.residual, 0.0, atol=1e-12 * max(1.0, np.abs(tau).max()))


@given(spec=robots(most=4, solid=True), seed=st.integers(0, 2**32 - 1))
@FEW
def test_full_model_is_exact_where_the_motion_is_a_parabola(spec, seed: int) -> None:
    """Derivatives by fitted parabolas are exact on one, so the torque is inverse dynamics with the true rates."""
    robot = ravengc.Robot(spec)
    random = np.random.default_rng(seed)
    start, rate, half = random.normal(size=(3, robot.n))
    t = np.cumsum(random.uniform(0.05, 0.1, 9))[:, np.newaxis]
    q, qd, qdd = start + rate * t + half * t**2, rate + 2 * half * t, np.broadcast_to(2 * half, (9, robot.n))
    result = replay(robot, Recording(t=t[:, 0], q=q), model="full", gravity=LEVEL, span=0.3)
    base = ravengc.Gravity(*LEVEL)
    exact = np.array([robot.inverse_dynamics(*row, base) for row in zip(q, qd, qdd, strict=True)])
    np.testing.assert_allclose(result.predicted, exact, rtol=1e-8, atol=1e-8 * max(1.0, np.abs(exact).max()))


def test_recorded_rates_are_used_as_they_are() -> None:
    random = np.random.default_rng(1)
    recording = recorded(2, 7, 1, qd=random.normal(size=(2, 7)), qdd=random.normal(size=(2, 7)))
    result = replay(PANDA, recording, model="full")
    exact = PANDA.inverse_dynamics(recording.q[1], recording.qd[1], recording.qdd[1], ravengc.Gravity.level())
    np.testing.assert_allclose(result.predicted[1], exact, rtol=1e-12, atol=1e-12)
    assert result.notes == ()


def test_errors_are_those_of_their_definition() -> None:
    recording = recorded(5, 7, 2, tau=np.random.default_rng(3).normal(size=(5, 7)))
    result = replay(PANDA, recording)
    residual = recording.tau - result.predicted
    assert result.overall_error == pytest.approx(np.linalg.norm(residual) / np.linalg.norm(recording.tau))
    joint = result.joint_errors[3]
    assert (joint.name, joint.unit) == ("panda_joint4", "N·m")
    assert joint.rms_error == pytest.approx(np.sqrt(np.mean(residual[:, 3] ** 2)))
    assert joint.rms_measured == pytest.approx(np.sqrt(np.mean(recording.tau[:, 3] ** 2)))
    assert joint.max_error == pytest.approx(np.abs(residual[:, 3]).max())
    assert joint.relative == pytest.approx(np.linalg.norm(residual[:, 3]) / np.linalg.norm(recording.tau[:, 3]))


def test_torques_the_other_way_round_are_said() -> None:
    recording = read_recording("example:panda")
    assert not any("opposite" in note for note in replay(PANDA, recording).notes)
    down = replay(PANDA, recording, gravity=(0.0, 0.0, 9.80665))
    assert any("opposite to the predicted ones (correlation -1.0" in note for note in down.notes)


def test_nothing_measured_is_nothing_compared() -> None:
    silent = replay(PANDA, recorded(3, 7, 4))
    assert (silent.residual, silent.joint_errors, silent.overall_error) == (None, (), None)
    zero = replay(PANDA, recorded(3, 7, 4, tau=np.zeros((3, 7))))
    assert zero.overall_error is None
    assert zero.joint_errors[0].relative is None


def test_what_cannot_be_replayed_is_refused() -> None:
    with pytest.raises(ConfigError, match="log has 6 joints, but panda has 7"):
        replay(PANDA, recorded(3, 6, 5))
    with pytest.raises(ConfigError, match="2 samples; accelerations need at least 3"):
        replay(PANDA, recorded(2, 7, 5), model="full")
    for span in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ConfigError, match="expected zero"):
            replay(PANDA, recorded(3, 7, 5), model="full", span=span)


def test_gaps_in_the_stamps_are_said() -> None:
    t = np.append(np.arange(10) * 0.01, 3.0 + np.arange(10) * 0.01)
    result = replay(PANDA, Recording(t=t, q=np.zeros((20, 7))), model="full")
    assert any("gap of 2.91 s after t = 0.09 s" in note for note in result.notes)


# --- derivatives


def stamps(seed: int, samples: int) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).uniform(0.1, 1.0, samples))


@given(seed=st.integers(0, 2**32 - 1), half=st.integers(1, 5), extra=st.integers(0, 10))
@FEW
def test_parabolas_are_differentiated_exactly_at_any_stamps(seed: int, half: int, extra: int) -> None:
    window = 2 * half + 1
    t = stamps(seed, window + extra)[:, np.newaxis]
    a, b, c = np.random.default_rng(seed + 1).normal(size=(3, 2))
    np.testing.assert_allclose(differentiate(t[:, 0], a + b * t + c * t**2, window), b + 2 * c * t, atol=1e-8)


@given(seed=st.integers(0, 2**32 - 1), half=st.integers(1, 4))
@FEW
def test_derivatives_have_no_phase_they_look_the_same_backwards(seed: int, half: int) -> None:
    t, window = stamps(seed, 20), 2 * half + 1
    values = np.random.default_rng(seed).normal(size=(20, 3))
    backwards = differentiate(-t[::-1], values[::-1], window)[::-1]
    np.testing.assert_allclose(backwards, -differentiate(t, values, window), rtol=1e-9, atol=1e-9)


def test_three_samples_are_the_central_difference() -> None:
    t, values = np.arange(9) * 0.5, np.random.default_rng(0).normal(size=(9, 2))
    np.testing.assert_allclose(differentiate(t, values, 3)[1:-1], (values[2:] - values[:-2]) / 1.0, atol=1e-12)


@pytest.mark.parametrize(("window", "message"), [(4, "odd number"), (1, "whole number from 3"), (11, "recording of 9")])
def test_impossible_windows_are_refused(window: int, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        differentiate(np.arange(9.0), np.zeros((9, 1)), window)


@pytest.mark.parametrize(("span", "window"), [(0.0, 3), (0.1, 11), (0.25, 25), (1e-9, 3)])
def test_windows_span_about_the_time_asked_for(span: float, window: int) -> None:
    assert window_for(np.arange(100) * 0.01, span) == window


# --- what is refused


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"model": "dynamics"}, "model 'dynamics' is unknown: choose 'gravity', 'full'"),
        ({"gravity": "down"}, "gravity has dtype <U4"),
        ({"gravity": (0.0, 0.0)}, r"gravity has shape \(2,\); expected \(3,\) or \(5, 3\)"),
        ({"gravity": np.zeros((4, 3)), "model": "full"}, r"expected \(3,\) or \(5, 3\)"),
        ({"span": np.zeros(2)}, "span has shape"),
        ({"span": -1.0}, "span of -1.0 s"),
    ],
)
def test_choices_that_do_not_exist_are_refused(options: dict, problem: str) -> None:
    with pytest.raises((ArgumentError, ConfigError), match=problem):
        replay(PANDA, recorded(5, 7, 0), **options)
