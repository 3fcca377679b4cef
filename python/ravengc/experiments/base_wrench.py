"""Joint torques from a force/torque sensor under the base: Morel & Dubowsky; Iagnemma and others.

The sensor measures the wrench (F, M) that the mount exerts on the arm. Subtract what the links up to joint i need, and
the component along joint i is that joint's torque, without the friction of its drive:

    tau_i = z_i . (M - p_i x F - sum over k < i of (M_k - p_i x F_k)),     prismatic: tau_i = z_i . (F - sum F_k)

At rest the links' wrenches are their weights, F_k = m_k f and M_k = m_k r_k x f, with f from the base's accelerometer.
On a moving base they are the wrenches of the links under the full motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc.experiments.base_rows import Rocking, base_motion, held_rows
from ravengc.experiments.drawing import PALETTE, legend_below, line_axes
from ravengc.experiments.experiment import Experiment, Finding, Outcome, Table, finding
from ravengc.experiments.raven import INERTIAS, JOINTS, base_axes, held_pose, raven
from ravengc.experiments.settings import Settings, setting
from ravengc.reference.kinematics import joint_axes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from ravengc.spec import RobotSpec

__all__ = ["BASE_WRENCH", "BaseWrench", "torque_from_wrench"]

Array = NDArray[np.float64]

ROBOTS = ("raven2_gold", "pa10", "panda", "rrbot")
EXACT = 1e-12
WAYS = {
    "level": "links weighed with level gravity",
    "accelerometer": "links weighed with the accelerometer",
    "full": "links' wrenches under the full motion",
}


@dataclass(frozen=True, kw_only=True)
class BaseWrench(Settings):
    """Settings of ``base-wrench``."""

    states: int = setting(200, 1, 100_000, "", "random states of each robot")
    seed: int = setting(0, 0, 2**63 - 1, "", "seed of the random states")
    mean_deg: float = setting(15.0, -90.0, 90.0, "deg", "rocking RAVEN: mean angle")
    amplitude_deg: float = setting(5.0, 0.1, 45.0, "deg", "rocking RAVEN: amplitude")
    hz: float = setting(1.0, 0.01, 20.0, "Hz", "rocking RAVEN: frequency")
    lever: float = setting(0.3, 0.0, 5.0, "m", "rocking RAVEN: pivot below the base origin")
    samples: int = setting(500, 16, 100_000, "", "rocking RAVEN: samples of one period")


def torque_from_wrench(spec: RobotSpec, q: Array, wrench: Array, inner: Sequence[Array]) -> Array:
    """Torques (n,) from the base's ``wrench`` (6,) less ``inner[i]`` (6,), that of the links before joint i.

    Wrenches are force, then moment about the base origin, that the mount exerts, in base axes.
    """
    torque = np.zeros(len(q))
    for i, (link, (axis, point)) in enumerate(zip(spec.moving_links, joint_axes(spec, q), strict=True)):
        force, moment = np.split(wrench - inner[i], 2)
        torque[i] = axis @ (force if link.joint == "prismatic" else moment - np.cross(point, force))
    return torque


def inner_robots(spec: RobotSpec) -> list[ravengc.Robot | None]:
    """For each joint of a chain, the robot of which only the links before that joint have mass; None for the first."""
    robots: list[ravengc.Robot | None] = [None]
    for count in range(1, len(spec.links)):
        light = [replace(link, mass=0.0, inertia=(0.0,) * 6, massless=True) for link in spec.links[count:]]
        robots.append(ravengc.Robot(replace(spec, links=(*spec.links[:count], *light))))
    return robots


def _tasks(settings: BaseWrench) -> list[tuple[BaseWrench, str]]:
    return [(settings, name) for name in (*ROBOTS, "rocking")]


def _run(task: tuple[BaseWrench, str]) -> dict[str, Array]:
    settings, name = task
    return _rocking(settings) if name == "rocking" else _random_states(settings, name)


def _random_states(settings: BaseWrench, name: str) -> dict[str, Array]:
    """Largest error of the torque in random states, relative to the largest torque: at rest, and all in motion."""
    robot = ravengc.load(name)
    random = np.random.default_rng((settings.seed, ROBOTS.index(name)))
    inner = inner_robots(robot.spec)
    worst = np.zeros(2)
    for _ in range(settings.states):
        q, qd, qdd = random.uniform(-1.5, 1.5, (3, robot.n))
        row = np.concatenate((random.uniform(-12.0, 12.0, 3), random.uniform(-2.0, 2.0, 3), random.uniform(-5, 5, 3)))
        zero = np.zeros(robot.n)
        at_rest = ravengc.BaseMotion(specific_force=row[:3])
        for kind, state in enumerate(((q, zero, zero, at_rest), (q, qd, qdd, base_motion(row)))):
            expected = robot.inverse_dynamics(*state)
            inner_wrenches = [np.zeros(6) if one is None else one.base_wrench(*state) for one in inner]
            error = torque_from_wrench(robot.spec, q, robot.base_wrench(*state), inner_wrenches) - expected
            worst[kind] = max(worst[kind], np.abs(error).max() / np.abs(expected).max())
    return {"worst": worst}


def _rocking(settings: BaseWrench) -> dict[str, Array]:
    """RAVEN held on a rocking base: torques from the wrench, the links before each joint weighed in three ways."""
    robot, pose = raven(), held_pose()
    x0, _, z0 = base_axes()
    mean, amplitude = np.deg2rad((settings.mean_deg, settings.amplitude_deg))
    up = ravengc.STANDARD_GRAVITY * x0
    motion = Rocking(
        z0, -settings.lever * x0, up, mean=mean, amplitude=amplitude, hz=settings.hz, samples=settings.samples
    )
    rows = motion.rows()
    q, zero = np.tile(pose, (len(rows), 1)), np.zeros((len(rows), robot.n))
    truth = robot.inverse_dynamics_batch(q, zero, zero, rows)
    wrench = robot.base_wrench_batch(q, zero, zero, rows)
    weighed = {
        "level": held_rows(np.tile(up, (len(rows), 1))),
        "accelerometer": held_rows(rows[:, :3]),
        "full": rows,
    }
    size = np.sqrt((truth**2).mean(0))
    result = {"time": motion.time, "size": size}
    for way, links_rows in weighed.items():
        inner = np.stack(
            [
                np.zeros((len(rows), 6)) if one is None else one.base_wrench_batch(q, zero, zero, links_rows)
                for one in inner_robots(robot.spec)
            ],
            axis=1,
        )
        error = np.stack([torque_from_wrench(robot.spec, pose, *pair) for pair in zip(wrench, inner, strict=True)])
        error -= truth
        result[way] = 100.0 * np.sqrt((error**2).mean(0)) / size
        result[f"trace_{way}"] = error[:, 1]
    return result


def _combine(settings: BaseWrench, results: Sequence[dict[str, Array]]) -> Outcome:
    worst = {name: found["worst"] for name, found in zip(ROBOTS, results, strict=False)}
    rocking = results[-1]
    numbers = {f"{name}_{kind}": float(worst[name][i]) for name in ROBOTS for i, kind in enumerate(("rest", "moving"))}
    numbers |= {f"rocking_{way}_j{j + 1}": float(rocking[way][j]) for way in WAYS for j in range(3)}
    agreement = Table(
        "Largest error of the torques in random states, relative to the largest torque",
        ("robot", "at rest", "arm and base in motion"),
        tuple((name, *(f"{value:.1e}" for value in worst[name])) for name in ROBOTS),
        f"{settings.states} states each: joints, rates and accelerations within 1.5 (SI), specific force within 12 "
        "m/s² on each axis, angular velocity within 2 rad/s, angular acceleration within 5 rad/s².",
    )
    rows = tuple((text, *(f"{value:.2f}" for value in rocking[way])) for way, text in WAYS.items())
    rocked = Table(
        "RAVEN on a rocking base: RMS error of the torques from the wrench, % of the RMS torque",
        ("what is subtracted for the links before the joint", *JOINTS),
        rows,
        f"Joint 1 has no link before it: its torque follows from the wrench alone, whatever the base does. {INERTIAS}.",
    )
    series = {key: rocking[key] for key in ("time", *(f"trace_{way}" for way in WAYS))}
    return Outcome(numbers, (agreement, rocked), tuple(_findings(numbers)), series)


def _findings(numbers: dict[str, float]) -> list[Finding]:
    worst = {kind: max(numbers[f"{name}_{kind}"] for name in ROBOTS) for kind in ("rest", "moving")}
    stated = "a force/torque sensor under the base gives the joints' torques, free of friction (ref [9] of the paper)"
    return [
        finding(
            "torques from the base wrench, at rest: largest relative error",
            worst["rest"],
            stated=stated,
            expected=0.0,
            tolerance=EXACT,
            verdict="reproduced" if worst["rest"] <= EXACT else "not reproduced",
            why="The weights of the links before the joint are subtracted; the identity is exact.",
        ),
        finding(
            "torques from the base wrench, arm and base in motion: largest relative error",
            worst["moving"],
            expected=0.0,
            tolerance=EXACT,
            why="The same identity with the links' full wrenches: it needs the base's angular velocity and "
            "acceleration as well as its specific force.",
        ),
        finding(
            "RAVEN rocking at 1 Hz, joint 2, links weighed with the accelerometer alone",
            numbers["rocking_accelerometer_j2"],
            "% of RMS torque",
            why="The links' angular acceleration is left out; with level gravity the error is "
            f"{numbers['rocking_level_j2']:.0f} %.",
        ),
    ]


def _draw(figure: Figure, outcome: Outcome) -> None:
    axes = figure.subplots()
    line_axes(axes, "time, s", "joint 2: error of the torque from the base wrench on a rocking base, N·m")
    for (way, text), colour in zip(WAYS.items(), (PALETTE[1], PALETTE[0], PALETTE[2]), strict=True):
        axes.plot(outcome.series["time"], outcome.series[f"trace_{way}"], label=text, color=colour)
    legend_below(figure, axes)


BASE_WRENCH = Experiment(
    name="base-wrench",
    title="Joint torques from a force/torque sensor under the base",
    source="Iagnemma, Burn, Wilhelm & Dubowsky 2000 (ref [9] of the paper); Morel & Dubowsky, US 5,767,648",
    about="The other route to friction-free torques: measure the wrench under the arm, subtract gravity with the "
    "base's accelerometer, and read the joints' torques off it, also on a base that moves.",
    settings=BaseWrench,
    tasks=_tasks,
    run=_run,
    combine=_combine,
    draw=_draw,
)
