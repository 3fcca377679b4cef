"""What a disturbance element must satisfy to act on a robot: joints and bodies that exist, numbers in order."""

from __future__ import annotations

from dataclasses import fields
from itertools import pairwise
from typing import TYPE_CHECKING

from ravengc.config.physical import check_numbers
from ravengc.disturbances import Constant, Friction, Harmonic, PiecewiseCable, Polynomial, SpringBetween
from ravengc.errors import ModelError
from ravengc.messages import did_you_mean, listed, shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.config.locate import Place
    from ravengc.disturbances import Along, Disturbance
    from ravengc.spec import RobotSpec

__all__ = ["BLENDS", "DIRECTIONS", "check_capacity", "check_element"]

MOST_ELEMENTS = 64
MOST_COLUMNS = 256
MOST_COEFFICIENTS = 10
MOST_KNOTS = 8

DIRECTIONS = ("both", "positive", "negative")
BLENDS = ("linear", "tanh")

PLAIN = ("viscous", "coulomb", "stribeck", "torque", "cosine", "sine", "stiffness", "rest")
"""Fields that may be any finite number."""


def check_capacity(elements: Sequence[Disturbance], place: Place) -> None:
    """Raise ModelError for more elements, or more of their parameters, than the core has room for."""
    if len(elements) > MOST_ELEMENTS:
        raise ModelError(f"{place}: {len(elements)} disturbance elements, expected at most {MOST_ELEMENTS}")
    columns = sum(len(element.labels) for element in elements)
    if columns > MOST_COLUMNS:
        raise ModelError(f"{place}: {columns} parameters of disturbance elements, expected at most {MOST_COLUMNS}")


def check_element(element: Disturbance, spec: RobotSpec, place: Place) -> None:
    """Raise ModelError for an element that cannot act on this robot, or whose numbers cannot be meant."""
    for field in fields(element):
        if field.name in PLAIN:
            check_numbers((getattr(element, field.name),), 1, place.at(field.name))
    if isinstance(element, SpringBetween):
        _check_spring(element, spec, place)
        return
    _check_along(element.joint, spec, place.at("joint"))
    if not isinstance(element, Constant) and element.of is not None:
        _check_along(element.of, spec, place.at("of"))
    match element:
        case Polynomial():
            _check_polynomial(element, place)
        case PiecewiseCable():
            _check_pieces(element, place)
        case Friction():
            _check_friction(element, place)
        case Harmonic():
            _check_positive(element.order, place.at("order"))


def _check_along(along: Along, spec: RobotSpec, place: Place) -> None:
    names = spec.coordinate_names
    if not isinstance(along, str):
        check_numbers(along, len(names), place)
        if not any(along):
            raise ModelError(f"{place}: got {shown(along)}, expected at least one number that is not 0")
    elif along not in names:
        near = did_you_mean(along, names)
        raise ModelError(f"{place}: there is no joint {shown(along)}{near} (joints: {listed(names)})")


def _check_polynomial(polynomial: Polynomial, place: Place) -> None:
    _check_coefficients(polynomial.coefficients, place.at("coefficients"))
    _check_choice(polynomial.direction, DIRECTIONS, place.at("direction"))
    _check_range(polynomial.range, place.at("range"))
    _check_blend(polynomial, place)


def _check_range(interval: tuple[float, ...] | None, place: Place) -> None:
    if interval is None:
        return
    check_numbers(interval, 2, place)
    if not interval[0] < interval[1]:
        raise ModelError(f"{place}: got {shown(interval)}, expected a lower and a larger upper end")


def _check_blend(element: Polynomial | Friction, place: Place) -> None:
    dead_band, saturation, ratio = element.dead_band, element.saturation, element.ratio
    for name, value in (("dead_band", dead_band), ("saturation", saturation), ("ratio", ratio)):
        check_numbers((value,), 1, place.at(name))
    if dead_band < 0.0:
        raise ModelError(f"{place.at('dead_band')}: got {dead_band!r}, expected 0 or more (rad/s, m/s)")
    if not saturation > dead_band:
        expected = f"expected more than the dead band, {dead_band!r}: a step in the velocity would chatter"
        raise ModelError(f"{place.at('saturation')}: got {saturation!r}, {expected}")
    if not 0.0 <= ratio <= 1.0:
        raise ModelError(f"{place.at('ratio')}: got {ratio!r}, expected 0 to 1, the share that is compensated")
    _check_choice(element.blend, BLENDS, place.at("blend"))


def _check_choice(value: str, options: Sequence[str], place: Place) -> None:
    if value not in options:
        near = did_you_mean(value, options)
        raise ModelError(f"{place}: got {shown(value)}, expected one of {listed(options)}{near}")


def _check_coefficients(coefficients: Sequence[float], place: Place) -> None:
    if not 1 <= len(coefficients) <= MOST_COEFFICIENTS:
        expected = f"expected 1 to {MOST_COEFFICIENTS}, from the constant on"
        raise ModelError(f"{place}: got {len(coefficients)} coefficients, {expected}")
    check_numbers(coefficients, len(coefficients), place)


def _check_pieces(cable: PiecewiseCable, place: Place) -> None:
    knots, pieces = cable.knots, cable.pieces
    if not 1 <= len(knots) <= MOST_KNOTS:
        raise ModelError(f"{place.at('knots')}: got {len(knots)} knots, expected 1 to {MOST_KNOTS}")
    check_numbers(knots, len(knots), place.at("knots"))
    if not all(left < right for left, right in pairwise(knots)):
        raise ModelError(f"{place.at('knots')}: got {shown(knots)}, expected knots that rise from left to right")
    if len(pieces) != len(knots) + 1:
        expected = f"expected {len(knots) + 1} polynomials, one more than there are knots"
        raise ModelError(f"{place.at('pieces')}: got {len(pieces)}, {expected}")
    for index, piece in enumerate(pieces):
        _check_coefficients(piece, place.at("pieces", index))
    _check_range(cable.range, place.at("range"))


def _check_friction(friction: Friction, place: Place) -> None:
    _check_blend(friction, place)
    velocity = friction.stribeck_velocity
    if velocity is not None:
        _check_positive(velocity, place.at("stribeck_velocity"))
    elif friction.stribeck != 0.0:
        expected = "expected a stribeck_velocity (rad/s, m/s) with it, at which it has fallen to 1/e"
        raise ModelError(f"{place.at('stribeck')}: got {friction.stribeck!r}, {expected}")


def _check_positive(value: float, place: Place) -> None:
    check_numbers((value,), 1, place)
    if not value > 0.0:
        raise ModelError(f"{place}: got {value!r}, expected more than 0")


def _check_spring(spring: SpringBetween, spec: RobotSpec, place: Place) -> None:
    for name, value in (("stiffness", spring.stiffness), ("rest_length", spring.rest_length)):
        check_numbers((value,), 1, place.at(name))
        if value < 0.0:
            raise ModelError(f"{place.at(name)}: got {value!r}, expected 0 or more")
    carriers = _carriers(spec)
    for end in ("body_a", "body_b"):
        body = getattr(spring, end)
        if body not in carriers:
            near = did_you_mean(body, carriers)
            raise ModelError(f"{place.at(end)}: there is no link {shown(body)}{near} (bodies: {listed(carriers)})")
        check_numbers(getattr(spring, end.replace("body", "point")), 3, place.at(end.replace("body", "point")))
    if carriers[spring.body_a] == carriers[spring.body_b]:
        rigid = f"{shown(spring.body_b)} is {shown(spring.body_a)} or fixed to it"
        raise ModelError(f"{place.at('body_b')}: {rigid}, expected bodies with a joint between them")


def _carriers(spec: RobotSpec) -> dict[str, str]:
    """The body that each link is a part of, by the name of its first link; "base" for the base."""
    carriers = {"base": "base"}
    for link in spec.links:
        carriers[link.name] = carriers[link.parent or "base"] if link.joint == "fixed" else link.name
    return carriers
