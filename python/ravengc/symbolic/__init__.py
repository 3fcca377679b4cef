"""Formulas of a robot: gravity torques, kinematics, Jacobian, regressors, inverse dynamics, by SymPy (extra symbolic).

:func:`formulas` follows the links of any robot of the library in symbols, :func:`check` compares what it found with the
compiled core in random states, :func:`written` prints it as text, LaTeX, C or Python, and :func:`function` makes it a
function.

>>> import ravengc as rg
>>> from ravengc import symbolic
>>> found = symbolic.formulas(rg.load("rrbot").spec, gravity="level")
>>> print(symbolic.written(found).splitlines()[-1])
tau2 = -g*m2*(cx2 + 0.9)*sin(q1 + q2)
>>> symbolic.check(found).holds
True
"""

from __future__ import annotations

from ravengc.symbolic.checking import Check, check, function
from ravengc.symbolic.deriving import formulas
from ravengc.symbolic.formulas import FORMS, QUANTITIES, Form, Formulas, Input, Quantity
from ravengc.symbolic.writing import FORMATS, Format, as_data, written

__all__ = [
    "FORMATS",
    "FORMS",
    "QUANTITIES",
    "Check",
    "Form",
    "Format",
    "Formulas",
    "Input",
    "Quantity",
    "as_data",
    "check",
    "formulas",
    "function",
    "written",
]
