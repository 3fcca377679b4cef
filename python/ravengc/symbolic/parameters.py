"""Masses, centres of mass and inertias of the moving links, as symbols with values or as numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ravengc import reference
from ravengc.symbolic.algebra import Expr, Matrix, Triple, added, dot, engine, exact, product, transposed

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.spec import RobotSpec
    from ravengc.symbolic.mechanism import Body, Mechanism
    from ravengc.symbolic.steps import Steps

__all__ = ["Inertial", "inertials", "regressor_columns"]

Ten = tuple[float, ...]
"""Mass (kg), COM (m) and inertia about it (kg·m², xx xy xz yy yz zz) in the link's own frame."""

AXES = "xyz"
PRODUCTS = ("xx", "xy", "xz", "yy", "yz", "zz")


@dataclass(frozen=True, slots=True)
class Inertial:
    """A moving link in its frame J: ``mass``, ``moment`` = mass x COM, ``inertia`` about the origin of J."""

    mass: Expr
    moment: Triple
    inertia: Matrix


def inertials(
    spec: RobotSpec, mechanism: Mechanism, steps: Steps, *, numbers: bool
) -> tuple[list[Inertial], dict[Expr, float]]:
    """The moving links, and what their symbols stand for; what is zero in the robot file is zero, not a symbol."""
    values: dict[Expr, float] = {}

    def entry(name: str, value: float) -> Expr:
        if numbers or value == 0.0:
            return exact(value)
        symbol = engine().Symbol(name)
        values[symbol] = value
        return symbol

    tens = _of_bodies(spec, mechanism)
    bodies = zip(mechanism.bodies, tens, strict=True)
    return [_inertial(body, _ten(index, ten, entry), steps) for index, (body, ten) in enumerate(bodies, 1)], values


def _ten(index: int, ten: Ten, entry: Callable[[str, float], Expr]) -> tuple[Expr, Triple, Matrix]:
    names = (f"m{index}", *(f"c{axis}{index}" for axis in AXES), *(f"I{pair}{index}" for pair in PRODUCTS))
    m, cx, cy, cz, xx, xy, xz, yy, yz, zz = (entry(name, value) for name, value in zip(names, ten, strict=True))
    return m, (cx, cy, cz), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def _inertial(body: Body, ten: tuple[Expr, Triple, Matrix], steps: Steps) -> Inertial:
    """From the link's own frame to J: the COM moves, the inertia turns, and by parallel axes is about the origin."""
    mass, com, about_com = ten
    x, y, z = (steps.atom(component) for component in body.link.point(com))
    moment = steps.names((mass * x, mass * y, mass * z))
    turn = body.link.rotation
    inertia = product(product(turn, about_com), transposed(turn))
    square = dot((x, y, z), (x, y, z))
    parallel = [
        [mass * ((square if a == b else 0) - p * q) for b, q in enumerate((x, y, z))] for a, p in enumerate((x, y, z))
    ]
    rows = [steps.names(added(row, tuple(more))) for row, more in zip(inertia, parallel, strict=True)]
    return Inertial(mass, moment, (rows[0], rows[1], rows[2]))


def _of_bodies(spec: RobotSpec, mechanism: Mechanism) -> list[Ten]:
    """The ten numbers of every moving link: its own, or the sum where links with mass are fixed to it."""
    merged = np.reshape(reference.inertial_parameters(spec), (-1, 10))
    with_mass = [mechanism.frames[link.name][0] for link in spec.links if link.joint == "fixed" and link.mass > 0.0]
    tens = []
    for index, link in enumerate(spec.moving_links):
        own = (link.mass, *link.com, *link.inertia)
        tens.append(_about_com(merged[index]) if index in with_mass else own)
    return tens


def _about_com(ten: np.ndarray) -> Ten:
    """From first moments and inertia about the origin, to 15 digits: sums carry no more."""
    mass, com = ten[0], ten[1:4] / ten[0]
    inertia = ten[4:] - mass * (com @ com * np.eye(3) - np.outer(com, com))[np.triu_indices(3)]
    return tuple(float(f"{value:.15g}") for value in (mass, *com, *np.where(abs(inertia) < 1e-15, 0.0, inertia)))


def regressor_columns(mechanism: Mechanism, *, inertia: bool) -> tuple[str, ...]:
    """Names of the parameters that a regressor's columns multiply: first moments h = m c, inertia about the origin."""
    kinds = ("m", "hx", "hy", "hz", *(f"I{pair}" for pair in PRODUCTS))[: 10 if inertia else 4]
    return tuple(f"{kind}{index}" for index in range(1, len(mechanism.bodies) + 1) for kind in kinds)
