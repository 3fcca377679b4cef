"""From the options of ``ravengc stability`` to a linear system and its certificate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_vector
from ravengc.cli.common import quantity, waiting
from ravengc.cli.robot_options import coordinates_from, gravity_from, robot_from
from ravengc.control import drive_for
from ravengc.errors import ConfigError
from ravengc.stability import Certificate, Mount, Remedy, Sensing, System, certify, directions_of, linearise, remedies
from ravengc.stability.mount import HEAVIEST
from ravengc.stability.ranges import within
from ravengc.trajectory import swing_within_limits

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    import ravengc
    from ravengc.control import Drive

__all__ = ["Setup", "build"]

DEFAULT_DAMPING = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """What was asked, and the answer."""

    robot: ravengc.Robot
    q: list[float]
    drive: Drive
    mount: Mount
    law: str
    system: System
    certificate: Certificate
    remedies: tuple[Remedy, ...]

    @property
    def title(self) -> str:
        """Robot, law and base in a line."""
        directions = ", ".join(self.mount.names)
        return f"{self.robot.name}, {self.law}, base free in {directions}"


def build(args: argparse.Namespace) -> Setup:
    """Work everything out as the options say; errors of ravengc where they cannot be followed."""
    _check(args)
    robot = robot_from(args)
    if not any(link.mass for link in robot.spec.links):
        raise ConfigError(f"robot '{robot.name}' has no masses: its reaction on the base is not known")
    q = coordinates_from(args.q, robot.spec) if args.q else list(swing_within_limits(robot.spec).centre)
    mount, drive = _mount(args), _drive(args, robot, q)
    sensing = Sensing(
        rate_hz=args.rate,
        latency_s=quantity(args.latency, "time", "--latency"),
        cutoff_hz=args.cutoff,
        order=args.order,
        gain=args.share,
        loop_rate_hz=args.loop_rate,
    )
    place = _point(args.sensor_place, "--sensor-place")
    system = linearise(robot, q, drive, mount, sensing, law=args.law, gravity=gravity_from(args), sensor=place)
    with waiting("counting unstable poles"):
        certificate = certify(system)
        found = remedies(system)
    return Setup(robot, q, drive, mount, args.law, system, certificate, found)


def _check(args: argparse.Namespace) -> None:
    if args.robot is None:
        raise ConfigError("which robot? Give ROBOT, or --campaign for random cases")
    if args.base_mass is None:
        raise ConfigError("--base-mass is missing: what does the base weigh without the arm, kg?")
    if args.base_frequency is None and args.stiffness is None:
        raise ConfigError("give --base-frequency HZ, at which the base swings, or --stiffness N/m, which holds it")
    if args.plot is not None:
        from ravengc.reports.figures import check_picture

        check_picture(args.plot, "a picture of the certificate")


def _mount(args: argparse.Namespace) -> Mount:
    twists, names = directions_of(args.direction, _point(args.pivot, "--pivot"))
    ratio = DEFAULT_DAMPING if args.base_damping is None else args.base_damping
    lose: dict[str, Any] = {"damping_ratio": ratio} if args.damping is None else {"damping": args.damping}
    hold = {"frequency_hz": args.base_frequency, "stiffness": args.stiffness}
    mass = within(quantity(args.base_mass, "mass", "--base-mass"), "--base-mass", 0.0, HEAVIEST, "kg")
    return Mount(directions=twists, mass=mass, names=names, **hold, **lose)


def _drive(args: argparse.Namespace, robot: ravengc.Robot, q: Sequence[float]) -> Drive:
    options = {"natural_frequency_hz": args.natural_frequency, "damping_ratio": args.damping_ratio}
    drive = drive_for(robot, np.asarray(q), **options)
    own = {name: _gains(value, f"--{name}", robot.n) for name, value in (("kp", args.kp), ("kd", args.kd)) if value}
    return replace(drive, source="given", **own) if own else drive


def _gains(values: list[float], name: str, n: int) -> Any:
    if len(values) not in {1, n}:
        raise ConfigError(f"{name} has {len(values)} values; expected one, or {n} with commas between")
    return as_vector(np.broadcast_to(values, (n,)).copy(), name, n)


def _point(words: list[str] | None, what: str) -> tuple[float, ...]:
    return tuple(quantity(word, "length", what) for word in words) if words else (0.0, 0.0, 0.0)
