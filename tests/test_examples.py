"""The examples that need nothing but the library run, and do what they say."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ravengc as rg
from ravengc.errors import SensorError

EXAMPLES = Path(__file__).parents[1] / "examples"


def parts_of(example: str) -> dict[str, Any]:
    """The functions of an example that has not been run."""
    return runpy.run_path(str(EXAMPLES / example))


def exit_of(monkeypatch: pytest.MonkeyPatch, example: str, *words: str) -> Any:
    """What an example exits with that is called with these words."""
    monkeypatch.setattr(sys, "argv", [example, *words])
    with pytest.raises(SystemExit) as caught:
        runpy.run_path(str(EXAMPLES / example), run_name="__main__")
    return caught.value.code


def test_a_breathing_target_is_followed_better_than_where_it_was_last_seen(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(EXAMPLES / "breathing_target.py"), run_name="__main__")
    errors = {
        name: float(rms) for name, rms in re.findall(r"(\w+): hold error ([\d.]+) mm RMS", capsys.readouterr().out)
    }
    assert errors["switch"] < 0.35
    assert errors["switch"] < 0.4 * errors["hold"]


def test_an_arm_is_held_by_the_torques_of_a_robot_file_and_a_sensor() -> None:
    example, robot = parts_of("imu_to_torques.py"), rg.load("ur5")
    drives = example["Drives"](robot)
    example["hold"](robot, "sim:tilt:20", drives, 0.2)
    assert len(drives.torques) == 200
    last, q, angle = drives.torques.pop(), np.zeros(robot.n), np.radians(20.0)
    drives.read(q)
    tilted = rg.Gravity(0.0, -np.sin(angle) * rg.STANDARD_GRAVITY, -np.cos(angle) * rg.STANDARD_GRAVITY)
    np.testing.assert_allclose(last, robot.gravity_torque(q, tilted), rtol=0.02)


@pytest.mark.parametrize(
    ("address", "why"),
    [("serial:/dev/none?format=line", "'/dev/none': not there"), ("sim:tilt:20?noise=0", "repeats the same bits")],
)
def test_a_sensor_that_cannot_be_trusted_holds_nothing_and_it_says_why(address: str, why: str) -> None:
    example, robot = parts_of("imu_to_torques.py"), rg.load("ur5")
    example["hold"].__globals__["PATIENCE_S"] = 2.0
    with pytest.raises(SensorError, match="no sensor to trust after 2 s: ") as caught:
        example["hold"](robot, address, example["Drives"](robot), 0.2)
    assert str(caught.value).startswith(address)
    assert why in str(caught.value)


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("nobody.urdf",), "nobody.urdf: cannot be read"),
        (("panda", "serial:/dev/ttyUSB0?fromat=line"), "'fromat'; did you mean 'format'"),
    ],
)
def test_a_slip_on_the_command_line_is_told_in_one_line(
    monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], why: str
) -> None:
    line = exit_of(monkeypatch, "imu_to_torques.py", *words)
    assert why in line
    assert "\n" not in line


@pytest.mark.parametrize("example", ["organ_phantom.py", "simulated_logs.py"])
def test_what_cannot_be_written_is_told_in_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, example: str
) -> None:
    (tmp_path / "taken").write_text("", encoding="utf-8")
    assert "taken" in exit_of(monkeypatch, example, str(tmp_path / "taken" / "here"))


@pytest.mark.parametrize(
    "example", ["imu_to_torques.py", "organ_phantom.py", "simulated_logs.py", "unplugged_sensor.py"]
)
def test_help_explains_and_does_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], example: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_of(monkeypatch, example, "--help") == 0
    assert f"python examples/{example}" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_on_a_boat_an_inertial_unit_knows_all_and_an_accelerometer_more_than_nothing() -> None:
    errors = parts_of("ur5_on_a_boat.py")["errors"]()
    assert errors["inertial unit"].max() < 1e-9
    assert (errors["accelerometer"] <= errors["level gravity"]).all()
    assert errors["accelerometer"].sum() < 0.3 * errors["level gravity"].sum()


def test_a_controller_of_ones_own_presses_as_wanted_while_the_tool_slides() -> None:
    forces, places, reason = parts_of("own_controller.py")["slide"]()
    assert forces[-1] == pytest.approx(5.0, abs=0.01)
    assert forces.max() < 5.05
    assert np.ptp(places[:, 1]) == pytest.approx(0.12, abs=1e-3)
    assert np.ptp(places[:, 0]) < 1e-4
    assert reason == ""
