"""``ravengc identify fit``: a robot's parameters from logs of its torques, and how far to trust them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, print_json
from ravengc.cli.identify_logs import ABOUT_LOGS, add_count_option, add_log_options, check_output
from ravengc.cli.identify_model import add_model_options
from ravengc.cli.identify_refusal import refusing
from ravengc.cli.progress import steps
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse

    from ravengc.cli.identify_fit_setup import Fit

__all__ = ["add_parser", "run"]

ABOUT = f"""\
Identify a robot's masses and friction from logs of its torques. Says how well
the result predicts what it was not fitted to, which parameters the logs do not
show or hardly tell apart, and what motion or tilt of the base would. A result
that predicts worse than a simpler one is refused.

{ABOUT_LOGS}

A model of gravity takes poses, best each passed upwards and downwards with
velocities recorded: friction cancels. Friction and dynamics take a motion in
which every joint moves far and not all together.
Estimators: ols (least squares), wls (weighted by every joint's error), huber
(bad rows count less), consistent (only what bodies can have; needs the extra
'identify')."""

EXAMPLES = """\
  ravengc identify fit dvrk_mtmr example:mtmr_tilts -o my_mtmr.toml
  ravengc identify fit panda example:panda --model gravity+friction
  ravengc identify fit arm.toml level.csv rolled.csv --tilt level \\
      --tilt "10 deg about x" --report out/arm
  ravengc identify fit arm.toml a.db3 --held-out b.db3 --model dynamics --rotor
  ravengc identify fit arm.toml wrist.csv elbow.csv --at wrist --at elbow

exit code: 0 good, 1 refused, 2 bad input
"""
ESTIMATORS = ("ols", "wls", "huber", "consistent")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``identify fit`` to the command line."""
    parser = command_parser(subparsers, "fit", "masses, friction, springs and cables", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", help="bundled robot, or a .toml or .urdf file, with its geometry")
    parser.add_argument("logs", metavar="LOG", nargs="+", help="recording of positions and torques, or example:NAME")
    _add_fit_options(add_model_options(parser))
    group = add_log_options(parser)
    group.add_argument(
        "--tilt",
        action="append",
        default=[],
        metavar="TILT",
        help='how the base stood, one for every LOG or for all: level, "10 deg about x"',
    )
    add_count_option(group)
    _add_output_options(parser.add_argument_group("output"))
    parser.set_defaults(func=run)


def _add_fit_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--estimator", choices=ESTIMATORS, default="wls", help="how (default: %(default)s)")
    add(
        "--held-out",
        metavar="SHARE|FILE",
        default="0.3",
        help="kept from the fit: the end of every motion, every so many-th pose, or another log (default: %(default)s)",
    )
    add(
        "--cutoff",
        metavar="HZ",
        default="auto",
        help="low-pass of motions, or none (default: 10 Hz or a tenth of the rate)",
    )
    add("--total-mass", metavar="MASS", help="most that all moving links weigh (consistent)")
    add("--reach", metavar="LENGTH", help="farthest a centre of mass is along an axis (consistent; default: 1 m)")


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument("-o", "--out", type=Path, metavar="FILE", help="write the robot with what was found (.toml)")
    group.add_argument(
        "--friction-share",
        type=float,
        default=0.0,
        metavar="SHARE",
        help="how much of the friction the written robot has for control laws to add, 0 to 1 (default: none of it; "
        "cables and offsets are always in it)",
    )
    group.add_argument(
        "--report", type=Path, metavar="DIR", help="write report.html, torques.png and .svg, results.json"
    )
    group.add_argument("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace) -> int:
    """Identify, print, and write what was asked for; 1 if the result is refused."""
    return refusing(args, _run)


def _run(args: argparse.Namespace) -> int:
    from ravengc.cli.identify_fit_setup import fitted
    from ravengc.cli.identify_fit_tables import describe, show

    _check_outputs(args)
    with steps("identifying", len(args.logs) + 2) as advance:
        fit = fitted(args, advance)
        about = describe(args, fit)
        if args.report is not None:
            from ravengc.reports.identify_report import write_report

            write_report(args.report, fit.found, fit.train, fit.held, about)
        advance("report")
    if args.out is not None and fit.why_no_file is None:
        fit.found.write(args.out, args.friction_share)
    print_json(about) if args.json else show(about)
    return _verdict(args, fit)


def _verdict(args: argparse.Namespace, fit: Fit) -> int:
    """0, or 1 if the result is refused or a robot file was asked for that cannot be."""
    return 1 if fit.found.refused is not None or (args.out is not None and fit.why_no_file is not None) else 0


def _check_outputs(args: argparse.Namespace) -> None:
    """Refuse what could not be written, before anything is read."""
    if args.out is not None:
        if args.out.suffix.lower() != ".toml":
            raise ConfigError(f"--out {args.out}: expected a name ending in .toml")
        check_output(args.out, "--out", args.logs)
    if args.report is not None:
        from ravengc.reports.figures import require_matplotlib

        require_matplotlib("the report of an identification")
        check_output(args.report / "report.html", "--report", args.logs)
