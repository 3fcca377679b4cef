"""``ravengc stability`` and ``ravengc run --mount`` from their options to what they print and their exit codes."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

import pytest

from ravengc.cli import main
from ravengc.stability import trials

if TYPE_CHECKING:
    from pathlib import Path

SOFT = ("panda", "--base-mass", "8", "--base-frequency", "2.5", "--base-damping", "0.005", "--latency", "30 ms",
        "--cutoff", "10", "--direction", "x,y")  # fmt: skip
FIRM = ("raven2_gold", "--base-mass", "900 kg", "--base-frequency", "4", "--direction", "y")


def printed(capsys: pytest.CaptureFixture[str], code: int, *options: str) -> str:
    assert main(["stability", *options]) == code
    return capsys.readouterr().out


def test_a_firm_base_is_certified(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, 0, *FIRM)
    for expected in (
        "raven2_gold, pd+dg, base free in y",
        "unstable poles",
        "gain margin, dB",
        "c_eff / c",
        "certified:",
    ):
        assert expected in out


def test_a_soft_base_is_not_and_it_says_what_to_change(capsys: pytest.CaptureFixture[str]) -> None:
    out = printed(capsys, 1, *SOFT)
    for expected in ("not certified: ", "What to change", "K_P at least", "damp the base", "feed at most"):
        assert expected in out
    assert "not certified" not in printed(capsys, 0, *SOFT, "--law", "pd+sg")


@pytest.mark.parametrize(
    ("direction", "damping"),
    [
        ("x", r"c at least [\d.e+]+ N s/m\n"),
        ("x,y", r"c at least [\d.e+]+, [\d.e+]+ N s/m\n"),
        ("ry", r"c at least [\d.e+]+ N m s/rad\n"),
        ("ry,rx", r"c at least [\d.e+]+, [\d.e+]+ N m s/rad\n"),
        ("x,ry", r"c at least [\d.e+]+ N s/m, [\d.e+]+ N m s/rad\n"),
    ],
)
def test_what_to_change_is_in_the_units_of_each_direction(
    capsys: pytest.CaptureFixture[str], direction: str, damping: str
) -> None:
    """Turning is damped by N m s/rad and not by N s/m; RAVEN's insertion slides, its other joints turn."""
    out = printed(capsys, 1, "raven2_gold", "--base-mass", "0.3", "--base-frequency", "4", "--direction", direction,
                  "--latency", "30 ms", "--base-damping", "0.001", "--sensor-place", "0", "0", "1")  # fmt: skip
    assert re.search(damping, out), out
    assert re.search(r"K_P at least [\d.e+]+ N m/rad, [\d.e+]+ N m/rad, [\d.e+]+ N/m \(", out), out
    for unit in ("N s/m", "N m s/rad"):
        assert (f" {unit} " in out.split("certified")[0]) <= (unit in damping), "the unit of a swing of the base"


def test_json_has_the_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    about = json.loads(printed(capsys, 1, *SOFT, "--json"))
    assert not about["certified"]
    assert about["unstable_poles"] >= 2
    assert about["pole"]["real"] > 0.0
    assert about["margin_db"] < 0.0
    assert about["sensing"]["latency_s"] == 0.03
    assert about["base"]["directions"] == ["x", "y"]
    less = next(remedy for remedy in about["remedies"] if remedy["name"] == "share fed")
    about = json.loads(printed(capsys, 0, *SOFT, "--json", "--share", str(less["value"])))
    assert about["certified"]


def test_the_picture(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    picture = tmp_path / "loop.png"
    assert f"plot: {picture}" in printed(capsys, 1, *SOFT, "--plot", str(picture))
    assert picture.read_bytes()[:4] == b"\x89PNG"
    printed(capsys, 0, *FIRM, "--law", "pd+sg", "--plot", str(tmp_path / "still.svg"))
    assert (tmp_path / "still.svg").stat().st_size > 1000


def test_a_campaign_prints_its_table(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trials, "STEPS", (1_000, 2_000))
    out = printed(capsys, 0, "--campaign", "6", "--seed", "5")
    assert "nothing certified grew" in out
    kinds = json.loads(printed(capsys, 0, "--campaign", "6", "--seed", "5", "--json"))["kinds"]
    assert sum(kind["cases"] for kind in kinds) == 6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "which robot"),
        (("raven2_gold",), "--base-mass is missing"),
        (("raven2_gold", "--base-mass", "5"), "give --base-frequency HZ"),
        (("raven2_gold", "--base-mass", "-5", "--base-frequency", "2"), "--base-mass is -5.0; expected a number"),
        (("raven2_gold", "--base-mass", "5", "--stiffness", "-9"), "stiffness is -9.0; expected above zero"),
        (
            ("raven2_gold", "--base-mass", "5", "--base-frequency", "2", "--kp", "1,-3,1"),
            "kp of 'elbow' is -3.0; expected above zero",
        ),
        (("raven2_gold", "--base-mass", "5 m", "--base-frequency", "2"), "--base-mass"),
        (
            ("raven2_gold", "--base-mass", "5", "--base-frequency", "0"),
            "frequency_hz is 0.0; expected a number from 0.001",
        ),
        (("raven2_gold", "--base-mass", "5", "--base-frequency", "2", "--law", "pd+gd"), "law 'pd+gd' is unknown"),
        (("raven2_gold", "--base-mass", "5", "--base-frequency", "2", "--kp", "1,2"), "--kp has 2 values"),
        (("raven2_gold", "--base-mass", "5", "--base-frequency", "2", "--direction", "u"), "direction 'u' is unknown"),
        (("raven2_gold", "--base-mass", "5", "--base-frequency", "2", "--plot", "x.txt"), "unknown kind of picture"),
        (("--campaign", "0"), "cases is 0; expected a whole number from 1"),
    ],
)
def test_bad_input_is_told(capsys: pytest.CaptureFixture[str], options: tuple[str, ...], message: str) -> None:
    assert main(["stability", *options]) == 2
    assert message in capsys.readouterr().err


def test_a_run_on_a_soft_mount_warns_before_it_starts(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    short = ["run", "--fast", "--json", "--duration", "0.05", "--robot", "panda", "--motion", "hold"]
    assert main([*short, "--cutoff", "5", "--mount", "8:2.5:0.005:x,y"]) == 0
    run = capsys.readouterr()
    assert run.err.startswith("ravengc: warning: not certified: ")
    assert "natural frequency" in run.err
    about = json.loads(run.out)
    assert about["mount"] == "8:2.5:0.005:x,y"
    assert about["mount_warnings"][0].startswith("not certified")
    assert main([*short, "--mount", "15000:2:0.05"]) == 0
    assert capsys.readouterr().err == ""
    assert main([*short, "--mount", "15"]) == 2
    assert "mount '15': write MASS:HZ:ZETA" in capsys.readouterr().err
