"""The MTM in the two Denavit-Hartenberg tables of the dVRK's page, and what makes them one arm.

A link's frame of either table is fixed to the link, so a constant displacement leads from one to the other,

    D_i = M_i(0)⁻¹ S_i(0)        M_i, S_i: frame 0 <- frame i of the modified and of the standard table

and masses given in one table are had in the other: com' = D_i com, I' = D_i I D_iᵀ. The tables describe one arm if
D_i is the same in every pose; then their axes are the same lines.

Source: jhu-dvrk/sawIntuitiveResearchKit wiki, page 'Control Gravity Compensation', appendix I.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ravengc._convert import as_count, check_type
from ravengc.errors import ConfigError
from ravengc.reference import joint_axes, link_frames
from ravengc.robot import Robot, load
from ravengc.spec import DhRow, Pose

if TYPE_CHECKING:
    from ravengc.spec import LinkSpec, RobotSpec

__all__ = ["SameArm", "compare_tables", "modified_mtm"]

Array = npt.NDArray[np.float64]
HALF = pi / 2.0
L_ARM, L_FOREARM, H = 0.2794, 0.3645, 0.1506
MODIFIED = (
    DhRow(theta=HALF),
    DhRow(alpha=-HALF, theta=-HALF),
    DhRow(a=-L_ARM, theta=HALF),
    DhRow(alpha=HALF, a=-L_FOREARM, d=H),
    DhRow(alpha=-HALF),
    DhRow(alpha=HALF, theta=HALF),
    DhRow(alpha=HALF, theta=HALF),
)
"""Table 2 of the appendix (rad, m)."""
ROUGH = 1e-9
ROUNDING = 1e-12


@dataclass(frozen=True, slots=True)
class SameArm:
    """How far the standard and the modified table are from one arm, at most over ``poses`` poses.

    ``direction`` is the largest difference of an axis's unit vector, ``distance`` (m) that between its two lines,
    ``wrist`` (m) that of the point in which the wrist's axes meet, ``torque`` (N·m) that of the gravity torques on
    tilted bases, ``tip`` that of the pose of the last frame, which is the same one in both tables.
    """

    robot: str
    poses: int
    direction: float
    distance: float
    wrist: float
    torque: float
    tip: float

    @property
    def agrees(self) -> bool:
        """Whether all is equal up to rounding."""
        return max(self.direction, self.distance, self.wrist, self.torque, self.tip) < ROUNDING


def modified_mtm(robot: Robot) -> Robot:
    """The same MTM, masses, limits and tool included, in the page's modified table.

    Raises ConfigError for a robot whose axes are not those of the table.
    """
    check_type(robot, Robot, "robot")
    standard = robot.spec
    if standard.convention != "standard" or len(standard.links) != len(MODIFIED):
        raise ConfigError(f"{robot.name} is no MTM in standard DH; expected dvrk_mtml or dvrk_mtmr")
    rows = [replace(link, placement=row) for link, row in zip(standard.links, MODIFIED, strict=True)]
    modified = replace(standard, name=f"{standard.name}_modified", convention="modified", links=tuple(rows))
    shifts = _shifts(standard, modified, np.zeros(len(rows)))
    there = np.linspace(0.3, 0.9, len(rows))
    if np.abs(shifts - _shifts(standard, modified, there)).max() > ROUGH:
        raise ConfigError(f"{robot.name} has other axes than the page's modified table of the MTM")
    links = tuple(_moved(link, shift) for link, shift in zip(rows, shifts, strict=True))
    return Robot(replace(modified, links=links, tool=_pose(shifts[-1] @ _matrix(standard.tool))))


def compare_tables(name: str = "dvrk_mtmr", poses: int = 50, seed: int = 0) -> SameArm:
    """Compare the two tables of a bundled MTM in random poses and random gravity fields."""
    standard = load(name)
    modified = modified_mtm(standard)
    rng = np.random.default_rng(as_count(seed, "seed", 0))
    largest = np.zeros(5)
    for q in rng.uniform(-pi, pi, (as_count(poses, "poses", 1, 100_000), standard.n)):
        largest = np.maximum(largest, _differences(standard, modified, q, rng.normal(0.0, 6.0, 3)))
    return SameArm(name, poses, *largest.tolist())


def _differences(standard: Robot, modified: Robot, q: Array, g: Array) -> Array:
    """Of axes' directions and lines, the wrist's point, torques and the last frame, (5,)."""
    axes, others = (joint_axes(robot.spec, q) for robot in (standard, modified))
    turned = max(np.abs(z - other).max() for (z, _), (other, _) in zip(axes, others, strict=True))
    apart = max(np.linalg.norm(np.cross(z, other - o)) for (z, o), (_, other) in zip(axes, others, strict=True))
    wrist, last = (
        np.abs(standard.forward_kinematics(q, name) - modified.forward_kinematics(q, name))
        for name in ("wrist_pitch", standard.spec.links[-1].name)
    )
    torque = np.abs(standard.gravity_torque(q, g) - modified.gravity_torque(q, g)).max()
    return np.array((turned, apart, wrist[:3, 3].max(), torque, last.max()))


def _shifts(standard: RobotSpec, modified: RobotSpec, q: Array) -> Array:
    """D_i of every link, (links, 4, 4), in a pose."""
    one, other = link_frames(standard, q), link_frames(modified, q)
    return np.array([np.linalg.inv(other[link.name]) @ one[link.name] for link in standard.links])


def _moved(link: LinkSpec, shift: Array) -> LinkSpec:
    turn, (xx, xy, xz, yy, yz, zz) = shift[:3, :3], link.inertia
    moments = turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T
    com = turn @ np.array(link.com) + shift[:3, 3] if link.mass else np.zeros(3)
    a, b, c, d, e, f = moments[np.triu_indices(3)].tolist()
    x, y, z = com.tolist()
    return replace(link, com=(x, y, z), inertia=(a, b, c, d, e, f))


def _matrix(pose: Pose) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.translation
    return matrix


def _pose(matrix: Array) -> Pose:
    return Pose(matrix[:3, :3].tolist(), matrix[:3, 3].tolist())
