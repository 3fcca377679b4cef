"""The fault campaign of the base's accelerometer: everything that can go wrong with a sensor, thousands of times each.

`python benches/faults.py` builds `benches/faults.rs` and flies it: a base that rocks by 10-20 degrees at 1 Hz, a
sensor at 100 Hz with noise of 0.03 m/s^2, a loop at 1 kHz, and a fault that sets in at a random time. Beside the chain
under both policies flies a gate that holds the last sample, whatever that was. The code is 1 if anything required does
not hold.

`--quick` flies 200 seeds of each kind instead of 4000, and a tenth of the rest: a few seconds.
"""

from __future__ import annotations

import json
import subprocess
import sys
from typing import TYPE_CHECKING, Any, NamedTuple

from comparison import command
from rich.box import SIMPLE_HEAD
from rich.progress import Progress
from rich.table import Table

if TYPE_CHECKING:
    from pathlib import Path

GRAVITY = 9.80665
IN_TIME_MS = 100.0
LEAST_SCENARIOS = 110_000
LONGEST_S = 120.0

LEGEND = """
alarm: from the fault's onset to the first reading with an alarm, the slower of both policies.
error: largest distance of the output from the true gravity after the onset; paper: the last value is held; strict:
after 50 ms the slow tilt estimate; naive: the last sample, whatever it was. Until a sensor is trusted the level vector
stands, whose error is that of the tilt. armed: the same while the chain said that the arm may be armed.
A horizontal axis or sign that changes is seen by its jump, where it jumps further than the declared base can move from
one sample to the next: 1.8 m/s^2, ten times the noise and 150 m/s^3 for 10 ms. A gyroscope shows in addition what comes
to be 3.3 m/s^2 from where it has carried gravity: ten times the noise, and twice 1.5 m/s^2 of acceleration of the base.
NaN: outputs that are no numbers. steps: outputs that moved by more than 50 m/s^3 times the cycle, both policies."""

SECTIONS = {
    "Hard": "an alarm within 100 ms, always",
    "Harmless": "no alarm",
    "Partial": "an alarm in most or some",
}

Results = dict[str, Any]


class Effort(NamedTuple):
    """How much is flown: seeds of each kind, seconds of healthy rocking, samples of random bits."""

    seeds: int = 4000
    healthy_s: int = 10_000
    random_samples: int = 10_000_000


QUICK = Effort(seeds=200, healthy_s=1000, random_samples=1_000_000)
SMALLEST = Effort(seeds=4, healthy_s=20, random_samples=20_000)


def main() -> int:
    parser = command.parser(__doc__, "faults")
    parser.add_argument("--quick", action="store_true", help="a small campaign")
    parser.add_argument("--smallest", action="store_true", help="four seeds of each kind, to see that all runs")
    arguments = parser.parse_args()
    effort = SMALLEST if arguments.smallest else QUICK if arguments.quick else Effort()
    results = fly(command.example("faults", release=not arguments.smallest), effort)
    results["required"] = required(results, whole=effort == Effort())
    console = command.console(132)
    for table in (alarms(results), hidden(results)):
        console.print(table)
    console.print(LEGEND.strip())
    console.print(totals(results), checks(results["required"]))
    command.write(arguments.json, results)
    return 0 if all(check["holds"] for check in results["required"]) else 1


def fly(program: Path, effort: Effort) -> Results:
    """Run the campaign; it says what it has done so far line by line, and everything at the end."""
    called = [str(program), *map(str, effort)]
    with (
        Progress(transient=True) as progress,
        subprocess.Popen(  # noqa: S603
            called, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process,
    ):
        assert process.stderr is not None
        assert process.stdout is not None
        task = progress.add_task("flying", total=int(process.stderr.readline()))
        for line in process.stderr:
            progress.update(task, advance=1, description=line.strip())
        printed = process.stdout.read()
    if process.returncode:
        raise SystemExit(f"{' '.join(called)}: failed with code {process.returncode}")
    results: Results = json.loads(printed)
    return results


def worse(row: Results, quantity: str) -> float | None:
    """The larger number of both policies, if there is any."""
    found = [row[policy][quantity] for policy in ("paper", "strict") if row[policy][quantity] is not None]
    return max(found, default=None)


def alarmed_percent(row: Results, seeds: int, when: str = "alarmed") -> float:
    """Share of the scenarios with an alarm (``when`` "in_time": within 100 ms), under the policy that raised fewer."""
    return float(100.0 * min(row["paper"][when], row["strict"][when]) / seeds)


def both(row: Results, quantity: str) -> int:
    """Sum over both policies."""
    return int(row["paper"][quantity] + row["strict"][quantity])


def number(x: float | None, decimals: int = 0) -> str:
    if x is None:
        return "-"
    return f"{x:.1e}" if x >= 1000.0 else f"{x:.{decimals}f}"


def alarms(results: Results) -> Table:
    """Every kind that an accelerometer can show, and what the outputs did meanwhile."""
    table = new_table(f"Faults that show, {results['seeds']:,} seeds each", "\nfault")
    times = ("alarmed\n%", "alarm\np50 ms", "\nmax ms")
    errors = ("error, m/s²\npaper", "\nstrict", "\narmed", "\nnaive")
    for column in (*times, *errors, "NaN\nours", "\nnaive", "steps\nours"):
        table.add_column(column, justify="right", no_wrap=True)
    for name, title in SECTIONS.items():
        table.add_section()
        table.add_row(f"[italic]{title}[/]")
        for row in results["kinds"]:
            if row["class"] == name:
                table.add_row(*alarm_cells(row, results["seeds"]))
    return table


def alarm_cells(row: Results, seeds: int) -> list[str]:
    times = [number(worse(row, quantity)) for quantity in ("p50", "max")]
    found = (row["paper"]["error"], row["strict"]["error"], worse(row, "armed"), row["naive"]["error"])
    errors = [number(error, 2) for error in found]
    counts = [f"{both(row, 'not_finite')}", f"{row['naive']['not_finite']:,}", f"{both(row, 'too_far')}"]
    return [row["name"], f"{alarmed_percent(row, seeds):.1f}", *times, *errors, *counts]


def hidden(results: Results) -> Table:
    """What one accelerometer cannot show, or not always, and the error of the gravity torque it can cause."""
    table = new_table("Faults that one accelerometer cannot show, or not always, and none", "\nfault")
    sizes = ("error armed, m/s²\nmedian", "\nworst", "% of the gravity load\nmedian", "\nworst")
    for column in ("alarmed, %\nin 100 ms", "\never", *sizes, "NaN\nours", "steps\nours"):
        table.add_column(column, justify="right", no_wrap=True)
    healthy = results["kinds"][0]
    for row in [healthy, *(row for row in results["kinds"] if row["class"] == "Hidden")]:
        errors = [worse(row, quantity) or 0.0 for quantity in ("armed_p50", "armed")]
        table.add_row(
            row["name"],
            *(f"{alarmed_percent(row, results['seeds'], when):.1f}" for when in ("in_time", "alarmed")),
            *(f"{error:.2f}" for error in errors),
            *(f"{100.0 * error / GRAVITY:.1f}" for error in errors),
            f"{both(row, 'not_finite')}",
            f"{both(row, 'too_far')}",
        )
    return table


def new_table(title: str, *texts: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    for text in texts:
        table.add_column(text, no_wrap=True)
    return table


def totals(results: Results) -> str:
    healthy, bits = results["healthy"], results["bits"]
    states = ", ".join(f"{state} {count:,}" for state, count in bits["states"].items())
    cycles = sum(row["cycles"] for row in results["kinds"])
    return f"""
{scenarios(results):,} scenarios, {cycles:,} cycles under each policy; healthy rocking {healthy["seconds"]:,} s: \
{healthy["alarms"]} alarms, largest error {healthy["error"]:.2f} m/s²;
{bits["samples"]:,} samples of random bits: {bits["accepted"]:,} accepted, cycles {states}; \
{results["seconds"]:.0f} s in all."""


def scenarios(results: Results) -> int:
    return len(results["kinds"]) * int(results["seeds"])


def required(results: Results, *, whole: bool) -> list[Results]:
    """What has to hold, with the number that was found."""
    kinds, healthy, bits = results["kinds"], results["healthy"], results["bits"]
    hard = [row for row in kinds if row["class"] == "Hard"]
    parts = [*(row[policy] for row in kinds for policy in ("paper", "strict")), healthy, bits]
    early = sum(both(row, "early") for row in kinds)
    checks = [
        check("outputs that are no numbers", sum(part["not_finite"] for part in parts), 0),
        check("steps further than the rate allows", sum(part["too_far"] for part in parts), 0),
        check("outputs longer than the norm window, random bits", bits["too_long"], 0),
        check(f"false alarms in {healthy['seconds']:,} s of healthy rocking, both policies", healthy["alarms"], 0),
        check("false alarms before a fault's onset", early, 0),
        check(
            f"alarmed in the {len(hard)} hard kinds, %",
            min(alarmed_percent(row, results["seeds"]) for row in hard),
            100,
            at_least=True,
        ),
        check("slowest alarm of the hard kinds, ms", max(worse(row, "max") or 0.0 for row in hard), IN_TIME_MS),
    ]
    if whole:
        checks.append(check("scenarios", scenarios(results), LEAST_SCENARIOS, at_least=True))
        checks.append(check("time, s", results["seconds"], LONGEST_S))
    return checks


def check(name: str, found: float, wanted: float, *, at_least: bool = False) -> Results:
    holds = found >= wanted if at_least else found <= wanted
    return {"name": name, "found": found, "wanted": wanted, "at_least": at_least, "holds": holds}


def checks(required: list[Results]) -> Table:
    table = new_table("Required", "what")
    for column in ("found", "wanted", "holds"):
        table.add_column(column, justify="right")
    for row in required:
        bound = "≥" if row["at_least"] else "≤"
        table.add_row(
            row["name"], f"{row['found']:,.6g}", f"{bound} {row['wanted']:,}", "yes" if row["holds"] else "NO"
        )
    return table


if __name__ == "__main__":
    sys.exit(main())
