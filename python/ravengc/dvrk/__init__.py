"""The da Vinci Research Kit: its published tables and files, checked, translated and put to use.

What the arms' own control software and its wiki say, against the core: the table of conventions
(:func:`agreement_table`) and the MTM's two tables (:func:`compare_tables`, :func:`modified_mtm`).
"""

from __future__ import annotations

from ravengc.dvrk.mtm_tables import SameArm, compare_tables, modified_mtm
from ravengc.dvrk.table import Cell, Column, Mistake, Table, agreement_table, mistakes

__all__ = [
    "Cell",
    "Column",
    "Mistake",
    "SameArm",
    "Table",
    "agreement_table",
    "compare_tables",
    "mistakes",
    "modified_mtm",
]
