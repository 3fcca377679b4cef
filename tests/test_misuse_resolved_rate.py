"""Resolved rate with every argument of the wrong kind: a result, or an error of ours that says which one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from misuse import functions_of, try_everything
from ravengc import resolved_rate
from ravengc.resolved_rate import ResolvedRate, turning_about

if TYPE_CHECKING:
    from collections.abc import Callable

ROBOT = rg.load("raven2_gold")
Q, SIX = np.array([0.5, 1.5, 0.4]), np.zeros(6)
RATE, SHAFT = ResolvedRate(ROBOT), ResolvedRate(ROBOT, "remote_centre", remote_centre=(0.0, 0.0, 0.1))

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (ResolvedRate, {"robot": ROBOT, "task": "twist", "frame": "tool", "rows": [True] * 6, "damping": "adaptive"}),
    (ResolvedRate, {"robot": ROBOT, "eps": 0.04, "lambda_max": 0.04, "qd_max": 1.0, "qdd_max": 9.0, "qddd_max": 99.0}),
    (ResolvedRate, {"robot": ROBOT, "q_min": -9.0, "q_max": Q + 9.0, "damper": 5.0, "limits": "qp", "rate_hz": 500.0}),
    (ResolvedRate, {"robot": ROBOT, "null_space": "posture", "null_gain": 1.0, "posture": Q, "midpoint": True}),
    (ResolvedRate, {"robot": ROBOT, "task": "pointing", "characteristic_length": 0.3, "pointing_axis": (0, 0, 1)}),
    (ResolvedRate, {"robot": ROBOT, "task": "remote_centre", "remote_centre": Q, "gain": 9.0, "turning_gain": 9.0}),
    (ResolvedRate, {"robot": ROBOT, "task": "position", "speed_max": 0.25, "turning_max": 2.0}),
    (RATE.step, {"q": Q, "twist": SIX, "dt": 1e-3, "base_twist": SIX, "out": np.zeros(3)}),
    (RATE.track, {"q": Q, "target": np.eye(4), "dt": 1e-3, "target_twist": SIX, "base_twist": SIX, "out": np.zeros(3)}),
    (SHAFT.track, {"q": Q, "target": SIX + 0.1, "dt": 1e-3}),
    (RATE.bind, {"q": Q, "twist": SIX.copy(), "base_twist": SIX.copy(), "out": np.zeros(3)}),
    (RATE.bind, {"q": Q, "target": np.eye(4), "target_twist": SIX.copy(), "out": np.zeros(3)}),
    (turning_about, {"pivot": Q, "angular_velocity": Q}),
]  # fmt: skip


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(("function", "good"), CALLS, ids=lambda x: getattr(x, "__name__", None))
def test_what_nobody_means_is_refused_by_name(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


def test_every_public_function_is_tried() -> None:
    assert functions_of(resolved_rate) - {function for function, _ in CALLS} == set()
