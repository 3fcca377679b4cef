"""``ravengc calibrate accelerometer`` from its options to its files and exit codes."""

from __future__ import annotations

import json
import re
import shlex
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calibrate_calls import BIAS, SIX, TILTS, WORDS, refused, said, saved, table
from calibration_scenes import G, Turned, evenly, held, rocked, rotation
from ravengc.calibration import ImuRecording, read_block, write_block
from ravengc.cli import _parser, main
from ravengc.cli.calibrate import run
from ravengc.config import bundled_path


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder, and a terminal of 80 columns."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


# Methods


def test_six_positions_print_and_write(capsys: pytest.CaptureFixture[str]) -> None:
    log = saved(held(SIX + BIAS))
    assert main(["calibrate", "accelerometer", log]) == 0
    printed = capsys.readouterr().out
    assert "accelerometer calibration: six positions" in printed
    assert "Good: six positions" in printed
    assert "[accelerometer]\nbias = [" in printed
    assert max(len(line) for line in printed.splitlines() if " = " not in line) <= 80
    about = said(capsys, log, "--robot", "arm.toml", "--write")
    np.testing.assert_allclose(about["bias"], BIAS, atol=0.01)
    assert about["written"] == "arm.toml"
    block = read_block("arm.toml")
    assert block is not None
    assert list(block.bias) == about["bias"]
    assert block.given == {"bias", "correction", "gyro_bias"}


def test_free_positions_are_written_into_a_robot_that_stays_as_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    old = bundled_path("raven2_gold").read_bytes()
    Path("arm.toml").write_bytes(old)
    about = said(capsys, saved(held(G * evenly(14) + BIAS, hold_s=2.0)), "--robot", "arm.toml", "--write")
    assert about["method"] == "ellipsoid"
    assert len(about["positions"]) == 14
    assert np.shape(about["covariance"]) == (9, 9)
    assert Path("arm.toml").read_bytes().startswith(old + b"\n[accelerometer]\nbias = [")


def test_known_tilts_from_words_and_from_a_file_are_alike(capsys: pytest.CaptureFixture[str]) -> None:
    log = saved(held(TILTS @ rotation(3) + BIAS))
    words = said(capsys, log, "--tilts", *WORDS)
    Path("tilts.txt").write_text("# roll, pitch\n" + "\n".join(WORDS) + "\n\n")
    assert said(capsys, log, "--tilts", "tilts.txt") == words
    np.testing.assert_allclose(words["rotation"], rotation(3), atol=2e-3)
    np.testing.assert_allclose(words["bias"], BIAS, atol=0.02)
    assert list(words["accelerometer"]) == ["bias", "rotation", "gyro_bias"]


def test_tilts_keep_the_correction_that_the_robot_has(capsys: pytest.CaptureFixture[str]) -> None:
    s = np.diag([1.05, 0.97, 1.02])
    write_block("arm.toml", {"correction": s})
    log = saved(held(TILTS @ rotation(3) @ np.linalg.inv(s) + BIAS))
    about = said(capsys, log, "--tilts", *WORDS, "--robot", "arm.toml", "--write")
    np.testing.assert_allclose(about["bias"], BIAS, atol=0.02)
    block = read_block("arm.toml")
    assert block is not None
    np.testing.assert_array_equal(block.correction, s)


def test_the_lever_arm_takes_calibration_and_mounting_from_the_robot(capsys: pytest.CaptureFixture[str]) -> None:
    r, (t, f, w) = rotation(6), rocked()
    log = saved(ImuRecording(t=t, specific_force=f @ r + BIAS, angular_velocity=w @ r))
    write_block("arm.toml", {"rotation": r, "bias": BIAS})
    about = said(capsys, log, "--method", "lever-arm", "--robot", "arm.toml", "--write", "--pivot", "0", "10mm", "0")
    np.testing.assert_allclose(about["position"], [0.1, -0.19, 0.3], atol=0.002)
    block = read_block("arm.toml")
    assert block is not None
    assert list(block.position) == about["position"]
    assert main(["calibrate", "accelerometer", log, "--method", "lever-arm", "--robot", "arm.toml"]) == 0
    assert "place, m" in capsys.readouterr().out


@pytest.mark.parametrize("scene", ["six", "free", "tilts", "lever-arm"])
def test_every_method_draws_a_picture(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    t, f, w = rocked()
    scenes = {
        "six": (held(SIX), []),
        "free": (held(G * evenly(14), hold_s=2.0, gyro=False), []),
        "tilts": (held(TILTS), ["--tilts", *WORDS]),
        "lever-arm": (ImuRecording(t=t, specific_force=f, angular_velocity=w), ["--method", "lever-arm"]),
    }
    recording, options = scenes[scene]
    for name in ("a.png", "a.svg"):
        about = said(capsys, saved(recording), *options, "--plot", name)
        assert about["plot"] == name
        assert Path(name).stat().st_size > 10_000


@pytest.mark.parametrize("scene", ["tilts", "poor"])
def test_no_words_of_the_picture_lie_over_others(
    scene: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    drawn: list[Any] = []
    monkeypatch.setattr("ravengc.reports.calibration_plot.save_figure", lambda figure, _: drawn.append(figure))
    forces = TILTS @ rotation(3) if scene == "tilts" else G * evenly(14) * np.linspace(1.0, 1.1, 14)[:, np.newaxis]
    words = ["--tilts", *WORDS] if scene == "tilts" else []
    main(["calibrate", "accelerometer", saved(held(forces, hold_s=2.0)), *words, "--plot", "a.png"])
    figure = drawn[0]
    figure.draw_without_rendering()
    texts = [
        figure._suptitle,
        *(part for axes in figure.axes for part in (axes.title, axes._left_title, axes.xaxis.label)),
    ]
    texts += [axes.get_legend() for axes in figure.axes if axes.get_legend()]
    boxes = [text.get_window_extent() for text in texts if not hasattr(text, "get_text") or text.get_text()]
    assert len(boxes) >= 8
    assert not [(a, b) for a, b in combinations(boxes, 2) if a.overlaps(b)]
    assert capsys.readouterr().err == ""


# What is refused, and how that is said


def test_the_real_recording_is_refused_with_the_reason(capsys: pytest.CaptureFixture[str]) -> None:
    """A sensor that was moved by hand and lay on a table in between: 13,514 samples, one direction."""
    message = refused(capsys, "example:xio", "--robot", "arm.toml", "--write")
    assert "7 still segments (52.1 s of 135.3 s) within 0.3 degrees of each other: 1 position" in message
    assert "missing: +x, -x, +y, -y, -z" in message
    assert "at least 12 free ones that cover 60 degrees" in message
    assert not Path("arm.toml").exists()


def test_a_replayed_recording_is_a_recording(capsys: pytest.CaptureFixture[str]) -> None:
    assert refused(capsys, "replay:example:xio") == refused(capsys, "example:xio")


def test_a_wrong_unit_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    log = saved(held(SIX), scale=1 / G)
    assert "the norm is 0.9994, taken as m/s^2; it looks like g: set the unit" in refused(capsys, log)
    assert said(capsys, log, "--unit", "g")["good"]


def test_a_mirrored_sensor_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    message = refused(capsys, saved(held(TILTS * [1.0, -1.0, 1.0])), "--tilts", *WORDS)
    assert "its y axis negated" in message
    message = refused(capsys, saved(held(-TILTS)), "--tilts", *WORDS)
    assert "the sensor gives gravity, not specific force" in message
    assert said(capsys, saved(held(-TILTS)), "--sends", "gravity", "--tilts", *WORDS)["good"]


def test_a_poor_result_is_1_and_is_not_written(capsys: pytest.CaptureFixture[str]) -> None:
    forces = G * evenly(14)
    forces[3] *= 1.08
    words = [saved(held(forces, hold_s=2.0)), "--robot", "arm.toml", "--write"]
    assert main(["calibrate", "accelerometer", *words]) == 1
    printed = capsys.readouterr().out
    assert "Poor: ellipsoid" in printed
    assert "position 4 is off" in printed
    assert "not written: too poor to be used" in printed
    assert main(["calibrate", "accelerometer", *words, "--json"]) == 1
    about = json.loads(capsys.readouterr().out)
    assert (about["good"], about["written"], about["accelerometer"]["bias"]) == (False, None, about["bias"])
    assert not Path("arm.toml").exists()


BAD: list[tuple[list[str], str]] = [
    (["--write"], "--write needs --robot FILE"),
    (["--robot", "raven2_gold"], "ravengc info raven2_gold --toml > raven2_gold.toml"),
    (["--robot", "arm.urdf"], "expected a file ending in .toml"),
    (["--robot", "/proc/none/arm.toml", "--write"], "cannot be written"),
    (["--plot", "a.gif"], "unknown kind of picture"),
    (["--pivot", "0", "0", "0"], "--pivot belongs to the method lever-arm"),
    (["--method", "lever-arm", "--tilts", "0,0"], "the method lever-arm takes none"),
    (["--tilts", "15,0", "0,0"], "degrees carry their unit"),
    (["--tilts", "0,0", "5,0"], "tilt 2: '5,0' is more than half a turn; degrees carry their unit: 15deg"),
    (["--robot", "amr.toml"], "--robot amr.toml: no such file; with --write it would be made"),
    (["--robot", "x" * 300 + ".toml"], "no such file"),
    (["--robot", "x" * 300 + ".toml", "--write"], "cannot be"),
    (["--plot", "x" * 300 + ".png"], "cannot be written"),
    (["--tilts", "1deg,2deg,3deg", "0,0"], "is not ROLL,PITCH"),
    (["--tilts", "none.txt"], "none.txt"),
    (["--tilts", "0,0", "1deg,0"], "2 tilts for 6 positions"),
    (["--method", "tilts"], "needs the tilt of every position"),
    (["--still-force", "0"], "expected more than 0"),
    (["--still-force", "5 deg"], "acceleration"),
    (["--still-time", "30"], "it lasts 23 s (2300 samples); a rest takes at least 30 s"),
    (["--local-gravity", "98"], "on Earth it is 9.76 to 9.84"),
    (["--rate", "-3"], "positive"),
    (["--columns", "a", "b"], "2 columns are named"),
]


@pytest.mark.parametrize(("options", "message"), BAD)
def test_options_that_do_not_fit_are_named(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert message in refused(capsys, saved(held(SIX)), *options)


def test_a_robot_file_that_is_wrong_is_named_first(capsys: pytest.CaptureFixture[str]) -> None:
    Path("arm.toml").write_text("[accelerometer]\nbias = [0, 0]\n")
    assert "arm.toml:2: [accelerometer]: bias" in refused(capsys, "none.csv", "--robot", "arm.toml")


def test_a_lever_arm_without_gyroscope_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert "takes a gyroscope" in refused(capsys, saved(held(SIX, gyro=False)), "--method", "lever-arm")


@pytest.mark.parametrize("words", [["calibrate"], ["calibrate", "gyroscope"], ["calibrate", "accelerometer"]])
def test_what_is_left_out_is_named(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(words)
    assert caught.value.code == 2
    assert "usage: ravengc calibrate" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["calibrate", "--help"], ["calibrate", "accelerometer", "--help"]])
def test_the_help_fits_80_columns_and_its_examples_do_what_they_say(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        main(words)
    printed = capsys.readouterr().out
    assert caught.value.code == 0
    assert max(map(len, printed.splitlines())) <= 80
    t, f, w = rocked()
    table("positions.csv", held(SIX, gyro=False))
    table("log.csv", held(SIX, gyro=False), 1.0 / G)
    table("tilted.csv", held(TILTS[:3], gyro=False))
    saved(ImuRecording(t=t, specific_force=f, angular_velocity=w), "rocked.npz")
    examples = re.findall(r"^  ravengc (.*)$", printed, re.MULTILINE)
    assert len(examples) == 5
    for example in examples:
        hand = Turned()
        assert run(_parser().parse_args(shlex.split(example)), lambda _, hand=hand: hand, hand.ask) == 0
        assert ("serial:" in example) == (len(hand.asked) == 6)
        assert "Good: " in capsys.readouterr().out
    assert read_block("arm.toml") is not None
