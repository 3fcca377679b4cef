"""Hypothesis strategies: disturbance elements for any robot, on a grid, so that a failing one can be read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hypothesis import strategies as st

from ravengc.disturbances import (
    Constant,
    Disturbance,
    Friction,
    Harmonic,
    LinearSpring,
    PiecewiseCable,
    Polynomial,
    SpringBetween,
)
from strategies import POSITION, grid

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

NUMBER = grid(-2.0, 2.0, 0.01)
COEFFICIENTS = st.lists(NUMBER, min_size=1, max_size=6).map(tuple)
RANGE = st.one_of(st.none(), st.tuples(grid(-1.5, -0.1, 0.1), grid(0.0, 1.5, 0.1)))


def along(spec: RobotSpec) -> st.SearchStrategy[str | tuple[float, ...]]:
    """A coordinate, or a share of each, one of them not zero."""
    names = spec.coordinate_names
    shares = st.lists(st.sampled_from((0.0, 1.0, -0.5)), min_size=len(names), max_size=len(names))
    return st.one_of(st.sampled_from(names), shares.map(lambda found: tuple(found) if any(found) else names[0]))


@st.composite
def blends(draw: st.DrawFn) -> dict[str, object]:
    dead_band = draw(st.sampled_from((0.0, 0.01, 0.1)))
    return {
        "dead_band": dead_band,
        "saturation": dead_band + draw(st.sampled_from((0.02, 0.3))),
        "ratio": draw(st.sampled_from((0.0, 0.4, 1.0))),
        "blend": draw(st.sampled_from(("linear", "tanh"))),
    }


@st.composite
def cables(draw: st.DrawFn, where: dict[str, object]) -> PiecewiseCable:
    knots = sorted(draw(st.sets(grid(-1.0, 1.0, 0.05), min_size=1, max_size=8)))
    pieces = draw(st.lists(COEFFICIENTS, min_size=len(knots) + 1, max_size=len(knots) + 1))
    return PiecewiseCable(**where, knots=knots, pieces=pieces, range=draw(RANGE))


@st.composite
def elements(draw: st.DrawFn, spec: RobotSpec, name: str) -> Disturbance:
    """Any element that acts along joints."""
    joint = draw(along(spec))
    where = {"name": name, "joint": joint, "of": draw(st.one_of(st.none(), along(spec)))}
    match draw(st.integers(0, 5)):
        case 0:
            direction, ends = draw(st.sampled_from(("both", "positive", "negative"))), draw(RANGE)
            return Polynomial(
                **where, coefficients=draw(COEFFICIENTS), direction=direction, range=ends, **draw(blends())
            )
        case 1:
            return draw(cables(where))
        case 2:
            return LinearSpring(**where, stiffness=draw(NUMBER), rest=draw(NUMBER))
        case 3:
            terms = {"coulomb": draw(NUMBER), "viscous": draw(NUMBER)}
            if draw(st.booleans()):
                terms |= {"stribeck": draw(NUMBER), "stribeck_velocity": draw(st.sampled_from((0.05, 0.5)))}
            return Friction(**where, **terms, **draw(blends()))
        case 4:
            return Harmonic(**where, cosine=draw(NUMBER), sine=draw(NUMBER), order=draw(st.sampled_from((1.0, 7.5))))
        case _:
            return Constant(name=name, joint=joint, torque=draw(NUMBER))


@st.composite
def springs(draw: st.DrawFn, spec: RobotSpec, name: str) -> SpringBetween:
    """A spring between the base or a link and a link that moves."""
    moving = draw(st.sampled_from([link.name for link in spec.moving_links]))
    others = ["base", *(link.name for link in spec.moving_links if link.name != moving)]
    return SpringBetween(
        name=name,
        body_a=moving,
        point_a=draw(POSITION),
        body_b=draw(st.sampled_from(others)),
        point_b=draw(POSITION),
        stiffness=draw(grid(0.0, 300.0, 1.0)),
        rest_length=draw(st.one_of(st.just(0.0), grid(0.0, 0.5))),
    )


def some(spec: RobotSpec) -> st.SearchStrategy[tuple[Disturbance, ...]]:
    """Up to six elements of any kind."""
    kinds = st.lists(st.sampled_from((elements, elements, springs)), max_size=6)
    return kinds.flatmap(lambda chosen: st.tuples(*(kind(spec, f"e{i}") for i, kind in enumerate(chosen))))
