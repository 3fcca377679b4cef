"""The coupling of a mechanism's joints and the transmission of its motors, from the tables of a robot file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ravengc.config.fields import POSITION, Table, read_limits
from ravengc.config.links import LIMIT_KEYS
from ravengc.config.physical import inverse
from ravengc.config.validate import check_coupling_matrix
from ravengc.errors import ModelError
from ravengc.spec import CouplingSpec, JointKind, LinkSpec, RobotSpec, TransmissionSpec

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["COUPLING_KEYS", "TRANSMISSION_KEYS", "kinds_of_coordinates", "read_coupling", "read_transmission"]

COUPLING_KEYS = ("coordinates", "matrix", "offset", "limits", "source")
TRANSMISSION_KEYS = ("motors", "joint_per_motor", "motor_per_joint", "offset", "source")

Rows = tuple[tuple[float, ...], ...]


def read_coupling(table: Table, links: Sequence[LinkSpec]) -> CouplingSpec:
    """Return ``[coupling]``: q_mechanism = matrix @ q + offset, a row per moving link, a column per coordinate."""
    kinds: list[JointKind] = [link.joint for link in links if link.joint != "fixed"]
    coordinates, matrix = table.texts("coordinates"), table.matrix("matrix")
    check_coupling_matrix(matrix, len(kinds), len(coordinates), table.place)
    of_coordinates = _coordinate_kinds(matrix, kinds, len(coordinates))
    limits = table.tables("limits", LIMIT_KEYS, "limits of coordinate")
    if limits and len(limits) != len(coordinates):
        raise table.complaint("limits", f"{len(coordinates)} tables, one per coordinate ({{}} where there are none)")
    return CouplingSpec(
        coordinates=coordinates,
        matrix=matrix,
        offset=_read_offset(table, kinds),
        limits=tuple(map(read_limits, limits, of_coordinates)),
        source=table.text("source"),
    )


def read_transmission(table: Table, spec: RobotSpec) -> TransmissionSpec:
    """Return ``[transmission]``; ``motor_per_joint`` (m = M q) is inverted to ``joint_per_motor`` (q = M⁻¹ m)."""
    kinds = kinds_of_coordinates(spec)
    if ("joint_per_motor" in table) == ("motor_per_joint" in table):
        raise table.complaint("joint_per_motor", "exactly one of 'joint_per_motor' and 'motor_per_joint'")
    return TransmissionSpec(
        motors=table.texts("motors"),
        joint_per_motor=table.matrix("joint_per_motor") if "joint_per_motor" in table else _inverse(table, len(kinds)),
        offset=_read_offset(table, kinds),
        source=table.text("source"),
    )


def kinds_of_coordinates(spec: RobotSpec) -> list[JointKind]:
    """Return what each of the user's coordinates is: "revolute" or "prismatic"."""
    kinds: list[JointKind] = [link.joint for link in spec.moving_links]
    if spec.coupling is None:
        return kinds
    return _coordinate_kinds(spec.coupling.matrix, kinds, len(spec.coupling.coordinates))


def _read_offset(table: Table, kinds: Sequence[JointKind]) -> tuple[float, ...]:
    return table.vector("offset", [POSITION[kind] for kind in kinds]) if "offset" in table else (0.0,) * len(kinds)


def _coordinate_kinds(matrix: Rows, kinds: Sequence[JointKind], count: int) -> list[JointKind]:
    """A coordinate measures metres when it moves prismatic joints only, radians otherwise."""
    moved: list[set[JointKind]] = [set() for _ in range(count)]
    for kind, row in zip(kinds, matrix, strict=True):
        for entry, kinds_moved in zip(row, moved, strict=True):
            if entry != 0.0:
                kinds_moved.add(kind)
    return ["prismatic" if kinds_moved == {"prismatic"} else "revolute" for kinds_moved in moved]


def _inverse(table: Table, count: int) -> Rows:
    rows = table.matrix("motor_per_joint")
    if [len(row) for row in rows] != [count] * count:
        raise table.complaint(
            "motor_per_joint", f"{count} rows of {count} numbers: a row per motor, a column per coordinate"
        )
    inverted = inverse(rows)
    if inverted is None:
        place = table.place.at("motor_per_joint")
        raise ModelError(f"{place}: has no inverse: some motors move the joints alike, or not at all")
    return inverted
