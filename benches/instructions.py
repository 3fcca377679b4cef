"""Instructions per call of every function and per step of a control law, counted by callgrind: a figure that no other
process and no clock can move. `_sample`: a step whose sensor slot holds a sample.

`python benches/instructions.py` builds `benches/instructions.rs`, runs it under valgrind, and prints the portable and
the AVX2+FMA build at 3, 6 and 7 joints, with the spread between poses: how much a cycle's work depends on its data.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np
from comparison import command
from rich.table import Table

COUNTED = "instructions::counted"
PLAIN_COPIES = "glibc.cpu.x86_rep_stosb_threshold=1000000000:glibc.cpu.x86_rep_movsb_threshold=1000000000"
"""Valgrind counts `rep stosb` once per byte; with these thresholds the C library fills and copies by vectors."""
CONFIGURATIONS = {"gravity_torques": 8}
"""How many configurations one call serves, where it is not one."""
LEVELS = ("portable", "avx2")
"""The builds that valgrind can run; AVX-512 is beyond it."""


class Case(NamedTuple):
    """What was counted, but for the pose and the number of calls."""

    function: str
    level: str
    joints: int


def main() -> int:
    parser = command.parser(__doc__, "instructions")
    parser.add_argument("--only", metavar="FUNCTION", help="count this one alone (gravity_torque, jacobian, ...)")
    parser.add_argument("--smallest", action="store_true", help="in the build of the tests: shows that it counts")
    arguments = parser.parse_args()
    if shutil.which("valgrind") is None:
        print("note: valgrind is not installed: no instructions counted (Debian: apt install valgrind)")
        return 0
    program = command.example("instructions", release=not arguments.smallest)
    named = [tuple(line.split()) for line in command.output([str(program)]).splitlines()]
    functions = list(dict.fromkeys(function for function, _ in named))
    if arguments.only not in {None, *functions}:
        parser.error(f"no function {arguments.only}; there are {', '.join(functions)}")
    counts: dict[Case, list[float]] = {}
    for function, level in named:
        if level in LEVELS and arguments.only in {None, function}:
            counts |= count(program, function, level)
    show(counts)
    command.write(arguments.json, [report(case, poses) for case, poses in counts.items()])
    return 0


def count(program: Path, function: str, level: str) -> dict[Case, list[float]]:
    """Instructions per configuration, pose by pose: the difference of a long and a short block, divided."""
    totals: dict[Case, dict[int, dict[int, int]]] = defaultdict(lambda: defaultdict(dict))
    with tempfile.TemporaryDirectory() as folder:
        options = [f"--toggle-collect={COUNTED}", f"--dump-after={COUNTED}", f"--callgrind-out-file={folder}/part"]
        called = ["valgrind", "-q", "--tool=callgrind", "--collect-atstart=no", *options, str(program), function, level]
        done = run(called)
        if done.returncode == -signal.SIGILL:
            print(f"{function}, {level}: not counted, this valgrind lacks one of its instructions", file=sys.stderr)
            return {}
        if done.returncode:
            raise SystemExit(f"valgrind failed with code {done.returncode} on {function}, {level}")
        for number, line in enumerate(done.stdout.splitlines(), start=1):
            joints, pose, calls = map(int, line.split())
            totals[Case(function, level, joints)][pose][calls] = total(Path(folder, f"part.{number}"))
    return {case: [per_call(case, blocks) for blocks in poses.values()] for case, poses in totals.items()}


def total(part: Path) -> int:
    """Instructions in one block, from the file that callgrind wrote at its end."""
    for line in part.read_text().splitlines():
        if line.startswith("totals: "):
            return int(line.removeprefix("totals: "))
    raise SystemExit(f"{part}: callgrind wrote no totals")


def per_call(case: Case, blocks: dict[int, int]) -> float:
    few, many = sorted(blocks)
    return (blocks[many] - blocks[few]) / (many - few) / CONFIGURATIONS.get(case.function, 1)


def spread(poses: list[float]) -> float:
    """Largest count over smallest, less one, in percent."""
    return 100.0 * (max(poses) / min(poses) - 1.0)


def report(case: Case, poses: list[float]) -> dict[str, object]:
    return {**case._asdict(), "instructions": float(np.median(poses)), "spread_percent": spread(poses), "poses": poses}


def show(counts: dict[Case, list[float]]) -> None:
    levels = [level for level in LEVELS if any(case.level == level for case in counts)]
    sizes = sorted({case.joints for case in counts})
    table = Table(title="Instructions per call (batch kernels: per configuration), median of the poses")
    table.add_column("function", no_wrap=True)
    for level in levels:
        for joints in sizes:
            table.add_column(f"{level}\n{joints}", justify="right")
        table.add_column("spread\n%", justify="right")
    for function in dict.fromkeys(case.function for case in counts):
        row = [cells(counts, function, level, sizes) for level in levels]
        table.add_row(function, *(cell for part in row for cell in part))
    command.console().print(table)


def cells(counts: dict[Case, list[float]], function: str, level: str, sizes: list[int]) -> list[str]:
    """The medians for all sizes of robot, then the largest spread among them."""
    poses = [counts.get(Case(function, level, joints), []) for joints in sizes]
    if not all(poses):
        return ["-"] * (len(sizes) + 1)
    return [*(f"{np.median(one):.0f}" for one in poses), f"{max(map(spread, poses)):.1f}"]


def run(called: list[str]) -> subprocess.CompletedProcess[str]:
    """Run a program whose C library fills and copies in the way that valgrind counts right."""
    environment = {**os.environ, "GLIBC_TUNABLES": PLAIN_COPIES}
    return subprocess.run(  # noqa: S603
        called, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False
    )


if __name__ == "__main__":
    sys.exit(main())
