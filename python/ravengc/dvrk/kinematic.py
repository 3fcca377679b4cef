"""Kinematic files of the dVRK's control software, as robots and back: DH rows, limits, coupling, masses.

``DH`` holds the convention and the joints (``links`` in older files): alpha, A, theta, D, the offset that the joint's
zero adds, type, qmin, qmax, ftmax; with masses also mass, cx cy cz, and principal moments of inertia Ixx Iyy Izz about
the axes (x1 x2 x3), (y1 y2 y3), (z1 z2 z3). The software takes an alpha of 1.5708 for a right angle; this
reader takes theta and offset so too, where the software keeps the 3.7e-6 rad.

Files of a "physical" chain give the bars of the Si arms' parallelogram as joints in a row, moved by three coordinates:
yaw, pitch and insertion, as +1, 0, +1, -1, +1 and the insertion shared by the prismatic joints.

Source: jhu-dvrk/sawIntuitiveResearchKit@9e535e68 share/kinematic, components/code/mtsIntuitiveResearchKitPSM.cpp:69-82;
jhu-dvrk/cisst robDH.cpp, robModifiedDH.cpp, robMass.cpp.
"""

from __future__ import annotations

import json
from dataclasses import replace
from math import cos, pi, sin
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc._convert import as_number, as_path, check_type
from ravengc.config.files import write_atomically
from ravengc.config.validate import validate
from ravengc.dvrk.json_file import number, optional_number, read_json, square, table_of
from ravengc.dvrk.peers import dh_row
from ravengc.errors import ConfigError
from ravengc.messages import listed
from ravengc.spec import CouplingSpec, DhRow, JointLimits, LinkSpec, Pose, RobotSpec, TransmissionSpec

if TYPE_CHECKING:
    import os

    from ravengc.config.fields import Table

__all__ = ["mounted", "read_kinematic", "spec_from_kinematic", "write_kinematic"]

RIGHT_ANGLE = 1.5708
TYPES = ("revolute", "prismatic")
AXES = (("x1", "x2", "x3"), ("y1", "y2", "y3"), ("z1", "z2", "z3"))
PHYSICAL = {
    ("yaw", "intermediate yaw", "pitch1", "pitch2", "pitch3", "insertion1", "insertion2"): 0.5,
    ("yaw", "intermediate yaw", "pitch1", "pitch2", "pitch3", "insertion"): 1.0,
}
"""Names of the joints of the two physical chains, and each sliding joint's share of the insertion."""


def read_kinematic(path: str | os.PathLike[str]) -> RobotSpec:
    """The robot in a kinematic file, named after it; ParseError or ConfigError for anything that is not one."""
    file = as_path(path, "path")
    return spec_from_kinematic(read_json(file), file.name, file.stem)


def spec_from_kinematic(data: dict[str, Any], file: str, name: str) -> RobotSpec:
    """The robot in what was read from a kinematic file; ``file`` says in errors which."""
    top = table_of(data, file, "the file")
    if "DH" not in top:
        raise top.complaint("DH", "the table of joints of a kinematic file")
    dh = table_of(data["DH"], file, "DH")
    convention = dh.choice("convention", ("standard", "modified"))
    key = "links" if "links" in dh and "joints" not in dh else "joints"
    joints = data["DH"].get(key)
    if not isinstance(joints, list) or not joints:
        raise dh.complaint(key, "a list of joints")
    rows = [table_of(joint, file, f"joint {place}") for place, joint in enumerate(joints, 1)]
    links = _chained([_link(row, place) for place, row in enumerate(rows, 1)])
    spec = RobotSpec(
        name=name,
        convention="standard" if convention == "standard" else "modified",
        links=links,
        coupling=_physical(links, rows),
        transmission=_transmission(top, data, len(links)),
        base=_base(top),
        source=f"{file}: kinematic file of the dVRK's control software",
    )
    validate(spec, lambda _: f"{file}: ")
    return spec


def mounted(spec: RobotSpec, pitch: float) -> RobotSpec:
    """The robot mounted at a pitch (rad) about x of its frame 0: up is (0, sin pitch, cos pitch) there.

    Base axes B are those of the level room, so that gravity in them is (0, 0, -g). Raises ConfigError for a robot
    whose file turns its base already.
    """
    check_type(spec, RobotSpec, "spec")
    angle = as_number(pitch, "pitch")
    if not abs(angle) <= 2.0 * pi:
        raise ConfigError(f"a mounting pitch of {angle:g} rad is more than a turn; it is in rad, -0.785398 is -45 deg")
    if spec.base != Pose():
        raise ConfigError(f"{spec.name} has a base offset and a mounting pitch; expected one of them")
    c, s = cos(angle), sin(angle)
    return replace(spec, base=Pose(((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c))))


def _link(row: Table, place: int) -> LinkSpec:
    joint = row.choice("type", TYPES)
    offset, theta, d = (number(row, key) for key in ("offset", "theta", "D"))
    for key in ("alpha", "A"):
        if key not in row:
            raise row.complaint(key, "a number (rad, m)")
    theta, d = (_right(theta + offset), d) if joint == "revolute" else (_right(theta), d + offset)
    limits = JointLimits(
        lower=optional_number(row, "qmin"),
        upper=optional_number(row, "qmax"),
        effort=optional_number(row, "ftmax"),
    )
    mass, com = number(row, "mass"), [number(row, key) for key in ("cx", "cy", "cz")]
    name = row.text("name", f"joint{place}") or f"joint{place}"
    alpha, a = _right(number(row, "alpha")), number(row, "A")
    return LinkSpec(
        name=name.replace(" ", "_"),
        joint="revolute" if joint == "revolute" else "prismatic",
        placement=DhRow(alpha=alpha, a=a, d=d, theta=theta),
        mass=mass,
        com=(com[0], com[1], com[2]) if mass else (0.0, 0.0, 0.0),
        inertia=_inertia(row) if mass else (0.0,) * 6,
        massless=mass == 0.0,
        limits=limits,
    )


def _chained(links: list[LinkSpec]) -> tuple[LinkSpec, ...]:
    """The links, each hanging on the one before it."""
    parents = [None, *(link.name for link in links[:-1])]
    return tuple(replace(link, parent=parent) for link, parent in zip(links, parents, strict=True))


def _right(angle: float) -> float:
    """The angle, with the 1.5708 of the files as the right angle that it stands for."""
    return angle / RIGHT_ANGLE * (pi / 2.0) if abs(angle) == RIGHT_ANGLE else angle


def _inertia(row: Table) -> tuple[float, float, float, float, float, float]:
    """Sum of I_i e_i e_iᵀ over the principal axes, which are brought to length 1."""
    total = np.zeros((3, 3))
    for moment, names, unit in zip(("Ixx", "Iyy", "Izz"), AXES, np.eye(3), strict=True):
        axis = np.array([number(row, name, default) for name, default in zip(names, unit, strict=True)])
        length = float(np.linalg.norm(axis))
        if length == 0.0:
            raise row.complaint(names[0], f"a principal axis {listed(names)} that is not zero")
        total += number(row, moment) * np.outer(axis, axis) / length**2
    xx, xy, xz, yy, yz, zz = total[np.triu_indices(3)].tolist()
    return (xx, xy, xz, yy, yz, zz)


def _physical(links: tuple[LinkSpec, ...], rows: list[Table]) -> CouplingSpec | None:
    """The coupling of a physical chain; ``None`` where every joint is a coordinate."""
    names = tuple(row.text("name", "") for row in rows)
    passive = [row for row in rows if row.choice("mode", ("active", "passive"), "active") == "passive"]
    if names in PHYSICAL:
        share = PHYSICAL[names]
        columns: dict[str, tuple[float, float, float]] = {"yaw": (1.0, 0.0, 0.0), "pitch2": (0.0, -1.0, 0.0)}
        columns |= dict.fromkeys(("pitch1", "pitch3"), (0.0, 1.0, 0.0))
        columns |= {link.name: (0.0, 0.0, share) for link in links if link.joint == "prismatic"}
        matrix = tuple(columns.get(link.name, (0.0, 0.0, 0.0)) for link in links)
        return CouplingSpec(
            coordinates=("yaw", "pitch", "insertion"),
            matrix=matrix,
            offset=(0.0,) * len(links),
            source="jhu-dvrk/sawIntuitiveResearchKit@9e535e68 mtsIntuitiveResearchKitPSM.cpp:69-82, ...ECM.cpp:82-103",
        )
    if passive:
        known = " or ".join(f"{len(chain)} joints ({', '.join(chain)})" for chain in PHYSICAL)
        raise passive[0].complaint("mode", f"'active': what moves a passive joint is known of {known} alone")
    return None


def _transmission(top: Table, data: dict[str, Any], n: int) -> TransmissionSpec | None:
    if data.get("coupling") is None:
        return None
    place = table_of(data["coupling"], str(top.place).removesuffix(": the file"), "coupling")
    rows = square(place, "ActuatorToJointPosition", n)
    motors = tuple(f"actuator_{i}" for i in range(1, n + 1))
    return TransmissionSpec(motors=motors, joint_per_motor=rows, offset=(0.0,) * n)


def _base(top: Table) -> Pose:
    if "base-offset" not in top:
        return Pose()
    rows = square(top, "base-offset", 4)
    return Pose([row[:3] for row in rows[:3]], [row[3] for row in rows[:3]])  # type: ignore[arg-type]


def write_kinematic(spec: RobotSpec, path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Write a robot as a kinematic file, atomically; returns what the format has no place for, in words.

    Raises ConfigError for joints that the format cannot say.
    """
    check_type(spec, RobotSpec, "spec")
    text = json.dumps(kinematic_object(spec), indent=4, ensure_ascii=False) + "\n"
    write_atomically(as_path(path, "path"), text)
    return _left_out(spec)


def kinematic_object(spec: RobotSpec) -> dict[str, Any]:
    """The robot as a kinematic file has it."""
    parents = [None, *(link.name for link in spec.links[:-1])]
    for link, parent in zip(spec.links, parents, strict=True):
        if link.parent != parent or link.joint == "fixed":
            why = "is fixed" if link.joint == "fixed" else f"hangs on '{link.parent or 'base'}'"
            raise ConfigError(f"{spec.name}: link '{link.name}' {why}; a kinematic file is one chain of moving joints")
    data: dict[str, Any] = {"DH": {"convention": spec.convention, "joints": [_joint(link) for link in spec.links]}}
    if spec.base != Pose():
        rows = [[*row, shift] for row, shift in zip(spec.base.rotation, spec.base.translation, strict=True)]
        data["base-offset"] = [*rows, [0.0, 0.0, 0.0, 1.0]]
    if spec.transmission is not None:
        data["coupling"] = {"ActuatorToJointPosition": spec.transmission.joint_per_motor}
    return data


def _joint(link: LinkSpec) -> dict[str, Any]:
    row = dh_row(link)
    own = {"offset": row.theta, "theta": 0.0, "D": row.d} if link.joint == "revolute" else {}
    own = own or {"offset": row.d, "theta": row.theta, "D": 0.0}
    passive = link.name == "intermediate_yaw"
    joint: dict[str, Any] = {
        "name": link.name.replace("_", " ") if passive else link.name,
        "type": link.joint,
        "mode": "passive" if passive else "active",
        "alpha": row.alpha,
        "A": row.a,
        **own,
    }
    limits = {"qmin": link.limits.lower, "qmax": link.limits.upper, "ftmax": link.limits.effort}
    joint |= {key: value for key, value in limits.items() if value is not None}
    return joint | (_mass(link) if link.mass else {})


def _mass(link: LinkSpec) -> dict[str, float]:
    xx, xy, xz, yy, yz, zz = link.inertia
    body = {"mass": link.mass, **dict(zip(("cx", "cy", "cz"), link.com, strict=True))}
    moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    if not any((xy, xz, yz)):
        moments, axes = np.array((xx, yy, zz)), np.eye(3)
    body |= dict(zip(("Ixx", "Iyy", "Izz"), moments.tolist(), strict=True))
    for names, axis in zip(AXES, axes.T.tolist(), strict=True):
        body |= dict(zip(names, axis, strict=True))
    return body


def _left_out(spec: RobotSpec) -> tuple[str, ...]:
    """What a kinematic file does not say of this robot."""
    joints = tuple(link.name.replace("intermediate_yaw", "intermediate yaw") for link in spec.links)
    limits, transmission = spec.coordinate_limits, spec.transmission
    told = (
        (spec.coupling is not None and joints not in PHYSICAL, "the coupling of its coordinates"),
        (spec.coupling is not None and any(one != JointLimits() for one in limits), "the limits of its coordinates"),
        (transmission is not None and any(transmission.offset), "the offset of its transmission"),
        (any(link.limits.velocity is not None for link in spec.links), "the limits of its velocities"),
        (bool(spec.disturbances), "the elements beside its masses"),
        (spec.tool != Pose(), "its tool frame"),
        (spec.accelerometer is not None, "its accelerometer"),
    )
    return tuple(text for there, text in told if there)
