"""The published gravity compensation: its controller to the last digit, what it is worth when tilted, as a robot."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import ravengc
from dvrk_files import FILES, gc_file, written
from ravengc.disturbances import Constant, Friction, LinearSpring, Polynomial
from ravengc.dvrk import (
    Published,
    published_from_robot,
    published_regressor,
    read_published,
    robot_spec_from_published,
    write_published,
)
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.reference import disturbance_torque

if TYPE_CHECKING:
    from pathlib import Path

POSE = np.array((0.0, 0.0, 0.0, 0.0, np.pi / 2.0, 0.0, 0.0))


@pytest.fixture(params=range(5))
def published(request: pytest.FixtureRequest, tmp_path: Path) -> Published:
    return read_published(written(tmp_path, "gc.json", gc_file(request.param)))


def potential(q: np.ndarray, p: np.ndarray) -> complex:
    """The energy of which gravity's columns are derivatives: a plane arm with a wrist, p kg m, angles from q2 on.

    Heights of unit moments: along and across the upper arm, the forearm, and the frames of joints 4, 5 and 6.
    """
    _, q2, q3, q4, q5, q6, _ = q
    a = q2 + q3
    s, c = np.sin, np.cos
    heights = (
        -c(q2), s(q2),
        s(a), c(a),
        s(a) * c(q4), -s(a) * s(q4),
        c(a) * c(q5) - s(a) * c(q4) * s(q5), c(a) * s(q5) + s(a) * c(q4) * c(q5),
        s(a) * s(q4) * s(q6) - c(a) * s(q5) * c(q6) - s(a) * c(q4) * c(q5) * c(q6),
        s(a) * s(q4) * c(q6) + c(a) * s(q5) * s(q6) + s(a) * c(q4) * c(q5) * s(q6),
    )  # fmt: skip
    return 9.81 * sum(height * number for height, number in zip(heights, p, strict=True))


def test_gravity_columns_are_the_gradient_of_an_energy() -> None:
    rng = np.random.default_rng(0)
    for q, p in zip(rng.uniform(-3.0, 3.0, (20, 7)), rng.normal(size=(20, 10)), strict=True):
        steps = 1e-30j * np.eye(7)
        gradient = np.array([potential(q + step, p).imag / 1e-30 for step in steps])
        np.testing.assert_allclose(published_regressor(q)[:, :10] @ p, gradient, atol=1e-12)


def test_regressor_at_a_pose_by_hand() -> None:
    """Entries of the published text at a pose, written out."""
    q2, q3, q4, q5, q6 = 0.3, -0.4, 0.7, 1.1, -0.2
    rows = published_regressor((0.9, q2, q3, q4, q5, q6, 5.0)) / 9.81
    s, c = np.sin, np.cos
    assert rows[3, 8] == pytest.approx(s(q2 + q3) * (c(q4) * s(q6) + c(q5) * c(q6) * s(q4)), abs=1e-15)
    assert rows[4, 6] == pytest.approx(
        -(
            c(q2) * c(q3) * s(q5)
            - s(q2) * s(q3) * s(q5)
            + c(q2) * c(q4) * c(q5) * s(q3)
            + c(q3) * c(q4) * c(q5) * s(q2)
        ),
        abs=1e-15,
    )
    assert rows[5, 9] == pytest.approx(
        c(q2) * c(q3) * c(q6) * s(q5) - c(q2) * s(q3) * s(q4) * s(q6) - c(q3) * s(q2) * s(q4) * s(q6)
        - c(q6) * s(q2) * s(q3) * s(q5) + c(q2) * c(q4) * c(q5) * c(q6) * s(q3) + c(q3) * c(q4) * c(q5) * c(q6) * s(q2),
        abs=1e-15,
    )  # fmt: skip
    assert not rows[6].any()
    np.testing.assert_allclose(rows[0, 10:15] * 9.81, 0.9 ** np.arange(5))


def blended(v: float, dead: float, saturation: float, ratio: float) -> float:
    """The controller's own branches."""
    if v >= saturation:
        return 0.5 + 0.5 * ratio
    if v <= -saturation:
        return 0.5 - 0.5 * ratio
    if -dead <= v <= dead:
        return 0.5
    if v > dead:
        return 0.5 * ratio * (v - dead) / (saturation - dead) + 0.5
    return -0.5 * ratio * (-v - dead) / (saturation - dead) + 0.5


def test_torque_is_the_controllers(published: Published) -> None:
    rng = np.random.default_rng(1)
    for q, qd in zip(rng.uniform(-1.0, 1.0, (50, 7)), rng.normal(0.0, 0.2, (50, 7)), strict=True):
        rows = published_regressor(q)
        rules = zip(qd, published.dead_band, published.saturation, published.ratio, strict=True)
        alpha = np.array([blended(*rule) for rule in rules])
        tau = alpha * (rows @ published.positive) + (1.0 - alpha) * (rows @ published.negative)
        expected = np.minimum(np.maximum(tau, published.lower), published.upper)
        np.testing.assert_allclose(published.torque(q, qd), expected, atol=1e-14)


def test_the_five_files_agree_level_and_disagree_tilted() -> None:
    """Level 0.608 to 0.675 N m; at 10 deg +0.10, -1.70, +3.99, -4.10, -1.17 N m more."""
    changes = {}
    for numbers in FILES:
        report = Published(
            positive=numbers["pos"], negative=numbers["neg"], upper=numbers["safe_upper_torque_limit"],
            lower=numbers["safe_lower_torque_limit"], dead_band=numbers["db_vel_vec"],
            saturation=numbers["sat_vec_vec"], ratio=numbers["fric_comp_ratio_vec"], arm=numbers["arm"],
        ).on_tilt()  # fmt: skip
        assert 0.607 < report.level < 0.676
        changes[numbers["serial"]] = round(report.change, 2)
    assert changes == {"22723": 0.10, "28247": -1.70, "30924": 3.99, "34863": -4.10, "32336": -1.17}


def test_a_tilted_base_is_flagged_with_the_numbers(published: Published) -> None:
    level = published.torque(POSE, gravity=(0.0, 0.0, -9.81))
    np.testing.assert_array_equal(level, published.torque(POSE))
    tilted = (0.0, -9.81 * np.sin(np.radians(10.0)), -9.81 * np.cos(np.radians(10.0)))
    with pytest.raises(ConfigError, match=r"tilted by 10\.0 deg.*N m more.*-4\.1 \.\.\. \+4\.0 N m"):
        published.torque(POSE, gravity=tilted)
    with pytest.raises(ConfigError, match="180"):
        published.torque(POSE, gravity=(0.0, 0.0, 9.81))
    for size in (0.0, 1.62, 12.0):
        with pytest.raises(ConfigError, match=r"its first moments are for 9\.81, at rest"):
            published.torque(POSE, gravity=(0.0, 0.0, -size))


def test_as_a_robot_it_gives_the_same_torques(published: Published) -> None:
    mtm = ravengc.load(f"dvrk_{published.arm.lower()}").spec
    spec = robot_spec_from_published(published, mtm)
    robot = ravengc.Robot(replace(spec, disturbances=()))
    rng = np.random.default_rng(2)
    for q, qd in zip(rng.uniform(-1.2, 1.2, (20, 7)), rng.normal(0.0, 0.2, (20, 7)), strict=True):
        gravity = robot.gravity_torque(q, (0.0, 0.0, -9.81))
        rows, alpha = published_regressor(q), published.blend(qd)
        expected = alpha * (rows @ published.positive) + (1.0 - alpha) * (rows @ published.negative)
        np.testing.assert_allclose(gravity + disturbance_torque(spec, q, qd), expected, atol=1e-10)
    assert "LEVEL BASE ONLY" in spec.description


def test_there_and_back(published: Published, tmp_path: Path) -> None:
    mtm = ravengc.load(f"dvrk_{published.arm.lower()}").spec
    back = published_from_robot(robot_spec_from_published(published, mtm))
    np.testing.assert_allclose(back.positive, published.positive, atol=1e-9)
    np.testing.assert_allclose(back.negative, published.negative, atol=1e-9)
    for name in ("dead_band", "saturation", "ratio"):
        np.testing.assert_array_equal(getattr(back, name)[:6], getattr(published, name)[:6])
    path = tmp_path / "back.json"
    write_published(published, path)
    again = read_published(path)
    for name in ("positive", "negative", "lower", "upper", "dead_band", "saturation", "ratio"):
        np.testing.assert_array_equal(getattr(again, name), getattr(published, name))
    assert (again.arm, again.serial) == (published.arm, published.serial)


def test_a_tilted_robot_of_a_file_shows_what_it_is_worth(published: Published) -> None:
    """The robot's masses turn with gravity: joint 2 changes by what the report says."""
    spec = robot_spec_from_published(published, ravengc.load(f"dvrk_{published.arm.lower()}").spec)
    robot, angle = ravengc.Robot(replace(spec, disturbances=())), np.radians(10.0)
    level = robot.gravity_torque(POSE, (0.0, 0.0, -9.81))
    change = robot.gravity_torque(POSE, 9.81 * np.array((0.0, np.sin(angle), -np.cos(angle)))) - level
    assert change[1] == pytest.approx(published.on_tilt().change, abs=1e-9)


def test_export_knows_springs_and_constants() -> None:
    mtm = ravengc.load("dvrk_mtmr").spec
    elements = (
        Constant(name="offset", joint="shoulder_pitch", torque=-0.3),
        LinearSpring(name="spring", joint="wrist_pitch", stiffness=0.2, rest=0.5),
        Polynomial(name="cable", joint="wrist_platform", coefficients=(0.1, 0.0, 0.3)),
    )
    spec = replace(mtm, disturbances=elements)
    published, robot = published_from_robot(spec), ravengc.Robot(mtm)
    q = np.array((0.1, 0.2, -0.3, 0.4, 0.5, -0.6, 0.7))
    expected = robot.gravity_torque(q, (0.0, 0.0, -9.81)) + disturbance_torque(spec, q)
    np.testing.assert_allclose(published_regressor(q) @ published.positive, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("element", "said"),
    [
        (Friction(name="rub", joint="wrist_pitch", coulomb=0.1), "'rub' has no place"),
        (Constant(name="last", joint="wrist_roll", torque=0.1), "'last' has no place"),
        (Polynomial(name="long", joint="wrist_pitch", coefficients=(0.0,) * 6), "'long' has no place"),
        (Polynomial(name="held", joint="wrist_pitch", coefficients=(1.0,), range=(0.0, 1.0)), "'held' has no place"),
        (LinearSpring(name="bar", joint="wrist_pitch", of="wrist_yaw", stiffness=1.0), "'bar' has no place"),
    ],
)
def test_export_refuses_what_the_file_cannot_say(element: Any, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        published_from_robot(replace(ravengc.load("dvrk_mtmr").spec, disturbances=(element,)))


def test_export_refuses_what_blends_otherwise() -> None:
    mtm = ravengc.load("dvrk_mtmr").spec
    pair = [
        Polynomial(name=way, joint="wrist_pitch", coefficients=(0.1,), direction=way, dead_band=0.01)  # type: ignore[arg-type]
        for way in ("positive", "negative")
    ]
    assert published_from_robot(replace(mtm, disturbances=tuple(pair))).dead_band[4] == 0.01
    for wrong in ({"dead_band": 0.02}, {"saturation": 0.3}, {"ratio": 0.5}, {"blend": "tanh"}):
        with pytest.raises(ConfigError, match="polynomials of wrist_pitch blend otherwise"):
            published_from_robot(replace(mtm, disturbances=(pair[0], replace(pair[1], **wrong))))  # type: ignore[arg-type]


def test_export_refuses_a_clip_at_nothing() -> None:
    mtm = ravengc.load("dvrk_mtmr").spec
    weak = replace(mtm.links[1], limits=replace(mtm.links[1].limits, effort=None))
    with pytest.raises(ConfigError, match="'shoulder_pitch' has no limit of its effort"):
        published_from_robot(replace(mtm, links=(mtm.links[0], weak, *mtm.links[2:])))


def test_export_refuses_a_mass_beside_the_last_axis() -> None:
    mtm = ravengc.load("dvrk_mtmr").spec
    last = replace(mtm.links[-1], mass=0.1, com=(0.02, 0.0, 0.0), massless=False)
    with pytest.raises(ConfigError, match="no mass beside the axis"):
        published_from_robot(replace(mtm, links=(*mtm.links[:-1], last)))
    for other in ("panda", "rrbot"):
        with pytest.raises(ConfigError):
            published_from_robot(ravengc.load(other).spec)


def test_directions_with_different_gravity_are_no_masses(tmp_path: Path) -> None:
    negative = [*FILES[3]["neg"]]
    negative[4] += 0.1
    published = read_published(written(tmp_path, "gc.json", gc_file(gc_dynamic_params_neg=negative)))
    with pytest.raises(ConfigError, match=r"parameter 5 is .* in the two directions"):
        robot_spec_from_published(published, ravengc.load("dvrk_mtml").spec)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"gc_dynamic_params_pos": None}, "'gc_dynamic_params_pos' is missing, expected 40 numbers"),
        ({"gc_dynamic_params_pos": [0.0] * 39}, "expected 40 numbers, not 39"),
        ({"db_vel_vec": [0.1] * 6 + ["a"]}, r"db_vel_vec: got .*'a'.*expected 7 numbers without"),
        ({"db_vel_vec": 3}, "expected 7 numbers"),
        (
            {"sat_vec_vec": [0.2] * 6 + [0.001]},
            r"sat_vec_vec\[6\] is 0.001, expected more than the dead band \(joint 7",
        ),
        ({"fric_comp_ratio_vec": [0.2] * 6 + [80]}, r"fric_comp_ratio_vec\[6\] is 80, expected 0 to 1"),
        ({"db_vel_vec": [-0.02] * 7}, r"db_vel_vec\[0\] is -0.02, expected 0 or more"),
        ({"safe_upper_torque_limit": [-9.0] * 7}, r"safe_upper_torque_limit\[0\] is -9, expected no less"),
        ({"gc_dynamic_params_neg": [1e30] * 40}, "at most 1e"),
    ],
)
def test_bad_files_say_where_and_what(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    with pytest.raises((ConfigError, ArgumentError), match=said):
        read_published(written(tmp_path, "gc.json", gc_file(**changes)))


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({"version": "2.0"}, "'GC_controller' is missing"),
        (gc_file() | {"version": "1.0"}, "version is '1.0', expected version 2.0"),
        ({key: value for key, value in gc_file().items() if key != "version"}, "version is None"),
        (gc_file() | {"GC_controller": []}, "expected a table"),
        (gc_file() | {"ARM_NAME": "PSM1"}, "arm is 'PSM1'; expected MTML or MTMR"),
        (gc_file() | {"ARM_NAME": 4}, "expected a text"),
        (gc_file() | {"SN": [30924]}, r"SN: got \[30924\], expected a serial number"),
        (gc_file() | {"SN": True}, "SN: got True, expected a serial number"),
    ],
)
def test_files_that_are_something_else(tmp_path: Path, data: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        read_published(written(tmp_path, "gc.json", data))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not JSON"),
        ('{"version": ', "gc.json:1:"),
        ("[]", "holds a list"),
        ('{"version": NaN}', "NaN is not a number"),
        ('{"version": 1' + "0" * 5000 + "}", "not JSON"),
        ("[" * 100_000, "not JSON"),
        (json.dumps(gc_file())[:-30], "not JSON"),
        ("/* never ends", "not JSON"),
    ],
)
def test_files_that_cannot_be_read(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ParseError, match=said):
        read_published(written(tmp_path, "gc.json", text))
