"""Every public function of ``ravengc.targets`` with every argument of the wrong kind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from misuse import functions_of, try_everything
from ravengc import targets

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

UP = np.tile((0.0, 0.0, 1.0), (4, 1))
CLOUD = targets.Cloud(np.vstack((np.eye(3), np.ones((1, 3)))), UP, "corners")
DATA = {targets.Cloud, targets.Recording}
"""Data that the readers make."""

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (targets.read_cloud, {"source": "cloud.xyz", "units": "m", "most": 3, "facing": (0.0, 0.0, 1.0), "strict": False}),
    (targets.read_motion, {"source": "motion.csv", "units": "m", "rate_hz": None, "strict": False}),
    (CLOUD.placed, {"at": (0.0, 0.0, 0.0), "turn_deg": (0.0, 0.0, 0.0)}),
    (CLOUD.faced, {"towards": (0.0, 0.0, 1.0)}),
    (CLOUD.thinned, {"most": 2}),
]


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The files that the good arguments name."""
    monkeypatch.chdir(tmp_path)
    np.savetxt("cloud.xyz", np.hstack((CLOUD.points, CLOUD.normals)))
    np.savetxt("motion.csv", np.arange(80.0).reshape(20, 4), delimiter=",", header="t,x,y,z", comments="")


@pytest.mark.parametrize(("function", "good"), CALLS)
def test_wrong_arguments_are_refused_by_name(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


def test_every_public_function_is_tried() -> None:
    assert functions_of(targets) - {function for function, _ in CALLS} - DATA == set()
