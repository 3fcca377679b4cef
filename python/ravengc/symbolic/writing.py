"""Formulas as a document: text, LaTeX, C or Python, with what the symbols mean at its head."""

from __future__ import annotations

import textwrap
from typing import Literal, get_args

from ravengc._convert import check_choice, check_type
from ravengc.errors import ArgumentError
from ravengc.symbolic.checking import Check
from ravengc.symbolic.code import to_c, to_python
from ravengc.symbolic.formulas import Formulas, Quantity
from ravengc.symbolic.infix import GLUE, TEXT, WIDTH, wrapped
from ravengc.symbolic.latex import to_latex

__all__ = ["FORMATS", "Format", "as_data", "meanings", "written"]

Format = Literal["text", "latex", "c", "python"]
FORMATS: tuple[Format, ...] = get_args(Format)

TITLES: dict[Quantity, str] = {
    "gravity": "torques tau (N m, N) that hold it against gravity",
    "kinematics": "pose T (4x4) of frame {frame} in the base frame",
    "jacobian": "Jacobian J of frame {frame} in base axes, linear rows first",
    "regressor": "gravity regressor Y, tau = Y pi",
    "inverse-dynamics": "torques tau (N m, N) of a motion",
    "inverse-dynamics-regressor": "regressor Y of the inverse dynamics, tau = Y pi",
}
KINDS = {
    "m": "mass, kg",
    "c": "centre of mass in the link's frame, m",
    "I": "inertia about the centre of mass in link axes, kg m^2",
    "a": "length a of the row, m",
    "d": "length d of the row, m",
}


def written(formulas: Formulas, format: Format = "text", check: Check | None = None) -> str:  # noqa: A002 -- as the option
    """The formulas in a format of :data:`FORMATS`, with the result of a check at its head if one is given."""
    check_type(formulas, Formulas, "formulas")
    check_choice(format, FORMATS, "format", ArgumentError)
    if check is not None:
        check_type(check, Check, "check")
    heading = [*_heading(formulas), *([] if check is None else [f"checked: {check}"])]
    writers = {"text": _to_text, "latex": to_latex, "c": to_c, "python": to_python}
    return writers[format](formulas, heading)


def meanings(formulas: Formulas) -> dict[str, str]:
    """What every symbol of the inputs is, with its unit."""
    found: dict[str, str] = {}
    for one in formulas.inputs:
        texts = one.meaning * len(one.symbols) if len(one.meaning) == 1 else one.meaning
        found |= {symbol.name: _one_line(text) for symbol, text in zip(one.symbols, texts, strict=False)}
    return found


def _one_line(text: str) -> str:
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())


def _heading(formulas: Formulas) -> list[str]:
    """Title and legend."""
    title = TITLES[formulas.what].format(frame=formulas.frame)
    lines = [_one_line(f"{formulas.spec.name}: {title}")]
    for one in formulas.inputs:
        if len(one.meaning) == 1:
            lines.append(f"{', '.join(symbol.name for symbol in one.symbols)}: {one.meaning[0]}")
        elif one.name == "q":
            lines += [_one_line(f"{symbol}: {text}") for symbol, text in zip(one.symbols, one.meaning, strict=True)]
        else:
            lines.append(f"{one.symbols[0]} ...: {'rates' if one.name == 'qd' else 'accelerations'} of q1 ...")
    if formulas.spec.disturbances and formulas.name == "tau":
        names = ", ".join(element.name for element in formulas.spec.disturbances)
        lines += _folded(_one_line(f"not in tau, to be added: the elements beside the masses ({names})"))
    if formulas.right_angles:
        lines.append(f"angles of rows within {formulas.right_angles:g} rad of right angles are right angles here")
    if formulas.columns:
        about = "; I about the origin of the link's frame" if formulas.what.startswith("inverse") else ""
        lines += _folded(f"pi = {' '.join(formulas.columns)} (h = m c, in the link's frame{about})")
    return [*lines, *_parameters(formulas)]


def _parameters(formulas: Formulas) -> list[str]:
    lines = []
    for kind, meaning in KINDS.items():
        values = [f"{symbol} = {value!r}" for symbol, value in formulas.parameters.items() if symbol.name[0] == kind]
        if values:
            lines += _folded(f"{meaning}: {', '.join(value.replace(' ', GLUE) for value in values)}")
    return lines


def _folded(text: str) -> list[str]:
    """A comment in lines; GLUE stands for a space at which it is not folded."""
    return [line.replace(GLUE, " ") for line in textwrap.wrap(text, WIDTH - 5, break_long_words=False)]


def _to_text(formulas: Formulas, heading: list[str]) -> str:
    lines = [f"# {line}".rstrip() for line in heading] + [""]
    rows = [(symbol.name, TEXT(value)) for symbol, value in formulas.steps.items()]
    rows += [(_entry(formulas, place), TEXT(e)) for place, e in formulas.places().items() if _is_listed(formulas, e)]
    lines += [wrapped(f"{name} = {text}", "    ") for name, text in rows]
    if not all(_is_listed(formulas, entry) for entry in formulas.entries):
        lines.append(f"# all other entries of {formulas.name} ({'x'.join(map(str, formulas.shape))}) are 0")
    return "\n".join([*lines, ""])


def _is_listed(formulas: Formulas, entry: object) -> bool:
    return len(formulas.shape) == 1 or entry != 0


def _entry(formulas: Formulas, place: tuple[int, ...]) -> str:
    index = ",".join(str(k + 1) for k in place)
    return f"{formulas.name}[{index}]" if len(place) > 1 else f"{formulas.name}{index}"


def as_data(formulas: Formulas) -> dict[str, object]:
    """The formulas as plain data: every expression as text."""
    check_type(formulas, Formulas, "formulas")
    return {
        "robot": formulas.spec.name,
        "what": formulas.what,
        "frame": formulas.frame,
        "inputs": {one.name: [symbol.name for symbol in one.symbols] for one in formulas.inputs},
        "meanings": meanings(formulas),
        "parameters": {symbol.name: value for symbol, value in formulas.parameters.items()},
        "columns": list(formulas.columns),
        "steps": {symbol.name: TEXT(value) for symbol, value in formulas.steps.items()},
        "result": formulas.name,
        "shape": list(formulas.shape),
        "entries": {_entry(formulas, place): TEXT(entry) for place, entry in formulas.places().items()},
    }
