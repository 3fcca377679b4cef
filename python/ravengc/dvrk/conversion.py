"""Files of the dVRK's control software, sorted out and made into one robot.

Which file is which is told by what is in it: ``DH`` (kinematic), ``GC_controller`` (gravity compensation of an MTM),
or the keys of an arm's file. An arm's file names others, which are looked for among those that were given: nothing here
opens a file that another file names.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees, remainder
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from ravengc._convert import as_number, as_path, check_type
from ravengc.config import validate
from ravengc.config.bundled import spec_for
from ravengc.dvrk.json_file import optional_number, read_json, table_of
from ravengc.dvrk.kinematic import mounted, spec_from_kinematic
from ravengc.dvrk.published import Published, published_from
from ravengc.dvrk.published_robot import robot_spec_from_published
from ravengc.errors import ArgumentError, ConfigError
from ravengc.messages import listed, shown
from ravengc.spec import Pose

if TYPE_CHECKING:
    import os
    from collections.abc import Sequence
    from pathlib import Path

    from ravengc.spec import CouplingSpec, RobotSpec

__all__ = ["Conversion", "convert"]

OF_AN_ARM = ("kinematic", "kinematic_gc", "gravity_compensation", "gravity-compensation", "mounting_pitch")
OTHERS = {"io": "an arm's input and output", "arms": "a whole system"}
TIPS = ("TooltipOffset", "tooltip_offset", "tooltip-offset")
"""Keys of an instrument, which has rows of its own."""
MOST_FILES = 8
PLATFORM = 3
"""Place of the wrist platform among an MTM's links."""


@dataclass(frozen=True, slots=True)
class Conversion:
    """The robot, what to know about it, and the published file that is in it, if one is.

    ``flag`` says why the robot must not be used as it stands: a published file on a base that is not level, or one of
    the other MTM.
    """

    spec: RobotSpec
    notes: tuple[str, ...]
    published: Published | None = None
    flag: str = ""


def convert(
    paths: Sequence[str | os.PathLike[str]], *, name: str | None = None, mounting_pitch: float | None = None
) -> Conversion:
    """One robot from the files of one arm: kinematic, physical (``kinematic_gc``), gravity compensation, arm.

    ``mounting_pitch`` (rad) replaces the arm file's. With a gravity compensation file alone the bundled MTM of its
    arm is taken. Raises ParseError and ConfigError for files that cannot be read or do not belong together.
    """
    found = _sorted(paths)
    arm = found.get("arm")
    pitch = None if mounting_pitch is None else as_number(mounting_pitch, "mounting_pitch")
    if arm is not None:
        _check_names(arm, found)
        if pitch is None:
            pitch = optional_number(table_of(arm[1], arm[0].name, "the file"), "mounting_pitch")
    published = published_from(found["gc"][1], found["gc"][0].name) if "gc" in found else None
    spec, notes = _robot(found, published)
    flags = [] if published is None else _other_side(published, spec)
    if pitch is not None:
        spec = mounted(spec, pitch)
        notes.append(f"mounted at a pitch of {pitch:g} rad about x: base axes are those of the level room")
        tilt = remainder(degrees(pitch), 360.0)
        if published is not None and tilt:
            flags.append(f"on a base tilted by {abs(tilt):.1f} deg: {published.on_tilt(-tilt).sentence}")
    elif spec.base != Pose():
        notes.append("base axes are those of the file's base offset; expected level with z up: it gives no pitch")
    elif published is None:
        notes.append("no mounting pitch: base axes are those of frame 0, level with z up")
    if name is not None:
        check_type(name, str, "name")
        spec = replace(spec, name=name)
    validate(spec, lambda _: f"{', '.join(path.name for path, _ in found.values())}: ")
    return Conversion(spec, tuple(notes), published, "; ".join(flags))


def _sorted(paths: Sequence[str | os.PathLike[str]]) -> dict[str, tuple[Path, dict[str, Any]]]:
    """The files by what they are, one of each."""
    if not isinstance(paths, (list, tuple)) or not 0 < len(paths) <= MOST_FILES:
        raise ArgumentError(f"paths is {shown(paths)}; expected a list of 1 to {MOST_FILES} files")
    found: dict[str, tuple[Path, dict[str, Any]]] = {}
    for path in (as_path(one, "paths") for one in paths):
        data = read_json(path)
        kind = _kind(data, path)
        if kind in found:
            raise ConfigError(f"{path}: is another {_TITLES[kind]} beside {found[kind][0]}; expected one of an arm")
        found[kind] = (path, data)
    return found


_TITLES = {
    "gc": "gravity compensation file",
    "physical": "kinematic file of a physical chain",
    "kinematic": "kinematic file",
    "arm": "arm file",
}


def _kind(data: dict[str, Any], path: Path) -> str:
    if "GC_controller" in data:
        return "gc"
    for key, title in OTHERS.items():
        if key in data and "DH" not in data:
            raise ConfigError(f"{path}: has {key!r}, so it is the file of {title}; expected {_expected()}")
    if any(key in data for key in TIPS):
        raise ConfigError(f"{path}: is the file of an instrument; expected {_expected()} (dvrk_psm has one built in)")
    if "DH" in data:
        dh = data["DH"] if isinstance(data["DH"], dict) else {}
        joints = dh.get("joints", dh.get("links"))
        several = [joint for joint in joints if isinstance(joint, dict)] if isinstance(joints, list) else []
        return "physical" if any(joint.get("mode") == "passive" for joint in several) else "kinematic"
    if any(key in data for key in OF_AN_ARM):
        return "arm"
    raise ConfigError(f"{path}: has none of the keys of {_expected()}; it has {listed(data)}")


def _expected() -> str:
    return f"a kinematic file ('DH'), a gravity compensation file ('GC_controller') or an arm's ({listed(OF_AN_ARM)})"


def _check_names(arm: tuple[Path, dict[str, Any]], found: dict[str, tuple[Path, dict[str, Any]]]) -> None:
    """Files that were given are those that the arm names, and the one that the robot needs is among them."""
    path, data = arm
    table = table_of(data, path.name, "the file")
    named = {key: PurePath(table.text(key)).name for key in OF_AN_ARM[:4] if key in table}
    given = {entry[0].name for kind, entry in found.items() if kind != "arm"}
    strange = sorted(given - set(named.values()))
    if strange and named:
        raise ConfigError(f"{path}: does not name {listed(strange)}; it names {listed(sorted(named.values()))}")
    if not given:
        raise ConfigError(
            f"{path}: names {listed(sorted(named.values()))}; give the kinematic file of the arm beside it"
        )


def _robot(found: dict[str, tuple[Path, dict[str, Any]]], published: Published | None) -> tuple[RobotSpec, list[str]]:
    chosen = found.get("physical") or found.get("kinematic")
    if chosen is None and published is None:
        raise ConfigError(f"{found['arm'][0]}: is an arm's file alone; give its kinematic file beside it")
    if chosen is not None:
        path, data = chosen
        spec = spec_from_kinematic(data, path.name, path.stem)
        notes = [f"axes, limits and masses: {path.name}"]
        virtual = found.get("kinematic")
        if spec.coupling is not None and virtual is not None:
            spec, note = _with_limits(spec, spec.coupling, virtual)
            notes.append(note)
        if not any(link.mass for link in spec.links) and published is None:
            notes.append("no masses: kinematics only")
    if published is None:
        return spec, notes
    if chosen is None:
        spec, notes = (
            spec_for(f"dvrk_{published.arm.lower()}"),
            [f"axes and masses: the bundled dvrk_{published.arm.lower()}"],
        )
    elif not any(link.mass for link in spec.links):
        spec = _with_masses(spec, published.arm)
        notes.append(f"masses, to which the file gives first moments: the bundled dvrk_{published.arm.lower()}")
    return robot_spec_from_published(published, spec), [*notes, f"gravity and cables: {published.source}"]


def _other_side(published: Published, spec: RobotSpec) -> list[str]:
    """Why the file is not this arm's: left and right are mirrored, and so are the moments of the links 4 and 5."""
    arm = _side(spec)
    if arm in {None, published.arm}:
        return []
    whose = f"{published.source} is of an {published.arm} (ARM_NAME), and the kinematic file of an {arm}"
    return [f"{whose}: the moments of the links 4 and 5 have the wrong sign; give the file of the {arm}"]


def _side(spec: RobotSpec) -> str | None:
    """Which MTM it is: by the range of the wrist platform, which is mirrored, or without one by its name."""
    limits = spec.links[PLATFORM].limits
    if limits.lower is not None and limits.upper is not None:
        return "MTML" if limits.lower + limits.upper < 0.0 else "MTMR"
    return next((arm for arm in ("MTML", "MTMR") if arm in spec.name.upper()), None)


def _with_limits(
    spec: RobotSpec, coupling: CouplingSpec, virtual: tuple[Path, dict[str, Any]]
) -> tuple[RobotSpec, str]:
    """The physical chain with the limits of the three coordinates, which the kinematic file has."""
    path, data = virtual
    three = spec_from_kinematic(data, path.name, path.stem).links[:3]
    if len(three) < 3 or [link.joint for link in three] != ["revolute", "revolute", "prismatic"]:
        raise ConfigError(f"{path}: is not yaw, pitch and insertion; expected the kinematic file of the same arm")
    limits = tuple(link.limits for link in three)
    return replace(spec, coupling=replace(coupling, limits=limits)), f"limits of the coordinates: {path.name}"


def _with_masses(spec: RobotSpec, arm: str) -> RobotSpec:
    bundled = spec_for(f"dvrk_{arm.lower()}")
    if len(spec.links) != len(bundled.links):
        raise ConfigError(f"{spec.name} has {len(spec.links)} links; the gravity compensation file is of an MTM with 7")
    links = zip(spec.links, bundled.links, strict=True)
    return replace(
        spec, links=tuple(replace(a, mass=b.mass, com=b.com, massless=b.massless, source=b.source) for a, b in links)
    )
