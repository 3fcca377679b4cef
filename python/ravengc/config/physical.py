"""What numbers of a link a body can have: finite ones, a rotation that is one, an inertia that some body has."""

from __future__ import annotations

import math
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from ravengc.config.rotations import Inertia, matrix_from_inertia
from ravengc.errors import ModelError
from ravengc.messages import shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.config.locate import Place
    from ravengc.spec import LinkSpec, Pose, Vector

__all__ = [
    "LARGEST",
    "TOLERANCE",
    "UNIT_TOLERANCE",
    "check_angle",
    "check_axis",
    "check_body",
    "check_numbers",
    "check_pose",
    "has_full_column_rank",
    "inverse",
    "principal_moments",
]

LARGEST = 1e9
"""No length, mass, inertia, ratio or limit of an arm is larger (SI); what is, is a slip, and could overflow later."""

TOLERANCE = 1e-9
"""How far a rotation may be from orthonormal, and (relative) an inertia from possible: rounding in a file, no more."""

A_TURN = 6.3
"""No fixed angle of a frame is larger (rad): a turn, and the rounding of files. What is, was meant in degrees."""

UNIT_TOLERANCE = 1e-12
"""How far the length of an axis may be from 1; readers of files bring an axis of any length to 1."""


def check_numbers(values: Sequence[float], count: int, place: Place) -> None:
    """Raise ModelError unless there are ``count`` finite numbers of sensible size."""
    if len(values) != count:
        raise ModelError(f"{place}: got {len(values)} numbers, expected {count}")
    for value in values:
        if not isinstance(value, Real) or not abs(value) <= LARGEST:
            expected = f"a finite number of at most {LARGEST:.0e} (SI)"
            raise ModelError(f"{place}: got {shown(value)}, expected {expected}")


def check_angle(angle: float, place: Place) -> None:
    """Raise ModelError for a fixed angle (rad) of more than a turn."""
    if abs(angle) > A_TURN:
        instead = f"angles without a unit are in rad, and {angle:g} deg are {math.radians(angle):.6g}"
        raise ModelError(f"{place}: {angle:g} rad is more than a turn; {instead}")


def check_pose(pose: Pose, place: Place) -> None:
    """Raise ModelError unless the rotation is one (orthonormal, not a mirror) and the translation is finite."""
    check_numbers(pose.translation, 3, place.at("translation"))
    of_rotation = place.at("rotation")
    if len(pose.rotation) != 3:
        raise ModelError(f"{of_rotation}: got {len(pose.rotation)} rows, expected 3")
    for row in pose.rotation:
        check_numbers(row, 3, of_rotation)
    rotation = np.array(pose.rotation, dtype=np.float64)
    error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if error > TOLERANCE:
        allowed = f"at most {TOLERANCE:.0e} is allowed"
        raise ModelError(f"{of_rotation}: not orthonormal: R Rᵀ differs from 1 by {error:.3g}, {allowed}")
    if np.linalg.det(rotation) < 0.0:
        raise ModelError(f"{of_rotation}: a mirror (determinant -1), not a rotation: one axis has the wrong sign")


def check_axis(axis: Vector, place: Place) -> None:
    """Raise ModelError unless the joint's axis is a unit vector."""
    check_numbers(axis, 3, place)
    length = math.hypot(*axis)
    if abs(length - 1.0) > UNIT_TOLERANCE:
        raise ModelError(f"{place}: {shown(axis)} has length {length:.6g}, expected a unit vector")


def check_body(link: LinkSpec, place: Place) -> None:
    """Raise ModelError unless mass, COM and inertia belong to a body, or to a link that is declared massless."""
    check_numbers((link.mass,), 1, place.at("mass"))
    check_numbers(link.com, 3, place.at("com"))
    check_numbers(link.inertia, 6, place.at("inertia"))
    for key, problem in (("mass", _mass_problem(link)), ("inertia", _inertia_problem(link))):
        if problem:
            raise ModelError(f"{place.at(key)}: {problem}")


def _mass_problem(link: LinkSpec) -> str:
    if link.mass < 0.0:
        return f"got {link.mass!r}, expected 0 or more (kg)"
    if link.mass == 0.0 and not link.massless:
        return "is 0 or not given; give a mass (kg), or massless = true if the link is meant to have none"
    if link.mass > 0.0 and link.massless:
        return f"got {link.mass!r} for a link that is declared massless; drop one of the two"
    return ""


def _inertia_problem(link: LinkSpec) -> str:
    """No principal moment of a body is negative, and none exceeds the sum of the other two."""
    if not any(link.inertia):
        return ""
    if link.mass == 0.0:
        return f"got {shown(link.inertia)} for a link without mass, expected none"
    if _is_possible(link.inertia):
        return ""
    moments = ", ".join(f"{moment:.6g}" for moment in principal_moments(link.inertia))
    return (
        f"got {shown(link.inertia)}, which no body has: principal moments {moments} kg·m², expected none negative and "
        f"none above the sum of the other two (about the centre of mass, order xx xy xz yy yz zz)"
        f"{_other_order(link.inertia)}"
    )


def _other_order(inertia: Inertia) -> str:
    """Tell whether the numbers would be possible in the other common order."""
    xx, yy, zz, xy, xz, yz = inertia
    possible = _is_possible((xx, xy, xz, yy, yz, zz))
    return "; read in the order xx yy zz xy xz yz they would be possible" if possible else ""


def principal_moments(inertia: Inertia) -> tuple[float, float, float]:
    """Return the principal moments of inertia (kg·m²), ascending."""
    scale = max(map(abs, inertia)) or 1.0
    a, b, c = (scale * np.linalg.eigvalsh(matrix_from_inertia(inertia) / scale)).tolist()
    return (a, b, c)


def _is_possible(inertia: Inertia) -> bool:
    a, b, c = principal_moments(inertia)
    slack = TOLERANCE * max(abs(a), abs(c))
    return a >= -slack and a + b - c >= -slack


def has_full_column_rank(matrix: Sequence[Sequence[float]]) -> bool:
    """Tell whether no column is a combination of the others, whatever units each column is in."""
    a = np.array(matrix, dtype=np.float64)
    largest = np.abs(a).max(axis=0)
    return bool(largest.all()) and int(np.linalg.matrix_rank(a / largest)) == a.shape[1]


def inverse(matrix: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...] | None:
    """Return the inverse of a square matrix, or None where it has none, whatever units its rows and columns are in."""
    a = np.array(matrix, dtype=np.float64)
    rows = np.abs(a).max(axis=1, keepdims=True)
    if not rows.all() or not has_full_column_rank((a / rows).tolist()):
        return None
    columns = np.abs(a / rows).max(axis=0, keepdims=True)
    with np.errstate(over="ignore"):
        inverted = np.linalg.inv(a / rows / columns) / columns.T / rows.T
    return tuple(map(tuple, inverted.tolist()))
