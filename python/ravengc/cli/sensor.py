"""``ravengc sensor``: look at a base sensor's stream, and say what is wrong with it."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, console, new_table, plain, print_json, right

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

    from rich.table import Table

    from ravengc.sensors.watch import Watch

__all__ = ["add_parser", "run"]

DESCRIPTION = """\
Watch a base sensor through the same chain that a control loop uses: rate and
jitter, size and direction of what it feels, states, and every alarm with what
it means. A recording is read to its end at once, a live sensor for --seconds.

KIND:ADDRESS[?key=value&...] is one of
{kinds}"""

EXAMPLES = """\
  ravengc sensor replay:example:xio  # a real sensor, moved by hand
  ravengc sensor 'serial:/dev/ttyUSB0?format=line' --seconds 20
  ravengc sensor udp:14550?format=mavlink --json
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``sensor`` to the command line."""
    parser = command_parser(subparsers, "sensor", "watch a base sensor and say what is wrong", "", EXAMPLES)
    parser.set_defaults(func=run)
    parser.format_help = _with_kinds(parser)  # type: ignore[method-assign]
    add = parser.add_argument
    add("address", metavar="KIND:ADDRESS", help="which sensor")
    add("--seconds", metavar="S", type=float, help="how long to watch (default: 5, a recording to its end)")
    add("--robot", metavar="NAME|FILE", help="take the chain from the [accelerometer] table of this robot's file")
    add("--rate", metavar="HZ", type=float, help="declared sample rate (default: the file's, else 100)")
    add("--policy", choices=("paper", "strict"), help="policy of the chain (default: the file's, else paper)")
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def _with_kinds(parser: argparse.ArgumentParser) -> Callable[[], str]:
    """The description lists the kinds, which are imported only when help is asked for."""
    original = parser.format_help

    def format_help() -> str:
        from ravengc.sensors.kinds import KINDS

        kinds = "\n".join(f"  {kind.example:<42} {kind.about}" for kind in KINDS.values())
        parser.description = DESCRIPTION.format(kinds=kinds)
        return original()

    return format_help


def run(args: argparse.Namespace) -> int:
    """Watch, print what was seen; 1 if the sensor was never live or alarms stood at the end."""
    import ravengc
    from ravengc.cli.run_sensor import block_of, chain_of
    from ravengc.sensors.address import parse_address
    from ravengc.sensors.watch import watch

    block = block_of(ravengc.load(args.robot).spec.file if args.robot is not None else None)
    address = parse_address(args.address).with_defaults(unit=block.unit)
    rate = args.rate or block.rate_hz or 100.0
    own = {} if args.policy is None else {"policy": args.policy}
    chain = chain_of(block, rate, **own)
    show = _show_live if sys.stderr.isatty() and not args.json else None
    found = watch(address, chain, declared_hz=rate, seconds=args.seconds, on_tick=show)
    if args.json:
        print_json(plain(found.as_dict()))
    else:
        _show(found)
    return 0 if found.state == "live" else 1


def _show_live(found: Watch) -> None:
    norm = found.norms[-1] if found.norms else float("nan")
    tilt = f"{found.tilts[-1]:.1f} deg" if found.tilts else "-"
    text = f"{found.state:<9} {len(found.stamps):6d} samples  {found.rate_hz:6.1f} Hz  norm {norm:7.3f}  tilt {tilt}"
    sys.stderr.write(f"\r{text}   ")
    sys.stderr.flush()


def _show(found: Watch) -> None:
    if sys.stderr.isatty():
        sys.stderr.write("\n")
    out = console()
    for verdict in found.verdicts():
        out.print(verdict, style="bold", markup=False)
    out.print(_stream_table(found))
    if found.episodes:
        out.print(_alarm_table(found))


def _stream_table(found: Watch) -> Table:
    about = found.as_dict()
    table = new_table("stream", "", right(""))
    table.add_row("samples", f"{about['samples']}", "with angular velocity" if found.has_gyro else "")
    table.add_row("rate", f"{found.rate_hz:.2f} Hz", f"jitter {1e3 * found.jitter_s:.2f} ms")
    if (size := about["norm_m_s2"]) is not None:
        table.add_row("norm", f"{size['median']:.3f} m/s²", f"{size['lowest']:.3f} to {size['highest']:.3f}")
    if about["tilt_deg"] is not None:
        table.add_row("tilt", f"{about['tilt_deg']:.2f} deg", "median while live")
    for state, seconds in found.seconds.items():
        if seconds > 0.0:
            table.add_row(state, f"{seconds:.2f} s", "")
    for name, count in {**found.link, **found.counters}.items():
        if count and name not in {"samples", "received", "bytes_received"}:
            table.add_row(name, f"{count}", "")
    return table


def _alarm_table(found: Watch) -> Table:
    table = new_table(right("alarm at, s"), right("for, s"), "because")
    for episode in found.episodes:
        table.add_row(f"{episode.begin:.2f}", f"{episode.end - episode.begin:.2f}", episode.explained())
    return table
