"""Identification of masses, friction, springs and cables from recorded torques, on a base that may stand tilted.

>>> from ravengc import identify
>>> found = identify.identify(robot, recording, identify.Model(kind="gravity+friction"), "wls")
>>> found.held_out.relative, found.refused

What joint torques do not show is named with the tilt or motion that would show it; what predicts worse than a simpler
model is refused.
"""

from __future__ import annotations

from ravengc.identify.base_parameters import BaseParameters, base_parameters
from ravengc.identify.bounds import Bounds
from ravengc.identify.elements import Element, friction, geometric_spring, hysteresis, polynomial, rotor
from ravengc.identify.fitting import identify
from ravengc.identify.held_out import JointErrors
from ravengc.identify.identification import Identification
from ravengc.identify.logs import UNITS, read_log
from ravengc.identify.model import Model
from ravengc.identify.mounting import MountingFit, mounting
from ravengc.identify.payload import Payload, payload
from ravengc.identify.plan import Plan, plan
from ravengc.identify.plan_prediction import Prediction, predict_uncertainty
from ravengc.identify.plan_trajectory import TrajectoryPlan, plan_trajectory
from ravengc.identify.preparing import parted, prepared
from ravengc.identify.recording import Recording, from_motion
from ravengc.identify.rests import rests
from ravengc.identify.smoothing import smoothed
from ravengc.identify.static import both_ways
from ravengc.identify.tilted import tilted_sd

__all__ = [
    "UNITS",
    "BaseParameters",
    "Bounds",
    "Element",
    "Identification",
    "JointErrors",
    "Model",
    "MountingFit",
    "Payload",
    "Plan",
    "Prediction",
    "Recording",
    "TrajectoryPlan",
    "base_parameters",
    "both_ways",
    "friction",
    "from_motion",
    "geometric_spring",
    "hysteresis",
    "identify",
    "mounting",
    "parted",
    "payload",
    "plan",
    "plan_trajectory",
    "polynomial",
    "predict_uncertainty",
    "prepared",
    "read_log",
    "rests",
    "rotor",
    "smoothed",
    "tilted_sd",
]
