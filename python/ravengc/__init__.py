"""Gravity torque for robot arms on bases that tilt, rock or accelerate, every control cycle.

>>> import ravengc as rg
>>> robot = rg.load("raven2_gold")
>>> tau = robot.gravity_torque([0.5, 1.5, 0.4], rg.Gravity.level())
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING

from ravengc._core import (
    FAULTS,
    INSTRUCTIONS,
    MAX_JOINTS,
    STANDARD_GRAVITY,
    Accelerometer,
    BaseMotion,
    Gravity,
    Mounting,
    Predictor,
    SpecificForce,
)
from ravengc.robot import Robot, from_dh, from_toml, from_urdf, load

if TYPE_CHECKING:
    from types import ModuleType

    from ravengc import elastic, reference, sim
    from ravengc.elastic import ElasticGravity
    from ravengc.resolved_rate import ResolvedRate

__all__ = [
    "FAULTS",
    "INSTRUCTIONS",
    "MAX_JOINTS",
    "STANDARD_GRAVITY",
    "Accelerometer",
    "BaseMotion",
    "ElasticGravity",
    "Gravity",
    "Mounting",
    "Predictor",
    "ResolvedRate",
    "Robot",
    "SpecificForce",
    "elastic",
    "from_dh",
    "from_toml",
    "from_urdf",
    "load",
    "reference",
    "sim",
]


def _check_level() -> None:
    """Refuse a misspelt RAVENGC_LEVEL, which the core would take for its best build."""
    level, levels = os.environ.get("RAVENGC_LEVEL", ""), ("portable", "avx2", "avx512")
    if level and level not in levels:
        from ravengc.errors import ConfigError
        from ravengc.messages import did_you_mean, listed, shown

        got = f"environment variable RAVENGC_LEVEL: got {shown(level)}{did_you_mean(level, levels)}"
        raise ConfigError(f"{got} (choose {listed(levels)}, or unset it for the best that this processor has)")


_check_level()


_CLASSES = {"ElasticGravity": "elastic", "ResolvedRate": "resolved_rate"}


def __getattr__(name: str) -> type[ElasticGravity | ResolvedRate] | ModuleType:
    """Import the parts that a control cycle does not need when they are first used."""
    if name in ("elastic", "reference", "sim"):
        return importlib.import_module(f"ravengc.{name}")
    if name in _CLASSES:
        return getattr(importlib.import_module(f"ravengc.{_CLASSES[name]}"), name)  # type: ignore[no-any-return]
    raise AttributeError(f"module 'ravengc' has no attribute '{name}'")
