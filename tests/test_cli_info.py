"""The commands info, torque and replay: what they print, and how they refuse."""

from __future__ import annotations

import io
import json
import math
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from rich.console import Console

import ravengc
from ravengc.cli import main
from ravengc.cli.common import print_json
from ravengc.cli.info_tables import show_robot
from ravengc.config import bundled_names
from ravengc.log import read_log
from ravengc.recordings import read_recording
from ravengc.reports.robot_facts import as_data, default_pose, facts_of
from strategies import robots

if TYPE_CHECKING:
    from pathlib import Path

READY = ["0", "-45 deg", "0", "-135deg", "0", "90 deg", "45 deg"]
READY_RAD = np.radians([0, -45, 0, -135, 0, 90, 45])
G = ravengc.STANDARD_GRAVITY


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]):
    """Run a command line; returns the exit code, standard output and standard error."""

    def call(*words: str) -> tuple[int, str, str]:
        code = main(list(words))
        return code, *capsys.readouterr()

    return call


@pytest.fixture
def good(run):
    """Run a command line that must succeed in silence on standard error; returns standard output."""

    def call(*words: str) -> str:
        code, out, err = run(*words)
        assert (code, err) == (0, "")
        return out

    return call


# --- info


def test_info_lists_the_bundled_robots(good) -> None:
    out = good("info")
    assert all(name in out for name in bundled_names())
    assert [robot["name"] for robot in json.loads(good("info", "--json"))["robots"]] == list(bundled_names())


@pytest.mark.parametrize("name", bundled_names())
def test_info_says_everything_about_every_bundled_robot(good, name: str) -> None:
    spec, out = ravengc.load(name).spec, good("info", name)
    assert all(link.name in out for link in spec.links)
    assert all(f"{link.mass:.6g}" in out for link in spec.links if link.mass)
    sections = ["joints", "masses", "sources"]
    sections += ["coupling"] if spec.coupling else []
    sections += ["transmission"] if spec.transmission else []
    assert all(f"\n{section} " in out or f"\n{section}," in out for section in sections)


def test_info_of_the_panda(good) -> None:
    out = good("info", "panda")
    for text in ("modified Denavit-Hartenberg", "16.0621 kg", "in panda_link7: (0 0 0.107) m", "-166 to 166 deg"):
        assert text in out


def test_info_as_toml_reads_back_to_the_same_robot(good) -> None:
    text = good("info", "raven2_gold", "--mass-set", "cad", "--toml")
    assert ravengc.from_toml(text).spec.links == ravengc.load("raven2_gold", mass_set="cad").spec.links


def test_info_as_json(good) -> None:
    data = json.loads(good("info", "dvrk_psm_si", "--json"))
    assert [coordinate["unit"] for coordinate in data["coordinates"]] == ["rad", "rad", "m"]
    assert data["moving_mass"] == pytest.approx(6.737)
    assert data["links"][2]["placement"]["a"] == 0.2913


@pytest.mark.parametrize("name", ["panda", "raven2_gold", "rrbot", "dvrk_ecm_si", "dvrk_psm"])
def test_info_draws_the_frames(good, tmp_path: Path, name: str) -> None:
    picture = tmp_path / "new" / "robot.png"
    assert f"plot: {picture}" in good("info", name, "--plot", str(picture))
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert [file.name for file in picture.parent.iterdir()] == ["robot.png"]


@given(spec=robots(most=5))
@settings(max_examples=40, deadline=None)
def test_any_robot_can_be_shown(spec) -> None:
    robot = ravengc.Robot(spec)
    out = io.StringIO()
    show_robot(Console(width=200, file=out), robot)
    assert all(link.name in out.getvalue() for link in spec.links)
    json.dumps(as_data(robot), allow_nan=False)


def test_facts_of_an_arm_that_can_be_worked_out() -> None:
    facts = facts_of(ravengc.load("rrbot"))
    assert facts.moving_mass == 2.0
    assert facts.reach == pytest.approx(math.hypot(1.8, 0.1), rel=1e-5)


@given(spec=robots(most=4))
@settings(max_examples=20, deadline=None)
def test_no_pose_is_farther_than_the_reach(spec) -> None:
    robot = ravengc.Robot(spec)
    reach = facts_of(robot).reach
    if reach is not None:
        poses = np.random.default_rng(0).uniform(-np.pi, np.pi, (200, robot.n))
        farthest = np.linalg.norm(robot.forward_kinematics_batch(poses)[:, :3, 3], axis=1).max()
        assert reach >= 0.98 * farthest


def test_default_pose_is_within_the_limits() -> None:
    for name in bundled_names():
        spec = ravengc.load(name).spec
        for value, limits in zip(default_pose(spec), spec.coordinate_limits, strict=True):
            assert limits.lower is None or limits.lower <= value
            assert limits.upper is None or value <= limits.upper


def test_joints_of_the_panda_fit_on_eighty_columns(good, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = good("info", "panda").splitlines()
    assert max(map(len, lines)) <= 80
    assert " panda_joint4  panda_link4  revolute  -176 to -3.999 deg  124.6 deg/s  87 N·m  " in lines


def test_coordinates_of_a_coupled_robot_have_their_limits(good) -> None:
    assert "pitch       -63.03 to 59.59 deg  34.08 N·m" in good("info", "dvrk_ecm_si")


def test_a_transmission_is_shown_without_what_rounding_left(good) -> None:
    assert "e-18" not in good("info", "raven2_gold_wrist")


@pytest.mark.parametrize("name", ["dvrk_psm", "dvrk_ecm"])
@pytest.mark.parametrize("form", [(), ("--json",), ("--toml",)])
def test_arms_without_masses_have_no_nan(good, name: str, form: tuple[str, ...]) -> None:
    words = ("--mass-set", "empty") if name == "dvrk_ecm" else ()
    assert "nan" not in good("info", name, *words, *form).lower().split()


# --- torque


def test_torque_prints_what_the_robot_computes(good) -> None:
    robot = ravengc.load("panda")
    data = json.loads(good("torque", "panda", "--q", *READY, "--json"))
    torques = [joint["torque"] for joint in data["joints"]]
    np.testing.assert_array_equal(torques, robot.gravity_torque(READY_RAD, (0.0, 0.0, -G)))
    table = good("torque", "panda", "--q", ",".join(READY))
    assert all(f"{torque:+.4f} N·m" in table for torque in torques)
    assert "-135.00 deg" in table


def test_torque_holds_cables_and_springs_too(good, tmp_path: Path) -> None:
    spring = ravengc.disturbances.LinearSpring(name="coil", joint="joint1", stiffness=2.0, rest=0.25)
    robot = ravengc.Robot(replace(ravengc.load("rrbot").spec, disturbances=(spring,)))
    robot.to_toml(tmp_path / "arm.toml")
    q = ("--q", "0.5", "0.1")
    first, second = json.loads(good("torque", str(tmp_path / "arm.toml"), *q, "--json"))["joints"]
    weight = robot.gravity_torque((0.5, 0.1), (0.0, 0.0, -G))
    assert (first["gravity"], first["disturbance"]) == pytest.approx((weight[0], 0.5))
    assert (first["torque"], second["torque"]) == pytest.approx((weight[0] + 0.5, weight[1]))
    table = good("torque", str(tmp_path / "arm.toml"), *q)
    assert all(text in table for text in ("gravity", "disturbance", f"{weight[0] + 0.5:+.4f} N·m", "+0.5000 N·m"))


def test_torque_says_what_was_probably_not_meant(good, tmp_path: Path) -> None:
    assert json.loads(good("torque", "rrbot", "--q", "0.1", "0.2", "--json"))["remarks"] == []
    assert "degrees are written '90 deg'" in good("torque", "rrbot", "--q", "90", "0")
    assert "the base hangs" in good("torque", "rrbot", "--q", "0", "0", "--gravity", "0", "0", "9.81")
    links = [replace(link, mass=0.0, inertia=(0.0,) * 6, massless=True) for link in ravengc.load("rrbot").spec.links]
    ravengc.Robot(replace(ravengc.load("rrbot").spec, links=tuple(links))).to_toml(tmp_path / "light.toml")
    assert "nothing of it weighs" in good("torque", str(tmp_path / "light.toml"), "--q", "0", "0")


def test_torque_of_a_sliding_joint_is_a_force(good) -> None:
    out = good("torque", "raven2_gold", "--q", "20 deg", "75 deg", "600 mm")
    assert "0.6000 m" in out
    assert " N " in out
    assert "upper" in out


@pytest.mark.parametrize(
    ("axis", "turned"), [("x", (0, -0.5, -math.sqrt(0.75))), ("y", (0.5, 0, -math.sqrt(0.75))), ("z", (0, 0, -1))]
)
@pytest.mark.parametrize("words", [("30 deg", "about"), ("30", "deg", "about"), ("0.5235987755982988", "about")])
def test_a_tilted_base_turns_gravity_the_other_way(good, axis: str, turned: tuple, words: tuple) -> None:
    data = json.loads(good("torque", "rrbot", "--q", "0.1", "-1e-3", "--tilt", *words, axis, "--json"))
    np.testing.assert_allclose(data["gravity"], np.array(turned) * G, atol=1e-12)


def test_payload_and_tool_are_weighed(good) -> None:
    robot = ravengc.load("panda")
    robot.set_tool(robot.spec.tool.rotation, (0.0, 0.0, 0.2))
    robot.set_payload(0.5, (0.01, 0.0, 0.03))
    words = ("--payload", "500 g", "--payload-com", "10 mm", "0", "0.03", "--tool", "0", "0", "20 cm", "--json")
    data = json.loads(good("torque", "panda", "--q", *READY, *words))
    torques = [joint["torque"] for joint in data["joints"]]
    np.testing.assert_allclose(torques, robot.gravity_torque(READY_RAD, (0.0, 0.0, -G)), atol=1e-12)


def test_numbers_of_any_size_have_a_place_in_a_table(good) -> None:
    assert "+0.0000 N·m" in good("torque", "rrbot", "--q", "0", "0")
    out = good("torque", "rrbot", "--q", "1e9", "0", "--payload", "1e9", "--gravity", "1e9", "0", "0")
    assert "5.72958e+10 deg" in out
    assert max(map(len, out.splitlines())) < 100


def test_numbers_that_json_has_not_are_null(capsys: pytest.CaptureFixture[str]) -> None:
    print_json({"a": [math.nan, (math.inf, 1.5)], "b": np.array([1.0, -math.inf]), "c": np.float64(2.0), "d": "nan"})
    assert json.loads(capsys.readouterr().out) == {"a": [None, [None, 1.5]], "b": [1.0, None], "c": 2.0, "d": "nan"}


# --- replay


def test_replay_prints_the_known_errors(good) -> None:
    lines = [line.split() for line in good("replay", "panda", "example:panda").splitlines() if line.strip()]
    rows = {words[0]: words for words in lines}
    assert [rows[f"panda_joint{joint}"][-1] for joint in (2, 3, 4)] == ["0.0614", "0.0531", "0.0860"]
    assert rows["all"][-1] == "0.0803"


def test_replay_as_json_with_all_its_files(good, tmp_path: Path) -> None:
    out, plot = tmp_path / "torques.csv", tmp_path / "torques.svg"
    data = json.loads(good("replay", "panda", "example:panda", "--json", "--out", str(out), "--plot", str(plot)))
    assert round(data["overall_relative_error"], 4) == 0.0803
    assert data["recording"]["samples"] == 727
    assert plot.read_text().startswith("<?xml")
    again, whole = read_recording(out), read_recording("example:panda")
    np.testing.assert_array_equal(again.tau, whole.tau)
    assert again.names == ravengc.load("panda").joint_names
    assert read_log(out).metadata["units"].keys() == read_log(out).columns.keys()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["torques.csv", "torques.svg"]


def test_replay_without_measured_torques_predicts(good, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t,q1,q2\n0,0.1,0.2\n0.1,0.2,0.3\n0.1,0.2,0.3\n0.2,,\n")
    out = good("replay", "rrbot", str(log), "--plot", str(tmp_path / "plot.png"))
    for text in (
        "no measured torques",
        "left out: 1 x repeated time stamp",
        "left out: 1 x missing or non-finite number",
    ):
        assert text in out


def test_replay_takes_gravity_from_the_recording(good, tmp_path: Path) -> None:
    robot, log = ravengc.load("rrbot"), tmp_path / "log.npz"
    q, gravity = np.random.default_rng(0).normal(size=(2, 5, 3))
    np.savez(log, t=np.arange(5.0), q=q[:, :2], gravity=gravity, tau=robot.gravity_torque_batch(q[:, :2], gravity))
    assert "--recorded-gravity uses it" in good("replay", "rrbot", str(log))
    data = json.loads(good("replay", "rrbot", str(log), "--recorded-gravity", "--json"))
    assert data["gravity"] == "recorded"
    assert data["overall_relative_error"] < 1e-12


def test_replay_at_the_motors(good, tmp_path: Path) -> None:
    robot, log = ravengc.load("raven2_gold"), tmp_path / "log.npz"
    q = np.array([[0.5, 1.5, 0.4], [0.6, 1.4, 0.3]])
    tau = robot.gravity_torque_batch(q, (0.0, 0.0, -G))
    at_motors = {"q": [*map(robot.motor_positions, q)], "tau": [*map(robot.actuator_torque, tau)]}
    np.savez(log, t=np.arange(2.0), **at_motors)
    data = json.loads(good("replay", "raven2_gold", str(log), "--shaft", "motor", "--json"))
    assert data["overall_relative_error"] < 1e-9


def test_a_recording_is_not_overwritten(run, tmp_path: Path) -> None:
    log, link = tmp_path / "log.csv", tmp_path / "link.csv"
    log.write_text("t,q1,q2\n0,0.1,0.2\n")
    link.symlink_to(log)
    code, _, err = run("replay", "rrbot", str(log), "--out", str(link))
    assert code == 2
    assert "would overwrite the recording" in err
    assert log.read_text() == "t,q1,q2\n0,0.1,0.2\n"


def test_replay_judges(run) -> None:
    assert run("replay", "panda", "example:panda", "--fail-above", "0.09")[0] == 0
    status, _, said = run("replay", "panda", "example:panda", "--fail-above", "0.08")
    assert status == 1
    assert said == "the overall relative error is above --fail-above 0.08\n"


# --- bad input


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("info pandda", "did you mean 'panda'"),
        ("info --toml", "--toml needs a robot"),
        ("info panda --q 0", "give --plot FILE"),
        ("info panda --q 0 --plot x.png", "--q has 1 values, but panda has 7 coordinates: 'panda_joint1'"),
        ("info rrbot --plot {tmp}/x.pgn", "expected a name ending in one of"),
        ("info raven2_gold --mass-set cda", "did you mean 'cad'"),
        ("info rrbot --plot {tmp}/x.pgf", "expected a name ending in one of .png, .svg or .pdf"),
        ("info rrbot --plot {tmp}/file/x.png", "is not a folder"),
        ("torque rrbot --q 0 1,2", "--q has 3 values"),
        ("torque rrbot --q 0 1e300", "1e300 is 1e+300 in SI; expected at most 1e+09"),
        ("torque rrbot --q 0 1_0", "cannot read the unit"),
        ("torque rrbot --q 0 1 --tilt 15 about x", "at most 90 degrees, in rad; degrees carry their unit"),
        ("torque rrbot --q 0 1 --tilt 5 about x", "--tilt 5: expected at most 90 degrees, in rad"),
        ("torque rrbot --q 0 1 --tilt 400deg about x", "at most a turn; degrees carry their unit"),
        ("torque rrbot --q 0 1 --payload 1e300", "expected at most 1e+09"),
        ("torque rrbot --q 0 1 --gravity 1e300 0 0", "expected at most 1e+09"),
        ("torque rrbot --q 0 5mm", "is a length, expected an angle"),
        ("torque rrbot --q 0 nan", "not finite"),
        ("torque rrbot --q 0 x", "is no quantity"),
        ("torque rrbot --q 0 1 --tilt 15 deg", "expected an angle and an axis"),
        ("torque rrbot --q 0 1 --gravity 0 0 5kg", "expected an acceleration"),
        ("torque rrbot --q 0 1 --payload-com 0 0 0", "needs --payload MASS"),
        ("torque rrbot --q 0 1 --payload -1", "mass"),
        ("replay panda example:pandas", "did you mean 'panda'"),
        ("replay rrbot example:panda", "7 joints (without names), but rrbot has 2"),
        ("replay panda example:panda --out x.txt", "suffix must be .npz or .csv"),
        ("replay panda example:panda --recorded-gravity", "has no gravity columns"),
        ("replay panda example:panda --shaft motor", "has no transmission"),
        ("replay panda example:panda --model full --window nan", "span of nan s"),
        ("replay panda nowhere.csv", "nowhere.csv: no such file"),
        ("replay panda example:panda --plot {tmp}/x.eps", "expected a name ending in one of .png, .svg or .pdf"),
        ("replay panda example:panda --out {tmp}/file/x.csv", "is not a folder"),
        ("replay panda example:panda --fail-above nan", "--fail-above nan: expected a relative error"),
        ("replay panda example:panda --fail-above -1", "expected a relative error, 0 or more"),
        ("replay panda example:panda --topic /joints", "example:panda: topic '/joints' chooses a part of a bag"),
        ("replay panda example:panda --rate 500", "has time stamps (array 't'), which a sample rate of 500 Hz"),
        ("replay panda example:panda --joints 1 2 3 4 5 6 6", "one is chosen twice"),
        ("replay panda example:panda --threads 99999999999999999999", "beyond 64 bits"),
    ],
)
def test_bad_input_is_exit_code_2_and_one_line(run, tmp_path: Path, words: str, message: str) -> None:
    (tmp_path / "file").write_text("in the way")
    code, out, err = run(*words.format(tmp=tmp_path).split(" "))
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_judging_nothing_is_bad_input(run, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t,q1,q2\n0,0.1,0.2\n")
    assert run("replay", "rrbot", str(log), "--fail-above", "1")[0] == 2


@pytest.mark.parametrize(
    "words", [("info", "rrbot", "--plot", "x.png"), ("replay", "panda", "example:panda", "--plot", "x.png")]
)
def test_pictures_name_the_missing_extra(run, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    code, _, err = run(*words)
    assert code == 2
    assert "pip install 'ravengc[plot]'" in err
