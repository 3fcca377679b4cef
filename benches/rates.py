"""A step of resolved rate beside other libraries': one arm, one process, interleaved rounds.

`python benches/rates.py` times a step (pose in, joint rates out) of every library that is installed: along a path as a
control loop takes it ("step"), back to back and once per millisecond, and from pose to pose drawn at random ("jump").
The programme with limits alone it times beside other solvers. First it compares the minima, and sees that each
library's rates lead to the goal. Others: `pip install --group rates`, in an environment of their own, as
placo takes an older pinocchio (`make bench` makes one).

Absolute times belong to the machine and its mood. The ratios are medians over rounds in which both sides ran.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from comparison import command, hot, machine, paced
from comparison.libraries import left_out
from comparison.stepping.scene import ROUND, along_a_path, anywhere, pose_error
from rich.table import Table

if TYPE_CHECKING:
    from collections.abc import Callable

    from comparison.arm import Array
    from comparison.call import Call
    from comparison.stepping.scene import Scene

PARTS: dict[str, tuple[Callable[[], Scene], str, str]] = {
    "step": (along_a_path, "steppers", "STEPPERS"),
    "jump": (anywhere, "steppers", "STEPPERS"),
    "solve": (anywhere, "solvers", "SOLVERS"),
}
"""What is timed: with which inputs, and the module and its table of the libraries' calls."""
BARS = {"step/ravengc/scale, bind": 0.6, "step/ravengc/qp, bind": 2.0, "step/ravengc/manipulability, bind": 5.0}
"""Medians that are to be held, µs."""
PACED_BARS = {"step/ravengc/scale, bind": 5.0}
"""Those once per millisecond, in a loop that calls one library."""
MOST_LEFT = 0.99
"""Of the pose error, after 10 ms: what leaves more does not go there."""


def calls_of(part: str) -> tuple[Scene, list[Call], list[str]]:
    """Their inputs, those of all libraries that take part, and a note for each that cannot."""
    inputs, module, table = PARTS[part]
    scene = inputs()
    calls: list[Call] = []
    notes = []
    for library, make in getattr(import_module(f"comparison.stepping.{module}"), table).items():
        if note := left_out(library):
            notes.append(note)
        else:
            calls += make(scene)
    return scene, calls, notes


def off(calls: list[Call], scene: Scene) -> dict[str, float]:
    """How much more the minima of the programme cost than the best found, relative, the worst of all."""
    solving = [call for call in calls if call.operation == "solve"]
    worst = dict.fromkeys((call.key for call in solving), 0.0)
    for k, programme in enumerate(scene.programme):
        inside = {call.key: np.clip(call.run(k), programme.lower, programme.upper) for call in solving}
        costs = {key: programme.cost(x) for key, x in inside.items()}
        least = min(costs.values(), default=0.0)
        for key, cost in costs.items():
            worst[key] = max(worst[key], (cost - least) / max(least, 1e-12))
    return worst


def error_left(calls: list[Call], scene: Scene) -> dict[str, float]:
    """Share of the pose error left after 10 ms at each library's rates, median: 0.9 where no limit slows them."""
    steps = [call for call in calls if call.operation == scene.operation]
    shares: dict[str, list[float]] = {call.key: [] for call in steps}
    for k in range(ROUND):
        for call in steps:
            moved = scene.q[k] + 0.01 * call.value(call.run(k))
            before, after = (
                float(np.linalg.norm(pose_error(scene.robot.forward_kinematics(q), scene.goal[k])))
                for q in (scene.q[k], moved)
            )
            shares[call.key].append(after / before)
    left = {key: float(np.median(share)) for key, share in shares.items()}
    if astray := [key for key, share in left.items() if not share < MOST_LEFT]:
        raise SystemExit(f"nothing timed: the rates of {', '.join(astray)} do not lead to the goal")
    return left


def rows(calls: list[Call], times: dict[str, Any], found: dict[str, dict[str, float]]) -> list[dict[str, Any]]:
    """In the form that is written."""
    first: dict[str, str] = {}
    for call in calls:
        first.setdefault(call.operation, call.key)
    return [
        {
            "key": call.key,
            "median_us": float(np.nanmedian(times[call.key])) / 1e3,
            "fast_us": float(np.nanpercentile(times[call.key], 10)) / 1e3,
            "times_ours": hot.ratio(times[call.key], times[first[call.operation]]),
            **{name: values.get(call.key) for name, values in found.items()},
        }
        for call in calls
    ]


def show(found: list[dict[str, Any]]) -> None:
    table = Table(title="µs per call; times: as long as the first of ours, median over rounds; error left: after 10 ms")
    for heading in ("what", "library", "way", "median", "fast", "times", "error left", "cost above best"):
        table.add_column(heading, justify="left" if heading in {"what", "library", "way"} else "right")
    for row in found:
        left, above = row["error_left"], row["cost_above_best"]
        checked = ("" if left is None else f"{left:.2f}", "" if above is None else f"{above:.0e}")
        numbers = (f"{row['median_us']:.2f}", f"{row['fast_us']:.2f}", f"{row['times_ours']:.1f}")
        table.add_row(*row["key"].split("/", 2), *numbers, *checked)
    command.console().print(table)


def once_per_millisecond(calls: list[Call], scene: Scene, turns: int) -> list[dict[str, Any]]:
    """A step of each library, of ours those that are bound, asleep in between: alone, and among the others' ticks."""
    steps = [call for call in calls if call.operation == "step" and (call.alone or call.library != "ravengc")]
    if not (turns and steps):
        return []
    alone, among = (_beyond_nothing(paced.pace(steps, scene.q, turns, block)) for block in (paced.ALONE, 1))
    return [
        {"key": key, "median_us": float(p50), "p99_us": float(p99), "among_median_us": float(among[key][0])}
        for key, (p50, p99) in alone.items()
    ]


def _beyond_nothing(times: dict[str, Array]) -> dict[str, Array]:
    """Median and 99th percentile of every call in µs, without what fetching an input takes."""
    nothing = float(np.median(times.pop("nothing")))
    return {key: np.percentile(found - nothing, (50, 99)) / 1e3 for key, found in times.items()}


def show_paced(found: list[dict[str, Any]]) -> None:
    headings = ("library", "way", "alone p50", "p99", "among p50")
    table = Table(*headings, title="µs per step once per millisecond, alone and among the others' ticks")
    for row in found:
        numbers = [f"{row[name]:.1f}" for name in ("median_us", "p99_us", "among_median_us")]
        table.add_row(*row["key"].split("/", 2)[1:], *numbers)
    command.console().print(table)


def over(bars: dict[str, float], found: list[dict[str, Any]]) -> list[str]:
    """The bars that are not held by the median, each with what the fastest tenth takes where that is known."""
    missed = [(row, bar) for row in found if row["median_us"] > (bar := bars.get(row["key"], np.inf))]
    return [
        f"MISSED: {row['key']} takes {row['median_us']:.2f} µs"
        + (f" ({row['fast_us']:.2f} in the fastest tenth)" if "fast_us" in row else "")
        + f", bar {bar}"
        for row, bar in missed
    ]


def measure(parts: list[str], rounds: int, turns: int, *, first: bool) -> dict[str, Any]:
    """Everything, in the form that is written."""
    made = [calls_of(part) for part in parts]
    checked: dict[str, dict[str, float]] = {"cost_above_best": {}, "error_left": {}}
    for scene, some, _ in made:
        checked["cost_above_best"] |= off(some, scene)
        checked["error_left"] |= error_left(some, scene)
    calls = [call for _, some, _ in made for call in some]
    with machine.quiet(first=first) as refused:
        times = hot.race(calls, made[0][0].q, rounds)
        slow = [row for scene, some, _ in made for row in once_per_millisecond(some, scene, turns)]
    notes = dict.fromkeys(note for _, _, some in made for note in some)
    return {
        "machine": machine.facts(),
        "notes": [*notes, *refused],
        "rows": rows(calls, times, checked),
        "paced": slow,
    }


def main() -> int:
    parser = command.parser(__doc__, "rates")
    parser.add_argument("--only", choices=PARTS, help="this part alone")
    parser.add_argument("--rounds", type=int, default=1000, help="rounds in which all run (default 1000)")
    parser.add_argument("--turns", type=int, default=300, help="milliseconds of each, twice; 0: none (default 300)")
    parser.add_argument("--smallest", action="store_true", help=f"{command.SMALLEST}, judges no bar")
    arguments = parser.parse_args()
    parts = [arguments.only] if arguments.only else list(PARTS)
    rounds, turns = (2, 1) if arguments.smallest else (arguments.rounds, arguments.turns)
    results = measure(parts, rounds, turns, first=not arguments.smallest)
    for note in results["notes"]:
        print(f"note: {note}")
    show(results["rows"])
    show_paced(results["paced"])
    command.write(arguments.json, results)
    missed = [] if arguments.smallest else [*over(BARS, results["rows"]), *over(PACED_BARS, results["paced"])]
    for line in missed:
        print(line)
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())
