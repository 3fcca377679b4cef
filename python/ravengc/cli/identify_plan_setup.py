"""From the options of ``ravengc identify plan`` to a plan and its curves."""

from __future__ import annotations

import math
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ravengc.cli.common import quantity
from ravengc.cli.identify_logs import for_each
from ravengc.cli.identify_model import model_from
from ravengc.errors import ConfigError

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Iterator, Sequence

    from ravengc.identify import Model, Plan, Prediction, Recording, TrajectoryPlan
    from ravengc.robot import Robot
    from ravengc.units import Dimension

__all__ = ["Found", "planned"]

WITH, LEVEL = "with tilts", "level only"


@dataclass(frozen=True, slots=True)
class Found:
    """A plan, or ``None`` where poses were judged, and predictions by label."""

    robot: Robot
    model: Model
    plan: Plan | TrajectoryPlan | None
    curves: dict[str, Prediction]
    judged: int = 0


def planned(args: argparse.Namespace) -> Found:
    """Plan as the options say; a bar on standard error shows how far it is."""
    import ravengc

    robot = ravengc.load(args.robot)
    model = model_from(args, robot)
    if args.predict is not None:
        return _judged(args, robot, model)
    with _bar("planning") as on_progress:
        plan = (_motion if args.motion else _poses)(args, robot, model, on_progress)
    curves = {WITH: plan.predicted, LEVEL: plan.level} if _tilts(args) else {LEVEL: plan.predicted}
    return Found(robot, model, plan, curves)


def _tilts(args: argparse.Namespace) -> bool:
    return _angle(args.tilt, "--tilt") > 0.0


def _poses(args: argparse.Namespace, robot: Robot, model: Model, on_progress: Callable[[int, int], object]) -> Plan:
    from ravengc import identify

    return identify.plan(
        robot,
        model,
        poses=args.poses,
        attitudes=args.attitudes,
        candidates=args.candidates,
        on_progress=on_progress,
        **_common(args, robot),
    )


def _motion(
    args: argparse.Namespace, robot: Robot, model: Model, on_progress: Callable[[int, int], object]
) -> TrajectoryPlan:
    from ravengc import identify

    return identify.plan_trajectory(
        robot,
        model,
        period=quantity(args.period, "time", "--period"),
        harmonics=args.harmonics,
        velocity=args.velocity,
        acceleration=args.acceleration,
        rounds=args.rounds,
        on_progress=on_progress,
        **_common(args, robot),
    )


def _common(args: argparse.Namespace, robot: Robot) -> dict[str, Any]:
    used_to = None if args.used_to is None else _angle(args.used_to, "--used-to")
    return {
        "tilt": _angle(args.tilt, "--tilt"),
        "used_to": used_to,
        "ranges": _ranges(args.range, robot),
        "noise": _noise(args.noise),
        "seed": args.seed,
    }


def _angle(text: str, option: str) -> float:
    """An angle as typed; ConfigError for more than a right angle, as degrees without their unit are."""
    angle = quantity(text, "angle", option)
    if not 0.0 <= angle <= 0.5 * math.pi + 1e-9:
        raise ConfigError(f'{option} {text}: expected 0 to 90 degrees; degrees carry their unit, such as "10deg"')
    return min(angle, 0.5 * math.pi)


def _ranges(words: list[str], robot: Robot) -> dict[str, tuple[float, float]]:
    from ravengc.coordinates import sliding
    from ravengc.messages import did_you_mean, listed, shown

    found, names = {}, robot.spec.coordinate_names
    for word in words:
        name, equals, ends = word.partition("=")
        least, colon, most = ends.partition(":")
        if not equals or not colon:
            raise ConfigError(f"--range {word!r}: expected JOINT=LEAST:MOST, such as {names[0]}=-10deg:40deg")
        if name not in names:
            near = did_you_mean(name, names)
            raise ConfigError(f"--range: {robot.name} has no joint {shown(name)}{near}; it has {listed(names)}")
        kind: Dimension = "length" if sliding(robot.spec)[names.index(name)] else "angle"
        found[name] = (quantity(least, kind, f"--range {name}"), quantity(most, kind, f"--range {name}"))
    return found


def _noise(text: str) -> float | list[float]:
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        raise ConfigError(f"--noise {text!r}: expected a number, or one for every joint with commas between") from None
    return values[0] if len(values) == 1 else values


def _judged(args: argparse.Namespace, robot: Robot, model: Model) -> Found:
    """Predictions from a file's own poses, and from these on a level base."""
    from ravengc import identify

    counted = for_each(args.at, len(args.predict), "--at")
    poses = _joined([_poses_of(*pair, robot) for pair in zip(args.predict, counted, strict=True)])
    reach = _angle(args.tilt if args.used_to is None else args.used_to, "--used-to")
    wanted = poses.q[:: max(1, len(poses.q) // 64)]
    judge: dict[str, Any] = {"tilt": reach, "noise": _noise(args.noise), "poses": wanted}
    whole = identify.predict_uncertainty(robot, model, poses, **judge)
    if poses.specific_force is None or np.ptp(poses.specific_force, axis=0).max() < 1e-6:
        return Found(robot, model, None, {LEVEL: whole}, poses.samples)
    level = identify.predict_uncertainty(robot, model, replace(poses, specific_force=None), **judge)
    return Found(robot, model, None, {WITH: whole, LEVEL: level}, poses.samples)


def _joined(parts: list[Recording]) -> Recording:
    """The poses of all files, one after the other."""
    from ravengc import identify

    q, base, counted = (np.vstack([getattr(part, name) for part in parts]) for name in ("q", "base", "counts"))
    force = None if all(part.specific_force is None for part in parts) else base[:, :3]
    return identify.Recording(
        stamps=np.arange(float(len(q))), q=q, tau=np.zeros_like(q), specific_force=force, counted=counted, source="plan"
    )


def _poses_of(file: str, at: Sequence[str] | None, robot: Robot) -> Recording:
    """The poses of a file, with or without a column of time."""
    from ravengc import identify, recordings
    from ravengc.identify.logs import counting

    try:
        read = recordings.read_recording(file)
    except ConfigError:
        read = recordings.read_recording(file, rate_hz=1.0)
    fitted = recordings.fit_to_robot(read, robot.spec)
    force = None if fitted.gravity is None else -fitted.gravity
    poses = identify.Recording(
        stamps=fitted.t, q=fitted.q, tau=np.zeros_like(fitted.q), specific_force=force, source=fitted.source
    )
    return counting(poses, robot, at)


@contextmanager
def _bar(label: str) -> Iterator[Callable[[int, int], object]]:
    """A bar on standard error while the ``with`` lasts, if that is a terminal."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(label, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)
