"""``ravengc dvrk`` from its options to what it prints and its exit codes."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc
from dvrk_files import gc_file, physical_psm_si, written
from ravengc.cli import main
from ravengc.cli.level_only import level_only_notes
from ravengc.dvrk import calibrate, convert, read_published, simulated_mtm

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(autouse=True)
def a_wide_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables on lines as long as they like."""
    monkeypatch.setenv("COLUMNS", "200")


def printed(capsys: pytest.CaptureFixture[str], code: int, *options: str) -> str:
    assert main(["dvrk", *options]) == code
    return capsys.readouterr().out


def test_table(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, 0, "table", "--poses", "20")
    for expected in (
        "Kinematics, standard",
        "Gravity, modified",
        "NO, NO (? Not sure), YES",
        "-7.080490",
        "-10.804879",
        "1.862195",
        "dvrk_mtml",
        "standard against modified table: YES",
        "every cell that was asked is YES; ",
    ):
        assert expected in out


def test_table_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    about = json.loads(printed(capsys, 0, "table", "--poses", "20", "--json"))
    assert about["complete"]
    silent = [library["name"] for library in about["libraries"] if library["why_not"]]
    left = f"not asked: {', '.join(silent)}" if silent else "every library was asked"
    assert about["verdict"] == f"every cell that was asked is YES; {left}"
    assert len(about["rows"]) == 4
    for row in about["rows"]:
        assert row["cells"]["NumPy reference"]["agrees"]
        assert set(row["page"]) == {"cisst", "KDL", "Matlab"}
    assert [arm["agrees"] for arm in about["mtm"]] == [True, True]


@pytest.mark.parametrize(
    ("options", "said"),
    [(("table", "--poses", "0"), "poses is 0"), (("table", "--pykdl", "/nonexistent"), "cannot be asked for PyKDL")],
)
def test_bad_input(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str) -> None:
    assert main(["dvrk", *options]) == 2
    assert said in capsys.readouterr().err


def test_convert_a_published_file(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    gc, out = written(tmp_path, "gc.json", gc_file(3)), tmp_path / "mtm.toml"
    said = printed(capsys, 0, "convert", str(gc), "-o", str(out))
    assert "LEVEL BASE ONLY" in said
    assert "-4.1 ... +4.0 N m" in said
    assert len(ravengc.load(out).spec.disturbances) == 12
    back = tmp_path / "back.json"
    assert "clips at the joints' largest efforts" in printed(
        capsys, 0, "convert", str(out), "--to", "gc", "-o", str(back)
    )
    np.testing.assert_allclose(
        read_published(back).positive, gc_file(3)["GC_controller"]["gc_dynamic_params_pos"], atol=1e-9
    )


def test_a_level_only_file_is_not_written_for_a_tilted_base(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    gc, out = written(tmp_path, "gc.json", gc_file(3)), tmp_path / "mtm.toml"
    tilted = ("convert", str(gc), "--mounting-pitch", "10 deg", "-o", str(out))
    assert "nothing written" in printed(capsys, 1, *tilted)
    assert not out.exists()
    about = json.loads(printed(capsys, 1, *tilted, "--json"))
    assert not about["written"]
    assert "N m more" in about["flag"]
    printed(capsys, 0, *tilted, "--anyway")
    assert out.exists()


def test_commands_note_a_level_only_robot_where_gravity_is_tilted(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    gc = written(tmp_path, "gc.json", gc_file(3))
    printed(capsys, 0, "convert", str(gc), "-o", "mtm.toml")
    noted = "for a level base only (level_only), and gravity is tilted by 10.0 deg"
    written(tmp_path, "log.csv", "t,q1,q2,q3,q4,q5,q6,q7\n0,0,0,0,0,0,0,0\n0.1,0,0,0,0,0,0,0\n")
    pose, tilt = ["--q", *("0" for _ in range(7))], ["--tilt", "10 deg about x"]
    asked = {
        ("torque", "mtm.toml", *pose): tilt,
        ("replay", "mtm.toml", "log.csv"): tilt,
        ("dvrk", "hold", "mtm.toml", *pose, "--seconds", "0.01"): ["--tilt", "10deg"],
        ("run", "--robot", "mtm.toml", "--fast", "--duration", "0.02", "--base"): ["tilt:10"],
    }
    for command, tilted in asked.items():
        if command[0] in {"dvrk", "run"}:
            pytest.importorskip("mujoco")
        for options, there in ((tilted, True), (["level"] if "--base" in command else [], False)):
            main([*command, *options])
            found = capsys.readouterr()
            assert (noted in " ".join((found.out + found.err).split())) == there, command
            main([*command, *options, "--json"])
            assert (noted in capsys.readouterr().out) == there, command


def test_level_is_where_gravity_is_along_frame_0(tmp_path: Path) -> None:
    """A base that is mounted at a pitch is tilted where the room is level, and level where the room is tilted."""
    gc = written(tmp_path, "gc.json", gc_file(3))
    spec = convert([gc], mounting_pitch=np.radians(10.0)).spec
    (note,) = level_only_notes(spec, (0.0, 0.0, -9.81))
    assert "tilted by 10.0 deg" in note
    along = np.array(spec.base.rotation) @ (0.0, 0.0, -9.81)
    assert not level_only_notes(spec, along)
    assert "10.0 deg" in level_only_notes(spec, np.array([along, (0.0, 0.0, -9.81)]))[0]
    assert not level_only_notes(replace(spec, level_only=False), (0.0, 0.0, -9.81))


@pytest.mark.parametrize(("degrees", "noted"), [(0.4, False), (0.6, True), (180.0, True)])
def test_half_a_degree_is_level(tmp_path: Path, degrees: float, noted: bool) -> None:
    spec = convert([written(tmp_path, "gc.json", gc_file(3))]).spec
    assert bool(level_only_notes(spec, tuple(ravengc.Gravity.tilted(np.radians(degrees), "y")))) == noted


def test_convert_an_arm(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arm = written(tmp_path, "PSM1.json", {"kinematic_gc": "PSM_Si_physical.json", "mounting_pitch": -0.785398})
    chain, out = written(tmp_path, "PSM_Si_physical.json", physical_psm_si()), tmp_path / "psm1.toml"
    about = json.loads(printed(capsys, 0, "convert", str(arm), str(chain), "-o", str(out), "--name", "psm1", "--json"))
    assert about["robot"] == ravengc.load(out).name == "psm1"
    assert about["coordinates"] == ["yaw", "pitch", "insertion"]
    said = printed(capsys, 0, "convert", "dvrk_psm", "-o", str(tmp_path / "k.json"))
    assert "left out, the format has no place for it: its tool frame" in said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("dvrk_mtmr", "-o", "a.txt"), "ending in .toml"),
        (("dvrk_mtmr", "panda", "-o", "a.json"), "backwards takes one robot"),
        (("dvrk_mtmr", "--name", "x", "-o", "a.json"), "--name is for an output that ends in .toml"),
        (("dvrk_mtmr", "--mounting-pitch", "1 deg", "-o", "a.json"), "--mounting-pitch is for an output"),
        (("dvrk_mtmr", "--anyway", "-o", "a.json"), "--anyway is for an output"),
        (("a.json", "--to", "gc", "-o", "a.toml"), "--to is for an output"),
        (("absent.json", "-o", "a.toml"), "cannot be read"),
        (("a.json", "--mounting-pitch", "3 m", "-o", "a.toml"), "--mounting-pitch"),
        (("panda", "--to", "gc", "-o", "a.json"), "axes of dvrk_mtml"),
    ],
)
def test_convert_bad_input(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str) -> None:
    assert main(["dvrk", "convert", *options]) == 2
    assert re.search(said, capsys.readouterr().err)


def test_hold(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    plot = tmp_path / "held.png"
    short = ("hold", "rrbot", "--poses", "2", "--seconds", "0.1", "--tilt", "20 deg")
    said = printed(capsys, 0, *short, "--plot", str(plot))
    assert "2 of 2 poses held within 0.01 mm" in said
    assert plot.exists()
    about = json.loads(printed(capsys, 0, *short, "--json"))
    assert about["held"]
    assert len(about["poses"]) == 2
    one = json.loads(printed(capsys, 0, "hold", "rrbot", "--q", "0.3", "0.5", "--seconds", "0.01", "--json"))
    assert one["poses"][0]["q"] == [0.3, 0.5]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("rrbot", "--q", "0.3"), "--q has 1 values"),
        (("nobody",), "there is no robot 'nobody'"),
        (("rrbot", "--tilt", "20 mm"), "--tilt"),
        (("rrbot", "--tilt", "10"), "degrees carry their unit"),
        (("rrbot", "--tilt", "5"), "degrees carry their unit"),
        (("rrbot", "--tilt", "400 deg"), "at most a turn"),
        (("rrbot", "--plot", "a.txt"), "unknown kind of picture"),
        (("rrbot", "--seconds", "-1"), "seconds is -1.0"),
        (("dvrk_psm",), "no masses"),
    ],
)
def test_hold_bad_input(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], said: str) -> None:
    pytest.importorskip("mujoco")
    assert main(["dvrk", "hold", *options]) == 2
    assert said in capsys.readouterr().err


def test_passive(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    made = calibrate(simulated_mtm(), tilted=True)
    monkeypatch.setattr("ravengc.dvrk.letting_go.calibrate", lambda *_, **__: made)
    plot = tmp_path / "passive.png"
    said = printed(capsys, 0, "passive", "--seconds", "0.1", "--plot", str(plot))
    assert "9 of 9 within 1 mm" in said
    assert "it stays however the base stands" in said
    assert plot.exists()
    about = json.loads(printed(capsys, 0, "passive", "--seconds", "0.1", "--json"))
    assert about["stays"]
    assert about["identified"]["tilts"] == 5
    assert max(about["identified"]["shares_of_friction_at_any_tilt"]) < 1.0
    assert main(["dvrk", "passive", "--calibration-tilt", "3 m"]) == 2
    assert main(["dvrk", "passive", "--seconds", "0"]) == 2
