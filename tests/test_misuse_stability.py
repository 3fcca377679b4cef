"""Every public function of the certificate with every argument of the wrong kind: a result, or an error of ours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from misuse import functions_of, try_everything
from ravengc import control, stability
from stability_cases import EX1

if TYPE_CHECKING:
    from collections.abc import Callable

ROBOT, POSE, UP = rg.load("raven2_gold"), np.array([0.5, 1.5, 0.4]), np.array([0.0, 0.0, -9.8])
DRIVE, MOUNT, SENSING = control.raven2_drive(), stability.parse_mount("5:3:0.01:y"), stability.Sensing()
SYSTEM = EX1.system()
CERTIFICATE = stability.certify(SYSTEM)
ARM = {"robot": ROBOT, "q": POSE, "drive": DRIVE, "mount": MOUNT, "sensing": SENSING}
ALONG_Y = np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]])

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (stability.Mount, {"directions": ALONG_Y, "mass": 5.0, "stiffness": 900.0, "damping": 3.0, "names": ("y",)}),
    (stability.Mount, {"directions": ALONG_Y, "mass": 5.0, "frequency_hz": 2.0, "damping_ratio": 0.01}),
    (stability.OneLink, {name: getattr(EX1, name) for name in EX1.__dataclass_fields__}),
    (stability.Sensing, {"rate_hz": 100.0, "latency_s": 0.0, "cutoff_hz": 10.0, "order": 2}
        | {"gain": 1.0, "loop_rate_hz": None}),
    (stability.System, {name: getattr(SYSTEM, name) for name in SYSTEM.__dataclass_fields__}),
    (stability.advice, {"system": SYSTEM, "certificate": CERTIFICATE}),
    (stability.base_modes, {"system": SYSTEM}),
    (stability.campaign, {"cases": 1, "seed": 0, "on_progress": None}),
    (stability.certify, {"system": SYSTEM}),
    (stability.check, {**ARM, "law": "pd+dg", "gravity": UP, "sensor": np.zeros(3)}),
    (stability.directions_of, {"text": "x,ry", "pivot": np.zeros(3)}),
    (stability.linearise, {**ARM, "law": "pd+dg", "gravity": UP, "sensor": np.zeros(3)}),
    (stability.loci, {"system": SYSTEM, "w": np.ones(2)}),
    (stability.margins, {"system": SYSTEM}),
    (stability.parse_mount, {"text": "5:3:0.01:y"}),
    (stability.poles, {"system": SYSTEM, "candidates": None}),
    (stability.poles_right_of, {"system": SYSTEM, "sigma": 0.0}),
    (stability.remedies, {"system": SYSTEM}),
    (stability.rightmost_pole, {"system": SYSTEM}),
    (stability.simulate, {"systems": [SYSTEM], "longest_step_s": [1e-3], "steps": 10}),
]  # fmt: skip

DATA = {
    stability.Certificate, stability.Count, stability.Growth, stability.Margins, stability.Mode, stability.Pole,
    stability.Remedy, stability.Tally,
}  # fmt: skip
"""Data that the package makes itself."""


@pytest.mark.parametrize(("function", "good"), CALLS, ids=lambda part: getattr(part, "__qualname__", ""))
def test_a_wrong_argument_is_an_error_of_ours(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


def test_every_public_function_is_tried() -> None:
    assert functions_of(stability) - {function for function, _ in CALLS} - DATA == set()
