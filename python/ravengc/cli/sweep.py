"""``ravengc sweep``: an experiment over a grid of its settings or over random draws of them."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, print_json, progress_bar
from ravengc.cli.reproduce import NAMES
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable
    from concurrent.futures import Executor
    from contextlib import AbstractContextManager

    from rich.progress import Progress as Bar

    from ravengc.experiments import Settings
    from ravengc.sweep import Progress, SweepTable

__all__ = ["add_parser", "run"]

ABOUT = f"""\
Run one experiment of `ravengc reproduce` over a grid of its settings, or over
random draws of them, on the processors of this machine or on a Dask cluster.
Writes one table, a row per trial: sweep.csv, and sweep.parquet with pyarrow.

The folder keeps what is finished: the same command goes on where a sweep was
stopped, by Ctrl-C or killed. The table does not depend on that, nor on
the number of processes: seed and number of a trial decide it.

experiments: {", ".join(NAMES[:4])},
  {", ".join(NAMES[4:])}
`ravengc reproduce NAME --list-settings` lists what can be swept."""

EXAMPLES = """\
  ravengc sweep ship --grid roll_deg=0:20:5 --grid heave=0,1,2
  ravengc sweep ship --random roll_deg=0:20 --random heave_hz=0.02:0.5:log \\
      --trials 40 --seed 7 --out out/random --plot out/random.png
  ravengc sweep base-wrench --grid lever=0.1,0.3 --trials 3 --json
  ravengc sweep moving-base-terms --grid hz=0.25:2:8 --dask tcp://cluster:8786

exit code: 0 done, 1 a trial failed, 2 bad input, 130 stopped by Ctrl-C
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``sweep`` to the command line."""
    parser = command_parser(subparsers, "sweep", "an experiment over a grid or random draws", ABOUT, EXAMPLES)
    parser.set_defaults(func=run)
    parser.add_argument("name", metavar="NAME", help="the experiment")
    _add_trial_options(parser.add_argument_group("trials"))
    _add_place_options(parser.add_argument_group("where they run"))
    _add_output_options(parser.add_argument_group("output"))


def _add_trial_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--grid",
        metavar="KEY=A:B:N|V,V",
        action="append",
        default=[],
        help="values of a setting: N of them from A to B (with :log in even ratio), or these; / stands between the "
        "entries of a list; several --grid make a product",
    )
    add(
        "--random", metavar="KEY=LOW:HIGH", action="append", default=[], help="draw a setting (:log behind it: its log)"
    )
    add("--trials", metavar="N", type=int, default=1, help="trials at every point of the grid (default: %(default)s)")
    add("--seed", metavar="S", type=int, default=0, help="of draws and of the trials' own seeds (default: %(default)s)")
    add("--settings", metavar="FILE", type=Path, help="TOML file with a table [NAME] of all the other settings")


def _add_place_options(group: argparse._ArgumentGroup) -> None:
    where = group.add_mutually_exclusive_group()
    where.add_argument("--jobs", metavar="N", type=int, help="processes (default: one per processor)")
    where.add_argument("--dask", metavar="ADDRESS", help="a Dask scheduler instead: tcp://host:8786")


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--out", metavar="DIR", type=Path, help="folder of this sweep (default: out/sweep/NAME)")
    add("--number", metavar="NAME", action="append", help="number to tell about (again for more); the first is drawn")
    add("--best", choices=("least", "largest"), default="least", help="which value is the best (default: %(default)s)")
    add("--plot", metavar="FILE", type=Path, help="draw a number against what is swept (.png, .svg, .pdf)")
    add("--against", metavar="KEY[,KEY]", type=lambda text: tuple(text.split(",")), help="one or two swept settings")
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace) -> int:
    """Run the sweep; 1 if a trial failed, 130 after Ctrl-C."""
    from ravengc.cli.sweep_tables import describe, show
    from ravengc.sweep import sweep

    arguments = _arguments(args)
    if args.plot is not None:
        _check_plot(args, arguments)
    out = args.out or Path("out") / "sweep" / args.name
    last: list[Progress] = []
    try:
        with progress_bar(remaining=True) as bar, _executor(args) as executor:
            table = sweep(args.name, out=out, executor=executor, on_progress=_teller(bar, last, out), **arguments)
    except KeyboardInterrupt:
        _say_how_to_go_on(out)
        return 130
    about = describe(table, args, last[-1], out)
    if args.plot is not None:
        _draw(table, args)
    if args.json:
        print_json(about)
    else:
        show(table, about)
    return 1 if table.failed else 0


def _arguments(args: argparse.Namespace) -> dict[str, Any]:
    """What to sweep, in the words of :func:`ravengc.sweep.sweep`, all of it checked."""
    from ravengc.sweep import read_draw, read_points
    from ravengc.sweep.plan import plan_sweep

    found: dict[str, Any] = {
        "grid": _by_key([read_points(args.name, text) for text in args.grid], "--grid"),
        "random": _by_key([read_draw(args.name, text) for text in args.random], "--random"),
        "trials": args.trials,
        "seed": args.seed,
        "settings": _settings(args),
    }
    if not (args.grid or args.random) and args.trials == 1:
        give = "give --grid KEY=A:B:N, --random KEY=LOW:HIGH or --trials N"
        raise ConfigError(f"nothing to sweep: {give}; ravengc reproduce {args.name} --list-settings lists the keys")
    plan_sweep(args.name, **found)
    return found


def _by_key(pairs: list[tuple[str, Any]], option: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise ConfigError(f"{option}: {key} is given twice; expected all its values in one {option}")
        found[key] = value
    return found


def _settings(args: argparse.Namespace) -> Settings | None:
    from ravengc.experiments.files import experiment_named, settings_of

    experiment_named(args.name)
    return None if args.settings is None else settings_of((args.name,), args.settings).get(args.name)


def _executor(args: argparse.Namespace) -> AbstractContextManager[Executor | None]:
    from ravengc.experiments.pool import default_jobs
    from ravengc.sweep import dask, processes

    if args.dask is not None:
        return dask(args.dask)
    jobs = default_jobs() if args.jobs is None else args.jobs
    return nullcontext(None) if jobs == 1 else processes(jobs)


def _check_plot(args: argparse.Namespace, arguments: dict[str, Any]) -> None:
    """Find out before the trials that the picture could not be drawn or written."""
    from ravengc.reports.figures import check_picture
    from ravengc.reports.sweep_plot import check_against

    check_against((*arguments["grid"], *arguments["random"]), args.against)
    check_picture(args.plot, "a picture of the sweep")


def _draw(table: SweepTable, args: argparse.Namespace) -> None:
    from ravengc.reports.sweep_plot import plot_sweep

    plot_sweep(args.plot, table, number=args.number[0] if args.number else None, against=args.against)


def _teller(bar: Bar, last: list[Progress], out: Path) -> Callable[[Progress], None]:
    """Show how far the sweep is, and once how many trials were there already; remember the latest in ``last``."""
    task = bar.add_task("trials", total=None)

    def tell(progress: Progress) -> None:
        if not last and progress.already:
            sys.stderr.write(f"{progress.already} of {progress.total} trials are in {out} already\n")
        last[:] = [progress]
        failed = f", {progress.failed} failed" if progress.failed else ""
        bar.update(task, completed=progress.done, total=progress.total, description=f"trials{failed}")

    return tell


def _say_how_to_go_on(out: Path) -> None:
    from ravengc.sweep.folder import finished_trials

    sys.stderr.write(
        f"ravengc: stopped: {finished_trials(out)} finished trials are in {out}; the same command goes on\n"
    )
