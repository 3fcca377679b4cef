"""Calibration of a base accelerometer: bias, scale, misalignment, mounting rotation, and where on the base it sits.

>>> from ravengc import calibration
>>> outcome = calibration.calibrate_accelerometer(calibration.read_imu("positions.csv"))
>>> calibration.write_block("my_arm.toml", outcome.block())

The model is f = S (s - b): the reading s, the bias b (m/s²), scale and misalignment S near 1, and f the specific force
in sensor axes, of length g at rest; R f is in base axes. What data do not determine is refused with what is missing.
"""

from __future__ import annotations

from ravengc.calibration.block import AccelerometerBlock, read_block, write_block
from ravengc.calibration.ellipsoid import fit_ellipsoid
from ravengc.calibration.imu import ImuRecording, from_samples
from ravengc.calibration.imu_files import ReadOptions, read_imu
from ravengc.calibration.kabsch import Mounting, mounting_rotation
from ravengc.calibration.lever_arm import LeverArm, fit_lever_arm
from ravengc.calibration.positions import Position, coverage_deg, missing_faces, still_positions
from ravengc.calibration.procedure import Outcome, calibrate_accelerometer
from ravengc.calibration.refusal import CalibrationError
from ravengc.calibration.result import Calibration
from ravengc.calibration.session import ask_for_faces, ask_for_positions, ask_for_tilts, record
from ravengc.calibration.six import fit_six_positions
from ravengc.calibration.still import StillLimits, StillSegment, still_segments
from ravengc.calibration.tilts import fit_tilts, tilted_force

__all__ = [
    "AccelerometerBlock",
    "Calibration",
    "CalibrationError",
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
