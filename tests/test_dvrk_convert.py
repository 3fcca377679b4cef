"""Kinematic files, physical chains, arms and gravity compensation files: one robot from them, and back."""

from __future__ import annotations

import re
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc
from dvrk_files import gc_file, kinematic_mtmr, kinematic_psm_si, physical_psm_si, written
from ravengc.config.bundled import bundled_names, spec_for
from ravengc.disturbances import Friction
from ravengc.dvrk import convert, mounted, read_kinematic, read_published, write_kinematic
from ravengc.errors import ArgumentError, ConfigError, LimitError, ModelError, ParseError
from ravengc.spec import JointOrigin, Pose

if TYPE_CHECKING:
    from pathlib import Path

NAMES = [
    name
    for name in bundled_names()
    if spec_for(name).convention != "frames" and all(link.joint != "fixed" for link in spec_for(name).links)
]
"""Of the bundled robots, those that a kinematic file can say."""
ARM = {"generation": "Si", "kinematic": "kinematic/PSM_Si.json", "kinematic_gc": "PSM_Si_physical.json"}


def rows(robot: ravengc.Robot) -> list[Any]:
    return [(link.placement, link.joint, link.limits) for link in robot.spec.links]


def test_the_mtms_file_is_the_bundled_robot(tmp_path: Path) -> None:
    spec = read_kinematic(written(tmp_path, "MTMR.json", kinematic_mtmr()))
    bundled = ravengc.load("dvrk_mtmr").spec
    for mine, theirs in zip(spec.links, bundled.links, strict=True):
        assert mine.name == theirs.name
        assert mine.limits == theirs.limits
        np.testing.assert_allclose(
            [getattr(mine.placement, key) for key in ("alpha", "a", "d", "theta")],
            [getattr(theirs.placement, key) for key in ("alpha", "a", "d", "theta")],
            atol=1e-15,
        )
    assert spec.transmission is not None
    assert bundled.transmission is not None
    assert spec.transmission.joint_per_motor == bundled.transmission.joint_per_motor


def test_the_physical_chain_is_the_bundled_robot(tmp_path: Path) -> None:
    files = [
        written(tmp_path, "PSM_Si_physical.json", physical_psm_si()),
        written(tmp_path, "PSM_Si.json", kinematic_psm_si()),
    ]
    found = convert(files)
    bundled = ravengc.load("dvrk_psm_si")
    assert found.spec.coordinate_names == ("yaw", "pitch", "insertion")
    assert found.spec.coordinate_limits == bundled.spec.coordinate_limits
    robot, g = ravengc.Robot(found.spec), np.array((0.3, -2.0, -9.0))
    for q in np.random.default_rng(0).uniform(-0.5, 0.5, (10, 3)):
        np.testing.assert_allclose(robot.gravity_torque(q, g), bundled.gravity_torque(q, g), atol=1e-13)


def test_the_arms_mounting_pitch_turns_the_base(tmp_path: Path) -> None:
    """-45 deg, q = (.5, .3, .15): -5.832 N m on an independent route; level +1.116 N m."""
    files = [
        written(tmp_path, "PSM1.json", ARM | {"mounting_pitch": -pi / 4.0}),
        written(tmp_path, "PSM_Si_physical.json", physical_psm_si()),
    ]
    found, level, q = convert(files), np.array((0.0, 0.0, -9.81)), np.array((0.5, 0.3, 0.15))
    tau = ravengc.Robot(found.spec).gravity_torque(q, level)
    np.testing.assert_allclose(tau, (-2.774, -5.832, -2.399), atol=1e-3)
    flat = convert(files, mounting_pitch=0.0)
    np.testing.assert_allclose(ravengc.Robot(flat.spec).gravity_torque(q, level), (-3.923, 1.116, -5.239), atol=1e-3)
    assert "mounted at a pitch" in " ".join(found.notes)


def test_up_is_where_the_control_software_has_it() -> None:
    spec = mounted(ravengc.load("dvrk_psm_si").spec, -0.785398)
    turn = np.array(spec.base.rotation)
    np.testing.assert_allclose(turn.T @ (0.0, 0.0, 1.0), (0.0, np.sin(-0.785398), np.cos(-0.785398)), atol=1e-15)


def test_a_published_file_makes_its_arm(tmp_path: Path) -> None:
    gc = written(tmp_path, "gc-MTMR-1.json", gc_file(1))
    alone, both = convert([gc]), convert([written(tmp_path, "MTMR.json", kinematic_mtmr()), gc])
    assert alone.published is not None
    assert not alone.flag
    assert len(alone.spec.disturbances) == 12
    assert alone.spec.level_only
    assert both.spec.level_only
    q = np.array((0.1, 0.2, -0.1, 0.3, 0.4, 0.2, 0.0))
    first, second = (
        ravengc.Robot(replace(found.spec, disturbances=())).gravity_torque(q, (0.0, 0.0, -9.81))
        for found in (alone, both)
    )
    np.testing.assert_allclose(first, second, atol=1e-10)


@pytest.mark.parametrize("pitch", [0.2, -0.2, 1.0, -2.5, 5.0])
def test_the_flag_says_what_the_tilted_robot_does(tmp_path: Path, pitch: float) -> None:
    """The masses of the robot turn with the base, and joint 2 changes by what the file is said to ask for."""
    found, level = (convert([written(tmp_path, "gc.json", gc_file(3))], mounting_pitch=angle) for angle in (pitch, 0.0))
    pose, room = (0.0, 0.0, 0.0, 0.0, pi / 2.0, 0.0, 0.0), (0.0, 0.0, -9.81)
    tilted, flat = (ravengc.Robot(one.spec).gravity_torque(pose, room)[1] for one in (found, level))
    assert f"for {tilted - flat:+.2f} N m more" in found.flag


def test_a_published_file_on_a_tilted_base_is_flagged(tmp_path: Path) -> None:
    gc = written(tmp_path, "gc.json", gc_file(3))
    found = convert([gc], mounting_pitch=np.radians(10.0))
    assert "N m more" in found.flag
    assert "-4.1 ... +4.0 N m" in found.flag
    arm = written(tmp_path, "MTML.json", {"gravity_compensation": "gc.json", "mounting_pitch": 0.2})
    assert "tilted by 11.5 deg" in convert([arm, gc]).flag
    assert not convert([gc], mounting_pitch=0.0).flag


def test_the_other_hands_file_is_flagged(tmp_path: Path) -> None:
    """Left and right are mirrored: told by the wrist platform's range, and where there is none by the name."""
    left, right = (written(tmp_path, f"gc{place}.json", gc_file(place)) for place in (0, 1))
    arms = [read_published(path).arm for path in (left, right)]
    assert arms == ["MTML", "MTMR"]
    ranged = written(tmp_path, "arm.json", kinematic_mtmr())
    named = written(tmp_path, "MTMR.json", re.sub(r'"qm(in|ax)": [-.0-9]+, ', "", kinematic_mtmr()))
    for kinematic in (ranged, named):
        assert "of an MTML (ARM_NAME), and the kinematic file of an MTMR" in convert([kinematic, left]).flag
        assert not convert([kinematic, right]).flag
    both = convert([ranged, left], mounting_pitch=0.2).flag
    assert "wrong sign" in both
    assert "tilted by 11.5 deg" in both


@pytest.mark.parametrize("name", NAMES)
def test_kinematic_files_go_there_and_back(tmp_path: Path, name: str) -> None:
    robot = ravengc.load(name)
    path = tmp_path / "arm.json"
    left_out = write_kinematic(robot.spec, path)
    back = ravengc.Robot(read_kinematic(path))
    q, qd, qdd = np.random.default_rng(1).uniform(-0.4, 0.4, (3, robot.n))
    base = ravengc.BaseMotion(specific_force=(1.0, 2.0, 9.0), angular_velocity=(0.1, 0.2, 0.3))
    torques = [one.inverse_dynamics(q, qd, qdd, base) for one in (robot, back)]
    np.testing.assert_allclose(*torques, atol=1e-11)
    last = robot.spec.links[-1].name
    poses = [one.forward_kinematics(q, last) for one in (robot, back)]
    np.testing.assert_allclose(*poses, atol=1e-13)
    assert ("its tool frame" in left_out) == (robot.spec.tool != Pose())


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    si, rubbing = ravengc.load("dvrk_psm_si").spec, Friction(name="rub", joint="joint1", coulomb=0.1)
    assert write_kinematic(si, tmp_path / "si.json") == ("the limits of its coordinates",)
    rrbot = replace(ravengc.load("rrbot").spec, disturbances=(rubbing,))
    assert "the elements beside its masses" in write_kinematic(rrbot, tmp_path / "rrbot.json")


def test_a_base_offset_is_not_called_level(tmp_path: Path) -> None:
    turned = kinematic_psm_si() | {"base-offset": np.diag((1.0, -1.0, -1.0, 1.0)).tolist()}
    (note,) = (note for note in convert([written(tmp_path, "PSM.json", turned)]).notes if "base axes" in note)
    assert "base offset" in note


def test_what_a_kinematic_file_cannot_say(tmp_path: Path) -> None:
    rrbot, tip = ravengc.load("rrbot").spec, ravengc.load("rrbot_modified").spec
    bent = replace(rrbot, convention="frames", links=tuple(replace(x, placement=JointOrigin()) for x in rrbot.links))
    fork = replace(rrbot, links=(rrbot.links[0], replace(rrbot.links[1], parent=None)))
    for spec, said in ((tip, "'tip' is fixed"), (bent, "no DH row"), (fork, "hangs on 'base'")):
        with pytest.raises(ConfigError, match=said):
            write_kinematic(spec, tmp_path / "no.json")
    assert not (tmp_path / "no.json").exists()


def joint(**changes: Any) -> dict[str, Any]:
    data = physical_psm_si()
    for key, value in changes.items():
        if value is None:
            data["DH"]["joints"][0].pop(key)
        else:
            data["DH"]["joints"][0][key] = value
    return data


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({}, "none of the keys"),
        ({"DH": []}, "expected a table"),
        ({"DH": {"joints": []}}, "'convention' is missing"),
        ({"DH": {"convention": "craig", "joints": [{}]}}, "expected one of 'standard', 'modified'"),
        ({"DH": {"convention": "modified"}}, "'joints' is missing, expected a list of joints"),
        ({"DH": {"convention": "modified", "joints": [4]}}, "joint 1"),
        (joint(alpha="1.57"), "joint 1: alpha: .*'1.57'"),
        (joint(alpha=None), "joint 1: 'alpha' is missing"),
        (joint(type="rotary"), "joint 1: type: got 'rotary', expected one of 'revolute', 'prismatic'"),
        (joint(mode="passive", name="odd"), "what moves a passive joint is known of"),
        (joint(mass=-1.0), "mass"),
        (joint(Ixx=-1.0), "inertia"),
        (joint(x1=0.0), "principal axis"),
        (joint(qmin=1.0, qmax=0.0), "lower"),
        (joint(A=1e12), r"^a\.json: link 1 'yaw': a: got .*1e\+09"),
        (joint(mode="pasive"), "joint 1: mode: got 'pasive', expected one of 'active', 'passive'"),
        (gc_file() | {"SN": "a\nb"}, r"^a\.json: robot: name: got 'dvrk_mtm._a\\nb'"),
        (kinematic_psm_si() | {"coupling": {}}, "'ActuatorToJointPosition' is missing"),
        (kinematic_psm_si() | {"coupling": {"ActuatorToJointPosition": [[1.0]]}}, "expected 3 rows of 3"),
        (kinematic_psm_si() | {"coupling": {"ActuatorToJointPosition": [[0.0] * 3] * 3}}, "no inverse"),
        (kinematic_psm_si() | {"base-offset": [[1.0] * 4] * 3}, "expected 4 rows of 4"),
        (kinematic_psm_si() | {"base-offset": [[1.0] * 4] * 4}, "rotation"),
        ({"TooltipOffset": [], "DH": {}}, "an instrument"),
        ({"arms": []}, "a whole system"),
        ({"io": {}}, "input and output"),
        ({"kinematic": "PSM.json"}, "give the kinematic file of the arm beside it"),
        ({"mounting_pitch": 0.1}, "kinematic file"),
    ],
)
def test_bad_files_say_where_and_what(tmp_path: Path, data: dict[str, Any], said: str) -> None:
    with pytest.raises((ConfigError, ModelError, LimitError), match=said):
        convert([written(tmp_path, "a.json", data)])


def test_files_that_do_not_belong_together(tmp_path: Path) -> None:
    physical = written(tmp_path, "PSM_Si_physical.json", physical_psm_si())
    arm = written(tmp_path, "PSM1.json", ARM | {"mounting_pitch": -0.785398})
    with pytest.raises(ConfigError, match="another kinematic file of a physical chain"):
        convert([physical, written(tmp_path, "other.json", physical_psm_si())])
    with pytest.raises(ConfigError, match=r"does not name 'other\.json'"):
        convert([arm, written(tmp_path, "other.json", physical_psm_si())])
    with pytest.raises(ConfigError, match="not yaw, pitch and insertion"):
        convert([physical, written(tmp_path, "MTMR.json", kinematic_mtmr())])
    with pytest.raises(ConfigError, match=r"no level MTM|of an MTM with 7"):
        convert([physical, written(tmp_path, "gc.json", gc_file())])
    with pytest.raises(ConfigError, match="more than a turn"):
        convert([physical], mounting_pitch=-45.0)
    turned = kinematic_psm_si() | {"base-offset": np.diag((-1.0, -1.0, 1.0, 1.0)).tolist()}
    with pytest.raises(ConfigError, match="base offset and a mounting pitch"):
        convert([written(tmp_path, "PSM.json", turned)], mounting_pitch=0.1)


def test_impossible_arguments(tmp_path: Path) -> None:
    for paths in ([], "a.json", None, ["a"] * 9, [4]):
        with pytest.raises(ArgumentError):
            convert(paths)  # type: ignore[arg-type]
    with pytest.raises(ParseError, match="cannot be read"):
        convert([tmp_path / "absent.json"])
