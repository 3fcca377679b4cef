"""Recorded motions: read CSV, NumPy archives and ROS bags into one immutable form, and fit it to a robot's joints."""

from __future__ import annotations

from ravengc.recordings.fitting import fit_to_robot, joint_side
from ravengc.recordings.reading import EXAMPLES, example_path, read_recording
from ravengc.recordings.recording import Recording

__all__ = ["EXAMPLES", "Recording", "example_path", "fit_to_robot", "joint_side", "read_recording"]
