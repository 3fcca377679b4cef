"""``ravengc run`` from its options to its files and exit codes."""

from __future__ import annotations

import json
import math
import os
import pty
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ravengc as rg
from ravengc.cli import main
from ravengc.cli.progress import PrerenderedBar
from ravengc.cli.run_setup import _sensor_note, rocking_axis
from ravengc.config import spec_for, write_toml
from ravengc.disturbances import LinearSpring
from ravengc.errors import ConfigError
from ravengc.log import read_log
from ravengc.monitored import MonitoredSensor
from ravengc.sim import parse_base

pytest.importorskip("mujoco")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ran(capsys: pytest.CaptureFixture[str], *options: str) -> dict[str, Any]:
    """What ``ravengc run --fast --json`` prints with these options."""
    assert main(["run", "--fast", "--json", "--duration", "0.3", *options]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    about: dict[str, Any] = json.loads(printed.out)
    return about


def test_the_default_run_prints_tables_and_leaves_a_log(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--fast", "--duration", "0.3"]) == 0
    printed = capsys.readouterr().out
    for expected in (
        "PD + dynamic gravity",
        "rocking 10 to 20 deg at 1 Hz about (0, -1, 0)",
        "300 cycles unpaced",
        "shoulder",
        "insertion",
        "PD share",
        "p99.9",
        "log: out/run.npz",
    ):
        assert expected in printed
    log = read_log(folder / "out" / "run.npz")
    assert log.joints == ("shoulder", "elbow", "insertion")
    assert log.metadata["joints"] == list(log.joints)
    assert log.columns["q"].shape == (300, 3)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_log_says_joint_and_unit_of_every_number(capsys: pytest.CaptureFixture[str], suffix: str) -> None:
    path = f"run{suffix}"
    ran(capsys, "--log", path)
    log, names = read_log(path), ("shoulder", "elbow", "insertion")
    assert log.joints == names
    assert log.metadata["units"].keys() == log.columns.keys()
    assert log.metadata["units"]["tau_pd"] == ["N m", "N m", "N"]
    if suffix == ".csv":
        header = Path(path).read_text(encoding="utf-8").splitlines()[1].split(",")
        assert [f"{name}/q" for name in names] == header[1:4]
    assert main(["replay", "raven2_gold", path, "--joints", "shoulder", "elbow", "insertion", "--json"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert [joint["name"] for joint in replayed["joints"]] == list(names)


def test_a_paced_run_accounts_for_every_cycle(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--json", "--duration", "0.2", "--rate", "200"]) == 0
    about = json.loads(capsys.readouterr().out)
    assert about["paced"]
    assert about["summary"]["cycles"] + about["summary"]["skipped_cycles"] == 40


def test_json_and_log_tell_the_same(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    about = ran(capsys, "--log", "run.csv", "--seed", "3")
    log = read_log(folder / "run.csv")
    assert log.metadata == about
    error = log.columns["q_desired"] - log.columns["q"]
    assert np.sqrt(np.mean(error**2, axis=0)) == pytest.approx(about["summary"]["rms_error"])
    ages = log.columns["sensor_age"]
    assert np.isnan(ages[:10]).all()
    assert np.nanmax(ages) == pytest.approx(0.009)
    assert log.columns["gravity"][:10] == pytest.approx(np.tile((0.0, 0.0, -9.80665), (10, 1)))


def test_the_same_seed_gives_the_same_run(capsys: pytest.CaptureFixture[str]) -> None:
    first, again, other = (ran(capsys, "--seed", seed)["summary"]["rms_error"] for seed in ("1", "1", "2"))
    assert first == again != other


def test_dynamic_gravity_leaves_the_least_to_the_pd_term(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """On a tilted base at rest, after the first samples: PD alone gives all, static gravity a part, dynamic nothing."""
    share = {}
    for law in ("pd", "pd+sg", "pd+dg"):
        options = ("--controller", law, "--base", "tilt:20", "--motion", "hold", "--noise", "0", "--duration", "2")
        ran(capsys, *options)
        columns = read_log(folder / "out" / "run.npz").columns
        pd, total = (np.linalg.norm(columns[name][1500:, :2]) for name in ("tau_pd", "tau"))
        share[law] = pd / total
    assert share["pd"] == 1.0
    assert 0.2 < share["pd+sg"] < 0.9
    assert share["pd+dg"] < 1e-3


def test_a_passive_arm_stays_where_it_was_put(capsys: pytest.CaptureFixture[str]) -> None:
    about = ran(capsys, "--controller", "passive", "--coulomb", "0.5,0.5,0.5", "--duration", "2")
    assert max(about["summary"]["rms_error"]) < 1e-3
    assert about["summary"]["pd_share_revolute"] == 0.0


@pytest.mark.parametrize(
    "robot", ["raven2_green", "raven2_gold_wrist", "rrbot", "dvrk_mtml", "dvrk_psm_si", "panda", "pa10"]
)
def test_any_robot_with_masses_follows_its_trajectory(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    about = ran(capsys, "--robot", robot)
    assert max(about["summary"]["rms_error"]) < 0.02
    assert about["gains"]["source"]


@pytest.mark.parametrize("axis", ["1e200,0,0", "0,0,1e-320", "5e-324,5e-324,0"])
def test_an_axis_of_any_length_is_a_direction(capsys: pytest.CaptureFixture[str], axis: str) -> None:
    assert "nan" not in ran(capsys, "--axis", axis)["base"]


def test_the_full_motion_of_the_base_leaves_least_to_pd(capsys: pytest.CaptureFixture[str]) -> None:
    """On a base that rocks at 2 Hz, with a gyro and a sensor off the base origin; the first samples are trust."""
    options = ("--base", "rocking:10:20:2", "--sensor-place", "0,0,-0.3", "--sensor-rate", "1000", "--noise", "0")
    share = {}
    for law in ("pd", "pd+dg", "pd+bm"):
        ran(capsys, "--controller", law, *options, "--duration", "1.5", "--log", "run.npz")
        columns = {name: column[500:] for name, column in read_log("run.npz").columns.items()}
        share[law] = np.linalg.norm(columns["tau_pd"][:, 0]) / np.linalg.norm(columns["tau"][:, 0])
    assert share["pd+bm"] < 0.5 * share["pd+dg"] < share["pd"]


def test_events_of_the_controller_are_said(capsys: pytest.CaptureFixture[str]) -> None:
    about = ran(capsys, "--natural-frequency", "2000", "--damping-ratio", "0.01")
    assert about["controller_states"] == ["disarmed", "ramping", "armed", "fault"]
    assert about["controller_counters"]["torque_limit"] > 0
    main(["run", "--fast", "--duration", "0.3", "--natural-frequency", "2000", "--damping-ratio", "0.01"])
    assert "controller: " in (said := capsys.readouterr().out)
    assert "a torque stands at its limit" in said


def test_an_arm_that_flies_apart_is_reported_without_warnings(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "--fast", "--json", "--duration", "0.05", "--base", "rocking:0:1:1e9"]) == 1
    printed = capsys.readouterr()
    assert printed.err == ""
    assert json.loads(printed.out)["summary"]["finite"] is False


def test_suffixes_may_be_written_in_capitals(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ran(capsys, "--log", "RUN.CSV", "--plot", "RUN.PNG")
    assert read_log(folder / "RUN.CSV").columns["q"].shape == (300, 3)
    assert (folder / "RUN.PNG").read_bytes().startswith(b"\x89PNG")


def test_the_picture_is_written(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ran(capsys, "--plot", "pictures/run.svg")
    assert "</svg>" in (folder / "pictures" / "run.svg").read_text(encoding="utf-8")
    assert [file.name for file in (folder / "pictures").iterdir()] == ["run.svg"]


def test_the_torque_of_disturbance_elements_is_in_the_picture_and_in_the_table(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")  # narrower, the heading has two lines
    gold = spec_for("raven2_gold")
    spring = LinearSpring(name="coil", joint=gold.coordinate_names[1], stiffness=2.0, rest=0.25)
    write_toml(replace(gold, name="plain"), "plain.toml")
    write_toml(replace(gold, name="sprung", disturbances=(spring,)), "sprung.toml")
    for name in ("plain", "sprung"):
        command = ["run", "--fast", "--duration", "0.1", "--robot", f"{name}.toml", "--plot", f"{name}.svg"]
        assert main(command) == 0
        has = name == "sprung"
        assert ("disturbance term" in capsys.readouterr().out) == has
        assert ("disturbance term" in (folder / f"{name}.svg").read_text(encoding="utf-8")) == has


@pytest.mark.parametrize("duration", ["0.001", "0.002"])
def test_a_run_of_a_cycle_or_two_has_a_picture(folder: Path, capsys: pytest.CaptureFixture[str], duration: str) -> None:
    ran(capsys, "--plot", "run.svg", "--duration", duration)
    assert "</svg>" in (folder / "run.svg").read_text(encoding="utf-8")


def test_a_run_that_was_stopped_before_its_first_cycle_has_log_and_picture(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ravengc.loop.ControlLoop._cycle", stopped)
    about = ran(capsys, "--plot", "run.svg", "--log", "run.npz")
    assert about["interrupted"]
    assert about["summary"]["cycles"] == 0
    assert read_log(folder / "run.npz").columns["q"].shape == (0, 3)
    assert (folder / "run.svg").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--robot", "raven3"), "raven3"),
        (("--robot", "dvrk_psm"), "no masses"),
        (("--controller", "pid"), "'pid' is unknown"),
        (("--base", "tilt"), "write level, tilt:DEG"),
        (("--base", "rocking:1:2:x"), "write level, tilt:DEG"),
        (("--base", "rocking:1:2:0"), "hz a positive number"),
        (("--axis", "0,0,0"), "no direction"),
        (("--rate", "0"), "rate 0 Hz"),
        (("--duration", "nan"), "duration nan"),
        (("--coulomb", "1,2"), "coulomb must be one number or 3"),
        (("--natural-frequency", "-1"), "the frequency must be positive"),
        (("--natural-frequency", "0"), "the frequency must be positive"),
        (("--sensor-rate", "0"), "hz must be from 1 to 100000"),
        (("--natural-frequency", "1e200"), "both at most 1e+06"),
        (("--damping-ratio", "1e300"), "both at most 1e+06"),
        (("--sensor-rate", "1e300"), "hz must be from 1 to 100000"),
        (("--noise", "1e300"), "noise from 0 to 1e+09"),
        (("--viscous", "1e300"), "at most 1e+09"),
        (("--base", "rocking:0:1:1e308"), "all at most 1e+09"),
        (("--base", "tilt:1e300"), "at most 1e+09"),
        (("--pivot", "1e300,0,0"), "pivot must be 3 finite numbers of at most 1e+09"),
        (("--sensor-place", "1e300,0,0"), "sensor must be 3 finite numbers of at most 1e+09"),
        (("--rate", "1e-300"), "rate must be from 1 to 20000 Hz"),
        (("--rate", "20000", "--duration", "1000"), "the cycles, at most 1e+07"),
        (("--log", "run.txt"), r".npz or .csv"),
        (("--log", "here/run.npz"), "'.*here' is not a folder"),
        (("--plot", "here/run.png"), "'.*here' is not a folder"),
        (("--plot", "run.pgf"), ".png, .svg or .pdf"),
        (("--plot", "run.xyz"), ".png, .svg or .pdf"),
    ],
)
def test_bad_input_is_answered_and_exits_2(
    options: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("here").write_text("in the way")
    assert main(["run", "--fast", "--duration", "0.01", *options]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert re.search(message, printed.err) or message in printed.err
    assert [file.name for file in Path().iterdir()] == ["here"]


@pytest.mark.parametrize(
    "options",
    [
        ("--pivot", "1,2"),
        ("--coulomb", "some"),
        ("--axis", "w"),
        ("--axis", "1,2"),
        ("--duration", "long"),
        ("--seed", "-1"),
        ("--seed", "1.5"),
    ],
)
def test_words_that_are_no_numbers_exit_2(options: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        main(["run", *options])
    assert exit_.value.code == 2
    assert options[1] in capsys.readouterr().err


def test_an_axis_that_is_none_is_told_what_an_axis_is(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", "--axis", "w"])
    assert "'w' is not x, y, z or three numbers such as 0,0,1" in capsys.readouterr().err


@pytest.mark.parametrize(("package", "option"), [("mujoco", "sim"), ("matplotlib", "plot")])
def test_a_missing_extra_exits_2_and_is_named(
    package: str, option: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    assert main(["run", "--fast", "--duration", "0.01", "--plot", "run.png"]) == 2
    assert f"pip install 'ravengc[{option}]'" in capsys.readouterr().err


def test_an_arm_that_runs_away_exits_1(capsys: pytest.CaptureFixture[str]) -> None:
    """Gains beyond what the rate can hold: 2 zeta w dt is far above 2."""
    unstable = ("--robot", "rrbot", "--rate", "20", "--natural-frequency", "1000", "--damping-ratio", "1")
    assert main(["run", "--fast", "--duration", "8", *unstable]) == 1
    assert "ran away" in capsys.readouterr().out


def test_a_run_says_what_it_waits_for_before_mujoco_is_there(folder: Path) -> None:
    """A simulator that takes for ever to load, until its standard input ends."""
    (folder / "mujoco.py").write_text("import sys; sys.stdin.read(); raise ImportError")
    command = [sys.executable, "-m", "ravengc", "run", "--json"]
    environment = {**os.environ, "PYTHONPATH": str(folder), "TERM": "xterm"}
    reader, writer = pty.openpty()
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": writer}
    process = subprocess.Popen(command, env=environment, **streams)  # noqa: S603 -- this very program
    os.close(writer)
    said = b""
    while b"loading MuJoCo, the simulator, and raven2_gold" not in said:
        said += os.read(reader, 1024)
    assert process.poll() is None
    out, _ = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, b"")
    os.close(reader)


def test_ctrl_c_ends_a_run_with_its_summary() -> None:
    command = [sys.executable, "-m", "ravengc", "run", "--duration", "600", "--json"]
    reader, writer = pty.openpty()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=writer)  # noqa: S603 -- this very program
    os.close(writer)
    while b"%" not in os.read(reader, 1024):
        pass
    process.send_signal(2)
    out, _ = process.communicate(timeout=60)
    os.close(reader)
    assert process.returncode == 0
    assert json.loads(out)["interrupted"]


def test_the_bar_writes_prepared_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[bytes] = []
    monkeypatch.setattr(os, "isatty", lambda _: True)
    bar = PrerenderedBar("arm")
    monkeypatch.setattr(os, "write", lambda _, frame: written.append(frame))
    for done in (0, 1, 10, 500, 1000):
        bar.show(done, 1000)
    bar.close()
    assert [re.findall(rb"\d+ %", frame) for frame in written] == [[b"0 %"], [b"1 %"], [b"50 %"], [b"100 %"], []]


def test_the_bar_fits_the_terminal_or_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "isatty", lambda _: True)
    written: list[bytes] = []
    monkeypatch.setattr(os, "write", lambda _, frame: written.append(frame))
    for columns, shown in (("80", True), ("24", True), ("12", False)):
        monkeypatch.setenv("COLUMNS", columns)
        written.clear()
        PrerenderedBar("arm").show(1, 1)
        assert bool(written) == shown
        assert all(len(re.sub(r"\x1b\[[0-9;]*m|\r", "", frame.decode())) < int(columns) for frame in written)


def test_the_bar_says_how_the_sensor_is_and_still_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "isatty", lambda _: True)
    written: list[bytes] = []
    monkeypatch.setattr(os, "write", lambda _, frame: written.append(frame))
    monkeypatch.setenv("COLUMNS", "80")
    for note in ("live 80 good of 99", "a note that is much longer than its place"):
        PrerenderedBar("arm", lambda note=note: note).show(1, 1)
        line = re.sub(r"\x1b\[[0-9;]*m|\r", "", written[-1].decode())
        assert note[:38] in line
        assert len(line) < 80


def test_the_note_counts_samples_and_good_ones_and_names_the_alarm() -> None:
    sensor = MonitoredSensor(rg.Accelerometer())
    noise = np.random.default_rng(2).normal(0.0, 0.03, (100, 3))
    for k in range(100):
        force = noise[k] + (0.0, 0.0, rg.STANDARD_GRAVITY)
        sensor.accelerometer.push(k, k * 10_000_000, force if k < 60 else (math.nan, 0.0, 0.0))
        sensor.step(k * 10_000_000)
        if k == 59:
            assert _sensor_note(sensor) == "live 41 good of 60"
    assert _sensor_note(sensor) == f"held ({sensor.accelerometer.alarms[0]}) 41 good of 100"


def test_a_terminal_that_is_gone_does_not_end_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[object] = []

    def gone(*frame: object) -> None:
        tried.append(frame)
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(os, "isatty", lambda _: True)
    monkeypatch.setattr(os, "write", gone)
    bar = PrerenderedBar("arm")
    bar.show(1, 2)
    bar.close()
    assert tried


@pytest.mark.parametrize(("robot", "axis"), [("raven2_gold", (0, -1, 0)), ("rrbot", (0, 1, 0)), ("panda", (1, 0, 0))])
def test_the_default_axis_is_horizontal(robot: str, axis: tuple[int, int, int]) -> None:
    assert rocking_axis(spec_for(robot)) == pytest.approx(axis)


def test_bases() -> None:
    tilted = parse_base("tilt:-20", axis="y", pivot=(0.0, 0.0, 0.0))
    assert tilted.state(1.0).position[3] == pytest.approx(np.deg2rad(-20.0))
    assert parse_base("level", axis="x", pivot=(0.0, 0.0, 0.0)).motion_at(1.0, (1.0, 2.0, 3.0))[0][2] == 9.80665
    with pytest.raises(ConfigError, match="level:1"):
        parse_base("level:1", axis="x", pivot=(0.0, 0.0, 0.0))


def test_without_a_command_the_help_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "replay    computed against measured torques" in printed.err


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    for options, expected in ((["--version"], r"ravengc \d+\.\d+"), (["run", "--help"], "examples:")):
        with pytest.raises(SystemExit) as exit_:
            main(options)
        assert exit_.value.code == 0
        assert re.search(expected, capsys.readouterr().out)
