"""Every public function with every argument of the wrong kind: a result, or an error of ours that says which one.

A table gives good arguments for each; each is then replaced by things that no caller means. The functions of a cycle
(``Controller.update``, ``SampledAccelerometer.update``, ``JointSwing.at``) take what the loop gives them and check
nothing; the compiled core has tests of its own, and what a base sensor needs is in test_misuse_sensors.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from misuse import functions_of, try_everything
from ravengc import (
    config,
    control,
    coordinates,
    differentiation,
    elastic,
    log,
    loop,
    recordings,
    reference,
    replay,
    sim,
    trajectory,
    units,
)
from ravengc import sweep as sweeps
from ravengc.errors import RavenGCError

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import ModuleType

pytest.importorskip("mujoco")

ROBOT = rg.load("raven2_gold")
SPEC = ROBOT.spec
Q, ZERO, SIX, STAMPS = np.array([0.5, 1.5, 0.4]), np.zeros(3), np.zeros(6), np.arange(9.0)
RECORDING = recordings.Recording(t=STAMPS, q=np.tile(Q, (9, 1)), tau=np.ones((9, 3)))
BASE, DRIVE = sim.tilted(3.0), control.raven2_drive()
PLANT, SWING = sim.Plant(ROBOT), trajectory.swing_within_limits(SPEC)
CABLED, PROFILE = sim.Plant(ROBOT, rotor_inertia=1.0, cable_stiffness=1e3), sim.elevator(3.0)
TURNS = np.tile(np.eye(3), (9, 1, 1))
SENSOR = sim.SampledAccelerometer(PLANT.accelerometer)
CONTROLLER = control.Controller(ROBOT, "pd", DRIVE)
URDF = """<robot name="rod"><link name="base_link"/><link name="rod"/><joint name="hinge" type="continuous">
  <parent link="base_link"/><child link="rod"/></joint></robot>"""
TABLE: dict[str, Any] = {"rows": [{"mass": 1.0, "a": 0.3}], "convention": "standard"}
PARTS = dict.fromkeys(("base", "tool", "tip", "coupling", "transmission"))
TEXTS = dict.fromkeys(("name", "description", "source"), "text")
ON_BASE = {"f": ZERO, "w": ZERO, "dw": ZERO}
MOVING = {"q": Q, "qd": ZERO, "qdd": ZERO}
PAYLOAD = {"payload": (1.0, ZERO, SIX)}

SPRINGS, ALPHA = (2000.0, 2000.0, 1e5), {"alpha": None, "tilt": "any", "field": 9.8, "allow_unproven": False}
SWEPT = sweeps.SweepTable("ship", (), ("y",), {"trial": np.arange(3), "error": ["", "", ""], "y": ZERO})
SWEEP = {
    "format": 1,
    "experiment": "ship",
    "settings": {},
    "grid": {"heave": [0, 1]},
    "random": {},
    "trials": 1,
    "seed": 0,
}
ELASTIC = {"robot": ROBOT, "stiffness": SPRINGS, "kp": DRIVE.kp, "q_desired": Q, "gravity": (0.0, 0.0, -9.8)}

CALLS: list[tuple[Callable[..., object], dict[str, Any]]] = [
    (rg.load, {"name_or_path": "raven2_gold", "mass_set": "cad"}),
    (rg.from_toml, {"path_or_text": ROBOT.to_toml(), "mass_set": None}),
    (rg.from_urdf, {"path": "rod.urdf", "tip": "rod"}),
    (rg.from_dh, {**TABLE, **PARTS, **TEXTS}),
    (rg.Robot, {"spec": SPEC}),
    (ROBOT.to_toml, {"path": "robot.toml"}),
    (config.bundled_path, {"name": "panda"}),
    (config.spec_for, {"name_or_path": "panda", "mass_set": None}),
    (config.spec_from_dh, {**TABLE, **PARTS, **TEXTS}),
    (config.spec_from_toml, {"path_or_text": ROBOT.to_toml(), "mass_set": None}),
    (config.spec_from_urdf, {"path": "rod.urdf", "tip": "rod"}),
    (config.spec_to_toml, {"spec": SPEC}),
    (config.validate, {"spec": SPEC}),
    (config.write_toml, {"spec": SPEC, "path": "robot.toml"}),
    (sim.BaseTrajectory, {**dict.fromkeys(("offset", "amplitude", "hz", "phase"), SIX), "axes": np.eye(3)}),
    (sim.BaseTrajectory, {"pivot": ZERO, "description": "still"}),
    (BASE.state, {"t": 0.0}),
    (BASE.rotation, {"t": 0.0}),
    (BASE.position, {"t": 0.0}),
    (BASE.motion, {"t": 0.0}),
    (BASE.motion_at, {"t": 0.0, "point": ZERO}),
    (sim.tilted, {"degrees": 1.0, "axis": "x"}),
    (sim.parse_base, {"text": "level", "axis": "x", "pivot": ZERO}),
    (sim.rocking, {"low_deg": 0.0, "high_deg": 1.0, "hz": 1.0, "axis": "x", "pivot": ZERO}),
    (sim.oscillating, {**dict.fromkeys(("amplitude", "hz", "phase", "offset"), SIX), "pivot": ZERO}),
    (sim.ship, {"roll_deg": 1.0, "roll_hz": 1.0, "pitch_deg": 1.0, "pitch_hz": 1.0, "heave": 1.0, "heave_hz": 1.0}
        | {"place": ZERO}),
    (sim.elevator, {"travel": 3.0, "speed": 2.5, "acceleration": 1.0, "jerk": 2.0, "start_s": 1.0}),
    (sim.acceleration_step, {"acceleration": 2.0, "axis": "x", "start_s": 1.0, "end_s": 2.0, "rise_s": 0.1}),
    (sim.recorded, {"times": STAMPS, "position": np.zeros((9, 3)), "rotation": TURNS, "description": "still"}),
    (sim.recorded_imu, {"times": STAMPS, "specific_force": np.full((9, 3), 9.8), "angular_velocity": np.zeros((9, 3))}
        | {"place": ZERO, "description": "still"}),
    (sim.read_recorded, {"path": "base.csv"}),
    (sim.ProfiledBase, {"times": STAMPS, "coefficients": np.zeros((8, 6, 6)), "axes": np.eye(3), "pivot": ZERO}
        | {"description": "still"}),
    (PROFILE.state, {"t": 0.0}),
    (PROFILE.motion_at, {"t": 0.0, "point": ZERO}),
    (sim.to_mjcf, {"robot": SPEC, "base": BASE, "step_s": 1e-3, "sensor": ZERO}),
    (sim.Plant, {"robot": ROBOT, "base": BASE, "step_s": 1e-3, "sensor": ZERO}),
    (sim.Plant, {"robot": ROBOT, "rotor_inertia": 0.1, "viscous": 0.1, "coulomb": 0.1, "disturbances": True}),
    (sim.Plant, {"robot": ROBOT, "rotor_inertia": 0.1, "friction": "soft", "cable_stiffness": 1e3}
        | {"cable_damping": 1.0}),
    (PLANT.reset, {"q": Q, "qd": ZERO, "time": 0.0}),
    (CABLED.reset, {"q": Q, "motor_q": Q}),
    (sim.Encoders, {"plant": PLANT, "counts_per_unit": 1e5, "offset": 0.0, "bits": 24, "at_motors": True}),
    (sim.raven2_encoders, {"plant": PLANT, "offset": ZERO}),
    (PLANT.step, {"tau": ZERO, "dt": 1e-3}),
    (PLANT.inverse_dynamics, MOVING),
    (sim.SampledAccelerometer, {"read": lambda: ZERO, "hz": 9.0, "noise": 0.0, "seed": 0}),
    (sim.SampledAccelerometer, {"read": lambda: ZERO, "gyro": lambda: ZERO, "latency_s": 0.01, "stamp": "taken"}
        | {"bias": ZERO, "scale": np.eye(3), "gyro_noise": 0.1, "gyro_bias": ZERO}),
    (control.Controller, {"robot": ROBOT, "law": "pd", "drive": DRIVE, "tau_max": 1.0, "tau_rate_max": 9.0}
        | {"limits": None, "jump": 1.0, "wrap": 6.3, "rate_hz": 1e3, "ramp_s": 1.0, "hold_s": 0.1}),
    (control.Controller, {"robot": ROBOT, "law": "pd", "drive": DRIVE, "feedback": "motor", "output": "joint"}
        | {"on_fault": "decay", "differentiate": True, "accelerometer": None, "disturbances": True, "armed": False}),
    (CONTROLLER.skip, {"updates": 1}),
    (control.drive_for, {"robot": ROBOT, "q": Q, "natural_frequency_hz": 5.0, "damping_ratio": 0.7}),
    (control.derived_drive, {"robot": ROBOT, "q": Q, "natural_frequency_hz": 5.0, "damping_ratio": 0.7}),
    (loop.ControlLoop, {"plant": PLANT, "controller": CONTROLLER, "sensor": SENSOR, "trajectory": SWING}
        | {"rate_hz": 1e3, "duration_s": 0.1, "on_tick": None}),
    (loop.Record, {"cycles": 3, "n": 2}),
    (loop.check_timing, {"rate_hz": 1e3, "duration_s": 1.0}),
    (log.check_log_path, {"path": "run.npz"}),
    (log.read_log, {"path": "run.npz"}),
    (log.write_log, {"path": "run.csv", "columns": {"t": STAMPS}, "metadata": {}, "joints": ("a",)}),
    (trajectory.JointSwing, {"centre": ZERO, "amplitude": ZERO, "period_s": np.ones(3)}),
    (trajectory.swing_within_limits, {"robot": SPEC, "scale": 1.0}),
    (coordinates.sliding, {"robot": SPEC}),
    (replay.replay, {"robot": ROBOT, "recording": RECORDING, "model": "full", "gravity": ZERO, "span": 0.1}),
    (replay.replay, {"robot": ROBOT, "recording": RECORDING, "threads": 1}),
    (rg.ElasticGravity, {"robot": ROBOT, "stiffness": SPRINGS, "variant": "biased", "kp": DRIVE.kp, **ALPHA}),
    (rg.ElasticGravity, {"robot": ROBOT, "stiffness": SPRINGS, "iterations": 9, "tolerance": 0.0}),
    (elastic.condition_for, {"variant": "biased", "stiffness": SPRINGS, "alpha": 8.0, "kp": DRIVE.kp}),
    (elastic.least_gain, {"alpha": 8.0, "spring": 99.0}),
    (elastic.least_spring, {"alpha": 8.0, "gain": 99.0}),
    (elastic.stiffest_gravity, {"robot": ROBOT, "tilt": "level", "field": 9.8, "searches": 1, "seed": 0}),
    (elastic.steady_errors, ELASTIC),
    (elastic.steady_error, {**ELASTIC, "law": "pd"}),
    (elastic.settle, {**ELASTIC, "law": "pd", "kd": DRIVE.kd, "motor_inertia": DRIVE.rotor_inertia}
        | {"joint_damping": 0.1, "start": Q, "seconds": 0.01, "step_s": 0.005}),
    (differentiation.differentiate, {"t": STAMPS, "values": np.zeros((9, 2)), "window": 3}),
    (differentiation.window_for, {"t": STAMPS, "span": 0.3}),
    (recordings.Recording, {"t": STAMPS, "q": np.zeros((9, 1)), "names": ("a",), "source": "log", "notes": ()}
        | dict.fromkeys(("qd", "qdd", "tau", "gravity")) | {"skipped": {}}),
    (RECORDING.select, {"joints": [0, 1]}),
    (recordings.example_path, {"name": "panda"}),
    (recordings.fit_to_robot, {"recording": RECORDING, "robot": SPEC, "joints": None}
        | {"angle_unit": "auto", "length_unit": "auto"}),
    (recordings.joint_side, {"recording": RECORDING, "robot": ROBOT, "joints": None}),
    (recordings.read_recording, {"source": "example:panda", "topic": None, "joints": None, "rate_hz": None}),
    (sweeps.Draw, {"low": 0.0, "high": 1.0, "log": False}),
    (sweeps.sweep, {"experiment": "ship", "out": "new", "grid": {"duration_s": [1.0]}, "random": {}, "trials": 1}
        | {"seed": 0, "settings": None, "executor": None}),
    (sweeps.processes, {"jobs": 1}),
    (sweeps.dask, {"address": "tcp://nowhere:1"}),
    (sweeps.read_sweep, {"folder": "swept", "experiment": None}),
    (sweeps.read_points, {"experiment": "ship", "text": "heave=0,1"}),
    (sweeps.read_draw, {"experiment": "ship", "text": "heave=0:1"}),
    (sweeps.summarise, {"table": SWEPT, "numbers": ["y"], "best": "least"}),
    (SWEPT.write_csv, {"path": "swept.csv"}),
    (units.to_si, {"value": 1.0, "dimension": "mass"}),
    (units.to_si_vector, {"values": [1.0], "dimensions": ["mass"]}),
    (reference.base_wrench, {"spec": SPEC, **MOVING, **ON_BASE, **PAYLOAD}),
    (reference.center_of_mass, {"spec": SPEC, "q": Q, **PAYLOAD}),
    (reference.disturbance_parameters, {"spec": SPEC}),
    (reference.disturbance_regressor, {"spec": SPEC, "q": Q, "qd": ZERO}),
    (reference.disturbance_torque, {"spec": SPEC, "q": Q, "qd": ZERO}),
    (reference.forward_dynamics, {"spec": SPEC, "q": Q, "qd": ZERO, "tau": ZERO, **ON_BASE, **PAYLOAD}),
    (reference.forward_kinematics, {"spec": SPEC, "q": Q, "frame": "tool"}),
    (reference.gravity_regressor, {"spec": SPEC, "q": Q, "g": ZERO}),
    (reference.gravity_stiffness, {"spec": SPEC, "q": Q, "g": ZERO, **PAYLOAD}),
    (reference.gravity_torque, {"spec": SPEC, "q": Q, "g": ZERO, **PAYLOAD}),
    (reference.gravity_torque_from_energy, {"spec": SPEC, "q": Q, "g": ZERO, **PAYLOAD}),
    (reference.inertial_parameters, {"spec": SPEC, **PAYLOAD}),
    (reference.inverse_dynamics, {"spec": SPEC, **MOVING, **ON_BASE, **PAYLOAD}),
    (reference.inverse_dynamics_regressor, {"spec": SPEC, **MOVING, **ON_BASE}),
    (reference.jacobian, {"spec": SPEC, "q": Q, "frame": "tool", "axes": "base"}),
    (reference.joint_axes, {"spec": SPEC, "q": Q}),
    (reference.kinetic_energy, {"spec": SPEC, "q": Q, "qd": ZERO, "v": ZERO, "w": ZERO, **PAYLOAD}),
    (reference.lagrangian_torque, {"spec": SPEC, **MOVING, "g": ZERO, **PAYLOAD}),
    (reference.link_frames, {"spec": SPEC, "q": Q}),
    (reference.mass_matrix, {"spec": SPEC, "q": Q, **PAYLOAD}),
    (reference.potential_energy, {"spec": SPEC, "q": Q, "g": ZERO, **PAYLOAD}),
    (reference.spring_energy, {"spec": SPEC, "q": Q}),
]  # fmt: skip

NO_ARGUMENTS = {config.bundled_names, control.raven2_drive, sim.level}
DATA = {
    elastic.Condition, elastic.Settled, elastic.StiffestGravity,
    control.Drive, control.Law, log.Log, loop.Plant, loop.Sensor, loop.Trajectory, replay.JointError, replay.Replay,
    sim.BaseState, sim.CarriedBase, sim.PrescribedBase, sweeps.Progress, sweeps.Summary, sweeps.SweepTable,
}  # fmt: skip
"""Data that the package makes itself or that is checked where it is used, and what a loop drives."""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rod.urdf").write_text(URDF)
    log.write_log("run.npz", {"t": STAMPS}, {})
    Path("swept").mkdir()
    Path("swept/sweep.json").write_text(json.dumps(SWEEP))
    Path("swept/journal.jsonl").touch()
    Path("base.csv").write_text("t,roll,pitch,yaw\n0,0,0,0\n1,0,0,0\n2,0,0,0\n")


@pytest.mark.parametrize(("function", "good"), CALLS, ids=lambda part: getattr(part, "__qualname__", ""))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_wrong_argument_is_an_error_of_ours(function: Callable[..., object], good: dict[str, Any]) -> None:
    try_everything(function, good)


MODULES = (
    config, control, coordinates, differentiation, elastic, log, loop, recordings, reference, replay, sim, sweeps,
    trajectory, units,
)  # fmt: skip


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__)
def test_every_public_function_is_tried(module: ModuleType) -> None:
    assert functions_of(module) - {function for function, _ in CALLS} - NO_ARGUMENTS - DATA == set()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sim.to_mjcf(ROBOT, BASE), "robot: got <Robot raven2_gold: .*>, expected a RobotSpec"),
        (lambda: sim.to_mjcf(SPEC, "level"), "base is a str without 'axes', 'pivot', 'state'"),
        (lambda: sim.to_mjcf(SPEC, BASE, step_s=0.0), "step_s must be a positive number, not 0"),
        (lambda: sim.BaseTrajectory(axes=np.ones((3, 3))), "axes must be three orthonormal rows"),
        (lambda: sim.BaseTrajectory(hz=[1.0]), r"hz must be 6 finite numbers of at most 1e\+09, not \[1.0\]"),
        (lambda: coordinates.sliding(ROBOT), "robot is a Robot; expected a RobotSpec"),
        (lambda: control.derived_drive(SPEC, Q), "robot is a RobotSpec; expected a Robot"),
        (lambda: control.derived_drive(ROBOT, [0.0]), r"q must be 3 finite numbers, not \[0.0\]"),
        (lambda: trajectory.swing_within_limits(SPEC, scale=-1), "scale is -1; expected a finite number, 0 or more"),
        (lambda: trajectory.JointSwing([0], [0], [0]), r"period_s must be positive, not \[0\]"),
        (lambda: differentiation.differentiate([0, 0, 1], np.zeros((3, 1)), 3), "expected finite stamps .* increase"),
        (lambda: differentiation.differentiate(STAMPS, STAMPS, 3), r"values has shape \(9,\); expected \(9, k\)"),
        (lambda: differentiation.window_for(STAMPS, -1.0), "span of -1.0 s; expected zero"),
        (lambda: loop.Record(2.5, 3), "cycles is 2.5; expected a whole number from 0 to 10000000"),
        (lambda: log.read_log(5), "path is an int; expected a path: a text or a pathlib.Path"),
        (lambda: rg.load(None), "name_or_path is a NoneType; expected a path"),
        (
            lambda: recordings.fit_to_robot(RECORDING, SPEC, joints="elbow"),
            "joints is 'elbow'; expected a list of texts",
        ),
        (lambda: RECORDING.select([3]), "joint is 3; expected a whole number from 0 to 2"),
        (lambda: reference.gravity_torque(ROBOT, Q, ZERO), "spec is a Robot; expected a RobotSpec"),
        (lambda: reference.gravity_torque(SPEC, Q[:2], ZERO), r"q has shape \(2,\); expected \(3,\)"),
        (lambda: reference.gravity_torque(SPEC, Q, "down"), "g has dtype <U4; expected numbers"),
        (lambda: reference.mass_matrix(SPEC, Q, payload=1.0), "payload is 1.0; expected a mass, a centre of mass and"),
        (lambda: reference.jacobian(SPEC, Q, frame="tol"), "frame 'tol' is unknown: choose .*; did you mean 'tool'"),
        (lambda: units.to_si(1.0, "weight"), "dimension 'weight' is unknown"),
    ],
)
def test_the_error_says_what_where_and_what_would_be_right(call: Callable[[], object], message: str) -> None:
    with pytest.raises(RavenGCError, match=message):
        call()
