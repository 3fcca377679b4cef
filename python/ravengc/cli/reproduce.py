"""``ravengc reproduce``: the paper's experiments, run again, and a report that says what came of it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.atomic import check_writable
from ravengc.cli.common import command_parser, console, new_table, plain, print_json, progress_bar, right

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.progress import Progress

    from ravengc.experiments import Experiment, Outcome, Settings

    Jobs = list[tuple[Experiment, Settings]]

__all__ = ["NAMES", "add_parser", "run"]

NAMES = (
    "static-poses", "cartesian-sinusoids", "rocking", "acceleration-step", "base-feedback", "moving-base-terms", "ship",
    "base-wrench", "newton-euler",
)  # fmt: skip
SIMULATED = NAMES[:4]
"""Those that need the plant, and so MuJoCo."""
DESCRIPTION = f"""\
Run the experiments of Lewis and Hannaford's paper, its open questions, and the
moving-base literature it builds on, in simulation. Writes a picture of each
(PNG, SVG), the numbers (results.json) and one self-contained report.html with
what the paper states beside what came out.

experiments
  {NAMES[0]:<20}  static poses on a tilted base (Figs 7, 8)
  {NAMES[1]:<20}  trajectory on a tilted base (Fig. 9)
  {NAMES[2]:<20}  the same on a rocking base (Fig. 10)
  {NAMES[3]:<20}  sustained acceleration of the base
  {NAMES[4]:<20}  feedback between arm, base and accelerometer
  {NAMES[5]:<20}  which terms of the base's motion matter
  {NAMES[6]:<20}  PA10 on a ship
  {NAMES[7]:<20}  joint torques from a force/torque sensor below
  {NAMES[8]:<20}  Newton-Euler against Lagrange-Euler

Exit code 1 means that a number is not within the tolerance of the known one."""
EXAMPLES = """\
  ravengc reproduce  # everything, into out/reproduce
  ravengc reproduce rocking ship --out out/report
  ravengc reproduce moving-base-terms --json
  ravengc reproduce static-poses --settings my.toml  # see --list-settings
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``reproduce`` to the command line."""
    parser = command_parser(subparsers, "reproduce", "the paper's experiments and a report", DESCRIPTION, EXAMPLES)
    parser.set_defaults(func=run)
    add = parser.add_argument
    add("names", metavar="NAME", nargs="*", help="experiments to run (default: all)")
    add(
        "--out", metavar="DIR", type=Path, default=Path("out/reproduce"),
        help="folder for report, pictures and numbers (default: %(default)s)",
    )  # fmt: skip
    add("--settings", metavar="FILE", type=Path, help="TOML file with a table of settings per experiment")
    add("--jobs", metavar="N", type=_jobs, help="processes (default: one per processor)")
    add("--list-settings", action="store_true", help="print the settings, with units and ranges, and stop")
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace) -> int:
    """Run the experiments and write the report; 1 if an expected number is missed."""
    jobs = _selected(args)
    if args.list_settings:
        return _list_settings(jobs, as_json=args.json)
    _check_extras(jobs)
    check_writable(args.out / "report.html")

    from ravengc.experiments.pool import default_jobs, run_all

    with progress_bar() as progress:
        outcomes = run_all(jobs, processes=args.jobs or default_jobs(), on_done=_shower(progress))
    files = _write(args, jobs, outcomes)
    holds = all(outcome.holds for outcome in outcomes.values())
    if args.json:
        print_json({**_results(jobs, outcomes), "files": [str(path) for path in files]})
    else:
        _show(jobs, outcomes, files)
    return 0 if holds else 1


def _selected(args: argparse.Namespace) -> Jobs:
    """The experiments asked for, in the order of the report, with their settings."""
    from ravengc.experiments import EXPERIMENTS
    from ravengc.experiments.files import experiment_named, settings_of

    for name in args.names:
        experiment_named(name)
    wanted = args.names or list(EXPERIMENTS)
    given = {} if args.settings is None else settings_of(wanted, args.settings)
    return [
        (experiment, given.get(name, experiment.settings()))
        for name, experiment in EXPERIMENTS.items()
        if name in wanted
    ]


def _check_extras(jobs: Jobs) -> None:
    """Find out before the work, not in the middle of it, that a package is missing."""
    from importlib.util import find_spec

    from ravengc.errors import MissingExtraError
    from ravengc.reports.figures import require_matplotlib

    require_matplotlib("the report")
    if any(experiment.name in SIMULATED for experiment, _ in jobs) and find_spec("mujoco") is None:
        raise MissingExtraError("mujoco", "sim", "the simulated plant")


def _shower(progress: Progress) -> Callable[[int, int], None]:
    bar = progress.add_task("runs", total=None)

    def show(done: int, total: int) -> None:
        progress.update(bar, completed=done, total=total)

    return show


def _write(args: argparse.Namespace, jobs: Jobs, outcomes: dict[str, Outcome]) -> list[Path]:
    """Pictures, numbers and report, each file whole or not at all."""
    import json

    from ravengc.config.files import write_atomically
    from ravengc.reports.experiment_figures import draw_experiment, embedded_png, save_experiment
    from ravengc.reports.experiment_report import Section, write_report

    files, sections = [], []
    for experiment, settings in jobs:
        outcome = outcomes[experiment.name]
        figure = draw_experiment(experiment, outcome)
        files += save_experiment(figure, args.out, experiment.name)
        sections.append(Section(experiment, settings, outcome, embedded_png(figure), _command(args, experiment.name)))
    results = json.dumps(plain(_results(jobs, outcomes)), indent=2, ensure_ascii=False, allow_nan=False)
    write_atomically(args.out / "results.json", results + "\n")
    write_report(args.out / "report.html", sections)
    return [args.out / "report.html", args.out / "results.json", *files]


def _command(args: argparse.Namespace, name: str) -> str:
    return f"ravengc reproduce {name}" + (f" --settings {args.settings}" if args.settings else "")


def _results(jobs: Jobs, outcomes: dict[str, Outcome]) -> dict[str, Any]:
    """Everything but the series, as plain data."""
    from dataclasses import asdict

    experiments = {}
    for experiment, settings in jobs:
        outcome = outcomes[experiment.name]
        experiments[experiment.name] = {
            "title": experiment.title,
            "source": experiment.source,
            "settings": asdict(settings),
            "numbers": outcome.numbers,
            "findings": [{**asdict(finding), "holds": finding.holds} for finding in outcome.findings],
            "tables": [asdict(table) for table in outcome.tables],
        }
    return {"holds": all(outcome.holds for outcome in outcomes.values()), "experiments": experiments}


def _show(jobs: Jobs, outcomes: dict[str, Outcome], files: list[Path]) -> None:
    from rich.markup import escape

    from ravengc.reports.experiment_report import expected_text, found_text

    screen = console()
    marks = {"reproduced": "[green]reproduced[/]", "not reproduced": "[yellow]not reproduced[/]"}
    for experiment, _ in jobs:
        table = new_table("finding", right("we get"), right("expected"), "the paper's statement")
        for finding in outcomes[experiment.name].findings:
            expected = expected_text(finding) + ("" if finding.holds else " [red]missed[/]")
            value = escape(found_text(finding))
            table.add_row(escape(finding.quantity), value, expected, marks.get(finding.verdict, ""))
        screen.print(f"[bold]{escape(experiment.title)}[/]  ({experiment.name})")
        screen.print(table)
    missed_count = sum(not finding.holds for outcome in outcomes.values() for finding in outcome.findings)
    if missed_count:
        screen.print(f"[red]{missed_count} numbers are outside their tolerance[/]")
    screen.print(f"report: {files[0]}", soft_wrap=True)


def _list_settings(jobs: Jobs, *, as_json: bool) -> int:
    from rich.markup import escape

    from ravengc.experiments import settings_table

    if as_json:
        keys = ("key", "value", "unit", "allowed", "meaning")
        rows = {e.name: [dict(zip(keys, row, strict=True)) for row in settings_table(s)] for e, s in jobs}
        print_json(rows)
        return 0
    screen = console()
    for experiment, settings in jobs:
        table = new_table("setting", "value", "allowed", "what it is")
        for key, value, _, allowed, meaning in settings_table(settings):
            table.add_row(key, escape(_toml(value)), escape(allowed), escape(meaning))
        screen.print(f"[bold]{escape(f'[{experiment.name}]')}[/]")
        screen.print(table)
    return 0


def _toml(value: object) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _jobs(text: str) -> int:
    try:
        count = int(text)
    except ValueError:
        count = 0
    if not 1 <= count <= 1024:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from 1 to 1024")
    return count
