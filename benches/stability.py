"""The feedback certificate against its reference numbers and against time.

`python benches/stability.py` prints two tables: the reference example of a light base under one link and its variants,
and the campaign: 10,000 random cases, each certified and then simulated. The code is 1 if a number differs or if
something that is certified grows. `--cases N` flies fewer.
"""

from __future__ import annotations

import sys
from dataclasses import asdict

from comparison import command
from rich.box import SIMPLE_HEAD
from rich.table import Table

from ravengc.cli.stability import flown
from ravengc.cli.stability_tables import show_campaign
from ravengc.experiments.base_feedback import CASES, POLES, BaseFeedback, link_of
from ravengc.stability import certify


def main() -> int:
    parser = command.parser(__doc__, "stability")
    parser.add_argument("--cases", type=int, default=10_000, metavar="N", help="cases of the campaign")
    parser.add_argument("--seed", type=int, default=0, help="its seed")
    arguments = parser.parse_args()
    table, same = examples()
    command.console().print(table)
    tallies = flown(arguments.cases, arguments.seed)
    show_campaign(tallies, arguments.seed)
    command.write(arguments.json, {"seed": arguments.seed, "kinds": [asdict(tally) for tally in tallies]})
    return 0 if same and all(tally.holds for tally in tallies) else 1


def examples() -> tuple[Table, bool]:
    """The example and its variants, and whether all are what they should be."""
    table = Table(
        "one link on a base", "pole, 1/s", "expected", "c_eff, N s/m", "margin, dB", "unstable", box=SIMPLE_HEAD
    )
    same = True
    for case, expected in POLES.items():
        found, growth = certify(link_of(BaseFeedback(), case).system()), expected.real
        same &= abs(found.pole.growth - growth) < 5e-5
        pole = f"{found.pole.growth:+.4f} ± {found.pole.s.imag:.3f}i"
        damping = f"{found.modes[0].effective_damping:.3f}"
        number = f"{found.count.number}{' proven' * found.count.proven}"
        table.add_row(CASES[case][0], pole, f"{growth:+.4f}", damping, f"{found.margin_db:+.2f}", number)
    return table, same


if __name__ == "__main__":
    sys.exit(main())
