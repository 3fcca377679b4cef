"""A base that rocks while the arm moves: its angular velocity makes its angular acceleration, and both count."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from identify_logs import moved, stood, write_csv
from ravengc import identify
from ravengc.errors import ConfigError
from ravengc.identify import Model, Recording, prepared, read_log, smoothed

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

ROBOT = rg.load("raven2_gold")
DYNAMICS = Model(kind="dynamics", friction=())


def rocked() -> tuple[Recording, np.ndarray]:
    """A motion at 100 Hz on a base that rocks about all axes, and its true angular acceleration."""
    table = moved(ROBOT, 20.0, 100.0)
    t, q, qd = table["t"], table["q"], table["dq"]
    qdd = np.gradient(qd, t, axis=0)
    rates = 2.0 * np.pi * np.array([0.4, 0.55, 0.7])
    phase = np.outer(t, rates) + np.arange(3.0)
    turn, rise = 0.8 * np.sin(phase), 0.8 * rates * np.cos(phase)
    force = 9.80665 * upward(lambda at: 0.8 * np.sin(rates * at + np.arange(3.0)), t)
    tau = ROBOT.inverse_dynamics_batch(q, qd, qdd, np.hstack([force, turn, rise]))
    return Recording(stamps=t, q=q, qd=qd, tau=tau, specific_force=force, angular_velocity=turn), rise


def upward(rate: Callable[[float], np.ndarray], t: np.ndarray) -> np.ndarray:
    """The vertical in the axes of a base that turns by ``rate``, upright at first: du/dt = u x w."""
    found, (up, step) = [], (np.array([0.0, 0.0, 1.0]), (t[1] - t[0]) / 10)
    for start in t:
        found.append(up)
        for k in range(10):
            half = up + 0.5 * step * np.cross(up, rate(start + k * step))
            up = up + step * np.cross(half, rate(start + (k + 0.5) * step))
    return np.array(found)


def test_the_angular_acceleration_is_the_slope_of_the_angular_velocity() -> None:
    recording, rise = rocked()
    calm = smoothed(recording, 8.0)
    assert calm.angular_acceleration is not None
    np.testing.assert_allclose(calm.angular_acceleration, rise[100:-100], atol=0.01)
    np.testing.assert_allclose(calm.specific_force, recording.specific_force[100:-100], atol=0.01)  # type: ignore[index]
    measured = smoothed(replace(recording, angular_acceleration=rise), 8.0)
    np.testing.assert_allclose(measured.angular_acceleration, rise[100:-100], atol=0.01)  # type: ignore[arg-type]


def test_a_rocking_base_is_in_the_model() -> None:
    """Known, its motion shows four parameters more and leaves no error; unknown, it is one."""
    recording, _ = rocked()
    found = identify.identify(ROBOT, prepared(recording, DYNAMICS, 8.0), DYNAMICS)
    assert found.rank == 18
    assert found.held_out.overall < 0.005
    still = replace(recording, angular_velocity=None)
    ignored = identify.identify(ROBOT, prepared(still, DYNAMICS, 8.0), DYNAMICS)
    assert ignored.held_out.overall > 3.0 * found.held_out.overall


def test_an_angular_velocity_without_its_acceleration_is_named() -> None:
    recording, rise = rocked()
    whole = replace(recording, qdd=np.zeros_like(recording.q))
    with pytest.raises(ConfigError, match="angular velocity without its angular acceleration"):
        prepared(whole, DYNAMICS, None)
    assert prepared(replace(whole, angular_acceleration=rise), DYNAMICS, None).samples == recording.samples
    assert prepared(whole, Model(kind="gravity+friction"), None).samples == recording.samples


def logged(folder: Path, recording: Recording, **columns: np.ndarray) -> str:
    """The recording as a file, with the base's motion by the names of inertial sensors, or those given."""
    of_base = {"a": recording.specific_force, "gyro_": recording.angular_velocity} | columns
    of_joints = {"t": recording.stamps, "q": recording.q, "dq": recording.qd, "tau": recording.tau}
    table = {name: values for name, values in {**of_joints, **of_base}.items() if values is not None}
    return write_csv(folder / "log.csv", table)


def test_a_gyroscope_s_columns_make_the_base_s_motion_known(tmp_path: Path) -> None:
    recording, _ = rocked()
    log = read_log(ROBOT, logged(tmp_path, recording))
    np.testing.assert_allclose(log.base[:, 3:6], recording.base[:, 3:6], rtol=1e-8)
    assert any("turns at up to" in note for note in log.notes)
    found = identify.identify(ROBOT, prepared(log, DYNAMICS, 8.0), DYNAMICS)
    assert found.held_out.overall < 0.01


@pytest.mark.parametrize(
    ("factor", "units", "message"),
    [
        (180.0 / np.pi, (), "deg/s; say --units deg/s"),
        (1000.0, (), "mrad/s; say --units mrad/s"),
        (-1.0, (), "wrong sign"),
        (3.0, (), "3 times as fast as gravity turns; expected once"),
        (1.0, ("deg/s",), "it is in rad/s, and was taken for deg/s"),
    ],
)
def test_a_gyroscope_in_another_unit_or_sign_is_refused(
    factor: float, units: tuple[Any, ...], message: str, tmp_path: Path
) -> None:
    recording, _ = rocked()
    log = logged(tmp_path, recording, gyro_=factor * recording.base[:, 3:6])
    with pytest.raises(ConfigError, match=message):
        read_log(ROBOT, log, units)
    if units == () and factor > 10.0:
        said = read_log(ROBOT, log, ("deg/s" if factor < 100.0 else "mrad/s",))
        np.testing.assert_allclose(said.base[:, 3:6], recording.base[:, 3:6], rtol=1e-8)


def read(folder: Path, recording: Recording, **columns: np.ndarray) -> tuple[bool, str]:
    """Whether the gyroscope of such a log is used, and all notes."""
    log = read_log(ROBOT, logged(folder, recording, **columns))
    return log.angular_velocity is not None, "; ".join(log.notes)


def test_a_gyroscope_about_other_axes_is_not_believed(tmp_path: Path) -> None:
    recording, _ = rocked()
    used, said = read(tmp_path, recording, gyro_=recording.base[:, [5, 3, 4]])
    assert not used
    assert "the base's gyroscope is not used: it explains" in said


def test_a_gyroscope_that_turns_one_axis_the_other_way_is_refused(tmp_path: Path) -> None:
    recording, _ = rocked()
    with pytest.raises(ConfigError, match="wrong sign about z"):
        read(tmp_path, recording, gyro_=recording.base[:, 3:6] * [1.0, 1.0, -1.0])


def test_a_gyroscope_s_scale_lag_and_bias(tmp_path: Path) -> None:
    """A scale and a lag are said; a bias is what gyroscopes have."""
    recording, _ = rocked()
    turn = recording.base[:, 3:6]
    used, said = read(tmp_path, recording, gyro_=0.7 * turn)
    assert used
    assert "0.7 times about x, 0.7 times about y, 0.7 times about z: is its scale right?" in said
    used, said = read(tmp_path, recording, gyro_=np.roll(turn, 15, axis=0))
    assert used
    assert "of how gravity turns: is it late" in said
    used, said = read(tmp_path, recording, gyro_=turn + np.array([0.1, -0.1, 0.1]))
    assert used
    assert "gravity" not in said
    used, said = read(tmp_path, recording, gyro_=1.9 * turn)
    assert not used
    assert "1.9 times about x" in said


@pytest.mark.parametrize("size", [0.0, 3.0])
def test_a_gyroscope_that_is_stuck_is_not_used(size: float, tmp_path: Path) -> None:
    recording, _ = rocked()
    used, said = read(tmp_path, recording, gyro_=np.full((recording.samples, 3), size))
    assert not used
    assert "it reads the same in every sample" in said


def still() -> Recording:
    """A motion on a base at rest, and a sensor with noise."""
    table, random = moved(ROBOT, 20.0, 100.0), np.random.default_rng(4)
    force = np.array([0.0, 0.0, 9.80665]) + 0.03 * random.standard_normal((len(table["t"]), 3))
    named = {"stamps": table["t"], "q": table["q"], "qd": table["dq"], "tau": table["tau"]}
    return Recording(**named, specific_force=force, angular_velocity=0.02 * random.standard_normal(force.shape))


@pytest.mark.parametrize("scale", [1.0, 180.0 / np.pi])
def test_noise_of_a_gyroscope_is_no_motion_of_the_base(scale: float, tmp_path: Path) -> None:
    recording = still()
    used, said = read(tmp_path, recording, gyro_=scale * recording.base[:, 3:6])
    assert not used
    assert "the base does not turn while samples are taken" in said


def test_a_base_that_spins_about_the_vertical_is_believed(tmp_path: Path) -> None:
    """Gravity does not show it."""
    recording = still()
    used, said = read(tmp_path, recording, gyro_=recording.base[:, 3:6] + [0.0, 0.0, 1.0])
    assert used
    assert "rad/s by its gyroscope, about the vertical" in said


@pytest.mark.parametrize("bias", [-0.01, 0.01])
def test_pauses_between_attitudes_are_no_turning(bias: float, tmp_path: Path) -> None:
    """Poses at rest on a base that is tilted between them: whatever its bias, the gyroscope contradicts nothing."""
    table = stood(ROBOT, 10.0, 2)
    for step in (1.0, 60.0):
        log = read_log(
            ROBOT,
            write_csv(
                tmp_path / "log.csv", table | {"t": step * table["t"], "w": np.full((60, 3), bias) + 1e-4 * table["a"]}
            ),
        )
        assert log.angular_velocity is None
        assert any("samples are too far apart" in note for note in log.notes)


def test_a_gyroscope_without_gravity_is_not_used(tmp_path: Path) -> None:
    table = stood(ROBOT, 10.0, 2)
    alone = {name: table[name] for name in ("t", "q", "tau")} | {"w": 1e-3 * table["a"]}
    log = read_log(ROBOT, write_csv(tmp_path / "log.csv", alone), gravity=(0.0, 0.0, -9.80665))
    assert log.angular_velocity is None
    assert any("angular velocity of the base not used: the base stood still" in note for note in log.notes)
