"""The libraries that can be imported here, each with its calls."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from comparison.arm import Arm
    from comparison.call import Call

LIBRARIES = {
    "ravengc": "ours",
    "pinocchio": "pinocchio",
    "dynibo": "dynibo",
    "mujoco": "mujoco",
    "PyKDL": "kdl",
    "roboticstoolbox": "toolbox",
    "numpy": "plain_numpy",
}
"""Module to import, and the module here that calls it."""

HINTS = {"PyKDL": "Debian's python3-pykdl serves the system's Python only"}


def all_calls(arm: Arm) -> tuple[list[Call], list[str]]:
    """Calls of every library that takes part, and a note for each that cannot."""
    calls: list[Call] = []
    notes = []
    for library, adapter in LIBRARIES.items():
        if note := left_out(library):
            notes.append(note)
        else:
            calls += import_module(f"comparison.libraries.{adapter}").calls(arm)
    return calls, notes


def left_out(library: str) -> str | None:
    """Why a library cannot take part; ``None`` where it can."""
    if find_spec(library) is None:
        hint = f" ({HINTS[library]})" if library in HINTS else ""
        return f"{library} is not installed: left out{hint}"
    try:
        import_module(library)
    except Exception as error:  # noqa: BLE001 - other people's code may fail in any way
        return f"{library} is installed, but does not import: {error or type(error).__name__}"
    return None
