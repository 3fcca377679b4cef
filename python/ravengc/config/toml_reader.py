"""A robot from a TOML file, format 1: every key known, every number in SI, every complaint with its line.

::

    format = 1
    name = "one_link"
    convention = "modified"        # or "standard", or "frames"
    source = "where the numbers come from"
    level_only = true              # torques are good only where gravity is along -z of frame 0

    [base]                         # frame 0 in B (z up when the arm is level)
    rpy = ["0 deg", "90 deg", "0 deg"]             # or rotation = three rows
    translation = [0, 0, 0]

    [[link]]                       # in order, parents first
    name = "arm"
    joint = "revolute"             # or "prismatic", "fixed"
    alpha = "90 deg"               # alpha, a, d, theta
                                   # explicit frames: translation, rotation or rpy, axis
    mass = "494 g"
    com = ["6.5 mm", "97.75 mm", "-137.71 mm"]
    inertia = [0.02, 0, 0, 0.02, 0, 0.001]         # about COM: xx xy xz yy yz zz
    limits = { lower = "0 deg", upper = "90 deg" }
    source = "data sheet"

Further tables: ``[tool]``, ``[coupling]``, ``[transmission]``, ``[mass_set.NAME.LINK]``, ``[accelerometer]`` and
``[[disturbance]]`` (:mod:`ravengc.config.disturbances`).
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from ravengc._convert import as_path
from ravengc.config.couplings import COUPLING_KEYS, TRANSMISSION_KEYS, read_coupling, read_transmission
from ravengc.config.disturbances import DISTURBANCE_KEYS, read_disturbance
from ravengc.config.fields import Table, read_rotation, read_vector
from ravengc.config.files import decode, read_bytes, refuse_oversized
from ravengc.config.links import LINK_KEYS, MASS_KEYS, override_mass, read_link
from ravengc.config.locate import KeyPath, Place, TextPlaces, Where
from ravengc.config.validate import CONVENTIONS, validate
from ravengc.errors import ConfigError, ParseError
from ravengc.messages import did_you_mean, listed, shown
from ravengc.spec import Convention, LinkSpec, Pose, RobotSpec

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator

__all__ = ["FORMAT", "spec_from_toml"]

FORMAT = 1
"""The layout of robot files that this version reads and writes."""

HEAD_KEYS = ("format", "name", "description", "convention", "source", "level_only")
TOP_KEYS = (*HEAD_KEYS, "base", "link", "tool", "coupling", "transmission", "mass_set", "accelerometer", "disturbance")
POSE_KEYS = ("translation", "rotation", "rpy", "source")
ACCELEROMETER_KEYS = (
    *("sensor", "rate_hz", "range", "unit", "rotation", "position", "bias", "correction", "gyro_bias", "cutoff_hz"),
    *("policy", "gyro_range", "bandwidth_hz", "noise", "stuck_count"),
    *("up", "pose_limit", "tilt_limit", "norm", "jerk", "linear_acceleration", "moving_base"),
)
"""The base's sensor: kept as it stands, for :mod:`ravengc.calibration.block`."""
ACCELEROMETER_FLAGS = ("moving_base",)
DEFAULT_SET = "default"

_LONG_KEY = re.compile(r"(?<![\w.-])[\w-]++(?:[ \t]*+\.[ \t]*+[\w-]++){64}")
_POSITION = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


def spec_from_toml(path_or_text: str | os.PathLike[str], mass_set: str | None = None) -> RobotSpec:
    """Return the robot of a TOML file, or of TOML text (anything with a line break in it).

    ``mass_set`` selects one of the file's mass sets instead of the links' own masses (``"default"``).
    Raises ParseError (syntax, size, unreadable file: with file, line, column), ConfigError (keys, types, shapes),
    UnitsError, ModelError and LimitError; each names file, line, field, value and what was expected.
    """
    text, file = _load(path_or_text)
    where = TextPlaces(file or "<text>", text)
    top = Table(_parse(text, where.file), Place("robot", (), where), TOP_KEYS)
    if top.number("format", "number", default=-1.0) != FORMAT:
        raise top.complaint("format", f"{FORMAT}, the layout that this version reads")
    spec = replace(_read_robot(top), file=file)
    return _select_masses(spec, top, mass_set, where)


def _load(path_or_text: str | os.PathLike[str]) -> tuple[str, str | None]:
    if isinstance(path_or_text, str) and ("\n" in path_or_text or "\r" in path_or_text):
        try:
            data = path_or_text.encode("utf-8")
        except UnicodeEncodeError as error:
            raise ParseError(f"not valid Unicode: {error.reason}", file="<text>") from error
        refuse_oversized(data, "<text>")
        return path_or_text.removeprefix("\ufeff"), None
    path = as_path(path_or_text, "path_or_text")
    return decode(read_bytes(path), str(path)), str(path)


def _parse(text: str, file: str) -> dict[str, object]:
    import tomllib

    long_key = _LONG_KEY.search(text)
    if long_key is not None:
        raise ParseError("a key of more than 64 parts", file=file, line=text.count("\n", 0, long_key.start()) + 1)
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ParseError("nested too deeply", file=file) from None
    except ValueError as error:  # TOMLDecodeError, and integers of more digits than Python converts
        raise _parse_error(str(error), text, file) from error


def _parse_error(message: str, text: str, file: str) -> ParseError:
    position = _POSITION.search(message)
    if position is None:
        return ParseError(f"not valid TOML: {message}", file=file)
    end_line, end_column = text.count("\n") + 1, len(text) - text.rfind("\n")
    line, column = (int(position[1]), int(position[2])) if position[1] else (end_line, end_column)
    return ParseError(f"not valid TOML: {message[: position.start()]}", file=file, line=line, column=column)


def _read_robot(top: Table) -> RobotSpec:
    convention = cast("Convention", top.choice("convention", CONVENTIONS))
    base = top.table("base", POSE_KEYS)
    tool = top.table("tool", ("tip", *POSE_KEYS))
    links = tuple(_read_links(top, convention))
    coupling = read_coupling(top.table("coupling", COUPLING_KEYS), links) if "coupling" in top else None
    spec = RobotSpec(
        name=top.text("name", None),
        convention=convention,
        links=links,
        base=_read_pose(base),
        tool=_read_pose(tool),
        tip=tool.text("tip") if "tip" in tool else None,
        coupling=coupling,
        description=top.text("description"),
        source=_sources(top, base, tool),
        accelerometer=_read_accelerometer(top),
        level_only=top.flag("level_only"),
    )
    elements = top.tables("disturbance", DISTURBANCE_KEYS, "disturbance")
    spec = replace(spec, disturbances=tuple(read_disturbance(table, spec) for table in elements))
    if "transmission" not in top:
        return spec
    return replace(spec, transmission=read_transmission(top.table("transmission", TRANSMISSION_KEYS), spec))


def _read_accelerometer(top: Table) -> dict[str, Any] | None:
    if "accelerometer" not in top:
        return None
    return top.table("accelerometer", ACCELEROMETER_KEYS).raw(ACCELEROMETER_FLAGS)


def _read_links(top: Table, convention: Convention) -> Iterator[LinkSpec]:
    if "link" not in top:
        raise top.complaint("link", "at least one [[link]]")
    previous = None
    for table in top.tables("link", LINK_KEYS, "link"):
        link = read_link(table, convention, previous)
        previous = link.name
        yield link


def _read_pose(table: Table) -> Pose:
    return Pose(rotation=read_rotation(table), translation=read_vector(table, "translation"))


def _sources(top: Table, base: Table, tool: Table) -> str:
    """The robot's source, with those of base and tool frame, which have none of their own once read."""
    parts = [top.text("source")]
    parts += [
        f"{name}: {table.text('source')}" for name, table in (("base", base), ("tool", tool)) if "source" in table
    ]
    return "\n".join(filter(None, parts))


def _select_masses(spec: RobotSpec, top: Table, wanted: str | None, where: TextPlaces) -> RobotSpec:
    """Check the robot with every mass set of the file and return it with the wanted one."""
    tables = top.table("mass_set")
    sets = {DEFAULT_SET: spec}
    for name in tables.names():
        if name == DEFAULT_SET:
            place = tables.place.at(name)
            raise ConfigError(f"{place}: {name!r} means the masses of the links themselves; choose another name")
        sets[name] = _with_masses(spec, tables.table(name))
    for name, candidate in sets.items():
        validate(candidate, _places_with_set(where, spec, name))
    chosen = DEFAULT_SET if wanted is None else wanted
    if not isinstance(chosen, str) or chosen not in sets:
        near = did_you_mean(chosen, sets)
        raise ConfigError(f"{where(())}there is no mass set {shown(chosen)}{near} (there are: {listed(sets)})")
    return replace(sets[chosen], mass_set=chosen, mass_sets=tuple(sets))


def _with_masses(spec: RobotSpec, tables: Table) -> RobotSpec:
    links = {link.name: link for link in spec.links}
    for name in tables.names():
        if name not in links:
            near = did_you_mean(name, links)
            raise ConfigError(f"{tables.place.at(name)}: there is no link {shown(name)}{near} (links: {listed(links)})")
        links[name] = override_mass(links[name], tables.table(name, MASS_KEYS))
    return replace(spec, links=tuple(links[link.name] for link in spec.links))


def _places_with_set(where: TextPlaces, spec: RobotSpec, set_name: str) -> Where:
    """Places of a robot with a mass set: what the set gives stands in the set's own table."""

    def place(path: KeyPath) -> str:
        if len(path) >= 3 and path[0] == "link":
            in_set = ("mass_set", set_name, spec.links[int(path[1])].name, *path[2:])
            if in_set[:4] in where.lines:
                return where(in_set)
        return where(path)

    return place
