"""ravengc beside other libraries: one arm, one process, interleaved rounds.

`python benches/peers.py` checks that all libraries installed here compute the same numbers, then times the operations
of a cycle back to back, the gravity torque paced at 1 kHz, a batch, and importing; it counts heap allocations and
compares the outcome with the project's bars. Other libraries: `pip install pin dynibo roboticstoolbox-python mujoco`.

Absolute times belong to the machine and its mood. The ratios are medians over rounds in which both sides ran.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np
from comparison import agreement, allocations, batch, command, hot, imports, machine, paced
from comparison.arm import SAMPLES, panda
from comparison.bars import bars
from comparison.libraries import LIBRARIES, all_calls
from comparison.tables import all_tables

if TYPE_CHECKING:
    from comparison.arm import Arm, Array
    from comparison.call import Call

LEGEND = """
fast: the fastest tenth of the rounds (of batches the best): on a slow host further from the median.
x bind, x out=: times slower than ravengc called so, median over rounds.
off by: largest difference from the reference, relative. eps Σmgr: error of the torque in roundings of its sum."""


@dataclass(frozen=True)
class Effort:
    """How much is measured, and whether before all other processes."""

    rounds: int = 1000
    turns: int = 1000
    samples: int = 1_000_000
    batch_rounds: int = 7
    processes: int = 7
    exact: int = SAMPLES
    counted: int = 1_000_000
    checked: int = 16
    imported: int = len(LIBRARIES)
    first: bool = True


QUICK = Effort(rounds=150, turns=150, samples=200_000, batch_rounds=3, processes=1, exact=32, counted=20_000)
SMALLEST = Effort(
    rounds=2, turns=1, samples=1000, batch_rounds=1, processes=1, exact=2, counted=SAMPLES, checked=1, imported=1,
    first=False,
)  # fmt: skip


def main() -> int:
    parser = command.parser(__doc__, "peers")
    parser.add_argument("--quick", action="store_true", help="measure less, in about half a minute")
    parser.add_argument("--smallest", action="store_true", help=command.SMALLEST)
    arguments = parser.parse_args()
    arm = panda()
    effort = SMALLEST if arguments.smallest else QUICK if arguments.quick else Effort()
    calls, notes = all_calls(arm)
    found = agreement.differences(arm, calls, effort.checked)
    if wrong := agreement.disagreeing(found):
        print("not timed, because these differ from the reference by more than 1e-10:", file=sys.stderr)
        print(*(f"  {key}: {found[key]:.1e}" for key in wrong), sep="\n", file=sys.stderr)
        return 1
    results = measure(arm, calls, found, notes, effort)
    show(results)
    command.write(arguments.json, results)
    return 0


def measure(arm: Arm, calls: list[Call], off: dict[str, float], notes: list[str], effort: Effort) -> dict[str, Any]:
    """Everything, in the form that is written."""
    say("accuracy and allocations")
    units = agreement.accuracy(arm, calls, effort.exact)
    mallocs, missing = allocations.count(effort.counted)
    say("imports")
    modules = [name for name in LIBRARIES if name in sys.modules and name != "numpy"]
    imported = imports.compare(modules[: effort.imported], effort.processes)
    torques, steps = (
        [call for call in calls if call.operation in operations]
        for operations in ({"gravity", "live"}, {"control", "control_live"})
    )
    with machine.quiet(first=effort.first) as refused:
        say("hot loops")
        times = hot.race(calls, arm.q, effort.rounds)
        say("paced calls")
        ticks = {
            "alone": paced.pace([*torques, *steps], arm.q, effort.turns, block=paced.ALONE),
            "among": paced.pace([*torques, *steps], arm.q, effort.turns, block=1),
        }
        say("batches")
        batches, absent = batch_rates(effort)
    results = {
        "machine": machine.facts(),
        "notes": [*notes, *missing, *refused, *absent],
        "hot": hot_rows(calls, times, off, mallocs, units or {}),
        "paced": paced_rows(torques, ticks),
        "paced_control": paced_rows(steps, ticks),
        "batch": batches,
        "imports": imported,
    }
    return {**results, "bars": bars(results)}


def say(stage: str) -> None:
    print(f"measuring {stage} ...", file=sys.stderr, flush=True)


Numbers = dict[str, float]


def hot_rows(
    calls: list[Call], times: dict[str, Array], off: Numbers, mallocs: Numbers, units: Numbers
) -> list[dict[str, Any]]:
    return [
        {
            "operation": call.operation,
            "library": call.library,
            "way": call.way,
            "median_us": float(np.nanmedian(times[call.key])) / 1e3,
            "fast_us": float(np.nanpercentile(times[call.key], 10)) / 1e3,
            "times_bind": times_slower(call, times, "bind"),
            "times_out": times_slower(call, times, "out="),
            "allocations": mallocs.get(call.key),
            "off": off[call.key],
            "rounding_units": units.get(call.key),
        }
        for call in calls
    ]


def times_slower(call: Call, times: dict[str, Array], way: str) -> float | None:
    """How many times slower than ours in this way; ``None`` where there is no such way."""
    ours = times.get(f"{call.operation}/ravengc/{way}")
    return None if ours is None else hot.ratio(times[call.key], ours)


def paced_rows(calls: list[Call], ticks: dict[str, dict[str, Array]]) -> list[dict[str, Any]]:
    """One row per call, after one for what Python itself takes; ratios are to the first of ours that is bound."""
    bound = next(call.key for call in calls if (call.library, call.way) == ("ravengc", "bind"))
    named = [("", "nothing", "Python's own part", "nothing")]
    named += [(call.operation, call.library, call.way, call.key) for call in calls]
    return [
        {"operation": operation, "library": library, "way": way}
        | {name: tick_numbers(times[key], times[bound]) for name, times in ticks.items()}
        for operation, library, way, key in named
    ]


def tick_numbers(times: Array, bound: Array) -> Numbers:
    return {
        "p10_us": float(np.percentile(times, 10)) / 1e3,
        "p50_us": float(np.median(times)) / 1e3,
        "p99_us": float(np.percentile(times, 99)) / 1e3,
        "times_bind": float(np.median(times) / np.median(bound)),
    }


def batch_rates(effort: Effort) -> tuple[dict[str, Any], list[str]]:
    """Rates with all cores allowed, then those of the lesser builds."""
    with machine.all_cores():
        found, notes = batch.compare(effort.samples, effort.batch_rounds)
    for level in ("portable", "avx2"):
        found[f"ravengc, {level} build"] = batch.at_level(level, effort.samples, effort.batch_rounds)
    ours = median(found["ravengc, 1 thread"])
    rows = [
        {"how": how, "median": median(rates), "best": max(rates), "times_slower": ours / median(rates)}
        for how, rates in found.items()
    ]
    return {"samples": effort.samples, "rates": rows}, notes


def show(results: dict[str, Any]) -> None:
    console = command.console(140)
    facts = results["machine"]
    versions = ", ".join(f"{name} {number}" for name, number in facts["versions"].items())
    where = f"{facts['processor']}, {facts['cores']} cores, Python {facts['python']}, kernels {facts['instructions']}"
    console.print(f"{where}\n{versions}")
    console.print(LEGEND)
    for note in results["notes"]:
        console.print(f"note: {note}")
    for one in all_tables(results):
        console.print(one)


if __name__ == "__main__":
    sys.exit(main())
