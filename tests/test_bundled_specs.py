"""The bundled robots: a source beside every number, torques as published or computed elsewhere, and their geometry.

``data/raven2_gravity_ref.csv``: 48 rows of the RAVEN II by two routes. ``data/dvrk_reference_torques.json``: complex
step gradients of the potential energy, with the gravity vector in DH frame 0; the masters' with exact right angles, the
Si arms' with the angles as rounded in their files.
"""

from __future__ import annotations

import csv
import json
import tomllib
from dataclasses import replace
from functools import cache
from math import pi, radians
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ravengc import reference
from ravengc.config import bundled_names, bundled_path, spec_from_toml, spec_to_toml, validate
from ravengc.config import spec_for as read_spec

if TYPE_CHECKING:
    from ravengc.spec import RobotSpec

DATA = Path(__file__).parent / "data"
NAMES = bundled_names()
spec_for = cache(read_spec)
RAVENS = ("raven2_gold", "raven2_green")
ANGLE = st.floats(-pi, pi)
LENGTH = st.floats(0.0, 0.5)
GRAVITY = st.tuples(*[st.floats(-20.0, 20.0)] * 3)


def torque(spec: RobotSpec, q: object, g: object) -> np.ndarray:
    return reference.gravity_torque_from_energy(spec, q, g)


def test_the_bundled_robots_are_these() -> None:
    assert set(NAMES) == {
        "dvrk_ecm", "dvrk_ecm_si", "dvrk_mtml", "dvrk_mtmr", "dvrk_psm", "dvrk_psm_si", "pa10", "panda",
        "raven2_gold", "raven2_gold_wrist", "raven2_green", "raven2_green_wrist", "rrbot", "rrbot_modified",
        "ur10", "ur5",
    }  # fmt: skip


def tables(value: object, name: str) -> list[tuple[str, dict[str, object]]]:
    """All tables of a document by name; those written in braces belong to the table that they stand in."""
    if isinstance(value, list):
        return [found for index, entry in enumerate(value) for found in tables(entry, f"{name}[{index}]")]
    if not isinstance(value, dict):
        return []
    inner = [found for key, entry in value.items() if key != "limits" for found in tables(entry, f"{name}.{key}")]
    return [(name, value), *inner]


@pytest.mark.parametrize("name", NAMES)
def test_every_table_with_numbers_names_their_source(name: str) -> None:
    for table, entries in tables(tomllib.loads(bundled_path(name).read_text(encoding="utf-8")), name):
        if not all(isinstance(entry, dict) for entry in entries.values()):
            assert isinstance(entries.get("source"), str), table
            assert len(str(entries["source"])) > 20, table


@pytest.mark.parametrize("name", NAMES)
def test_every_mass_set_is_valid_and_survives_writing(name: str) -> None:
    for mass_set in spec_for(name).mass_sets:
        spec = spec_for(name, mass_set)
        validate(spec)
        assert spec.name == name
        assert spec.description
        written = spec_from_toml(spec_to_toml(spec))
        assert written == replace(spec, mass_set="default", mass_sets=("default",))


@pytest.mark.parametrize("name", NAMES)
def test_every_coordinate_has_limits_where_they_are_known(name: str) -> None:
    spec = spec_for(name)
    bounded = [limits.lower is not None and limits.upper is not None for limits in spec.coordinate_limits]
    assert all(bounded) or name.startswith("rrbot")


def test_raven_torques_are_those_of_both_routes() -> None:
    with (DATA / "raven2_gravity_ref.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 48
    for row in rows:
        q = [radians(float(row["J1_deg"])), radians(float(row["J2_deg"])), float(row["d3_m"])]
        g = [float(row[key]) for key in ("gBx", "gBy", "gBz")]
        for route in ("eq", "grad"):
            expected = [float(row[f"{key}_{route}"]) for key in ("tau1", "tau2", "f3")]
            tau = torque(spec_for(f"raven2_{row['arm']}"), q, g)
            np.testing.assert_allclose(tau, expected, rtol=0.0, atol=1e-9)
            wrist = torque(spec_for(f"raven2_{row['arm']}_wrist"), [*q, 0.3, -0.2, 0.1], g)
            np.testing.assert_allclose(wrist, [*expected, 0, 0, 0], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("group", "count"), [("rrbot", 60), ("mtm", 100), ("psm_si", 16), ("ecm_si", 16)])
def test_dvrk_torques_are_those_of_the_energy_gradient(group: str, count: int) -> None:
    rows = json.loads((DATA / "dvrk_reference_torques.json").read_text())[group]
    assert len(rows) == count
    names = {"rrbot": ("rrbot", "rrbot_modified"), "psm_si": ("dvrk_psm_si",), "ecm_si": ("dvrk_ecm_si",)}
    for row in rows:
        for name in names.get(group, (f"dvrk_{row.get('arm', '').lower()}",)):
            spec = spec_for(name)
            g = np.array(spec.base.rotation) @ row["g"]
            np.testing.assert_allclose(torque(spec, row["q"], g), row["tau"], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("name", ["dvrk_psm_si", "dvrk_ecm_si"])
def test_a_level_mount_is_a_mounting_pitch_of_zero(name: str) -> None:
    """The control software's gravity is -9.81 (0, sin(pitch), cos(pitch)) in frame 0, which is B."""
    rows = json.loads((DATA / "dvrk_reference_torques.json").read_text())[name.removeprefix("dvrk_")]
    for row in rows:
        pitch = radians(row["mounting_pitch_deg"])
        g = -9.81 * np.array([0.0, np.sin(pitch), np.cos(pitch)])
        np.testing.assert_allclose(torque(spec_for(name), row["q"], g), row["tau"], rtol=0.0, atol=1e-12)


def test_pa10_torques_are_those_of_the_ship_study() -> None:
    q = (0.3, 0.6, -1.0, 0.2, 0.5, 0.1)
    expected = [0.0, -25.0096, 8.4105, 0.0124, 0.0357, 0.0]
    np.testing.assert_allclose(torque(spec_for("pa10"), q, (0, 0, -9.81)), expected, rtol=0.0, atol=5e-5)


def test_pa10_stands_straight_up() -> None:
    spec = spec_for("pa10")
    frames = reference.link_frames(spec, [0.0] * 6)
    heights = [(frames[link.name] @ [*link.com, 1.0])[:3] for link in spec.links]
    np.testing.assert_allclose(
        heights, [[0, 0, z] for z in (0.14818, 0.46390644, 0.80959, 1.09875, 1.2335, 1.3145)], atol=1e-8
    )


@given(q=st.tuples(ANGLE, ANGLE, LENGTH), g=GRAVITY)
def test_gold_and_green_mirror_each_other(q: tuple[float, ...], g: tuple[float, ...]) -> None:
    gx, gy, gz = g
    gold, green = map(spec_for, RAVENS)
    np.testing.assert_allclose(torque(gold, q, g), torque(green, q, (gx, -gy, gz)), atol=1e-12)
    mirror = np.diag([1.0, -1.0, 1.0])
    for name in ("link1", "link2", "link3"):
        frames = [reference.link_frames(arm, q)[name] for arm in (gold, green)]
        coms = [next(link.com for link in arm.links if link.name == name) for arm in (gold, green)]
        left, right = ((frame @ [*com, 1.0])[:3] for frame, com in zip(frames, coms, strict=True))
        np.testing.assert_allclose(left, mirror @ right, atol=1e-14)


@pytest.mark.parametrize("name", [*RAVENS, "raven2_gold_wrist", "dvrk_psm", "dvrk_ecm", "dvrk_psm_si", "dvrk_ecm_si"])
@given(data=st.data())
def test_the_instrument_always_passes_the_remote_centre(name: str, data: st.DataObject) -> None:
    """The axis of insertion meets the origin of B, or (Si arms, to the digits of their angles) a point beside it."""
    spec = spec_for(name)
    q = data.draw(st.tuples(ANGLE, ANGLE, LENGTH, *[ANGLE] * (len(spec.coordinate_names) - 3)))
    centre = np.array([0.0, 0.630, 0.0]) if name.endswith("si") else np.zeros(3)
    carriage = [link.name for link in spec.links if link.joint == "prismatic"][-1]
    frame = reference.link_frames(spec, q)[carriage]
    distance = np.linalg.norm(np.cross(frame[:3, 2], frame[:3, 3] - centre))
    assert distance < (1e-4 if name.endswith("si") else 1e-12)


@pytest.mark.parametrize("name", ["dvrk_psm", "dvrk_ecm", "dvrk_psm_si", "dvrk_ecm_si"])
def test_a_level_instrument_points_down_and_a_level_master_hangs(name: str) -> None:
    spec = spec_for(name)
    carriage = [link.name for link in spec.links if link.joint == "prismatic"][-1]
    frame = reference.link_frames(spec, [0.0] * len(spec.coordinate_names))[carriage]
    np.testing.assert_allclose(frame[:3, 2], [0, 0, -1], atol=1e-5)
    for master in ("dvrk_mtml", "dvrk_mtmr"):
        elbow = reference.link_frames(spec_for(master), [0.0] * 7)["shoulder_pitch"][:3, 3]
        np.testing.assert_allclose(elbow, [0, 0, -0.2794], atol=1e-15)


def test_raven_tool_pose_is_the_one_its_software_states() -> None:
    """params/raven_gold_crtk.yaml of the crtk branch: home_jpos and the pose that belongs to it, to its digits."""
    grasp1, grasp2 = 0.7537, 0.852
    q = (0.523, 1.584, 0.4002, 0.0715, 0.0950, (grasp2 - grasp1) / 2)
    pose = reference.forward_kinematics(spec_for("raven2_gold_wrist"), q)
    np.testing.assert_allclose(pose[:3, 3], [0.0239, -0.0144, -0.0779], atol=3e-4)
    x, y, z, w = np.array([-0.14, 0.636, 0.02, 0.76]) / np.linalg.norm([-0.14, 0.636, 0.02, 0.76])
    tool_z = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    np.testing.assert_allclose(pose[:3, 2], tool_z, atol=0.02)


def test_the_wrist_centre_is_the_tool_of_the_short_arm() -> None:
    q = (0.5, 1.2, 0.4)
    short = reference.forward_kinematics(spec_for("raven2_gold"), q)[:3, 3]
    long = reference.link_frames(spec_for("raven2_gold_wrist"), [*q, 0.1, 0.2, 0.3])["link4"][:3, 3]
    np.testing.assert_allclose(short, long, atol=1e-15)


def test_raven_motor_torques_in_counts_of_its_converters() -> None:
    """Gold, level, home: exact transmission against the software's diagonal, at 3695.8 counts per N·m of capstan."""
    spec = spec_for("raven2_gold")
    tau = torque(spec, (pi / 6, pi / 2, 0.4), (0, 0, -9.8))
    joint_per_motor = np.array(spec.transmission.joint_per_motor)
    counts = 12.25 * 3695.8
    np.testing.assert_allclose(joint_per_motor.T @ tau * counts, [-29.8, -165.7, 44.6], atol=0.05)
    np.testing.assert_allclose(tau / np.diag(np.linalg.inv(joint_per_motor)) * counts, [-45.8, -159.3, 44.6], atol=0.05)


def test_the_pair_of_grasp_motors_turns_the_jaws_without_opening_them() -> None:
    """Motors g1 = 8.992 grasp1 - c insertion and g2 = 8.992 grasp2 + c insertion (gold): half their difference."""
    for arm in RAVENS:
        motor_per_joint = np.linalg.inv(spec_for(f"{arm}_wrist").transmission.joint_per_motor)
        short = np.linalg.inv(spec_for(arm).transmission.joint_per_motor)
        np.testing.assert_allclose(motor_per_joint[:3, :3], short, rtol=1e-12)
        np.testing.assert_allclose(motor_per_joint[3:, :3], [motor_per_joint[3, :3]] * 3, rtol=1e-9)
        assert np.sign(motor_per_joint[3, 2]) == (1 if arm == "raven2_gold" else -1)


def test_master_torques_at_the_actuators_carry_the_joints_beyond() -> None:
    """The elbow's actuator turns the forearm against the base: q3 = m3 - m2, so tau_m2 = tau2 - tau3 + 0.6697 tau4."""
    spec = spec_for("dvrk_mtmr")
    tau = np.arange(1.0, 8.0)
    motors = np.array(spec.transmission.joint_per_motor).T @ tau
    np.testing.assert_allclose(motors[:4], [1.0, 2.0 - 3.0 + 0.6697 * 4.0, 3.0 - 0.6697 * 4.0, 4.0])


def test_the_mass_sets_differ_as_published() -> None:
    home = (pi / 6, pi / 2, 0.4)
    np.testing.assert_allclose(
        torque(spec_for("raven2_gold", "cad"), home, (0, 0, -9.8)), [-0.230, -0.520, 3.742], atol=5e-4
    )
    masses = {name: spec_for("dvrk_ecm", name).links[2].mass for name in spec_for("dvrk_ecm").mass_sets}
    assert masses == {"default": 1.5, "classic_hd": 2.5, "si_hd": 1.8, "custom": 0.8, "empty": 0.1}
    assert spec_for("rrbot", "box").links[0].inertia[3] == pytest.approx(1 / 12 * (1 + 0.01), rel=1e-12)


@pytest.mark.parametrize("name", [name for name in NAMES if name.startswith("raven2")])
def test_raven_inertias_are_the_rods_they_are_said_to_be(name: str) -> None:
    for mass_set in ("default", "cad"):
        for link in spec_for(name, mass_set).links[:2]:
            com = np.array(link.com)
            rod = link.mass * 4 / 12 * (com @ com * np.eye(3) - np.outer(com, com))
            np.testing.assert_allclose(link.inertia, rod[np.triu_indices(3)], rtol=1e-11)
