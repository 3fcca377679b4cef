"""``ravengc sensor``: look at a base sensor's stream, and say what is wrong with it."""

from __future__ import annotations

import argparse
import math
import sys
import textwrap
from typing import TYPE_CHECKING

from ravengc.cli.common import command_parser, console, new_table, plain, print_json, right

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.table import Table

    from ravengc.calibration.block import AccelerometerBlock
    from ravengc.sensors.seen import Watch

__all__ = ["add_parser", "run"]

MOST_ALARMS = 100
COUNTED = {
    "accepted": "samples that passed every check",
    "other_frames": "good frames of another content",
    "bad_checksum": "frames with a wrong checksum",
    "bad_content": "whole frames that make no sense",
    "unconfirmed": "frames left out as they came right behind garbage",
    "resynchronisations": "good frames found behind bytes that belong to none",
    "bytes_skipped": "bytes that belong to no good frame",
    "frames_lost": "frames that never came, by the sensor's own counter",
    "clock_restarts": "jumps of the sensor's own clock",
    "foreign_datagrams": "datagrams from another sender than the first",
}
"""What the counters count that are no faults."""

DESCRIPTION = """\
Watch a base sensor through the same chain that a control loop uses: rate and
jitter, size and direction of what it feels, states, and every alarm with what
it means. A recording is read to its end at once, a live sensor for --seconds.

KIND:ADDRESS[?key=value&...] is one of these, in quotes, as shells take ? and &
for their own:
{kinds}

format=, for the kinds that give bytes:
{formats}

With --robot FILE, the chain is the one in the [accelerometer] table of that
file, and so is the sensor, unless KIND:ADDRESS names another. The table may be

  [accelerometer]
  sensor = "serial:/dev/ttyUSB0?format=line"
  rate_hz = 100
  rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]  # base axes <- sensor axes
  policy = "strict"

{keys}:
'python -m pydoc ravengc.calibration.block' shows each with its unit.
'ravengc run --robot FILE' runs with the same sensor and the same chain."""

EXAMPLES = """\
  ravengc sensor replay:example:xio  # a real sensor, moved by hand
  ravengc sensor 'serial:/dev/ttyUSB0?format=line' --seconds 20
  ravengc sensor 'udp:14550?format=mavlink&axes=x,-y,-z' --json
  ravengc sensor --robot my_arm.toml  # the sensor and the chain of that file
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``sensor`` to the command line."""
    parser = command_parser(subparsers, "sensor", "watch a base sensor and say what is wrong", "", EXAMPLES)
    parser.set_defaults(func=run)
    parser.format_help = _with_kinds(parser)  # type: ignore[method-assign]
    add = parser.add_argument
    add("address", metavar="KIND:ADDRESS", nargs="?", help="which sensor (default: the one that --robot's file names)")
    add("--seconds", metavar="S", type=_positive, help="how long to watch (default: 5, a recording to its end)")
    add(
        "--robot", metavar="NAME|FILE", help="take chain and sensor from the [accelerometer] table of this robot's file"
    )
    add("--rate", metavar="HZ", type=_positive, help="declared sample rate (default: the file's, else 100)")
    add("--policy", choices=("paper", "strict"), help="policy of the chain (default: the file's, else paper)")
    add("--json", action="store_true", help="print one JSON object instead of the tables")


def _positive(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number")
    return number


def _with_kinds(parser: argparse.ArgumentParser) -> Callable[[], str]:
    """The description lists the kinds, which are imported only when help is asked for."""
    original = parser.format_help

    def format_help() -> str:
        from ravengc.calibration.block import KEYS
        from ravengc.sensors.decoders import FORMATS
        from ravengc.sensors.kinds import KINDS

        shown = {"sensor", "rate_hz", "rotation", "policy"}
        keys = textwrap.fill("and may have " + ", ".join(key for key in KEYS if key not in shown), 78)
        kinds = "\n".join(f"  {kind.example}\n      {kind.about}" for kind in KINDS.values())
        formats = "\n".join(f"  {name:<10} {form.about} ({form.baud} baud)" for name, form in FORMATS.items())
        parser.description = DESCRIPTION.format(kinds=kinds, formats=formats, keys=keys)
        return original()

    return format_help


def run(args: argparse.Namespace) -> int:
    """Watch, print what was seen; 1 if the sensor was not live at the end."""
    from ravengc.cli.run_sensor import DEFAULT_RATE_HZ, address_of, chain_of
    from ravengc.sensors.verdicts import as_data
    from ravengc.sensors.watch import watch

    block = _block(args.robot)
    rate = args.rate or block.rate_hz
    address = address_of(_named(args, block), block, rate)
    own = {} if args.policy is None else {"policy": args.policy}
    declared_hz = rate or DEFAULT_RATE_HZ
    chain = chain_of(block, declared_hz, **own)
    show = _show_live if sys.stderr.isatty() and not args.json else None
    found = watch(address, chain, declared_hz=declared_hz, seconds=args.seconds, on_tick=show)
    if args.json:
        print_json(plain(as_data(found)))
    else:
        _show(found)
    return 0 if found.state == "live" else 1


def _block(robot: str | None) -> AccelerometerBlock:
    import ravengc
    from ravengc.cli.run_sensor import block_of

    return block_of(ravengc.load(robot).spec.file if robot is not None else None)


def _named(args: argparse.Namespace, block: AccelerometerBlock) -> str:
    """The address that is given, or that the robot's file gives."""
    from ravengc.errors import ConfigError

    text = args.address or block.sensor
    if not text and args.robot is not None:
        raise ConfigError(
            f'{args.robot} names no sensor: give KIND:ADDRESS, or write sensor = "KIND:ADDRESS" in its '
            "[accelerometer] table (ravengc sensor --help lists the kinds)"
        )
    if not text:
        raise ConfigError(
            "which sensor? Give KIND:ADDRESS, or --robot FILE with one (ravengc sensor --help lists them)"
        )
    if args.address and ":" not in text and text.endswith((".toml", ".urdf")):
        raise ConfigError(f"{text} is a robot's file; did you mean --robot {text}?")
    return str(text)


def _show_live(found: Watch) -> None:
    norm = f"{found.norms[-1]:.3f}" if found.norms else "-"
    tilt = f"{found.tilts[-1]:.1f} deg" if found.tilts else "-"
    rate = _finite(found.recent_hz, "{:.1f} Hz")
    text = f"{found.state:<9} {found.count:6d} samples  {rate:>10}  norm {norm:>7}  tilt {tilt}"
    sys.stderr.write(f"\r{text}   ")
    sys.stderr.flush()


def _show(found: Watch) -> None:
    if sys.stderr.isatty():
        sys.stderr.write("\n")
    from ravengc.sensors.verdicts import verdicts

    out = console()
    for verdict in verdicts(found):
        out.print(verdict, style="bold", markup=False)
    out.print(_stream_table(found))
    if found.episodes:
        out.print(_alarm_table(found))


def _stream_table(found: Watch) -> Table:
    import ravengc

    table = new_table("stream", "", "")
    table.add_row("samples", f"{found.count}", "with angular velocity" if found.has_gyro else "")
    jitter = _finite(1e3 * found.jitter_s, "jitter {:.2f} ms")
    table.add_row("rate", _finite(found.rate_hz, "{:.2f} Hz"), jitter)
    if math.isfinite(found.norm):
        table.add_row("norm", f"{found.norm:.3f} m/s²", f"{found.lowest:.3f} to {found.highest:.3f}")
    if found.tilt is not None:
        table.add_row("tilt", f"{found.tilt:.2f} deg", "median while live")
    for state, seconds in found.seconds.items():
        if seconds > 0.0:
            table.add_row(state, f"{seconds:.2f} s", "")
    for name, count in {**found.link, **found.counters}.items():
        if count and name not in {"samples", "received", "bytes_received"}:
            table.add_row(name, f"{count}", ravengc.FAULTS.get(name) or COUNTED.get(name, ""))
    return table


def _finite(number: float, form: str) -> str:
    return form.format(number) if math.isfinite(number) else "-"


def _alarm_table(found: Watch) -> Table:
    table = new_table(right("alarm at, s"), right("for, s"), "because")
    for episode in found.episodes[:MOST_ALARMS]:
        table.add_row(f"{episode.begin:.2f}", f"{episode.end - episode.begin:.2f}", episode.explained())
    if found.alarms > MOST_ALARMS:
        table.add_row("...", "", f"and {found.alarms - MOST_ALARMS} more (--json lists them)")
    return table
