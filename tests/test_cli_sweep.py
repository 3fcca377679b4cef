"""``ravengc sweep``: files, picture, exit codes, and what is left when it is killed or stopped."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from command_line import begun, gone, refusal
from ravengc.cli import main
from ravengc.cli.sweep import EXAMPLES
from ravengc.errors import ConfigError
from ravengc.reports.sweep_plot import _axis, _chosen, check_against, plot_sweep
from ravengc.sweep import Draw, read_draw, read_points, sweep
from sweep_toy import TOY, Toy

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Iterator
    from pathlib import Path

pytest.importorskip("mujoco")

TINY = ("--grid", "duration_s=1", "--jobs", "1")
COMMANDS = EXAMPLES.split("\n\n")[0].replace("\\\n", "").splitlines()
SIZES = {"ship": TINY, "base-wrench": ("--grid", "states=1", "--grid", "samples=16"), "moving-base-terms": ()}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The message of bad input."""
    return refusal(capsys, "sweep", *words)


def tables(folder: Path) -> list[bytes]:
    """Bytes of what a sweep leaves."""
    return [path.read_bytes() for path in sorted(folder.glob("sweep.*"))]


# The command


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """The address of a Dask cluster of one thread."""
    distributed = pytest.importorskip("distributed", reason="distributed is not installed")
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:
        yield cluster.scheduler_address


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("line", COMMANDS)
def test_the_examples_of_the_help_run(line: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    if "--plot" in line:
        pytest.importorskip("matplotlib")
    words = shlex.split(line)[1:] + list(SIZES[shlex.split(line)[2]])
    if "--dask" in words:
        words[words.index("--dask") + 1] = request.getfixturevalue("scheduler")
        words += ["--grid", "samples=16"]
    assert main(words) == 0
    assert list(tmp_path.glob("out/**/sweep.csv"))
    assert bool(list(tmp_path.glob("out/*.png"))) == ("--plot" in line)


def test_tables_and_what_is_printed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sweep", "ship", "--grid", "roll_deg=0,10", "--number", "sg_j2", "--number", "tilt_j2", *TINY]
    assert main(words) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "ship: 2 trials over roll_deg, duration_s" in printed.out
    assert re.search(r"sg_j2 +[\d.]+ +roll_deg=10 +[\d.]+ +roll_deg=0 ", printed.out)
    assert "tilt_j2" in printed.out
    assert "sg_j1" not in printed.out
    assert "out/sweep/ship/sweep.csv" in printed.out
    header = (folder / "out" / "sweep" / "ship" / "sweep.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.startswith("trial,roll_deg,duration_s,error,sg_j1,")
    assert main([*words, "--best", "largest"]) == 0
    printed = capsys.readouterr()
    assert printed.err == "2 of 2 trials are in out/sweep/ship already\n"
    assert re.search(r"sg_j2 +[\d.]+ +roll_deg=0 +[\d.]+ +roll_deg=10 ", printed.out)


def test_json_is_one_object(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "ship", "--random", "roll_deg=0:9", "--trials", "3", "--seed", "5", *TINY, "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    about = json.loads(printed.out)
    assert (about["trials"], about["already"], about["failed"], about["errors"], about["seed"]) == (3, 0, 0, {}, 5)
    assert about["swept"] == ["duration_s", "roll_deg"]
    number = about["numbers"]["tilt_j2"]
    assert number["best"] <= number["mean"] <= number["worst"]
    assert 0.0 <= number["best_at"]["roll_deg"] <= 9.0
    assert "out/sweep/ship/sweep.csv" in about["files"]


def test_failed_trials_are_exit_code_1(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sweep", "rocking", "--grid", "low_deg=30,40", "--grid", "high_deg=20", "--jobs", "1"]
    assert main(words) == 1
    printed = capsys.readouterr().out
    assert "trial 0: low_deg is 30; expected less than high_deg, 20" in printed
    assert "2 of 2 trials failed" in printed
    assert main([*words, "--json"]) == 1
    about = json.loads(capsys.readouterr().out)
    assert about["failed"] == 2
    assert list(about["errors"]) == ["0", "1"]
    assert about["numbers"] == {}


def test_settings_of_a_file_are_those_of_every_trial(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "my.toml").write_text("[ship]\nduration_s = 1.0\nroll_deg = 0.0\n", encoding="utf-8")
    words = ["sweep", "ship", "--grid", "pitch_deg=0,1", "--settings", "my.toml", "--jobs", "1", "--json"]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["numbers"]["accelerometer_j2"]["best_at"] == {"pitch_deg": 0.0}
    about = json.loads((folder / "out" / "sweep" / "ship" / "sweep.json").read_text(encoding="utf-8"))
    assert about["settings"]["roll_deg"] == 0.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("ship", "nothing to sweep: give --grid KEY=A:B:N, --random"),
        ("shp --grid roll_deg=0,1", "there is no experiment 'shp'; did you mean 'ship'?"),
        ("ship --grid rol_deg=0,1", "grid: ship has no setting 'rol_deg'; did you mean 'roll_deg'?"),
        ("ship --grid roll_deg=0:90:4", "grid: roll_deg is 60.0; expected a number from 0 to 45 deg"),
        ("ship --grid roll_deg=0,1 --grid roll_deg=2", "--grid: roll_deg is given twice"),
        ("ship --grid roll_deg=0,1 --random roll_deg=0:1", "roll_deg is both in the grid and drawn at random"),
        ("ship --random roll_deg=0:90", "random: roll_deg is 90.0; expected a number from 0 to 45 deg"),
        ("ship --random roll_deg=9:0", "random: roll_deg: draws from 9 to 0"),
        ("ship --grid roll_deg=0,1 --trials 0", "trials is 0; expected a whole number from 1 to 1000000"),
        ("ship --grid roll_deg=0,1 --trials 2", "2 trials at every point would all be the same"),
        ("ship --grid roll_deg=0,1 --seed -1", "seed is -1; expected a whole number from 0"),
        ("ship --grid roll_deg=0,1 --jobs 0", "jobs is 0; expected a whole number from 1 to 1024"),
        ("ship --grid roll_deg=0:9:2000 --grid heave=0:9:2000", "4000000 trials (grid 2000 x 2000, 1 at every point)"),
        ("ship --grid roll_deg=0,1 --settings none.toml", "none.toml: cannot be read"),
        ("ship --grid roll_deg=0,1 --out taken", "taken"),
        ("ship --grid roll_deg=0,1 --plot x.bmp", "x.bmp: unknown kind of picture"),
        ("ship --grid roll_deg=0,1 --plot x.png --against heave", "'heave' is not swept (swept: 'roll_deg')"),
        ("ship --grid roll_deg=0,1 --dask nonsense://x", "no Dask scheduler at 'nonsense://x'"),
    ],
)
def test_misuse_is_refused(folder: Path, capsys: pytest.CaptureFixture[str], words: str, said: str) -> None:
    if "--dask" in words:
        pytest.importorskip("distributed", reason="distributed is not installed")
    if "--plot" in words:
        pytest.importorskip("matplotlib")
    (folder / "taken").write_text("", encoding="utf-8")
    assert said in refused(capsys, *words.split())
    assert [path.name for path in folder.iterdir()] == ["taken"]


def test_a_number_that_does_not_exist_costs_no_trial(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("ship", "--grid", "roll_deg=0,1", *TINY)
    assert "ship has no number 'tilt_j9'; did you mean 'tilt_j" in refused(capsys, *words, "--number", "tilt_j9")
    assert main(["sweep", *words, "--number", "tilt_j2"]) == 0
    assert "2 of 2 trials are in" in capsys.readouterr().err


def test_options_that_exclude_each_other() -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["sweep", "ship", "--grid", "roll_deg=0,1", "--jobs", "1", "--dask", "tcp://x:1"])


# Killed and stopped


LONG = ("ship", "--grid", "roll_deg=0:20:4", "--random", "heave=0:2", "--trials", "3", "--out", "swept")


def started(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    """The command in a group of its own, when it has finished some of its trials."""
    process = begun(folder, "sweep", *words)
    journal, deadline = folder / "swept" / "journal.jsonl", time.monotonic() + 120.0
    while not (journal.exists() and journal.read_bytes().count(b"\n") >= 3):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)
    return process


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_killed_sweep_goes_on(folder: Path, capsys: pytest.CaptureFixture[str], jobs: str) -> None:
    process = started(folder, *LONG, "--jobs", jobs)
    process.kill()
    process.communicate()
    gone(process.pid)
    kept = (folder / "swept" / "journal.jsonl").read_bytes().count(b"\n")
    assert 3 <= kept < 12
    assert main(["sweep", *LONG, "--jobs", "2" if jobs == "1" else "1", "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == f"{kept} of 12 trials are in swept already\n"
    assert json.loads(printed.out)["already"] == kept
    assert main(["sweep", *LONG[:-1], "again", "--jobs", "1"]) == 0
    assert tables(folder / "swept") == tables(folder / "again")


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_says_how_to_go_on(folder: Path, jobs: str) -> None:
    process = started(folder, *LONG, "--jobs", jobs)
    os.killpg(process.pid, signal.SIGINT)
    out, said = process.communicate(timeout=60.0)
    assert process.returncode == 130
    assert out == b""
    kept = (folder / "swept" / "journal.jsonl").read_bytes().count(b"\n")
    assert said.decode() == f"ravengc: stopped: {kept} finished trials are in swept; the same command goes on\n"
    gone(process.pid)


# What is typed


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("x=0:1:3", [0.0, 0.5, 1.0]),
        ("x=0:1:11", [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]),
        ("x=5:1:2", [5.0, 1.0]),
        ("y=0.01:100:5:log", [0.01, 0.1, 1.0, 10.0, 100.0]),
        ("x=1,2.5, 3e0", [1.0, 2.5, 3.0]),
        ("n=1:5:3", [1, 3, 5]),
        ("n=4,2e0", [4, 2]),
        ("kind=plain,odd", ["plain", "odd"]),
        ("flag=true,false", [True, False]),
        ("many=1,2/3,4/5/6", [1.0, (2.0, 3.0), (4.0, 5.0, 6.0)]),
        ("pair=1/2,3/4", [(1.0, 2.0), (3.0, 4.0)]),
        ("seed=9223372036854775807", [2**63 - 1]),
        (" x = 1", [1.0]),
    ],
)
def test_grids_as_typed(text: str, values: list[Any]) -> None:
    assert read_points(TOY, text) == (text.partition("=")[0].strip(), values)
    assert [type(value) for value in read_points(TOY, text)[1]] == [type(value) for value in values]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x", "grid: 'x'; expected key=from:to:count, key=from:to:count:log or key=value,value,..."),
        ("=1", "grid: '=1'; expected key="),
        ("x=", "grid: 'x='; expected key="),
        ("x=1:2", "grid: 'x=1:2'; expected key="),
        ("x=1:2:1", "the count is '1'; expected a whole number from 2 to 1000000"),
        ("x=1:2:1000001", "the count is '1000001'"),
        ("x=1:2:3.5", "the count is '3.5'"),
        ("x=1:2:3:lin", "grid: 'x=1:2:3:lin'; expected key="),
        ("x=0:2:3:log", "a logarithmic range needs positive ends"),
        ("x=a:2:3", "'a' is not a finite number"),
        ("x=1,,2", "grid: x: '' is not a finite number"),
        ("x=1_0", "'1_0' is not a finite number"),
        ("x=nan", "'nan' is not a finite number"),
        ("x=1/2", "'1/2' is not a finite number"),
    ],
)
def test_grids_that_are_none(text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        read_points(TOY, text)


def test_draws_as_typed() -> None:
    assert read_draw(TOY, "x=0:1") == ("x", Draw(0.0, 1.0))
    assert read_draw(TOY, "y=1e-2:1:log") == ("y", Draw(0.01, 1.0, log=True))
    key, draw = read_draw(TOY, "n=1:5")
    assert (key, type(draw.low), draw.high) == ("n", int, 5)


@pytest.mark.parametrize("text", ["x", "x=1", "x=1:2:3", "x=1:2:log:log", "x=:2", "x=1:2:", "x=2:1", "x=a:1", "xx=1:2"])
def test_draws_that_are_none(text: str) -> None:
    with pytest.raises(ConfigError, match="random: "):
        read_draw(TOY, text)


# The picture


PICTURES: dict[str, dict[str, Any]] = {
    "curve": {"grid": {"x": [1.0, 2.0, 3.0]}, "trials": 3},
    "lines": {"grid": {"x": [1.0, 2.0, 3.0], "kind": ["plain", "odd"]}},
    "map": {"grid": {"x": [1.0, 2.0, 3.0], "n": [1, 2, 3, 4, 5, 6]}},
    "dots": {"random": {"x": Draw(1.0, 2.0)}, "trials": 60},
    "few dots": {"random": {"x": Draw(1.0, 2.0)}, "trials": 3},
    "coloured dots": {"random": {"x": Draw(1.0, 2.0), "y": Draw(0.01, 100.0, log=True)}, "trials": 30},
    "grid and draws": {"grid": {"flag": [True, False]}, "random": {"x": Draw(1.0, 9.0)}, "trials": 30},
    "lists": {"grid": {"pair": [(1.0, 2.0), (3.0, 4.0)]}},
    "seeds": {"trials": 30},
    "failures": {"grid": {"n": [12, 13, 14]}},
}


@pytest.mark.parametrize("kind", PICTURES)
@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_pictures(folder: Path, kind: str, suffix: str) -> None:
    pytest.importorskip("matplotlib")
    table = sweep(TOY, out=folder / "swept", **PICTURES[kind])
    plot_sweep(folder / f"x.{suffix}", table, number="dice" if kind == "seeds" else None)
    assert (folder / f"x.{suffix}").stat().st_size > 5000


def test_what_varies_is_drawn(folder: Path) -> None:
    table = sweep(TOY, out=folder, grid={"x": [1.0], "kind": ["plain", "odd"], "n": [1, 2]}, settings=Toy(y=1.0))
    assert _chosen(table, None) == ["kind", "n"]
    axis = _axis(table, "kind", np.ones(4, dtype=bool))
    assert (axis.names, axis.at.tolist(), axis.label) == (("plain", "odd"), [0.0, 0.0, 1.0, 1.0], "kind")
    assert _axis(table, "x", np.ones(4, dtype=bool)).label == "x, m"


def test_pictures_of_nothing(folder: Path) -> None:
    pytest.importorskip("matplotlib")
    table = sweep(TOY, out=folder / "a", grid={"n": [1, 2]})
    for arguments, said in [
        ({"number": "nothing"}, "nothing is finite in no trial; there is nothing to draw"),
        ({"number": "dic"}, "toy has no number 'dic'; did you mean 'dice'"),
        ({"against": ["x"]}, "'x' is not swept"),
        ({"against": ["n", "n"]}, "expected one or two different settings"),
    ]:
        with pytest.raises(ConfigError, match=said):
            plot_sweep(folder / "x.png", table, **arguments)
    failed = sweep(TOY, out=folder / "b", grid={"n": [13]})
    with pytest.raises(ConfigError, match=r"toy has no number .*no trial has any number"):
        plot_sweep(folder / "x.png", failed)
    with pytest.raises(ConfigError, match="expected one or two"):
        check_against(("a", "b", "c"), ("a", "b", "c"))
    assert not (folder / "x.png").exists()
