"""A robot as tables for people: angles in degrees, lengths in metres."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from rich.markup import escape
from rich.table import Column, Table

from ravengc.cli.common import new_table, right
from ravengc.coordinates import sliding
from ravengc.disturbances import Constant, PiecewiseCable, Polynomial, SpringBetween
from ravengc.reports.robot_facts import RobotFacts, facts_of
from ravengc.spec import CouplingSpec, DhRow, JointLimits, LinkSpec, Pose, RobotSpec, TransmissionSpec

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rich.console import Console

    import ravengc
    from ravengc.disturbances import Disturbance

__all__ = ["list_table", "show_robot"]

CONVENTIONS = {
    "standard": "standard Denavit-Hartenberg",
    "modified": "modified Denavit-Hartenberg (Craig)",
    "frames": "explicit joint frames",
}
TINY = 5e-7


def list_table(robots: Sequence[RobotSpec]) -> Table:
    """One line for every robot."""
    table = new_table("robot", right("n"), "what it is", "mass sets")
    for robot in robots:
        sets = ", ".join(robot.mass_sets) if len(robot.mass_sets) > 1 else ""
        count = str(len(robot.coordinate_names))
        table.add_row(robot.name, count, escape(_first_sentence(robot.description)), sets)
    table.caption = "n: coordinates; ravengc info ROBOT says everything that is known of one"
    return table


def show_robot(console: Console, robot: ravengc.Robot) -> None:
    """Print everything that was understood of a robot."""
    spec = robot.spec
    sources = _numbered_sources(spec)
    console.print(_head(spec, facts_of(robot)))
    _section(console, "joints", _joint_table(spec))
    _section(console, "frames", _frame_table(spec))
    _section(console, "masses in link frames; inertia about the COM, kg·m²", _mass_table(spec, sources))
    if spec.coupling is not None:
        _section(console, f"coupling {spec.coupling.source}", _coupling_table(spec, spec.coupling))
        _section(console, "coordinates", _coordinate_table(spec))
    if spec.transmission is not None:
        _section(console, f"transmission {spec.transmission.source}", _transmission_table(spec, spec.transmission))
    if spec.disturbances:
        _section(console, "beside the masses, N·m and rad, or N and m", _disturbance_table(spec, sources))
    if sources:
        _section(console, "sources", _source_table(sources))


def _section(console: Console, title: str, table: Table) -> None:
    name, _, source = title.partition(" ")
    console.print(f"\n[bold]{name}[/bold] {escape(source)}")
    console.print(table)


def _head(spec: RobotSpec, facts: RobotFacts) -> Table:
    table = Table.grid(Column(style="bold"), Column(), padding=(0, 2))
    for name, text in _head_rows(spec, facts):
        table.add_row(escape(name), escape(text))
    return table


def _head_rows(spec: RobotSpec, facts: RobotFacts) -> Iterator[tuple[str, str]]:
    yield spec.name, " ".join(spec.description.split())
    if spec.file:
        yield "file", spec.file
    if spec.level_only:
        yield "level only", "its torques hold only where gravity is along -z of frame 0"
    yield "convention", CONVENTIONS[spec.convention]
    yield (
        "size",
        f"{len(spec.coordinate_names)} coordinates, {len(spec.moving_links)} moving links, {len(spec.links)} links",
    )
    fixed = f" and {facts.base_mass:.6g} kg fixed to the base" if facts.base_mass else ""
    yield "mass", f"{facts.moving_mass:.6g} kg{fixed}"
    sets = f" (of {', '.join(spec.mass_sets)})" if len(spec.mass_sets) > 1 else ""
    yield "mass set", f"{spec.mass_set}{sets}"
    if facts.reach is not None:
        yield "reach", f"{facts.reach:.3f} m from the base origin to the tool, at most"
    yield "base", f"frame 0 in B: {_pose(spec.base)}"
    yield "tool", f"in {spec.tip or spec.links[-1].name}: {_pose(spec.tool)}"


def _joint_table(spec: RobotSpec) -> Table:
    rows = [
        (link.joint_name or link.name, link.name, link.joint, *_limits(link.limits, slides=link.joint == "prismatic"))
        for link in spec.moving_links
    ]
    return _table(("joint", "moves", "type", *map(right, ("range", "speed", "effort"))), rows)


def _frame_table(spec: RobotSpec) -> Table:
    headings, placements = _placements(spec)
    rows = [
        (link.name, link.parent or "base", "fixed" if link.joint == "fixed" else "", *placement)
        for link, placement in zip(spec.links, placements, strict=True)
    ]
    return _table(("link", "on", "", *map(right, headings)), rows)


def _placements(spec: RobotSpec) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """How each link is placed on its parent: DH columns, or origin, turn and axis."""
    if spec.convention == "frames":
        return ("origin, m", "roll pitch yaw, deg", "axis"), [_frame_cells(link) for link in spec.links]
    headings = ("alpha, deg", "a, m", "d, m", "theta, deg")
    return headings, [_dh_cells(link) for link in spec.links]


def _dh_cells(link: LinkSpec) -> tuple[str, ...]:
    row = link.placement
    if not isinstance(row, DhRow):
        return _frame_cells(link)
    theta, d = math.degrees(row.theta), row.d
    return (
        _number(math.degrees(row.alpha)),
        _number(row.a),
        _joint_value(d) if link.joint == "prismatic" else _number(d),
        _joint_value(theta) if link.joint == "revolute" else _number(theta),
    )


def _joint_value(offset: float) -> str:
    sign = "-" if offset < 0.0 else "+"
    return "q" if abs(offset) < TINY else f"q {sign} {_number(abs(offset))}"


def _frame_cells(link: LinkSpec) -> tuple[str, ...]:
    origin = link.placement
    if isinstance(origin, DhRow):
        return _dh_cells(link)
    axis = "" if link.joint == "fixed" else _vector(origin.axis)
    return _vector(origin.pose.translation), _vector(_roll_pitch_yaw(origin.pose)), axis


def _limits(limits: JointLimits, *, slides: bool) -> tuple[str, str, str]:
    scale, unit, effort = (1.0, "m", "N") if slides else (180.0 / math.pi, "deg", "N·m")
    known = limits.lower is not None or limits.upper is not None
    ends = ("-" if end is None else f"{scale * end:.4g}" for end in (limits.lower, limits.upper))
    return (
        f"{' to '.join(ends)} {unit}" if known else "",
        "" if limits.velocity is None else f"{scale * limits.velocity:.4g} {unit}/s",
        "" if limits.effort is None else f"{limits.effort:.4g} {effort}",
    )


def _mass_table(spec: RobotSpec, sources: Mapping[str, int]) -> Table:
    rows = []
    for link in spec.links:
        xx, xy, xz, yy, yz, zz = link.inertia
        inertia = (_vector((xx, yy, zz)), _vector((xy, xz, yz))) if any(link.inertia) else ("point mass", "")
        cells = (f"{link.mass:.6g}", _vector(link.com), *inertia) if link.mass else ("massless", "", "", "")
        rows.append((link.name, *cells, f"[{sources[link.source]}]" if link.source else ""))
    headings = ("mass, kg", "COM, m", "inertia xx yy zz", "xy xz yz", "source")
    return _table(("link", *map(right, headings)), rows)


def _coupling_table(spec: RobotSpec, coupling: CouplingSpec) -> Table:
    joints = zip(spec.moving_links, coupling.matrix, coupling.offset, strict=True)
    rows = [
        (link.joint_name or link.name, _sum(row, coupling.coordinates, offset, turns=link.joint != "prismatic"))
        for link, row, offset in joints
    ]
    return _table(("joint", "follows"), rows)


def _coordinate_table(spec: RobotSpec) -> Table:
    coordinates = zip(spec.coordinate_names, spec.coordinate_limits, sliding(spec), strict=True)
    rows = [(name, *_limits(limits, slides=bool(slides))) for name, limits, slides in coordinates]
    return _table(("coordinate", *map(right, ("range", "speed", "effort"))), rows)


def _transmission_table(spec: RobotSpec, transmission: TransmissionSpec) -> Table:
    coordinates = zip(
        spec.coordinate_names, transmission.joint_per_motor, transmission.offset, sliding(spec), strict=True
    )
    rows = [(name, _sum(row, transmission.motors, offset, turns=not s)) for name, row, offset, s in coordinates]
    return _table(("coordinate", "from the motors"), rows)


def _disturbance_table(spec: RobotSpec, sources: Mapping[str, int]) -> Table:
    rows = []
    for element in spec.disturbances:
        numbers = zip(element.labels, element.parameters, strict=True)
        parameters = " ".join(f"{label} {value:.4g}" for label, value in numbers)
        source = f"[{sources[element.source]}]" if element.source else ""
        rows.append((element.name, element.kind, _acts_on(element, spec), parameters, _remark(element), source))
    return _table(("element", "kind", "acts on", "parameters", "", right("source")), rows)


def _acts_on(element: Disturbance, spec: RobotSpec) -> str:
    if isinstance(element, SpringBetween):
        return f"what lies between {element.body_a} and {element.body_b}"
    acts = _along(element.joint, spec)
    reads = acts if isinstance(element, Constant) else _along(element.of or element.joint, spec)
    return acts if reads == acts else f"{acts}, by {reads}"


def _along(along: str | Sequence[float], spec: RobotSpec) -> str:
    return along if isinstance(along, str) else _sum(along, spec.coordinate_names, 0.0, turns=False)


def _remark(element: Disturbance) -> str:
    """Steps of the torque, the direction and the range in which an element holds."""
    remarks = []
    if isinstance(element, PiecewiseCable):
        remarks = [f"JUMPS by {size:.4g} at {at:.4g}" for at, size in element.jumps()]
    if isinstance(element, Polynomial) and element.direction != "both":
        remarks.append(f"{element.direction} direction")
    if isinstance(element, (Polynomial, PiecewiseCable)) and element.range is not None:
        low, high = element.range
        remarks.append(f"constant beyond {low:.4g} to {high:.4g}")
    return "; ".join(remarks)


def _source_table(sources: Mapping[str, int]) -> Table:
    table = Table.grid(Column(justify="right"), Column(), padding=(0, 2))
    for source, number in sources.items():
        table.add_row(f"[{number}]" if number else "", escape(source))
    return table


def _numbered_sources(spec: RobotSpec) -> dict[str, int]:
    """Every source once: the links' with a number, then the robot's own (number 0) where it says more."""
    numbered: dict[str, int] = {}
    for part in (*spec.links, *spec.disturbances):
        if part.source:
            numbered.setdefault(part.source, len(numbered) + 1)
    if spec.source:
        numbered.setdefault(spec.source, 0)
    return numbered


def _sum(factors: Sequence[float], names: Sequence[str], offset: float, *, turns: bool) -> str:
    """A row of a matrix as it is read aloud: ``-0.83 m5 + 0.609 m6 + 90 deg``; what is left of rounding is dropped."""
    named, least = zip(factors, names, strict=True), 1e-12 * max(map(abs, factors))
    terms = [(factor, f"{_factor(factor)}{name}") for factor, name in named if abs(factor) > least]
    if offset:
        terms.append((offset, f"{abs(math.degrees(offset)):.6g} deg" if turns else f"{abs(offset):.6g} m"))
    text = " ".join(f"{'-' if sign < 0.0 else '+'} {term}" for sign, term in terms) or "0"
    return text[2:] if text.startswith("+ ") else text.replace("- ", "-", 1)


def _factor(factor: float) -> str:
    return "" if abs(factor) == 1.0 else f"{abs(factor):.6g} "


def _pose(pose: Pose) -> str:
    moved = f"({_vector(pose.translation)}) m"
    turn = _roll_pitch_yaw(pose)
    return moved if max(map(abs, turn)) < TINY else f"{moved}, roll pitch yaw ({_vector(turn)}) deg"


def _roll_pitch_yaw(pose: Pose) -> tuple[float, float, float]:
    """Angles (deg) with R = Rz(yaw) Ry(pitch) Rx(roll); roll is 0 where pitch is ±90 deg and only yaw ∓ roll counts."""
    r = np.array(pose.rotation)
    pitch = math.atan2(-r[2, 0], math.hypot(r[0, 0], r[1, 0]))
    if math.hypot(r[0, 0], r[1, 0]) < TINY:
        return 0.0, math.degrees(pitch), math.degrees(math.atan2(-r[0, 1], r[1, 1]))
    return math.degrees(math.atan2(r[2, 1], r[2, 2])), math.degrees(pitch), math.degrees(math.atan2(r[1, 0], r[0, 0]))


def _vector(values: Sequence[float]) -> str:
    return " ".join(_number(value) for value in values)


def _number(value: float) -> str:
    return "0" if abs(value) < TINY else f"{value:.6g}"


def _first_sentence(text: str) -> str:
    flat = " ".join(text.split())
    return flat.split(". ")[0].split(": ")[0].rstrip(".")


def _table(headings: Sequence[Column | str], rows: Sequence[Sequence[str]]) -> Table:
    """A table without the columns that are empty throughout."""
    shown = [index for index in range(len(headings)) if any(row[index] for row in rows)]
    table = new_table(*(headings[index] for index in shown))
    for row in rows:
        table.add_row(*(escape(row[index]) for index in shown))
    return table
