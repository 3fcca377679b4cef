"""``ravengc dvrk passive``: an MTM let go on tilted bases, with a calibration on tilted bases and a level-only one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, console, fixed, new_table, print_json, quantity, right

if TYPE_CHECKING:
    import argparse

    import numpy as np
    from numpy.typing import NDArray

    from ravengc.dvrk import Calibrated, Drift, PassiveRuns

__all__ = ["add_parser", "run"]

ABOUT = """\
Let an MTM go in simulation, on bases that stand level to upside down, with
nothing but its calibrated gravity torques, and measure how far the tool drifts.
Two calibrations of the same arm, with as many readings of the published grid
of poses: one with the base level and at four tilts, one on a level base alone.

The arm has the page's cables (as straight lines) and the smallest friction
that the published files show; that friction holds it where the error of the
torques is less. Poses are random within the calibrated range."""

EXAMPLES = """\
  ravengc dvrk passive --plot out/passive.png
  ravengc dvrk passive dvrk_mtml --seconds 5 --json
  ravengc dvrk passive --calibration-tilt "10 deg" --seed 3

exit code: 0 it stays within 1 mm at every tilt, 1 not, 2 bad input
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``dvrk passive`` to the command line."""
    parser = command_parser(subparsers, "passive", "an MTM let go on tilted bases", ABOUT, EXAMPLES)
    add = parser.add_argument
    add("robot", metavar="ROBOT", nargs="?", choices=("dvrk_mtml", "dvrk_mtmr"), default="dvrk_mtmr",
        help="dvrk_mtml or dvrk_mtmr (default: %(default)s)")  # fmt: skip
    add("--seconds", metavar="T", type=float, default=60.0, help="how long it is watched (default: %(default)g)")
    add("--calibration-tilt", metavar="ANGLE", default="20 deg", help="of the four tilts (default: %(default)s)")
    add("--seed", type=int, default=0, help="seed of noise and poses (default: %(default)s)")
    add("--plot", type=Path, metavar="FILE", help="draw the drift (.png, .svg, .pdf)")
    add("--json", action="store_true", help="print one JSON object instead of the tables")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> int:
    """Calibrate, let go, print, draw; 1 if the arm drifted."""
    import numpy as np
    from rich.console import Console
    from rich.progress import Progress

    from ravengc.dvrk import passive

    if args.plot is not None:
        from ravengc.reports.figures import check_picture

        check_picture(args.plot, "a picture of the drift")
    tilt = float(np.degrees(quantity(args.calibration_tilt, "angle", "--calibration-tilt")))
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("calibrating, letting go", total=None)
        found = passive(
            args.robot,
            seconds=args.seconds,
            calibration_tilt_deg=tilt,
            seed=args.seed,
            on_progress=lambda done, total: progress.update(task, completed=done, total=total),
        )
    if args.plot is not None:
        from ravengc.reports.dvrk_passive_plot import plot_passive

        plot_passive(args.plot, found)
    print_json(describe(found)) if args.json else _show(found, args.plot)
    return 0 if found.stays else 1


def describe(found: PassiveRuns) -> dict[str, Any]:
    """Everything as plain data, SI."""
    return {
        "robot": found.robot,
        "seconds": found.seconds,
        "stays": found.stays,
        "identified": _calibration(found.identified, found.with_identified, found.identified_shares),
        "level_only": _calibration(found.level_only, found.with_level_only, found.level_only_shares),
    }


def _calibration(calibration: Calibrated, runs: tuple[Drift, ...], shares: NDArray[np.float64]) -> dict[str, Any]:
    return {
        "shares_of_friction_at_any_tilt": shares,
        "tilts": calibration.tilts,
        "readings": calibration.readings,
        "rank": calibration.rank,
        "condition": calibration.condition,
        "runs": [
            {"tilt_deg": run.tilt_deg, "axis": list(run.axis), "q": run.q, "error": run.error, "drift": run.drift}
            for run in runs
        ],
    }


def _show(found: PassiveRuns, plot: Path | None) -> None:
    out = console()
    out.print(f"{found.robot}, let go for {found.seconds:g} s", style="bold")
    for title, one in (("tilted bases", found.identified), ("level base alone", found.level_only)):
        numbers = f"{one.readings} readings, {one.rank} base parameters, condition {one.condition:.0f}"
        out.print(f"calibrated on {title}: {numbers}", soft_wrap=True)
    headings = ("error tau2 N m", "drift mm", "level-only: error tau2 N m", "drift mm")
    table = new_table("base tilted", *map(right, headings))
    for good, bad in zip(found.with_identified, found.with_level_only, strict=True):
        where = f"{good.tilt_deg:g} deg about ({good.axis[0]:g}, {good.axis[1]:g})" if good.tilt_deg else "level"
        table.add_row(where, fixed(float(good.error[1]), 4), _drift(good), fixed(float(bad.error[1]), 4), _drift(bad))
    out.print(table)
    for title, runs, shares in (
        ("tilted bases", found.with_identified, found.identified_shares),
        ("level base alone", found.with_level_only, found.level_only_shares),
    ):
        stays, worst = sum(run.stays for run in runs), 1e3 * max(run.drift for run in runs)
        out.print(f"calibrated on {title}: {stays} of {len(runs)} within 1 mm, worst {worst:.2g} mm")
        out.print(_at_any_tilt(shares))
    if plot is not None:
        out.print(f"plot: {plot}", soft_wrap=True, markup=False)


def _at_any_tilt(shares: NDArray[np.float64]) -> str:
    from ravengc.dvrk.letting_go import SHARE_POSES

    joint, share = int(shares.argmax()) + 1, float(shares.max())
    verdict = "it stays however the base stands" if share < 1.0 else "there are tilts at which it does not stay"
    return f"  {SHARE_POSES} poses, any tilt: errors up to {share:.2f} of the friction (joint {joint}), {verdict}"


def _drift(run: Drift) -> str:
    millimetres = 1e3 * run.drift
    if millimetres > 99.0:
        return f"fell in {run.time[-1]:.2g} s"
    return f"{millimetres:.1e}" if millimetres < 0.01 else fixed(millimetres, 2)
