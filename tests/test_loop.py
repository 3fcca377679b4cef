"""The control loop, its laws, its trajectory, the log and the summary."""

from __future__ import annotations

import gc
import os
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import ravengc
from loop_parts import GAINS, TILTED, Integrator, Tilted, loop_on, still
from ravengc.control import (
    LAWS,
    Controller,
    derived_drive,
    drive_for,
    raven2_drive,
)
from ravengc.coordinates import sliding
from ravengc.errors import ArgumentError, ConfigError, LimitError, TimingError
from ravengc.log import read_log, write_log
from ravengc.loop import ControlLoop, Record
from ravengc.reports.run_summary import rms, summarise
from ravengc.spec import DhRow, JointLimits, LinkSpec, RobotSpec
from ravengc.trajectory import JointSwing, swing_within_limits
from strategies import coordinates, robots

if TYPE_CHECKING:
    from pathlib import Path

LEVEL = np.array((0.0, 0.0, -ravengc.STANDARD_GRAVITY))


@pytest.mark.parametrize("rate_hz", [250.0, 1000.0, 1300.0])
def test_an_unpaced_loop_runs_every_cycle_on_the_grid(rate_hz: float) -> None:
    plant = Integrator()
    record = loop_on(plant, rate_hz=rate_hz).run()
    assert record.count == round(0.1 * rate_hz) == plant.steps
    assert record.time[: record.count] == pytest.approx(np.arange(record.count) / rate_hz)
    assert plant.time == pytest.approx(record.count / rate_hz)
    assert (record.skipped, record.late.any(), record.interrupted) == (0, False, False)
    assert {len(column) for column in record.columns().values()} == {record.count}


def test_a_record_holds_what_the_law_was_given_and_gave() -> None:
    record = loop_on(Integrator(), "pd+dg").run()
    robot = ravengc.load("rrbot")
    for q, qd, tau_pd, tau_gravity, tau in zip(
        record.q, record.qd, record.tau_pd, record.tau_gravity, record.tau, strict=True
    ):
        assert tau_pd == pytest.approx(-GAINS.kp * q - GAINS.kd * qd)
        assert tau_gravity == pytest.approx(robot.gravity_torque(q, TILTED))
        assert tau == pytest.approx(tau_pd + tau_gravity)
    assert (record.gravity == TILTED).all()
    assert (record.compute_ns > 0).all()


def test_a_stall_skips_cycles_and_the_plant_goes_on() -> None:
    plant = Integrator(lambda step: time.sleep(0.02) if step == 10 else None)
    record = loop_on(plant, paced=True, rate_hz=1000.0).run()
    assert record.count + record.skipped == 100
    assert record.skipped >= 19
    assert record.late[: record.count].any()
    assert plant.time == pytest.approx(0.1)
    steps = np.diff(np.rint(1e3 * record.time[: record.count]))
    assert steps.min() >= 1.0
    assert steps.max() >= 20.0


def test_a_plant_slower_than_the_clock_does_not_hang_the_loop() -> None:
    plant = Integrator(lambda _: time.sleep(0.002))
    record = loop_on(plant, paced=True, rate_hz=1000.0, duration_s=0.05).run()
    assert record.count + record.skipped == 50
    assert plant.time == pytest.approx(0.05)


def test_ctrl_c_ends_the_loop_with_the_rows_that_are_whole() -> None:
    def interrupt(step: int) -> None:
        if step == 7:
            raise KeyboardInterrupt

    record = loop_on(Integrator(interrupt)).run()
    assert record.interrupted
    assert record.count == 8
    assert gc.isenabled()


def test_other_errors_pass_through_and_the_collector_runs_again() -> None:
    def fail(step: int) -> None:
        assert not gc.isenabled()
        if step == 3:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        loop_on(Integrator(fail)).run()
    assert gc.isenabled()


@pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="a Linux call")
@pytest.mark.parametrize("allowed", [True, False])
def test_a_paced_loop_takes_a_real_time_priority_where_it_may(allowed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def set_scheduler(_: int, policy: int, __: object) -> None:
        asked.append(policy)
        if not allowed:
            raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", set_scheduler)
    loop_on(Integrator(), paced=False).run()
    assert asked == []
    record = loop_on(Integrator(), paced=True, duration_s=0.01).run()
    assert record.real_time is allowed
    assert asked[0] & os.SCHED_FIFO
    assert asked[1:] == ([os.sched_getscheduler(0)] if allowed else [])


@pytest.mark.parametrize(
    ("part", "value", "problem"),
    [
        ("plant", None, "plant is a NoneType without 'q', 'qd', 'step'"),
        ("plant", JointSwing([0.0], [0.0], [1.0]), "plant is a JointSwing without 'q', 'qd', 'step'"),
        ("controller", "pd", "controller is a str; expected a Controller"),
        ("sensor", still(), "sensor is a JointSwing without 'gravity', 'age', 'state', 'status', 'update'"),
        ("trajectory", Tilted(), "trajectory is a Tilted without 'at'"),
        ("on_tick", 5, "on_tick is an int; expected a function"),
    ],
)
def test_parts_that_are_none_are_refused_before_the_loop(part: str, value: object, problem: str) -> None:
    controller = Controller(ravengc.load("rrbot"), "pd", GAINS)
    parts = {"plant": Integrator(), "controller": controller, "sensor": Tilted(), "trajectory": still()}
    with pytest.raises(ArgumentError, match=problem):
        ControlLoop(**parts | {part: value})


def test_a_plant_of_another_arm_is_refused_before_the_loop() -> None:
    plant = Integrator()
    plant.qd = np.zeros(3)
    with pytest.raises(ArgumentError, match=r"plant.qd has shape \(3,\); expected \(2,\) as the controller's"):
        loop_on(plant)


def test_progress_is_told_ten_times_a_second() -> None:
    told: list[tuple[int, int]] = []
    loop_on(Integrator(), duration_s=0.5, on_tick=lambda done, total: told.append((done, total))).run()
    assert told == [(100, 500), (200, 500), (300, 500), (400, 500), (500, 500)]


@pytest.mark.parametrize(
    ("rate_hz", "duration_s"),
    [(0.0, 1.0), (-1.0, 1.0), (1e6, 1.0), (1e-300, 1.0), (1e3, 0.0), (1e3, np.nan), (1e3, 1e5)],
)
def test_impossible_rates_and_durations_are_refused(rate_hz: float, duration_s: float) -> None:
    with pytest.raises(TimingError, match="rate"):
        loop_on(Integrator(), rate_hz=rate_hz, duration_s=duration_s)


def updated(law: str, **options: object) -> Controller:
    controller = Controller(ravengc.load("rrbot"), law, GAINS, **options)
    controller.q[:] = (0.3, 0.4)
    controller.qd[:] = (1.0, -1.0)
    controller.q_desired[:] = (0.5, 0.1)
    controller.qd_desired[:] = (0.5, 0.5)
    if controller.law.gravity == "dynamic":
        controller.gravity[:] = TILTED
    controller.update()
    return controller


@pytest.mark.parametrize(
    ("law", "gravity"), [("pd", None), ("pd+sg", LEVEL), ("pd+dg", TILTED), ("pd+bm", TILTED), ("passive", TILTED)]
)
def test_laws(law: str, gravity: np.ndarray | None) -> None:
    controller = updated(law)
    robot = ravengc.load("rrbot")
    pd = GAINS.kp * (0.2, -0.3) + GAINS.kd * (-0.5, 1.5) if LAWS[law].pd else np.zeros(2)
    held = np.zeros(2) if gravity is None else robot.gravity_torque((0.3, 0.4), gravity)
    assert controller.tau_pd == pytest.approx(pd)
    assert controller.tau_gravity == pytest.approx(held)
    assert controller.tau == pytest.approx(pd + held)


def test_torques_stay_within_their_limits() -> None:
    free = updated("pd+dg").tau
    limits = np.abs(free) * (0.5, 2.0)
    assert updated("pd+dg", tau_max=limits).tau == pytest.approx(np.clip(free, -limits, limits))


def test_unknown_laws_are_answered_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"'passiv'.*did you mean 'passive'"):
        Controller(ravengc.load("rrbot"), "passiv", GAINS)


@pytest.mark.parametrize(
    ("tau_max", "error"), [(-1.0, LimitError), ((1.0, 2.0, 3.0), ArgumentError), (np.nan, LimitError)]
)
def test_impossible_limits_are_refused(tau_max: object, error: type[Exception]) -> None:
    with pytest.raises(error, match="tau_max"):
        Controller(ravengc.load("rrbot"), "pd", GAINS, tau_max=tau_max)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(st.data(), robots(most=7))
def test_derived_gains_leave_the_sampled_loop_stable(data: st.DataObject, spec: ravengc.spec.RobotSpec) -> None:
    """No eigenvalue of M^-1 Kd exceeds 11 * 2 zeta w: the bound that keeps a 1 kHz loop far from its limit."""
    robot = ravengc.Robot(spec)
    q = data.draw(coordinates(spec))
    drive = derived_drive(robot, q, natural_frequency_hz=5.0, damping_ratio=0.7)
    inertia = robot.mass_matrix(q) + np.diag(drive.rotor_inertia)
    rates = np.linalg.eigvals(np.linalg.solve(inertia, np.diag(drive.kd)))
    assert np.abs(rates).max() <= 11.0 * 2.0 * 0.7 * 2.0 * np.pi * 5.0 * (1.0 + 1e-6)
    assert (drive.kp > 0.0).all()


def test_a_single_joint_gets_the_frequency_and_damping_asked_for() -> None:
    robot = ravengc.load("rrbot")
    drive = derived_drive(robot, np.zeros(2), natural_frequency_hz=3.0, damping_ratio=0.4)
    inertia = np.diag(robot.mass_matrix(np.zeros(2))) + drive.rotor_inertia
    assert np.sqrt(drive.kp / inertia) == pytest.approx(np.full(2, 6.0 * np.pi))
    assert drive.kd / (2.0 * np.sqrt(drive.kp * inertia)) == pytest.approx(np.full(2, 0.4))


def test_raven_gains_are_those_of_its_software_at_the_joints() -> None:
    drive = raven2_drive()
    assert drive.kp == pytest.approx((454.3, 361.7, 57055.0), rel=1e-3)
    assert drive.kd == pytest.approx((12.11, 9.64, 4564.0), rel=1e-3)
    assert drive.rotor_inertia == pytest.approx((0.263, 0.210, 66.2), rel=2e-3)


@pytest.mark.parametrize("name", ["raven2_green", "panda"])
@pytest.mark.parametrize("q", [[1.0, 2.0], np.full(3, np.nan), None])
def test_gains_for_a_pose_that_is_none_are_refused(name: str, q: Any) -> None:
    with pytest.raises(ArgumentError, match=r"^q "):
        drive_for(ravengc.load(name), q)


def test_published_gains_come_first_unless_others_are_asked_for() -> None:
    raven, panda = ravengc.load("raven2_green"), ravengc.load("panda")
    assert "RAVEN II" in drive_for(raven, np.zeros(3)).source
    assert "3 Hz" in drive_for(raven, np.zeros(3), natural_frequency_hz=3.0).source
    assert "derived" in drive_for(panda, np.zeros(7)).source


@pytest.mark.parametrize("name", ["raven2_gold", "panda", "dvrk_psm_si", "rrbot"])
def test_a_swing_stays_within_limits_and_starts_at_rest(name: str) -> None:
    spec = ravengc.load(name).spec
    swing = swing_within_limits(spec)
    q, qd, later = np.zeros((3, len(spec.coordinate_names)))
    swing.at(0.0, q, qd)
    assert q == pytest.approx(swing.start)
    assert (qd == 0.0).all()
    for t in np.linspace(0.0, 20.0, 101):
        swing.at(t + 1e-6, later, qd)
        swing.at(t, q, qd)
        assert qd == pytest.approx((later - q) / 1e-6, abs=1e-5)
        for value, limit in zip(q, spec.coordinate_limits, strict=True):
            assert limit.lower is None or value >= limit.lower
            assert limit.upper is None or value <= limit.upper


@pytest.mark.parametrize(
    ("lower", "upper", "centre"), [(None, None, 0.0), (1.0, None, 1.3), (None, -1.0, -1.3), (-1.0, None, 0.0)]
)
def test_a_swing_without_both_limits_stays_near_zero(lower: float | None, upper: float | None, centre: float) -> None:
    limits = JointLimits(lower=lower, upper=upper)
    link = LinkSpec(name="rod", placement=DhRow(), mass=1.0, limits=limits)
    swing = swing_within_limits(RobotSpec(name="one", convention="modified", links=(link,)))
    assert (swing.centre[0], swing.amplitude[0]) == pytest.approx((centre, 0.3))


def test_coupled_coordinates_slide_if_their_first_joint_does() -> None:
    assert sliding(ravengc.load("raven2_gold").spec).tolist() == [False, False, True]
    assert sliding(ravengc.load("dvrk_psm_si").spec).tolist() == [False, False, True]


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_record_of_a_run_reads_back(tmp_path: Path, suffix: str) -> None:
    columns = loop_on(Integrator(), "pd+dg").run().columns()
    log = read_log(write_log(tmp_path / f"run{suffix}", columns, {}))
    assert log.columns.keys() == columns.keys()
    for name, column in columns.items():
        np.testing.assert_array_equal(log.columns[name], column)


def test_summary_of_a_known_record() -> None:
    record = Record(4, 2)
    record.count = 2
    record.tau_pd[:2] = ((3.0, 0.0), (-3.0, 0.0))
    record.tau[:2] = ((4.0, 0.0), (-4.0, 0.0))
    record.q_desired[:2] = ((0.1, 0.0), (-0.1, 0.2))
    record.compute_ns[:2] = (1000, 3000)
    summary = summarise(record, np.array((False, True)))
    assert summary.cycles == 2
    assert summary.rms_error == pytest.approx((0.1, 0.2 / np.sqrt(2.0)))
    assert summary.pd_share[0] == summary.pd_share_revolute == pytest.approx(0.75)
    assert np.isnan(summary.pd_share[1])
    assert (summary.compute_us.p50, summary.compute_us.max) == (2.0, 3.0)
    assert summary.finite


def test_summary_of_nothing_and_of_a_runaway() -> None:
    assert summarise(Record(3, 2), np.zeros(2, dtype=bool)).cycles == 0
    assert rms(np.zeros((0, 2))).tolist() == [0.0, 0.0]
    record = Record(1, 1)
    record.count, record.q[0] = 1, np.inf
    assert not summarise(record, np.zeros(1, dtype=bool)).finite
