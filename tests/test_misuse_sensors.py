"""Every public function of a base sensor with every argument of the wrong kind: a result, or an error of ours.

What a live sensor or a user answers is wrong here too: a function that returns nothing stands for both. The samples and
steps of a chain (``Accelerometer.push``, ``MonitoredSensor.step``) are in the tests of the chain.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from calibration_scenes import FACES, G, Turned, evenly, held, rocked
from misuse import functions_of, try_everything
from ravengc import calibration, monitored, sensors
from ravengc.errors import RavenGCError
from ravengc.sensors import Sample

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType

SIX, TILTS = (
    G * FACES,
    np.array([calibration.tilted_force(roll, pitch) for roll, pitch in [(0, 0), (0.3, 0), (0, 0.3)]]),
)
SIX_HELD, TILTS_HELD = held(SIX, hold_s=1.6), held(TILTS, hold_s=1.6)
STAMPS, ROCKED_FORCE, ROCKED_RATE = rocked(seconds=4.0)
CALIBRATED = calibration.calibrate_accelerometer(SIX_HELD).calibration
HAND = Turned()
ONE, ZERO = np.eye(3), np.zeros(3)

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (calibration.ImuRecording, {"t": np.arange(9.0), "specific_force": np.ones((9, 3)), "angular_velocity": None}
        | {"unit": "g", "source": "log", "notes": ()}),
    (calibration.from_samples, {"samples": [Sample(0, 0, (0.0, 0.0, G))], "source": "log"}),
    (calibration.ReadOptions, {"unit": "g", "rate_unit": "deg/s", "columns": ["1", "2", "3"], "rate_hz": 9.0}
        | {"sends": "gravity"}),
    (calibration.read_imu, {"source": "log.csv", "options": calibration.ReadOptions()}),
    (calibration.read_imu, {"source": "log.npz", "options": None}),
    (calibration.StillLimits, {"force": 0.1, "rate": 0.1, "window_s": 0.1, "shortest_s": 1.0}),
    (calibration.still_segments, {"recording": SIX_HELD, "limits": None}),
    (calibration.still_positions, {"recording": SIX_HELD, "limits": calibration.StillLimits(), "same_deg": 2.0}
        | {"in_order": False}),
    (calibration.coverage_deg, {"directions": SIX}),
    (calibration.missing_faces, {"directions": SIX, "within_deg": 40.0}),
    (calibration.tilted_force, {"roll": 0.1, "pitch": 0.1, "gravity": G}),
    (calibration.fit_ellipsoid, {"forces": G * evenly(14), "errors": 0.01, "gravity": G}),
    (calibration.fit_six_positions, {"forces": SIX, "errors": np.full(6, 0.01), "gravity": G}),
    (calibration.fit_tilts, {"forces": TILTS, "expected": TILTS, "errors": 0.01, "correction": ONE, "declared": ONE}),
    (calibration.mounting_rotation, {"measured": SIX, "expected": SIX, "errors": 0.01, "declared": ONE}),
    (calibration.fit_lever_arm, {"t": STAMPS, "specific_force": ROCKED_FORCE, "angular_velocity": ROCKED_RATE}
        | {"pivot": ZERO, "gravity": G}),
    (calibration.calibrate_accelerometer, {"recording": SIX_HELD, "method": "auto", "limits": None, "gravity": G}),
    (calibration.calibrate_accelerometer, {"recording": TILTS_HELD, "tilts": TILTS}
        | {"correction": ONE, "declared": ONE}),
    (CALIBRATED.apply, {"readings": SIX}),
    (calibration.ask_for_faces, {"read": HAND.read, "ask": HAND.ask, "limits": None}),
    (calibration.ask_for_tilts, {"read": HAND.read, "ask": HAND.ask, "count": 2, "limits": None}),
    (calibration.ask_for_positions, {"read": HAND.read, "ask": lambda _: "q", "limits": None}),
    (calibration.record, {"read": HAND.read, "seconds": 1.0}),
    (calibration.read_block, {"path": "arm.toml"}),
    (calibration.write_block, {"path": "arm.toml", "values": {"bias": [0.0, 0.0, 0.1]}}),
    *((lambda key=key, **value: calibration.write_block("arm.toml", {key: value["value"]}), {"value": value})
        for key, value in calibration.AccelerometerBlock(
            sensor="sim:", rate_hz=9.0, range=9.0, cutoff_hz=2.0, gyro_range=9.0, bandwidth_hz=2.0, noise=0.1,
            stuck_count=9, up=(0.0, 0.0, 1.0), pose_limit=1.0, tilt_limit=1.0, norm=(3.0, 18.0), jerk=9.0,
            linear_acceleration=9.0, moving_base=True,
        ).as_dict().items()),
    (sensors.parse_address, {"text": "sim:level"}),
    (sensors.open_sensor, {"text": "sim:level", "unit": "g", "rate": 9.0, "noise": 0.1, "axis": "x", "position": ZERO}),
    (sensors.SensorReader, {"open_sensor": lambda: None, "deliver": print, "on_event": None}),
    (sensors.LiveSensor, {"accelerometer": rg.Accelerometer(), "open_sensor": lambda: None, "address": None}),
    (monitored.MonitoredSensor, {"accelerometer": rg.Accelerometer()}),
    (monitored.chain_for, {"rate_hz": 100.0, "policy": "paper"}),
    (rg.Accelerometer, {"unit": "g", "bias": ZERO, "correction": ONE, "gyro_bias": ZERO, "rotation": ONE}
        | {"position": ZERO, "up": (0.0, 0.0, 1.0), "policy": "paper", "norm": (3.0, 16.0), "moving_base": True}
        | {"start_count": 20}),
]  # fmt: skip

DATA = {
    calibration.AccelerometerBlock, calibration.Calibration, calibration.LeverArm, calibration.Mounting,
    calibration.Outcome, calibration.Position, calibration.StillSegment, sensors.Address, sensors.ReaderEvent,
    sensors.Sample, sensors.Sensor, sensors.Statistics,
}  # fmt: skip
"""What the package makes itself, and what a loop reads."""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_text("t,ax,ay,az\n0.0,0,0,9.8\n0.1,0,0,9.8\n")
    np.savez("log.npz", t=np.arange(5.0), acc=np.ones((5, 3)))
    Path("arm.toml").write_text("[accelerometer]\n")


@pytest.mark.parametrize(("function", "good"), CALLS, ids=lambda part: getattr(part, "__qualname__", ""))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_wrong_argument_is_an_error_of_ours(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


@pytest.mark.parametrize("module", [calibration, monitored, sensors], ids=lambda module: module.__name__)
def test_every_public_function_is_tried(module: ModuleType) -> None:
    assert functions_of(module) - {function for function, _ in CALLS} - DATA == set()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: calibration.from_samples(5), "samples is an int; expected samples, one after the other"),
        (lambda: calibration.from_samples([5]), "sample is an int; expected a Sample"),
        (lambda: calibration.read_imu("log.csv", "g"), "options is a str; expected a ReadOptions"),
        (lambda: calibration.still_segments(SIX), "recording is a ndarray; expected an ImuRecording"),
        (lambda: calibration.still_segments(SIX_HELD, 0.1), "limits is a float; expected a StillLimits"),
        (lambda: calibration.fit_ellipsoid(SIX, "small"), "errors has dtype <U5; expected real numbers"),
        (
            lambda: calibration.mounting_rotation(SIX, SIX * [1, 1, -1], 0.1, declared=np.ones(3)),
            r"declared has shape \(3,\); expected \(3, 3\)",
        ),
        (lambda: calibration.ask_for_faces(None, print), "read is a NoneType; expected a function"),
        (
            lambda: calibration.ask_for_faces(HAND.read, lambda _: 5),
            "the answer to a question is an int; expected a str",
        ),
        (
            lambda: calibration.ask_for_tilts(HAND.read, HAND.ask, 0),
            "count is 0; expected a whole number from 1 to 200",
        ),
        (lambda: calibration.record(lambda timeout: 5 if timeout else None, 1.0), "what read returns is an int"),
        (lambda: calibration.write_block("arm.toml", None), "values is a NoneType without 'items'"),
        (lambda: monitored.chain_for("fast"), "rate_hz has dtype <U4; expected real numbers"),
    ],
)
def test_the_error_says_what_where_and_what_would_be_right(call: Callable[[], object], message: str) -> None:
    with pytest.raises(RavenGCError, match=message):
        call()
