"""The plant's integration against MuJoCo's own, and its torques against the core on every kind of base.

MuJoCo's base is carried along by forces that give it exactly the accelerations that are prescribed.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import ravengc
from bounds import assert_close, bounds
from ravengc import sim
from ravengc.spec import DhRow, LinkSpec, RobotSpec

mujoco = pytest.importorskip("mujoco")

BASE = 6
STEP = 5e-4
BASES = {
    "level": sim.level(),
    "ship": sim.ship(),
    "rocking": sim.rocking(10, 20, hz=1.0, pivot=(0.0, 0.0, -0.3)),
    "elevator": sim.elevator(4.0, start_s=0.0),
}
TIMES = np.linspace(0.0, 4.0, 81)
WAVES = sim.oscillating(amplitude=(0.2,) * 6, hz=(0.3, 0.4, 0.2, 0.5, 0.3, 0.25))
BASES["recorded"] = sim.recorded_imu(
    TIMES, *(np.array([WAVES.motion_at(t, (0.0, 0.0, 0.0))[part] for t in TIMES]) for part in (0, 1))
)
WITH_MASSES = [name for name in ravengc.config.bundled_names() if any(x.mass for x in ravengc.load(name).spec.links)]


class Referee:
    """MuJoCo's ``mj_step`` of the plant's model, with rotors and damping as it has them, on the prescribed base."""

    def __init__(self, plant: sim.Plant, *, rotor: Any, viscous: Any) -> None:
        self.base = plant.base
        self.model = mujoco.MjModel.from_xml_string(plant.mjcf)
        self.model.dof_armature[BASE:] = rotor
        self.model.dof_damping[BASE:] = viscous
        self.data = mujoco.MjData(self.model)
        mujoco.mj_setConst(self.model, self.data)
        self.data.qpos[BASE:], self.data.qvel[BASE:] = plant.q, plant.qd
        self.time = plant.time

    def step(self, tau: np.ndarray) -> None:
        model, data, h = self.model, self.data, self.model.opt.timestep
        data.qpos[:BASE], data.qvel[:BASE], wanted = self.base.state(self.time)
        data.qfrc_applied[:] = (*np.zeros(BASE), *tau)
        mujoco.mj_forward(model, data)
        inertia = np.zeros((model.nv, model.nv))
        for column, unit in zip(inertia, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        inertia += h * np.diag(model.dof_damping)
        smooth = data.qfrc_smooth
        arm = np.linalg.solve(inertia[BASE:, BASE:], smooth[BASE:] - inertia[BASE:, :BASE] @ wanted)
        data.qfrc_applied[:BASE] = inertia[:BASE] @ np.concatenate((wanted, arm)) - smooth[:BASE]
        mujoco.mj_step(model, data)
        self.time += h

    @property
    def q(self) -> np.ndarray:
        return np.array(self.data.qpos[BASE:])


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("name", ["raven2_gold", "panda", "rrbot"])
def test_trajectories_are_those_of_mujoco(name: str, base: str) -> None:
    """Rotors and viscous friction, torques that change at every step: the same numbers after 200 steps."""
    robot = ravengc.load(name)
    random = np.random.default_rng(5)
    rotor, viscous = 0.1 + random.random(robot.n), random.random(robot.n)
    plant = sim.Plant(robot, BASES[base], step_s=STEP, rotor_inertia=rotor, viscous=viscous)
    plant.reset(random.random(robot.n), random.standard_normal(robot.n), time=0.3)
    referee = Referee(plant, rotor=rotor, viscous=viscous)
    start = plant.q.copy()
    for tau in 5.0 * random.standard_normal((200, robot.n)):
        plant.step(tau, STEP)
        referee.step(tau)
    assert np.abs(plant.q - start).max() > 0.03
    np.testing.assert_allclose(plant.q, referee.q, atol=1e-10)


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("name", WITH_MASSES)
def test_torques_are_those_of_the_core(name: str, base: str) -> None:
    robot = ravengc.load(name)
    plant = sim.Plant(robot, BASES[base], rotor_inertia=1.0)
    random = np.random.default_rng(2)
    for t in (0.13, 1.4, 3.9):
        motion = random.standard_normal((3, robot.n))
        plant.reset(motion[0], time=t)
        exact = BASES[base].motion_at(t, (0.0, 0.0, 0.0))
        scale = bounds(robot.spec, *motion, *exact)
        torque = robot.inverse_dynamics(*motion, BASES[base].motion(t))
        assert_close(plant.inverse_dynamics(*motion), torque, scale.torque, 1e-10)


# Friction


def turntable() -> ravengc.Robot:
    """One link about a vertical axis, 0.5 kg m^2."""
    rod = LinkSpec(name="rod", placement=DhRow(), mass=2.0, com=(0.5, 0.0, 0.0))
    return ravengc.Robot(RobotSpec(name="turntable", convention="modified", links=(rod,)))


def test_soft_friction_is_mujoco_s() -> None:
    """Push, slide, stop, creep back: the same path, on a base that stands, within the tolerance of MuJoCo's solver."""
    plant = sim.Plant(turntable(), step_s=STEP, rotor_inertia=0.2, coulomb=2.0, friction="soft")
    model = mujoco.MjModel.from_xml_string(re.sub(r'<joint name="base [^>]*>', "", plant.mjcf))
    model.dof_armature[:], model.dof_frictionloss[:], model.opt.tolerance = 0.2, 2.0, 1e-14
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    path = []
    for k in range(600):
        tau = np.array((3.0 * np.sin(0.02 * k),))
        plant.step(tau, STEP)
        data.qfrc_applied[:] = tau
        mujoco.mj_step(model, data)
        path.append(plant.q[0])
        assert plant.q == pytest.approx(data.qpos, abs=1e-9)
    assert np.ptp(path) > 1e-3


def test_stuck_soft_friction_creeps_where_exact_friction_stands() -> None:
    """1.06 ms times the acceleration that the torque would give without friction."""
    rates = {}
    for friction in ("stick", "soft"):
        plant = sim.Plant(turntable(), coulomb=2.0, friction=friction)
        plant.reset([0.0])
        plant.step([1.0], 0.5)
        rates[friction] = plant.qd[0]
    assert rates["stick"] == 0.0
    assert rates["soft"] == pytest.approx(1.0 / 0.5 * 0.95 * 0.01 / 9.0, rel=1e-6)


@pytest.mark.parametrize("friction", ["stick", "soft"])
def test_sliding_friction_is_at_its_limit(friction: str) -> None:
    robot = ravengc.load("raven2_gold")
    plant = sim.Plant(robot, rotor_inertia=0.3, coulomb=(1.0, 2.0, 3.0), friction=friction)
    plant.reset((0.8, 1.5, 0.4), (2.0, -2.0, 1.0))
    plant.step(robot.gravity_torque(plant.q, (0.0, 0.0, -9.8)), 1e-3)
    np.testing.assert_allclose(plant.friction_torque, (1.0, -2.0, 3.0))


def test_friction_takes_no_more_than_its_work() -> None:
    """The work of Coulomb friction is its limit times the way, in both models: what is lost of the energy."""
    for friction in ("stick", "soft"):
        plant = sim.Plant(turntable(), step_s=1e-4, coulomb=1.0, friction=friction)
        plant.reset([0.0], [2.0])
        plant.step([0.0], 0.5)
        assert 0.5 * 0.5 * (2.0**2 - plant.qd[0] ** 2) == pytest.approx(plant.q[0], abs=1e-3)
