"""The dVRK's arms as the trees that their linkages are, driven by motor coordinates, and their recordings.

Links, couplings, springs and cable: WPI-AIM/dvrk_dynamics_identification@7697d3a6, main_mtm.ipynb and main_psm.ipynb
(Wang, Gondokaryono, Munawar, Fischer, A Convex Optimization-based Dynamic Model Identification Package for the da Vinci
Research Kit, IEEE RA-L 4(4), 2019). The recordings carry no licence and do not come along.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

import ravengc as rg
from ravengc.identify import (
    Bounds,
    Model,
    Recording,
    friction,
    geometric_spring,
    hysteresis,
    polynomial,
    rotor,
    smoothed,
)
from ravengc.spec import CouplingSpec, DhRow, LinkSpec, RobotSpec

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from ravengc.spec import JointKind

RATE = 200.0
COORDINATES = tuple(f"q{number}" for number in range(1, 8))
RIGHT = math.pi / 2.0
CABLE = (0.0004877, -0.0037149, 0.0067497, 0.008519, -0.0201475, -0.025265, 0.048095, 0.00255)
"""Of the MTM's joint 4, from the highest power: measured by a sweep of that joint alone."""
JOINT4 = (0.0, 0.6697, -0.6697, 1.0, 0.0, 0.0, 0.0)


def link(
    name: str, parent: str | None, a: float, alpha: float, d: float, theta: float, joint: JointKind = "revolute"
) -> LinkSpec:
    row = DhRow(a=a, alpha=alpha, d=d, theta=theta)
    return LinkSpec(name=name, placement=row, joint=joint, parent=parent, massless=True)


def mtm() -> rg.Robot:
    """The right MTM: upper arm and forearm are a parallelogram, driven from the shoulder."""
    links = (
        link("L1", None, 0.0, 0.0, -0.2154, 0.0),
        link("L2", "L1", 0.0, -RIGHT, 0.0, RIGHT),
        link("L30", "L2", 0.2794, 0.0, 0.0, RIGHT),
        link("L31", "L1", 0.0, -RIGHT, 0.0, math.pi),
        link("L32", "L31", 0.1, 0.0, 0.0, -RIGHT),
        link("L4", "L30", 0.3645, -RIGHT, 0.151, 0.0),
        link("L5", "L4", 0.0, RIGHT, 0.0, 0.0),
        link("L6", "L5", 0.0, -RIGHT, 0.0, RIGHT),
        link("L7", "L6", 0.0, -RIGHT, 0.0, math.pi),
    )
    one = np.eye(7)
    rows = [one[0], one[1], one[2] - one[1], one[2], one[1] - one[2], JOINT4, one[4], one[5], one[6]]
    return _coupled("dvrk_mtm_tree", links, np.array(rows))


def mtm_model() -> Model:
    """Friction of every frame and of motor 4, that motor's rotor, and the spring of joint 5."""
    frames = {part.name: row for part, row in zip(mtm().spec.links, _rows(mtm()), strict=True)}
    frames["M4"] = tuple(np.eye(7)[3])
    friction_of = tuple(friction(row, name=name) for name, row in frames.items())
    spring = geometric_spring("q5", radius=0.0075, distance=0.1035, rest=0.0613, angle=math.pi + math.radians(23.0))
    return Model(kind="dynamics", friction=(), elements=(*friction_of, rotor("q4", name="M4"), spring))


def mtm_bounds() -> Bounds:
    """The authors' boxes (cell 94), but for what the torques of a few motors cannot exceed."""
    boxes = {
        "L1": (2, 20, -0.1, 0.1, -0.1, 0.1, -0.1, 0.3),
        "L2": (1, 15, -0.1, 0.15, -0.05, 0.05, -0.05, 0.05),
        "L30": (0.5, 5, 0.0, 0.3, -0.03, 0.03, -0.03, 0.03),
        "L31": (1, 10, -0.1, 0.1, -0.05, 0.05, -0.1, 0.1),
        "L32": (0.05, 2, 0.05, 0.2, -0.02, 0.02, 0.02, 0.1),
        "L4": (0.05, 2, -0.03, 0.03, 0.0, 0.12, -0.15, 0.0),
        "L5": (0.05, 1, -0.02, 0.02, -0.1, 0.0, -0.1, 0.0),
        "L6": (0.05, 0.5, -0.02, 0.02, 0.0, 0.1, -0.1, 0.0),
        "L7": (0.02, 0.5, -0.01, 0.01, -0.01, 0.01, 0.0, 0.1),
    }
    return _boxes(boxes)


def _boxes(boxes: Mapping[str, tuple[float, ...]]) -> Bounds:
    return Bounds(
        mass={name: (box[0], box[1]) for name, box in boxes.items()}, com={name: box[2:] for name, box in boxes.items()}
    )


def rubbing(model: Model, sliding: tuple[str, ...] = ()) -> Model:
    """The same model with friction that gives before it slips: over 0.02 rad, or 1 mm along what slides."""
    frames = [part for part in model.elements if part.group == "friction"]
    more = tuple(hysteresis(part.joint, (0.001 if part.name in sliding else 0.02,), name=part.name) for part in frames)
    return replace(model, elements=(*model.elements, *more))


def psm() -> rg.Robot:
    """The PSM: a double parallelogram with a counterweight that runs with the instrument."""
    links = (
        link("L1", None, 0.0, RIGHT, 0.0, RIGHT),
        link("L20", "L1", 0.0, -RIGHT, 0.0, -RIGHT),
        link("L21", "L20", 0.04009, 0.0, 0.0, RIGHT, "fixed"),
        link("L22", "L21", 0.14454, 0.0, 0.0, RIGHT),
        link("L23", "L21", 0.18262, 0.0, 0.0, RIGHT),
        link("L24", "L22", 0.516, 0.0, 0.0, 0.0),
        link("L25", "L22", 0.096, 0.0, 0.0, math.pi),
        link("L30", "L24", 0.04009, -RIGHT, 0.14454 - 0.4318, 0.0, "prismatic"),
        link("L31", "L20", 0.04009, -RIGHT, 0.0, 0.0, "prismatic"),
        link("L4", "L30", 0.0, 0.0, 0.4162, 0.0),
        link("L5", "L4", 0.0, RIGHT, 0.0, RIGHT),
        link("L6", "L5", 0.0091, -RIGHT, 0.0, RIGHT),
        link("L7", "L5", 0.0091, -RIGHT, 0.0, RIGHT),
    )
    one = np.eye(7)
    wrist = [1.0186 * one[4], -0.8306 * one[4] + 1.2178 * one[5], -0.8306 * one[4] + 1.2178 * one[6]]
    rows = [one[0], one[1], -one[1], -one[1], one[1], one[1], one[2], one[2], one[3], *wrist]
    return _coupled("dvrk_psm_tree", links, np.array(rows))


def psm_model() -> Model:
    """Inertia of the linkage, friction of joints, wrist frames and motors, rotors of the wrist, the roll's spring."""
    one = np.eye(7)
    rows = dict(zip((part.name for part in psm().spec.moving_links), _rows(psm()), strict=True))
    frames = {name: rows[name] for name in ("L1", "L20", "L30", "L4", "L5", "L6", "L7")}
    frames |= {"M6": tuple(one[5]), "M7": tuple(one[6]), "F67": tuple(np.subtract(rows["L7"], rows["L6"]))}
    friction_of = tuple(friction(row, name=name) for name, row in frames.items())
    rotors = (rotor("q4", name="L4"), rotor(rows["L5"], name="L5"), rotor("q6", name="M6"), rotor("q7", name="M7"))
    spring = polynomial("q4", (1,), name="L4.spring")
    linkage = ("L1", "L20", "L22", "L23", "L24", "L25", "L30", "L31")
    return Model(kind="dynamics", friction=(), links=linkage, elements=(*friction_of, *rotors, spring))


def psm_bounds() -> Bounds:
    """The authors' boxes."""
    boxes = {
        "L1": (0.3, 10, -0.1, 0.1, -0.1, 0.1, -0.1, 0.1),
        "L20": (0.3, 10, -0.1, 0.1, -0.2, 0.1, -0.05, 0.05),
        "L22": (0.1, 5, 0.1, 0.4, -0.06, 0.02, -0.03, 0.03),
        "L23": (0.02, 2, 0.1, 0.4, -0.03, 0.03, -0.03, 0.03),
        "L24": (0.1, 5, 0.0, 0.05, -0.40, 0.05, -0.03, 0.03),
        "L25": (0.01, 0.5, -0.05, 0.0, -0.14, 0.0, 0.02, 0.08),
        "L30": (0.1, 2, -0.02, 0.02, -0.02, 0.02, -0.1, 0.15),
        "L31": (0.1, 2, -0.05, 0.05, -0.03, 0.03, -0.1, 0.1),
    }
    return _boxes(boxes)


def _rows(robot: rg.Robot) -> tuple[tuple[float, ...], ...]:
    """The coupling: a row per moving frame."""
    assert robot.spec.coupling is not None
    return robot.spec.coupling.matrix


def _coupled(name: str, links: tuple[LinkSpec, ...], matrix: np.ndarray) -> rg.Robot:
    rows = tuple(tuple(row) for row in matrix.tolist())
    coupling = CouplingSpec(coordinates=COORDINATES, matrix=rows, offset=(0.0,) * len(rows))
    return rg.Robot(RobotSpec(name=name, convention="modified", links=links, coupling=coupling))


def recorded(data: Path, key: str, cutoff_hz: float, *, repeated: bool = False) -> Recording:
    """A recording without its repeated rows (13 % of the MTM's), filtered both ways as its authors did."""
    table = np.load(data / "dvrk" / "dvrk_real.npz")[key].astype(float)
    q, qd, tau = table[:, :7], table[:, 7:14], table[:, 14:]
    fresh = np.concatenate([[True], (np.diff(table, axis=0) != 0.0).any(axis=1)])
    raw = Recording(stamps=np.arange(len(table)) / RATE, q=q, qd=qd, tau=tau, source=key)
    return smoothed(raw if repeated else raw.take(fresh), cutoff_hz)


def without_cable(recording: Recording) -> Recording:
    """The recording without what the cable of the MTM's joint 4 takes, seen at the motors."""
    torque = np.polyval(CABLE, recording.q @ np.array(JOINT4))
    return replace(recording, tau=recording.tau - np.outer(torque, JOINT4))
