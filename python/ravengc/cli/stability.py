"""``ravengc stability``: is the feedback from the base's accelerometer over the arm to the base stable?"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, print_json
from ravengc.cli.robot_options import add_gain_options, add_gravity_options, add_robot_options

if TYPE_CHECKING:
    from ravengc.cli.stability_setup import Setup
    from ravengc.stability import Tally

__all__ = ["add_parser", "flown", "run"]

ABOUT = """\
Certify that an arm whose gravity torque follows its base's accelerometer does
not shake the base that carries it. The accelerometer feels the base, the torque
follows, the arm pushes back on the base: on a light, weakly damped base and
with a late sensor that grows. Proven by counting the unstable poles, delay
included, for one pose; says how far it is from instability and what to change.

The stiffness is that of the base with the arm on it. For turning directions
(rx, ry, rz) mass, stiffness and damping are kg m^2, N m/rad and N m s/rad."""

EXAMPLES = """\
  ravengc stability raven2_gold --base-mass 15 --base-frequency 2 --direction y
  ravengc stability panda --base-mass 20 --base-frequency 2.5 \\
      --base-damping 0.01 --latency 30ms --cutoff 10 --plot out/panda.png
  ravengc stability raven2_gold --base-mass 5 --stiffness 2300 --direction x,ry
  ravengc stability --campaign 1000  # random cases, certified and simulated

exit code: 0 certified, 1 not certified, 2 bad input
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``stability`` to the command line."""
    parser = command_parser(subparsers, "stability", "does the sensor's feedback shake the base?", ABOUT, EXAMPLES)
    parser.add_argument("robot", metavar="ROBOT", nargs="?", help="bundled robot, or a .toml or .urdf file")
    add_robot_options(parser)
    _add_base_options(parser.add_argument_group("base"))
    _add_arm_options(parser.add_argument_group("arm and law"))
    _add_sensor_options(parser.add_argument_group("accelerometer"))
    add_gravity_options(parser)
    _add_output_options(parser.add_argument_group("output"))
    parser.set_defaults(func=run)


def _add_base_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--base-mass", metavar="MASS", help='mass of the base without the arm: 15 (kg) or "900 g"')
    hold = group.add_mutually_exclusive_group()
    hold.add_argument("--base-frequency", metavar="HZ", type=float, help="at which it swings with the arm on it")
    hold.add_argument("--stiffness", metavar="K", type=float, help="instead: of what holds it, N/m")
    lose = group.add_mutually_exclusive_group()
    lose.add_argument(
        "--base-damping", metavar="ZETA", type=float, help="its damping ratio (default: 0.01, a bare steel frame)"
    )
    lose.add_argument("--damping", metavar="C", type=float, help="instead: its damping, N s/m")
    add(
        "--direction",
        metavar="D",
        default="x,y,z",
        help="what it can do: along x, y, z and about rx, ry, rz with commas between, or along a vector X,Y,Z "
        "(default: %(default)s)",
    )
    add(
        "--pivot",
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="point it turns about, base axes (m; default: the base origin)",
    )


def _add_arm_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--q", nargs="+", metavar="Q", help='pose: 0.3, "30 deg", "0.4 m" (default: the middle of every range)')
    add(
        "--law",
        default="pd+dg",
        help="pd, pd+sg (static gravity), pd+dg (dynamic gravity) or pd+bm (full motion of the base); default: "
        "%(default)s",
    )
    add_gain_options(group)
    add("--kp", metavar="K[,K...]", type=_numbers, help="proportional gains at the joints, N m/rad or N/m")
    add("--kd", metavar="D[,D...]", type=_numbers, help="derivative gains at the joints, N m s/rad or N s/m")


def _add_sensor_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--rate", metavar="HZ", type=float, default=100.0, help="samples per second (default: %(default)g)")
    add(
        "--latency",
        metavar="T",
        default="0",
        help='age of a sample when it is used first: 0.02 (s) or "20 ms" (default: 0)',
    )
    add("--cutoff", metavar="HZ", type=float, help="cut-off of the low-pass (default: none)")
    add("--order", type=int, choices=(1, 2), default=2, help="order of the low-pass (default: 2, the chain's own)")
    add(
        "--share",
        metavar="RHO",
        type=float,
        default=1.0,
        help="how much of what is measured beyond gravity at rest the law takes: 1 all, 0 none (default: %(default)g)",
    )
    add("--loop-rate", metavar="HZ", type=float, default=1000.0, help="cycles per second (default: %(default)g)")
    add(
        "--sensor-place",
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="place of a sensor without lever-arm correction, base axes (m; default: the base origin)",
    )


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--plot", type=Path, metavar="FILE", help="draw Nyquist, Bode, poles and damping (.png, .svg, .pdf)")
    add(
        "--campaign",
        metavar="N",
        type=int,
        nargs="?",
        const=10_000,
        help="instead: certify and simulate N random cases (default: 10000); 1 if one that is certified grows",
    )
    add("--seed", type=int, default=0, help="seed of the campaign (default: %(default)s)")
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def run(args: argparse.Namespace) -> int:
    """Certify, print, draw; 1 without a certificate."""
    if args.campaign is not None:
        return _campaign(args)
    from ravengc.cli.stability_setup import build
    from ravengc.cli.stability_tables import describe, show

    setup = build(args)
    about = describe(setup)
    if args.plot is not None:
        _plot(args.plot, setup)
        about["plot"] = str(args.plot)
    print_json(about) if args.json else show(setup, about)
    return 0 if setup.certificate.certified else 1


def _plot(path: Path, setup: Setup) -> None:
    from ravengc.reports.stability_plot import plot_stability

    plot_stability(path, setup.system, setup.certificate, title=setup.title)


def _campaign(args: argparse.Namespace) -> int:
    from dataclasses import asdict

    from ravengc.cli.stability_tables import show_campaign

    tallies = flown(args.campaign, args.seed)
    if args.json:
        print_json({"seed": args.seed, "kinds": [asdict(tally) for tally in tallies]})
    else:
        show_campaign(tallies, args.seed)
    return 0 if all(tally.holds for tally in tallies) else 1


def flown(cases: int, seed: int) -> tuple[Tally, ...]:
    """Fly the campaign, and show on standard error how far it has come."""
    from rich.console import Console
    from rich.progress import Progress

    from ravengc.stability import campaign

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("certifying and simulating", total=cases)
        return campaign(cases, seed, on_progress=lambda done, _: progress.update(task, completed=done))


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number or numbers with commas between") from None
