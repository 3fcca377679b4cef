"""``ravengc reproduce``: files, report, exit codes, misuse."""

from __future__ import annotations

import json
import os
import re
import signal
import time
from html.parser import HTMLParser
from typing import TYPE_CHECKING

import pytest

from command_line import begun, gone, living, refusal
from ravengc.cli import main
from ravengc.cli.reproduce import NAMES
from ravengc.experiments import EXPERIMENTS

if TYPE_CHECKING:
    import subprocess
    from pathlib import Path

pytest.importorskip("matplotlib")

QUICK = ("moving-base-terms", "ship")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The message of bad input."""
    return refusal(capsys, "reproduce", *words)


class Page(HTMLParser):
    """What a page loads from elsewhere, its open elements, and what is linked inside."""

    VOID = frozenset({"meta", "img", "br", "link"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sources: list[str] = []
        self.anchors: set[str] = set()
        self.names: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        assert tag not in {"script", "link", "iframe"}
        for key, value in attrs:
            if key in {"src", "href"}:
                (
                    self.anchors.add((value or "")[1:])
                    if (value or "").startswith("#")
                    else self.sources.append(value or "")
                )
            if key == "id":
                self.names.add(value or "")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_names_are_those_of_the_experiments() -> None:
    assert tuple(EXPERIMENTS) == NAMES


def test_report_pictures_and_numbers(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", *QUICK, "--jobs", "1"]) == 0
    out = folder / "out" / "reproduce"
    assert {path.name for path in out.iterdir()} == {
        "report.html", "results.json", *(f"{name}{suffix}" for name in QUICK for suffix in (".png", ".svg")),
    }  # fmt: skip
    assert "report: out/reproduce/report.html" in capsys.readouterr().out
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert results["holds"] is True
    assert results["experiments"]["ship"]["numbers"]["full_j1"] == pytest.approx(0.0, abs=1e-9)


def test_the_report_is_whole_and_needs_nothing_else(folder: Path) -> None:
    assert main(["reproduce", *QUICK, "--jobs", "1"]) == 0
    text = (folder / "out" / "reproduce" / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    assert len(page.sources) == len(QUICK)
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert page.anchors <= page.names == set(QUICK)
    assert not re.search(r"url\(|@import|https?://", text)
    for phrase in ("the paper states", "we get", "verdict", "ravengc reproduce ship", "roll_deg", "reproduced"):
        assert phrase in text


def test_json_is_one_object(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "ship", "--json", "--jobs", "1"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    about = json.loads(printed.out)
    ship = about["experiments"]["ship"]
    assert ship["settings"]["roll_deg"] == 10.0
    assert all(finding["holds"] for finding in ship["findings"])
    assert "out/reproduce/report.html" in about["files"]


def test_a_missed_number_is_exit_code_1(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("ravengc.experiments.ship.LEVEL_TORQUE", (0.0, -26.0, 8.4105, 0.0124, 0.0357, 0.0))
    assert main(["reproduce", "ship", "--jobs", "1"]) == 1
    assert "1 numbers are outside their tolerance" in capsys.readouterr().out
    assert "1 of " in (folder / "out" / "reproduce" / "report.html").read_text(encoding="utf-8")


def test_settings_of_a_file_are_used(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "my.toml").write_text("[ship]\nroll_deg = 0.0\npitch_deg = 0.0\n", encoding="utf-8")
    assert main(["reproduce", "ship", "--settings", "my.toml", "--json", "--jobs", "1"]) == 0
    numbers = json.loads(capsys.readouterr().out)["experiments"]["ship"]["numbers"]
    assert numbers["accelerometer_j2"] == pytest.approx(0.0, abs=1e-9)
    assert numbers["tilt_j2"] == pytest.approx(numbers["sg_j2"])


def test_settings_can_be_listed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--list-settings"]) == 0
    printed = capsys.readouterr().out
    assert all(f"[{name}]" in printed for name in EXPERIMENTS)
    assert main(["reproduce", "rocking", "--list-settings", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rocking"]
    assert {"key": "hz", "value": 1.0, "unit": "Hz"}.items() <= next(r for r in rows if r["key"] == "hz").items()
    assert list(folder.iterdir()) == []


def test_misuse_is_refused_before_anything_is_run(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "there is no experiment 'rock'; did you mean 'rocking'? (choose" in refused(capsys, "rock")
    assert "none.toml: cannot be read" in refused(capsys, "ship", "--settings", "none.toml")
    (folder / "my.toml").write_text("[ship]\nroll_deg = -1\n", encoding="utf-8")
    assert "roll_deg is -1; expected a number from 0 to 45 deg" in refused(capsys, "ship", "--settings", "my.toml")
    (folder / "my.toml").write_text("[rocking]\nhz = 2.0\n", encoding="utf-8")
    said = refused(capsys, "ship", "base-wrench", "--settings", "my.toml")
    assert "my.toml: has tables for 'rocking' and none for what is run; expected [ship], [base-wrench]" in said
    (folder / "taken").write_text("", encoding="utf-8")
    assert "'taken' is not a folder" in refused(capsys, "ship", "--out", "taken").replace(str(folder) + "/", "")
    with pytest.raises(SystemExit, match="2"):
        main(["reproduce", "--jobs", "0"])
    assert sorted(path.name for path in folder.iterdir()) == ["my.toml", "taken"]


def at_work(folder: Path) -> subprocess.Popen[bytes]:
    """The command with two processes that compute."""
    process = begun(folder, "reproduce", "rocking", "--jobs", "2")
    deadline = time.monotonic() + 60.0
    while len(living(process.pid)) < 3 and time.monotonic() < deadline:
        time.sleep(0.1)
    time.sleep(1.0)
    return process


def test_ctrl_c_leaves_no_files_and_no_processes(folder: Path) -> None:
    pytest.importorskip("mujoco")
    process = at_work(folder)
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60.0)
    assert process.returncode == 130
    assert said == b""
    assert list(folder.iterdir()) == []
    gone(process.pid)


def test_killed_it_leaves_no_processes(folder: Path) -> None:
    pytest.importorskip("mujoco")
    process = at_work(folder)
    assert len(living(process.pid)) >= 3
    process.kill()
    process.communicate(timeout=60.0)
    gone(process.pid)
