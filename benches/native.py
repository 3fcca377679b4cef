"""Our kernels beside pinocchio's C++: compiled code against compiled code, one arm, interleaved runs.

`python benches/native.py` compiles `benches/native/pinocchio.cpp` with `-O3 -march=native` and with `-O2`, against the
headers that `pip install pin cmeel-eigen` brings, and `benches/native/ravengc.rs`: our AVX2 and our portable build. It
gives all the same file of inputs, checks that they compute the same numbers, then runs them one by one, each operation
for 50 ms at a time, in an order that is new every round. A run goes through 256 poses, gravities and motions in turn.

Absolute times belong to the machine and its mood. The ratios are medians over rounds in which both sides ran.
"""

from __future__ import annotations

import random
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from comparison import agreement, command, machine
from comparison.arm import panda
from comparison.call import Call
from comparison.compiled import MissingToolError, Program, compiler_version, ours, pinocchio, write_inputs
from comparison.hot import ratio
from rich.box import SIMPLE_HEAD
from rich.table import Table

import ravengc as rg

if TYPE_CHECKING:
    from collections.abc import Iterator

    from comparison.arm import Array

EXAMPLE = "example: python benches/native.py --quick --json native.json"
OPERATIONS = {
    "gravity": ("gravity torque, new gravity", "computeGeneralizedGravity"),
    "kinematics": ("pose of the tool", "forwardKinematics, updateFramePlacement"),
    "jacobian": ("Jacobian of the tool", "computeFrameJacobian"),
    "inverse_dynamics": ("inverse dynamics, base at rest", "rnea"),
    "moving_base": ("inverse dynamics, moving base", "rnea, free-flyer"),
    "resolved_rate": ("damped resolved rate", "computeFrameJacobian, Eigen's LLT"),
}
"""What is timed, and what pinocchio calls it."""
SHAPES = {"kinematics": (4, 4), "jacobian": (6, -1)}
"""Of the results that are no vectors."""
FLAGS = (("-O3", "-march=native"), ("-O2",))


class Effort(NamedTuple):
    """How much is measured: rounds, and how long a program runs in each."""

    rounds: int = 40
    run_ms: int = 50


QUICK, SMALLEST = Effort(rounds=6), Effort(rounds=1, run_ms=1)

Pair = tuple[Program | None, Program]
"""pinocchio where it could be compiled, and our build that is compared with it."""
Times = dict[tuple[Program, str], "Array"]


def main() -> int:
    parser = command.parser(__doc__, "native")
    parser.epilog = EXAMPLE
    parser.add_argument("--quick", action="store_true", help="measure less, in a few seconds once all is compiled")
    parser.add_argument("--smallest", action="store_true", help=f"{command.SMALLEST}, compiles no C++")
    arguments = parser.parse_args()
    effort = SMALLEST if arguments.smallest else QUICK if arguments.quick else Effort()
    arm = panda()
    pairs, notes = compared(smallest=arguments.smallest)
    programs = list(dict.fromkeys(program for pair in pairs for program in pair if program))
    with tempfile.TemporaryDirectory() as folder:
        inputs = Path(folder, "inputs.txt")
        write_inputs(arm, inputs)
        say("checking that all compute the same numbers ...")
        found = agreement.differences(arm, list(computed(programs, inputs)))
        if wrong := agreement.disagreeing(found):
            say("not timed, because these differ from the reference by more than 1e-10:")
            say("\n".join(f"  {key}: {found[key]:.1e}" for key in wrong))
            return 1
        with machine.quiet(first=not arguments.smallest) as refused:
            times = race(programs, inputs, effort)
    results = {"machine": facts(), "notes": [*notes, *refused], "run_ms": effort.run_ms, "rows": rows(pairs, times)}
    show(results)
    command.write(arguments.json, results)
    return 0


def say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def compared(*, smallest: bool) -> tuple[list[Pair], list[str]]:
    """What this processor makes the best of on either side, then what runs on any; or a note what is missing."""
    best = "portable" if rg.INSTRUCTIONS == "portable" else "avx2"
    mine = ours(best, "portable", release=not smallest)
    try:
        return list(zip((pinocchio(*flags, build=not smallest) for flags in FLAGS), mine, strict=True)), []
    except MissingToolError as missing:
        return [(None, one) for one in mine], [str(missing)]


def computed(programs: list[Program], inputs: Path) -> Iterator[Call]:
    """What the programs compute, as calls that look it up."""
    for program in programs:
        for operation in OPERATIONS:
            numbers = program.numbers(inputs, operation)
            shaped = numbers.reshape(len(numbers), *SHAPES.get(operation, (-1,)))
            yield Call(program.library, operation, program.build, shaped.__getitem__, 0)


def race(programs: list[Program], inputs: Path, effort: Effort) -> Times:
    """Time of one call in every round, ns."""
    times = {(program, operation): np.empty(effort.rounds) for program in programs for operation in OPERATIONS}
    field = list(times)
    seconds = effort.rounds * len(field) * effort.run_ms / 1e3
    say(f"measuring {effort.rounds} rounds of {len(field)} runs, about {seconds:.0f} s ...")
    for number in range(effort.rounds):
        random.shuffle(field)
        for program, operation in field:
            times[program, operation][number] = program.nanoseconds(inputs, operation, effort.run_ms)
    return times


def facts() -> dict[str, object]:
    """What the numbers depend on."""
    compilers = {name: compiler_version(name) for name in ("g++", "rustc")}
    return {**machine.facts(), "compilers": compilers, "eigen": machine.installed("cmeel-eigen")}


def rows(pairs: list[Pair], times: Times) -> list[dict[str, Any]]:
    return [row(operation, peer, mine, times) for operation in OPERATIONS for peer, mine in pairs]


def row(operation: str, peer: Program | None, mine: Program, times: Times) -> dict[str, Any]:
    fast = times[mine, operation]
    found: dict[str, Any] = {"operation": operation, "ravengc": mine.build, "ravengc_ns": float(np.median(fast))}
    if peer is None:
        return found
    slow = times[peer, operation]
    found |= {"pinocchio": peer.build, "pinocchio_ns": float(np.median(slow)), "times_slower": ratio(slow, fast)}
    quartiles = np.percentile(slow / fast, [25, 75])
    return {**found, "times_slower_quartiles": quartiles.tolist(), "rounds": len(fast)}


def show(results: dict[str, Any]) -> None:
    console = command.console(140)
    about = results["machine"]
    versions = f"pinocchio {about['versions'].get('pin', '-')}, Eigen {about['eigen'] or '-'}"
    where = f"{about['processor']}, {about['cores']} cores"
    console.print(where, versions, *filter(None, about["compilers"].values()), sep="\n")
    for note in results["notes"]:
        console.print(f"note: {note}")
    console.print(table(results["rows"]))


def table(found: list[dict[str, Any]]) -> Table:
    """A row per operation, and beside each other the two comparisons."""
    title = "Seven-joint Panda, ns per call; x: times slower than ravengc, median over rounds"
    shown = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD)
    shown.add_column("operation", no_wrap=True)
    shown.add_column("pinocchio's call", no_wrap=True)
    first = next(iter(OPERATIONS))
    for one in found:
        if one["operation"] == first:
            for heading in (f"pinocchio {one.get('pinocchio', '-')}", f"ravengc {one['ravengc']}", "x"):
                shown.add_column(heading.replace(" ", "\n"), justify="right", no_wrap=True)
    for operation, names in OPERATIONS.items():
        shown.add_row(*names, *(cell for one in found if one["operation"] == operation for cell in cells(one)))
    return shown


def cells(one: dict[str, Any]) -> list[str]:
    mine = f"{one['ravengc_ns']:.0f}"
    if "pinocchio" not in one:
        return ["-", mine, "-"]
    return [f"{one['pinocchio_ns']:.0f}", mine, f"[bold]{one['times_slower']:.1f}[/]"]


if __name__ == "__main__":
    sys.exit(main())
