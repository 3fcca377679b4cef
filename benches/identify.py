"""Identification against published numbers: one row per name, each printed with its bar.

`python benches/identify.py` prints every row that the data here allow, `python benches/identify.py mtm ur10` these two.
The UR10 and the Panda (unisa-acg/inverse-dynamics-solver, BSD-3-Clause) come with the tests; the dVRK's recordings
(WPI-AIM/dvrk_dynamics_identification, without a licence) do not: `--data FOLDER` says where dvrk/dvrk_real.npz is.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import identify_arms as arms
import numpy as np

import ravengc as rg
from ravengc.identify import (
    Bounds,
    Model,
    Recording,
    base_parameters,
    identify,
    mounting,
    payload,
    plan,
    polynomial,
    predict_uncertainty,
    smoothed,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from ravengc.identify.identification import Estimator

SHIPPED = Path(__file__).parents[1] / "tests" / "data" / "ident"
GRAVITY = 9.80665
PUBLISHED = {
    "mtm": ((0.0818, 0.1631, 0.1906, 0.2090, 0.2630, 0.2348, 0.3396), (0.0769, 0.1485, 0.1695, 0.2232, 0.2800, 0.2342,
    0.3395)), "psm": ((0.1028, 0.1828, 0.1976, 0.1344, 0.2399, 0.2111, 0.2662), (0.0929, 0.1783, 0.1907, 0.1345,
    0.2394, 0.2125, 0.2642)),
}  # fmt: skip
"""Relative errors of joints 1-7 on the test trajectory, least squares and convex: Wang et al. 2019 (repository)."""
RANKS = {
    "raven2_gold": (3, 5), "ur10": (10, 12), "panda": (12, 14), "dvrk_mtmr": (12, 14), "dvrk_mtml": (12, 14),
    "dvrk_psm_si": (5, 5), "dvrk_ecm_si": (5, 5), "rrbot": (4, 4), "pa10": (10, 12),
}  # fmt: skip


def said(row: str, text: str, good: bool) -> bool:
    print(f"{row:14s} {'holds' if good else 'FALLS SHORT'}: {text}", flush=True)
    return good


def percents(values: np.ndarray) -> str:
    return "[" + " ".join(f"{value:.4f}" for value in values) + "]"


# The rows


def ranks(_: Path) -> bool:
    """Base parameters, gravity along joint 1 and tilted."""
    good, parts = True, []
    for name, expected in RANKS.items():
        robot = rg.load(name)
        axis = _first_axis(robot) if name == "raven2_gold" else np.array([0.0, 0.0, 1.0])
        found = tuple(base_parameters(robot, Model(), way).rank for way in (GRAVITY * axis[np.newaxis], "tilted"))
        good &= found == expected
        parts.append(f"{name} {found[0]}/{found[1]}")
    return said("ranks", ", ".join(parts), good)


def _first_axis(robot: rg.Robot) -> np.ndarray:
    return np.array(robot.base.rotation)[:, 2]


def mtm(data: Path) -> bool:
    """MTM of WPI."""
    train, test = (
        arms.without_cable(arms.recorded(data, f"mtm_wpi__{name}", 5.65)) for name in ("train_one", "test_two")
    )
    models = {"as published": arms.mtm_model(), "hysteresis": arms.rubbing(arms.mtm_model())}
    whole = [
        arms.without_cable(arms.recorded(data, f"mtm_wpi__{name}", 5.65, repeated=True))
        for name in ("train_one", "test_two")
    ]
    good = _reproduced("mtm", arms.mtm(), models["as published"], whole[0], whole[1].take(slice(0, 2000)))
    return good & _dvrk("mtm", arms.mtm(), models, arms.mtm_bounds(), train, test.take(slice(0, 2000)))


def psm(data: Path) -> bool:
    """PSM of WPI."""
    train, test = (arms.recorded(data, f"psm_wpi__{name}", 16.96) for name in ("train_one", "test_two"))
    models = {"as published": arms.psm_model(), "hysteresis": arms.rubbing(arms.psm_model(), ("L30",))}
    good = _reproduced("psm", arms.psm(), models["as published"], train, test.take(slice(0, 1111)))
    return good & _dvrk("psm", arms.psm(), models, arms.psm_bounds(), train, test.take(slice(0, 1111)))


def _dvrk(
    row: str, robot: rg.Robot, models: dict[str, Model], bounds: Bounds, train: Recording, test: Recording
) -> bool:
    """The same recordings with our filters and friction; the last fit is judged, what leads to it is printed."""
    best = np.min(PUBLISHED[row], axis=0)
    print(f"{row:14s} the better of both published columns, per joint {percents(best)}")
    fits: tuple[tuple[str, Estimator], ...]
    fits = (("as published", "wls"), ("hysteresis", "wls"), ("hysteresis", "consistent"))
    for label, estimator in fits:
        start = time.perf_counter()
        found = identify(
            robot, train, models[label], estimator, held_out=test, bounds=bounds if estimator == "consistent" else None
        )
        took = time.perf_counter() - start
        errors = found.held_out.relative
        worst, better = float((errors - best).max()), int((errors < best).sum())
        text = f"{label}, {estimator} {percents(errors)} worst {worst:+.4f}, {better} better, {took:.1f} s"
        refused = f"; refused: {found.refused}" if found.refused else ""
        if (label, estimator) == fits[-1]:
            return said(row, text + refused, worst <= 0.005 and better >= 4 and found.refused is None)
        print(f"{row:14s} on the way: {text}{refused}", flush=True)
    return False


def _reproduced(row: str, robot: rg.Robot, model: Model, train: Recording, test: Recording) -> bool:
    """The published least-squares column from the published model."""
    plain = _as_published(robot, model, train, test)
    off = float(np.abs(plain - PUBLISHED[row][0]).max())
    return said(f"{row} published", f"reproduced {percents(plain)}, off by {off:.4f} at most", off < 3e-4)


def _as_published(robot: rg.Robot, model: Model, train: Recording, test: Recording) -> np.ndarray:
    """Least squares with rows over their joint's range, columns of unfiltered steps, as the authors have it."""
    train, test = replace(train, cutoff_hz=None), replace(test, cutoff_hz=None)
    chosen = base_parameters(robot, model).chosen
    weights = np.tile(1.0 / np.ptp(train.tau, axis=0), train.samples)
    X = model.regressor(robot, train)[:, chosen] * weights[:, np.newaxis]
    values = np.linalg.lstsq(X, train.tau.ravel() * weights)[0]
    errors = test.tau - (model.regressor(robot, test)[:, chosen] @ values).reshape(test.q.shape)
    relative: np.ndarray = np.linalg.norm(errors, axis=0) / np.linalg.norm(test.tau, axis=0)
    return relative


def consistent(data: Path) -> bool:
    """Time of the conic solve alone."""
    from ravengc.identify.consistent import consistent as solve
    from ravengc.identify.estimators import weighted
    from ravengc.identify.reduction import joined, reduce_rows

    robot, model = arms.mtm(), arms.rubbing(arms.mtm_model())
    train = arms.without_cable(arms.recorded(data, "mtm_wpi__train_one", 5.65))
    rows = joined(reduce_rows(robot, model, train))
    weights = weighted(rows, base_parameters(robot, model).chosen).weights
    start = time.perf_counter()
    solve(robot, model, rows, weights, arms.mtm_bounds())
    took = time.perf_counter() - start
    return said(
        "consistent", f"{len(model.columns(robot.spec))} parameters, {took:.2f} s (published 335-869 s)", took <= 5.0
    )


def load(data: Path) -> bool:
    """Known weights on the PSM's insertion column, 0.5355 m from the remote centre."""
    robot, key = arms.psm(), "psm_wpi_payload__one_1.0_scale_"
    unloaded, good = arms.recorded(data, f"{key}no_weight", 16.96), True
    for grams in (105, 205):
        loaded = arms.recorded(data, f"{key}{grams}_grams_insertion", 16.96)
        found = payload(robot, unloaded, loaded, link="L20", lever=0.5355, joints=("q1", "q2"))
        off = 1e3 * found.mass / grams - 1.0
        good &= said("payload", f"{grams} g found as {1e3 * found.mass:.1f} g ({100.0 * off:+.1f} %)", abs(off) <= 0.02)
    return good


def ur10(_: Path) -> bool:
    """UR10 of UNISA, last 30 % held out."""
    recording = smoothed(_unisa("ur10"), 10.0, trim=0.3)
    model = Model(kind="dynamics", friction=("coulomb", "viscous", "offset", "cubic_root"))
    good = True
    for estimator in ("wls", "consistent"):
        found = identify(rg.load("ur10"), recording, model, estimator)
        text = f"{estimator} {100.0 * found.held_out.overall:.2f} % overall {percents(found.held_out.relative)}"
        good &= said("ur10", f"{text} (their model 7.68 %)", found.held_out.overall <= 0.068 and found.refused is None)
    return good


def panda(_: Path) -> bool:
    """Panda of UNISA, gravity and friction, last 30 % held out."""
    recording = smoothed(_unisa("panda"), 3.0, trim=0.5)
    found = identify(rg.load("panda"), recording, Model(kind="gravity+friction"), "ols")
    text = f"{100.0 * found.held_out.overall:.2f} % overall {percents(found.held_out.relative)}"
    return said("panda", text, found.held_out.overall <= 0.066 and found.refused is None)


def _unisa(name: str) -> Recording:
    with np.load(SHIPPED / f"{name}_unisa.npz") as table:
        parts = {part: table[part].astype(float) for part in ("q", "qd", "tau")}
        return Recording(stamps=table["t"], source=f"unisa-acg/inverse-dynamics-solver, {name}", **parts)


def tilts(_: Path) -> bool:
    """Torque of the MTM's joint 2 on a base tilted by 10 degrees, calibrated level and at four more attitudes."""
    robot = rg.load("dvrk_mtmr")
    names = robot.spec.coordinate_names
    cables = tuple(polynomial(name, (0, 1) if name == "shoulder_pitch" else (0, 1, 2, 3, 4)) for name in names[:6])
    model = Model(elements=cables, links=tuple(link.name for link in robot.spec.links[:6]))  # the last has no mass
    poses, trained = _protocol(robot)
    used, level, good = poses[:: len(poses) // 60], [(0.0, 0.0)], True
    tilted = [*level, (10.0, 0.0), (-10.0, 0.0), (0.0, 10.0), (0.0, -10.0)]
    for way, attitudes, rows, study, bar in (
        ("level only, rows of the trained joint", level, trained, 0.27, (0.2, 0.35)),
        ("level only, rows of all joints", level, None, 0.079, (0.05, 0.12)),
        ("with tilts, rows of all joints", tilted, None, 0.0003, (0.0, 0.0006)),
    ):
        recorded = _on_all(poses, attitudes, rows)
        predicted = predict_uncertainty(robot, model, recorded, poses=used).worst[1]
        simulated = _simulated(robot, model, recorded, used)
        text = f"{way}, {recorded.samples} poses: predicted {predicted:.4f} N·m, simulated {simulated:.4f}"
        holds = bar[0] <= predicted <= bar[1] and abs(simulated / predicted - 1.0) < 0.5
        good &= said("tilts", f"{text} (published study: {study})", holds)
    planned = plan(robot, model, poses=60, ranges={"shoulder_pitch": tuple(np.radians([-11.0, 16.0]))})
    alone, tilted = planned.level.worst[1], planned.predicted.worst[1]
    text = f"60 planned poses, the shoulder within the study's range: {alone:.4f} level only, {tilted:.4f} with tilts"
    return good & said("tilts", text, tilted < 0.006 and alone > 0.079)


def _on_all(poses: np.ndarray, attitudes: list[tuple[float, float]], trained: np.ndarray | None) -> Recording:
    """The poses on one attitude after the other; of each the torque of its ``trained`` joint (N,) counts, or all."""
    parts = [_stand(poses, *one) for one in attitudes]
    q, force = (np.vstack([getattr(part, name) for part in parts]) for name in ("q", "specific_force"))
    counted = None if trained is None else np.tile(trained[:, np.newaxis] == range(poses.shape[1]), (len(parts), 1))
    return Recording(stamps=np.arange(float(len(q))), q=q, tau=0.0 * q, specific_force=force, counted=counted)


def _simulated(robot: rg.Robot, model: Model, recorded: Recording, used: np.ndarray) -> float:
    """RMS error of joint 2 in the worst direction after identifications from torques with 0.01 N·m of noise."""
    exact = robot.gravity_torque_batch(recorded.q, -_felt(recorded))
    errors = []
    for seed in range(max(8, 60_000 // recorded.samples)):
        noisy = replace(recorded, tau=exact + 0.01 * np.random.default_rng(seed).normal(size=exact.shape))
        found = identify(robot, noisy, model, held_out=noisy)
        stands = [_stand(used, *tilt) for tilt in ((10.0, 0.0), (-10.0, 0.0), (0.0, 10.0), (0.0, -10.0))]
        pairs = [(found.predict(stand), robot.gravity_torque_batch(used, -_felt(stand))) for stand in stands]
        errors.append([(((mine - true) ** 2)[:, 1]).mean() for mine, true in pairs])
    return float(np.sqrt(np.mean(errors, axis=0).max()))


def _felt(recording: Recording) -> np.ndarray:
    """The specific force, which all recordings of the rows above have."""
    assert recording.specific_force is not None
    return recording.specific_force


def mounted(_: Path) -> bool:
    """Accelerometer mounting and bias beside the moments, 1 % torque noise, 60 poses: tilts of 20 degrees, any axis."""
    off = np.median([_mounted("any", seed) for seed in range(5)], axis=0)
    one = np.median([_mounted("one", seed) for seed in range(5)], axis=0)
    text = f"{off[0]:.2f} deg, {off[1]:.4f} m/s² about any axis"
    worse = f"{one[0]:.1f} deg, {one[1]:.2f} m/s², condition {one[2]:.0f} about one"
    return said("mounting", f"{text}; {worse}", bool(off[0] <= 0.25 and off[1] <= 0.005 and off[2] < 50.0 < one[2]))


def _mounted(way: str, seed: int) -> tuple[float, float, float]:
    robot, random = rg.load("raven2_gold"), np.random.default_rng(seed)
    ranges = np.array([(limit.lower, limit.upper) for limit in robot.spec.coordinate_limits], float)
    q = np.array([random.uniform(low, high, 60) for low, high in ranges]).T
    lean = np.radians(20.0) * random.uniform(-1.0, 1.0, (2, 60)) * [[1.0], [float(way == "any")]]
    force = _force(lean[0], lean[1])
    tau = robot.gravity_torque_batch(q, -force)
    tau += 0.01 * np.sqrt((tau**2).mean(axis=0)) * random.normal(size=tau.shape)
    R, _ = np.linalg.qr(np.eye(3) + 0.3 * random.normal(size=(3, 3)))
    R *= np.sign(np.linalg.det(R))
    bias = 0.1 * random.normal(size=3)
    readings = force @ R + bias + 0.003 * random.normal(size=force.shape)
    found = mounting(robot, Recording(stamps=np.arange(60.0), q=q, tau=tau, specific_force=readings), noise=0.003)
    angle = np.degrees(np.arccos(np.clip((np.trace(found.rotation @ R.T) - 1.0) / 2.0, -1.0, 1.0)))
    return float(angle), float(np.abs(found.bias - bias).max()), found.condition


def regressor(_: Path) -> bool:
    """Regressor of seven joints against pinocchio's, interleaved in one process."""
    try:
        import pinocchio as pin
    except ImportError:
        return said("regressor", "pinocchio is not installed here (pip install pin)", good=False)
    robot, random = rg.load("panda"), np.random.default_rng(0)
    q, qd, qdd = random.uniform(-1.0, 1.0, (3, 7))
    base, out = rg.SpecificForce(0.0, 0.0, GRAVITY), np.empty((7, 70))
    model = _pinocchio(robot)
    data = model.createData()
    theirs = lambda: pin.computeJointTorqueRegressor(model, data, q, qd, qdd)  # noqa: E731
    ours = lambda: robot.inverse_dynamics_regressor(q, qd, qdd, base, out)  # noqa: E731
    ratios, times = [], []
    for _round in range(200):
        mine, other = (_seconds(call) for call in (ours, theirs))
        ratios.append(other / mine)
        times.append((mine, other))
    mine, other = np.min(times, axis=0)
    text = (
        f"{1e6 * mine:.2f} µs, pinocchio {1e6 * other:.2f} µs; {np.median(ratios):.1f} times as fast (median of rounds)"
    )
    return said("regressor", text, bool(np.median(ratios) > 1.0))


def _seconds(call: Callable[[], object], turns: int = 200) -> float:
    start = time.perf_counter()
    for _turn in range(turns):
        call()
    return (time.perf_counter() - start) / turns


def _pinocchio(robot: rg.Robot) -> Any:
    import pinocchio as pin

    model, parent, q = pin.Model(), 0, np.zeros(7)
    before = np.eye(4)
    for place, link in enumerate(robot.spec.links):
        pose = robot.forward_kinematics(q, link.name)
        joint = np.linalg.inv(before) @ pose
        parent = model.addJoint(parent, pin.JointModelRZ(), pin.SE3(joint[:3, :3], joint[:3, 3]), f"joint{place}")
        model.appendBodyToJoint(
            parent, pin.Inertia(link.mass, np.array(link.com), 0.01 * np.eye(3)), pin.SE3.Identity()
        )
        before = pose
    return model


# What the rows stand on


def _force(roll: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    up = np.column_stack([np.sin(pitch), -np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])
    return GRAVITY * up


def _stand(poses: np.ndarray, roll: float, pitch: float) -> Recording:
    """The poses on a base tilted so (degrees)."""
    force = np.repeat(_force(np.radians([roll]), np.radians([pitch])), len(poses), axis=0)
    return Recording(stamps=np.arange(float(len(poses))), q=poses, tau=np.zeros_like(poses), specific_force=force)


def _protocol(robot: rg.Robot) -> tuple[np.ndarray, np.ndarray]:
    """The grid of jhu-dvrk/dvrk-gravity-compensation (dataCollection_config.json), degrees there, and whose it is.

    Poses (N, n) joint by joint, and the joint (N,) that each trains.
    """
    sweeps = (
        (5, range(-40, 41, 2), 4, range(-90, 91, 30)),
        (4, range(-85, 176, 6), 2, range(-10, 21, 5)),
        (3, range(-80, 191, 6), 2, range(-10, 21, 5)),
        (2, range(-34, 35), 1, range(-14, 21, 2)),
        (1, range(-11, 17), 2, (0,) * 10),
        (0, range(-40, 8), 1, (0,) * 10),
    )
    poses, trained = [], []
    for joint, along, other, steps in sweeps:
        for step in steps:
            for value in along:
                pose = np.zeros(robot.n)
                pose[4] = 90.0
                pose[joint], pose[other] = value, step
                if joint != 2 or -11 <= value + step <= 16:
                    poses.append(pose)
                    trained.append(joint)
    return np.radians(poses), np.array(trained)


ROWS = {
    "ranks": ranks, "mtm": mtm, "psm": psm, "consistent": consistent, "payload": load, "ur10": ur10, "panda": panda,
    "tilts": tilts, "mounting": mounted, "regressor": regressor,
}  # fmt: skip
NEED_DATA = ("mtm", "psm", "consistent", "payload")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"of {', '.join(ROWS)} (default all)")
    parser.add_argument("--data", type=Path, default=Path("data"), metavar="FOLDER", help="holds dvrk/dvrk_real.npz")
    args = parser.parse_args()
    if unknown := set(args.rows) - set(ROWS):
        parser.error(f"no row {', '.join(sorted(unknown))}; there are {', '.join(ROWS)}")
    good, left_out = True, 0
    for name in args.rows or ROWS:
        if name in NEED_DATA and not (args.data / "dvrk" / "dvrk_real.npz").exists():
            print(f"{name:14s} left out: {args.data}/dvrk/dvrk_real.npz is not there")
            left_out += 1
            continue
        good &= ROWS[name](args.data)
    if left_out:
        print(f"{left_out} of {len(args.rows or ROWS)} rows were left out for want of data: nothing is said of them")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
