"""Logs that are not what they seem: each is refused or repaired by a message that names the cause and the remedy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import ravengc as rg
from identify_logs import Table, moved, stood, write_csv
from ravengc import identify
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.identify import Model, parted, prepared, read_log, tilted_sd

if TYPE_CHECKING:
    from pathlib import Path

UR5, RAVEN, MTM = rg.load("ur5"), rg.load("raven2_gold"), rg.load("dvrk_mtmr")
MOTION, POSES = moved(UR5), moved(RAVEN)


def spoilt(tmp_path: Path, table: Table, robot: rg.Robot = UR5, *units: str) -> str:
    """What is said against a log."""
    with pytest.raises((ConfigError, ParseError)) as caught:
        read_log(robot, write_csv(tmp_path / "log.csv", table), units)
    return str(caught.value)


def test_a_sound_log_is_taken_as_it_is(tmp_path: Path) -> None:
    log = read_log(UR5, write_csv(tmp_path / "log.csv", MOTION))
    np.testing.assert_allclose(log.q, MOTION["q"])
    np.testing.assert_allclose(log.tau, MOTION["tau"])
    assert not log.skipped
    assert not log.notes
    assert log.robot == "ur5"


def test_a_joint_whose_torque_was_not_recorded_is_noted(tmp_path: Path) -> None:
    tau = MOTION["tau"] * (np.arange(6) != 2)
    path = write_csv(tmp_path / "log.csv", {**MOTION, "tau": tau})
    (note,) = read_log(UR5, path).notes
    assert f"the torque of joint 'elbow' is 0 in all {len(tau)} rows: if it was not recorded" in note
    others = [name for name in UR5.spec.coordinate_names if name != "elbow"]
    assert not read_log(UR5, path, counted=others).notes
    flat = {**MOTION, "q": np.zeros_like(tau), "tau": np.tile(MOTION["tau"][0], (len(tau), 1))}
    assert not read_log(UR5, write_csv(tmp_path / "flat.csv", flat)).notes, "no torque changes while the arm stands"


def test_a_log_without_torques_says_which_columns_are_missing(tmp_path: Path) -> None:
    said = spoilt(tmp_path, {"t": MOTION["t"], "q": MOTION["q"]})
    assert "no torques" in said
    assert "tau1 tau2" in said


def test_degrees_that_were_said_of_rad_are_refused(tmp_path: Path) -> None:
    said = spoilt(tmp_path, MOTION, UR5, "deg")
    assert "degrees, but all stay within their limits if the file is in rad: leave out 'deg'" in said


def test_what_no_unit_explains_is_no_matter_of_units(tmp_path: Path) -> None:
    """A sign or an order: small numbers are within limits in every larger unit."""
    sign = np.array([1.0, -1.0, 1.0])
    turned = {**POSES, "q": POSES["q"] * sign, "dq": POSES["dq"] * sign}
    log = read_log(RAVEN, write_csv(tmp_path / "log.csv", turned), ("joint",))
    assert any("is its zero that of the robot's file" in note for note in log.notes)


@pytest.mark.parametrize(
    ("robot", "table", "change", "word"),
    [
        (RAVEN, POSES, {"q": np.array([180.0 / np.pi, 180.0 / np.pi, 1.0])}, "degrees (--units deg)"),
        (RAVEN, POSES, {"q": np.array([1.0, 1.0, 1000.0])}, "millimetres (--units mm)"),
        (UR5, MOTION, {"tau": np.full(6, 1000.0)}, "--units mNm"),
        (UR5, MOTION, {"tau": np.full(6, 0.01)}, "motor torques or currents"),
        (UR5, MOTION, {"tau": np.full(6, -1.0)}, "opposite to what holds the arm up"),
        (UR5, MOTION, {"dq": np.full(6, 180.0 / np.pi)}, "they are in deg/s and the positions are not"),
        (UR5, MOTION, {"dq": np.full(6, -1.0)}, "sign turned round"),
        (UR5, MOTION, {"dq": np.full(6, 100.0)}, "at the motor side"),
    ],
)
def test_another_unit_is_named(
    tmp_path: Path, robot: rg.Robot, table: Table, change: dict[str, np.ndarray], word: str
) -> None:
    wrong = {name: values * change[name] if name in change else values for name, values in table.items()}
    said = spoilt(tmp_path, wrong, robot)
    assert word in said, said
    assert "log.csv" in said


def test_what_is_said_of_the_units_is_done(tmp_path: Path) -> None:
    turned = np.array([180.0 / np.pi, 180.0 / np.pi, 1000.0])
    table = {"t": POSES["t"], "q": POSES["q"] * turned, "dq": POSES["dq"] * turned, "tau": POSES["tau"]}
    log = read_log(RAVEN, write_csv(tmp_path / "log.csv", table), ("deg", "mm"))
    np.testing.assert_allclose(log.q, POSES["q"], atol=1e-8)
    table = MOTION | {"tau": 1000.0 * MOTION["tau"]}
    np.testing.assert_allclose(read_log(UR5, write_csv(tmp_path / "log.csv", table), ("mNm",)).tau, MOTION["tau"])


def test_the_motor_side_is_named_and_taken_through_the_transmission(tmp_path: Path) -> None:
    motors = np.array([RAVEN.motor_positions(q) for q in POSES["q"]])
    tau = np.array([RAVEN.actuator_torque(row) for row in POSES["tau"]])
    table = {"t": POSES["t"], "q": motors, "tau": tau}
    assert "at the motors (--units motor)" in spoilt(tmp_path, table, RAVEN)
    log = read_log(RAVEN, write_csv(tmp_path / "log.csv", table), ("motor",))
    np.testing.assert_allclose(log.q, POSES["q"], atol=1e-6)
    np.testing.assert_allclose(log.tau, POSES["tau"], atol=1e-6)


@pytest.mark.parametrize(("factor", "word"), [(1 / 9.80665, "--units g"), (100.0, "--units cm/s^2"), (0.5, "at rest")])
def test_a_norm_that_is_not_g_is_named(tmp_path: Path, factor: float, word: str) -> None:
    table = stood(MTM, 10.0, 2)
    said = spoilt(tmp_path, table | {"a": factor * table["a"]}, MTM)
    assert "norm of the gravity columns" in said
    assert word in said


def test_gravity_with_the_sign_of_an_accelerometer_is_named(tmp_path: Path) -> None:
    table = stood(MTM, 10.0, 2)
    wrong = {"t": table["t"], "q": table["q"], "tau": table["tau"], "g": table["a"]}
    assert "call them ax ay az" in spoilt(tmp_path, wrong, MTM)


def test_a_scale_that_is_off_is_noted_because_torques_do_not_show_it(tmp_path: Path) -> None:
    table = stood(MTM, 10.0, 2)
    log = read_log(MTM, write_csv(tmp_path / "log.csv", table | {"a": 1.03 * table["a"]}))
    assert any("its scale is 1.030" in note and "torques cannot tell" in note for note in log.notes)


def test_rows_that_repeat_are_left_out_and_counted(tmp_path: Path) -> None:
    """The recorder ran faster than the robot: 13 of 100 rows bring nothing new."""
    twice = np.sort(np.concatenate([np.arange(600), np.arange(0, 600, 8)]))
    table = {name: values[twice] for name, values in MOTION.items()} | {"t": np.arange(len(twice)) / 50.0}
    log = read_log(UR5, write_csv(tmp_path / "log.csv", table))
    assert dict(log.skipped) == {"row that repeats the readings of the one before": 75}
    assert log.samples == 600


def test_rows_without_numbers_and_a_cut_line_are_left_out_and_counted(tmp_path: Path) -> None:
    tau = MOTION["tau"].copy()
    tau[[5, 9], 2] = np.nan
    log = read_log(UR5, write_csv(tmp_path / "log.csv", MOTION | {"tau": tau}, end=""))
    assert dict(log.skipped) == {"missing or non-finite number": 2, "last line without a line end": 1}
    with pytest.raises(ParseError, match="rows would be skipped"):
        read_log(UR5, str(tmp_path / "log.csv"), strict=True)


def test_stamps_must_increase(tmp_path: Path) -> None:
    t = MOTION["t"].copy()
    t[40] = t[39]
    log = read_log(UR5, write_csv(tmp_path / "log.csv", MOTION | {"t": t}))
    assert dict(log.skipped) == {"repeated time stamp": 1}
    t[40] = t[30]
    assert "time runs backwards at line 42" in spoilt(tmp_path, MOTION | {"t": t})


def test_beyond_its_limits_without_a_reason_is_a_note(tmp_path: Path) -> None:
    q = POSES["q"] + np.array([2.0, 0.0, 0.0])
    tau = RAVEN.gravity_torque_batch(q, [0.0, 0.0, -9.80665])
    log = read_log(RAVEN, write_csv(tmp_path / "log.csv", {"t": POSES["t"], "q": q, "tau": tau}), ("rad", "joint"))
    assert any("joint 'shoulder' runs from" in note and "is its zero" in note for note in log.notes)


def test_the_noise_of_a_sensor_is_no_tilt(tmp_path: Path) -> None:
    table = stood(MTM, 0.0, 1, noise=0.02)
    log = read_log(MTM, write_csv(tmp_path / "log.csv", table))
    assert any("taken as standing there, with gravity along the axis of joint 1" in note for note in log.notes)
    found = identify.identify(MTM, log, Model())
    assert found.rank == 12
    sd = tilted_sd(found, log.q[:20], 0.17)
    assert np.isinf(sd[0])
    assert np.isfinite(sd[1:]).all()


def test_a_tilt_that_was_said_is_the_field_of_the_whole_log(tmp_path: Path) -> None:
    table = {"t": MOTION["t"], "q": MOTION["q"], "tau": MOTION["tau"]}
    path = write_csv(tmp_path / "log.csv", table)
    log = read_log(UR5, path, gravity=(0.0, -1.0, -9.75))
    np.testing.assert_allclose(
        log.specific_force[7] / 9.80665, np.array([0.0, 1.0, 9.75]) / np.hypot(1.0, 9.75), atol=1e-3
    )
    posed = write_csv(tmp_path / "posed.csv", stood(UR5, 10.0, 2))
    with pytest.raises(ConfigError, match="has gravity columns of its own"):
        read_log(UR5, posed, gravity=(0.0, 0.0, -9.8))


@pytest.mark.parametrize(
    ("units", "said"),
    [
        (("degs",), "did you mean 'deg'"),
        (("deg", "rad"), "exclude each other"),
        (("deg", "motor"), "motor positions are in rad"),
    ],
)
def test_units_that_are_none(tmp_path: Path, units: tuple[str, ...], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        read_log(RAVEN, write_csv(tmp_path / "log.csv", POSES), units)


# Prepared for a model


def test_a_motion_is_filtered_and_poses_are_not(tmp_path: Path) -> None:
    log = read_log(UR5, write_csv(tmp_path / "log.csv", MOTION))
    for kind in ("gravity+friction", "dynamics"):
        calm = prepared(log, Model(kind=kind))
        assert calm.cutoff_hz == pytest.approx(5.0)
        assert calm.qdd is not None
    assert prepared(log, Model(kind="dynamics"), 3.0).cutoff_hz == 3.0
    assert prepared(log, Model()).cutoff_hz is None
    posed = read_log(MTM, write_csv(tmp_path / "posed.csv", stood(MTM, 10.0, 2)))
    assert "no velocities" in prepared(posed, Model()).notes[-1]
    with pytest.raises(ConfigError, match="no velocities and accelerations"):
        prepared(posed, Model(kind="dynamics"))
    with pytest.raises(ConfigError, match="no accelerations"):
        prepared(log, Model(kind="dynamics"), None)


def test_no_filter_reaches_across_a_gap(tmp_path: Path) -> None:
    t = MOTION["t"] + np.where(np.arange(600) > 300, 4.0, 0.0)
    log = read_log(UR5, write_csv(tmp_path / "log.csv", MOTION | {"t": t}))
    with pytest.raises(ConfigError, match=r"4.02 s without a sample after 6 s.*as two logs"):
        prepared(log, Model(kind="dynamics"))


def test_poses_passed_both_ways_are_averaged() -> None:
    log = read_log(MTM, "example:mtmr_tilts")
    poses = prepared(log, Model())
    assert poses.samples == 100
    assert "friction cancels" in poses.notes[-1]
    train, held = parted(poses, 0.3)
    assert (train.samples, held.samples) == (70, 30)
    assert len(np.unique(np.round(held.base[:, :2] / 1.7), axis=0)) == 5, "every attitude is in what is held out"


def test_the_end_of_a_motion_is_held_out(tmp_path: Path) -> None:
    log = read_log(UR5, write_csv(tmp_path / "log.csv", MOTION))
    train, held = parted(log, 0.25)
    assert (train.samples, held.samples) == (450, 150)
    assert train.stamps[-1] < held.stamps[0]
    with pytest.raises(ArgumentError, match="share is 0"):
        parted(log, 0.0)
    with pytest.raises(ArgumentError, match="too few"):
        parted(log.take(slice(0, 1)), 0.3)


def test_more_tilts_make_the_torque_on_a_tilted_base_surer() -> None:
    """Joint 1 of a master arm: unknown from a level base, known from one that tilts."""
    sizes = {}
    for name in ("mtmr_level", "mtmr_tilts"):
        poses = prepared(read_log(MTM, f"example:{name}"), Model())
        found = identify.identify(MTM, poses, Model())
        sizes[name] = tilted_sd(found, poses.q, np.radians(10.0))
    assert np.isinf(sizes["mtmr_level"][0])
    assert sizes["mtmr_tilts"].max() < 0.005


def rested(robot: rg.Robot, poses: int, both: bool) -> Table:
    """A recorder that runs at 50 Hz while the arm goes from pose to pose, stays 0.6 s, and overshoots to come back."""
    random = np.random.default_rng(8)
    limits = [(limit.lower or 0.0, limit.upper or 0.0) for limit in robot.spec.coordinate_limits]
    q = [np.mean(limits, axis=1)]
    came = [np.zeros(robot.n)]
    for _ in range(poses):
        pose = np.array([random.uniform(*limit) for limit in limits])
        for way in (1.0, -1.0) if both else (1.0,):
            away = pose - 0.1 * way
            q += [q[-1] + share * (away - q[-1]) for share in np.linspace(0.05, 1.0, 40)]
            q += [away + share * (pose - away) for share in np.linspace(0.1, 1.0, 10)]
            q += [pose] * 30
            came += [np.full(robot.n, way)] * 80
    positions, ways = np.array(q), np.array(came)
    tau = robot.gravity_torque_batch(positions, [0.0, 0.0, -9.80665]) + 0.5 * ways
    noise = random.normal(size=(2, *tau.shape))
    return {"t": np.arange(len(q)) / 50.0, "q": positions + 2e-4 * noise[0], "tau": tau + 0.01 * noise[1]}


def test_the_rests_of_a_motion_are_poses_with_the_way_by_which_the_arm_came(tmp_path: Path) -> None:
    log = read_log(RAVEN, write_csv(tmp_path / "log.csv", rested(RAVEN, 12, both=True)))
    poses = prepared(log, Model())
    assert poses.samples == 12
    assert [note.partition(":")[0] for note in poses.notes[-2:]] == [
        "the arm rests 24 times",
        "12 poses approached from both sides",
    ]
    np.testing.assert_allclose(
        poses.tau, RAVEN.gravity_torque_batch(poses.q, [0.0, 0.0, -9.80665]), atol=0.02
    )  # without the 0.5 N m of friction
    one_way = prepared(read_log(RAVEN, write_csv(tmp_path / "one.csv", rested(RAVEN, 12, both=False))), Model())
    assert one_way.samples == 12
    assert "no pose was approached from both sides" in one_way.notes[-1]
    assert "sample by sample" in prepared(log.take(slice(0, 300)), Model()).notes[-1]
    with pytest.raises(ArgumentError, match=r"never rests for 0.3 s"):
        identify.rests(log.take(slice(0, 40)))
