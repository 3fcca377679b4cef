"""``ravengc track``: visit the points of a surface that moves, and measure how well it was followed."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ravengc.cli.common import command_parser, print_json, waiting
from ravengc.errors import RavenGCError

if TYPE_CHECKING:
    from ravengc.cli.track_runs import Runs
    from ravengc.cli.track_setup import Setup

__all__ = ["add_parser", "run"]

ABOUT = """\
Send an arm to every point of a surface that moves, and let it stay there with
no motion relative to it: the tool goes for where a camera's late, noisy
pictures say the point will be. Prints how much was covered, the time per
point, and how far the tool was from the true point while it stayed.

Without options this is LIVER-500: 500 points of a liver-sized surface that
breathes 15 mm in 4 s, seen 30 times a second, 60 ms late, by a Panda."""

EXAMPLES = """\
  ravengc track  # LIVER-500
  ravengc track --baseline --out out/track  # beside the naive chase; a report
  ravengc track --quick --mode palpate
  ravengc track --surface scan.ply --units mm --at 0.5,0,0.3 --points 300
  ravengc track --motion example:breathing --predictor autoregressive --json
  ravengc track --seeds 10  # the mean of ten runs
  ravengc track --quick --view out/view.html  # to look at in three dimensions

exit code: 0 good, 1 too little covered or a joint beyond a limit, 2 bad input,
130 after Ctrl-C: what was done until then is printed and written
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``track`` to the command line."""
    parser = command_parser(subparsers, "track", "follow a moving surface, point by point", ABOUT, EXAMPLES)
    parser.set_defaults(func=run)
    _add_surface_options(parser.add_argument_group("surface"))
    _add_motion_options(parser.add_argument_group("motion"))
    _add_run_options(parser.add_argument_group("arm and runs"))
    _add_output_options(parser.add_argument_group("output"))


def _add_surface_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--surface",
        metavar="FILE",
        help="cloud of points, with normals if it has them: PLY, XYZ, CSV, or example:organ (default: LIVER-500)",
    )
    add("--singular", action="store_true", help="LIVER-500-S: the same where the arm is nearly singular")
    add("--units", metavar="UNIT", help="of the cloud: m, cm or mm (default: as the file says, else by its size)")
    add("--points", metavar="N", type=_count, help="visit at most so many, spread evenly (default: 500)")
    add(
        "--at",
        metavar="X,Y,Z",
        type=_vector,
        help="put the middle of the cloud there, m, base axes (default: where it is, if the arm can reach it)",
    )
    add("--turn", metavar="R,P,Y", type=_vector, help="turn the cloud about its middle: roll, pitch, yaw, deg")
    add(
        "--facing",
        metavar="X,Y,Z",
        type=_vector,
        help="side on which normals that the file lacks end, axes of the file (default: 0,0,1)",
    )


def _add_motion_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--motion",
        metavar="MOTION",
        default="lujan",
        help="lujan or lujan:AMPLITUDE:PERIOD (m, s), still, or a recording: CSV, npz, example:breathing, "
        "example:heart (default: %(default)s)",
    )
    add("--motion-units", metavar="UNIT", help="of the recording: m, cm or mm (default: by its size)")
    add("--motion-rate", metavar="HZ", type=float, help="samples per second of a recording without times")
    add(
        "--strict",
        action="store_true",
        help="refuse clouds and recordings with missing, repeated or zero numbers or times out of order, do not mend "
        "them",
    )


def _add_run_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--robot", metavar="NAME|FILE", default="panda", help="bundled robot or robot file (default: %(default)s)")
    add("--mode", choices=("scan", "palpate"), help="stay at each point, or press into it (default: scan)")
    add("--predictor", metavar="NAME", help="how the surface is predicted (default: switch, the lately best)")
    add("--baseline", action="store_true", help="also the naive chase of the last picture, by steps of constant size")
    add("--oracle", action="store_true", help="also with the true place of the surface: what prediction costs")
    add("--seed", metavar="N", type=_seed, default=0, help="of breaths and noise (default: %(default)s)")
    add("--seeds", metavar="N", type=_count, default=1, help="run so many seeds and print the mean (default: 1)")
    add("--quick", action="store_true", help="60 points and two short hold tests")
    add("--settings", metavar="FILE", type=Path, help="TOML file with tables [track] and [camera] of settings")
    add("--list-settings", action="store_true", help="print those settings, with units and ranges, and stop")


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add(
        "--out",
        metavar="DIR",
        type=Path,
        help="write report.html, track.png, track.svg and results.json there, and view.html where viser is installed",
    )
    add("--view", metavar="FILE", type=Path, help="write a view to play back in three dimensions (.html; needs viser)")
    add(
        "--least-coverage",
        metavar="PERCENT",
        type=float,
        default=95.0,
        help="exit code 1 below (default: %(default)g)",
    )
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace) -> int:
    """Run, print, write; 1 if too little was covered or a joint went beyond a limit."""
    from ravengc.cli.track_runs import run_all
    from ravengc.cli.track_setup import build
    from ravengc.cli.track_tables import describe, list_settings, show

    _check_output(args)
    if args.list_settings:
        return list_settings(as_json=args.json)
    setup = build(args)
    runs = run_all(setup)
    about = describe(setup, runs)
    failure = _write(args, setup, runs, about)
    if args.json:
        print_json(about)
    else:
        show(about)
    if failure is not None:
        raise failure
    if runs.interrupted:
        return 130
    return 0 if about["holds"] else 1


def _check_output(args: argparse.Namespace) -> None:
    """Find out before the run that a file could not be written, or that a package is missing."""
    if not 0.0 <= args.least_coverage <= 100.0:
        from ravengc.errors import ConfigError

        raise ConfigError(f"--least-coverage is {args.least_coverage:g}; expected 0 to 100 %")
    if args.out is not None:
        from ravengc.atomic import check_writable
        from ravengc.cli.track_files import FILES
        from ravengc.reports.figures import check_picture

        check_picture(args.out / "track.png", "the report")
        for name in FILES:
            check_writable(args.out / name)
    if args.view is not None:
        from ravengc.reports.track_view import check_view

        check_view(args.view)


def _write(
    args: argparse.Namespace, setup: Setup, runs: Runs, about: dict[str, Any]
) -> RavenGCError | KeyboardInterrupt | None:
    """Write the files and list them; return what kept them from it, so that a run's numbers are printed even then."""
    about["files"] = []
    try:
        about["files"] = [str(path) for path in _written(args, setup, runs, about)]
    except RavenGCError as error:
        return error
    except KeyboardInterrupt as error:
        about["interrupted"] = "stopped by Ctrl-C while the files were written"
        about["problems"].append(about["interrupted"])
        return error
    return None


def _written(args: argparse.Namespace, setup: Setup, runs: Runs, about: dict[str, Any]) -> list[Path]:
    """The files that were asked for, each whole or not at all."""
    from ravengc.reports.track_view import write_view

    main = next(iter(runs.first.values()))
    view: Path | None = args.view
    if view is None and args.out is not None and _has_viser():
        view = args.out / "view.html"
    if view is not None:
        with waiting(f"drawing {view}"):
            write_view(view, main, setup.robot)
    views = [] if view is None else [view]
    if args.out is None:
        return views
    from ravengc.cli.track_files import write_folder

    return [*write_folder(args.out, setup, runs.first, about, view), *views]


def _has_viser() -> bool:
    from importlib.util import find_spec

    return find_spec("viser") is not None


def _vector(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not three numbers with commas between, such as 0.5,0,0.3"
        ) from None
    return x, y, z


def _count(text: str) -> int:
    return _whole(text, 1)


def _seed(text: str) -> int:
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    number = int(text) if text.isdecimal() and text.isascii() and len(text) < 8 else least - 1
    if number < least:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from {least} to 9999999")
    return number
