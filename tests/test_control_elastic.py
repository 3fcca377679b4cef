"""Elastic gravity as a term of the controller: on the motors' encoders alone it brings the links to the goal."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import ravengc as rg
from elastic_arm import DAMPING, GOAL, GRAVITY, KD, KP, LEVEL, MOTORS, STEADY, STIFFNESS, two_links
from ravengc import control
from ravengc.errors import ArgumentError, ConfigError

PERIOD, SECONDS = 1e-3, 12.0
DRIVE = control.Drive(KP, KD, MOTORS, "test")
VARIANTS = ("desired", "motor", "biased", "quasi_static", "link")


def springs(robot: rg.Robot, variant: str, **settings: Any) -> rg.ElasticGravity:
    return rg.ElasticGravity(robot, STIFFNESS, variant, kp=KP, **{**LEVEL, "allow_unproven": True, **settings})


def settled(variant: str | None, law: str = "pd+dg") -> np.ndarray:
    """Degrees that the links stand beside the goal, at rest under the controller, after moving there from zero."""
    robot = two_links()
    elastic = None if variant is None else springs(robot, variant)
    loop = control.Controller(robot, law, DRIVE, elastic=elastic)
    loop.gravity[:], loop.q_desired[:] = GRAVITY, GOAL
    q, qd, gravity = np.zeros(2), np.zeros(2), rg.Gravity(*GRAVITY)
    theta, thetad = robot.gravity_torque(q, gravity) / STIFFNESS, np.zeros(2)
    for _ in range(round(SECONDS / PERIOD)):
        loop.q[:], loop.qd[:], loop.q_link[:] = theta, thetad, q
        loop.update()
        pull = STIFFNESS * (theta - q)
        qd = qd + PERIOD * robot.forward_dynamics(q, qd, pull - DAMPING * qd, gravity)
        thetad = thetad + PERIOD * (loop.tau - pull) / MOTORS
        q, theta = q + PERIOD * qd, theta + PERIOD * thetad
    assert loop.state == "armed"
    assert not loop.seen
    return np.degrees(q - GOAL)


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_links_come_to_rest_as_published(variant: str) -> None:
    np.testing.assert_allclose(settled(variant), STEADY[variant], atol=1e-4)


def test_as_if_rigid_they_do_not() -> None:
    np.testing.assert_allclose(settled(None), STEADY["rigid_motor"], atol=1e-4)
    np.testing.assert_allclose(settled(None, "pd"), STEADY["pd"], atol=1e-4)


@pytest.mark.parametrize("law", ["pd+sg", "pd+bm"])
def test_other_laws_with_gravity_take_it_too(law: str) -> None:
    np.testing.assert_allclose(settled("quasi_static", law), 0.0, atol=1e-4)


def test_the_controller_gives_the_terms_of_the_elastic_law() -> None:
    robot = two_links()
    for variant in VARIANTS:
        elastic = springs(robot, variant)
        loop = control.Controller(robot, "pd+dg", DRIVE, elastic=elastic)
        loop.gravity[:], loop.q_desired[:] = GRAVITY, GOAL
        loop.q[:], loop.qd[:], loop.q_link[:] = (0.4, 0.5), (0.1, -0.2), (0.35, 0.45)
        loop.update()
        fed = elastic.torque(loop.q, GOAL, rg.Gravity(*GRAVITY), q=loop.q_link)
        np.testing.assert_array_equal(loop.tau_gravity, fed)
        aim = elastic.theta_desired(GOAL, rg.Gravity(*GRAVITY))
        np.testing.assert_array_equal(loop.theta_desired, aim)
        np.testing.assert_allclose(loop.tau_pd, KP * (aim - loop.q) - KD * loop.qd, rtol=1e-15)
        assert (loop._core.iterations, loop._core.error_bound) == (elastic.iterations, elastic.error_bound)


def test_joints_that_do_not_give_are_rigid() -> None:
    robot = two_links()
    rigid = control.Controller(robot, "pd+dg", DRIVE)
    for variant in ("motor", "biased", "quasi_static", "link"):
        stiff = rg.ElasticGravity(robot, [np.inf, np.inf], variant, kp=KP, allow_unproven=True)
        elastic = control.Controller(robot, "pd+dg", DRIVE, elastic=stiff)
        for loop in (rigid, elastic):
            loop.q[:], loop.q_link[:], loop.q_desired[:], loop.gravity[:] = (0.2, 0.4), (0.2, 0.4), GOAL, GRAVITY
            loop.update()
        np.testing.assert_allclose(elastic.tau, rigid.tau, rtol=1e-12)


def make(robot: rg.Robot, law: str = "pd+dg", drive: control.Drive = DRIVE, **settings: Any) -> control.Controller:
    return control.Controller(robot, law, drive, **settings)


def test_what_cannot_be_meant_is_refused_with_the_numbers() -> None:
    robot, other = two_links(), two_links()
    with pytest.raises(ConfigError, match="the law 'pd' has no gravity term; use 'pd"):
        make(robot, "pd", elastic=springs(robot, "quasi_static"))
    for variant in ("desired", "motor", "biased"):
        with pytest.raises(
            ConfigError, match=f"variant '{variant}', but the law 'passive' has no goal; use quasi_static"
        ):
            make(robot, "passive", elastic=springs(robot, variant))
    with pytest.raises(ConfigError, match=r"made for another robot \('two links', n = 2\)"):
        make(robot, elastic=springs(other, "quasi_static"))
    with pytest.raises(ArgumentError, match="elastic"):
        make(robot, elastic="quasi_static")  # type: ignore[arg-type]


def test_gains_must_keep_what_the_condition_promises() -> None:
    robot = two_links()
    proven = springs(robot, "biased", allow_unproven=False)
    make(robot, elastic=proven)
    weak = control.Drive(0.3 * KP, KD, MOTORS, "weak")
    with pytest.raises(ConfigError, match=r"with these gains: variant 'biased': the least eigenvalue .* K_P of"):
        make(robot, drive=weak, elastic=proven)
    make(robot, drive=weak, elastic=springs(robot, "biased"))
    make(robot, drive=weak, elastic=springs(robot, "quasi_static", allow_unproven=False))


def test_gains_at_the_motors_count_as_what_they_are_at_the_joints() -> None:
    robot, drive = rg.load("raven2_gold"), control.raven2_drive()
    cables = np.array((2000.0, 2000.0, 2e5))
    elastic = rg.ElasticGravity(robot, cables, "biased", kp=drive.kp)
    at_motors = control.Drive(
        drive.kp / control.RAVEN2_RATIO**2, drive.kd / control.RAVEN2_RATIO**2, drive.rotor_inertia, ""
    )
    control.Controller(robot, "pd+dg", at_motors, feedback="motor", elastic=elastic)
    weak = control.Drive(at_motors.kp * 1e-4, at_motors.kd, drive.rotor_inertia, "")
    with pytest.raises(ConfigError, match="with these gains"):
        control.Controller(robot, "pd+dg", weak, feedback="motor", elastic=elastic)


def test_links_are_needed_where_gravity_is_taken_there_and_the_aim_only_with_springs() -> None:
    robot = two_links()
    q, out, aim = np.zeros((3, 2))
    rigid = control.Controller(robot, "pd+dg", DRIVE)._core
    with pytest.raises(ArgumentError, match=r"theta_desired .* elastic="):
        rigid.bind(q=q, out=out, q_desired=q.copy(), gravity=np.array(GRAVITY), theta_desired=aim)
    linked = control.Controller(robot, "pd+dg", DRIVE, elastic=springs(robot, "link"))._core
    with pytest.raises(ArgumentError, match="q_link is missing"):
        linked.bind(q=q, out=out, q_desired=q.copy(), gravity=np.array(GRAVITY))


# Of arrays that are views of one, that one is checked


def test_a_common_array_that_moved_is_refused() -> None:
    robot = two_links()
    law, block = control.Controller(robot, "pd+dg", DRIVE)._core, np.zeros(9)
    cycle = law.bind(q=block[:2], q_desired=block[2:4], out=block[4:6], gravity=block[6:])
    cycle()
    block.resize(10_000, refcheck=False)
    with pytest.raises(ArgumentError, match=r"resized, reshaped.* bind again"):
        cycle()


def test_the_controllers_own_arrays_do_not_overlap() -> None:
    loop = control.Controller(two_links(), "pd+bm", DRIVE)
    arrays = {name: x for name, x in vars(loop).items() if isinstance(x, np.ndarray)}
    for k, x in enumerate(arrays.values(), start=1):
        x[:] = k
    assert len(arrays) == 13
    assert [x[0] for x in arrays.values()] == list(range(1, 14))


# In the simulator, on the RAVEN's cables


@pytest.mark.parametrize("degrees", [0.0, 20.0])
def test_on_the_simulated_cables_the_links_hold_where_the_rigid_law_leaves_the_sag(degrees: float) -> None:
    pytest.importorskip("mujoco")
    from ravengc import loop as loops
    from ravengc import sim

    robot, drive = rg.load("raven2_gold"), control.raven2_drive()
    pose, cables = np.array((math.pi / 4, math.pi / 2, 0.33)), np.array((2000.0, 2000.0, 2e5))
    base = sim.tilted(degrees, tuple(np.array(robot.base.rotation)[:, 2]))
    left = {}
    for variant in (None, "quasi_static", "biased", "link"):
        plant = sim.Plant(
            robot,
            base,
            rotor_inertia=drive.rotor_inertia,
            cable_stiffness=cables,
            cable_damping=0.002 * cables,
            viscous=0.5,
        )
        plant.reset(pose + np.array((0.05, -0.05, 0.005)))
        elastic = None if variant is None else rg.ElasticGravity(robot, cables, variant, kp=drive.kp)
        held = control.Controller(robot, "pd+dg", drive, elastic=elastic)
        held.q_desired[:], held.gravity[:] = pose, -plant.accelerometer()
        at_motors = loops._measuring(plant, held) if elastic is not None else None
        for _ in range(1000):
            if at_motors is None:
                held.q[:], held.qd[:] = plant.motor_q, plant.motor_qd
            else:
                at_motors()
            held.update()
            plant.step(held.tau, 1e-3)
        left[variant] = np.abs(np.degrees(plant.q - pose))[0]
    assert left.pop(None) > 0.02
    assert max(left.values()) < 1e-4
