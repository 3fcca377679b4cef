"""Sweeps: the same table however they are run, nothing lost when they are stopped, nothing mixed up, misuse refused."""

from __future__ import annotations

import csv
import json
import math
import os
import pickle
import sys
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ravengc.errors import ConfigError, MissingExtraError, ParseError, RavenGCError
from ravengc.sweep import Draw, Progress, SweepTable, dask, processes, read_sweep, summarise, sweep
from ravengc.sweep.journal import Journal, Result, read_journal
from ravengc.sweep.plan import plan_sweep
from ravengc.sweep.running import _run_trial
from sweep_toy import TOY, UNSEEDED, Plain, Toy

if TYPE_CHECKING:
    from collections.abc import Callable

WHOLE: dict[str, Any] = {
    "grid": {"n": [2, 3, 13], "kind": ["plain", "odd"], "pair": [(1.0, 2.0), (0.0, 9.0)]},
    "random": {"x": Draw(0.0, 1.0), "y": Draw(0.01, 100.0, log=True), "many": Draw(1.0, 2.0)},
    "trials": 2,
    "seed": 7,
}


def tables(folder: Path) -> tuple[bytes, ...]:
    """Bytes of what a sweep leaves."""
    return tuple(path.read_bytes() for path in sorted(folder.glob("sweep.*")))


def same(one: SweepTable, other: SweepTable) -> bool:
    """Whether two tables are the same, bit by bit."""
    return pickle.dumps({**one.columns}) == pickle.dumps({**other.columns})


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, ...]:
    """Tables of the sweep ``WHOLE``, run in this process at one go."""
    folder = tmp_path_factory.mktemp("whole")
    sweep(TOY, out=folder, **WHOLE)
    return tables(folder)


class Backwards(Executor):
    """Runs what it was given when the fifth call comes, the last one first, and then everything at once."""

    def __init__(self) -> None:
        self.held: list[tuple[Future[Any], Callable[..., Any], tuple[Any, ...]]] | None = []

    def submit(self, function: Callable[..., Any], /, *args: Any, **_: Any) -> Future[Any]:
        future: Future[Any] = Future()
        calls = [(future, function, args)]
        if self.held is not None:
            self.held += calls
            calls = self.held[::-1] if len(self.held) == 5 else []
            self.held = None if calls else self.held
        for waiting, called, arguments in calls:
            waiting.set_result(called(*arguments))
        return future


# The trials


def test_a_trial_follows_from_seed_and_number_alone() -> None:
    plan = plan_sweep(TOY, random={"x": Draw(0, 1)}, trials=50, seed=3)
    longer = plan_sweep(TOY, grid={"n": [1, 2]}, random={"x": Draw(0, 1)}, trials=50, seed=3)
    assert [plan.changes(i) for i in range(50)] == [
        {key: value for key, value in longer.changes(i).items() if key != "n"} for i in range(50)
    ]
    expected = np.random.SeedSequence(3).spawn(50)[49].generate_state(1, np.uint64)[0] >> 1
    assert plan.changes(49)["seed"] == expected
    other = plan_sweep(TOY, random={"x": Draw(0, 1)}, trials=50, seed=4)
    seeds = [one.changes(i)["seed"] for one in (plan, other) for i in range(50)]
    assert len(set(seeds)) == 100


def test_a_grid_is_every_combination_and_the_last_key_turns_fastest() -> None:
    plan = plan_sweep(TOY, grid={"n": [1, 2], "x": [0.0, 5.0, 10.0]}, trials=2)
    assert plan.total == 12
    points = [(plan.changes(i)["n"], plan.changes(i)["x"]) for i in range(12)]
    assert points == [(n, x) for n in (1, 2) for x in (0.0, 5.0, 10.0) for _ in range(2)]


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.floats(0.0, 1.0, exclude_max=True), st.booleans())
def test_draws_stay_in_their_range(low: float, width: float, share: float, log: bool) -> None:
    draw = Draw(abs(low) + 1e-3 if log else low, (abs(low) + 1e-3 if log else low) + width, log)
    assert draw.low <= draw.value(share, whole=False) <= draw.high


@given(st.integers(1, 10**6), st.integers(1, 10**6), st.floats(0.0, 1.0, exclude_max=True), st.booleans())
def test_draws_of_whole_numbers_are_whole(low: int, width: int, share: float, log: bool) -> None:
    value = Draw(low, low + width, log).value(share, whole=True)
    assert isinstance(value, int)
    assert low <= value <= low + width


def test_draws_fill_their_range_evenly() -> None:
    random = {"n": Draw(1, 4), "x": Draw(2.0, 6.0), "y": Draw(0.01, 100.0, log=True)}
    plan = plan_sweep(TOY, random=random, trials=4000)
    drawn = [plan.changes(i) for i in range(4000)]
    counts = np.bincount([one["n"] for one in drawn], minlength=5)
    assert counts[0] == 0
    assert (abs(counts[1:] - 1000) < 150).all()
    assert np.mean([one["x"] for one in drawn]) == pytest.approx(4.0, abs=0.1)
    assert np.mean([math.log10(one["y"]) for one in drawn]) == pytest.approx(0.0, abs=0.1)


def test_a_swept_seed_is_the_trials_seed(tmp_path: Path) -> None:
    table = sweep(TOY, out=tmp_path, grid={"seed": [0, 2**62]})
    assert table.columns["dice"].tolist() == [0.0, 0.5]
    assert list(table.columns) == ["trial", "seed", "error", "product", "dice", "n"]


def test_other_settings_are_those_given(tmp_path: Path) -> None:
    table = sweep(TOY, out=tmp_path, grid={"x": [1.0, 2.0]}, settings=Toy(y=10.0, many=(1.0,)))
    assert table.columns["product"].tolist() == [10.0, 20.0]


# One table, however it is run


def test_the_table(whole: tuple[bytes, ...], tmp_path: Path) -> None:
    table = sweep(TOY, out=tmp_path, **WHOLE)
    assert tables(tmp_path) == whole
    assert (len(table), table.failed, table.swept) == (24, 8, ("n", "kind", "pair", "x", "y", "many"))
    assert table.numbers == ("product", "dice", "number/n", "only_two", "nothing", "endless")
    assert table.units["x"] == "m"
    failed = table.columns["n"] == 13
    assert [error != "" for error in table.columns["error"]] == failed.tolist()
    assert (np.isnan(table.columns["product"]) == failed).all()
    assert np.isfinite(table.columns["only_two"]).tolist() == (table.columns["n"] == 2).tolist()
    found = table.columns["x"] * table.columns["y"] * table.columns["many"]
    assert table.columns["product"][~failed].tolist() == found[~failed].tolist()


def test_csv_and_parquet_hold_the_table(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    table = sweep(TOY, out=tmp_path, **WHOLE)
    with (tmp_path / "sweep.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    parquet = pyarrow.read_table(tmp_path / "sweep.parquet").to_pydict()
    assert list(rows[0]) == list(parquet) == list(table.columns)
    for i, row in enumerate(rows):
        assert float(row["x"]) == parquet["x"][i] == table.columns["x"][i]
        assert int(row["seed"]) == parquet["seed"][i] == table.columns["seed"][i]
        assert row["error"] == parquet["error"][i] == table.columns["error"][i]
        assert [float(part) for part in row["pair"].split("/")] == parquet["pair"][i]
        assert row["nothing"] == ""
    assert rows[0]["endless"] == "-inf"
    assert rows[-1]["error"] == "thirteen brings\nbad luck"


def test_the_order_of_trials_does_not_matter(whole: tuple[bytes, ...], tmp_path: Path) -> None:
    sweep(TOY, out=tmp_path, executor=Backwards(), **WHOLE)
    assert (tmp_path / "journal.jsonl").read_text(encoding="utf-8").startswith('{"trial": 3,')
    assert tables(tmp_path) == whole


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_number_of_processes_does_not_matter(whole: tuple[bytes, ...], tmp_path: Path, jobs: int) -> None:
    with processes(jobs) as executor:
        sweep(TOY, out=tmp_path, executor=executor, **WHOLE)
    assert tables(tmp_path) == whole


@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_does_not_matter(whole: tuple[bytes, ...], tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="distributed is not installed")
    options = {"n_workers": 1, "threads_per_worker": 2, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, dask(cluster.scheduler_address) as executor:
        sweep(TOY, out=tmp_path, executor=executor, **WHOLE)
    assert tables(tmp_path) == whole


def test_more_trials_than_wait_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ravengc.sweep.running.AT_ONCE", 3)
    with ThreadPoolExecutor(2) as executor:
        table = sweep(TOY, out=tmp_path, grid={"x": np.linspace(0.0, 10.0, 40)}, executor=executor)
    assert table.columns["trial"].tolist() == list(range(40))


# Stopped and gone on with


@pytest.mark.parametrize("stop", [1, 5, 23])
def test_a_stopped_sweep_goes_on(whole: tuple[bytes, ...], tmp_path: Path, stop: int) -> None:
    seen: list[Progress] = []

    def interrupt(progress: Progress) -> None:
        seen.append(progress)
        if progress.done == stop:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(2) as executor, pytest.raises(KeyboardInterrupt):
        sweep(TOY, out=tmp_path, executor=executor, on_progress=interrupt, **WHOLE)
    kept = len(read_sweep(tmp_path, TOY))
    assert kept >= stop
    assert not list(tmp_path.glob("sweep.csv"))
    sweep(TOY, out=tmp_path, on_progress=seen.append, **WHOLE)
    assert seen[-1] == Progress(done=24, total=24, already=kept, failed=8)
    assert tables(tmp_path) == whole


def test_a_finished_sweep_runs_nothing_again(whole: tuple[bytes, ...], tmp_path: Path) -> None:
    sweep(TOY, out=tmp_path, **WHOLE)
    journal = (tmp_path / "journal.jsonl").read_bytes()
    (tmp_path / "sweep.csv").unlink()
    seen: list[Progress] = []
    sweep(TOY, out=tmp_path, on_progress=seen.append, **WHOLE)
    assert seen == [Progress(done=24, total=24, already=24, failed=8)]
    assert (tmp_path / "journal.jsonl").read_bytes() == journal
    assert tables(tmp_path) == whole


@pytest.mark.parametrize("cut", [1, 2, 30])
def test_a_torn_last_line_is_run_again(whole: tuple[bytes, ...], tmp_path: Path, cut: int) -> None:
    sweep(TOY, out=tmp_path, **WHOLE)
    journal = tmp_path / "journal.jsonl"
    os.truncate(journal, journal.stat().st_size - cut)
    assert len(read_sweep(tmp_path, TOY)) == 23
    sweep(TOY, out=tmp_path, **WHOLE)
    assert len(journal.read_bytes().splitlines()) == 24
    assert tables(tmp_path) == whole


def test_a_process_that_dies_costs_the_trials_at_work(tmp_path: Path) -> None:
    with (
        processes(1) as executor,
        pytest.raises(RavenGCError, match="the executor lost its workers: one may have needed"),
    ):
        sweep(TOY, out=tmp_path, grid={"n": [1, 2, 66, 3]}, executor=executor)
    assert read_sweep_of(tmp_path, 4) == {0, 1}


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (CancelledError(), "the executor lost its workers: .* goes on from there .CancelledError."),
        (BrokenExecutor("gone\nand more"), "the executor lost its workers: .* .gone.$"),
        (
            ModuleNotFoundError("No module named 'ravengc'"),
            "cannot run a trial: No module .*; expected ravengc .* there",
        ),
        (RuntimeError("Error during deserialization of the task graph."), "cannot run a trial: Error during"),
    ],
)
def test_an_executor_that_fails_is_told_from_a_trial(tmp_path: Path, error: Exception, said: str) -> None:
    class Failing(Executor):
        def submit(self, function: Callable[..., Any], /, *args: Any, **_: Any) -> Future[Any]:
            future: Future[Any] = Future()
            if args[2]["n"] == 3:
                future.set_exception(error)
            else:
                future.set_result(function(*args))
            return future

    with pytest.raises(RavenGCError, match=said):
        sweep(TOY, out=tmp_path, grid={"n": [1, 2, 3, 4]}, executor=Failing())
    assert {0, 1} <= read_sweep_of(tmp_path, 4) <= {0, 1, 3}


def test_a_bug_or_a_missing_package_is_no_failed_trial(tmp_path: Path) -> None:
    for folder, n, error in (("a", 77, MissingExtraError), ("b", 88, ZeroDivisionError)):
        with pytest.raises(error):
            sweep(TOY, out=tmp_path / folder, grid={"n": [1, n, 2]})
        with processes(1) as executor, pytest.raises(error):
            sweep(TOY, out=tmp_path / folder, grid={"n": [1, n, 2]}, executor=executor)
        assert 1 not in read_sweep_of(tmp_path / folder, 3)


def read_sweep_of(folder: Path, total: int) -> set[int]:
    return set(read_journal(folder / "journal.jsonl", total)[0])


def test_settings_that_do_not_fit_together_are_failed_trials(tmp_path: Path) -> None:
    table = sweep(TOY, out=tmp_path, grid={"x": [1.0, 9.0], "flag": [False, True]})
    assert table.columns["error"] == ["", "", "", "x and flag do not fit together"]


def test_a_worker_of_another_version_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"a worker has ravengc .*; expected ravengc 0.0, as the process that asks"):
        _run_trial(TOY, Toy(), {}, {"ravengc": "0.0"})


# Folders


def test_another_sweep_is_refused_with_what_differs(tmp_path: Path) -> None:
    arguments = {"grid": {"n": [1, 2], "x": [1.0]}, "random": {"y": Draw(1.0, 2.0)}, "seed": 1}
    sweep(TOY, out=tmp_path, **arguments)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for change, differs in [
        ({"seed": 2}, "seed is 1 there and 2 here"),
        ({"trials": 3}, "trials is 1 there and 3 here"),
        ({"grid": {"n": [1, 3], "x": [1.0]}}, r"grid.n is \[1, 2\] there and \[1, 3\] here"),
        ({"grid": {"x": [1.0], "n": [1, 2]}}, "the order of grid is n, x there and x, n here"),
        ({"grid": {"n": [1, 2]}}, r"grid.x is \[1.0\] there and absent here"),
        ({"random": {"y": Draw(1.0, 3.0)}}, "random.y.high is 2.0 there and 3.0 here"),
        ({"settings": Toy(many=[1.0])}, r"settings.many is \[1.0, 2.0\] there and \[1.0\] here"),
    ]:
        with pytest.raises(ConfigError, match=f"holds another sweep: {differs}"):
            sweep(TOY, out=tmp_path, **(arguments | change))
    with pytest.raises(ConfigError, match=r"holds another sweep: experiment is 'toy' there and 'plain' here. Choose"):
        sweep(UNSEEDED, out=tmp_path, grid={"x": [1.0]})
    assert before == {path.name: path.read_bytes() for path in tmp_path.iterdir()}


def test_another_version_is_another_sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep(TOY, out=tmp_path, grid={"n": [1]})
    monkeypatch.setattr("ravengc.sweep.folder.versions", lambda: {"ravengc": "0.0.0"})
    with pytest.raises(ConfigError, match=r"versions.ravengc is '.*' there and '0.0.0' here; versions.numpy is"):
        sweep(TOY, out=tmp_path, grid={"n": [1]})


@pytest.mark.parametrize("name", ["journal.jsonl", "sweep.csv", "sweep.parquet"])
def test_a_folder_of_something_else_is_left_alone(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine", encoding="utf-8")
    with pytest.raises(ConfigError, match=f"has a {name} without sweep.json, so it is not of this sweep"):
        sweep(TOY, out=tmp_path, grid={"n": [1]})
    assert [(path.name, path.read_text(encoding="utf-8")) for path in tmp_path.iterdir()] == [(name, "mine")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not valid JSON"),
        ("[]", "not a sweep of this version of ravengc: expected an object with format 1"),
        ('{"format": 2}', "not a sweep of this version of ravengc"),
        ("[" * 10**5, "not valid JSON"),
    ],
)
def test_a_sweep_json_of_something_else_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "sweep.json").write_text(text, encoding="utf-8")
    with pytest.raises(ParseError, match=said):
        sweep(TOY, out=tmp_path, grid={"n": [1]})
    with pytest.raises(ParseError, match=said):
        read_sweep(tmp_path)


@pytest.mark.parametrize(
    "line",
    [
        "",
        "x",
        "[]",
        "{}",
        "\0",
        "5",
        '{"trial": 2, "error": "x"}',
        '{"trial": -1, "error": "x"}',
        '{"trial": 0}',
        '{"trial": 0, "numbers": {"a": "b"}}',
        '{"trial": true, "error": "x"}',
        '{"trial": 0, "numbers": [1]}',
    ],
)
def test_a_journal_of_something_else_is_refused_with_the_line(tmp_path: Path, line: str) -> None:
    sweep(TOY, out=tmp_path, grid={"n": [1, 2]})
    with (tmp_path / "journal.jsonl").open("a", encoding="utf-8") as file:
        file.write(f"{line}\n")
    with pytest.raises(ParseError, match=r"journal.jsonl:3: .*expected a finished trial from 0 to 1; remove this line"):
        sweep(TOY, out=tmp_path, grid={"n": [1, 2]})


def test_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    sweep(TOY, out=tmp_path, grid={"n": [1, 2]})
    with (
        Journal(tmp_path / "journal.jsonl", 2),
        pytest.raises(ConfigError, match="another sweep is at work in this folder"),
    ):
        sweep(TOY, out=tmp_path, grid={"n": [1, 2]})
    sweep(TOY, out=tmp_path, grid={"n": [1, 2]})


def test_a_full_disk_leaves_whole_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = os.write
    with Journal(tmp_path / "journal.jsonl", 3) as journal:
        journal.add(0, Result({"a": 1.0}))
        monkeypatch.setattr(os, "write", lambda file, data: write(file, data[:5]))
        with pytest.raises(ConfigError, match="cannot be written: No space left on device"):
            journal.add(1, Result({"a": 1.0}))
        monkeypatch.undo()
        journal.add(2, Result(error="no"))
    assert read_journal(tmp_path / "journal.jsonl", 3)[0] == {0: Result({"a": 1.0}), 2: Result(error="no")}


@given(st.dictionaries(st.text(), st.floats(allow_nan=False)), st.text(min_size=1))
def test_a_journal_gives_back_what_it_got(numbers: dict[str, float], error: str) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "journal.jsonl"
        with Journal(path, 2) as journal:
            journal.add(1, Result(numbers))
            journal.add(0, Result(error=error))
        assert read_journal(path, 2) == ({1: Result(numbers), 0: Result(error=error)}, path.stat().st_size)


def test_a_sweep_is_read_from_its_folder(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    arguments = {"grid": {"duration_s": [1.0], "place": [(3.0, 1.0, 4.0), (0.0, 0.0, 1.0)]}, "trials": 2}
    table = sweep("ship", out=tmp_path, random={"roll_deg": Draw(0.0, 9.0)}, **arguments)
    assert same(read_sweep(tmp_path), table)
    assert table.columns["place"][-1] == (0.0, 0.0, 1.0)
    about = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    assert about["experiment"] == "ship"
    assert about["versions"]["numpy"] == np.__version__
    for broken in ({"grid": 5}, {"trials": 0}, {"experiment": "shp"}, {"random": {"x": {"lo": 1}}}, {"settings": []}):
        (tmp_path / "sweep.json").write_text(json.dumps(about | broken), encoding="utf-8")
        with pytest.raises(RavenGCError, match=r"sweep.json"):
            read_sweep(tmp_path)


# Misuse


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({}, "nothing to sweep: give a grid or random draws of settings of toy"),
        ({"grid": {"xx": [1]}}, "grid: unknown key 'xx'; did you mean 'x'"),
        ({"grid": {"x": [1, 11]}}, "grid: x is 11; expected a number from 0 to 10 m"),
        ({"grid": {"n": [1.5]}}, "grid: n is 1.5; expected a whole number from 1 to 100"),
        ({"grid": {"kind": ["plian"]}}, "grid: kind is 'plian'; expected one of 'plain', 'odd'; did you mean 'plain'"),
        ({"grid": {"pair": [1.0]}}, "grid: pair is 1.0; expected 2 values"),
        ({"grid": {"x": []}}, r"grid: x is \[\]; expected a list of values"),
        ({"grid": {"x": 3.0}}, "grid: x is 3.0; expected a list of values"),
        ({"grid": {"x": [1.0, 2.0, 1]}}, "grid: x has the value 1.0 twice"),
        ({"grid": {"x": [math.nan]}}, "grid: x is nan; expected a number from 0 to 10 m"),
        ({"grid": {"x": [1.0]}, "random": {"x": Draw(1, 2)}}, "x is both in the grid and drawn at random"),
        ({"random": {"z": Draw(1, 2)}}, "random: unknown key 'z'"),
        ({"random": {"x": Draw(5, 11)}}, "random: x is 11; expected a number from 0 to 10 m"),
        ({"random": {"n": Draw(1, 2.5)}}, "random: n is 2.5; expected a whole number"),
        ({"random": {"pair": Draw(0, 1)}}, "random: pair is not a single number; give its values in the grid"),
        ({"random": {"flag": Draw(0, 1)}}, "random: flag is not a single number"),
        ({"random": {"x": (0, 1)}}, r"random\['x'\] is a tuple; expected a Draw"),
        ({"trials": 0}, "trials is 0; expected a whole number from 1 to 1000000"),
        ({"trials": 2, "seed": -1}, "seed is -1; expected a whole number from 0"),
        ({"grid": {"n": range(1, 101)}, "trials": 10**5}, r"10000000 trials \(grid 100, 100000 at every point\)"),
        ({"grid": {"seed": [1]}, "trials": 2}, "2 trials at every point would all be the same"),
        ({"settings": Plain(), "trials": 2}, "settings is a Plain; expected a Toy"),
    ],
)
def test_misuse_is_refused_before_anything_is_run(tmp_path: Path, arguments: dict[str, Any], said: str) -> None:
    with pytest.raises(RavenGCError, match=said):
        sweep(TOY, out=tmp_path / "new", **arguments)
    assert list(tmp_path.iterdir()) == []


def test_the_same_trial_twice_is_refused() -> None:
    with pytest.raises(ConfigError, match="3 trials at every point would all be the same: nothing is drawn"):
        plan_sweep(UNSEEDED, grid={"x": [1.0]}, trials=3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((2, 1), "draws from 2 to 1; expected a lower and a higher end"),
        ((1, 1), "draws from 1 to 1"),
        ((0, 1, True), "logarithmic draws from 0; expected a positive lower end"),
        ((math.nan, 1), "low is nan; expected a finite number"),
        ((0, math.inf), "high is inf; expected a finite number"),
        (("0", 1), "low is '0'; expected a finite number"),
        ((True, 2), "low is True; expected a finite number"),
    ],
)
def test_impossible_draws_are_refused(arguments: tuple[Any, ...], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        Draw(*arguments)


def test_no_scheduler_at_an_address(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="distributed is not installed")
    monkeypatch.setattr("ravengc.sweep.executors.PATIENCE", "0.2s")
    for address in ("tcp://127.0.0.1:1", "nonsense://x", ""):
        with pytest.raises(ConfigError, match=r"no Dask scheduler at .*; expected tcp://host:port"), dask(address):
            pass


def test_a_missing_extra_names_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(MissingExtraError, match=r"needs the package 'distributed': pip install 'ravengc\[sweep\]'"),
        dask(""),
    ):
        pass
    table = sweep(TOY, out=tmp_path, grid={"n": [1]})
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match=r"needs the package 'pyarrow': pip install 'ravengc\[sweep\]'"):
        table.write_parquet(tmp_path / "x.parquet")


def test_errors_cross_processes_unchanged() -> None:
    error = MissingExtraError("mujoco", "sim", "the plant")
    back = pickle.loads(pickle.dumps(error))  # noqa: S301 -- our own
    assert (str(back), back.package, back.extra) == (str(error), "mujoco", "sim")


# Summaries


def test_summaries(tmp_path: Path) -> None:
    table = sweep(TOY, out=tmp_path, grid={"x": [3.0, 1.0, 2.0], "n": [2, 13]}, settings=Toy(y=1.0, many=(1.0,)))
    product, *_ = summarise(table)
    assert (product.best, product.best_trial, product.worst, product.worst_trial) == (1.0, 2, 3.0, 0)
    assert (product.mean, product.spread, product.count) == (2.0, pytest.approx(math.sqrt(2.0 / 3.0)), 3)
    assert summarise(table, ["product"], best="largest")[0].best == 3.0
    assert "nothing" not in {summary.name for summary in summarise(table)}
    with pytest.raises(ConfigError, match="toy has no number 'prodct'; did you mean 'product'"):
        summarise(table, ["prodct"])
