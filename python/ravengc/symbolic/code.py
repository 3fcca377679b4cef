"""Formulas as a C or Python function that needs nothing else."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from ravengc.symbolic.infix import PYTHON, WIDTH, C, wrapped

if TYPE_CHECKING:
    from ravengc.symbolic.algebra import Expr
    from ravengc.symbolic.formulas import Formulas, Input

__all__ = ["function_name", "to_c", "to_python"]


def function_name(formulas: Formulas) -> str:
    """The name of the function: the robot's and the quantity's, with underscores for what no name can have."""
    robot = re.sub(r"[^0-9a-z_]+", "_", formulas.spec.name.lower()).strip("_") or "robot"
    return f"{'robot_' if robot[0].isdigit() else ''}{robot}_{formulas.what.replace('-', '_')}"


def to_c(formulas: Formulas, heading: list[str]) -> str:
    """A C99 function: inputs and parameters in, the result out; parameters of the robot file in an array beside it."""
    name, comment = function_name(formulas), "".join(f" * {line.replace('*/', '* /')}\n" for line in heading)
    shape = "".join(f"[{size}]" for size in formulas.shape)
    arguments = [_c_argument(one) for one in formulas.inputs]
    if formulas.parameters:
        arguments.append(f"const double parameters[{len(formulas.parameters)}]")
    arguments.append(f"double {formulas.name}{shape}")
    lines = [f"/*\n{comment} */", "#include <math.h>", "", *_c_parameters(formulas, name)]
    lines += [wrapped(f"void {name}({', '.join(arguments)})", "         "), "{", *_c_locals(formulas)]
    lines += [
        wrapped(f"    const double {symbol} = {C(value)};", "        ") for symbol, value in formulas.steps.items()
    ]
    for place, entry in formulas.places().items():
        where = "".join(f"[{index}]" for index in place)
        lines.append(wrapped(f"    {formulas.name}{where} = {C(entry)};", "        "))
    return "\n".join([*lines, "}", ""])


def _c_argument(one: Input) -> str:
    return f"double {one.name}" if _is_scalar(one) else f"const double {one.name}[{len(one.symbols)}]"


def _is_scalar(one: Input) -> bool:
    """The magnitude of gravity: an argument that is its own symbol."""
    return [symbol.name for symbol in one.symbols] == [one.name]


def _c_parameters(formulas: Formulas, name: str) -> list[str]:
    if not formulas.parameters:
        return []
    rows = [f"    {value!r}, /* {symbol} */" for symbol, value in formulas.parameters.items()]
    return [f"const double {name}_parameters[{len(rows)}] = {{", *rows, "};", ""]


def _c_locals(formulas: Formulas) -> list[str]:
    """Names for the entries that the formulas use; an argument that they do not use is said to be meant."""
    used, lines = formulas.used(), []
    for one in formulas.inputs:
        here = [(k, symbol) for k, symbol in enumerate(one.symbols) if symbol in used]
        if not here:
            lines.append(f"    (void){one.name};")
        elif not _is_scalar(one):
            lines += [f"    const double {symbol} = {one.name}[{k}];" for k, symbol in here]
    return lines + [f"    const double {symbol} = parameters[{k}];" for k, symbol in enumerate(formulas.parameters)]


def to_python(formulas: Formulas, heading: list[str]) -> str:
    """A Python function: sequences of floats in, a list (of rows) out; the robot's parameters are the default."""
    comment = [f"# {line}".rstrip() for line in heading]
    arguments = [one.name for one in formulas.inputs]
    lines = [*comment, "", "from math import cos, sin", ""]
    if formulas.parameters:
        rows = [f"    {value!r},  # {symbol}" for symbol, value in formulas.parameters.items()]
        lines += ["PARAMETERS = (", *rows, ")", ""]
        arguments.append("parameters=PARAMETERS")
    lines += ["", f"def {function_name(formulas)}({', '.join(arguments)}):"]
    lines += [f"    ({_unpacked(one.symbols)}) = {one.name}" for one in formulas.inputs if not _is_scalar(one)]
    if formulas.parameters:
        names = wrapped(f"        {_unpacked(tuple(formulas.parameters))}", "        ")
        lines += ["    (", names, "    ) = parameters"]
    lines += [_python_line(f"    {symbol} = ", PYTHON(value), "") for symbol, value in formulas.steps.items()]
    return "\n".join([*lines, *_python_result(formulas), ""])


def _unpacked(symbols: tuple[Expr, ...]) -> str:
    names = ", ".join(symbol.name for symbol in symbols)
    return f"{names}," if len(symbols) == 1 else names


def _python_line(start: str, expression: str, end: str) -> str:
    """An assignment on one line, or in brackets over several."""
    line = f"{start}{expression}{end}"
    return line if len(line) <= WIDTH else wrapped(f"{start}({expression}){end}", " " * (len(start) + 1))


def _python_result(formulas: Formulas) -> list[str]:
    rows: dict[int, list[str]] = {}
    for place, entry in formulas.places().items():
        rows.setdefault(place[0], []).append(PYTHON(entry))
    if len(formulas.shape) == 1:
        return ["    return [", *(_python_line("        ", row[0], ",") for row in rows.values()), "    ]"]
    lines = ["    return ["]
    for row in rows.values():
        lines += ["        [", *(_python_line("            ", entry, ",") for entry in row), "        ],"]
    return [*lines, "    ]"]
