"""``ravengc sensor``: what it says of healthy, wrong, recorded and missing sensors."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from ravengc.cli import main

if TYPE_CHECKING:
    from pathlib import Path


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict]:
    code = main(["sensor", *arguments, "--json"])
    return code, json.loads(capsys.readouterr().out)


def recording(path: Path, forces: np.ndarray, rate_hz: float = 100.0) -> Path:
    lines = ["time_s,ax,ay,az"]
    lines += [f"{k / rate_hz:.4f}," + ",".join(f"{x:.6f}" for x in f) for k, f in enumerate(forces)]
    path.write_text("\n".join(lines) + "\n")
    return path


def level(count: int, size: float = rg.STANDARD_GRAVITY, noise: float = 0.02) -> np.ndarray:
    random = np.random.default_rng(5)
    return size * np.array((0.0, 0.0, 1.0)) + noise * random.standard_normal((count, 3))


def address(path: Path) -> str:
    return f"replay:{path}?time=time_s&acc=ax,ay,az&unit=m/s^2"


def test_the_shipped_recording_runs_through_and_every_alarm_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = said(capsys, "replay:example:xio")
    assert code == 0
    assert found["samples"] == 13514
    assert 4.0 < found["norm_m_s2"]["lowest"] < 4.4
    assert 15.0 < found["norm_m_s2"]["highest"] < 15.3
    assert found["gyroscope"]
    assert found["seconds"]["live"] > 10.0
    assert found["alarms"]
    for alarm in found["alarms"]:
        assert set(alarm["alarms"]) <= set(rg.FAULTS)
        assert all(rg.FAULTS[name] in alarm["explained"] for name in alarm["alarms"])
    in_alarm = sum(alarm["end_s"] - alarm["begin_s"] for alarm in found["alarms"])
    assert in_alarm == pytest.approx(found["seconds"]["held"], abs=0.2)


def test_a_healthy_sensor_is_called_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = said(capsys, address(recording(tmp_path / "a.csv", level(500))))
    assert code == 0
    assert found["verdicts"] == ["nothing wrong was seen"]
    assert found["tilt_deg"] == pytest.approx(0.0, abs=0.3)
    assert not found["alarms"]


def test_another_unit_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = said(capsys, address(recording(tmp_path / "a.csv", level(500, size=0.98, noise=0.002))))
    assert code == 1
    assert "looks like g, not m/s²: set unit = g" in found["verdicts"][0]


def test_another_rate_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, found = said(capsys, address(recording(tmp_path / "a.csv", level(300), rate_hz=50.0)))
    assert any("50 samples per second, declared are 100" in verdict for verdict in found["verdicts"])


def test_gravity_reported_upside_down_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, found = said(capsys, address(recording(tmp_path / "a.csv", -level(500))))
    assert "sign" in found["alarms"][0]["alarms"]
    assert rg.FAULTS["sign"] in found["alarms"][0]["explained"]


def test_a_simulated_sensor_lives_in_real_time(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = said(capsys, "sim:tilt:10?noise=0.02", "--seconds", "1")
    assert code == 0
    assert found["seconds"]["live"] > 0.5
    assert found["tilt_deg"] == pytest.approx(10.0, abs=0.5)


def test_a_missing_sensor_is_an_answer_not_a_crash(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sensor", "serial:/dev/nosuch?format=line", "--seconds", "0.3"]) == 1
    said = capsys.readouterr().out
    assert "no sample came" in said
    assert "/dev/nosuch" in said


def test_tables_and_help_are_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    main(["sensor", "replay:example:xio", "--seconds", "20"])
    table = capsys.readouterr().out
    assert "jitter" in table
    assert "the specific force jumped" in table
    with pytest.raises(SystemExit):
        main(["sensor", "--help"])
    assert "serial:/dev/ttyUSB0" in capsys.readouterr().out


@pytest.mark.parametrize("wrong", ["nonsense", "serail:/dev/x", "replay:nosuch.csv", "udp:99999999"])
def test_an_address_that_is_none(wrong: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sensor", wrong]) == 2
    assert capsys.readouterr().err.startswith("ravengc: error:")
