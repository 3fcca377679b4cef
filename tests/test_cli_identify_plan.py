"""``ravengc identify plan``: what it prints, writes, draws and refuses."""

from __future__ import annotations

import json
import tomllib
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from command_line import refusal
from ravengc.cli import main

if TYPE_CHECKING:
    from pathlib import Path

QUICK = ("--poses", "12", "--candidates", "60")


def printed(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert main(["identify", "plan", *words]) == code
    captured = capsys.readouterr()
    return captured.out if code == 0 else captured.err


def test_the_table_has_both_calibrations_and_what_stays_open(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, "dvrk_mtmr", *QUICK)
    assert "dvrk_mtmr: 12 poses on" in out
    assert "with tilts" in out
    assert "level only" in out
    first = next(line for line in out.splitlines() if "outer_yaw" in line)
    assert "open" in first
    assert "not shown: outer_yaw.m" in out
    assert "-o FILE.csv" in out


def test_json_has_the_poses_and_null_for_what_stays_open(capsys: pytest.CaptureFixture[str]) -> None:
    about = json.loads(printed(capsys, "dvrk_mtmr", *QUICK, "--json"))
    assert len(about["pose"]) == 12
    assert about["level_only"]["worst"][0] is None
    assert about["curves"]["level only"]["worst"][0] is None
    assert about["predicted"]["worst"][0] < 0.02
    assert about["units"] == ["N·m"] * 7


def test_a_level_base_alone_has_one_curve(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, "dvrk_mtmr", *QUICK, "--tilt", "0")
    assert "on the level base" in out
    assert "with tilts" not in out
    assert "tilt the base, once by 10 degrees or more" in out


def test_what_is_written_can_be_judged_again(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    poses = tmp_path / "poses.csv"
    about = json.loads(printed(capsys, "raven2_gold", *QUICK, "-o", str(poses), "--json"))
    judged = json.loads(printed(capsys, "raven2_gold", "--predict", str(poses), "--json"))
    assert judged["judged"] == 12
    assert judged["out"] is None
    for label in ("with tilts", "level only"):
        ratio = np.array(judged["curves"][label]["worst"]) / about["curves"][label]["worst"]
        assert np.all((ratio > 0.4) & (ratio < 2.0))  # over its own poses, not over the whole range


def test_a_protocol_with_times_on_a_level_base(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "ours.csv"
    file.write_text("t,q1,q2,q3\n" + "".join(f"{k},{0.1 * k},{0.8 + 0.1 * k},{0.3}\n" for k in range(12)))
    about = json.loads(printed(capsys, "raven2_gold", "--predict", str(file), "--json"))
    assert list(about["curves"]) == ["level only"]


def test_a_protocol_that_trusts_one_joint_in_each_file_is_worth_less(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    random, files = np.random.default_rng(0), []
    for name in ("shoulder", "elbow", "insertion"):
        poses = random.uniform([-1.0, 0.8, 0.25], [1.0, 1.8, 0.45], (20, 3))
        files.append(tmp_path / f"{name}.csv")
        np.savetxt(files[-1], poses, delimiter=",", header="q1,q2,q3", comments="")
    judge = [word for file in files for word in ("--predict", str(file))]
    every = json.loads(printed(capsys, "raven2_gold", *judge, "--json"))
    assert every["judged"] == 60
    alone = [*judge, "--at", "shoulder", "--at", "elbow", "--at", "insertion"]
    trained = json.loads(printed(capsys, "raven2_gold", *alone, "--json"))
    worst = [np.array(one["curves"]["level only"]["worst"], dtype=float) for one in (trained, every)]
    assert np.all(worst[0] > 1.3 * worst[1])
    silent = json.loads(printed(capsys, "raven2_gold", *judge, "--at", "insertion", "--json"))
    assert silent["curves"]["level only"]["worst"][0] is None


def test_a_motion_is_planned_and_written(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    plan = tmp_path / "motion.toml"
    out = printed(
        capsys, "raven2_gold", "--motion", "--model", "dynamics", "--rounds", "5", "--tilt", "0", "-o", str(plan)
    )
    assert "a motion of 20 s on the level base" in out
    assert "of random motions" in out
    assert tomllib.loads(plan.read_text(encoding="utf-8"))["motion"]["period"] == 20.0


def test_the_picture(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    picture = tmp_path / "plan.svg"
    out = printed(capsys, "raven2_gold", *QUICK, "--plot", str(picture))
    assert f"plot: {picture}" in out
    text = picture.read_text(encoding="utf-8")
    assert "<svg" in text


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--tilt", "10"), "degrees carry their unit"),
        (("--range", "elbow"), "expected JOINT=LEAST:MOST"),
        (("--range", "elbo=0:1"), "did you mean 'elbow'"),
        (("--range", "insertion=0.3deg:0.4deg"), "--range insertion"),
        (("--noise", "much"), "--noise 'much': expected a number"),
        (("--noise", "0.1,0.1"), "expected one positive number, or 3"),
        (("--poses", "0"), "poses is 0"),
        (("--at", "elbow"), "a plan is for the torques of all joints"),
        (("--predict", "nowhere.csv"), "nowhere.csv: no such file"),
        (("--cable", "elbo"), "did you mean 'elbow'"),
        (("-o", "plan.txt"), "expected a name ending in .csv or .toml"),
        (("--plot", "plan.txt"), "unknown kind of picture"),
        (("--motion", "--period", "-3"), "period is -3.0; expected a positive number"),
    ],
)
def test_bad_input_is_refused(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], message: str) -> None:
    assert message in refusal(capsys, "identify", "plan", "raven2_gold", *options)


def test_nothing_can_be_written_of_what_is_judged(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    said = refusal(capsys, "identify", "plan", "raven2_gold", "--predict", "a.csv", "-o", str(tmp_path / "b.csv"))
    assert "--predict judges" in said
    assert not list(tmp_path.iterdir())


def test_the_files_own_cable_counts_if_it_is_sought(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    cable = (
        '[[disturbance]]\nkind = "polynomial"\nname = "cable"\njoint = "shoulder_pitch"\ncoefficients = [0.0, 0.0]\n'
    )
    rg.load("dvrk_mtmr").to_toml(file)
    file.write_text(f"{file.read_text(encoding='utf-8')}\n{cable}", encoding="utf-8")
    near = ("--range", "shoulder_pitch=-11deg:16deg", "--json", *QUICK)
    known, sought = (json.loads(printed(capsys, str(file), *near, *more)) for more in ((), ("--disturbances",)))
    assert sought["level_only"]["worst"][1] > 20.0 * known["level_only"]["worst"][1]
    assert "cable.p1" in sought["identified"]
