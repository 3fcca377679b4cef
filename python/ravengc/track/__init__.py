"""A surface that moves, visited point by point: closed in on where it will be, held, and left for the next."""

from __future__ import annotations

from ravengc.track.camera import Camera
from ravengc.track.liver import liver_500, liver_surface
from ravengc.track.motions import Breathing, Drifting, Motion, Playback, drifting, lujan, recorded, still
from ravengc.track.result import OUTCOMES, PHASES, VERDICTS, Hold, Trace, TrackResult, Visits
from ravengc.track.run import track
from ravengc.track.settings import TrackSettings
from ravengc.track.surface import Surface
from ravengc.track.tour import tour

__all__ = [
    "OUTCOMES",
    "PHASES",
    "VERDICTS",
    "Breathing",
    "Camera",
    "Drifting",
    "Hold",
    "Motion",
    "Playback",
    "Surface",
    "Trace",
    "TrackResult",
    "TrackSettings",
    "Visits",
    "drifting",
    "liver_500",
    "liver_surface",
    "lujan",
    "recorded",
    "still",
    "tour",
    "track",
]
