"""What a robot file has of an identified element: a polynomial, friction, a constant torque.

A polynomial is kept to the range that was visited: beyond it the torque stays constant, because nothing is known there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ravengc.disturbances import Constant, Friction, Polynomial

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ravengc.disturbances import Disturbance

    Filed = Callable[[tuple[float, ...], tuple[float, float], float], tuple[Disturbance, ...]]
    Along = str | tuple[float, ...]

__all__ = ["friction", "polynomial", "stribeck_velocity"]

WRITTEN = {"coulomb", "viscous", "stribeck", "offset"}
"""Terms of friction that a robot file knows."""
MOST_COEFFICIENTS = 10
SATURATION = 0.05
"""rad/s, m/s: where control laws add all of the friction, if it was identified as a step."""


def stribeck_velocity(width: float) -> float:
    """The speed at which what breaking loose takes has faded, for friction rounded over ``width``."""
    return max(10.0 * width, SATURATION)


def friction(name: str, joint: Along, terms: Sequence[str], width: float) -> Filed | None:
    """Friction and its offset; ``None`` if there is a term that a robot file does not know."""
    if not set(terms) <= WRITTEN:
        return None

    def filed(coefficients: tuple[float, ...], _: tuple[float, float], share: float) -> tuple[Disturbance, ...]:
        found = dict(zip(terms, coefficients, strict=True))
        parts: list[Disturbance] = []
        if "offset" in found:
            parts.append(Constant(name=f"{name} offset", joint=joint, torque=found["offset"]))
        if share > 0.0 and set(found) - {"offset"}:
            rubbing = Friction(
                name=f"{name} friction",
                joint=joint,
                coulomb=found.get("coulomb", 0.0),
                viscous=share * found.get("viscous", 0.0),
                stribeck=found.get("stribeck", 0.0),
                stribeck_velocity=stribeck_velocity(width) if "stribeck" in found else None,
                saturation=width or SATURATION,
                ratio=share,
                blend="tanh" if width else "linear",
            )
            parts.append(rubbing)
        return tuple(parts)

    return filed


def polynomial(name: str, joint: Along, powers: Sequence[int], middle: float, unit: float) -> Filed | None:
    """The polynomial in powers of s itself: Σ c_k ((s - middle)/unit)^k multiplied out; ``None`` if it has too many."""
    if max(powers, default=0) >= MOST_COEFFICIENTS:
        return None

    def filed(coefficients: tuple[float, ...], span: tuple[float, float], _: float) -> tuple[Disturbance, ...]:
        series = np.zeros(max(powers) + 1)
        for power, coefficient in zip(powers, coefficients, strict=True):
            series[power] += coefficient
        whole = np.polynomial.Polynomial(series)(np.polynomial.Polynomial([-middle / unit, 1.0 / unit]))
        return (Polynomial(name=name, joint=joint, coefficients=tuple(whole.coef.tolist()), range=span),)

    return filed
