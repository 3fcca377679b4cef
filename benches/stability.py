"""The feedback certificate against its reference numbers and against time.

`python benches/stability.py` prints two tables: the reference example of a light base under one link and its variants,
and the campaign: 10,000 random cases, each certified and then simulated. The code is 1 if a number differs or if
something that is certified grows. `--cases N` flies fewer.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from ravengc.atomic import replacing
from ravengc.cli.stability_tables import show_campaign
from ravengc.stability import OneLink, Sensing, campaign, certify

OUT = Path(__file__).parents[1] / "out" / "stability.json"
EX1 = OneLink(
    base_mass=10.0,
    base_frequency_hz=2.5,
    base_damping_ratio=0.01,
    mass=2.0,
    length=0.4,
    inertia=0.37,
    kp=150.0,
    kd=3.0,
    sensing=Sensing(rate_hz=None, latency_s=0.02, cutoff_hz=10.0, order=1),
)


class Row(NamedTuple):
    """A variant of the example, and the real part of its pole, to four places."""

    title: str
    changes: dict[str, float]
    growth: float


ROWS = (
    Row("light base, 20 ms, 10 Hz", {}, 0.1696),
    Row("no latency, 100 Hz", {"latency_s": 0.0, "cutoff_hz": 100.0}, -0.1294),
    Row("base damping 0.05", {"base_damping_ratio": 0.05}, -0.3263),
    Row("stiffer joint", {"kp": 600.0, "kd": 12.0}, -0.0761),
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=10_000, metavar="N", help="cases of the campaign")
    parser.add_argument("--seed", type=int, default=0, help="its seed")
    arguments = parser.parse_args()
    table, same = examples()
    Console().print(table)
    with Progress(transient=True) as progress:
        task = progress.add_task("certifying and simulating", total=arguments.cases)
        tallies = campaign(
            arguments.cases, arguments.seed, on_progress=lambda done, _: progress.update(task, completed=done)
        )
    show_campaign(tallies, arguments.seed)
    OUT.parent.mkdir(exist_ok=True)
    with replacing(OUT) as path:
        path.write_text(json.dumps({"seed": arguments.seed, "kinds": [asdict(tally) for tally in tallies]}, indent=1))
    return 0 if same and all(tally.holds for tally in tallies) else 1


def examples() -> tuple[Table, bool]:
    """The example and its variants, and whether all are what they should be."""
    table = Table(
        "one link on a base", "pole, 1/s", "expected", "c_eff, N s/m", "margin, dB", "unstable", box=SIMPLE_HEAD
    )
    same = True
    for row in ROWS:
        found = certify(EX1.with_(**row.changes).system())
        same &= abs(found.pole.growth - row.growth) < 5e-5
        pole = f"{found.pole.growth:+.4f} ± {found.pole.s.imag:.3f}i"
        damping = f"{found.modes[0].effective_damping:.3f}"
        number = f"{found.count.number}{' proven' * found.count.proven}"
        table.add_row(row.title, pole, f"{row.growth:+.4f}", damping, f"{found.margin_db:+.2f}", number)
    return table, same


if __name__ == "__main__":
    sys.exit(main())
