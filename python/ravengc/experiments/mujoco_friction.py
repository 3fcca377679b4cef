"""The arm in MuJoCo's own integrator, with its compliant friction: a referee for friction that sticks.

MuJoCo's ``frictionloss`` is a soft constraint: where friction should hold, the joint creeps, the faster the softer
``solref`` (time constant) and ``solimp`` (impedance, 1 would be rigid) are. Made stiffer, it must come to what the
plant's exact friction gives.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.control import Controller, raven2_drive
from ravengc.errors import MissingExtraError
from ravengc.experiments.raven import Path, raven
from ravengc.sim import tilted, to_mjcf

if TYPE_CHECKING:
    from ravengc.experiments.trial import Friction

__all__ = ["SOFTNESS", "SoftRecord", "SoftTrial", "run_soft"]

Array = NDArray[np.float64]

STEP_S = 0.0005
SOFTNESS = {
    "MuJoCo's defaults (20 ms, 0.9)": (0.02, 0.9),
    "stiffer (5 ms, 0.99)": (0.005, 0.99),
    "nearly rigid (1 ms, 0.9999)": (0.001, 0.9999),
}
"""Time constant of ``solref`` (s) and impedance of ``solimp``."""


class SoftTrial(NamedTuple):
    """One run on a base at rest, tilted by ``tilt_deg`` about ``axis``; the law knows gravity without delay."""

    law: str
    tilt_deg: float
    axis: tuple[float, ...]
    path: Path
    friction: Friction
    softness: str


class SoftRecord(NamedTuple):
    """Every cycle of a run, (cycles, 3) each: set-point less position, PD term, total torque."""

    error: Array
    tau_pd: Array
    tau: Array


def run_soft(trial: SoftTrial) -> SoftRecord:
    """Run one trial and return the record of every cycle."""
    gravity = -tilted(trial.tilt_deg, trial.axis).motion_at(0.0, np.zeros(3))[0]
    mujoco, model = _model(trial, gravity)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = trial.path.q[0], trial.path.qd[0]
    controller = Controller(raven(), trial.law, raven2_drive())
    if trial.law == "pd+dg":
        controller.gravity[:] = gravity
    steps = round(1.0 / (trial.path.rate_hz * STEP_S))
    record = SoftRecord(*np.zeros((3, *trial.path.q.shape)))
    for row, (q, qd) in enumerate(zip(trial.path.q, trial.path.qd, strict=True)):
        controller.q[:], controller.qd[:] = data.qpos, data.qvel
        controller.q_desired[:], controller.qd_desired[:] = q, qd
        controller.update()
        record.error[row] = q - data.qpos
        record.tau_pd[row], record.tau[row] = controller.tau_pd, controller.tau
        data.qfrc_applied[:] = controller.tau
        mujoco.mj_step(model, data, steps)
    return record


def _model(trial: SoftTrial, gravity: Array) -> tuple[Any, Any]:
    """The arm alone, on a base that stands, with friction as MuJoCo has it."""
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtraError("mujoco", "sim", "the simulated plant") from error
    tree = ET.fromstring(to_mjcf(raven().spec, tilted(0.0), step_s=STEP_S))  # noqa: S314 -- our own text
    for body in tree.iter("body"):
        for joint in [joint for joint in body.findall("joint") if joint.get("name", "").startswith("base ")]:
            body.remove(joint)
    model = mujoco.MjModel.from_xml_string(ET.tostring(tree, encoding="unicode"))
    time_constant, impedance = SOFTNESS[trial.softness]
    model.opt.gravity[:] = gravity
    model.dof_armature[:] = raven2_drive().rotor_inertia
    model.dof_damping[:], model.dof_frictionloss[:] = trial.friction.viscous, trial.friction.coulomb
    model.dof_solref[:, 0] = time_constant
    model.dof_solimp[:, :2] = (impedance, max(impedance, 0.95))
    return mujoco, model
