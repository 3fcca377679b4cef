"""The libraries that can be imported here, each with its calls."""

from __future__ import annotations

from importlib import import_module
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
    """Calls of every library that is installed, and a note for each that is not."""
    calls: list[Call] = []
    notes = []
    for library, adapter in LIBRARIES.items():
        try:
            import_module(library)
        except ImportError:
            notes.append(f"{library} is not installed: left out" + (f" ({HINTS[library]})" if library in HINTS else ""))
            continue
        calls += import_module(f"comparison.libraries.{adapter}").calls(arm)
    return calls, notes
