"""Where ``ravengc calibrate accelerometer`` has its readings from: a recording by its address, or a live sensor."""

from __future__ import annotations

import io
import json
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from calibrate_calls import BIAS, SIX, TILTS, WORDS, refused, said, table
from calibration_scenes import G, Turned, evenly, held
from ravengc.calibration import read_block, write_block
from ravengc.cli import _parser, main
from ravengc.cli.calibrate import run
from ravengc.errors import SensorError

if TYPE_CHECKING:
    from pathlib import Path

    from ravengc.sensors import Address


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder, and a terminal of 80 columns."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


# Recordings by a sensor's address


def test_a_replayed_recording_is_read_as_its_address_says(capsys: pytest.CaptureFixture[str]) -> None:
    table("log.csv", held(SIX + BIAS, gyro=False), 1.0 / G)
    plain = said(capsys, "log.csv", "--unit", "g")
    for words in (["replay:log.csv?unit=g"], ["replay:log.csv?time=t&acc=ax,ay,az&speed=2&repeat=yes", "--unit", "g"]):
        found = said(capsys, *words)
        assert found["recording"]["source"] == "log.csv"
        np.testing.assert_allclose(found["bias"], plain["bias"], atol=1e-9)
    turned = said(capsys, "replay:log.csv?unit=g&axes=y,-x,z")
    np.testing.assert_allclose(turned["bias"], [plain["bias"][1], -plain["bias"][0], plain["bias"][2]], atol=1e-6)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["seriall:/dev/ttyUSB0"], "unknown kind 'seriall'; did you mean 'serial'?"),
        (["sim:lvel"], "write level, tilt:DEG, rocking"),
        (["replay:log.csv?unit=g", "--unit", "mg"], "--unit mg: sensor 'replay:log.csv?unit=g' says g"),
        (["sim:level", "--unit", "g"], "--unit: sensor 'sim:level' does not take it"),
        (["serial:/dev/none", "--columns", "1", "2", "3"], "--columns: a sensor's address names the columns itself"),
        (["iio:none", "--rate", "100"], "--rate: a live sensor has its own"),
        (["stdin:?format=csv"], "carries the answers to questions"),
        (["x" * 5000 + ".csv"], "File name too long"),
        (["serial:" + "x" * 5000], "too long"),
        ([""], "source is empty"),
    ],
)
def test_sources_that_cannot_be_followed_are_named(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert message in refused(capsys, *words)


# A live sensor


def live(hand: Turned, *words: str, source: str = "sim:") -> int:
    return run(_parser().parse_args(["calibrate", "accelerometer", source, *words]), lambda _: hand, hand.ask)


def test_a_live_sensor_is_read_as_the_options_and_the_robot_say() -> None:
    opened: list[Address] = []

    def unplugged(address: Address) -> Turned:
        opened.append(address)
        raise SensorError("unplugged")

    write_block("arm.toml", {"unit": "mg"})
    for words in (
        ["--unit", "g", "--sends", "gravity"],
        ["--robot", "arm.toml"],
        ["--unit", "g", "--robot", "arm.toml"],
    ):
        with pytest.raises(SensorError, match="unplugged"):
            run(_parser().parse_args(["calibrate", "accelerometer", "serial:/dev/none?format=csv", *words]), unplugged)
    assert [address.options.get("unit") for address in opened] == ["g", "mg", "g"]
    assert opened[0].options["sends"] == "gravity"


@pytest.mark.parametrize(
    ("forces", "options", "method"),
    [
        (None, [], "six positions"),
        (None, ["--method", "six"], "six positions"),
        (G * evenly(14), ["--method", "ellipsoid"], "ellipsoid"),
        (TILTS, ["--tilts", *WORDS], "known tilts"),
    ],
)
def test_a_live_sensor_is_asked_for_positions(
    forces: Any, options: list[str], method: str, capsys: pytest.CaptureFixture[str]
) -> None:
    hand = Turned(forces)
    assert live(hand, *options, "--json", "--robot", "arm.toml", "--write") == 0
    about = json.loads(capsys.readouterr().out)
    assert (about["method"], about["recording"]["source"]) == (method, "sim: in a hand")
    assert hand.closed
    assert read_block("arm.toml") is not None


def test_a_live_sensor_is_closed_when_the_user_gives_up() -> None:
    hand = Turned()

    def interrupted(_: str) -> str:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(_parser().parse_args(["calibrate", "accelerometer", "sim:"]), lambda _: hand, interrupted)
    assert hand.closed


def test_questions_go_to_standard_error_and_need_somebody_to_answer(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(""))
    message = "ravengc: error: nobody answers: the input ended; run it in a terminal, or calibrate from a recording\n"
    assert main(["calibrate", "accelerometer", "sim:level"]) == 2
    printed = capsys.readouterr()
    assert (printed.out, printed.err) == ("", "+x up: put it there, hold it still and press Enter: " + message)


def test_a_live_lever_arm_is_recorded_once_the_user_is_ready(capsys: pytest.CaptureFixture[str]) -> None:
    hand = Turned()
    with pytest.raises(ValueError, match=r"turns by 0 rad/s RMS only"):
        live(hand, "--method", "lever-arm")
    assert len(hand.asked) == 1
    assert "about two axes in turn; press Enter, and go on for 20 s" in hand.asked[0]
    with pytest.raises(ValueError, match="takes a gyroscope"):
        live(Turned(gyro=False), "--method", "lever-arm")
    assert capsys.readouterr().out == ""


def test_a_simulated_sensor_is_a_live_one(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """In real time, by its address: a base that rocks about one axis, and one that stays where it is."""
    monkeypatch.setattr("ravengc.cli.calibrate_source.ROCKING_S", 3.0)
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n\nq\n"))
    rocking = "sim:rocking:-15:15:1?noise=0.03&gyro_noise=0.001&position=0.1,-0.2,0.3"
    assert main(["calibrate", "accelerometer", rocking, "--method", "lever-arm"]) == 2
    assert "place of the sensor along x undetermined" in capsys.readouterr().err
    assert main(["calibrate", "accelerometer", "sim:level?noise=0.02", "--method", "ellipsoid"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "Position 2 of 12 or more (1 different so far, coverage 0 of 60 degrees, none near +x" in printed.err
    assert "1 different position cover 0.0 degrees" in printed.err
