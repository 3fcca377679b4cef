"""The NumPy reference against numbers from elsewhere: the RAVEN II and the two-link arm of the dVRK wiki.

``data/raven2_gravity_ref.csv``: 48 rows, both arms of the RAVEN II (modified DH, masses and centres of mass of
uw-biorobotics/raven2, ``grav_comp.cpp``), six poses, four gravity vectors; computed by the paper's equations in link
frames and again by a fourth-order central difference of the potential energy. ``data/dvrk_reference_torques.json``:
complex-step gradients of the potential energy.
"""

from __future__ import annotations

import csv
import json
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from ravengc import reference as ref
from ravengc.spec import Convention, DhRow, LinkSpec, Matrix, Pose, RobotSpec

DATA = Path(__file__).parent / "data"
MASSES = (0.494, 0.750, 0.231)


def raven(name: str, signs: tuple[float, ...], base_rotation: Matrix) -> RobotSpec:
    """The three gross-positioning links of a RAVEN II arm; ``signs`` are those that tell gold from green."""
    alpha0, alpha2, theta1, theta2, theta3, mirror = signs
    first = tuple(mirror * x for x in (0.0065, 0.09775, -0.13771))
    second = (-0.002, -0.18274, -0.23053 * mirror)
    links = (
        LinkSpec(
            name="shoulder", mass=MASSES[0], com=first, placement=DhRow(alpha=radians(alpha0), theta=radians(theta1))
        ),
        LinkSpec(
            name="elbow",
            parent="shoulder",
            mass=MASSES[1],
            com=second,
            placement=DhRow(alpha=radians(75), theta=radians(theta2)),
        ),
        LinkSpec(
            name="insertion",
            parent="elbow",
            joint="prismatic",
            mass=MASSES[2],
            placement=DhRow(alpha=radians(alpha2), theta=radians(theta3)),
        ),
    )
    return RobotSpec(name=name, convention="modified", links=links, base=Pose(rotation=base_rotation))


ARMS = {
    "gold": raven("gold", (0, 128, 205, 180, 90, 1), ((0, -1, 0), (0, 0, -1), (1, 0, 0))),
    "green": raven("green", (180, 52, 25, 0, -90, -1), ((0, 1, 0), (0, 0, 1), (1, 0, 0))),
}


def test_raven_gravity_table() -> None:
    with (DATA / "raven2_gravity_ref.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 48
    for row in rows:
        q = [radians(float(row["J1_deg"])), radians(float(row["J2_deg"])), float(row["d3_m"])]
        g = [float(row[axis]) for axis in ("gBx", "gBy", "gBz")]
        expected = [float(row[name]) for name in ("tau1_eq", "tau2_eq", "f3_eq")]
        slope = [float(row[name]) for name in ("tau1_grad", "tau2_grad", "f3_grad")]
        tau = ref.gravity_torque(ARMS[row["arm"]], q, g)
        np.testing.assert_allclose(tau, expected, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(tau, slope, rtol=0.0, atol=1e-9)


def test_raven_arms_mirror_each_other() -> None:
    rng = np.random.default_rng(1)
    mirror = np.array([1.0, -1.0, 1.0])  # y of B
    for q, g in zip(rng.uniform(0.2, 1.5, (20, 3)), rng.normal(0.0, 9.8, (20, 3)), strict=True):
        gold = ref.gravity_torque(ARMS["gold"], q, g)
        np.testing.assert_allclose(ref.gravity_torque(ARMS["green"], q, mirror * g), gold, atol=1e-13)


def rrbot(convention: Convention) -> RobotSpec:
    """The two-link arm of the dVRK wiki: links of 1 kg, 0.9 m from joint to joint, COM half-way."""
    if convention == "standard":
        rows, com = (DhRow(a=0.9), DhRow(a=0.9, d=0.1)), (-0.45, 0.0, 0.0)
    else:
        rows, com = (DhRow(), DhRow(a=0.9, d=0.1)), (0.45, 0.0, 0.0)
    links = [
        LinkSpec(name="link1", mass=1.0, com=com, inertia=(1.0, 0.0, 0.0, 1.0, 0.0, 1.0), placement=rows[0]),
        LinkSpec(
            name="link2", parent="link1", mass=1.0, com=com, inertia=(1.0, 0.0, 0.0, 1.0, 0.0, 1.0), placement=rows[1]
        ),
    ]
    if convention == "modified":
        links.append(LinkSpec(name="tip", parent="link2", joint="fixed", massless=True, placement=DhRow(a=0.9)))
    return RobotSpec(name="rrbot", convention=convention, links=tuple(links))


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_rrbot_reference_torques(convention: Convention) -> None:
    rows = json.loads((DATA / "dvrk_reference_torques.json").read_text())["rrbot"]
    assert len(rows) == 60
    for row in rows:
        tau = ref.gravity_torque(rrbot(convention), row["q"], row["g"])
        np.testing.assert_allclose(tau, row["tau"], rtol=0.0, atol=1e-12)


def test_rrbot_by_hand() -> None:
    """Both links along y while gravity pulls along -x: lever arms 0.45 m and 1.35 m, and only 0.45 m at joint 2."""
    expected = -9.81 * (0.45 + 1.35), -9.81 * 0.45
    for convention in ("standard", "modified"):
        tau = ref.gravity_torque(rrbot(convention), [pi / 2, 0.0], (-9.81, 0.0, 0.0))
        np.testing.assert_allclose(tau, expected, rtol=1e-14)


def test_rrbot_tables_agree_on_everything() -> None:
    rng = np.random.default_rng(2)
    one, other = rrbot("standard"), rrbot("modified")
    for motion in rng.normal(size=(20, 15)):
        args = motion[0:2], motion[2:4], motion[4:6], motion[6:9], motion[9:12], motion[12:15]
        q = args[0]
        np.testing.assert_allclose(ref.inverse_dynamics(one, *args), ref.inverse_dynamics(other, *args), atol=1e-12)
        np.testing.assert_allclose(ref.mass_matrix(one, q), ref.mass_matrix(other, q), atol=1e-12)
        np.testing.assert_allclose(ref.forward_kinematics(one, q), ref.forward_kinematics(other, q), atol=1e-12)
