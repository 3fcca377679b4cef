"""A robot by name, from those that come with the package, or by the path of its file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ravengc._convert import as_path
from ravengc.config.toml_reader import spec_from_toml
from ravengc.config.urdf import spec_from_urdf
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, listed, shown

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

__all__ = ["bundled_names", "bundled_path", "spec_for"]

_FOLDER = Path(__file__).parent.parent / "robots"


def bundled_names() -> tuple[str, ...]:
    """Return the names of the robots that come with the package, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def bundled_path(name: str) -> Path:
    """Return the TOML file of a bundled robot; ConfigError with the near names when there is none."""
    names = bundled_names()
    if not isinstance(name, str) or name not in names:
        near = did_you_mean(name, names) or _described_as(name)
        raise ConfigError(
            f"there is no robot {shown(name)}{near} (bundled: {listed(names)}; or a path ending in .toml or .urdf)"
        )
    return _FOLDER / f"{name}.toml"


def _described_as(word: object) -> str:
    """Return ``"; did you mean 'panda' (Franka Emika Panda)?"`` where one description begins with ``word`` in it."""
    if not isinstance(word, str):
        return ""
    specs = {name: spec_from_toml(_FOLDER / f"{name}.toml") for name in bundled_names()}
    called = {name: spec.description.partition(",")[0] for name, spec in specs.items()}
    found = [name for name, text in called.items() if word.lower() in text.lower().split()]
    return f"; did you mean {found[0]!r} ({called[found[0]]})?" if len(found) == 1 else ""


def spec_for(name_or_path: str | os.PathLike[str], mass_set: str | None = None) -> RobotSpec:
    """Return a bundled robot by its name, or the robot in the file at a path ending in ``.toml`` or ``.urdf``.

    ``mass_set`` selects one of the mass sets that the file offers. Errors as of the readers of the two formats.
    """
    path = as_path(name_or_path, "name_or_path")
    suffix = path.suffix.lower()
    if suffix == ".urdf":
        return _from_urdf(path, mass_set)
    if suffix == ".toml":
        return spec_from_toml(path, mass_set)
    if isinstance(name_or_path, str) and not suffix and os.sep not in name_or_path:
        return spec_from_toml(bundled_path(name_or_path), mass_set)
    hint = "; expand it first: xacro robot.xacro > robot.urdf" if suffix == ".xacro" else ""
    raise ConfigError(f"{name_or_path}: a robot file ends in .toml or .urdf{hint}")


def _from_urdf(path: Path, mass_set: str | None) -> RobotSpec:
    if mass_set is not None and (not isinstance(mass_set, str) or mass_set != "default"):
        raise ConfigError(f"{path}: there is no mass set {shown(mass_set)}; a URDF has one set of masses, 'default'")
    return spec_from_urdf(path)
