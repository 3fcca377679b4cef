"""What an arm is to follow, from files: clouds of points with normals, and recordings of how they move."""

from __future__ import annotations

from ravengc.targets.cloud import Cloud
from ravengc.targets.motion import Recording, read_motion
from ravengc.targets.reading import read_cloud

__all__ = ["Cloud", "Recording", "read_cloud", "read_motion"]
