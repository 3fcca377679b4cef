"""Every public function of the identification with every argument of the wrong kind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from misuse import functions_of, try_everything
from ravengc import identify, recordings
from test_identify import mounted, moving, static

if TYPE_CHECKING:
    from collections.abc import Callable

ARM, PANDA = rg.load("raven2_gold"), rg.load("panda")
POSES = static(ARM, 30, 0.3)
MOTION = moving(PANDA, 3.0)
HEAVIER = identify.Recording(stamps=MOTION.stamps, q=MOTION.q, qd=MOTION.qd, qdd=MOTION.qdd, tau=MOTION.tau + 0.1)
READINGS = mounted(0.3, 2, 1)[2]
STAMPS, Q = np.arange(9.0), np.ones((9, 3))
PASSED = identify.Recording(stamps=STAMPS, q=Q, tau=Q, qd=np.array([[1.0], [-1.0], [1.0]] * 3) * Q)
SPRING = {"radius": 0.0075, "distance": 0.1, "rest": 0.06, "angle": 3.5}
POSES_HELD = identify.Recording(stamps=0.1 * np.arange(40.0), q=np.repeat(np.eye(4), 10, axis=0), tau=np.ones((40, 4)))
DATA = {
    getattr(identify, name)
    for name in (
        "BaseParameters", "Identification", "JointErrors", "MountingFit", "Payload", "Plan", "Prediction",
        "TrajectoryPlan",
    )
}  # fmt: skip
"""What the functions return."""

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (identify.Bounds, {"mass": {"a": (0, 1)}, "com": {}, "reach": 1.0, "total_mass": 3.0, "parameters": {}}),
    (identify.Element, {"name": "e", "joint": "j", "basis": np.vstack, "labels": ("a",), "group": "g", "filed": None}),
    (
        identify.Model,
        {
            "kind": "gravity",
            "friction": None,
            "width": 0.1,
            "rotor": True,
            "elements": (),
            "disturbances": True,
            "links": None,
        },
    ),
    (
        identify.Recording,
        {
            "stamps": STAMPS,
            "q": Q,
            "tau": Q,
            "qd": Q,
            "qdd": Q,
            "specific_force": Q,
            "angular_velocity": Q,
            "angular_acceleration": Q,
            "cutoff_hz": 3.0,
            "source": "s",
            "robot": "r",
            "skipped": {"twice": 3},
            "notes": ("n",),
        },
    ),
    (identify.base_parameters, {"robot": ARM, "model": identify.Model(), "attitudes": "level", "at_rest": True}),
    (identify.both_ways, {"recording": PASSED, "tolerance": 0.01}),
    (identify.friction, {"joint": "j", "terms": ("coulomb",), "width": 0.1, "name": "n", "group": "g"}),
    (identify.from_motion, {"motion": recordings.Recording(t=STAMPS, q=Q, tau=Q), "robot": None}),
    (identify.geometric_spring, {"joint": "j", **SPRING, "name": None}),
    (identify.hysteresis, {"joint": "j", "distances": (0.1,), "name": None, "group": "g"}),
    (
        identify.identify,
        {
            "robot": ARM,
            "recordings": POSES,
            "model": identify.Model(),
            "estimator": "ols",
            "held_out": 0.3,
            "bounds": None,
        },
    ),
    (
        identify.mounting,
        {"robot": ARM, "recording": READINGS, "model": identify.Model(), "find": ("rotation", "bias"), "noise": 0.003},
    ),
    (identify.parted, {"recording": MOTION, "share": 0.3}),
    (
        identify.payload,
        {
            "robot": PANDA,
            "unloaded": MOTION,
            "loaded": HEAVIER,
            "link": None,
            "com": np.ones(3),
            "lever": None,
            "joints": None,
        },
    ),
    (identify.payload, {"robot": PANDA, "unloaded": MOTION, "loaded": HEAVIER, "lever": 1.0}),
    (
        identify.plan,
        {
            "robot": ARM,
            "model": None,
            "poses": 5,
            "tilt": 0.1,
            "attitudes": 3,
            "tilts": [[0.1, 0.0]],
            "ranges": {"elbow": (1.0, 1.5)},
            "candidates": 20,
            "noise": 0.01,
            "used_to": 0.2,
            "seed": 1,
            "on_progress": None,
        },
    ),
    (
        identify.plan_trajectory,
        {
            "robot": ARM,
            "model": None,
            "period": 10.0,
            "harmonics": 2,
            "velocity": 0.3,
            "acceleration": np.ones(3),
            "tilt": 0.1,
            "ranges": {"elbow": (1.0, 1.5)},
            "noise": 0.01,
            "rate": 5.0,
            "used_to": 0.2,
            "rounds": 3,
            "seed": 1,
            "on_progress": None,
        },
    ),
    (
        identify.predict_uncertainty,
        {
            "robot": ARM,
            "model": identify.Model(),
            "recording": POSES,
            "tilt": 0.1,
            "noise": 0.01,
            "poses": np.ones((2, 3)),
            "steps": 3,
        },
    ),
    (identify.polynomial, {"joint": "j", "degrees": (1, 2), "centre": 0.0, "scale": 1.0, "name": None}),
    (identify.prepared, {"recording": MOTION, "model": identify.Model(kind="dynamics"), "cutoff_hz": 5.0}),
    (
        identify.read_log,
        {
            "robot": PANDA,
            "source": "example:panda",
            "units": ("rad",),
            "topic": None,
            "joints": None,
            "rate_hz": None,
            "gravity": None,
            "sensor_axes": False,
            "strict": False,
        },
    ),
    (identify.rests, {"recording": POSES_HELD, "shortest_s": 0.3, "tolerance": 0.002}),
    (identify.rotor, {"joint": "j", "name": None, "group": "g"}),
    (identify.smoothed, {"recording": MOTION, "cutoff_hz": 5.0, "trim": 0.2}),
    (identify.tilted_sd, {"found": identify.identify(ARM, POSES, identify.Model()), "poses": POSES.q, "tilt": 0.2}),
]


@pytest.mark.parametrize(("function", "good"), CALLS, ids=[function.__name__ for function, _ in CALLS])
def test_wrong_kinds_are_refused_by_name(function: Callable[..., object], good: dict[str, Any]) -> None:
    if function is identify.payload:  # what the poses hold is no load; wrong kinds are found before that
        good = good | {"loaded": _loaded()}
    try_everything(function, good)


def _loaded() -> identify.Recording:
    columns = PANDA.inverse_dynamics_regressor_batch(MOTION.q, MOTION.qd, MOTION.qdd, MOTION.base)[:, :, 60:64]
    tau = MOTION.tau + columns @ np.ones(4)
    return identify.Recording(stamps=MOTION.stamps, q=MOTION.q, qd=MOTION.qd, qdd=MOTION.qdd, tau=tau)


def test_every_public_function_is_tried() -> None:
    assert functions_of(identify) - {function for function, _ in CALLS} - DATA == set()
