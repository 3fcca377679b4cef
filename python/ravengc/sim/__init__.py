"""A simulated plant for control loops: prescribed base motions, a robot in MuJoCo, and a sampled accelerometer.

Needs the extra ``sim`` (MuJoCo) as soon as a :class:`Plant` is built, not before.
"""

from ravengc.sim.base_motion import BaseState, BaseTrajectory, level, oscillating, parse_base, rocking, tilted
from ravengc.sim.mjcf import to_mjcf
from ravengc.sim.plant import Plant
from ravengc.sim.sensor import SampledAccelerometer

__all__ = [
    "BaseState",
    "BaseTrajectory",
    "Plant",
    "SampledAccelerometer",
    "level",
    "oscillating",
    "parse_base",
    "rocking",
    "tilted",
    "to_mjcf",
]
