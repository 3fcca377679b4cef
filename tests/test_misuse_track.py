"""Every public function of the coverage of surfaces with every argument of the wrong kind: a result, or our error."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from misuse import functions_of, try_everything
from ravengc import track as tracking

if TYPE_CHECKING:
    from collections.abc import Callable

ROBOT, LIVER, MOTION, CAMERA, SETTINGS = tracking.liver_500(0)
POINTS, NORMALS, STAMPS = LIVER.points[:2], LIVER.normals[:2], np.arange(5.0)
PATCH = tracking.Surface(POINTS, NORMALS)
SHORT = {"most_s": 1.0, "lead_in_s": 1.0, "settle_s": 0.1, "start_q": SETTINGS.start_q}

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (tracking.Camera, {name: getattr(CAMERA, name) for name in CAMERA.__dataclass_fields__}),
    (tracking.Surface, {"points": POINTS, "normals": NORMALS, "name": "patch", "dropped": {}}),
    (tracking.Surface.cleaned, {"points": POINTS, "normals": NORMALS, "name": "patch", "apart": 1e-6}),
    (tracking.TrackSettings, {name: getattr(SETTINGS, name) for name in SETTINGS.__dataclass_fields__}),
    (tracking.drifting, {"velocity": np.zeros(3), "start_s": 1.0}),
    (tracking.liver_500, {"seed": 0, "singular": False}),
    (tracking.liver_surface, {"singular": True}),
    (tracking.lujan, {"amplitude": 0.01, "period_s": 4.0, "variation": 0.1, "seed": 0, "direction": np.ones(3)}
        | {"duration_s": 60.0}),
    (tracking.recorded, {"stamps": STAMPS, "displacement": np.zeros((5, 3)), "description": "still"}),
    (tracking.tour, {"surface": PATCH, "order": "tour", "strip": 0.006, "turning": 0.1}),
    (tracking.track, {"robot": ROBOT, "surface": PATCH, "motion": MOTION, "camera": CAMERA}
        | {"settings": tracking.TrackSettings(**SHORT), "on_progress": None}),
]  # fmt: skip

NO_ARGUMENTS = {tracking.still}
DATA = {
    tracking.Breathing, tracking.Drifting, tracking.Hold, tracking.Motion, tracking.Playback, tracking.Trace,
    tracking.TrackResult, tracking.Visits,
}  # fmt: skip
"""Data that the package makes itself, and what a caller's own motion must have."""


@pytest.mark.parametrize(("function", "good"), CALLS, ids=lambda part: getattr(part, "__qualname__", ""))
def test_a_wrong_argument_is_an_error_of_ours(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


def test_every_public_function_is_tried() -> None:
    assert functions_of(tracking) - {function for function, _ in CALLS} - NO_ARGUMENTS - DATA == set()
