"""Recordings fitted to a robot: its joints in its order, rad and m, at the motors or at the joints."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ravengc
from ravengc.errors import ConfigError
from ravengc.recordings import Recording, fit_to_robot, joint_side, read_recording

PANDA = ravengc.load("panda").spec
RAVEN = ravengc.load("raven2_gold")


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"joints": ["1", "1", "3", "4", "5", "6", "7"]}, "one is chosen twice"),
        ({"angle_unit": "degrees"}, "angle_unit 'degrees' is unknown: .*; did you mean 'deg'"),
        ({"length_unit": "cm"}, "length_unit 'cm' is unknown: choose 'auto', 'm', 'mm'"),
    ],
)
def test_choices_that_do_not_exist_are_refused(options: dict, problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        fit_to_robot(read_recording("example:panda"), PANDA, **options)


def recorded(q: list, names: tuple[str, ...] = (), **more: object) -> Recording:
    return Recording(t=np.arange(len(q)) * 0.1, q=q, names=names, source="log", **more)


def test_columns_follow_the_robots_joint_names() -> None:
    names = tuple(reversed([name.upper() for name in PANDA.coordinate_names]))
    fitted = fit_to_robot(recorded([[*range(7), 99]], (*names, "finger")), PANDA)
    np.testing.assert_array_equal(fitted.q, [[6, 5, 4, 3, 2, 1, 0]])
    assert fitted.notes == ("joints not used: finger",)


def test_foreign_names_are_taken_in_order_and_said() -> None:
    names = tuple(f"fer_joint{number}" for number in range(1, 8))
    fitted = fit_to_robot(recorded([[0.1] * 7], names), PANDA)
    assert "fer_joint1 = panda_joint1" in fitted.notes[0]


def test_joints_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"2 joints \('a', 'b'\), but panda has 7 .*--joints"):
        fit_to_robot(recorded([[0, 0]], ("a", "b")), PANDA)
    mixed = ("shoulder", "b", "c")
    with pytest.raises(ConfigError, match="names 'shoulder' as raven2_gold does, but not 'elbow', 'insertion'"):
        fit_to_robot(recorded([[0, 1, 0.3]], mixed), RAVEN.spec)
    with pytest.raises(ConfigError, match="has no joint 'bb'; did you mean 'b'"):
        fit_to_robot(recorded([[0, 1, 0.3]], mixed), RAVEN.spec, joints=["c", "bb", "shoulder"])
    with pytest.raises(ConfigError, match="2 joints chosen, but raven2_gold has 3"):
        fit_to_robot(recorded([[0, 1, 0.3]], mixed), RAVEN.spec, joints=["c", "b"])


def test_joints_can_be_chosen_by_name_or_number() -> None:
    by_number = fit_to_robot(recorded([[9, 0.3, 1, 0.5]]), RAVEN.spec, joints=["3", "4", "2"])
    np.testing.assert_array_equal(by_number.q, [[1, 0.5, 0.3]])


def test_suspect_units_are_named_and_can_be_settled() -> None:
    degrees = recorded([[45, 90, 0.3]], qd=[[1, 2, 3]], tau=[[1, 2, 3]])
    with pytest.raises(ConfigError, match=r"'shoulder' reaches 45, far outside .* rad; .*--angle-unit deg"):
        fit_to_robot(degrees, RAVEN.spec)
    fitted = fit_to_robot(degrees, RAVEN.spec, angle_unit="deg")
    np.testing.assert_allclose(fitted.q, [[np.pi / 4, np.pi / 2, 0.3]])
    np.testing.assert_allclose(fitted.qd, [[np.pi / 180, np.pi / 90, 3]])
    np.testing.assert_array_equal(fitted.tau, [[1, 2, 3]])
    assert fit_to_robot(degrees, RAVEN.spec, angle_unit="rad").q[0, 0] == 45.0


def test_millimetres_are_named_and_converted() -> None:
    millimetres = recorded([[0.5, 1.0, 300]])
    with pytest.raises(ConfigError, match=r"'insertion' reaches 300, far outside .* m; .*--length-unit mm"):
        fit_to_robot(millimetres, RAVEN.spec)
    np.testing.assert_allclose(fit_to_robot(millimetres, RAVEN.spec, length_unit="mm").q, [[0.5, 1.0, 0.3]])


@given(seed=st.integers(0, 2**32 - 1))
def test_power_at_the_motors_is_power_at_the_joints(seed: int) -> None:
    random = np.random.default_rng(seed)
    motor = recorded(random.normal(size=(4, 3)), qd=random.normal(size=(4, 3)), tau=random.normal(size=(4, 3)))
    joint = joint_side(motor, RAVEN)
    np.testing.assert_allclose(joint.q, [RAVEN.joint_positions(sample) for sample in motor.q], atol=1e-15)
    np.testing.assert_allclose(
        (joint.tau * joint.qd).sum(axis=1), (motor.tau * motor.qd).sum(axis=1), rtol=1e-9, atol=1e-12
    )
    assert joint.names == RAVEN.joint_names


def test_motor_recordings_need_a_transmission() -> None:
    with pytest.raises(ConfigError, match="has no transmission"):
        joint_side(recorded([[0.0] * 7]), ravengc.load("panda"))
