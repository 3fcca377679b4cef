"""The table of the dVRK's page: RRBot's kinematics and gravity in standard and modified DH, asked of every library.

The page found "NO" for gravity in modified DH. The arm is the same in both tables, and so are its torques, if

    a modified row is put before its joint, Rx(alpha) Tx(a) Rz(theta) Tz(d), and a standard one behind it,
    and the centre of mass is given in the frame that the row makes: distal (standard) or proximal (modified).

:func:`mistakes` computes what comes out otherwise.

Source: jhu-dvrk/sawIntuitiveResearchKit wiki, page 'Control Gravity Compensation', tables for RRBot and appendix II.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ravengc import reference
from ravengc._convert import as_count, check_type
from ravengc.dvrk.mtm_tables import SameArm, compare_tables
from ravengc.dvrk.peers import Answers, Peer, ask_kdl, ask_toolbox
from ravengc.robot import Robot, load
from ravengc.spec import Pose

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

__all__ = ["ROWS", "Cell", "Column", "Mistake", "Table", "agreement_table", "mistakes"]

Array = npt.NDArray[np.float64]
Subject = Literal["Kinematics", "Gravity"]
ROWS: tuple[tuple[Subject, str], ...] = (
    ("Kinematics", "standard"),
    ("Kinematics", "modified"),
    ("Gravity", "standard"),
    ("Gravity", "modified"),
)
ROBOTS = {"standard": "rrbot", "modified": "rrbot_modified"}
PAGE = {
    ("Kinematics", "standard"): ("YES", "YES", "YES"),
    ("Kinematics", "modified"): ("YES", "YES", "YES"),
    ("Gravity", "standard"): ("YES", "YES", "YES"),
    ("Gravity", "modified"): ("NO", "NO (? Not sure)", "YES"),
}
"""What the page says of cisstRobot, KDL and Matlab's toolbox."""
FIELD = 9.81
"""The page's gravity, m/s²: (-9.81, 0, 0) in frame 0."""
WHERE = (0.3, 0.5)
"""The pose in which mistakes are shown (rad)."""
ROUNDING = 1e-13
"""Share of the largest number up to which answers are equal."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One answer: the largest difference (m, rad as a matrix's entry; N·m), and whether that is rounding."""

    agrees: bool
    difference: float


@dataclass(frozen=True, slots=True)
class Column:
    """A library's four cells in the order of :data:`ROWS`, or why it was not asked."""

    name: str
    version: str
    cells: tuple[Cell, ...]
    why_not: str = ""


@dataclass(frozen=True, slots=True)
class Mistake:
    """What comes out at :data:`WHERE` (N·m) when a modified table is used in this way."""

    what: str
    torque: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Table:
    """The table, the difference between RRBot's two conventions, the mistakes, and the MTM's two tables."""

    poses: int
    columns: tuple[Column, ...]
    conventions: Cell
    mistakes: tuple[Mistake, ...]
    mtm: tuple[SameArm, ...]

    @property
    def complete(self) -> bool:
        """Whether every cell that was asked for is YES."""
        cells = [cell for column in self.columns for cell in column.cells]
        return all(cell.agrees for cell in (*cells, self.conventions)) and all(arm.agrees for arm in self.mtm)


def agreement_table(poses: int = 100, *, pykdl: str | None = None, seed: int = 0) -> Table:
    """Ask every library for RRBot in ``poses`` random poses, level and on tilted and accelerated bases.

    ``pykdl`` names a Python interpreter that has PyKDL. Raises ConfigError if that one cannot answer.
    """
    if pykdl is not None:
        check_type(pykdl, str, "pykdl")
    q, g = _cases(as_count(poses, "poses", 1, 100_000), as_count(seed, "seed", 0))
    specs = {convention: replace(load(name).spec, base=Pose()) for convention, name in ROBOTS.items()}
    ours = {convention: _core(spec, q, g) for convention, spec in specs.items()}
    columns = (
        _column(ours, {convention: _reference(spec, q, g) for convention, spec in specs.items()}),
        _column(ours, {convention: ask_kdl(spec, q, g, python=pykdl) for convention, spec in specs.items()}),
        _column(ours, {convention: ask_toolbox(spec, q, g) for convention, spec in specs.items()}),
    )
    between = _cell(ours["standard"].torques, ours["modified"].torques)
    arms = tuple(compare_tables(name, min(poses, 50), seed) for name in ("dvrk_mtml", "dvrk_mtmr"))
    return Table(poses, columns, between, (*mistakes(), *_mistakes_of_kdl(specs["modified"], pykdl)), arms)


def _mistakes_of_kdl(modified: RobotSpec, pykdl: str | None) -> tuple[Mistake, ...]:
    """The same first mistake as it is made in KDL: its segment is a joint and then a frame, so the row comes behind."""
    q, g = np.array([WHERE]), np.array([(-FIELD, 0.0, 0.0)])
    answers = ask_kdl(modified, q, g, python=pykdl, convention="modified as standard").answers
    if answers is None:
        return ()
    first, second = answers.torques[0].tolist()
    return (Mistake("KDL, Segment(Joint.RotZ, Frame.DH_Craig1989(row))", (first, second)),)


def mistakes() -> tuple[Mistake, ...]:
    """The right torques of RRBot at :data:`WHERE`, and those of two ways to misread its modified table."""
    modified = replace(load("rrbot_modified").spec, base=Pose())
    mirrored = tuple(replace(link, com=(-link.com[0], -link.com[1], -link.com[2])) for link in modified.links)
    found = (
        ("modified rows, centres of mass in their own (proximal) frames: right", modified),
        ("modified rows taken for standard ones, each behind its joint", replace(modified, convention="standard")),
        ("modified rows, centres of mass left as in the standard table", replace(modified, links=mirrored)),
    )
    return tuple(Mistake(what, _torque_at(spec)) for what, spec in found)


def _torque_at(spec: RobotSpec) -> tuple[float, float]:
    first, second = Robot(spec).gravity_torque(np.array(WHERE), np.array((-FIELD, 0.0, 0.0))).tolist()
    return first, second


def _cases(count: int, seed: int) -> tuple[Array, Array]:
    """Poses (N, 2) and gravity in frame 0 (N, 3): every other one the page's field, the rest of tilted bases."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-np.pi, np.pi, (count, 2))
    q[0] = WHERE
    g = rng.normal(0.0, 6.0, (count, 3))
    g[::2] = (-FIELD, 0.0, 0.0)
    return q, g


def _core(spec: RobotSpec, q: Array, g: Array) -> Answers:
    robot, last = Robot(spec), spec.links[-1].name
    poses = np.array([robot.forward_kinematics(row, last)[:3] for row in q])
    return Answers(poses, robot.gravity_torque_batch(q, g))


def _reference(spec: RobotSpec, q: Array, g: Array) -> Peer:
    last = spec.links[-1].name
    poses = np.array([reference.forward_kinematics(spec, row, last)[:3] for row in q])
    energy = [reference.gravity_torque_from_energy(spec, row, field) for row, field in zip(q, g, strict=True)]
    return Peer("NumPy reference", np.__version__, Answers(poses, np.array(energy)))


def _column(ours: dict[str, Answers], theirs: dict[str, Peer]) -> Column:
    first = theirs["standard"]
    cells = []
    for subject, convention in ROWS:
        answers = theirs[convention].answers
        if answers is not None:
            mine = ours[convention]
            pair = (mine.poses, answers.poses) if subject == "Kinematics" else (mine.torques, answers.torques)
            cells.append(_cell(*pair))
    return Column(first.name, first.version, tuple(cells), first.why_not)


def _cell(ours: Array, theirs: Array) -> Cell:
    difference = float(np.abs(ours - theirs).max())
    return Cell(difference <= ROUNDING * max(1.0, float(np.abs(ours).max())), difference)
