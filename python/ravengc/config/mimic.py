"""Mimic joints of a URDF as one affine coupling: q_mechanism = C q + c0, with a column per joint that mimics none."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc.errors import ModelError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.spec import CouplingSpec, LinkSpec

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ravengc.config.urdf_xml import Element

__all__ = ["read_mimic"]


def read_mimic(joints: Sequence[Element], links: Sequence[LinkSpec]) -> CouplingSpec | None:
    """Return the coupling of the moving joints (element and link of each, in tree order), or None where none mimics.

    A joint may mimic one that mimics a third; a joint that is fixed, unknown, or in a circle is a ModelError.
    """
    moving = {
        link.joint_name: (joint, link) for joint, link in zip(joints, links, strict=True) if link.joint != "fixed"
    }
    mimics = {name: joint.first("mimic") for name, (joint, _) in moving.items()}
    coordinates = tuple(name for name, mimic in mimics.items() if mimic is None)
    if len(coordinates) == len(moving):
        return None
    matrix, offset = [], []
    for name in moving:
        master, multiplier, constant = _follow(name, mimics)
        matrix.append(tuple(multiplier if coordinate == master else 0.0 for coordinate in coordinates))
        offset.append(constant)
    limits = tuple(moving[name][1].limits for name in coordinates)
    return CouplingSpec(coordinates=coordinates, matrix=tuple(matrix), offset=tuple(offset), limits=limits)


def _follow(name: str, mimics: dict[str, Element | None]) -> tuple[str, float, float]:
    """Return the joint at the end of the chain, and joint ``name`` as multiplier * end + offset."""
    multiplier, offset, seen = 1.0, 0.0, [name]
    mimic = mimics[name]
    while mimic is not None:
        offset += multiplier * mimic.number("offset", 0.0)
        multiplier *= mimic.number("multiplier", 1.0)
        master = mimic.get("joint")
        if master not in mimics:
            near = did_you_mean(master, mimics)
            raise _error(mimic, name, f"there is no moving joint {shown(master)}{near} (moving: {listed(mimics)})")
        if master in seen:
            raise _error(mimic, name, f"joints {listed([*seen, master])} mimic each other in a circle")
        seen.append(master)
        mimic = mimics[master]
    return seen[-1], multiplier, offset


def _error(mimic: Element, name: str, problem: str) -> ModelError:
    return ModelError(f"{mimic.file}:{mimic.line}: <mimic> of joint {name!r}: {problem}")
