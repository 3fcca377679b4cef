"""Robots from files and back: TOML, URDF, Denavit-Hartenberg tables and the robots that come with the package.

Everything becomes a :class:`~ravengc.spec.RobotSpec` in SI, validated by the same rules. Nothing here opens a file that
another file names, and nothing runs a command.
"""

from __future__ import annotations

from ravengc.config.bundled import bundled_names, bundled_path, spec_for
from ravengc.config.dh import spec_from_dh
from ravengc.config.toml_reader import spec_from_toml
from ravengc.config.toml_writer import spec_to_toml, write_toml
from ravengc.config.urdf import spec_from_urdf
from ravengc.config.validate import MAX_BODIES, validate

__all__ = [
    "MAX_BODIES",
    "bundled_names",
    "bundled_path",
    "spec_for",
    "spec_from_dh",
    "spec_from_toml",
    "spec_from_urdf",
    "spec_to_toml",
    "validate",
    "write_toml",
]
