"""``ravengc track`` from its options to what it prints and writes, and its exit codes."""

from __future__ import annotations

import json
import re
import shlex
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from command_line import refusal
from ravengc import track as tracking
from ravengc.cli import main, track_place
from ravengc.errors import ConfigError
from ravengc.targets import Cloud
from ravengc.track.run import start_of
from track_scenes import small_run

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.track import Camera, Motion, Surface, TrackResult, TrackSettings

FEW = ("--points", "3", "--quick")
SHORT = "[track]\nlead_in_s = 4.0\nsettle_s = 2.0\nhold_points = 0\n"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What would have been run: runs are replaced by one whose numbers are known."""
    calls: list[dict[str, Any]] = []

    def run(
        robot: object, surface: Surface, motion: Motion, camera: Camera, settings: TrackSettings, tell: Any = None
    ) -> TrackResult:
        calls.append({"robot": robot, "surface": surface, "motion": motion, "camera": camera, "settings": settings})
        tell(len(surface), len(surface))
        error_m = {"resolved": 3e-4, "naive": 1.2e-3, "oracle": 1e-5}[settings.method]
        return small_run(10, method=settings.method, error_m=error_m)

    monkeypatch.setattr(tracking, "track", run)
    return calls


def about(capsys: pytest.CaptureFixture[str], code: int, *options: str) -> dict[str, Any]:
    assert main(["track", "--json", "--least-coverage", "60", *options]) == code
    return json.loads(capsys.readouterr().out)


# Real runs


def test_a_few_points_are_covered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "short.toml").write_text(SHORT, encoding="utf-8")
    assert main(["track", *FEW, "--settings", str(tmp_path / "short.toml"), "--motion", "still"]) == 0
    out = capsys.readouterr().out
    assert "LIVER-500: panda, scan, still" in out
    assert re.search(r"coverage, %\s+100\.0", out)
    assert re.search(r"visited again\s+0\s", out)
    assert re.search(r"cycles beyond a limit\s+0", out)


def test_a_cloud_and_a_recording_are_followed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "short.toml").write_text(SHORT + "[camera]\nlatency_s = 0.0\nnoise_m = 1e-4\n", encoding="utf-8")
    files = ("--surface", "example:organ", "--motion", "example:breathing", "--settings", str(tmp_path / "short.toml"))
    found = about(capsys, 0, *files, "--points", "3")
    assert found["runs"]["resolved"]["seeds"][0]["points"] <= 3
    assert found["holds"]
    assert "the recording" not in " ".join(found["notes"])
    assert any("face up" in note for note in found["notes"])


# What is run


def test_the_default_is_the_benchmark(asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]) -> None:
    assert about(capsys, 0)["command"] == "ravengc track"
    _, surface, _, camera, settings = tracking.liver_500()
    np.testing.assert_array_equal(asked[0]["surface"].points, surface.points)
    assert asked[0]["settings"] == settings
    assert asked[0]["camera"] == camera
    assert len(asked) == 1


def test_methods_and_seeds_are_run_one_after_the_other(
    asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    found = about(capsys, 0, "--baseline", "--oracle", "--seed", "3", "--seeds", "2")
    assert list(found["runs"]) == ["resolved", "naive", "oracle"]
    assert [call["settings"].method for call in asked] == ["resolved", "naive", "oracle"] * 2
    assert asked[1]["settings"].approach == "step"
    assert [call["camera"].seed for call in asked[::3]] == [10_003, 10_004]
    assert found["camera"]["seed"] == 10_003
    assert asked[0]["motion"] is asked[2]["motion"]
    assert found["seeds"] == [3, 4]
    assert found["runs"]["naive"]["mean"]["hold_rms_m"] == pytest.approx(1.2e-3)
    assert len(found["runs"]["oracle"]["seeds"]) == 2


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--mode", "palpate"), {"mode": "palpate"}),
        (("--predictor", "hold"), {"predictor": "hold"}),
        (("--quick",), {"hold_points": 2, "hold_s": 4.0}),
        (("--points", "4"), {"hold_points": 4}),
    ],
)
def test_options_become_settings(
    asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str], options: tuple[str, ...], expected: dict[str, Any]
) -> None:
    about(capsys, 0, *options)
    for name, value in expected.items():
        assert getattr(asked[0]["settings"], name) == value


def test_a_settings_file_changes_camera_and_run_and_options_win(
    asked: list[dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "my.toml"
    band = "band_hz = [0.5, 3]\nharmonics = 5"
    path.write_text(f'[track]\nmode = "palpate"\ndwell_s = 0.2\n{band}\n[camera]\nlatency_s = 0.1\n', encoding="utf-8")
    about(capsys, 0, "--settings", str(path), "--mode", "scan")
    assert (asked[0]["settings"].mode, asked[0]["settings"].dwell_s) == ("scan", 0.2)
    assert (asked[0]["settings"].band_hz, asked[0]["settings"].harmonics) == ((0.5, 3.0), 5)
    assert asked[0]["camera"].latency_s == 0.1
    for text, words in (
        ("[trak]\n", "expected [track] and [camera]"),
        ("[track]\ndwel_s = 1\n", "did you mean 'dwell_s'"),
        ("[track]\nband_hz = [0.5]\n", "expected 2 values"),
        ("[camera]\nlatency_s = -1\n", "expected a number from 0 to 2 s"),
        ("[camera]\nseed = 1\n", "seed comes from --seed"),
        ("[track", "not valid TOML"),
    ):
        path.write_text(text, encoding="utf-8")
        assert words in refusal(capsys, "track", "--settings", str(path))


def test_motions(asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]) -> None:
    for text in ("lujan:20 mm:5", "lujan:0.02:5 s", "example:breathing", "still"):
        about(capsys, 0, "--motion", text)
    described = [call["motion"].description for call in asked]
    assert described == [
        "respiration 20 mm, 5 s, 10 % variation",
        "respiration 20 mm, 5 s, 10 % variation",
        "recorded in example:breathing",
        "still",
    ]


def test_a_recording_of_motion_can_be_read_strictly(
    asked: list[dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stamps = np.arange(100) / 10.0
    stamps[30] /= 500.0
    np.savetxt(
        tmp_path / "marker.csv", np.column_stack((stamps, np.sin(stamps) / 100.0)), header="t_s,x_m", delimiter=","
    )
    motion = ("--motion", str(tmp_path / "marker.csv"))
    assert "1 row out of order in time is left out" in about(capsys, 0, *motion)["notes"]
    assert "strict reading was asked for" in refusal(capsys, "track", *motion, "--strict")
    assert len(asked) == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--surface", "/dev/zero"), "error: /dev/zero: cannot be read: it is a pipe or a device"),
        (("--surface", "nowhere.ply"), "cannot be read: No such file"),
        (("--surface", "example:orgen"), "did you mean 'organ'"),
        (("--units", "mm"), "--units is for a surface from a file"),
        (("--surface", "example:organ", "--singular"), "leave out --surface or --singular"),
        (("--surface", "example:organ", "--units", "m"), "the file says mm"),
        (("--points", "1000000"), "expected at most 20000"),
        (("--motion", "lujam"), "choose lujan, lujan:AMPLITUDE:PERIOD, still, example:breathing"),
        (("--motion", "lujan:0.015"), "--motion 'lujan:0.015' is unknown: choose lujan, lujan:AMPLITUDE:PERIOD"),
        (("--motion", "lujan:20 kg:5"), "'20 kg' is a mass, expected a length (m)"),
        (("--motion", "lujan:0.02:0"), "period_s is 0"),
        (
            ("--motion", "lujan:15:4"),
            "--motion lujan:15:4: amplitude is 15 m; expected 0 to 10 m; AMPLITUDE",
        ),
        (("--strict",), "--strict is for a surface or a motion from a file"),
        (("--motion", "still", "--motion-rate", "5"), "are for a recording"),
        (("--motion-rate", "0"), "are for a recording"),
        (("--predictor", "swich"), "did you mean 'switch'"),
        (("--robot", "pandda"), "did you mean 'panda'"),
        (("--robot", "rrbot"), "rrbot has 2 joints; 5 at least bring a tool to a point of a surface"),
        (("--robot", "raven2_gold"), "raven2_gold has 3 joints"),
        (("--least-coverage", "101"), "expected 0 to 100 %"),
        (("--view", "view.png"), "ending in .html"),
        (("--out", "/dev/null/x"), "cannot be written"),
        (("--settings", "nowhere.toml"), "cannot be read"),
    ],
)
def test_bad_input_is_refused_before_the_run(
    asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str], options: tuple[str, ...], words: str
) -> None:
    assert words in refusal(capsys, "track", *options)
    assert not asked


@pytest.mark.parametrize("words", ["--points 0", "--seeds x", "--seed -1", "--at 1,2", "--mode press"])
def test_options_that_are_no_values(capsys: pytest.CaptureFixture[str], words: str) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["track", *words.split()])
    assert caught.value.code == 2
    assert "ravengc track: error: argument" in capsys.readouterr().err


# Where a cloud is put


def test_a_cloud_in_reach_stays_where_it_is_and_one_out_of_reach_is_put_before_the_arm(
    asked: list[dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points = np.array((0.5, 0.0, 0.3)) + 0.05 * np.random.default_rng(0).standard_normal((20, 3)) * (1, 1, 0.1)
    rows = np.hstack((points, np.tile((0.0, 0.0, 1.0), (20, 1))))
    np.savetxt(tmp_path / "near.xyz", rows)
    np.savetxt(tmp_path / "far.xyz", np.add(rows, (9.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    found = about(capsys, 0, "--surface", str(tmp_path / "near.xyz"))
    np.testing.assert_allclose(asked[0]["surface"].points, points, atol=1e-12)
    assert asked[0]["surface"].name == "near.xyz"
    assert len(found["notes"]) == 1
    assert (
        "the arm does not reach it where it is" in about(capsys, 0, "--surface", str(tmp_path / "far.xyz"))["notes"][-1]
    )
    middle = asked[1]["surface"].points.mean(axis=0)
    assert 0.2 < np.linalg.norm(middle) < 0.9
    found = about(capsys, 0, "--surface", str(tmp_path / "far.xyz"), "--at", "0.4,0.1,0.2", "--turn", "180,0,0")
    assert "--at 0.4,0.1,0.2 --turn 180,0,0" in found["command"]
    box = asked[2]["surface"].points
    np.testing.assert_allclose(0.5 * (box.min(axis=0) + box.max(axis=0)), (0.4, 0.1, 0.2), atol=1e-12)
    np.testing.assert_allclose(asked[2]["surface"].normals[:, 2], -1.0)


def test_the_note_on_the_place_is_in_whole_millimetres(
    asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    notes = " ".join(about(capsys, 0, "--robot", "dvrk_psm")["notes"])
    place = re.search(r"its middle is put at (\S+), (\S+), (\S+) m", notes)
    assert place
    assert all(re.fullmatch(r"-?\d+(\.\d{1,3})?", number) and number != "-0" for number in place.groups())
    assert asked


@pytest.mark.parametrize("name", ["ur5", "ur10", "pa10", "dvrk_psm", "dvrk_mtml", "raven2_green_wrist"])
def test_any_arm_begins_within_its_limits_and_reaches_the_surface_of_the_benchmark(
    asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str], name: str
) -> None:
    about(capsys, 0, "--robot", name)
    robot, surface, start = (asked[0][key] for key in ("robot", "surface", "settings"))
    assert len(surface) == 500
    start = start_of(robot, start)
    assert np.linalg.svd(robot.jacobian(start), compute_uv=False)[-1] > 0.03
    assert track_place.reaches(robot, start, Cloud(surface.points, surface.normals, "liver"))


# What is written


def test_the_folder_has_report_picture_and_numbers(
    asked: list[dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    from ravengc.cli import track

    monkeypatch.setattr(track, "_has_viser", lambda: False)
    found = about(capsys, 0, "--baseline", "--out", str(tmp_path / "out"))
    names = ("report.html", "results.json", "track.png", "track.svg")
    assert found["files"] == [str(tmp_path / "out" / name) for name in names]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(names)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "pip install &#x27;ravengc[view]&#x27;" in page
    assert "ravengc track --baseline" in page
    stored = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    assert stored["runs"] == found["runs"]
    assert len(asked) == 2


@pytest.mark.parametrize(
    ("error", "code"), [(ConfigError("disk: cannot be written: No space left"), 2), (KeyboardInterrupt(), 130)]
)
def test_the_numbers_are_printed_even_if_the_files_cannot_be_written(
    asked: list[dict[str, Any]],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    code: int,
) -> None:
    """The disk may be full only after the run, and Ctrl-C may come while a picture is drawn."""
    pytest.importorskip("matplotlib")
    from ravengc.cli import track, track_files

    def fail(*_: Any) -> None:
        raise error

    monkeypatch.setattr(track, "_has_viser", lambda: False)
    monkeypatch.setattr(track_files, "write_report", fail)
    assert main(["track", "--json", "--out", str(tmp_path)]) == code
    printed = capsys.readouterr()
    assert json.loads(printed.out)["runs"]["resolved"]["mean"]["coverage"] == pytest.approx(0.7)
    assert ("No space left" in printed.err) == (code == 2)
    assert ("while the files were written" in json.loads(printed.out)["interrupted"]) == (code == 130)
    assert asked


def test_too_little_coverage_is_exit_code_1(asked: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track"]) == 1
    out = capsys.readouterr().out
    assert "70.0% of the points covered; expected 95.0% at least" in out
    assert "resolved: 1 missed, 1 timeout, 1 unreachable of 10 points" in out
    assert main(["track", "--least-coverage", "70"]) == 0
    assert asked


def test_too_little_coverage_says_what_the_predictor_noted_and_what_helps(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import dataclasses

    counters = {"received": 1000, "accepted": 1000, "out_of_band": 810, "learning": 20, "jump": 100}
    run = dataclasses.replace(small_run(10), predictor_counters=counters)
    monkeypatch.setattr(tracking, "track", lambda *_: run)
    _, jump, band = json_problems(capsys)
    assert jump.startswith("the predictor, with 10% of the pictures: the sample moved the prediction by more than")
    assert band.startswith("the predictor, with 81% of the pictures: the cycles are at an end of the declared band")
    assert band.endswith("(out_of_band); band_hz and harmonics in [track] of --settings say which cycles to expect")
    assert not about(capsys, 0)["problems"]


def test_points_out_of_reach_are_counted_and_only_a_cloud_from_a_file_can_be_put_elsewhere(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import dataclasses

    some = small_run(10)
    visits = dataclasses.replace(some.visits, outcome=np.full(10, "unreachable"))
    none = dataclasses.replace(some, visits=visits, coverage=0.0)
    elsewhere = ": --at X,Y,Z puts the cloud elsewhere, --turn R,P,Y turns it"
    for run, which in ((some, "1"), (none, "all")):
        monkeypatch.setattr(tracking, "track", lambda *_, run=run: run)
        assert json_problems(capsys)[0].endswith(f"; {which} of them out of the arm's reach")
        from_file = json_problems(capsys, "--surface", "example:organ")
        assert from_file[0].endswith(f"; {which} of them out of the arm's reach{elsewhere}")


def json_problems(capsys: pytest.CaptureFixture[str], *options: str) -> list[str]:
    """Why the exit code is 1."""
    assert main(["track", "--json", *options]) == 1
    problems: list[str] = json.loads(capsys.readouterr().out)["problems"]
    return problems


def test_a_limit_that_was_exceeded_is_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import dataclasses

    run = dataclasses.replace(small_run(10), limit_violations={"position": 0, "velocity": 4})
    monkeypatch.setattr(tracking, "track", lambda *_: run)
    assert "4 cycles with a joint beyond its limit" in about(capsys, 1)["problems"][0]


def test_settings_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", "--list-settings"]) == 0
    out = capsys.readouterr().out
    assert "[track]" in out
    assert "latency_s" in out
    assert re.search(r"tolerance_rad\s+0\.0174533\b", out)
    assert not re.search(r"^\s*seed ", out, re.MULTILINE)
    assert main(["track", "--list-settings", "--json"]) == 0
    tables = json.loads(capsys.readouterr().out)
    assert {row["key"] for row in tables["camera"]} >= {"rate_hz", "latency_s", "noise_m"}


def test_the_help_fits_80_columns_and_its_examples_are_understood(
    asked: list[dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main(["track", "--help"])
    printed = capsys.readouterr().out
    assert max(map(len, printed.splitlines())) <= 80
    monkeypatch.chdir(tmp_path)
    rows = np.hstack((1e3 * np.random.default_rng(0).uniform(0.0, 0.2, (30, 3)), np.tile((0.0, 0.0, 1.0), (30, 1))))
    np.savetxt(tmp_path / "scan.ply", rows)
    header = "ply\nformat ascii 1.0\nelement vertex 30\n"
    header += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz")) + "end_header\n"
    (tmp_path / "scan.ply").write_text(header + (tmp_path / "scan.ply").read_text(encoding="utf-8"), encoding="utf-8")
    examples = re.findall(r"^  ravengc (track.*?)(?:  #.*)?$", printed, re.MULTILINE)
    assert len(examples) == 7
    for example in examples:
        words = [word for word in shlex.split(example) if not word.startswith(("--out", "--view", "out/"))]
        before = len(asked)
        assert main([*words, "--least-coverage", "0"]) == 0
        assert len(asked) > before


def test_the_length_of_an_arm(asked: list[dict[str, Any]]) -> None:
    assert not asked
    import ravengc

    assert 1.0 < track_place.length(ravengc.load("panda")) < 1.6


# Stopped, and what could never be


def test_more_seeds_than_can_be_meant_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--seeds is 1001; expected at most 1000" in refusal(capsys, "track", "--seeds", "1001")


@pytest.mark.parametrize("name", ["report.html", "results.json", "track.svg", "view.html"])
def test_a_folder_in_the_place_of_a_file_is_found_before_the_run(
    asked: list[dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    pytest.importorskip("matplotlib")
    (tmp_path / name).mkdir()
    assert f"{name}: cannot be written: Is a directory" in refusal(capsys, "track", "--out", str(tmp_path))
    assert not asked
    assert "cannot be written" in refusal(capsys, "track", "--out", "/proc/x")


def stopping(monkeypatch: pytest.MonkeyPatch, runs: int) -> None:
    """Ctrl-C in the run after so many."""
    import dataclasses

    left = iter([False] * runs + [True])

    def run(*arguments: Any) -> TrackResult:
        return dataclasses.replace(small_run(10, method=arguments[4].method), interrupted=next(left))

    monkeypatch.setattr(tracking, "track", run)


@pytest.mark.parametrize(
    ("runs", "seeds", "methods"),
    [(0, [0], 1), (1, [0], 1), (2, [0], 2), (3, [0], 2), (4, [0, 1], 2), (5, [0, 1], 2)],
)
def test_ctrl_c_tells_what_was_done(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], runs: int, seeds: list[int], methods: int
) -> None:
    """Means are of the seeds that all methods have, and a run that was stopped counts only if there is no other."""
    stopping(monkeypatch, runs)
    found = about(capsys, 130, "--baseline", "--seeds", "5")
    assert found["seeds"] == seeds
    assert [len(run["seeds"]) for run in found["runs"].values()] == [len(seeds)] * methods
    assert not found["holds"]
    assert "stopped by Ctrl-C in " in found["interrupted"]
    assert found["interrupted"].endswith("that run does not count") == (runs > 0)
    stopping(monkeypatch, runs)
    assert main(["track", "--baseline", "--seeds", "5"]) == 130
    assert found["interrupted"][:40] in capsys.readouterr().out


def test_the_report_of_a_stopped_run_is_written(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    from ravengc.cli import track

    monkeypatch.setattr(track, "_has_viser", lambda: False)
    stopping(monkeypatch, 0)
    about(capsys, 130, "--out", str(tmp_path))
    assert "stopped by Ctrl-C" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert {path.name for path in tmp_path.iterdir()} == {"report.html", "results.json", "track.png", "track.svg"}
