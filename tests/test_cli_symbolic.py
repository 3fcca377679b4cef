"""``ravengc symbolic`` from its options to what it prints, its files and its exit codes."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING

import pytest

from command_line import refusal
from ravengc import symbolic
from ravengc.cli import main
from ravengc.cli import symbolic as command
from symbolic_c import compiled

pytest.importorskip("sympy")

if TYPE_CHECKING:
    from pathlib import Path

    Capture = pytest.CaptureFixture[str]


def test_the_options_are_those_of_the_library() -> None:
    assert command.WHAT == symbolic.QUANTITIES
    assert command.FORMATS == symbolic.FORMATS
    assert command.FORMS == symbolic.FORMS


def test_without_sympy_it_names_the_command(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    from ravengc.symbolic import algebra

    monkeypatch.setitem(sys.modules, "sympy", None)
    algebra.engine.cache_clear()
    try:
        assert "needs the package 'sympy': pip install 'ravengc[symbolic]'" in refusal(capsys, "symbolic", "rrbot")
    finally:
        algebra.engine.cache_clear()


def printed(capsys: Capture, *options: str, code: int = 0) -> str:
    assert main(["symbolic", *options]) == code
    return capsys.readouterr().out


def test_the_textbook(capsys: Capture) -> None:
    out = printed(capsys, "rrbot", "--level", "--lengths")
    assert out.endswith("tau2 = -g*m2*(a2 + cx2)*sin(q1 + q2)\n")
    assert "# checked: against the core in 5 random states: largest difference " in out
    assert "# mass, kg: m1 = 1.0, m2 = 1.0\n" in out


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--format", "latex", "--level"), r"\tau_{2} &= -g \, m_{2} \,"),
        (("--format", "python"), "def rrbot_gravity(q, g, parameters=PARAMETERS):"),
        (("--format", "c", "--numbers"), "void rrbot_gravity(const double q[2], const double g[3], double tau[2])"),
        (("--what", "kinematics", "--frame", "link1"), "T[1,4] = 0.9*sin(q1)"),
        (("--right-angles", "0.01 deg"), "within 0.000174533 rad of right angles"),
        (("--what", "jacobian"), "J[1,2] = 0.9*cos(q1 + q2)"),
        (("--what", "regressor", "--gravity", "0", "0", "-9.81"), "Y[2,6] = -9.81*sin(q1 + q2)"),
        (("--what", "inverse-dynamics", "--moving-base", "--form", "steps"), "dwy"),
        (("--what", "inverse-dynamics-regressor", "--level"), "pi = m1 hx1"),
        (("--mass-set", "box", "--what", "inverse-dynamics"), "Izz1 = 0.0841666666667"),
    ],
)
def test_every_option(capsys: Capture, options: tuple[str, ...], expected: str) -> None:
    assert expected in printed(capsys, "rrbot", *options)


def test_a_file_of_c_is_whole_and_runs(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "new" / "gravity.c"
    out = printed(capsys, "rrbot", "--numbers", "--level", "--format", "c", "-o", str(file), "--check", "20")
    assert out.startswith(f"{file}: gravity of rrbot, checked against the core in 20 random states: largest")
    assert [path.name for path in file.parent.iterdir()] == ["gravity.c"]
    tau = compiled(file.read_text(encoding="utf-8"), "rrbot_gravity", (2,), tmp_path)([0.3, 0.5], 9.81)
    assert tau == pytest.approx([-7.080, -3.167], abs=5e-4)


def test_json_is_one_object(capsys: Capture) -> None:
    about = json.loads(printed(capsys, "rrbot", "--level", "--json", "--format", "c", "--check", "3"))
    assert about["entries"]["tau2"] == "-m2*x1*x4" or about["steps"]
    assert about["check"]["states"] == 3
    assert about["check"]["largest_difference"] < 1e-12
    assert about["inputs"] == {"q": ["q1", "q2"], "g": ["g"]}
    assert about["text"].startswith("/*\n * rrbot: torques")
    assert about["file"] is None


def test_what_the_core_does_not_compute_is_not_printed(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    wrong = symbolic.Check(states=5, difference=0.1, largest=10.0)
    monkeypatch.setattr(symbolic, "check", lambda *_: wrong)
    assert main(["symbolic", "rrbot", "-o", str(tmp_path / "wrong.txt")]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "not what the core computes, against the core in 5 random states: largest difference 0.1" in captured.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("nobody",), "nobody"),
        (("rrbot", "--frame", "hand"), "frame 'hand' is unknown"),
        (("rrbot", "--check", "0"), "states is 0; expected a whole number from 1"),
        (("rrbot", "--moving-base"), "moving_base is for inverse dynamics"),
        (("rrbot", "--gravity", "0", "0", "9.8 N"), "--gravity"),
        (("rrbot", "-o", "/dev/null/x"), "cannot be written"),
        (("panda", "--what", "inverse-dynamics", "--form", "closed"), "choose 'steps' or 'auto'"),
    ],
)
def test_bad_input_is_told(capsys: Capture, options: tuple[str, ...], message: str) -> None:
    assert message in refusal(capsys, "symbolic", *options)


@pytest.mark.parametrize("options", [("--level", "--moving-base"), ("--what", "mass"), ("--format", "f77")])
def test_what_cannot_be_meant_is_refused_at_once(capsys: Capture, options: tuple[str, ...]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["symbolic", "rrbot", *options])
    assert "error: argument" in capsys.readouterr().err
