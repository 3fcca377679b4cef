"""The da Vinci Research Kit: its published tables and files, checked, translated and put to use.

What the arms' own control software and its wiki say, against the core: the table of conventions
(:func:`agreement_table`), the MTM's two tables (:func:`compare_tables`, :func:`modified_mtm`) and special terms
(:func:`special_terms`), kinematic files (:func:`read_kinematic`), the published gravity compensation
(:class:`Published`), robots from them (:func:`convert`), an arm held (:func:`hold`) and let go (:func:`passive`) in
simulation.
"""

from __future__ import annotations

from ravengc.dvrk.calibration import Calibrated, calibrate, simulated_mtm
from ravengc.dvrk.conversion import Conversion, convert
from ravengc.dvrk.holding import Hold, Holding, hold
from ravengc.dvrk.kinematic import mounted, read_kinematic, write_kinematic
from ravengc.dvrk.letting_go import Drift, PassiveRuns, friction_shares, let_go, passive
from ravengc.dvrk.mtm_tables import SameArm, compare_tables, modified_mtm
from ravengc.dvrk.published import Published, TiltReport, published_regressor, read_published, write_published
from ravengc.dvrk.published_robot import published_from_robot, robot_spec_from_published
from ravengc.dvrk.special_terms import SpecialTerm, mtm_with_special_terms, special_terms
from ravengc.dvrk.table import Cell, Column, Mistake, Table, agreement_table, mistakes

__all__ = [
    "Calibrated",
    "Cell",
    "Column",
    "Conversion",
    "Drift",
    "Hold",
    "Holding",
    "Mistake",
    "PassiveRuns",
    "Published",
    "SameArm",
    "SpecialTerm",
    "Table",
    "TiltReport",
    "agreement_table",
    "calibrate",
    "compare_tables",
    "convert",
    "friction_shares",
    "hold",
    "let_go",
    "mistakes",
    "modified_mtm",
    "mounted",
    "mtm_with_special_terms",
    "passive",
    "published_from_robot",
    "published_regressor",
    "read_kinematic",
    "read_published",
    "robot_spec_from_published",
    "simulated_mtm",
    "special_terms",
    "write_kinematic",
    "write_published",
]
