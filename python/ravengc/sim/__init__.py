"""A simulated plant for control loops: prescribed base motions, a robot in MuJoCo, encoders and an inertial sensor.

Needs the extra ``sim`` (MuJoCo) as soon as a :class:`Plant` is built, not before.
"""

from ravengc.sim.base_file import read_recorded
from ravengc.sim.base_motion import BaseState, CarriedBase, PrescribedBase
from ravengc.sim.base_profiles import ProfiledBase, acceleration_step, elevator
from ravengc.sim.base_recorded import recorded, recorded_imu
from ravengc.sim.base_swings import BaseTrajectory, level, oscillating, rocking, ship, tilted
from ravengc.sim.base_text import parse_base
from ravengc.sim.encoders import Encoders, raven2_encoders
from ravengc.sim.mjcf import to_mjcf
from ravengc.sim.plant import Plant
from ravengc.sim.sensor import SampledAccelerometer

__all__ = [
    "BaseState",
    "BaseTrajectory",
    "CarriedBase",
    "Encoders",
    "Plant",
    "PrescribedBase",
    "ProfiledBase",
    "SampledAccelerometer",
    "acceleration_step",
    "elevator",
    "level",
    "oscillating",
    "parse_base",
    "raven2_encoders",
    "read_recorded",
    "recorded",
    "recorded_imu",
    "rocking",
    "ship",
    "tilted",
    "to_mjcf",
]
