"""Follow a breathing target with an arm at 1 kHz: a camera sees it 30 times per second, 60 ms late and in noise.

python examples/breathing_target.py
"""

from __future__ import annotations

from typing import Literal

import numpy as np

import ravengc as rg
from ravengc.track import lujan

CYCLE_S, CYCLES_PER_PICTURE, CYCLES_LATE = 1e-3, 33, 60
NOISE_M = 3e-4
LEARNING_S, FOLLOWING_S, SETTLING_S = 25.0, 10.0, 1.0
Method = Literal["switch", "hold"]
METHODS: tuple[Method, ...] = ("switch", "hold")


def follow(method: Method, seed: int = 0) -> np.ndarray:
    """Distances (k,) of the tool from the target, m, once it has arrived, with this method of prediction."""
    robot, rng = rg.load("panda"), np.random.default_rng(seed)
    q = np.array([0.0, 0.2, 0.0, -2.1, 0.0, 2.3, np.pi / 4])
    stamps = np.arange(0.0, LEARNING_S + FOLLOWING_S, CYCLE_S)
    places = robot.forward_kinematics(q)[:3, 3] + lujan(seed=seed).positions(stamps)

    target, velocity, rates = np.zeros(3), np.zeros(3), np.zeros(robot.n)
    late_s = CYCLES_LATE * CYCLE_S
    predictor = rg.Predictor(1 / (CYCLES_PER_PICTURE * CYCLE_S), method=method, latency_s=late_s, noise=NOISE_M)
    predict = predictor.bind(out=target, velocity=velocity)
    step = rg.ResolvedRate(robot, "position").bind(q=q, target=target, target_twist=velocity, out=rates)

    errors = []
    for cycle, now in enumerate(stamps.tolist()):
        if cycle >= CYCLES_LATE and cycle % CYCLES_PER_PICTURE == 0:
            predictor.update(now, places[cycle - CYCLES_LATE] + rng.normal(0.0, NOISE_M, 3))
        if now >= LEARNING_S:
            predict(now)
            step()
            q += CYCLE_S * rates
        if now >= LEARNING_S + SETTLING_S:
            errors.append(np.linalg.norm(robot.forward_kinematics(q)[:3, 3] - places[cycle]))
    return np.array(errors)


if __name__ == "__main__":
    for method in METHODS:
        errors_mm = 1e3 * follow(method)
        rms, p95 = np.sqrt(np.mean(errors_mm**2)), np.quantile(errors_mm, 0.95)
        print(f"{method}: hold error {rms:.2f} mm RMS, {p95:.2f} mm in 95 % of cycles")  # noqa: T201 -- its result
