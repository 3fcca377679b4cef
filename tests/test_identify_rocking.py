"""A base that rocks while the arm moves: its angular velocity makes its angular acceleration, and both count."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from identify_logs import moved, stood, write_csv
from ravengc import identify
from ravengc.errors import ConfigError
from ravengc.identify import Model, Recording, from_motion, prepared, read_log, smoothed
from ravengc.recordings import read_recording

if TYPE_CHECKING:
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
    lean = 0.3 * np.sin(np.outer(t, 2.0 * np.pi * np.array([0.3, 0.45])))
    up = [np.sin(lean[:, 1]), -np.sin(lean[:, 0]) * np.cos(lean[:, 1]), np.cos(lean[:, 0]) * np.cos(lean[:, 1])]
    force = 9.80665 * np.column_stack(up)
    tau = ROBOT.inverse_dynamics_batch(q, qd, qdd, np.hstack([force, turn, rise]))
    return Recording(stamps=t, q=q, qd=qd, tau=tau, specific_force=force, angular_velocity=turn), rise


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


def test_a_gyroscope_that_is_not_read_is_named_and_can_be_given(tmp_path: Path) -> None:
    table = stood(ROBOT, 10.0, 2)
    turn = 0.1 * np.ones((60, 3))
    lines = write_csv(tmp_path / "log.csv", table | {"w": turn})
    text = (tmp_path / "log.csv").read_text(encoding="utf-8").replace("w1,w2,w3", "wx,wy,wz", 1)
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    log = read_log(ROBOT, lines)
    assert any("wx, wy, wz: the base's angular velocity is not read from logs" in note for note in log.notes)
    assert not any("angular velocity" in note for note in read_log(ROBOT, write_csv(tmp_path / "b.csv", table)).notes)
    given = from_motion(read_recording(lines), angular_velocity=turn)
    np.testing.assert_array_equal(given.base[:, 3:6], turn)
