"""Newton-Euler against Lagrange-Euler for an arm on a ship: the same torques, at what cost.

For Lagrange the ship becomes joints of its own, roll, pitch and heave, before the arm's, and the arm's torques are the
last rows of d/dt dT/dqd - dT/dq + dU/dq. Newton-Euler takes the same motion as that of the base: specific force,
angular velocity, angular acceleration. Both are exact, so they agree to rounding.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

import ravengc
from ravengc import reference
from ravengc.experiments.base_rows import base_motion
from ravengc.experiments.drawing import PALETTE, legend_below, line_axes
from ravengc.experiments.experiment import Experiment, Finding, Outcome, Table, finding
from ravengc.experiments.settings import Settings, setting
from ravengc.experiments.ship import Ship, ship_motion
from ravengc.spec import JointOrigin, LinkSpec, Pose

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from ravengc.spec import JointKind, RobotSpec, Vector

__all__ = ["NEWTON_EULER", "NewtonEuler", "on_ship"]

Array = NDArray[np.float64]

AGREES = 1e-10
TORQUES = ("core", "newton", "lagrange")
METHODS = {
    "core": "Newton-Euler, compiled core (one call from Python)",
    "newton": "Newton-Euler, NumPy",
    "mass": "mass matrix alone, NumPy: the least that a Lagrange form must build",
    "lagrange": "Lagrange-Euler, NumPy (derivatives by complex step)",
}


@dataclass(frozen=True, kw_only=True)
class NewtonEuler(Settings):
    """Settings of ``newton-euler``."""

    states: int = setting(20, 1, 10_000, "", "random states of the arm, at moments of the ship's motion")
    seed: int = setting(0, 0, 2**63 - 1, "", "seed of the states")
    repeats: int = setting(5, 1, 1000, "", "rounds of the timing; a round runs every method once per state")


def on_ship(spec: RobotSpec, place: tuple[float, ...]) -> RobotSpec:
    """Return the arm with heave, roll and pitch of its ship as three more joints, massless, before its own.

    ``place`` (m) is the arm's base from the centre of rotation, in the ship's axes. The spec's base must be frame 0.
    """

    def joint(name: str, parent: str | None, kind: JointKind, axis: Vector) -> LinkSpec:
        return LinkSpec(name=name, parent=parent, joint=kind, placement=JointOrigin(axis=axis), massless=True)

    x, y, z = place
    on_deck = Pose(translation=(x, y, z))
    ship = (
        joint("heave", None, "prismatic", (0.0, 0.0, 1.0)),
        joint("roll", "heave", "revolute", (1.0, 0.0, 0.0)),
        joint("pitch", "roll", "revolute", (0.0, 1.0, 0.0)),
        LinkSpec(name="deck", parent="pitch", joint="fixed", placement=JointOrigin(pose=on_deck), massless=True),
    )
    first, *others = spec.links
    return replace(spec, name=f"{spec.name} on a ship", links=(*ship, replace(first, parent="deck"), *others))


def _tasks(settings: NewtonEuler) -> list[NewtonEuler]:
    return [settings]


def _run(settings: NewtonEuler) -> dict[str, Array]:
    """Torques by each method, and the median time of one evaluation: interleaved, so all see the same machine."""
    robot, ship = ravengc.load("pa10"), Ship()
    extended = on_ship(robot.spec, ship.place)
    random = np.random.default_rng(settings.seed)
    moments = random.uniform(0.0, ship.duration_s, settings.states)
    rows, _ = ship_motion(ship, moments)
    arm = random.uniform(-1.5, 1.5, (settings.states, 3, robot.n))
    both = np.concatenate((np.stack([_ship_state(ship, moment) for moment in moments]), arm), axis=2)
    states = [_State(*arm[i], *both[i], base_motion(rows[i]), rows[i]) for i in range(settings.states)]  # type: ignore[call-arg]
    gravity = (0.0, 0.0, -ship.gravity)
    methods: dict[str, Method] = {
        "core": lambda s: robot.inverse_dynamics(s.q, s.qd, s.qdd, s.base),
        "newton": lambda s: reference.inverse_dynamics(robot.spec, s.q, s.qd, s.qdd, s.row[:3], s.row[3:6], s.row[6:]),
        "mass": lambda s: reference.mass_matrix(extended, s.all_q),
        "lagrange": lambda s: reference.lagrangian_torque(extended, s.all_q, s.all_qd, s.all_qdd, gravity),
    }
    torques = {name: np.stack([methods[name](state)[-robot.n :] for state in states]) for name in TORQUES}
    return {**torques, **_times(methods, states, settings.repeats)}


class _State(NamedTuple):
    """A state of the arm, the same with the ship's joints before its own, and the motion of the arm's base."""

    q: Array
    qd: Array
    qdd: Array
    all_q: Array
    all_qd: Array
    all_qdd: Array
    base: ravengc.BaseMotion
    row: Array


Method = Callable[[_State], Array]


def _ship_state(ship: Ship, moment: float) -> Array:
    """Positions, velocities and accelerations of heave, roll and pitch, (3, 3)."""
    amplitude = np.array((ship.heave, *np.deg2rad((ship.roll_deg, ship.pitch_deg))))
    rate = 2.0 * np.pi * np.array((ship.heave_hz, ship.roll_hz, ship.pitch_hz))
    sine, cosine = np.sin(rate * moment), np.cos(rate * moment)
    return np.stack((amplitude * sine, amplitude * rate * cosine, -amplitude * rate**2 * sine))


def _times(methods: dict[str, Method], states: Sequence[_State], repeats: int) -> dict[str, Array]:
    """Processor time (s) of single evaluations, all methods in turn for every state and round."""
    seconds: dict[str, list[int]] = {f"seconds_{name}": [] for name in methods}
    for state in [*states] * repeats:
        for name, method in methods.items():
            begun = time.thread_time_ns()
            method(state)
            seconds[f"seconds_{name}"].append(time.thread_time_ns() - begun)
    return {name: 1e-9 * np.array(values) for name, values in seconds.items()}


def _combine(settings: NewtonEuler, results: Sequence[dict[str, Array]]) -> Outcome:
    (found,) = results
    largest = np.abs(found["lagrange"]).max()
    numbers = {f"{name}_disagreement": float(np.abs(found[name] - found["lagrange"]).max() / largest)
               for name in ("core", "newton")}  # fmt: skip
    median = {name: float(np.median(found[f"seconds_{name}"])) for name in METHODS}
    rows = tuple((text, f"{1e6 * median[name]:.4g}", _disagreement(numbers, name)) for name, text in METHODS.items())
    table = Table(
        "One evaluation of the torques of a six-joint arm on a ship",
        ("method", "median processor time, µs", "disagreement with Lagrange, relative to the largest torque"),
        rows,
        f"{settings.states} states x {settings.repeats} rounds in one interleaved run on this machine: times are "
        "information and differ from run to run. Both NumPy texts are written to be read, not to be fast. Lagrange "
        "differentiates the mass matrix for nine coordinates, three of them the ship's.",
    )
    series = {f"seconds_{name}": found[f"seconds_{name}"] for name in METHODS}
    return Outcome(numbers, (table,), tuple(_findings(numbers, median)), series)


def _disagreement(numbers: dict[str, float], name: str) -> str:
    return f"{numbers[f'{name}_disagreement']:.1e}" if f"{name}_disagreement" in numbers else ""


def _findings(numbers: dict[str, float], median: dict[str, float]) -> list[Finding]:
    worst = max(numbers.values())
    return [
        finding(
            "Newton-Euler and Lagrange-Euler on the ship: largest disagreement",
            worst,
            "of the largest torque",
            stated="both agree (Sadraei & Moghaddam)",
            expected=0.0,
            tolerance=AGREES,
            verdict="reproduced" if worst <= AGREES else "not reproduced",
            why="Both are exact; what is left is rounding. Lagrange has no term for the base: the ship's motion enters "
            "as three more coordinates.",
        ),
        finding(
            "processor time of Lagrange-Euler over that of Newton-Euler, both NumPy (median, this run)",
            median["lagrange"] / median["newton"],
            "times",
            stated="Newton-Euler needs less computation time (Sadraei & Moghaddam)",
            verdict="reproduced" if median["newton"] < median["lagrange"] else "not reproduced",
            why="The recursion visits every link once; Lagrange builds and differentiates the mass matrix. The ratio "
            "depends on how each is written: a symbolic Lagrange form would be nearer, see the mass matrix alone.",
        ),
    ]


def _draw(figure: Figure, outcome: Outcome) -> None:
    axes = figure.subplots()
    line_axes(axes, "processor time of one evaluation, µs (log scale)", "share of evaluations done within the time")
    for i, (name, text) in enumerate(METHODS.items()):
        sorted_times = 1e6 * np.sort(outcome.series[f"seconds_{name}"])
        axes.semilogx(sorted_times, np.linspace(0.0, 1.0, len(sorted_times)), label=text, color=PALETTE[i])
    legend_below(figure, axes)


NEWTON_EULER = Experiment(
    name="newton-euler",
    title="Newton-Euler against Lagrange-Euler",
    source="Sadraei & Moghaddam 2013 (ref [7] of the paper); Wronka & Dunnigan 2011 (ref [6])",
    about="The torques of a moving arm on a moving ship by both formulations: whether they agree, and what they cost.",
    settings=NewtonEuler,
    tasks=_tasks,
    run=_run,
    combine=_combine,
    draw=_draw,
    timed=True,
)
