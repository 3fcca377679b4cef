"""``ravengc run --sensor``: a real file descriptor feeds the loop, is unplugged and plugged in again."""

from __future__ import annotations

import importlib.util
import json
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ravengc as rg
from ravengc.cli import main
from ravengc.log import read_log
from ravengc.monitored import STATES

pytest.importorskip("mujoco")


EXAMPLE = Path(__file__).parents[1] / "examples" / "unplugged_sensor.py"
SPEC = importlib.util.spec_from_file_location("unplugged_sensor", EXAMPLE)
assert SPEC is not None
assert SPEC.loader is not None
unplugged_sensor = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(unplugged_sensor)


def run_with(imu: Any, log: Path, *options: str) -> tuple[int, object]:
    imu.start()
    while not imu.path.is_symlink():
        time.sleep(0.01)
    try:
        code = main(["run", "--sensor", f"serial:{imu.path}?format=line", "--log", str(log), *options])
    finally:
        imu.stop.set()
        imu.join()
    return code, read_log(log)


def test_a_sensor_unplugged_and_plugged_in_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    imu = unplugged_sensor.PluggableImu(tmp_path / "imu", [(0.0, 2.5), (3.5, 9.0)])
    code, log = run_with(imu, tmp_path / "run.npz", "--duration", "6", "--json", "--motion", "hold")
    assert code == 0
    state = log.columns["sensor_state"]
    passed = [STATES[state[0]]] + [STATES[b] for a, b in pairwise(state) if a != b]
    assert passed == ["nominal", "live", "held", "live"]
    alarms = log.columns["sensor_status"].astype(np.uint64) & np.uint64(0xFFFF_FFFF)
    held = np.flatnonzero(state == STATES.index("held"))
    assert (alarms[held] != 0).all()
    assert log.columns["sensor_age"][held[0]] < 0.05
    gravity, t = log.columns["gravity"], log.columns["time"]
    steps = np.linalg.norm(np.diff(gravity, axis=0), axis=1)
    # The chain lives in real time: a cycle that the system started late may move as far as its longest step, 10 ms.
    started = t + 1e-9 * log.columns["lateness_ns"]
    on_time = (log.columns["lateness_ns"][1:] < 1e5) & (np.diff(started) < 1.5e-3)
    assert (steps <= 50.0 * 0.01 * (1.0 + 1e-9)).all()
    assert np.quantile(steps[on_time] / (50.0 * np.diff(started)[on_time]), 0.99) <= 1.5
    robot, q, tau = rg.load("raven2_gold"), log.columns["q"], log.columns["tau_gravity"]
    per_gravity = np.array([robot.gravity_torque(q[0], axis) for axis in np.eye(3)]).T
    stiffness = np.abs(robot.gravity_stiffness(q[0], (8.0, 8.0, 8.0)))
    allowed = 1.1 * steps[:, None] * np.linalg.norm(per_gravity, axis=1) + 2.0 * np.abs(np.diff(q, axis=0)) @ stiffness
    assert (np.abs(np.diff(tau, axis=0)) <= allowed + 1e-6).all()
    about = json.loads(capsys.readouterr().out)
    assert about["sensor_counters"]["age"] == 1
    assert about["summary"]["sensor_seconds"]["live"] > 3.0


def test_a_strict_run_without_a_sensor_is_not_armed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "imu").touch()
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
