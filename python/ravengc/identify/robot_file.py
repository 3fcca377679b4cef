"""From identified parameters to a robot file: bodies that have them, and where the numbers come from."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ravengc.errors import CalibrationError
from ravengc.identify.consistent import pseudo_inertia
from ravengc.identify.own_elements import filled, own_columns

if TYPE_CHECKING:
    from ravengc.identify.base_parameters import BaseParameters
    from ravengc.identify.model import Model
    from ravengc.identify.recording import FloatArray
    from ravengc.robot import Robot
    from ravengc.spec import LinkSpec, RobotSpec

__all__ = ["identified_spec", "nearest"]

NO_MASS = 1e-9
"""kg below which a link is massless."""
UNKNOWN_AT = 0.1
"""m: where the centre of mass is put if only its product with the mass is known."""


def nearest(robot: Robot, model: Model, base: BaseParameters, parameters: FloatArray) -> FloatArray:
    """All parameters (p,) with these base parameters that differ least from the robot's own.

    Differences are counted in the robot's scale: masses in shares of its mean link mass (at least 0.1 kg), moments in
    that mass at 0.1 m. p = p0 + W² Kᵀ (K W² Kᵀ)⁻¹ (b - K p0). A link that has a first moment without a positive mass
    gets the one with which its centre of mass is about 0.1 m from its frame, unless torques show that it has none.
    """
    prior = model.prior(robot)
    count = len(model.link_columns(robot.spec))
    mass = max(0.1, float(np.mean(np.abs(prior[0 : count : len(model.per_link)]))) if count else 0.1)
    units = {"m": mass, "hx": 0.1 * mass, "hy": 0.1 * mass, "hz": 0.1 * mass}
    scale = np.ones(len(prior))
    scale[:count] = [units.get(name.rpartition(".")[2], 0.01 * mass) for name in base.columns[:count]]
    found = _least(base, prior, scale, parameters, {})
    fixed: dict[int, float] = {}
    while wanted := _masses_wanted(found[:count], len(model.per_link)):
        fixed |= wanted
        other = _least(base, prior, scale, parameters, fixed)
        if np.abs(base.K @ (other - parameters)).max() > 1e-9 * np.abs(base.K @ parameters).max():
            break  # torques show that the mass is negative
        found = other
    return found


def _masses_wanted(found: FloatArray, per_link: int) -> dict[int, float]:
    """Places of the masses that are none although the link has a first moment, and the mass that it is given."""
    none = [place for place in range(0, len(found), per_link) if found[place] <= NO_MASS]
    moments = {place: float(np.linalg.norm(found[place + 1 : place + 4])) for place in none}
    return {place: moment / UNKNOWN_AT for place, moment in moments.items() if moment > NO_MASS}


def _least(
    base: BaseParameters, prior: FloatArray, scale: FloatArray, parameters: FloatArray, fixed: dict[int, float]
) -> FloatArray:
    """The parameters nearest to the prior with these base parameters, and with ``fixed`` values at some places."""
    start, free = prior.copy(), scale.copy()
    start[list(fixed)], free[list(fixed)] = list(fixed.values()), 0.0
    return np.asarray(start + free * (np.linalg.pinv(base.K * free) @ (base.K @ (parameters - start))))


def identified_spec(
    robot: Robot, model: Model, parameters: FloatArray, provenance: str, *, tilted: bool = False
) -> RobotSpec:
    """The robot with these masses, centres of mass and, in a model of the dynamics, inertias.

    From logs of a ``tilted`` base it is no longer one for a level base only.

    A gravity model leaves inertias about the centre of mass as they were. What rides on a moving link is part of it.
    Raises CalibrationError for parameters that no body has.
    """
    spec = robot._as_it_is()  # noqa: SLF001 - the robot with its base and tool of now, or its own refusal
    given = robot.inertial_parameters().reshape(-1, 10)
    bodies = {}
    rows = parameters[: len(model.link_columns(spec))].reshape(-1, len(model.per_link))
    for place, row in zip(model.bodies(spec), rows, strict=True):
        link = spec.moving_links[place]
        bodies[link.name] = _with_body(link, _whole(row, given[place]), provenance)
    links = tuple(bodies.get(link.name) or _rider(link) for link in spec.links)
    source = "\n".join(filter(None, (provenance, f"before: {spec.source}" if spec.source else "")))
    own = len(own_columns(spec))
    disturbances = filled(spec, parameters[-own:], provenance) if own and model.disturbances else spec.disturbances
    return replace(
        spec,
        links=links,
        source=source,
        disturbances=disturbances,
        mass_set="default",
        mass_sets=("default",),
        level_only=spec.level_only and not tilted,
    )


def _whole(row: FloatArray, before: FloatArray) -> FloatArray:
    """m, h and I about the frame's origin of a link; from a gravity model with the inertia about the COM of before."""
    if row.size == len(before):
        return row
    about_com = _inertia(before) - _point(before) if before[0] > NO_MASS else np.zeros((3, 3))
    moved = about_com + _point(row) if row[0] > NO_MASS else about_com
    return np.concatenate([row, moved[np.triu_indices(3)]])


def _with_body(link: LinkSpec, body: FloatArray, provenance: str) -> LinkSpec:
    mass = float(body[0])
    if abs(mass) <= NO_MASS and np.abs(body[1:4]).max() <= NO_MASS:
        return replace(link, mass=0.0, com=(0.0, 0.0, 0.0), inertia=(0.0,) * 6, massless=True, source=provenance)
    if mass <= 0.0 or float(np.linalg.eigvalsh(pseudo_inertia(body))[0]) < -1e-9 * max(mass, 1.0):
        why = f"a mass of {mass:.4g} kg" if mass <= 0.0 else "an inertia that no mass distribution has"
        remedy = "identify with estimator='consistent', or record a motion that shows more of it"
        raise CalibrationError(f"link '{link.name}' would have {why}; {remedy}")
    about_com = _inertia(body) - _point(body)
    about_com[np.abs(about_com) <= 1e-12 * np.abs(_inertia(body)).max()] = 0.0  # a point mass has no such rounding
    xx, xy, xz, yy, yz, zz = (float(value) for value in about_com[np.triu_indices(3)])
    x, y, z = (float(value) for value in body[1:4] / mass)
    return replace(link, mass=mass, com=(x, y, z), inertia=(xx, xy, xz, yy, yz, zz), massless=False, source=provenance)


def _rider(link: LinkSpec) -> LinkSpec:
    """A fixed link: its mass is in that of its carrier. Moving links that were not sought stay as they are."""
    if link.joint != "fixed" or link.massless:
        return link
    said = f"{link.source}; mass: in that of its carrier".removeprefix("; ")
    return replace(link, mass=0.0, com=(0.0, 0.0, 0.0), inertia=(0.0,) * 6, massless=True, source=said)


def _inertia(body: FloatArray) -> FloatArray:
    xx, xy, xz, yy, yz, zz = body[4:10]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _point(body: FloatArray) -> FloatArray:
    """Inertia about the frame's origin of the whole mass in its centre: (h² 1 - h hᵀ)/m."""
    h = body[1:4]
    return np.asarray((h @ h * np.eye(3) - np.outer(h, h)) / body[0])
