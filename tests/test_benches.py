"""Every Python bench runs, in its smallest form, and its tables and files are whole. No time is asserted."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

ROOT = Path(__file__).parents[1]
BENCHES = ROOT / "benches"
CARGO = pytest.mark.skipif(shutil.which("cargo") is None, reason="cargo is not installed")


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., tuple[str, Any]]:
    """Runs a bench that must succeed, and gives what it printed and what it wrote."""

    def run(name: str, *options: str) -> tuple[str, Any]:
        file = tmp_path / "results.json"
        done = execute(name, *options, "--json", str(file))
        assert done.returncode == 0, done.stderr
        assert f"written to {file}" in done.stdout
        assert "…" not in done.stdout  # no cell of a table is cut
        return done.stdout, json.loads(file.read_text())

    return run


def execute(name: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(BENCHES / f"{name}.py"), *options]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)  # noqa: S603


def test_no_bench_is_forgotten() -> None:
    scripts = {path.stem for path in BENCHES.glob("*.py") if "__main__" in path.read_text()}
    made = re.findall(r"^BENCHES := (.*)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert set(made[0].split()) == scripts
    assert {name for name in scripts if f'("{name}", ' in Path(__file__).read_text()} == scripts


def test_make_hides_no_failure() -> None:
    assert not re.findall(r"^\t@?-.*", (ROOT / "Makefile").read_text(), re.MULTILINE)


def test_what_is_left_out_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "broken.py").write_text("raise ImportError('libboost.so.1.87.0: cannot open shared object file')")
    monkeypatch.syspath_prepend(tmp_path)
    left_out = named("comparison.libraries", monkeypatch).left_out
    assert left_out("nowhere") == "nowhere is not installed: left out"
    assert left_out("broken") == (
        "broken is installed, but does not import: libboost.so.1.87.0: cannot open shared object file"
    )
    assert left_out("json") is None


def named(module: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(BENCHES)
    return import_module(module)


def present(results: Any, library: str) -> bool:
    """Whether the library took part; if not, a note says why."""
    said = [note for note in results["notes"] if note.startswith(f"{library} is ")]
    assert all(": " in note for note in said)
    assert said or find_spec(library) is not None
    return not said


def test_peers(run: Callable[..., tuple[str, Any]], monkeypatch: pytest.MonkeyPatch) -> None:
    printed, found = run("peers", "--smallest")
    operations = named("comparison.call", monkeypatch).OPERATIONS
    libraries = named("comparison.libraries", monkeypatch).LIBRARIES
    for library in libraries:
        taken = {row["operation"] for row in found["hot"] if row["library"] == library}
        assert ("gravity" in taken) == present(found, library)
    assert {row["operation"] for row in found["hot"] if row["library"] == "ravengc"} == set(operations)
    assert all(row["off"] <= 1e-10 for row in found["hot"])
    for part in (*found["paced"], *found["paced_control"]):
        assert part["alone"].keys() == part["among"].keys() == {"p10_us", "p50_us", "p99_us", "times_bind"}
    assert all(bar["holds"] in {True, False, None} for bar in found["bars"])
    assert {"ravengc, 1 thread", "numpy, vectorised"} < {row["how"] for row in found["batch"]["rates"]}
    assert found["imports"].keys() >= {"numpy", "ravengc"}
    for title in (*(f"Hot loop: {title}" for title in operations.values()), "Paced at 1 kHz", "Batch of", "Bars"):
        assert title in printed


def test_rates(run: Callable[..., tuple[str, Any]], monkeypatch: pytest.MonkeyPatch) -> None:
    printed, found = run("rates", "--smallest")
    for part, (_, module, table) in named("rates", monkeypatch).PARTS.items():
        for library in getattr(named(f"comparison.stepping.{module}", monkeypatch), table):
            assert any(row["key"].startswith(f"{part}/{library}/") for row in found["rows"]) == present(found, library)
    for row in found["rows"]:
        checked = (row["error_left"], 0.99) if row["error_left"] is not None else (row["cost_above_best"], 1e-5)
        assert checked[0] < checked[1], row
    assert {row["key"] for row in found["paced"]} >= set(named("rates", monkeypatch).BARS)
    assert "µs per call" in printed
    assert "µs per step once per millisecond" in printed


def test_manipulability(run: Callable[..., tuple[str, Any]]) -> None:
    printed, found = run("manipulability", "--problems", "3")
    assert {name: set(one) for name, one in found["summary"].items()} == {
        arm: {"plain", "theirs", "ours"} for arm in ("panda", "ur5")
    }
    assert all(len(runs) == 3 for arm in found["runs"].values() for runs in arm.values())
    assert "no velocity limit exceeded: held" in printed


def test_singular_poses() -> None:
    done = execute("singular_poses", "--poses", "100")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(" 100 ") == 15  # five ways of damping, three of keeping limits


def test_stability(run: Callable[..., tuple[str, Any]]) -> None:
    printed, found = run("stability", "--cases", "10")
    assert sum(kind["cases"] for kind in found["kinds"]) == 10
    assert "as set: late sensor, light damping" in printed


def test_predictions() -> None:
    done = execute("predictions", "--seeds", "0")
    assert done.returncode == 0, done.stderr
    assert "RMS error, 3-D, mm" in done.stdout
    assert "the switch to hold: worst" in done.stdout


def test_identify() -> None:
    done = execute("identify", "ranks", "mtm", "regressor", "--data", "nowhere")
    *lines, last = done.stdout.splitlines()
    rows = dict(line.split(None, 1) for line in lines)
    assert rows.keys() == {"ranks", "mtm", "regressor"}, done.stderr
    assert last == "1 of 3 rows were left out for want of data: nothing is said of them"
    assert rows["ranks"].startswith("holds: ")
    assert rows["mtm"] == "left out: nowhere/dvrk/dvrk_real.npz is not there"
    assert "pinocchio" in rows["regressor"]


@CARGO
def test_faults(run: Callable[..., tuple[str, Any]]) -> None:
    printed, found = run("faults", "--smallest")
    assert found["seeds"] == 4
    assert {kind["class"] for kind in found["kinds"]} == {"Hard", "Harmless", "Partial", "Hidden"}
    assert len(found["required"]) == 7
    assert "Faults that show" in printed


@CARGO
def test_native(run: Callable[..., tuple[str, Any]]) -> None:
    printed, found = run("native", "--smallest")
    assert len(found["rows"]) == 12
    assert ("pinocchio" in found["rows"][0]) != any("left out" in note for note in found["notes"])
    assert "computeGeneralizedGravity" in printed


@CARGO
def test_instructions(run: Callable[..., tuple[str, Any]]) -> None:
    if shutil.which("valgrind") is None:
        assert "valgrind is not installed" in execute("instructions").stdout
        return
    printed, found = run("instructions", "--only", "gravity_torque", "--smallest")
    assert {row["joints"] for row in found} == {3, 6, 7}
    assert all(row["instructions"] > 0.0 for row in found)
    assert "Instructions per call" in printed


@pytest.mark.parametrize("inputs", ["along_a_path", "anywhere"])
def test_in_half_of_the_raced_steps_a_joint_is_at_its_limit(inputs: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = named("comparison.stepping.scene", monkeypatch)
    programme = getattr(scenes, inputs)().programme
    beyond = [bool((abs(scenes.damped(one.rows, one.target)) > one.upper).any()) for one in programme]
    assert 0.4 < sum(beyond) / len(beyond) < 0.6


def test_bars_are_judged_by_the_median_and_show_the_fastest_tenth_and_the_peer(monkeypatch: pytest.MonkeyPatch) -> None:
    bars = named("comparison.bars", monkeypatch)
    hot = [
        {"library": "ravengc", "operation": "gravity", "way": "bind", "median_us": 0.3, "fast_us": 0.2},
        {
            "library": "pinocchio",
            "operation": "gravity",
            "way": "",
            "median_us": 3.0,
            "fast_us": 2.6,
            "times_bind": 11.0,
        },
    ]
    found = next(bar for bar in bars.ratios(hot) if bar["name"].startswith("gravity, bind"))
    assert (found["measured"], found["fast"]) == (11.0, pytest.approx(13.0))  # of 12 wanted
    assert (found["peer"], found["peer_fast"], found["holds"]) == (3.0, 2.6, False)
    missing = bars.ratios([])[0]
    assert [missing[key] for key in ("measured", "fast", "peer", "peer_fast", "holds")] == [None] * 5
