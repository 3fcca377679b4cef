"""Static poses over the range of joint 1 at base tilts about its axis: the paper's validation, Figures 7 and 8.

Each law holds each pose; the share of the PD term in the total torque says what its gravity term leaves. Tilting the
base about joint 1 turns gravity in the arm's frame, so without friction the share follows from geometry alone: static
gravity leaves g(q, tilted) - g(q, level) whatever the gains are.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.experiments.drawing import LAW_COLOURS, LAW_TITLES, legend_below, line_axes
from ravengc.experiments.experiment import Experiment, Finding, Outcome, Table, finding
from ravengc.experiments.mujoco_friction import SOFTNESS, SoftTrial, run_soft
from ravengc.experiments.raven import INERTIAS, Path, base_axes, held_pose, raven, still_path, tilted_gravity
from ravengc.experiments.settings import Settings, setting
from ravengc.experiments.trial import PLANT_NOTE, Friction, Sensing, Trial, run_trial
from ravengc.sim import tilted

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

__all__ = ["STATIC_POSES", "StaticPoses", "predicted_share"]

Array = NDArray[np.float64]

RATE_HZ = 1000.0
LAWS = ("pd", "pd+sg", "pd+dg")
NO_FRICTION = (0.0, 0.0, 0.0)
SOFTEST, *_, STIFFEST = SOFTNESS
COUNTED = 2
"""Shares are of joints 1 and 2 together; the rail of joint 3 carries a force, in another unit."""
REFERENCE = {0.0: 0.0, 5.0: 13.0, 10.0: 24.4, 15.0: 34.2, 20.0: 42.6, 25.0: 49.8}
"""PD share of PD+SG without friction, %, by tilt: an independent simulation."""
FRICTION_NOTE = (
    "With friction the share depends on how the pose was come to: a joint stops wherever the PD torque is within the "
    "friction of the gravity error. Released in the pose it stops early, so friction carries part of that error for "
    "good; approached from one side or the other, friction adds to it or takes from it. Compliant friction, as in "
    "MuJoCo's frictionloss, creeps until nothing is left for it to carry, and the share is the frictionless one."
)
MATCHES = 0.05
"""N m: a difference of torques that a figure does not show."""
STATED_8 = "the PD share of PD+SG grows with the tilt, that of PD+DG stays near zero (Fig. 8)"


@dataclass(frozen=True, kw_only=True)
class StaticPoses(Settings):
    """Settings of ``static-poses``."""

    tilts_deg: tuple[float, ...] = setting((0.0, 5.0, 10.0, 15.0, 20.0, 25.0), -90.0, 90.0, "deg", "base tilts")
    j1_deg: tuple[float, ...] = setting(
        (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0), 0.0, 90.0, "deg", "poses along joint 1's range"
    )
    j2_deg: float = setting(90.0, 45.0, 135.0, "deg", "elbow")
    d3: float = setting(0.33, 0.23, 0.56, "m", "insertion")
    hold_s: float = setting(1.5, 0.1, 60.0, "s", "how long each pose is held")
    count_s: float = setting(0.5, 0.05, 60.0, "s", "how much of its end is counted")
    coulomb: tuple[float, ...] = setting(
        (0.5, 0.3, 2.0), 0.0, 100.0, "N m, N m, N", "Coulomb friction of the second series", count=3
    )
    approach_deg: float = setting(1.0, 0.1, 5.0, "deg", "with friction: from how far off a pose is approached")
    noise: float = setting(0.0, 0.0, 1.0, "m/s^2", "noise of the accelerometer")
    seed: int = setting(0, 0, 2**63 - 1, "", "seed of the noise")


class _Held(NamedTuple):
    """One pose to hold, approached from ``approach`` deg away (0: it starts there).

    ``friction`` is "none", "stick", or the name of a :data:`SOFTNESS` for MuJoCo's own friction.
    """

    tilt: float
    law: str
    j1: float
    friction: str
    approach: float


def _tasks(settings: StaticPoses) -> list[tuple[StaticPoses, list[_Held]]]:
    """Without friction all laws; with friction PD+SG, from the pose itself, from both sides, and with soft friction.

    PD alone, whose share is 100 %, is run on the first and the last tilt, for the torques of Figure 7.
    """
    away = settings.approach_deg
    series = [(law, "none", 0.0) for law in LAWS]
    series += [("pd+sg", "stick", side) for side in (0.0, -away, away)]
    series += [("pd+sg", softness, 0.0) for softness in (SOFTEST, STIFFEST)]
    ends = (settings.tilts_deg[0], settings.tilts_deg[-1])
    return [
        (settings, [_Held(tilt, law, j1, friction, side) for j1 in settings.j1_deg])
        for tilt, (law, friction, side) in itertools.product(settings.tilts_deg, series)
        if law != "pd" or tilt in ends
    ]


def _run(task: tuple[StaticPoses, list[_Held]]) -> dict[str, Array]:
    """Mean PD and gravity torques (poses, 3) of the counted time, and the squares' means that the shares take."""
    settings, poses = task
    counted = round(settings.count_s * RATE_HZ)
    found: dict[str, list[Array]] = {"pd": [], "gravity": [], "pd_square": [], "total_square": []}
    for held in poses:
        soft = held.friction in SOFTNESS
        record = run_soft(_soft_trial(settings, held)) if soft else run_trial(_trial(settings, held))
        pd, total = record.tau_pd[-counted:], record.tau[-counted:]
        found["pd"].append(pd.mean(0))
        found["gravity"].append((total - pd).mean(0))
        found["pd_square"].append((pd**2).mean(0))
        found["total_square"].append((total**2).mean(0))
    return {name: np.stack(values) for name, values in found.items()}


def _path(settings: StaticPoses, held: _Held) -> Path:
    pose = held_pose(held.j1, settings.j2_deg, settings.d3)
    return still_path(pose, max(settings.hold_s, settings.count_s), RATE_HZ)


def _soft_trial(settings: StaticPoses, held: _Held) -> SoftTrial:
    path, axis = _path(settings, held), tuple(base_axes()[2])
    return SoftTrial(held.law, held.tilt, axis, path, Friction(settings.coulomb), held.friction)


def _trial(settings: StaticPoses, held: _Held) -> Trial:
    path = _path(settings, held)
    start = path.q[0] + np.array((np.deg2rad(held.approach), np.deg2rad(held.approach), 0.0))
    sensing = Sensing(latency_s=0.0, noise=settings.noise, seed=settings.seed)
    friction = Friction(settings.coulomb if held.friction == "stick" else NO_FRICTION)
    return Trial(held.law, tilted(held.tilt, base_axes()[2]), path, friction, sensing, tuple(start))


def predicted_share(settings: StaticPoses, tilt_deg: float, coulomb: Sequence[float] = NO_FRICTION) -> float:
    """PD share of PD+SG (%) by statics: PD gives g(tilted) - g(level), less what friction holds.

    An arm that starts in the pose at rest lets friction carry the first ``coulomb`` (N m) of the difference.
    """
    poses = np.stack([held_pose(j1, settings.j2_deg, settings.d3) for j1 in settings.j1_deg])
    level, true = (raven().gravity_torque_batch(poses, tilted_gravity(tilt)) for tilt in (0.0, tilt_deg))
    missing = np.sign(true - level) * np.maximum(np.abs(true - level) - np.array(coulomb), 0.0)
    return _share((missing**2), (level + missing) ** 2)


def _share(pd_square: Array, total_square: Array) -> float:
    """RMS of the PD term over RMS of the total, joints 1 and 2, over all poses, %."""
    pd, total = (np.sqrt(square[:, :COUNTED].mean(0)) for square in (pd_square, total_square))
    return float(100.0 * np.linalg.norm(pd) / np.linalg.norm(total))


def _combine(settings: StaticPoses, results: Sequence[dict[str, Array]]) -> Outcome:
    tasks = [poses[0] for _, poses in _tasks(settings)]
    found = {(h.tilt, h.law, h.friction, np.sign(h.approach)): result for h, result in zip(tasks, results, strict=True)}
    tilts = settings.tilts_deg

    def shares(law: str, friction: str = "none", side: float = 0.0) -> list[float]:
        kept = [found[tilt, law, friction, side] for tilt in tilts]
        return [_share(result["pd_square"], result["total_square"]) for result in kept]

    free = {law: shares(law) for law in LAWS[1:]}
    rubbed = {"start": shares("pd+sg", "stick")}
    rubbed |= {"below": shares("pd+sg", "stick", -1.0), "above": shares("pd+sg", "stick", 1.0)}
    rubbed |= {"rigid": shares("pd+sg", STIFFEST), "soft": shares("pd+sg", SOFTEST)}
    numbers = {f"share_{law}_{tilt:g}deg": free[law][i] for law in free for i, tilt in enumerate(tilts)}
    numbers |= {f"share_pd+sg_{way}_{tilt:g}deg": rubbed[way][i] for way in rubbed for i, tilt in enumerate(tilts)}
    predicted = [predicted_share(settings, tilt) for tilt in tilts]
    predicted_rubbed = [predicted_share(settings, tilt, settings.coulomb) for tilt in tilts]
    tables = (_free_table(tilts, free, predicted), _friction_table(settings, rubbed, predicted_rubbed))
    series = {"tilt": np.array(tilts), "j1": np.array(settings.j1_deg)}
    series |= {f"share_{law}": np.array(free[law]) for law in free}
    series |= {f"friction_{way}": np.array(values) for way, values in rubbed.items()}
    for name, tilt in (("low", tilts[0]), ("high", tilts[-1])):
        series[f"{name}_pd"] = found[tilt, "pd", "none", 0.0]["pd"]
        series[f"{name}_sg"] = found[tilt, "pd+sg", "none", 0.0]["gravity"]
        series[f"{name}_dg"] = found[tilt, "pd+dg", "none", 0.0]["gravity"]
    return Outcome(numbers, tables, tuple(_findings(settings, free, rubbed, series)), series)


def _free_table(tilts: Sequence[float], free: dict[str, list[float]], predicted: list[float]) -> Table:
    rows = tuple((LAW_TITLES[law], *(f"{value:.1f}" for value in free[law])) for law in free)
    theory = ("PD+SG by statics alone", *(f"{value:.1f}" for value in predicted))
    title = "PD term in % of the total torque (RMS, joints 1 and 2), without friction"
    return Table(title, ("law", *(f"{tilt:g}°" for tilt in tilts)), (*rows, theory), f"{INERTIAS}. {PLANT_NOTE}")


def _friction_table(settings: StaticPoses, rubbed: dict[str, list[float]], predicted: list[float]) -> Table:
    texts = {
        "start": "sticks exactly; the arm starts in the pose, at rest",
        "below": f"sticks exactly; approached from {settings.approach_deg:g}° below",
        "above": f"sticks exactly; approached from {settings.approach_deg:g}° above",
        "rigid": f"MuJoCo's own friction, {STIFFEST}; starts in the pose",
        "soft": f"creeps: MuJoCo's own friction, {SOFTEST}; starts in the pose",
    }
    rows = tuple((text, *(f"{value:.1f}" for value in rubbed[way])) for way, text in texts.items())
    theory = ("the least that any history leaves: statics", *(f"{value:.1f}" for value in predicted))
    title = "PD+SG with Coulomb friction {:g} / {:g} N·m / {:g} N: PD term in % of the total".format(*settings.coulomb)
    return Table(title, ("friction", *(f"{tilt:g}°" for tilt in settings.tilts_deg)), (*rows, theory), FRICTION_NOTE)


def _findings(
    settings: StaticPoses,
    free: dict[str, list[float]],
    rubbed: dict[str, list[float]],
    series: dict[str, Array],
) -> list[Finding]:
    default = settings == StaticPoses()
    mismatch = float(np.abs(series["low_pd"] - series["low_dg"])[:, :COUNTED].max())
    return [
        *_on_shares(settings, free["pd+sg"]),
        finding(
            "PD share of PD+DG, largest over all tilts, no friction",
            max(free["pd+dg"]),
            "%",
            stated="the PD term exerts nearly zero torque with PD+DG (section V-A)",
            expected=0.0 if default else None,
            tolerance=0.05,
            verdict="reproduced" if max(free["pd+dg"]) < 1.0 else "not reproduced",
            why="The accelerometer gives gravity in base axes, and the model in the simulation is exact.",
        ),
        finding(
            f"{settings.tilts_deg[0]:g}°: largest difference between the gravity term and the torque of PD alone",
            mismatch,
            "N·m",
            stated="calculated gravity terms match the PD torques at static poses (Fig. 7)",
            verdict="reproduced" if mismatch < MATCHES else "not reproduced",
            why="PD alone sags until it carries the weight; the terms differ by what gravity changes over the sag.",
        ),
        *(_on_friction(rubbed) if default else ()),
    ]


def _on_shares(settings: StaticPoses, shares: list[float]) -> list[Finding]:
    default, stated_at = settings == StaticPoses(), settings.tilts_deg[-1]
    grows = shares == sorted(shares)
    return [
        finding(
            f"PD share of PD+SG at {tilt:g}°, no friction",
            shares[i],
            "%",
            stated=STATED_8 if tilt == stated_at else "",
            expected=REFERENCE[tilt] if default else None,
            tolerance=0.1,
            verdict=("reproduced" if grows else "not reproduced") if tilt == stated_at else "no number stated",
            why="Pure geometry: g(tilted) against g(level) over the poses. Values of the figure are not in the text.",
        )
        for i, tilt in enumerate(settings.tilts_deg)
        if i > 0
    ]


def _on_friction(rubbed: dict[str, list[float]]) -> list[Finding]:
    at_20 = list(REFERENCE).index(20.0)
    return [
        finding(
            "PD share of PD+SG at 20°, friction that sticks, starting in the pose",
            rubbed["start"][at_20],
            "%",
            expected=29.2,
            tolerance=0.2,
            why="Friction carries part of joint 1's gravity error for good: less than without friction. The value "
            "depends on the history of the pose, see the table.",
        ),
        finding(
            "PD share of PD+SG at 20°, friction that creeps",
            rubbed["soft"][at_20],
            "%",
            expected=REFERENCE[20.0],
            tolerance=0.2,
            why="A compliant friction model slides, however slowly, until the PD term carries all of the gravity "
            "error: the share is the frictionless one. A motor and its cables do not do that.",
        ),
    ]


def _draw(figure: Figure, outcome: Outcome) -> None:
    low, high, share = figure.subplots(1, 3)
    series = outcome.series
    for axes, name, tilt in ((low, "low", series["tilt"][0]), (high, "high", series["tilt"][-1])):
        line_axes(axes, "joint 1, deg", f"joint 1 torque at {tilt:g}° of base tilt, N·m")
        axes.plot(series["j1"], series[f"{name}_pd"][:, 0], "o", color=LAW_COLOURS["pd"], label="PD torque, PD alone")
        axes.plot(series["j1"], series[f"{name}_sg"][:, 0], color=LAW_COLOURS["pd+sg"], label="SG term")
        axes.plot(series["j1"], series[f"{name}_dg"][:, 0], "--", color=LAW_COLOURS["pd+dg"], label="DG term")
    line_axes(share, "base tilt, deg", "PD term, % of the total torque (RMS)")
    for law in ("pd+sg", "pd+dg"):
        share.plot(series["tilt"], series[f"share_{law}"], "o-", color=LAW_COLOURS[law], label=LAW_TITLES[law])
    band = [series["friction_below"], series["friction_above"]]
    share.fill_between(
        series["tilt"], np.minimum(*band), np.maximum(*band), color=LAW_COLOURS["pd+sg"], alpha=0.15, linewidth=0.0,
        label="PD+SG with friction, by approach",
    )  # fmt: skip
    legend_below(figure, low, share)


STATIC_POSES = Experiment(
    name="static-poses",
    title="Static poses on a tilted base",
    source="Lewis & Hannaford, section V-A, Figures 7 and 8",
    about="Poses along joint 1's range are held at base tilts about Z0. Left: the torques of Fig. 7; right: the PD "
    "term as a share of the total, Fig. 8.",
    settings=StaticPoses,
    tasks=_tasks,
    run=_run,
    combine=_combine,
    draw=_draw,
)
