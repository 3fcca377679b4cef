"""Calibration of a base accelerometer: bias, scale, misalignment, mounting rotation, and where on the base it sits.

>>> from ravengc import calibration
>>> outcome = calibration.calibrate_accelerometer(calibration.read_imu("positions.csv"))
>>> calibration.write_block("my_arm.toml", outcome.block())

The model is f = S (s - b): the reading s, the bias b (m/s²), scale and misalignment S near 1, and f the specific force
in sensor axes, of length g at rest; R f is in base axes. What data do not determine is refused with what is missing, by
:class:`ravengc.errors.CalibrationError`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ravengc.calibration.block import AccelerometerBlock, read_block, write_block
    from ravengc.calibration.ellipsoid import fit_ellipsoid
    from ravengc.calibration.imu import ImuRecording, from_samples
    from ravengc.calibration.imu_files import ReadOptions, read_imu
    from ravengc.calibration.kabsch import Mounting, mounting_rotation
    from ravengc.calibration.lever_arm import LeverArm, fit_lever_arm
    from ravengc.calibration.positions import Position, coverage_deg, missing_faces, still_positions
    from ravengc.calibration.procedure import Outcome, calibrate_accelerometer
    from ravengc.calibration.result import Calibration
    from ravengc.calibration.session import ask_for_faces, ask_for_positions, ask_for_tilts, record
    from ravengc.calibration.six import fit_six_positions
    from ravengc.calibration.still import StillLimits, StillSegment, still_segments
    from ravengc.calibration.tilts import fit_tilts, tilted_force

__all__ = [
    "AccelerometerBlock",
    "Calibration",
    "ImuRecording",
    "LeverArm",
    "Mounting",
    "Outcome",
    "Position",
    "ReadOptions",
    "StillLimits",
    "StillSegment",
    "ask_for_faces",
    "ask_for_positions",
    "ask_for_tilts",
    "calibrate_accelerometer",
    "coverage_deg",
    "fit_ellipsoid",
    "fit_lever_arm",
    "fit_six_positions",
    "fit_tilts",
    "from_samples",
    "missing_faces",
    "mounting_rotation",
    "read_block",
    "read_imu",
    "record",
    "still_positions",
    "still_segments",
    "tilted_force",
    "write_block",
]

_HOMES = {
    "block": ("AccelerometerBlock", "read_block", "write_block"),
    "ellipsoid": ("fit_ellipsoid",),
    "imu": ("ImuRecording", "from_samples"),
    "imu_files": ("ReadOptions", "read_imu"),
    "kabsch": ("Mounting", "mounting_rotation"),
    "lever_arm": ("LeverArm", "fit_lever_arm"),
    "positions": ("Position", "coverage_deg", "missing_faces", "still_positions"),
    "procedure": ("Outcome", "calibrate_accelerometer"),
    "result": ("Calibration",),
    "session": ("ask_for_faces", "ask_for_positions", "ask_for_tilts", "record"),
    "six": ("fit_six_positions",),
    "still": ("StillLimits", "StillSegment", "still_segments"),
    "tilts": ("fit_tilts", "tilted_force"),
}
"""The module of each name: a run reads a robot's table, and has no use for the fits behind it."""


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is first used."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(importlib.import_module(f"ravengc.calibration.{module}"), name)
    raise AttributeError(f"module 'ravengc.calibration' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
