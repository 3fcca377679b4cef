"""KDL's answers for a serial arm, for an interpreter that has PyKDL: one JSON object in, one out.

Run as a file by that interpreter (Debian's python3-pykdl is for the system's), so it needs nothing but the standard
library and PyKDL. In: ``convention``, ``links`` (joint, alpha, a, d, theta, mass, com, inertia), ``q`` (N, n), ``g``
(N, 3) in axes of frame 0. Out: ``poses`` (N, 12) of the last link, ``torques`` (N, n).
"""

from __future__ import annotations

import importlib
import json
import sys
from typing import Any

ABSENT = 3
"""Exit code of an interpreter without PyKDL."""


def main() -> int:
    """Answer what standard input asks."""
    try:
        kdl = importlib.import_module("PyKDL")
    except ImportError as error:
        sys.stderr.write(f"{error}\n")
        return ABSENT
    asked = json.load(sys.stdin)
    chain = chain_of(kdl, asked["links"], asked["convention"])
    rows = list(zip(asked["q"], asked["g"], strict=True))
    out = {
        "version": getattr(kdl, "__version__", ""),
        "poses": [pose(kdl, chain, q) for q, _ in rows],
        "torques": [torque(kdl, chain, q, g) for q, g in rows],
    }
    json.dump(out, sys.stdout)
    return 0


def chain_of(kdl: Any, links: list[dict[str, Any]], convention: str) -> Any:
    """The rows as segments: a joint, then the way to its segment's tip.

    A modified row stands before its joint, so it is a fixed segment, and the joint with the mass the next;
    "modified as standard" puts it after its joint, as the rows of the other convention.
    """
    kinds = {"revolute": kdl.Joint.RotZ, "prismatic": kdl.Joint.TransZ, "fixed": kdl.Joint.Fixed}
    chain = kdl.Chain()
    for link in links:
        row = (link["a"], link["alpha"], link["d"], link["theta"])
        joint, body = kdl.Joint(kinds[link["joint"]]), inertia(kdl, link)
        if convention == "standard":
            chain.addSegment(kdl.Segment(joint, kdl.Frame.DH(*row), body))
        elif convention == "modified as standard":
            chain.addSegment(kdl.Segment(joint, kdl.Frame.DH_Craig1989(*row), body))
        else:
            chain.addSegment(kdl.Segment(kdl.Joint(kdl.Joint.Fixed), kdl.Frame.DH_Craig1989(*row)))
            chain.addSegment(kdl.Segment(joint, kdl.Frame.Identity(), body))
    return chain


def inertia(kdl: Any, link: dict[str, Any]) -> Any:
    """Mass, centre of mass and inertia about it."""
    xx, xy, xz, yy, yz, zz = link["inertia"]
    about = kdl.RotationalInertia(xx, yy, zz, xy, xz, yz)
    return kdl.RigidBodyInertia(link["mass"], kdl.Vector(*link["com"]), about)


def pose(kdl: Any, chain: Any, q: list[float]) -> list[float]:
    """Rotation and translation of the last segment's tip, row by row."""
    out = kdl.Frame()
    kdl.ChainFkSolverPos_recursive(chain).JntToCart(array(kdl, q), out)
    return [out[i, j] for i in range(3) for j in range(4)]


def torque(kdl: Any, chain: Any, q: list[float], g: list[float]) -> list[float]:
    """The page's call: inverse dynamics at rest, ChainIdSolver_RNE."""
    still, out = array(kdl, [0.0] * len(q)), kdl.JntArray(len(q))
    none = [kdl.Wrench.Zero()] * chain.getNrOfSegments()
    kdl.ChainIdSolver_RNE(chain, kdl.Vector(*g)).CartToJnt(array(kdl, q), still, still, none, out)
    return list(out)


def array(kdl: Any, values: list[float]) -> Any:
    """Numbers as KDL takes them."""
    out = kdl.JntArray(len(values))
    for i, value in enumerate(values):
        out[i] = value
    return out


if __name__ == "__main__":
    sys.exit(main())
