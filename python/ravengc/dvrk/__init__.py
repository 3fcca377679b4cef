"""The da Vinci Research Kit: its published tables and files, checked, translated and put to use.

What the arms' own control software and its wiki say, against the core: the table of conventions
(:func:`agreement_table`), the MTM's two tables (:func:`compare_tables`, :func:`modified_mtm`), kinematic files
(:func:`read_kinematic`), the published gravity compensation (:class:`Published`), and robots from them
(:func:`convert`).
"""

from __future__ import annotations

from ravengc.dvrk.convert import Conversion, convert
from ravengc.dvrk.holding import Hold, Holding, hold
from ravengc.dvrk.kinematic import mounted, read_kinematic, write_kinematic
from ravengc.dvrk.mtm_tables import SameArm, compare_tables, modified_mtm
from ravengc.dvrk.published import Published, TiltReport, published_regressor, read_published, write_published
from ravengc.dvrk.published_robot import published_from_robot, robot_spec_from_published
from ravengc.dvrk.table import Cell, Column, Mistake, Table, agreement_table, mistakes

__all__ = [
    "Cell",
    "Column",
    "Conversion",
    "Hold",
    "Holding",
    "Mistake",
    "Published",
    "SameArm",
    "Table",
    "TiltReport",
    "agreement_table",
    "compare_tables",
    "convert",
    "hold",
    "mistakes",
    "modified_mtm",
    "mounted",
    "published_from_robot",
    "published_regressor",
    "read_kinematic",
    "read_published",
    "robot_spec_from_published",
    "write_kinematic",
    "write_published",
]
