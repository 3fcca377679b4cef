"""Disturbance elements of a robot's file: known in an identification, or identified and written back."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from ravengc import disturbances as parts
from ravengc import identify
from ravengc.errors import CalibrationError
from ravengc.identify import Model, Recording
from test_identify import moving, static

if TYPE_CHECKING:
    from pathlib import Path

FRICTION = parts.Friction(name="rub", joint="panda_joint2", coulomb=0.8, viscous=0.3, saturation=0.02, blend="tanh")
CABLE = parts.PiecewiseCable(
    name="cable", joint="panda_joint4", knots=(0.05,), pieces=((0.1, 0.4), (0.3, -0.2, 0.5)), range=(-1.0, 1.0)
)
SPRING = parts.SpringBetween(
    name="spring", body_a="panda_link1", point_a=(0.1, 0.0, 0.0), body_b="panda_link2", point_b=(0.0, -0.2, 0.05),
    stiffness=150.0, rest_length=0.05,
)  # fmt: skip
PAIR = tuple(
    parts.Polynomial(name=way, joint="panda_joint6", coefficients=(sign * 0.1, 0.05), direction=way)
    for way, sign in (("positive", 1.0), ("negative", -1.0))
)
ALL = (FRICTION, CABLE, SPRING, *PAIR)


def arm(elements: tuple[parts.Disturbance, ...]) -> rg.Robot:
    return rg.Robot(replace(rg.load("panda").spec, disturbances=elements))


def blank(element: parts.Disturbance) -> parts.Disturbance:
    """The same element with coefficients that are to be found."""
    match element:
        case parts.Friction():
            return replace(element, coulomb=0.0, viscous=0.0)
        case parts.PiecewiseCable():
            return replace(element, pieces=tuple((0.0,) * len(piece) for piece in element.pieces))
        case parts.Polynomial():
            return replace(element, coefficients=(0.0,) * len(element.coefficients))
        case _:
            return replace(element, stiffness=0.0)


def disturbed(elements: tuple[parts.Disturbance, ...] = ALL) -> Recording:
    """A motion whose torques have those of the elements in them."""
    robot, recording = arm(elements), moving(rg.load("panda"))
    torque = [robot.disturbance_torque(q, qd) for q, qd in zip(recording.q, recording.velocity, strict=True)]
    return replace(recording, tau=recording.tau + np.array(torque))


@pytest.mark.parametrize("element", [FRICTION, CABLE, SPRING, *PAIR], ids=lambda element: element.name)
def test_every_kind_is_found(element: parts.Disturbance) -> None:
    robot = arm((blank(element),))
    model = Model(kind="dynamics", friction=(), disturbances=True)
    found = identify.identify(robot, disturbed((element,)), model)
    assert found.refused is None
    assert found.held_out.overall < 1e-8
    (written,) = found.robot().disturbances
    assert written.source.startswith("identified from")
    truth = arm((element,))
    for q, qd in zip(*np.random.default_rng(0).uniform(-1.0, 1.0, (2, 5, 7)), strict=True):
        identified = found.predict(Recording(stamps=[0.0], q=[q], qd=[qd], tau=[q]))
        exact = truth.inverse_dynamics(q, qd, np.zeros(7), rg.Gravity.level()) + truth.disturbance_torque(q, qd)
        np.testing.assert_allclose(identified[0], exact, atol=1e-6)


def test_what_was_found_is_in_the_file(tmp_path: Path) -> None:
    robot, recording = arm(tuple(map(blank, ALL))), disturbed()
    found = identify.identify(robot, recording, Model(kind="dynamics", friction=(), disturbances=True))
    found.write(tmp_path / "arm.toml")
    written = rg.load(tmp_path / "arm.toml")
    rows = zip(recording.q[::50], recording.qd[::50], recording.qdd[::50], recording.tau[::50], strict=True)
    for q, qd, qdd, tau in rows:
        torque = written.inverse_dynamics(q, qd, qdd, rg.Gravity.level()) + written.disturbance_torque(q, qd)
        np.testing.assert_allclose(torque, tau, atol=1e-6)


def test_what_the_file_has_is_known_unless_it_is_sought() -> None:
    robot, recording = arm(ALL), disturbed()
    found = identify.identify(robot, recording, Model(kind="dynamics", friction=()))
    assert found.held_out.overall < 1e-8
    assert found.robot().disturbances == ALL
    np.testing.assert_allclose(found.predict(recording), recording.tau, atol=1e-6)
    without = identify.identify(rg.load("panda"), recording, Model(kind="dynamics", friction=()))
    assert without.held_out.overall > 0.01


def test_known_elements_are_filtered_as_the_torques_are() -> None:
    calm = identify.smoothed(disturbed(), 5.0)
    for model in (Model(kind="dynamics", friction=()), Model(kind="dynamics", friction=(), disturbances=True)):
        found = identify.identify(arm(ALL), calm, model)
        assert found.held_out.overall < 5e-3


def test_an_element_that_predicts_worse_is_refused_by_its_name() -> None:
    robot = rg.load("raven2_gold")
    wild = parts.Polynomial(name="wild cable", joint="elbow", coefficients=(0.0,) * 9)
    robot = rg.Robot(replace(robot.spec, disturbances=(wild,)))
    recording = static(robot, 44, 0.3, noise=0.2)
    found = identify.identify(robot, recording, Model(disturbances=True))
    assert found.refused is not None
    assert "wild cable" in found.refused
    with pytest.raises(CalibrationError, match="wild cable"):
        found.robot()


def test_a_spring_that_would_push_is_no_spring() -> None:
    pushing = replace(SPRING, stiffness=0.0)
    recording = disturbed((SPRING,))
    wrong = replace(recording, tau=2.0 * moving(rg.load("panda")).tau - recording.tau)
    found = identify.identify(arm((pushing,)), wrong, Model(kind="dynamics", friction=(), disturbances=True))
    assert found.coefficients["spring.stiffness"] == pytest.approx(-150.0)
    with pytest.raises(CalibrationError, match="'spring' would have a stiffness of -150 N/m"):
        found.robot()


def test_a_plan_counts_the_robots_own_cables() -> None:
    cable = parts.Polynomial(name="cable", joint="shoulder_pitch", coefficients=(0.0, 0.0))
    robot = rg.Robot(replace(rg.load("dvrk_mtmr").spec, disturbances=(cable,)))
    near = {"shoulder_pitch": tuple(np.radians([-11.0, 16.0]))}
    plain = identify.plan(robot, Model(), poses=15, candidates=60, ranges=near)
    own = identify.plan(robot, Model(disturbances=True), poses=15, candidates=60, ranges=near)
    assert own.level.worst[1] > 20.0 * plain.level.worst[1]
    assert own.predicted.worst[1] < 0.02
