"""Libraries of others that answer for a serial arm: PyKDL and the Robotics Toolbox, where they are installed."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ravengc.dvrk.kdl_peer import ABSENT
from ravengc.errors import ConfigError
from ravengc.spec import DhRow

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ravengc.spec import LinkSpec, RobotSpec

__all__ = ["Answers", "Peer", "ask_kdl", "ask_toolbox"]

Array = npt.NDArray[np.float64]
PATIENCE_S = 60.0
OLDEST_TOOLBOX = (1, 4, 4)
"""Before that its gravity is of another sign."""


@dataclass(frozen=True, slots=True)
class Answers:
    """Poses of the last link (N, 3, 4) and torques that hold the arm (N, n), N·m, in axes of frame 0."""

    poses: Array
    torques: Array


@dataclass(frozen=True, slots=True)
class Peer:
    """A library that was asked: its name and version, and its answers, or why there are none."""

    name: str
    version: str = ""
    answers: Answers | None = None
    why_not: str = ""


def ask_kdl(spec: RobotSpec, q: Array, g: Array, *, python: str | None = None, convention: str | None = None) -> Peer:
    """What KDL says for the arm at ``q`` (N, n) in the fields ``g`` (N, 3), both in axes of frame 0.

    ``python`` is an interpreter that has PyKDL; without it this one is asked, then the system's. ``convention``
    replaces the robot's own, to show what a wrong one does. Raises ConfigError if a named interpreter cannot answer.
    """
    question = json.dumps(
        {
            "convention": convention or spec.convention,
            "links": [_row(link) for link in spec.links],
            "q": q.tolist(),
            "g": g.tolist(),
        }
    )
    for interpreter in [python] if python else _interpreters():
        found = _asked(interpreter, question, q.shape)
        if found is not None:
            return found
    if python:
        raise ConfigError(f"{python}: has no PyKDL; expected an interpreter that can import it, such as that of Debian")
    return Peer("PyKDL", why_not="not installed (Debian: python3-pykdl; --pykdl PYTHON names an interpreter with it)")


def _interpreters() -> Iterator[str]:
    yield sys.executable
    system = which("python3", path="/usr/bin:/usr/local/bin")
    if system:
        yield system


def _asked(interpreter: str, question: str, shape: tuple[int, ...]) -> Peer | None:
    """The interpreter's answers for coordinates of this shape, or ``None`` if it has no PyKDL."""
    script = str(Path(__file__).with_name("kdl_peer.py"))
    try:
        result = subprocess.run(  # noqa: S603 - an interpreter of the system, or one that the user named
            [interpreter, script], input=question, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired, ValueError) as error:
        raise ConfigError(f"{interpreter}: cannot be asked for PyKDL: {error}") from error
    if result.returncode == ABSENT:
        return None
    try:
        found = json.loads(result.stdout)
        poses = np.array(found["poses"], dtype=np.float64).reshape(shape[0], 3, 4)
        torques = np.array(found["torques"], dtype=np.float64).reshape(shape)
        return Peer("PyKDL", str(found["version"]), Answers(poses, torques))
    except (KeyError, TypeError, ValueError) as error:
        said = result.stderr.strip().splitlines()[-1:] or ["nothing"]
        raise ConfigError(f"{interpreter}: did not answer for PyKDL; it said: {said[0][:200]}") from error


def _row(link: LinkSpec) -> dict[str, Any]:
    row = dh_row(link)
    place = {"alpha": row.alpha, "a": row.a, "d": row.d, "theta": row.theta}
    return {"joint": link.joint, **place, "mass": link.mass, "com": link.com, "inertia": link.inertia}


def dh_row(link: LinkSpec) -> DhRow:
    """The link's DH row; ConfigError for a link that is placed otherwise."""
    if not isinstance(link.placement, DhRow):
        raise ConfigError(f"link '{link.name}' has no DH row; expected a robot in standard or modified DH")
    return link.placement


def ask_toolbox(spec: RobotSpec, q: Array, g: Array) -> Peer:
    """What the Robotics Toolbox says for the arm at ``q`` (N, n) in the fields ``g`` (N, 3), axes of frame 0."""
    name = "Robotics Toolbox"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what the library says on import is not ours to mend
        try:
            toolbox = importlib.import_module("roboticstoolbox")
        except ImportError as error:
            return Peer(name, why_not=f"not installed (pip install roboticstoolbox-python): {error}")
        version = str(getattr(toolbox, "__version__", "0"))
        if tuple(int(part) for part in version.split(".")[:3] if part.isdigit()) < OLDEST_TOOLBOX:
            return Peer(name, version, why_not=f"version {version}; asked from 1.4.4 on")
        arm, tip = _toolbox_arm(toolbox, spec)
        poses = np.array([(arm.fkine(row).A @ tip)[:3] for row in q])
        torques = np.array([arm.gravload(row, gravity=field) for row, field in zip(q, g, strict=True)])
    return Peer(name, version, Answers(poses, torques))


def _toolbox_arm(toolbox: Any, spec: RobotSpec) -> tuple[Any, Array]:
    """The moving rows as an arm, and what the fixed rows at its end make of its last frame."""
    kinds = {
        ("standard", "revolute"): toolbox.RevoluteDH,
        ("standard", "prismatic"): toolbox.PrismaticDH,
        ("modified", "revolute"): toolbox.RevoluteMDH,
        ("modified", "prismatic"): toolbox.PrismaticMDH,
    }
    tip, rows = np.eye(4), []
    for link in spec.links:
        row = dh_row(link)
        if link.joint == "fixed":
            fixed = kinds[spec.convention, "revolute"](a=row.a, alpha=row.alpha, d=row.d, offset=row.theta)
            tip = tip @ fixed.A(0.0).A
            continue
        own = {"d": row.d, "offset": row.theta} if link.joint == "revolute" else {"theta": row.theta, "offset": row.d}
        xx, xy, xz, yy, yz, zz = link.inertia
        moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        kind = kinds[spec.convention, link.joint]
        rows.append(kind(a=row.a, alpha=row.alpha, m=link.mass, r=link.com, I=moments, **own))
    return toolbox.DHRobot(rows), tip
