"""One link from the keys that TOML files and DH lists share, and the replacement of its mass by a mass set."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, cast

from ravengc.config.fields import Table, read_limits, read_rotation, read_vector
from ravengc.config.physical import UNIT_TOLERANCE
from ravengc.config.validate import JOINTS
from ravengc.errors import ConfigError, ModelError
from ravengc.messages import shown
from ravengc.spec import Convention, DhRow, JointKind, JointOrigin, LinkSpec, Pose, Vector

if TYPE_CHECKING:
    from ravengc.config.locate import Place
    from ravengc.config.rotations import Inertia

__all__ = ["LINK_KEYS", "MASS_KEYS", "override_mass", "read_link", "unit_axis"]

DH_KEYS = ("alpha", "a", "d", "theta")
FRAME_KEYS = ("translation", "rotation", "rpy", "axis")
MASS_KEYS = ("mass", "com", "inertia", "massless", "source")
LIMIT_KEYS = ("lower", "upper", "velocity", "effort")
LINK_KEYS = ("name", "joint", "joint_name", "parent", *DH_KEYS, *FRAME_KEYS, *MASS_KEYS, "limits")


def read_link(table: Table, convention: Convention, previous: str | None, default_name: str | None = None) -> LinkSpec:
    """Return the link that ``table`` describes; without ``parent`` it rides on link ``previous`` (None: the base)."""
    joint = cast("JointKind", table.choice("joint", JOINTS, "revolute"))
    name = table.text("name", default_name)
    parent = table.text("parent") if "parent" in table else previous
    return LinkSpec(
        name=name,
        placement=_read_placement(table, convention),
        joint=joint,
        joint_name=table.text("joint_name"),
        parent=None if parent == "base" else parent,
        mass=table.number("mass", "mass"),
        com=read_vector(table, "com"),
        inertia=_read_inertia(table),
        massless=table.flag("massless"),
        limits=read_limits(table.table("limits", LIMIT_KEYS), joint),
        source=table.text("source"),
    )


def override_mass(link: LinkSpec, table: Table) -> LinkSpec:
    """Return the link with the mass, COM, inertia and source of a mass set; what the set does not give stays."""
    return replace(
        link,
        mass=table.number("mass", "mass", link.mass),
        com=read_vector(table, "com", link.com),
        inertia=_read_inertia(table, link.inertia),
        massless=table.flag("massless", default=link.massless and "mass" not in table),
        source=table.text("source", link.source),
    )


def unit_axis(axis: Vector, place: Place) -> Vector:
    """Return the axis at length 1, unchanged where it is that long already; ModelError for an axis of no length."""
    if abs(math.hypot(*axis) - 1.0) <= UNIT_TOLERANCE:
        return axis
    largest = max(map(abs, axis))
    if largest == 0.0:
        raise ModelError(f"{place}: {shown(axis)} has no direction, expected a vector that is not zero")
    x, y, z = (component / largest for component in axis)
    length = math.hypot(x, y, z)
    return (x / length, y / length, z / length)


def _read_placement(table: Table, convention: Convention) -> DhRow | JointOrigin:
    """A DH row in a DH robot, an explicit frame otherwise; a DH robot may have explicit frames too, link by link."""
    framed = [key for key in FRAME_KEYS if key in table]
    rowed = [key for key in DH_KEYS if key in table]
    if rowed and (framed or convention == "frames"):
        beside = f"beside {framed[0]!r}" if framed else "in a robot of convention 'frames'"
        either = "a link has alpha, a, d, theta, or it has translation, rotation (or rpy), axis"
        raise ConfigError(f"{table.place.at(rowed[0])}: a Denavit-Hartenberg key {beside}; {either}")
    if framed or convention == "frames":
        return JointOrigin(pose=Pose(read_rotation(table), read_vector(table, "translation")), axis=_read_axis(table))
    return DhRow(
        alpha=table.number("alpha", "angle"),
        a=table.number("a", "length"),
        d=table.number("d", "length"),
        theta=table.number("theta", "angle"),
    )


def _read_axis(table: Table) -> Vector:
    if "axis" not in table:
        return (0.0, 0.0, 1.0)
    x, y, z = table.vector("axis", ("number",) * 3)
    return unit_axis((x, y, z), table.place.at("axis"))


def _read_inertia(table: Table, default: Inertia = (0.0,) * 6) -> Inertia:
    if "inertia" not in table:
        return default
    xx, xy, xz, yy, yz, zz = table.vector("inertia", ("inertia",) * 6)
    return (xx, xy, xz, yy, yz, zz)
