"""Gravity torque for robot arms on bases that tilt, rock or accelerate, every control cycle.

>>> import ravengc as rg
>>> robot = rg.load("raven2_gold")
>>> tau = robot.gravity_torque([0.5, 1.5, 0.4], rg.Gravity.level())
"""

from ravengc._core import INSTRUCTIONS, MAX_JOINTS, STANDARD_GRAVITY, BaseMotion, Gravity, Mounting, SpecificForce
from ravengc.robot import Robot, from_dh, from_toml, from_urdf, load

__all__ = [
    "INSTRUCTIONS",
    "MAX_JOINTS",
    "STANDARD_GRAVITY",
    "BaseMotion",
    "Gravity",
    "Mounting",
    "Robot",
    "SpecificForce",
    "from_dh",
    "from_toml",
    "from_urdf",
    "load",
]
