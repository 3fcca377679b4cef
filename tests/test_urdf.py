"""Robots from URDF: what MuJoCo makes of the same text, what a DH table of the same arm says, and every refusal."""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mutations import damaged
from ravengc import reference
from ravengc.config import spec_for, spec_from_toml, spec_from_urdf, spec_to_toml
from ravengc.errors import ConfigError, LimitError, ModelError, ParseError, RavenGCError
from ravengc.spec import JointLimits, RobotSpec
from strategies import grid

if TYPE_CHECKING:
    from pathlib import Path

GRIPPER = """\
<?xml version="1.0"?>
<robot name="gripper" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <link name="stand">
    <inertial>
      <origin xyz="0 0 0.1"/>
      <mass value="3"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>
    </inertial>
    <visual><geometry><mesh filename="package://nowhere/stand.dae"/></geometry></visual>
  </link>
  <link name="base"/>
  <joint name="mount" type="fixed"><parent link="stand"/><child link="base"/></joint>
  <link name="upper">
    <inertial>
      <origin xyz="0 0 0.1" rpy="0 0 1.5707963267948966"/>
      <mass value="2"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.25"/>
    </inertial>
  </link>
  <link name="left">
    <inertial><mass value="0.1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <link name="right"/>
  <link name="tip"/>
  <link name="tool"/>
  <joint name="turn" type="continuous">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 1" rpy="0 1.5 0"/><axis xyz="0 2 0"/>
    <limit lower="-1" upper="1" effort="0" velocity="3"/>
  </joint>
  <joint name="open" type="prismatic">
    <parent link="upper"/><child link="left"/><limit lower="0" upper="0.04" effort="5" velocity="0"/>
  </joint>
  <joint name="mirror" type="prismatic">
    <parent link="upper"/><child link="right"/><axis xyz="0 -1 0"/><mimic joint="open" multiplier="-1" offset="0.01"/>
  </joint>
  <joint name="third" type="revolute">
    <parent link="right"/><child link="tip"/><mimic joint="mirror" multiplier="2"/>
    <limit effort="1" velocity="1"/>
  </joint>
  <joint name="flange" type="fixed"><parent link="upper"/><child link="tool"/></joint>
  <transmission name="drive"><joint name="turn"/></transmission>
</robot>
"""


@pytest.fixture
def read(tmp_path: Path):
    def from_text(text: str | bytes, **options: str) -> RobotSpec:
        path = tmp_path / "robot.urdf"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return spec_from_urdf(path, **options)

    return from_text


def test_a_file_is_read_as_it_stands(read) -> None:
    spec = read(GRIPPER)
    links = {link.name: link for link in spec.links}
    assert list(links) == ["stand", "base_link", "upper", "left", "right", "tip", "tool_link"]
    assert (spec.name, spec.source, spec.convention) == ("gripper", "URDF file robot.urdf", "frames")
    assert (links["stand"].joint, links["stand"].parent, links["stand"].mass) == ("fixed", None, 3.0)
    assert (links["base_link"].parent, links["upper"].parent) == (None, "base_link")
    assert [links[name].massless for name in ("stand", "base_link", "upper", "left", "right")] == [0, 1, 0, 0, 1]
    assert links["upper"].placement.axis == (0.0, 1.0, 0.0)
    assert links["upper"].placement.pose.translation == (0.0, 0.0, 1.0)
    assert links["left"].placement.axis == (1.0, 0.0, 0.0)
    np.testing.assert_allclose(links["upper"].inertia, (0.2, 0, 0, 0.1, 0, 0.25), atol=1e-16)
    assert links["upper"].limits == JointLimits(velocity=3.0)
    assert links["left"].limits == JointLimits(lower=0.0, upper=0.04, effort=5.0)
    assert links["tip"].limits == JointLimits(effort=1.0, velocity=1.0)
    assert spec_from_toml(spec_to_toml(spec)) == spec


def test_mimic_joints_are_one_affine_map(read) -> None:
    """mirror = -open + 0.01 and third = 2 mirror = -2 open + 0.02."""
    coupling = read(GRIPPER).coupling
    assert coupling.coordinates == ("turn", "open")
    assert coupling.matrix == ((1, 0), (0, 1), (0, -1), (0, -2))
    assert coupling.offset == (0, 0, 0.01, 0.02)
    assert coupling.limits == (JointLimits(velocity=3.0), JointLimits(lower=0.0, upper=0.04, effort=5.0))


def test_the_tool_may_ride_on_any_link(read) -> None:
    assert read(GRIPPER).tip is None
    assert read(GRIPPER, tip="left").tip == "left"
    assert read(GRIPPER, tip="tool").tip == "tool_link"
    with pytest.raises(ModelError, match="did you mean 'left'"):
        read(GRIPPER, tip="leftt")


RRBOT = """\
<robot name="rrbot">
  <link name="world"/>
  <link name="link1"><inertial><origin xyz="0 0 0.45"/><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="link2"><inertial><origin xyz="0 0 0.45"/><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="camera"/>
  <joint name="joint1" type="continuous"><parent link="world"/><child link="link1"/><axis xyz="0 1 0"/></joint>
  <joint name="joint2" type="continuous"><parent link="link1"/><child link="link2"/>
    <origin xyz="0 0.1 0.9"/><axis xyz="0 1 0"/></joint>
  <joint name="tip" type="fixed"><parent link="link2"/><child link="camera"/><origin xyz="0 0 0.9"/></joint>
</robot>
"""

ANGLE = st.floats(-3.2, 3.2)
GRAVITY = st.tuples(*[st.floats(-20.0, 20.0)] * 3)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(q=st.tuples(ANGLE, ANGLE), g=GRAVITY)
def test_the_two_link_arm_is_that_of_its_dh_tables(read, q: tuple[float, ...], g: tuple[float, ...]) -> None:
    urdf = read(RRBOT)
    tau = reference.gravity_torque_from_energy(urdf, q, g)
    tip = reference.forward_kinematics(urdf, q)[:3, 3]
    for name in ("rrbot", "rrbot_modified"):
        table = spec_for(name)
        assert table.coordinate_names == urdf.coordinate_names
        np.testing.assert_allclose(reference.gravity_torque_from_energy(table, q, g), tau, atol=1e-12)
        np.testing.assert_allclose(reference.mass_matrix(table, q), reference.mass_matrix(urdf, q), atol=1e-12)
        # in the table the offset of 0.1 m along the axes stands in row 2 of either convention
        np.testing.assert_allclose(reference.forward_kinematics(table, q)[:3, 3], tip, atol=1e-12)


@dataclass(frozen=True)
class Drawn:
    """A random tree as URDF text, with a state of each moving joint by name."""

    text: str
    state: dict[str, tuple[float, float]]


TRIPLE = st.tuples(*[grid(-0.5, 0.5)] * 3)
TURN = st.tuples(*[grid(-3.0, 3.0)] * 3)
AXIS = st.tuples(*[st.integers(-3, 3)] * 3).filter(any)
KIND = st.sampled_from(("revolute", "continuous", "prismatic", "fixed"))


def words(values: tuple[float, ...]) -> str:
    return " ".join(map(repr, values))


@st.composite
def link_text(draw: st.DrawFn, name: str) -> str:
    a, b, c = (value**2 for value in draw(st.tuples(*[grid(0.05, 0.5)] * 3)))
    mass = draw(grid(0.1, 5.0))
    inertia = f'ixx="{mass * (b + c)}" ixy="0" ixz="0" iyy="{mass * (a + c)}" iyz="0" izz="{mass * (a + b)}"'
    origin = f'<origin xyz="{words(draw(TRIPLE))}" rpy="{words(draw(TURN))}"/>'
    return f'<link name="{name}"><inertial>{origin}<mass value="{mass}"/><inertia {inertia}/></inertial></link>'


@st.composite
def trees(draw: st.DrawFn) -> Drawn:
    text, state = ['<robot name="tree"><link name="l0"/>'], {}
    for index in range(1, draw(st.integers(2, 7))):
        kind = "revolute" if index == 1 else draw(KIND)
        origin = f'<origin xyz="{words(draw(TRIPLE))}" rpy="{words(draw(TURN))}"/>'
        ends = f'<parent link="l{draw(st.integers(0, index - 1))}"/><child link="l{index}"/>'
        rest = f'{origin}<axis xyz="{words(draw(AXIS))}"/><limit lower="-9" upper="9" effort="1" velocity="1"/>'
        text += [draw(link_text(f"l{index}")), f'<joint name="j{index}" type="{kind}">{ends}{rest}</joint>']
        if kind != "fixed":
            state[f"j{index}"] = draw(st.tuples(grid(-3.0, 3.0), grid(-2.0, 2.0)))
    return Drawn("\n".join([*text, "</robot>"]), state)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(drawn=trees())
def test_mujoco_reads_the_same_robot(read, drawn: Drawn) -> None:
    """Forces at rest and in motion (gravity, Coriolis) and the mass matrix of random trees, to 1e-10."""
    mujoco = pytest.importorskip("mujoco")
    spec = read(drawn.text)
    model = mujoco.MjModel.from_xml_string(drawn.text)
    data = mujoco.MjData(model)
    names = spec.coordinate_names
    assert set(names) == set(drawn.state)
    order = [model.jnt_dofadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)] for name in names]
    q, qd = np.array([drawn.state[name] for name in names]).T
    data.qpos[order], data.qvel[order] = q, qd
    mujoco.mj_forward(model, data)
    mass_matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass_matrix)
    still = np.zeros(len(names))
    f = -model.opt.gravity
    ours = reference.inverse_dynamics(spec, q, qd, still, f, np.zeros(3), np.zeros(3))
    scale = 1.0 + np.abs(ours).max()
    np.testing.assert_allclose(ours, data.qfrc_bias[order], atol=1e-10 * scale)
    np.testing.assert_allclose(reference.mass_matrix(spec, q), mass_matrix[np.ix_(order, order)], rtol=1e-9, atol=1e-10)


BAD = [
    (
        "<robot",
        "<!DOCTYPE robot [<!ENTITY a 'b'>]>\n<robot",
        ParseError,
        "<!DOCTYPE ...> (and with it <!ENTITY ...>) is refused",
    ),
    ("<robot", "<!ENTITY a 'b'>\n<robot", ParseError, "not valid XML"),
    (
        'version="1.0"',
        'version="1.0" encoding="klingon"',
        ParseError,
        "encoding 'klingon' is not read; save the file as UTF-8",
    ),
    ('version="1.0"', 'version="1.0" encoding="euc-jp"', ParseError, "encoding 'euc-jp' is not read"),
    ('version="1.0"', 'version="1.0" encoding="unicode_escape"', ParseError, "encoding 'unicode_escape' is not read"),
    ('<link name="tool"/>', "<a>" * 64 + "</a>" * 64, ParseError, "nested more than 64 deep"),
    ('<link name="tool"/>', "<a/>" * 100_001, ParseError, "more than 100000 elements"),
    ('<link name="tool"/>', "<link", ParseError, "not valid XML: not well-formed"),
    ('<link name="tool"/>', "<xacro:include filename='x'/>", ParseError, "xacro robot.xacro > robot.urdf"),
    ('<link name="tool"/>', "", ModelError, "<child>: there is no link 'tool'"),
    ('<link name="tool"/>', '<link name="tool"/><link name="lost"/>', ModelError, "2 roots, 'stand', 'lost'"),
    ('<link name="tool"/>', '<link name="upper"/><link name="tool"/>', ModelError, "'upper' stands in line 13 already"),
    ('<link name="tool"/>', '<link name=""/>', ConfigError, "attribute 'name' is missing"),
    ('"upper"/><child link="tool"', '"tool"/><child link="tool"', ModelError, "'tool' form a loop"),
    ('"upper"/><child link="tool"', '"tool"/><child link="upper"', ModelError, "'upper' hangs on joint 'turn' already"),
    ('"upper"/><child link="tool"', '"uper"/><child link="tool"', ModelError, "did you mean 'upper'"),
    ('<parent link="upper"/><child link="tool"/>', '<child link="tool"/>', ConfigError, "'flange' has no <parent"),
    ('"continuous"', '"floating"', ModelError, "'turn': type 'floating' is not a joint of an arm"),
    ('"continuous"', '"planar"', ModelError, "'turn': type 'planar' has two coordinates"),
    ('"continuous"', '"revolut"', ModelError, "did you mean 'revolute'"),
    ('"continuous"', '""', ConfigError, "attribute 'type' is missing"),
    ('<axis xyz="0 2 0"/>', '<axis xyz="0 0 0"/>', ModelError, "'turn': axis: (0.0, 0.0, 0.0) has no direction"),
    ('<axis xyz="0 2 0"/>', '<axis xyz="0 2"/>', ConfigError, "<axis>: xyz: got '0 2', expected 3 finite numbers"),
    ('<axis xyz="0 2 0"/>', '<axis xyz="0 inf 0"/>', ConfigError, "<axis>: xyz: got '0 inf 0'"),
    ('<axis xyz="0 2 0"/>', '<axis xyz="0 1_0 0"/>', ConfigError, "<axis>: xyz: got '0 1_0 0'"),
    ('rpy="0 1.5 0"', 'rpy="0 ${pi} 0"', ConfigError, "looks like xacro"),
    ('rpy="0 1.5 0"', 'rpy="0 90 0"', ModelError, "<origin>: rpy: 90 rad is more than a turn"),
    ('joint="open"', 'joint="opne"', ModelError, "<mimic> of joint 'mirror': there is no moving joint 'opne'; did you"),
    ('joint="open"', 'joint="mount"', ModelError, "there is no moving joint 'mount'"),
    ('joint="open"', 'joint="third"', ModelError, "mimic each other in a circle"),
    ('multiplier="-1"', 'multiplier="x"', ConfigError, "<mimic>: multiplier: got 'x', expected a finite number"),
    ('lower="0" upper="0.04"', 'lower="1" upper="0.04"', LimitError, "limits.lower: 1.0 is not below upper, 0.04"),
    ('effort="5"', 'effort="-5"', LimitError, "limits.effort: got -5.0, expected more than 0"),
    ('<mass value="0.1"/>', '<mass value="-0.1"/>', ModelError, "'left': mass: got -0.1"),
    ('<mass value="0.1"/>', "<mass/>", ConfigError, "<mass>: attribute 'value' is missing"),
    ('<mass value="0.1"/>', "", ConfigError, "link 'left': <mass .../> is missing"),
    ('<mass value="0.1"/>', '<mass value="0"/>', ModelError, "without mass, expected none"),
    ('iyy="0.2"', 'iyy="0.9"', ModelError, "'upper': inertia: got"),
    ('ixx="1"', 'ixx=""', ConfigError, "attribute 'ixx' is missing"),
]


@pytest.mark.parametrize(("old", "new", "error", "expected"), BAD)
def test_what_is_wrong_is_named_with_its_line(
    read, old: str, new: str, error: type[RavenGCError], expected: str
) -> None:
    assert old in GRIPPER
    with pytest.raises(error) as caught:
        read(GRIPPER.replace(old, new, 1))
    assert type(caught.value) is error
    assert re.match(r".*/robot\.urdf:[0-9]+:", str(caught.value))
    assert expected in str(caught.value)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"", "no element found"),
        (b"<sdf/>", r"<sdf> \(an SDF, not a URDF\), expected <robot>"),
        (b"<robot/>", "there is no <link>"),
        (b'<robot><link name="a"/></robot>', "0 moving links"),
        (b" " * (8 * 1024 * 1024 + 1), "larger than 8 MiB"),
        (b"\xff\xfe<\x00", "not valid XML"),
    ],
)
def test_what_is_no_urdf_is_refused(read, data: bytes, expected: str) -> None:
    with pytest.raises((ParseError, ModelError), match=expected):
        read(data)


def test_a_loop_without_a_root_is_refused(read) -> None:
    joints = "".join(
        f'<joint name="{parent}{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        for parent, child in ("ab", "ba")
    )
    with pytest.raises(ModelError, match="the links form a loop"):
        read(f'<robot name="r"><link name="a"/><link name="b"/>{joints}</robot>')


def test_a_long_chain_of_frames_is_read_and_a_long_chain_of_joints_refused(read) -> None:
    def chain(kinds: list[str]) -> str:
        links = "".join(f'<link name="l{i}"/>' for i in range(len(kinds) + 1))
        joints = "".join(
            f'<joint name="j{i}" type="{kind}"><parent link="l{i}"/><child link="l{i + 1}"/></joint>'
            for i, kind in enumerate(kinds)
        )
        return f'<robot name="chain">{links}{joints}</robot>'

    assert len(read(chain(["revolute"] + ["fixed"] * 5000)).links) == 5001
    with pytest.raises(ModelError, match="17 moving links"):
        read(chain(["revolute"] * 17))


def test_a_urdf_is_loaded_by_its_path_and_has_one_set_of_masses(tmp_path: Path) -> None:
    path = tmp_path / "robot.URDF"
    path.write_text(GRIPPER)
    assert spec_for(path) == spec_for(str(path), "default") == spec_from_urdf(path)
    assert replace(spec_for(path), file=None) == spec_for(path)
    with pytest.raises(ConfigError, match="one set of masses"):
        spec_for(path, "cad")


def robot_or_none(path: str) -> RobotSpec | None:
    try:
        return spec_from_urdf(path)
    except RavenGCError:
        return None


@given(damaged(GRIPPER))
def test_any_damaged_text_is_a_robot_or_an_error_of_ours(text: str) -> None:
    with tempfile.NamedTemporaryFile(suffix=".urdf") as file:
        file.write(text.encode("utf-8", errors="surrogatepass"))
        file.flush()
        spec = robot_or_none(file.name)
    assert spec is None or spec_from_toml(spec_to_toml(spec)) == spec


def test_any_truncated_text_is_an_error_of_ours(read) -> None:
    for end in range(0, len(GRIPPER.rstrip()) - 1, 7):
        with pytest.raises(ParseError):
            read(GRIPPER[:end])
