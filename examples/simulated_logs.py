"""Write the logs that ravengc carries for `ravengc identify`: what recorders at simulated arms would have written.

python examples/simulated_logs.py FOLDER

mtmr_level, mtmr_tilts: a dVRK master arm whose masses differ from its file, poses passed upwards and downwards, on a
level base and on one that is tilted to five attitudes with an accelerometer on it. ur5_unloaded, ur5_loaded: one motion
of a UR5, with 1.5 kg on its flange and without.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import ravengc as rg

GRAVITY = 9.80665
SEED = 6
POSES = 20
ATTITUDES = ((0.0, 0.0), (10.0, 0.0), (0.0, 10.0), (-10.0, 0.0), (0.0, -10.0))
"""Roll and pitch of the base, degrees."""
MASS_ERROR, COM_ERROR = 0.25, 0.01
"""Standard deviations: of the true masses as a share of the file's, of the true centres of mass in m."""
FRICTION = (0.04, 0.03, 0.02, 0.03, 0.008, 0.006, 0.001)
TORQUE_NOISE = (0.005, 0.005, 0.005, 0.003, 0.001, 0.001, 0.0005)
FORCE_NOISE = 0.01
LOAD, LOAD_AT = 1.5, (0.02, -0.01, 0.06)
RATE, SECONDS, BASIC = 25.0, 20.0, 0.1
DRIVE_NOISE = 0.1


def other_masses(robot: rg.Robot, random: np.random.Generator) -> rg.Robot:
    """An arm of the same geometry with other masses."""
    links = []
    for link in robot.spec.links:
        share = 1.0 + MASS_ERROR * random.uniform(-1.0, 1.0)
        com = tuple((np.array(link.com) + COM_ERROR * random.normal(size=3)).tolist())
        links.append(link if link.massless else replace(link, mass=share * link.mass, com=com))
    return rg.Robot(replace(robot.spec, links=tuple(links)))


def force(roll: float, pitch: float) -> np.ndarray:
    """What an accelerometer on the base reads, m/s²."""
    r, p = np.radians([roll, pitch])
    return GRAVITY * np.array([np.sin(p), -np.sin(r) * np.cos(p), np.cos(r) * np.cos(p)])


def write_poses(path: Path, arm: rg.Robot, attitudes: tuple[tuple[float, float], ...], seed: int) -> None:
    """Poses on every attitude, each passed upwards and downwards at 0.05 rad/s, a row every second."""
    random = np.random.default_rng(seed)
    lower, upper = np.array([(limit.lower, limit.upper) for limit in arm.spec.coordinate_limits]).T
    rows = []
    for attitude in attitudes:
        for q in random.uniform(
            0.9 * lower + 0.1 * upper, 0.1 * lower + 0.9 * upper, (POSES * 5 // len(attitudes), arm.n)
        ):
            for way in (1.0, -1.0):
                f, qd = force(*attitude), np.full(arm.n, 0.05 * way)
                tau = arm.gravity_torque(q, rg.SpecificForce(*f)) + way * np.array(FRICTION)
                noisy = tau + np.array(TORQUE_NOISE) * random.normal(size=arm.n)
                rows.append(np.concatenate([[len(rows)], q, qd, noisy, f + FORCE_NOISE * random.normal(size=3)]))
    names = ["t", *(f"{kind}{joint + 1}" for kind in ("q", "dq", "tau") for joint in range(arm.n)), "ax", "ay", "az"]
    lines = [",".join(names), *(",".join(f"{value:.5g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_motion(path: Path, arm: rg.Robot, seed: int) -> None:
    """A periodic motion of five harmonics with friction, its torques with the noise of drives."""
    random, shape = np.random.default_rng(seed), np.random.default_rng(SEED)
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    q, qd, qdd = np.zeros((3, t.size, arm.n))
    for harmonic in range(1, 6):
        w = 2.0 * np.pi * BASIC * harmonic
        phase = w * t[:, np.newaxis] + shape.uniform(0.0, 2.0 * np.pi, arm.n)
        size = 0.5 * shape.uniform(0.3, 1.0, arm.n) / harmonic
        q += size * np.sin(phase)
        qd += size * w * np.cos(phase)
        qdd -= size * w * w * np.sin(phase)
    level = np.tile([0.0, 0.0, GRAVITY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], (t.size, 1))
    tau = arm.inverse_dynamics_batch(q, qd, qdd, level) + 2.0 * np.tanh(qd / 0.02) + 3.0 * qd
    tau += DRIVE_NOISE * random.normal(size=tau.shape)
    arrays = {"q": q, "qd": qd, "tau": tau}
    np.savez_compressed(path, t=t, **{name: values.astype(np.float32) for name, values in arrays.items()})


def main(folder: Path) -> None:
    """Write all four."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(SEED)
    arm = other_masses(rg.load("dvrk_mtmr"), random)
    write_poses(folder / "mtmr_level.csv", arm, ATTITUDES[:1], SEED + 1)
    write_poses(folder / "mtmr_tilts.csv", arm, ATTITUDES, SEED + 2)
    ur5 = other_masses(rg.load("ur5"), random)
    write_motion(folder / "ur5_unloaded.npz", ur5, SEED + 3)
    ur5.set_payload(LOAD, LOAD_AT)
    write_motion(folder / "ur5_loaded.npz", ur5, SEED + 4)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    try:
        main(parser.parse_args().folder)
    except OSError as error:
        sys.exit(str(error))
