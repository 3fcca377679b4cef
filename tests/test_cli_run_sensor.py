"""``ravengc run --sensor``: a real file descriptor feeds the loop, is unplugged and plugged in again."""

from __future__ import annotations

import importlib.util
import json
import math
import threading
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ravengc as rg
from ravengc.cli import main
from ravengc.errors import ConfigError
from ravengc.log import read_log
from ravengc.monitored import STATES
from ravengc.sensors.watch import WatchedSensor

pytest.importorskip("mujoco")


LIVE, HELD = STATES.index("live"), STATES.index("held")
DECLARED_HZ = 10
"""Less than what the sensors of these tests send, so that a busy machine may be late by 400 ms."""
MAX_AGE, LONGEST_STEP = 4.0 / DECLARED_HZ, 0.01
EXAMPLE = Path(__file__).parents[1] / "examples" / "unplugged_sensor.py"
SPEC = importlib.util.spec_from_file_location("unplugged_sensor", EXAMPLE)
assert SPEC is not None
assert SPEC.loader is not None
unplugged_sensor = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(unplugged_sensor)


class Watched(WatchedSensor):
    """Is unplugged after a second live, plugged in after a second without, and stops the run when live for half of one.

    So everything waits for what comes before it, and a machine that is busy otherwise needs longer and no more.
    """

    def __init__(self, *parts: Any) -> None:
        self.times: list[int] = []
        self.plugged, self.was_pulled, self.live_from = True, False, math.inf
        super().__init__(*parts)

    def step(self, now_ns: int) -> None:
        seconds = 1e-9 * now_ns
        self.live_from = min(self.live_from, seconds) if self.state == LIVE else math.inf
        if not self.was_pulled:
            self.was_pulled = seconds - self.live_from > 1.0
            self.plugged = not self.was_pulled
        elif self.age > 1.0:
            self.plugged = True
        elif self.plugged and seconds - self.live_from > 0.5:
            raise KeyboardInterrupt
        self.times.append(now_ns)
        super().step(now_ns)


UPSIDE_DOWN = "[[1, 0, 0], [0, -1, 0], [0, 0, -1]]"


def robot_with(
    folder: Path, sensor: str, *, policy: str = "paper", unit: str = "g", rotation: str = UPSIDE_DOWN
) -> str:
    """A robot's file whose table names a sensor with this unit and mounting."""
    path = folder / "arm.toml"
    rg.load("raven2_gold").to_toml(path)
    table = f'\n[accelerometer]\nsensor = "{sensor}"\nunit = "{unit}"\npolicy = "{policy}"\nrate_hz = {DECLARED_HZ}\n'
    path.write_text(path.read_text() + f"{table}rotation = {rotation}\n")
    return str(path)


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
    reason. Each statement is about the chain's own clock, so that no cycle needs to have been on time.
    """
    made: list[Watched] = []

    class Made(Watched):
        def __init__(self, *parts: Any) -> None:
            super().__init__(*parts)
            made.append(self)

    monkeypatch.setattr("ravengc.cli.run_sensor.WatchedSensor", Made)
    imu = unplugged_sensor.PluggableImu(tmp_path / "imu", lambda _: not made or made[0].plugged)
    robot = robot_with(tmp_path, "sim", unit="m/s^2", rotation="[[1, 0, 0], [0, 1, 0], [0, 0, 1]]")
    options = ["--robot", robot, "--rate", "200", "--duration", "60", "--json", "--motion", "hold"]
    code, log = run_with(imu, tmp_path / "run.npz", *options)
    assert code == 0
    elapsed = 1e-9 * np.diff(made[0].times[-len(log.columns["time"]) :])
    _gravity_and_torque_keep_their_rates(log, elapsed)
    _states_are_those_of_an_unplugged_sensor(log, elapsed)
    about = json.loads(capsys.readouterr().out)
    held = np.flatnonzero(np.diff((log.columns["sensor_state"] == HELD).astype(int)) == 1)
    assert about["interrupted"], "the sensor was live again before the time was over"
    assert about["sensor_counters"]["age"] == len(held)


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
    assert (age[begins] <= age[begins - 1] + elapsed[begins - 1] + 1e-9).all(), "the first that could, did"
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


def test_a_run_on_the_level_vector_says_why_it_has_no_sensor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ravengc.cli.run_sensor.PATIENCE_S", 0.2)
    monkeypatch.setenv("COLUMNS", "120")
    options = ["--duration", "0.3", "--log", str(tmp_path / "run.npz")]
    assert main(["run", "--sensor", f"serial:{tmp_path / 'unplugged'}?format=line", *options]) == 1
    said = capsys.readouterr().out
    assert "unplugged" in said
    assert "base sensor: it was never live: the law had the gravity of a level base throughout" in said
    assert "base sensor: no sample came" in said
    assert rg.FAULTS["no_sensor"] in said


@pytest.mark.parametrize(("law", "code"), [("pd+dg", 1), ("passive", 1), ("pd", 0), ("pd+sg", 0)])
def test_a_law_that_takes_no_gravity_from_the_sensor_does_without_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], law: str, code: int
) -> None:
    """A base that lies farther over than the chain lets up be."""
    options = ["--base", "tilt:60", "--fast", "--duration", "0.6", "--json", "--log", str(tmp_path / "run.npz")]
    assert main(["run", "--controller", law, *options]) == code
    about = json.loads(capsys.readouterr().out)
    assert about["sensor_counters"]["axes"] == 1
    assert about["summary"]["sensor_seconds"]["live"] == 0.0
    assert [words for words in about["sensor_verdicts"] if "never live" in words] == about["sensor_verdicts"]
    assert len(about["sensor_verdicts"]) == code


@pytest.mark.parametrize("in_table", [False, True])
@pytest.mark.parametrize(
    ("option", "value"), [("--noise", "0"), ("--sensor-place", "0,0,0"), ("--sensor-rate", "100"), ("--seed", "0")]
)
def test_what_only_the_plants_own_sensor_has_is_refused_beside_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str, value: str, *, in_table: bool
) -> None:
    """Whether or not it is the default's value, and whoever named the other sensor."""
    address = f"replay:{hanging(tmp_path / 'imu.csv')}"
    named = ["--robot", robot_with(tmp_path, address)] if in_table else ["--sensor", address]
    assert main(["run", *named, option, value, "--log", str(tmp_path / "run.npz")]) == 2
    said = capsys.readouterr().err
    assert f"{option}: only the plant's own accelerometer has that, not '{address}'" in said
    assert "leave it out, or say --sensor sim" in said


def test_a_run_with_another_sensor_records_nothing_of_the_plants_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own = ("noise_m_s2", "sensor_rate_hz", "sensor_place_m", "seed")
    options = ["--duration", "0.2", "--log", str(tmp_path / "run.npz")]
    other = ["--robot", robot_with(tmp_path, f"replay:{hanging(tmp_path / 'imu.csv')}")]
    main(["run", *options, *other, "--json"])
    about = json.loads(capsys.readouterr().out)
    assert [about[name] for name in own] == [None] * 4
    main(["run", *options, *other])
    assert "it does not feel the simulated base" in capsys.readouterr().out
    main(["run", *options, "--fast", "--json"])
    about = json.loads(capsys.readouterr().out)
    assert [about[name] for name in own] == [0.02, 100.0, [0.0, 0.0, 0.0], 0]
    main(["run", *options, "--fast"])
    assert "does not feel" not in capsys.readouterr().out


def test_a_run_says_which_unit_to_set_and_what_its_alarms_mean(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--sensor", f"replay:{hanging(tmp_path / 'imu.csv')}", "--duration", "1", "--motion", "hold"]
    assert main(["run", *options, "--log", str(tmp_path / "run.npz")]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "looks like g, not m/s²: set unit = g" in said
    assert "free fall, on a base that is not declared to move so" in said


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
    first = STATES[log.columns["sensor_state"][0]]
    assert first not in {"no_data", "nominal"}, "armed on a live sensor, which a busy machine may have lost again"
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


@pytest.mark.parametrize(
    ("in_table", "option", "same_as"), [("2", (), "2"), ("4", ("--cutoff", "2"), "2"), (None, (), None)]
)
def test_the_low_pass_is_the_options_else_the_tables(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    in_table: str | None,
    option: tuple[str, ...],
    same_as: str | None,
) -> None:
    """For the plant's own sensor too, as the help says: the same gravity to the last bit as with that cut-off."""

    def used(robot: str, *options: str) -> Any:
        path = tmp_path / "run.npz"
        assert main(["run", "--robot", robot, "--fast", "--duration", "0.5", "--log", str(path), *options]) == 0
        capsys.readouterr()
        return read_log(path).columns["gravity"]

    robot = Path(robot_with(tmp_path, "sim"))
    if in_table is not None:
        robot.write_text(robot.read_text() + f"cutoff_hz = {in_table}\n")
    plain = () if same_as is None else ("--cutoff", same_as)
    assert np.array_equal(used(str(robot), *option), used("raven2_gold", *plain))
    assert (same_as is None) == np.array_equal(used(str(robot), *option), used("raven2_gold"))


def test_a_robot_without_a_table_runs_with_the_plants_own_sensor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "--duration", "0.2", "--fast", "--log", str(tmp_path / "run.npz"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["sensor"] == "sim"


def test_a_base_that_the_file_declares_is_believed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A step of acceleration is a jump of the specific force on a base that does not declare its jerk."""
    seen = {}
    for declared in ("", "jerk = 2000\n"):
        robot = Path(robot_with(tmp_path, "sim"))
        robot.write_text(robot.read_text() + declared)
        options = ["--base", "step:1.96:1:2", "--axis", "z", "--fast", "--duration", "3", "--json"]
        assert main(["run", "--robot", str(robot), *options, "--log", str(tmp_path / "run.npz")]) == 0
        seen[declared != ""] = json.loads(capsys.readouterr().out)
    assert seen[False]["sensor_counters"]["jerk"] > 0
    assert seen[True]["sensor_counters"]["jerk"] == 0


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
