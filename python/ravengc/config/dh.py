"""A robot from rows of Denavit-Hartenberg parameters, as a table in a paper gives them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from ravengc.config.fields import Table
from ravengc.config.links import LINK_KEYS, read_link
from ravengc.config.locate import Place
from ravengc.config.validate import validate
from ravengc.errors import ConfigError
from ravengc.messages import did_you_mean, shown
from ravengc.spec import CouplingSpec, LinkSpec, Pose, RobotSpec, TransmissionSpec

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["spec_from_dh"]


def spec_from_dh(
    rows: Sequence[Mapping[str, object]],
    convention: Literal["standard", "modified"],
    *,
    name: str = "robot",
    base: Pose | None = None,
    tool: Pose | None = None,
    tip: str | None = None,
    coupling: CouplingSpec | None = None,
    transmission: TransmissionSpec | None = None,
    description: str = "",
    source: str = "",
) -> RobotSpec:
    """Return the robot whose links are ``rows``, each a dict of the keys of ``[[link]]`` in a robot file.

    ``joint`` ("revolute"), ``name`` ("link1", "link2", ...), ``joint_name``, ``parent`` (the row before; "base"),
    ``alpha``, ``a``, ``d``, ``theta``, ``mass``, ``com``, ``inertia`` (about the COM, xx xy xz yy yz zz), ``massless``,
    ``limits`` (dict of lower, upper, velocity, effort), ``source``; plain numbers are SI, texts such as "90 deg" carry
    their unit. ``theta`` (``d`` of a prismatic joint) is the offset to which the coordinate adds.
    ``base`` leads from frame 0 to the base frame B (z up when the arm is level), ``tool`` is in the frame of ``tip``.
    Raises ConfigError, UnitsError, ModelError and LimitError, each naming row, field, value and what was expected.
    """
    if not isinstance(convention, str) or convention not in {"standard", "modified"}:
        near = did_you_mean(convention, ("standard", "modified"))
        raise ConfigError(f"convention: got {shown(convention)}, expected 'standard' or 'modified' (Craig){near}")
    spec = RobotSpec(
        name=name,
        convention=convention,
        links=_read_rows(rows, convention),
        base=Pose() if base is None else base,
        tool=Pose() if tool is None else tool,
        tip=tip,
        coupling=coupling,
        transmission=transmission,
        description=description,
        source=source,
    )
    validate(spec)
    return spec


def _read_rows(
    rows: Sequence[Mapping[str, object]], convention: Literal["standard", "modified"]
) -> tuple[LinkSpec, ...]:
    if not isinstance(rows, (list, tuple)):
        expected = 'a list of dicts, one per link, such as {"alpha": "90 deg", "a": 0.3, "mass": 2.0}'
        raise ConfigError(f"rows: got {shown(rows)}, expected {expected}")
    links: list[LinkSpec] = []
    for index, row in enumerate(rows):
        table = Table(row, Place(f"row {index + 1}"), LINK_KEYS)
        links.append(read_link(table, convention, links[-1].name if links else None, f"link{index + 1}"))
    return tuple(links)
