"""What is said before a run about its base: one that its own arm could shake (``--mount``), and how it tilts."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import numpy as np

from ravengc.cli.run_sensor import OWN, block_of, cutoff_of
from ravengc.control import LAWS
from ravengc.sim.base_motion import WORLD_GRAVITY, CarriedBase
from ravengc.stability import Sensing, check, parse_mount

if TYPE_CHECKING:
    import argparse

    import numpy.typing as npt

    from ravengc.cli.run_setup import Setup

__all__ = ["gravity_along", "mount_warnings", "warn"]

INSTANTS = 1000
"""At which the base of a run is looked at."""


def gravity_along(base: CarriedBase, duration: float) -> npt.NDArray[np.float64]:
    """The gravity field in base axes (m/s²) over the ``duration`` (s) of a run, (k, 3)."""
    return np.array([base.rotation(t).T @ WORLD_GRAVITY for t in np.linspace(0.0, duration, INSTANTS).tolist()])


def mount_warnings(args: argparse.Namespace, setup: Setup) -> tuple[str, ...]:
    """Certify the run's configuration at its first pose on the mount of ``--mount``; () without one."""
    if args.mount is None:
        return ()
    base = setup.plant.base
    at_origin = args.sensor != OWN or LAWS[args.controller].turning  # the chain takes out the lever arm
    return check(
        setup.robot,
        parse_mount(args.mount),
        _sensing(args, setup),
        q=setup.plant.q,
        drive=setup.drive,
        law=args.controller,
        gravity=base.rotation(0.0).T @ WORLD_GRAVITY if isinstance(base, CarriedBase) else WORLD_GRAVITY,
        sensor=(0.0, 0.0, 0.0) if at_origin else args.sensor_place,
    )


def warn(warnings: tuple[str, ...]) -> None:
    """Write the warnings to standard error: the first says what is wrong, the others what to change."""
    for i, text in enumerate(warnings):
        sys.stderr.write(f"ravengc: warning: {text}\n" if i == 0 else f"  {text}\n")


def _sensing(args: argparse.Namespace, setup: Setup) -> Sensing:
    """The chain of the run: the plant's own sensor as the options say, any other as the robot's file declares it."""
    block = block_of(setup.robot.spec.file)
    rate = args.sensor_rate if args.sensor == OWN else block.rate_hz or 100.0
    return Sensing(rate_hz=rate, cutoff_hz=cutoff_of(args, block), loop_rate_hz=args.rate)
