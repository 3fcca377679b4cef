"""``ravengc identify`` from its options to what it prints, what it writes, and its exit codes."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from command_line import refusal
from identify_logs import moved, stood, write_csv
from ravengc.cli import main

if TYPE_CHECKING:
    from pathlib import Path

TILTS = ("dvrk_mtmr", "example:mtmr_tilts")


@pytest.fixture(autouse=True)
def a_wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables on lines as long as they like."""
    monkeypatch.setenv("COLUMNS", "200")


def printed(capsys: pytest.CaptureFixture[str], code: int, *words: str) -> str:
    assert main(["identify", *words]) == code
    return capsys.readouterr().out


def about(capsys: pytest.CaptureFixture[str], code: int, *words: str) -> dict[str, object]:
    described: dict[str, object] = json.loads(printed(capsys, code, *words, "--json"))
    return described


# fit


def test_a_fit_says_what_the_torques_show_and_what_not(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, 0, "fit", *TILTS)
    for expected in (
        "dvrk_mtmr: gravity from example:mtmr_tilts",
        "200 samples read; 70 fitted, 30 held out",
        "100 poses approached from both sides",
        "held out, %",
        "± at a tilt",
        "14 sums of 28 parameters show in the torques; condition",
        "no joint torque depends on them",
    ):
        assert expected in out


def test_a_level_base_leaves_joint_one_unknown_and_says_what_would_show_it(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, 0, "fit", "dvrk_mtmr", "example:mtmr_level")
    assert "unknown" in out.partition("shoulder_pitch")[0]
    assert "tilt the base, once by 10 degrees or more" in out
    joints = about(capsys, 0, "fit", "dvrk_mtmr", "example:mtmr_level", "--held-out", TILTS[1])["joints"]
    assert joints[0]["sd_at_tilt"] is None
    assert joints[0]["held_out_rms"] > 2.0 * joints[0]["train_rms"]


def test_the_robot_is_written_with_where_it_comes_from(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "arm.toml"
    described = about(capsys, 0, "fit", *TILTS, "-o", str(file))
    assert described["out"] == str(file)
    robot = rg.load(file)
    assert "identified from example:mtmr_tilts (gravity, estimator wls, 14 base parameters, " in robot.spec.source
    assert os.listdir(tmp_path) == ["arm.toml"]  # noqa: PTH208
    log = rg.identify.prepared(rg.identify.read_log(robot, TILTS[1]), rg.identify.Model())
    left = log.tau - robot.gravity_torque_batch(log.q, -log.base[:, :3])
    before = log.tau - rg.load("dvrk_mtmr").gravity_torque_batch(log.q, -log.base[:, :3])
    assert np.sqrt((left**2).mean()) < 0.005
    assert np.sqrt((before**2).mean()) > 0.03


def test_a_cable_and_friction_are_written_for_control_laws_to_add(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = rg.load("raven2_gold")
    table = stood(robot, 15.0, 2)
    rubbing = np.tile([1.0, -1.0], 30)[:, np.newaxis] * np.array([0.5, 0.3, 2.0])
    cable = np.zeros((60, 3))
    cable[:, 1] = 0.4 - 0.3 * table["q"][:, 1]
    tau = table["tau"] + cable + rubbing
    log = write_csv(tmp_path / "log.csv", table | {"tau": tau, "dq": 0.1 * np.sign(rubbing)})
    file = tmp_path / "arm.toml"
    words = ("fit", "raven2_gold", log, "--cable", "elbow:0,1", "--friction", "coulomb", "-o", str(file))
    about(capsys, 0, *words, "--friction-share", "0.5")
    written = rg.load(file)
    held = [
        written.gravity_torque(q, rg.SpecificForce(*a)) + written.disturbance_torque(q)
        for q, a in zip(table["q"], table["a"], strict=True)
    ]
    assert np.abs(np.array(held) - (tau - rubbing)).max() < 0.05
    moving = written.disturbance_torque(table["q"][0], np.full(3, 0.1)) - written.disturbance_torque(table["q"][0])
    np.testing.assert_allclose(moving, 0.5 * np.array([0.5, 0.3, 2.0]), rtol=0.05)
    assert "no friction for control laws to add" in printed(capsys, 0, *words)
    assert {one.kind for one in rg.load(file).spec.disturbances} == {"polynomial"}
    assert "friction_share is 1.5" in refusal(capsys, "identify", *words, "--friction-share", "1.5")


def test_json_has_all_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    described = about(capsys, 0, "fit", "panda", "example:panda", "--model", "gravity+friction", "--estimator", "ols")
    assert described["rank"] == 33
    assert described["overall"]["held_out"] < 0.066
    assert described["skipped_rows"] == {"row that repeats the readings of the one before": 14}
    assert described["coefficients"]["panda_joint7.coulomb"] == pytest.approx(0.25, abs=0.05)
    assert {"name", "value", "formal_sd", "cross_sd", "in_file"} == set(described["parameters"][0])


def test_a_report_needs_no_other_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    described = about(capsys, 0, "fit", *TILTS, "--report", str(tmp_path / "out"))
    names = ["report.html", "results.json", "torques.png", "torques.svg", "uncertainty.png", "uncertainty.svg"]
    assert sorted(os.listdir(tmp_path / "out")) == names  # noqa: PTH208
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == 2
    assert "http" not in page
    for expected in ("outer_yaw", "± at a tilt", "What the logs do not show", "ravengc identify fit dvrk_mtmr"):
        assert expected in page
    numbers = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    assert numbers == described


def test_logs_of_a_base_without_a_sensor_have_their_tilt_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = rg.load("dvrk_mtmr")
    logs = []
    for name, force in (("level", [0.0, 0.0, 9.80665]), ("rolled", [0.0, 1.702909, 9.657662])):
        table = stood(robot, 0.0, 1, seed=len(name))
        tau = robot.gravity_torque_batch(table["q"], -np.array(force))
        logs.append(write_csv(tmp_path / f"{name}.csv", {"t": table["t"], "q": table["q"], "tau": tau}))
    described = about(capsys, 0, "fit", "dvrk_mtmr", *logs, "--tilt", "level", "--tilt", "10 deg about x")
    assert described["rank"] == 14
    assert described["overall"]["held_out"] < 1e-4
    said = refusal(capsys, "identify", "fit", "dvrk_mtmr", *logs, *("--tilt", "level") * 3)
    assert "3 x --tilt for 2 logs" in said


def test_what_predicts_worse_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = rg.load("raven2_gold")
    table = stood(robot, 17.0, 2, poses=30)
    table["tau"] += 0.2 * np.random.default_rng(0).normal(size=table["tau"].shape)
    log = write_csv(tmp_path / "log.csv", table)
    cables = [word for name in robot.spec.coordinate_names for word in ("--cable", f"{name}:1,2,3,4,5,6")]
    out = printed(capsys, 1, "fit", "raven2_gold", log, *cables, "-o", str(tmp_path / "arm.toml"))
    assert "refused: it predicts worse than without" in out
    assert "\nout: " not in out
    assert os.listdir(tmp_path) == ["log.csv"]  # noqa: PTH208


def test_a_log_that_excites_too_little_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = moved(rg.load("ur5"))
    still = {"t": table["t"], "q": table["q"].copy(), "tau": table["tau"]}
    still["q"][:, 2] = 0.5
    log = write_csv(tmp_path / "log.csv", still)
    words = ("identify", "fit", "ur5", log, "--model", "dynamics", "-o", str(tmp_path / "arm.toml"))
    assert main([*words]) == 1
    caught = capsys.readouterr()
    assert caught.err.startswith("ravengc: refused: the recording says nothing about ")
    assert "every joint moves far" in caught.err
    assert main([*words, "--json"]) == 1
    assert "says nothing about" in json.loads(capsys.readouterr().out)["refused"]
    assert os.listdir(tmp_path) == ["log.csv"]  # noqa: PTH208


def test_parameters_that_no_body_has_make_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = write_csv(tmp_path / "log.csv", moved(rg.load("ur5"), 6.0, 40.0))
    words = ("fit", "ur5", log, "--model", "dynamics")
    out = printed(capsys, 0, *words)
    assert "no robot file: link" in out
    assert "estimator='consistent'" in out
    printed(capsys, 1, *words, "-o", str(tmp_path / "arm.toml"))
    assert os.listdir(tmp_path) == ["log.csv"]  # noqa: PTH208


def test_consistent_parameters_are_those_of_bodies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("clarabel")
    log = write_csv(tmp_path / "log.csv", moved(rg.load("ur5"), 6.0, 40.0))
    file = tmp_path / "arm.toml"
    words = ("fit", "ur5", log, "--model", "dynamics", "--estimator", "consistent", "--total-mass", "20")
    assert about(capsys, 0, *words, "-o", str(file))["no_robot_file"] is None
    assert sum(link.mass for link in rg.load(file).spec.links) < 20.0 + 1e-6


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("fit", "dvrk_mtmr", "nowhere.csv"), "no such file"),
        (("fit", *TILTS, "--cutoff", "fast"), "expected a number of Hz, auto or none"),
        (("fit", *TILTS, "--held-out", "0.99"), "share is 0.99"),
        (("fit", *TILTS, "--held-out", TILTS[1]), "is one of the logs"),
        (("fit", *TILTS, "--held-out", "example:mtmr_level", *("--tilt", "level") * 3), "3 x --tilt for 1 logs and"),
        (("fit", *TILTS, "-o", "arm.urdf"), "expected a name ending in .toml"),
        (("fit", *TILTS, "--cable", "elbow"), "did you mean 'elbow_pitch'"),
        (("fit", *TILTS, "--cable", "elbow_pitch:one"), "expected degrees with commas between"),
        (("fit", *TILTS, "--hysteresis", "elbow_pitch"), "expected JOINT:DISTANCE"),
        (("fit", *TILTS, "--friction", "coulom"), "did you mean 'coulomb'"),
        (("fit", *TILTS, "--total-mass", "3 kg"), "say --estimator consistent"),
        (("fit", *TILTS, "--units", "degs"), "did you mean 'deg'"),
        (("fit", *TILTS, "--tilt", "10 deg"), "expected an angle and an axis"),
        (("fit", *TILTS, "--tilt", "10 deg about x"), "has gravity columns of its own"),
        (("mounting", *TILTS, "--find", "scale"), "torques do not show the scale of the sensor"),
        (("mounting", *TILTS, "--find", "bias"), "found together"),
        (("payload", "ur5", "example:ur5_unloaded", "example:ur5_loaded", "--link", "wrist"), "no moving link 'wrist'"),
        (("payload", "ur5", "example:ur5_unloaded", "example:ur5_loaded", "--lever", "-1"), "expected more than 0 m"),
    ],
)
def test_bad_input_is_named(capsys: pytest.CaptureFixture[str], words: tuple[str, ...], said: str) -> None:
    assert said in refusal(capsys, "identify", *words)


def test_a_log_is_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "log.toml"
    log.write_text("t,q1\n", encoding="utf-8")
    assert "would overwrite a log" in refusal(capsys, "identify", "fit", "ur5", str(log), "-o", str(log))


def test_parameters_hardly_told_apart_are_part_of_the_verdict(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A cable along the shoulder of a level arm: what it is and what the masses are is told apart by tilts."""
    cables = [word for joint in ("shoulder_pitch", "elbow_pitch") for word in ("--cable", f"{joint}:0,1")]
    file = tmp_path / "arm.toml"
    words = ("fit", "dvrk_mtmr", "example:mtmr_level", *cables, "-o", str(file), "--report", str(tmp_path / "out"))
    pytest.importorskip("matplotlib")
    out = printed(capsys, 0, *words)
    weak = next(line for line in out.splitlines() if line.startswith("weak: the condition is "))
    for expected in ("more than 50", "shoulder_pitch.cable.p1", "tilt the base by 10 degrees or more to four sides"):
        assert expected in weak
    assert weak.removeprefix("weak: ") in rg.load(file).spec.source
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "held out; weak</p>" in page
    assert "hardly told apart are shoulder_pitch" in page
    assert about(capsys, 0, "fit", *TILTS, *cables)["warnings"] == []


def test_each_logs_own_joints_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = rg.load("raven2_gold")
    logs = []
    for joint, name in enumerate(robot.spec.coordinate_names):
        table = stood(robot, 15.0, 2, seed=joint)
        table["tau"][:, [place for place in range(3) if place != joint]] += 20.0  # not to be trusted there
        logs.append(write_csv(tmp_path / f"{name}.csv", table))
    at = [word for name in robot.spec.coordinate_names for word in ("--at", name)]
    described = about(capsys, 0, "fit", "raven2_gold", *logs, *at)
    assert described["overall"]["held_out"] < 0.02
    assert "--at shoulder --at elbow" in described["command"]
    alone = about(capsys, 0, "fit", "raven2_gold", *logs[1:], "--at", "elbow", "--at", "insertion")
    assert alone["joints"][0]["held_out_relative"] is None
    assert printed(capsys, 0, "fit", "raven2_gold", logs[1], "--at", "elbow").count(" - ") >= 2
    held = about(capsys, 0, "fit", "raven2_gold", *logs[:2], *at, "--held-out", logs[2])
    assert [joint["held_out_relative"] is None for joint in held["joints"]] == [True, True, False]
    assert "2 x --at for 3 logs" in refusal(capsys, "identify", "fit", "raven2_gold", *logs, *at[:4])
    assert "did you mean 'elbow'" in refusal(capsys, "identify", "fit", "raven2_gold", *logs, "--at", "elbo")


# payload


def test_the_load_of_the_example_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("payload", "ur5", "example:ur5_unloaded", "example:ur5_loaded")
    described = about(capsys, 0, *words)
    assert described["mass"] == pytest.approx(1.5, rel=0.02)
    np.testing.assert_allclose(described["com"], [0.02, -0.01, 0.06], atol=0.003)
    out = printed(capsys, 0, *words)
    assert "for other commands: --payload 1.49" in out
    known = about(capsys, 0, *words, "--com", "20 mm", "-10mm", "0.06")
    assert known["mass"] == pytest.approx(1.5, rel=0.02)


def test_two_different_motions_are_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    robot = rg.load("ur5")
    logs = [write_csv(tmp_path / f"{seed}.csv", moved(robot, seed=seed)) for seed in (1, 2)]
    assert main(["identify", "payload", "ur5", *logs]) == 1
    assert "record the same motion" in capsys.readouterr().err


# mounting


def test_a_turned_sensor_is_found_from_the_torques(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = rg.load("raven2_gold")
    table = stood(robot, 20.0, 2)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    table["a"] = table["a"] @ turn + np.array([0.1, -0.2, 0.05])  # f = R (s - b)
    log, file = write_csv(tmp_path / "log.csv", table), tmp_path / "arm.toml"
    robot.to_toml(file)
    described = about(capsys, 0, "mounting", "raven2_gold", log, "--write", str(file))
    np.testing.assert_allclose(described["rotation"], turn, atol=0.02)
    np.testing.assert_allclose(described["bias"], [0.1, -0.2, 0.05], atol=0.05)
    assert described["written"] == str(file)
    np.testing.assert_allclose(rg.load(file).spec.accelerometer["bias"], described["bias"], atol=1e-6)


def test_tilts_about_one_axis_are_refused_with_what_to_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_csv(tmp_path / "log.csv", stood(rg.load("raven2_gold"), 20.0, 1))
    out = printed(capsys, 1, "mounting", "raven2_gold", log, "--write", str(tmp_path / "arm.toml"))
    assert "refused: the base tilts about one axis only: tilt it about a second one" in out
    assert "condition" in out
    assert os.listdir(tmp_path) == ["log.csv"]  # noqa: PTH208


def test_a_level_base_shows_no_mounting(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["identify", "mounting", "dvrk_mtmr", "example:mtmr_level"]) == 1
    assert "the base hardly tilts" in capsys.readouterr().err
