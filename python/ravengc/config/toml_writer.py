"""A robot as TOML text, format 1, in SI, with every digit: reading it gives the same robot back."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from ravengc._convert import as_path
from ravengc.config.files import write_atomically
from ravengc.config.toml_reader import FORMAT
from ravengc.config.toml_values import toml_text, toml_value
from ravengc.config.validate import validate
from ravengc.spec import (
    IDENTITY,
    ZERO,
    CouplingSpec,
    DhRow,
    JointLimits,
    JointOrigin,
    LinkSpec,
    Pose,
    RobotSpec,
    TransmissionSpec,
)

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator, Mapping, Sequence

    from ravengc.disturbances import Disturbance

__all__ = ["spec_to_toml", "write_toml"]


def spec_to_toml(spec: RobotSpec) -> str:
    """Return the robot as TOML text; :func:`spec_from_toml` reads the same robot from it, to the last bit.

    The masses in use become the file's own: its other mass sets, which the robot does not carry, are not in the text.
    Raises ModelError and LimitError for a robot that cannot exist, which no reader would take back.
    """
    validate(spec)
    blocks = [
        _head(spec),
        _pose_table("base", spec.base, None),
        *map(_link_table, spec.links, _parents_by_default(spec.links)),
        _pose_table("tool", spec.tool, spec.tip),
        _coupling_table(spec.coupling),
        _transmission_table(spec.transmission),
        _accelerometer_table(spec.accelerometer),
        *map(_disturbance_table, spec.disturbances),
    ]
    return "\n\n".join("\n".join(block) for block in map(list, blocks) if block) + "\n"


def write_toml(spec: RobotSpec, path: str | os.PathLike[str]) -> None:
    """Write :func:`spec_to_toml` to ``path``; when that fails (ConfigError) an old file is still there, whole."""
    write_atomically(as_path(path, "path"), spec_to_toml(spec))


def _head(spec: RobotSpec) -> Iterator[str]:
    yield "# SI units: m, rad, kg, s, N, N·m. COM and inertia (about the COM: xx xy xz yy yz zz) are in the link frame."
    if spec.mass_set != "default":
        yield f"# Mass set: {spec.mass_set}"
    yield f"format = {FORMAT}"
    yield f"name = {toml_text(spec.name)}"
    yield f"convention = {toml_text(spec.convention)}"
    yield from _texts({"description": spec.description, "source": spec.source})
    if spec.level_only:
        yield "level_only = true"


def _pose_table(name: str, pose: Pose, tip: str | None) -> Iterator[str]:
    if pose == Pose() and tip is None:
        return
    yield f"[{name}]"
    if tip is not None:
        yield f"tip = {toml_text(tip)}"
    yield f"rotation = {_matrix(pose.rotation)}"
    yield f"translation = {_vector(pose.translation)}"


def _parents_by_default(links: Sequence[LinkSpec]) -> list[str | None]:
    return [None, *(link.name for link in links[:-1])]


def _link_table(link: LinkSpec, default_parent: str | None) -> Iterator[str]:
    yield "[[link]]"
    yield f"name = {toml_text(link.name)}"
    yield f"joint = {toml_text(link.joint)}"
    yield from _texts({"joint_name": link.joint_name})
    if link.parent != default_parent:
        yield f"parent = {toml_text('base' if link.parent is None else link.parent)}"
    yield from _placement(link.placement)
    yield from _body(link)
    if link.limits != JointLimits():
        yield f"limits = {_limits(link.limits)}"
    yield from _texts({"source": link.source})


def _placement(placement: DhRow | JointOrigin) -> Iterator[str]:
    if isinstance(placement, DhRow):
        yield from (f"{key} = {_number(getattr(placement, key))}" for key in ("alpha", "a", "d", "theta"))
        return
    yield f"translation = {_vector(placement.pose.translation)}"
    if placement.pose.rotation != IDENTITY:
        yield f"rotation = {_matrix(placement.pose.rotation)}"
    yield f"axis = {_vector(placement.axis)}"


def _body(link: LinkSpec) -> Iterator[str]:
    yield "massless = true" if link.massless else f"mass = {_number(link.mass)}"
    if link.com != ZERO:
        yield f"com = {_vector(link.com)}"
    if any(link.inertia):
        yield f"inertia = {_vector(link.inertia)}"


def _coupling_table(coupling: CouplingSpec | None) -> Iterator[str]:
    if coupling is None:
        return
    yield "[coupling]"
    yield f"coordinates = {_list(map(toml_text, coupling.coordinates))}"
    yield f"matrix = {_matrix(coupling.matrix)}"
    yield f"offset = {_vector(coupling.offset)}"
    if coupling.limits:
        yield f"limits = {_list(map(_limits, coupling.limits))}"
    yield from _texts({"source": coupling.source})


def _transmission_table(transmission: TransmissionSpec | None) -> Iterator[str]:
    if transmission is None:
        return
    yield "[transmission]"
    yield f"motors = {_list(map(toml_text, transmission.motors))}"
    yield f"joint_per_motor = {_matrix(transmission.joint_per_motor)}"
    yield f"offset = {_vector(transmission.offset)}"
    yield from _texts({"source": transmission.source})


def _accelerometer_table(table: Mapping[str, Any] | None) -> Iterator[str]:
    if table is None:
        return
    yield "[accelerometer]"
    yield from (f"{key} = {toml_value(value)}" for key, value in table.items())


def _disturbance_table(element: Disturbance) -> Iterator[str]:
    yield "[[disturbance]]"
    yield f"kind = {toml_text(element.kind)}"
    yield f"name = {toml_text(element.name)}"
    for field in fields(element):
        value = getattr(element, field.name)
        if field.name not in {"name", "source"} and value != field.default:
            yield f"{field.name} = {_floats(value)}"
    yield from _texts({"source": element.source})


def _floats(value: Any) -> str:
    """A text, or numbers of any kind, singly or in lists, as floats."""
    if isinstance(value, str):
        return toml_text(value)
    return _list(map(_floats, value)) if isinstance(value, tuple) else _number(value)


def _limits(limits: JointLimits) -> str:
    given = {key: getattr(limits, key) for key in ("lower", "upper", "velocity", "effort")}
    pairs = ", ".join(f"{key} = {_number(value)}" for key, value in given.items() if value is not None)
    return f"{{ {pairs} }}" if pairs else "{}"


def _texts(values: dict[str, str]) -> Iterator[str]:
    return (f"{key} = {toml_text(value)}" for key, value in values.items() if value)


def _number(value: float) -> str:
    return repr(float(value))


def _vector(values: Sequence[float]) -> str:
    return _list(map(_number, values))


def _matrix(rows: Sequence[Sequence[float]]) -> str:
    if len(rows) <= 3:
        return _list(map(_vector, rows))
    return "[\n" + "".join(f"  {_vector(row)},\n" for row in rows) + "]"


def _list(items: Iterator[str] | map[str]) -> str:
    return f"[{', '.join(items)}]"
