"""Resolved rates that climb manipulability: the experiment of Haviland and Corke on Panda and UR5.

`python benches/manipulability.py` servoes random problems with three controllers and prints what it finds beside what
J. Haviland and P. Corke, "A purely-reactive manipulability-maximising motion controller", arXiv 2002.11901, published
(the table of github.com/jhavl/mmc, branch gh-pages). Their goals are not published. Here they are the tool's poses at
joint positions drawn evenly within the limits (of the UR5 within half a turn), all from one start.

A problem is 1000 steps of 50 ms at the most, the velocity is the pose error per second, and it has arrived when
Σ|error| < 0.1 (m, rad). It fails when it leaves the joint limits, or does not arrive.

| controller | what it is |
|---|---|
| plain | resolved rate with the pseudo-inverse, no limits |
| theirs | the published programme: Y = 0.01, damper from 0.9 rad to 0.05 rad, no floor |
| ours | the same programme, Y = 0.003, damper from 0.3 rad to 0.01 rad, half the task's way guaranteed |
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from comparison import command
from rich.progress import track
from rich.table import Table

import ravengc
from ravengc._core import _ascend, _manipulability
from ravengc.reference.box_qp import velocity_box

if TYPE_CHECKING:
    import numpy.typing as npt

    Array = npt.NDArray[np.float64]

DT, STEPS, ARRIVED = 0.05, 1000, 0.1

PUBLISHED = {
    "panda": {"plain": (0.0693, 0.0692, 12.4), "theirs": (0.0942, 0.0955, 8.0)},
    "ur5": {"plain": (0.0433, 0.0381, 39.7), "theirs": (0.0563, 0.0460, 25.6)},
}
"""Mean and final manipulability, and failures in %, of resolved rate and of their controller."""

STARTS = {"panda": (0.0, -0.3, 0.0, -2.2, 0.0, 2.0, math.pi / 4.0), "ur5": (0.0, -1.2, 1.6, -1.9, -1.5, 0.0)}


@dataclass(frozen=True)
class Scene:
    """An arm, what it must keep to, and where it goes."""

    robot: ravengc.Robot
    lower: Array
    upper: Array
    rate: Array
    start: Array
    goals: list[Array]


@dataclass(frozen=True)
class Run:
    """One problem: whether the goal was reached, and how."""

    arrived: bool
    left: bool
    too_fast: bool
    mean: float
    final: float
    steps: int
    at_limit: bool


def scene(name: str, count: int) -> Scene:
    robot = ravengc.load(name)
    limits = robot.spec.coordinate_limits
    lower, upper, rate = (
        np.array([getattr(limit, side) for limit in limits], float) for side in ("lower", "upper", "velocity")
    )
    within = (np.maximum(lower, -math.pi), np.minimum(upper, math.pi))
    drawn = np.random.default_rng(0).uniform(*within, (count, len(limits)))
    return Scene(robot, lower, upper, rate, np.array(STARTS[name]), [robot.forward_kinematics(q) for q in drawn])


def pose_error(now: Array, goal: Array) -> Array:
    """Way to go: displacement, then the rotation vector, in base axes."""
    turn = goal[:3, :3] @ now[:3, :3].T
    (_, xy, xz), (yx, _, yz), (zx, zy, _) = turn.tolist()
    axis = np.array([zy - yz, xz - zx, yx - xy])
    twice_sine = math.sqrt(float(axis @ axis))
    angle = math.atan2(twice_sine, float(np.trace(turn)) - 1.0)
    scale = angle / twice_sine if twice_sine > 1e-12 else 0.5
    found: Array = np.concatenate([goal[:3, 3] - now[:3, 3], scale * axis])
    return found


def plain(scene: Scene, q: Array, rows: Array, v: Array) -> Array:
    del scene, q
    return np.asarray(np.linalg.lstsq(rows, v, rcond=1e-12)[0], np.float64)


@dataclass(frozen=True)
class Climbing:
    """The programme with its settings."""

    effort: float
    progress: float
    damper: tuple[float, float, float]

    def __call__(self, scene: Scene, q: Array, rows: Array, v: Array) -> Array:
        lower, upper = velocity_box(q, (scene.lower, scene.upper, scene.rate), self.damper, DT)
        gradient = _manipulability(scene.robot, q)[1]
        settings = (self.effort, 1.0 / float(np.abs(v).sum()), self.progress)
        found: Array = _ascend(rows, v, gradient, settings, lower, upper)[0]
        return found


CONTROLLERS: dict[str, Any] = {
    "plain": plain,
    "theirs": Climbing(0.01, 0.0, (0.9, 0.05, 1.0)),
    "ours": Climbing(0.003, 0.5, (0.3, 0.01, 1.0)),
}


def servo(scene: Scene, goal: Array, controller: Any) -> Run:
    """From the start to the goal."""
    q, met, too_fast, left = scene.start.copy(), [], False, False
    for _ in range(STEPS):
        met.append(_manipulability(scene.robot, q)[0])
        v = pose_error(scene.robot.forward_kinematics(q), goal)
        if left or float(np.abs(v).sum()) < ARRIVED:
            break
        rates = controller(scene, q, scene.robot.jacobian(q), v)
        too_fast |= bool(np.any(np.abs(rates) > scene.rate + 1e-9))
        q = q + DT * rates
        left = bool(np.any((q < scene.lower - 1e-9) | (q > scene.upper + 1e-9)))
    arrived = not left and float(np.abs(v).sum()) < ARRIVED
    near = bool(np.any(np.minimum(q - scene.lower, scene.upper - q) < 0.1))
    return Run(arrived, left, too_fast, float(np.mean(met)), met[-1], len(met), near)


def summary(runs: list[Run], plainly: list[Run]) -> dict[str, float]:
    """What is printed; gains are over resolved rate, of all problems and of those that both solve."""
    both = [(run.mean, other.mean) for run, other in zip(runs, plainly, strict=True) if run.arrived and other.arrived]
    failed = [run for run in runs if not run.arrived]
    ours, theirs = np.mean(both, axis=0)
    return {
        "mean": float(np.mean([run.mean for run in runs])),
        "final": float(np.mean([run.final for run in runs])),
        "gain_all": 100.0 * float(np.mean([run.mean for run in runs]) / np.mean([run.mean for run in plainly]) - 1.0),
        "gain_both": 100.0 * float(ours / theirs - 1.0),
        "failed": 100.0 * len(failed) / len(runs),
        "left_limits": 100.0 * float(np.mean([run.left for run in runs])),
        "too_fast": 100.0 * float(np.mean([run.too_fast for run in runs])),
        "failed_at_limit": 100.0 * float(np.mean([run.at_limit for run in failed])) if failed else 0.0,
        "seconds_to_goal": DT * float(np.mean([run.steps for run in runs if run.arrived])),
    }


def show(results: dict[str, dict[str, dict[str, float]]]) -> None:
    table = Table(title="manipulability on the way, and who arrives (in brackets: published)")
    for heading in ("arm", "controller", "mean m", "final m", "gain, all", "gain, both arrive", "fails", "at a limit",
                    "left limits", "too fast", "to goal"):  # fmt: skip
        table.add_column(heading, justify="left" if heading in {"arm", "controller"} else "right")
    for name, controllers in results.items():
        for controller, found in controllers.items():
            mean, final, failed = PUBLISHED[name].get(controller, (None, None, None))
            table.add_row(
                name, controller, beside(found["mean"], ".4f", mean), beside(found["final"], ".4f", final),
                f"{found['gain_all']:+.1f} %", f"{found['gain_both']:+.1f} %",
                beside(found["failed"], ".1f", failed, " %"),
                f"{found['failed_at_limit']:.0f} %", f"{found['left_limits']:.1f} %", f"{found['too_fast']:.1f} %",
                f"{found['seconds_to_goal']:.1f} s",
            )  # fmt: skip
    command.console(160).print(table)


def beside(found: float, form: str, published: float | None, unit: str = "") -> str:
    return f"{found:{form}}{unit}" + (f" ({published:{form}})" if published is not None else "")


def main() -> int:
    parser = command.parser(__doc__, "manipulability")
    parser.add_argument("--problems", type=int, default=1000, help="per arm (default 1000)")
    arguments = parser.parse_args()
    results: dict[str, dict[str, dict[str, float]]] = {}
    every: dict[str, dict[str, list[dict[str, Any]]]] = {}
    for name in STARTS:
        arm = scene(name, arguments.problems)
        runs = {
            controller: [servo(arm, goal, law) for goal in track(arm.goals, f"{name} {controller}")]
            for controller, law in CONTROLLERS.items()
        }
        results[name] = {controller: summary(found, runs["plain"]) for controller, found in runs.items()}
        every[name] = {controller: [asdict(run) for run in found] for controller, found in runs.items()}
    show(results)
    command.write(arguments.json, {"summary": results, "runs": every})
    ours = results["panda"]["ours"]
    held = ours["gain_all"] >= 35.0 and ours["failed"] <= 12.0 and ours["too_fast"] == 0.0
    print(f"Panda: gain >= +35 %, failures <= 12 %, no velocity limit exceeded: {'held' if held else 'MISSED'}")
    return 0 if held else 1


if __name__ == "__main__":
    raise SystemExit(main())
