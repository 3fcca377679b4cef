"""Base motions of every kind against their own derivatives, their limits, and what they were made from."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ravengc
from bounds import assert_close
from ravengc import sim
from ravengc.errors import ArgumentError, ConfigError, ParseError, RavenGCError

if TYPE_CHECKING:
    from pathlib import Path

G = ravengc.STANDARD_GRAVITY
LEVEL = np.array((0.0, 0.0, -G))
ORIGIN = np.zeros(3)
POINT = np.array((0.3, -0.2, 0.5))


def axis_turn(axis: int, angle: float) -> np.ndarray:
    """Rx, Ry or Rz."""
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.eye(3)
    i, k = (axis + 1) % 3, (axis + 2) % 3
    rotation[i, i] = rotation[k, k] = c
    rotation[i, k], rotation[k, i] = -s, s
    return rotation


def sampled(base: sim.CarriedBase, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and rotations."""
    return np.array([base.position(t) for t in times]), np.array([base.rotation(t) for t in times])


def felt(base: sim.CarriedBase, times: np.ndarray, place: np.ndarray = ORIGIN) -> tuple[np.ndarray, np.ndarray]:
    """What an accelerometer and a gyro at ``place`` read."""
    readings = [base.motion_at(t, place) for t in times]
    return np.array([f for f, _, _ in readings]), np.array([w for _, w, _ in readings])


TIMES = np.linspace(0.0, 4.0, 81)
WAVES = sim.oscillating(
    amplitude=(0.2, 0.1, 0.3, 0.3, 0.2, 0.4),
    hz=(0.3, 0.4, 0.2, 0.5, 0.3, 0.25),
    phase=(0.0, 1.0, 2.0, 0.5, 0.0, 3.0),
    pivot=(0.1, 0.2, -0.3),
)
BASES = {
    "ship": sim.ship(),
    "elevator": sim.elevator(-6.0, start_s=0.2),
    "step": sim.acceleration_step(2.0, (1.0, 2.0, 0.0), start_s=0.5, end_s=2.5, rise_s=0.4),
    "poses": sim.recorded(TIMES, *sampled(WAVES, TIMES)),
    "imu": sim.recorded_imu(TIMES, *felt(WAVES, TIMES, POINT), place=POINT),
}


@pytest.mark.parametrize("name", BASES)
@pytest.mark.parametrize("t", [-0.6, 0.3, 1.21, 3.77, 4.45])
def test_a_motion_is_the_derivative_of_its_pose(name: str, t: float) -> None:
    base, h = BASES[name], 1e-4
    before, now, after = (base.position(t + k * h) + base.rotation(t + k * h) @ POINT for k in (-1, 0, 1))
    rotations = [base.rotation(t + k * h) for k in (-1, 0, 1)]
    f, w, dw = base.motion_at(t, POINT)
    inverse = rotations[1].T
    assert_close(f, inverse @ ((after - 2.0 * now + before) / h**2 - LEVEL), bound=1.0, tolerance=1e-3)
    assert_close(w, vee(inverse @ (rotations[2] - rotations[0])) / (2.0 * h), bound=1.0, tolerance=1e-5)
    assert_close(dw, vee(inverse @ (rotations[2] - 2.0 * rotations[1] + rotations[0])) / h**2, 1.0, tolerance=1e-4)


def vee(matrix: np.ndarray) -> np.ndarray:
    """The vector of the antisymmetric part of a matrix."""
    return 0.5 * np.array((matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]))


@pytest.mark.parametrize("name", BASES)
def test_position_and_velocity_never_jump(name: str) -> None:
    base, h = BASES[name], 1e-3
    states = [base.state(t) for t in np.arange(-2.0, 7.0, h)]
    for before, after in pairwise(states):
        middle = 0.5 * (before.velocity + after.velocity)
        assert np.abs(after.position - before.position - h * middle).max() < 2e-5
        assert np.abs(after.velocity - before.velocity).max() < 0.02


# Ship


@pytest.mark.parametrize("t", [0.0, 1.7, 12.3, 59.0])
def test_a_ship_rolls_pitches_and_heaves_about_its_centre(t: float) -> None:
    """R = Rx(10 deg sin(2 pi 0.1 t)) Ry(4 deg sin(2 pi 0.13 t)), heave 1 m sin(2 pi 0.1 t), arm at (3, 1, 4) m."""
    base, place = sim.ship(), np.array((3.0, 1.0, 4.0))
    roll, pitch = (
        np.deg2rad(size) * np.sin(2.0 * np.pi * hz * t) for size, hz in zip((10.0, 4.0), (0.1, 0.13), strict=True)
    )
    rotation = axis_turn(0, roll) @ axis_turn(1, pitch)
    np.testing.assert_allclose(base.rotation(t), rotation, atol=1e-14)
    centre = np.array((0.0, 0.0, np.sin(2.0 * np.pi * 0.1 * t)))
    np.testing.assert_allclose(base.position(t), centre + rotation @ place - place, atol=1e-13)


def test_the_pa10_on_a_ship_holds_the_published_torque() -> None:
    """Error of eqs (1)-(3) with level gravity, the tilt alone and an accelerometer, in % of the RMS torque."""
    robot = ravengc.load("pa10")
    q, still = np.array((0.3, 0.6, -1.0, 0.2, 0.5, 0.1)), np.zeros(6)
    base = sim.ship()
    truth, static, tilt, sensed = [], [], [], []
    for t in np.arange(0.0, 60.0, 0.05):
        truth.append(robot.inverse_dynamics(q, still, still, base.motion(t)))
        static.append(robot.gravity_torque(q, LEVEL))
        tilt.append(robot.gravity_torque(q, base.rotation(t).T @ LEVEL))
        sensed.append(robot.gravity_torque(q, -base.motion_at(t, ORIGIN)[0]))
    exact = np.array(truth)

    def share(model: list[np.ndarray], joint: int) -> float:
        error = exact[:, joint] - np.array(model)[:, joint]
        return float(100.0 * np.sqrt((error**2).mean() / (exact[:, joint] ** 2).mean()))

    assert [share(model, 1) for model in (static, tilt, sensed)] == pytest.approx((19.0, 3.6, 0.9), abs=0.6)
    assert [share(model, 2) for model in (static, tilt, sensed)] == pytest.approx((21.0, 7.0, 0.8), abs=0.6)


@pytest.mark.parametrize("options", [{"roll_hz": -0.1}, {"heave": np.nan}, {"pitch_deg": -1.0}])
def test_impossible_ships_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match=next(iter(options))):
        sim.ship(**options)


# Elevator and step


@settings(deadline=None)
@given(
    st.floats(0.01, 100.0), st.sampled_from((1.0, -1.0)), st.floats(0.2, 5.0), st.floats(0.1, 3.0), st.floats(0.2, 10.0)
)
def test_an_elevator_arrives_within_its_limits(
    travel: float, up: float, speed: float, acceleration: float, jerk: float
) -> None:
    base = sim.elevator(up * travel, speed=speed, acceleration=acceleration, jerk=jerk, start_s=0.5)
    times = np.linspace(0.0, float(base.times[-1]) + 1.0, 500)
    states = [base.state(t) for t in times]
    height, rate, gain = np.array([[part[2] for part in state] for state in states]).T
    assert height[0] == rate[0] == 0.0
    assert height[-1] == pytest.approx(up * travel, rel=1e-9)
    assert rate[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(rate).max() <= speed * (1.0 + 1e-9)
    assert np.abs(gain).max() <= acceleration * (1.0 + 1e-9)
    assert np.abs(np.diff(gain)).max() <= jerk * (times[1] - times[0]) * (1.0 + 1e-6)
    assert (up * np.diff(height) >= -1e-12).all()


def test_a_long_ride_reaches_its_speed_and_acceleration() -> None:
    base = sim.elevator(30.0, speed=2.5, acceleration=1.0, jerk=2.0, start_s=1.0)
    assert base.state(1.0 + 2.0).acceleration[2] == pytest.approx(1.0)
    assert base.state(1.0 + 6.0).velocity[2] == pytest.approx(2.5)
    assert base.motion_at(3.0, ORIGIN)[0] == pytest.approx((0.0, 0.0, G + 1.0))


def test_a_step_adds_its_specific_force_while_it_lasts() -> None:
    base = sim.acceleration_step(0.2 * G, "y", start_s=1.0, end_s=3.0)
    for t, more in ((0.999, 0.0), (1.0, 0.2 * G), (2.999, 0.2 * G), (3.0, 0.0), (60.0, 0.0)):
        f, w, dw = base.motion_at(t, POINT)
        assert f == pytest.approx((0.0, more, G), abs=1e-9)
        assert np.abs((w, dw)).max() == 0.0
    assert base.state(10.0).velocity[:3] == pytest.approx((0.0, 0.4 * G, 0.0))


def test_a_step_may_rise_slowly() -> None:
    base = sim.acceleration_step(1.0, start_s=1.0, end_s=2.0, rise_s=0.25)
    assert [base.state(t).acceleration[0] for t in (1.125, 1.25, 1.75, 1.875)] == pytest.approx([0.5, 1.0, 1.0, 0.5])


@pytest.mark.parametrize(
    "make",
    [
        lambda: sim.elevator(0.0),
        lambda: sim.elevator(1.0, jerk=0.0),
        lambda: sim.elevator(np.inf),
        lambda: sim.acceleration_step(1.0, start_s=2.0, end_s=2.0),
        lambda: sim.acceleration_step(1.0, start_s=2.0, end_s=1.0),
        lambda: sim.acceleration_step(1.0, start_s=0.0, end_s=1.0, rise_s=0.6),
        lambda: sim.acceleration_step(np.nan),
    ],
)
def test_impossible_profiles_are_refused(make: object) -> None:
    with pytest.raises(ConfigError, match=r"elevator|acceleration step"):
        make()


# Recorded


def test_a_recorded_base_goes_through_its_poses() -> None:
    base = BASES["poses"]
    positions, rotations = sampled(WAVES, TIMES)
    for t, position, rotation in zip(TIMES, positions, rotations, strict=True):
        np.testing.assert_allclose(base.position(t), position, atol=1e-12)
        np.testing.assert_allclose(base.rotation(t), rotation, atol=1e-12)


def test_between_poses_it_moves_as_the_base_did() -> None:
    for t in np.linspace(1.0, 3.0, 41):
        f, w, dw = WAVES.motion_at(t, POINT)
        found = BASES["poses"].motion_at(t, POINT)
        assert_close(found[0], f, bound=1.0, tolerance=0.02)
        assert_close(found[1], w, bound=1.0, tolerance=1e-3)
        assert_close(found[2], dw, bound=1.0, tolerance=0.02)


def test_a_felt_base_feels_its_samples() -> None:
    """Exactly at the samples; between them as closely as splines follow a sine of half a hertz at 20 Hz."""
    base = BASES["imu"]
    force, rate = felt(WAVES, TIMES, POINT)
    for t, f, w in zip(TIMES, force, rate, strict=True):
        found = base.motion_at(t, POINT)
        assert_close(found[0], f, bound=1.0, tolerance=1e-9)
        assert_close(found[1], w, bound=1.0, tolerance=1e-9)
    for t in np.linspace(1.0, 3.0, 37):
        found = base.motion_at(t, POINT)
        for mine, true in zip(found, WAVES.motion_at(t, POINT), strict=True):
            assert_close(mine, true, bound=1.0, tolerance=0.01)


def test_a_felt_base_that_begins_at_rest_keeps_its_orientation() -> None:
    ride = sim.BaseTrajectory(
        offset=(0.0, 0.0, 0.0, 0.3, 0.0, 0.0), amplitude=(0.5, 0.0, 0.0, 0.0, 0.0, 0.0), hz=(0.0,) * 6
    )
    times = np.linspace(0.0, 2.0, 50)
    base = sim.recorded_imu(times, *felt(ride, times))
    np.testing.assert_allclose(base.rotation(1.3), ride.rotation(1.3), atol=1e-12)
    np.testing.assert_allclose(base.position(1.3), 0.0, atol=1e-12)


def test_outside_its_recording_a_base_coasts_and_stops_turning() -> None:
    for name in ("poses", "imu"):
        base = BASES[name]
        for t in (-30.0, 30.0):
            f, w, dw = base.motion_at(t, POINT)
            assert np.abs((w, dw)).max() == pytest.approx(0.0, abs=1e-12)
            np.testing.assert_allclose(base.rotation(t) @ f, -LEVEL, atol=1e-9)


def test_a_base_may_turn_once_around_but_not_tumble() -> None:
    times = np.linspace(0.0, 10.0, 101)
    around = np.array([axis_turn(1, 0.7 * t) for t in times])
    base = sim.recorded(times, np.zeros((101, 3)), around)
    np.testing.assert_allclose(base.rotation(7.05), axis_turn(1, 0.7 * 7.05), atol=1e-9)
    tumbling = np.array([axis_turn(0, 1.3 * t) @ axis_turn(1, 1.7 * t) @ axis_turn(2, 0.9 * t) for t in times])
    with pytest.raises(ConfigError, match="keeps the middle one within 80 deg"):
        sim.recorded(times, np.zeros((101, 3)), tumbling)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"times": TIMES[::-1]}, "times must be 3 to 1000000 finite numbers that increase"),
        ({"times": TIMES[:2]}, "times must be 3 to"),
        ({"position": np.zeros((80, 3))}, r"position has shape \(80, 3\); expected \(81, 3\)"),
        ({"position": np.full((81, 3), np.nan)}, "position holds a number that is not finite"),
        ({"rotation": 2.0 * np.tile(np.eye(3), (81, 1, 1))}, r"rotation\[0\] is no rotation matrix"),
        ({"rotation": -np.tile(np.eye(3), (81, 1, 1))}, r"rotation\[0\] is no rotation matrix"),
    ],
)
def test_impossible_recordings_are_refused(change: dict[str, np.ndarray], message: str) -> None:
    positions, rotations = sampled(WAVES, TIMES)
    with pytest.raises(ArgumentError, match=message):
        sim.recorded(**{"times": TIMES, "position": positions, "rotation": rotations, **change})


# Files


def quaternion(rotation: np.ndarray) -> list[float]:
    w = 0.5 * np.sqrt(1.0 + np.trace(rotation))
    return [w, *(vee(rotation) / (2.0 * w))]


def written(path: Path, names: str, rows: np.ndarray) -> Path:
    np.savetxt(path, rows, delimiter=",", header=names, fmt="%.17g")
    return path


def test_poses_come_from_a_table_or_an_archive(tmp_path: Path) -> None:
    positions, rotations = sampled(WAVES, TIMES)
    quaternions = np.array([quaternion(rotation) for rotation in rotations])
    table = np.hstack((TIMES[:, None], quaternions, positions))
    path = written(tmp_path / "poses.csv", "t,qw,qx,qy,qz,x,y,z", table)
    np.savez(tmp_path / "poses.npz", t=TIMES, position=positions, quaternion=quaternions, notes="of a swing")
    for base in (sim.read_recorded(path), sim.parse_base(f"recorded:{tmp_path / 'poses.npz'}")):
        np.testing.assert_allclose(base.position(1.23), BASES["poses"].position(1.23), atol=1e-9)
        np.testing.assert_allclose(base.rotation(1.23), BASES["poses"].rotation(1.23), atol=1e-9)


def test_angles_of_a_table_are_roll_pitch_and_yaw(tmp_path: Path) -> None:
    angles = np.stack((0.3 * np.sin(TIMES), 0.2 * TIMES, 0.1 * np.cos(TIMES)), axis=1)
    rows = np.hstack((TIMES[:, None], np.rad2deg(angles)))
    base = sim.read_recorded(written(tmp_path / "angles.csv", "t,roll_deg,pitch_deg,yaw_deg", rows))
    rolled = axis_turn(0, angles[20, 0]) @ axis_turn(1, angles[20, 1]) @ axis_turn(2, angles[20, 2])
    np.testing.assert_allclose(base.rotation(TIMES[20]), rolled, atol=1e-9)
    assert base.position(TIMES[20]) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_a_sensor_s_table_is_felt(tmp_path: Path) -> None:
    rows = np.hstack((TIMES[:, None], *felt(WAVES, TIMES)))
    base = sim.parse_base(f"recorded:{written(tmp_path / 'imu.csv', 't,fx,fy,fz,wx,wy,wz', rows)}")
    assert_close(base.motion_at(TIMES[30], ORIGIN)[0], WAVES.motion_at(TIMES[30], ORIGIN)[0], 1.0, 1e-9)
    assert base.description == "recorded in imu.csv"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "columns ; expected t with"),
        ("t,x,y,z\n0,1,2,3\n", "columns 't', 'x', 'y', 'z'; expected t with qw,qx,qy,qz"),
        ("1,2,3\n", "no line of names before the numbers"),
        ("t,roll,pitch,yaw\n0,0,0,0\n1,0,0\n", "3 cells, expected 4"),
        ("t,roll,pitch,yaw\n0,0,0,no\n", "a cell is no number"),
        ("t,roll,pitch,yaw\n0,0,0,0\n", "times must be 3 to"),
        ("t,roll,pitch,yaw\n0,0,0,0\n1,0,0,nan\n2,0,0,0\n", "rotation holds a number that is not finite"),
        ("t,qw,qx,qy,qz\n0,1,0,0,0\n1,2,0,0,0\n2,1,0,0,0\n", "quaternion 1 has the length 2; expected 1"),
    ],
)
def test_tables_that_are_no_motion_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "base.csv"
    path.write_text(text)
    with pytest.raises(ParseError, match=message) as caught:
        sim.read_recorded(path)
    assert "base.csv" in str(caught.value)


def test_what_is_no_file_of_a_motion_is_refused(tmp_path: Path) -> None:
    (tmp_path / "noise.csv").write_bytes(b"\xff\xfe\x00t,roll")
    (tmp_path / "noise.npz").write_bytes(b"PK\x03\x04 and so on")
    np.savez(tmp_path / "text.npz", t=np.array(["a", "b", "c"]), quaternion=np.eye(4))
    for name in ("noise.csv", "noise.npz", "text.npz", "missing.csv", "."):
        with pytest.raises(RavenGCError):
            sim.read_recorded(tmp_path / name)


# Words


@pytest.mark.parametrize(
    ("text", "description"),
    [
        ("level", "level"),
        ("tilt:20", "tilted 20 deg about (1, 0, 0)"),
        ("rocking:10:20:1", "rocking 10 to 20 deg at 1 Hz about (1, 0, 0)"),
        ("ship", "ship: roll 10 deg at 0.1 Hz, pitch 4 deg at 0.13 Hz, heave 1 m at 0.1 Hz"),
        ("ship:5:0.2:2:0.3:0.5:0.1", "ship: roll 5 deg at 0.2 Hz, pitch 2 deg at 0.3 Hz, heave 0.5 m at 0.1 Hz"),
        ("elevator:-10:2", "elevator: -10 m at up to 2 m/s, 1 m/s^2"),
        ("step:1.96:1:3", "acceleration of 1.96 m/s^2 along (1, 0, 0) from 1 to 3 s"),
    ],
)
def test_motions_are_read_from_words(text: str, description: str) -> None:
    assert sim.parse_base(text).description == description


@pytest.mark.parametrize(
    "text",
    [
        "",
        "tilt",
        "tilt:x",
        "level:1",
        "ship:1",
        "elevator",
        "elevator:1:2:3:4:5",
        "step:1",
        "boat",
        "recorded",
        "recorded:",
    ],
)
def test_other_words_are_refused_with_what_may_be_written(text: str) -> None:
    with pytest.raises(ConfigError, match="write level, tilt:DEG, rocking:LOW:HIGH:HZ, ship"):
        sim.parse_base(text)
