"""The command ``ravengc calibrate accelerometer`` as its tests call it, on recordings that they save."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from calibration_scenes import G
from ravengc.calibration import tilted_force
from ravengc.calibration.positions import FACES
from ravengc.cli import main

if TYPE_CHECKING:
    import pytest

    from ravengc.calibration import ImuRecording

SIX = G * np.array(list(FACES.values()))
ANGLES = [(0, 0), (15, 0), (0, 15), (-15, 0), (0, -15)]
TILTS = np.array([tilted_force(*np.radians(pair)) for pair in ANGLES])
WORDS = [f"{roll}deg,{pitch}deg" for roll, pitch in ANGLES]
BIAS = np.array([0.2, -0.1, 0.3])


def saved(recording: ImuRecording, name: str = "log.npz", scale: float = 1.0) -> str:
    arrays = {"t": recording.t, "specific_force": scale * recording.specific_force}
    if recording.angular_velocity is not None:
        arrays["angular_velocity"] = recording.angular_velocity
    np.savez(name, **arrays)
    return name


def said(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    """What the command prints with ``--json``."""
    assert main(["calibrate", "accelerometer", *words, "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    about: dict[str, Any] = json.loads(printed.out)
    return about


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The message of an error."""
    assert main(["calibrate", "accelerometer", *words]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("ravengc: error: ")
    assert printed.err.count("\n") == 1
    return printed.err


def table(name: str, recording: ImuRecording, scale: float = 1.0) -> None:
    numbers = np.column_stack([recording.t, scale * recording.specific_force])
    np.savetxt(name, numbers, delimiter=",", header="t,ax,ay,az", comments="")
