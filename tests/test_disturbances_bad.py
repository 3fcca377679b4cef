"""Disturbance elements that cannot be meant: each is refused with its place, its value and what would be right."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc as rg
from ravengc.config import spec_from_toml
from ravengc.disturbances import (
    KINDS,
    Constant,
    Friction,
    Harmonic,
    LinearSpring,
    PiecewiseCable,
    Polynomial,
    SpringBetween,
)
from ravengc.errors import ConfigError, ModelError, UnitsError

if TYPE_CHECKING:
    from ravengc.disturbances import Disturbance

ROBOT = rg.load("rrbot")
TEXT = ROBOT.to_toml()
AT = {"name": "x", "joint": "joint2"}
CABLE = {"knots": (0.0,), "pieces": ((1.0,), (0.0,))}
SPRING = {"body_a": "base", "point_a": (0, 0, 0), "body_b": "link2", "point_b": (0, 0, 0), "stiffness": 1.0}

BAD: list[tuple[Disturbance, str]] = [
    (Constant(name="", joint="joint2", torque=1.0), "name: got '', expected a name"),
    (Constant(name="x", joint="joint3", torque=1.0), "joint: there is no joint 'joint3'"),
    (Constant(name="x", joint=(1.0,), torque=1.0), "joint: got 1 numbers, expected 2"),
    (Constant(name="x", joint=(0.0, 0.0), torque=1.0), "expected at least one number that is not 0"),
    (Constant(**AT, torque=float("nan")), "torque: got nan, expected a finite number"),
    (Constant(**AT, torque="1"), "torque: got '1', expected a number"),
    (Polynomial(**AT, coefficients=()), "coefficients: got 0 coefficients, expected 1 to 10"),
    (Polynomial(**AT, coefficients=[0.0] * 11), "got 11 coefficients"),
    (Polynomial(**AT, coefficients=(1.0, float("inf"))), "coefficients: got inf, expected a finite number"),
    (Polynomial(**AT, coefficients=(1.0,), direction="forward"), "direction: got 'forward', expected one of"),
    (Polynomial(**AT, coefficients=(1.0,), range=(0.5, -0.5)), "range: got (0.5, -0.5), expected a lower and a larger"),
    (Polynomial(**AT, coefficients=(1.0,), range=(0.5,)), "range: got 1 numbers, expected 2"),
    (Polynomial(**AT, coefficients=(1.0,), of="joint"), "of: there is no joint 'joint'"),
    (PiecewiseCable(**AT, **{**CABLE, "knots": ()}), "knots: got 0 knots, expected 1 to 8"),
    (PiecewiseCable(**AT, knots=(1.0, 1.0), pieces=((1.0,),) * 3), "expected knots that rise from left to right"),
    (PiecewiseCable(**AT, **{**CABLE, "pieces": ((1.0,),)}), "pieces: got 1, expected 2 polynomials"),
    (PiecewiseCable(**AT, **{**CABLE, "pieces": ((1.0,), ())}), "pieces[1]: got 0 coefficients"),
    (LinearSpring(**AT, stiffness=None), "stiffness: got None, expected a number"),
    (SpringBetween(name="x", **{**SPRING, "stiffness": -1.0}), "stiffness: got -1.0, expected 0 or more"),
    (SpringBetween(name="x", **SPRING, rest_length=-0.1), "rest_length: got -0.1, expected 0 or more"),
    (SpringBetween(name="x", **{**SPRING, "body_b": "link"}), "body_b: there is no link 'link'"),
    (SpringBetween(name="x", **{**SPRING, "body_b": "base"}), "expected bodies with a joint between them"),
    (SpringBetween(name="x", **{**SPRING, "point_a": (0.0, 0.0)}), "point_a: got 2 numbers, expected 3"),
    (Friction(**AT, coulomb=1.0, dead_band=-0.1), "dead_band: got -0.1, expected 0 or more"),
    (Friction(**AT, coulomb=1.0, dead_band=0.1), "saturation: got 0.05, expected more than the dead band, 0.1"),
    (Friction(**AT, coulomb=1.0, saturation=0.0), "a step in the velocity would chatter"),
    (Friction(**AT, coulomb=1.0, ratio=1.5), "ratio: got 1.5, expected 0 to 1"),
    (Friction(**AT, coulomb=1.0, blend="step"), "blend: got 'step', expected one of"),
    (Friction(**AT, stribeck=0.1), "stribeck: got 0.1, expected a stribeck_velocity"),
    (Friction(**AT, stribeck=0.1, stribeck_velocity=0.0), "stribeck_velocity: got 0.0, expected more than 0"),
    (Harmonic(**AT, order=0.0), "order: got 0.0, expected more than 0"),
]


@pytest.mark.parametrize(("element", "problem"), BAD)
def test_an_element_that_cannot_be_meant_is_refused(element: Disturbance, problem: str) -> None:
    with pytest.raises(ModelError) as caught:
        rg.Robot(replace(ROBOT.spec, disturbances=(element,)))
    assert problem in str(caught.value)
    assert str(caught.value).startswith("disturbance 1") or "robot" in str(caught.value)


def test_names_are_unique_and_room_is_limited() -> None:
    same = Constant(**AT, torque=1.0)
    many = tuple(replace(same, name=f"c{i}") for i in range(65))
    wide = tuple(Polynomial(name=f"p{i}", joint="joint1", coefficients=(0.0,) * 10) for i in range(26))
    for elements, problem in (
        ((same, same), "disturbance 2 'x': name: stands twice"),
        (many, "65 disturbance elements, expected at most 64"),
        (wide, "260 parameters of disturbance elements, expected at most 256"),
        ((same, 3), "expected a Polynomial or a PiecewiseCable"),
    ):
        with pytest.raises(ModelError, match=problem):
            rg.Robot(replace(ROBOT.spec, disturbances=elements))
    assert rg.Robot(replace(ROBOT.spec, disturbances=many[:64])).disturbance_parameters().shape == (64,)


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_says_what_is_missing(kind: str) -> None:
    with pytest.raises(ConfigError) as caught:
        spec_from_toml(f'{TEXT}\n[[disturbance]]\nkind = "{kind}"\nname = "x"\n')
    assert f"every element of kind '{kind}' has one" in str(caught.value)
    assert "<text>:" in str(caught.value)


TABLES: list[tuple[str, type[Exception], str]] = [
    ('kind = "sprnig"', ConfigError, "did you mean 'spring'?"),
    ('kind = "constant"\njoint = "joint1"\ntorque = 1\nrest = 2', ConfigError, "unknown key 'rest'"),
    ('kind = "constant"\njoint = "joint1"\ntorque = "1 deg"', UnitsError, "torque"),
    ('kind = "constant"\njoint = 3\ntorque = 1', ConfigError, "joint: got 3, expected a list of numbers"),
    ('kind = "constant"\njoint = [1, "a"]\ntorque = 1', UnitsError, "mixes entries"),
    ('kind = "linear_spring"\njoint = "joint1"\nstiffness = "1 N"', UnitsError, "stiffness"),
    ('kind = "cable"\njoint = "joint1"\nknots = "3 deg"\npieces = [[0], [0]]', ConfigError, "knots: got '3 deg'"),
    ('kind = "cable"\njoint = "joint1"\nknots = [1]\npieces = [0, [0]]', ConfigError, "expected a row of numbers"),
    ('kind = "polynomial"\njoint = "joint1"\ncoefficients = [1]\nrange = ["1 deg", 1]', UnitsError, "range"),
    ('kind = "polynomial"\njoint = "joint9"\ncoefficients = [1]', ModelError, "there is no joint 'joint9'"),
    ('kind = "friction"\njoint = "joint1"\nblend = "hard"', ConfigError, "one of 'linear', 'tanh'"),
]


@pytest.mark.parametrize(("table", "error", "problem"), TABLES)
def test_a_bad_table_is_refused_with_its_line(table: str, error: type[Exception], problem: str) -> None:
    with pytest.raises(error) as caught:
        spec_from_toml(f'{TEXT}\n[[disturbance]]\nname = "x"\n{table}\n')
    assert problem in str(caught.value)
    assert "<text>:" in str(caught.value)
    assert "disturbance 1 'x'" in str(caught.value)


def test_units_are_those_of_the_joint() -> None:
    """Degrees on a turning joint, millimetres on a sliding one, plain numbers where both are mixed."""
    raven = rg.load("raven2_gold")
    turning, _, sliding = raven.joint_names
    tables = f"""
[[disturbance]]
kind = "linear_spring"
name = "a"
joint = "{turning}"
stiffness = "2 N*m/rad"
rest = "90 deg"

[[disturbance]]
kind = "friction"
name = "b"
joint = "{sliding}"
coulomb = "3 N"
saturation = "40 mm/s"

[[disturbance]]
kind = "polynomial"
name = "c"
joint = "{turning}"
of = [1, 0, 0.5]
coefficients = [1, 2]
range = [-1, 1]
"""
    spring, friction, polynomial = spec_from_toml(raven.to_toml() + tables).disturbances
    assert spring == LinearSpring(name="a", joint=turning, stiffness=2.0, rest=np.pi / 2)
    assert friction == Friction(name="b", joint=sliding, coulomb=3.0, saturation=0.04)
    expected = Polynomial(name="c", joint=turning, of=(1.0, 0.0, 0.5), coefficients=(1.0, 2.0), range=(-1.0, 1.0))
    assert polynomial == expected


def test_what_is_given_as_arrays_is_kept_as_tuples() -> None:
    element: Any = Polynomial(name="x", joint=np.array([0.0, 1.0]), coefficients=np.ones(2), range=[0.0, 1.0])
    assert element == Polynomial(name="x", joint=(0.0, 1.0), coefficients=(1.0, 1.0), range=(0.0, 1.0))
    assert hash(element)
    assert [kind(**_least(name)).kind for name, kind in KINDS.items()] == list(KINDS)


def _least(kind: str) -> dict[str, Any]:
    """The fields that an element of this kind must have."""
    along = {"polynomial": {"coefficients": (1.0,)}, "cable": CABLE, "linear_spring": {"stiffness": 1.0}}
    along |= {"friction": {}, "constant": {"torque": 1.0}, "harmonic": {}}
    return {"name": "x", **SPRING} if kind == "spring" else {**AT, **along[kind]}
