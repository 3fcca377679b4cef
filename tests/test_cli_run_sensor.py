"""``ravengc run --sensor``: a real file descriptor feeds the loop, is unplugged and plugged in again."""

from __future__ import annotations

import importlib.util
import json
import threading
import time
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import ravengc as rg
from ravengc.cli import main
from ravengc.errors import ConfigError
from ravengc.log import read_log
from ravengc.monitored import STATES
from ravengc.sensors.live import LiveSensor

pytest.importorskip("mujoco")


HELD = STATES.index("held")
MAX_AGE, LONGEST_STEP = 0.04, 0.01
EXAMPLE = Path(__file__).parents[1] / "examples" / "unplugged_sensor.py"
SPEC = importlib.util.spec_from_file_location("unplugged_sensor", EXAMPLE)
assert SPEC is not None
assert SPEC.loader is not None
unplugged_sensor = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(unplugged_sensor)


class Stepped(LiveSensor):
    """Remembers the times at which a run stepped its chain."""

    times: ClassVar[list[int]] = []

    def step(self, now_ns: int) -> None:
        self.times.append(now_ns)
        super().step(now_ns)


def run_with(imu: Any, log: Path, *options: str) -> tuple[int, Any]:
    imu.start()
    while not imu.path.is_symlink():
        time.sleep(0.01)
    try:
        code = main(["run", "--sensor", f"serial:{imu.path}?format=line", "--log", str(log), *options])
    finally:
        imu.stop.set()
        imu.join()
    return code, read_log(log)


def test_a_sensor_unplugged_and_plugged_in_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nominal, live, held with an alarm, live again; no step of gravity or torque beyond what its cycle's time allows.

    A busy machine may starve the sensor on other occasions, too: then the chain has to hold as well, and for the same
    reason. Each statement is about the chain's own clock, so that no cycle needs to have been on time. Where hardly any
    cycle ran, there is nothing to be said about states; rates are kept all the same.
    """
    monkeypatch.setattr("ravengc.cli.run_sensor.LiveSensor", Stepped)
    monkeypatch.setattr(Stepped, "times", [])
    imu = unplugged_sensor.PluggableImu(tmp_path / "imu", [(0.0, 2.5), (3.5, 60.0)])
    code, log = run_with(imu, tmp_path / "run.npz", "--duration", "7", "--json", "--motion", "hold")
    assert code == 0
    elapsed = 1e-9 * np.diff(Stepped.times[-len(log.columns["time"]) :])
    _gravity_and_torque_keep_their_rates(log, elapsed)
    about = json.loads(capsys.readouterr().out)
    if (ran := len(log.columns["time"])) < 3500:
        pytest.skip(f"this machine ran {ran} of 7000 cycles: too few for a sensor at 100 Hz to be followed")
    _states_are_those_of_an_unplugged_sensor(log, elapsed)
    held = np.flatnonzero(np.diff((log.columns["sensor_state"] == HELD).astype(int)) == 1)
    assert about["sensor_counters"]["age"] == len(held)
    assert about["summary"]["sensor_seconds"]["live"] > 2.0


def _states_are_those_of_an_unplugged_sensor(log: Any, elapsed: np.ndarray) -> None:
    state, age = log.columns["sensor_state"], log.columns["sensor_age"]
    changes = [(STATES[a], STATES[b]) for a, b in pairwise(state) if a != b]
    assert changes[:3] == [("nominal", "live"), ("live", "held"), ("held", "live")]
    assert set(changes[1:]) == {("live", "held"), ("held", "live")}
    alarms = log.columns["sensor_status"].astype(np.uint64) & np.uint64(0xFFFF_FFFF)
    assert (alarms[state == HELD] != 0).all()
    begins = np.flatnonzero((state[1:] == HELD) & (state[:-1] != HELD)) + 1
    assert (age[begins] > MAX_AGE).all()
    assert (age[begins - 1] <= MAX_AGE).all(), "no cycle before could have known"
    on_time = elapsed[begins - 1] < 0.009
    assert (age[begins][on_time] < 0.05).all()
    assert age[state == HELD].max() > 0.9, "the plug was out for a second"


def _gravity_and_torque_keep_their_rates(log: Any, elapsed: np.ndarray) -> None:
    steps = np.linalg.norm(np.diff(log.columns["gravity"], axis=0), axis=1)
    assert (steps <= 50.0 * np.minimum(elapsed, LONGEST_STEP) * (1.0 + 1e-9) + 1e-12).all()
    robot, q, g, tau = rg.load("raven2_gold"), log.columns["q"], log.columns["gravity"], log.columns["tau_gravity"]
    assert tau == pytest.approx(robot.gravity_torque_batch(q, g), abs=1e-9)
    by_gravity = tau[1:] - robot.gravity_torque_batch(q[1:], g[:-1])  # what is left is the arm's own motion
    per_axis = np.array([robot.gravity_torque_batch(q[1:], axis) for axis in np.eye(3)])
    allowed = steps[:, None] * np.linalg.norm(per_axis, axis=0)
    assert (np.abs(by_gravity) <= allowed * (1.0 + 1e-9) + 1e-9).all()


def test_a_strict_run_without_a_sensor_is_not_armed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ravengc.cli.run_sensor.PATIENCE_S", 0.3)
    options = ["--policy", "strict", "--log", str(tmp_path / "run.npz")]
    assert main(["run", "--sensor", f"serial:{tmp_path / 'missing'}?format=line", *options]) == 2
    said = capsys.readouterr().err
    assert "not armed" in said
    assert "missing" in said
    assert not (tmp_path / "run.npz").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--sensor", "serail:/dev/x?format=line"], "did you mean 'serial'"),
        (["--sensor", "serial:/dev/x?fromat=line"], "format"),
        (["--sensor", "replay:example:xio", "--fast"], "--fast"),
        (["--policy", "lax"], "paper"),
    ],
)
def test_a_sensor_that_cannot_be_meant(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        code = main(["run", *options])
    except SystemExit as stopped:
        code = stopped.code
    assert code == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [((), "the loop refuses"), (("--mount", "15"), "mount '15'"), (("--mount", "15:2:0.01:u"), "direction 'u'")],
)
def test_a_run_that_is_refused_lets_go_of_its_sensor(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: tuple[str, ...],
    words: str,
) -> None:
    """No thread goes on reading a port, whichever part refuses what was asked for."""

    def refuse(*_: object, **__: object) -> None:
        raise ConfigError(words)

    if not options:
        monkeypatch.setattr("ravengc.cli.run_setup.ControlLoop", refuse)
    address = f"serial:{tmp_path / 'missing'}?format=line"
    assert main(["run", "--sensor", address, "--log", str(tmp_path / "run.npz"), *options]) == 2
    assert words in capsys.readouterr().err
    assert "ravengc-sensor" not in [thread.name for thread in threading.enumerate()]


# The robot's own table


def robot_with(folder: Path, sensor: str, *, policy: str = "paper", unit: str = "g") -> str:
    """A robot's file whose table names a sensor that hangs upside down, with this unit.

    The declared rate is lower than the sensor's: so a busy machine may be late by 160 ms.
    """
    path = folder / "arm.toml"
    rg.load("raven2_gold").to_toml(path)
    table = f'\n[accelerometer]\nsensor = "{sensor}"\nunit = "{unit}"\npolicy = "{policy}"\nrate_hz = 25\n'
    path.write_text(path.read_text() + table + "rotation = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]\n")
    return str(path)


def hanging(path: Path) -> Path:
    """Two minutes of a sensor upside down that sends g, in a file."""
    noise = 0.002 * np.random.default_rng(3).standard_normal((12_000, 3))
    rows = [f"{k / 100:.2f},{x:.6f},{y:.6f},{z - 1.0:.6f}" for k, (x, y, z) in enumerate(noise)]
    path.write_text("\n".join(["t,ax,ay,az", *rows]))
    return path


def test_a_run_takes_the_sensor_that_the_robots_file_names(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Chain and sensor of the table, and nothing to say on the command line; a strict run begins with a live sensor."""
    monkeypatch.setattr("ravengc.cli.run_sensor.PATIENCE_S", 30.0)
    address = f"replay:{hanging(tmp_path / 'imu.csv')}"
    options = [
        "--robot",
        robot_with(tmp_path, address, policy="strict"),
        "--duration",
        "0.5",
        "--log",
        str(tmp_path / "run.npz"),
        "--json",
    ]
    assert main(["run", *options]) == 0
    about = json.loads(capsys.readouterr().out)
    assert about["sensor"] == address
    assert about["sensor_counters"]["accepted"] > 0
    log = read_log(tmp_path / "run.npz")
    assert log.columns["sensor_state"][0] == STATES.index("live")
    assert np.abs(log.columns["gravity"] - (0.0, 0.0, -rg.STANDARD_GRAVITY)).max() < 0.2


def test_another_sensor_may_be_named_beside_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = robot_with(tmp_path, "serial:/dev/nosuch?format=line")
    options = ["--robot", robot, "--duration", "0.2", "--log", str(tmp_path / "run.npz"), "--json"]
    assert main(["run", *options, "--sensor", "sim", "--fast"]) == 0
    assert json.loads(capsys.readouterr().out)["sensor"] == "sim"
    assert main(["run", *options, "--fast"]) == 2
    said = capsys.readouterr().err
    assert "serial:/dev/nosuch" in said
    assert "leave out --fast, or say --sensor sim" in said


def test_a_robot_without_a_table_runs_with_the_plants_own_sensor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "--duration", "0.2", "--fast", "--log", str(tmp_path / "run.npz"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["sensor"] == "sim"


def test_a_sensor_in_another_unit_is_not_armed_and_the_unit_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ravengc.cli.run_sensor.PATIENCE_S", 1.0)
    address = f"replay:{hanging(tmp_path / 'imu.csv')}"
    robot = robot_with(tmp_path, address, policy="strict", unit="cm/s^2")
    assert main(["run", "--robot", robot, "--log", str(tmp_path / "run.npz")]) == 2
    said = capsys.readouterr().err
    assert "not armed" in said
    assert "looks like g, not " in said
    assert "set unit = g" in said


def test_the_help_says_how_to_run_with_the_robots_own_sensor(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "ravengc run --robot my_arm.toml # the sensor" in said
    assert "the one that the robot's file names in its [accelerometer] table, else sim" in said
