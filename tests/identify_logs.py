"""Logs of simulated arms, as a recorder would have written them, and what spoils them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import ravengc as rg

__all__ = ["Table", "moved", "stood", "write_csv"]

GRAVITY = 9.80665
OF_THE_BASE = {"a", "g", "w", "gyro_"}
Table = dict[str, np.ndarray]


def moved(robot: rg.Robot, seconds: float = 12.0, rate: float = 50.0, seed: int = 3) -> Table:
    """A motion about the middle of all ranges with the torques of the file and friction: t, q, dq, tau."""
    t, random = np.arange(0.0, seconds, 1.0 / rate), np.random.default_rng(seed)
    limits = [(limit.lower or 0.0, limit.upper or 0.0) for limit in robot.spec.coordinate_limits]
    middle, half = (
        np.array([f(*limit) for limit in limits]) for f in (lambda a, b: (a + b) / 2, lambda a, b: (b - a) / 2)
    )
    q, qd, qdd = np.zeros((3, t.size, robot.n))
    for harmonic in range(1, 5):
        w = 2.0 * np.pi * 0.15 * harmonic
        phase = w * t[:, np.newaxis] + random.uniform(0.0, 6.0, robot.n)
        size = np.minimum(0.5, 0.4 * half) * random.uniform(0.4, 1.0, robot.n) / harmonic
        q += size * np.sin(phase)
        qd += size * w * np.cos(phase)
        qdd -= size * w * w * np.sin(phase)
    level = np.tile([0.0, 0.0, GRAVITY, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], (t.size, 1))
    tau = robot.inverse_dynamics_batch(q + middle, qd, qdd, level) + 0.2 * np.tanh(qd / 0.01) + 0.1 * qd
    return {"t": t, "q": q + middle, "dq": qd, "tau": tau + 0.005 * random.normal(size=tau.shape)}


def stood(robot: rg.Robot, tilt_deg: float, axes: int, poses: int = 60, noise: float = 0.002, seed: int = 1) -> Table:
    """Poses at rest on a base that leans about so many axes, with its accelerometer: t, q, tau, a."""
    random = np.random.default_rng(seed)
    q = np.array([random.uniform(limit.lower, limit.upper, poses) for limit in robot.spec.coordinate_limits]).T
    lean = np.radians(tilt_deg) * random.uniform(-1.0, 1.0, (2, poses)) * [[1.0], [float(axes > 1)]]
    up = [np.sin(lean[1]), -np.sin(lean[0]) * np.cos(lean[1]), np.cos(lean[0]) * np.cos(lean[1])]
    force = GRAVITY * np.column_stack(up)
    tau = robot.gravity_torque_batch(q, -force)
    tau = tau + 0.003 * np.sqrt((tau**2).mean(axis=0)) * random.normal(size=tau.shape)
    return {"t": np.arange(float(poses)), "q": q, "tau": tau, "a": force + noise * random.normal(size=force.shape)}


def write_csv(path: Path, table: Mapping[str, np.ndarray], end: str = "\n") -> str:
    """The table as a log, columns numbered from 1; ``end`` closes its last line. Returns the path as text."""
    names, columns = [], []
    for name, values in table.items():
        wide = values.reshape(len(values), -1)
        ends = [""] if values.ndim == 1 else list("xyz") if name in OF_THE_BASE else range(1, wide.shape[1] + 1)
        names += [f"{name}{one}" for one in ends]
        columns.append(wide)
    lines = [",".join(names), *(",".join(f"{value:.10g}" for value in row) for row in np.hstack(columns))]
    path.write_text("\n".join(lines) + end, encoding="utf-8")
    return str(path)
