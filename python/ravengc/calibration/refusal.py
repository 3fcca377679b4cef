"""The answer to data that do not determine what is asked: what was found, what is missing, and how to get it."""

from __future__ import annotations

from ravengc.errors import RavenGCError

__all__ = ["CalibrationError"]


class CalibrationError(RavenGCError, ValueError):
    """Data that do not determine a calibration, or determine one that no working sensor has."""
