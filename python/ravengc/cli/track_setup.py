"""From the options of ``ravengc track`` to what is run: an arm, a surface in its reach, a motion, settings."""

from __future__ import annotations

import re
import tomllib
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ravengc.cli.common import quantity
from ravengc.cli.track_place import placed, posture
from ravengc.errors import ArgumentError, ConfigError, ParseError
from ravengc.messages import listed, shown
from ravengc.targets import Cloud, read_cloud, read_motion
from ravengc.targets.files import MOTIONS
from ravengc.track import Camera, Surface, TrackSettings, liver_500, lujan, recorded, still
from ravengc.track.run import check_arm

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

    import ravengc
    from ravengc.track import Motion

__all__ = ["SIZE", "Setup", "build"]

Array = NDArray[np.float64]

SIZE = 500
QUICK_POINTS, QUICK_HOLDS, QUICK_HOLD_S = 60, 2, 4.0
MOST_POINTS, MOST_SEEDS = 20_000, 1000
LUJAN = re.compile(r"lujan(?::(?P<amplitude>[^:]+):(?P<period>[^:]+))?")
CAMERA_SEEDS = 10_000
TABLES = ("track", "camera")


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What is run: ``methods`` are the settings by name, the first the one that counts; a seed gives the motion."""

    title: str
    robot: ravengc.Robot
    surface: Surface
    methods: dict[str, TrackSettings]
    motion_of: Callable[[int], Motion]
    camera: Camera
    first_seed: int
    seeds: int
    least_coverage: float
    notes: tuple[str, ...]
    recorded_s: float | None
    is_from_file: bool
    command: str

    def camera_of(self, seed: int) -> Camera:
        """The camera with the noise of a seed."""
        return replace(self.camera, seed=CAMERA_SEEDS + seed)


def build(args: argparse.Namespace) -> Setup:
    """Read every file and check every option; errors of ravengc for what does not fit."""
    _check_options(args)
    robot = _robot(args.robot)
    check_arm(robot)
    start = np.array(liver_500()[4].start_q) if args.robot == "panda" else posture(robot)
    surface, surface_notes = _surface(args, robot, start)
    motion_of, recorded_s, motion_notes = _motion(args)
    settings, camera = _settings(args, surface, start)
    name = f"{surface.name}: {robot.name}, {settings.mode}, {motion_of(args.seed).description}"
    return Setup(
        title=name,
        robot=robot,
        surface=surface,
        methods=_methods(args, settings),
        motion_of=motion_of,
        camera=camera,
        first_seed=args.seed,
        seeds=args.seeds,
        least_coverage=args.least_coverage / 100.0,
        notes=(*surface_notes, *motion_notes),
        recorded_s=recorded_s,
        is_from_file=args.surface is not None,
        command=_command(args),
    )


def _check_options(args: argparse.Namespace) -> None:
    """Refuse options that would do nothing."""
    if args.strict and args.surface is None and not _may_be_file(args.motion):
        raise ConfigError("--strict is for a surface or a motion from a file; give --surface FILE or --motion FILE")
    if args.surface is None:
        useless = [name for name in ("units", "at", "turn", "facing") if getattr(args, name)]
        if useless:
            raise ConfigError(f"--{useless[0]} is for a surface from a file; give --surface FILE")
    elif args.singular:
        raise ConfigError("--singular is LIVER-500-S, which has its own surface; leave out --surface or --singular")
    if args.points is not None and args.points > MOST_POINTS:
        raise ConfigError(f"--points is {args.points}; expected at most {MOST_POINTS}")
    if args.seeds > MOST_SEEDS:
        raise ConfigError(f"--seeds is {args.seeds}; expected at most {MOST_SEEDS}")
    if args.predictor is not None and args.predictor not in _predictors():
        from ravengc.messages import did_you_mean

        near = did_you_mean(args.predictor, _predictors())
        raise ConfigError(f"--predictor {shown(args.predictor)} is unknown: choose {listed(_predictors())}{near}")


def _predictors() -> tuple[str, ...]:
    from ravengc.track.settings import PREDICTORS

    return PREDICTORS


def _robot(name: str) -> ravengc.Robot:
    import ravengc

    return liver_500()[0] if name == "panda" else ravengc.load(name)


def _surface(args: argparse.Namespace, robot: ravengc.Robot, start: Array) -> tuple[Surface, tuple[str, ...]]:
    """The points to visit in base axes, and what has been done to them."""
    most = args.points or (QUICK_POINTS if args.quick else SIZE)
    if args.surface is None:
        return _liver(args, robot, start, most)
    cloud = read_cloud(args.surface, units=args.units, most=most, facing=args.facing or (0, 0, 1), strict=args.strict)
    found = placed(cloud, robot, start, args.at, args.turn)
    try:
        surface = Surface(found.points, found.normals, _name_of(args.surface))
    except ArgumentError as error:
        raise ParseError(str(error), file=args.surface) from error
    return surface, found.notes


def _liver(args: argparse.Namespace, robot: ravengc.Robot, start: Array, most: int) -> tuple[Surface, tuple[str, ...]]:
    """The benchmark's points, or those in their middle; for another arm than its own, where that reaches them."""
    surface = liver_500(singular=args.singular)[1]
    notes: tuple[str, ...] = ()
    if most < len(surface):
        surface, notes = _middle_of(surface, most), (f"the {most} points in its middle",)
    if args.robot == "panda":
        return surface, notes
    found = placed(Cloud(surface.points, surface.normals, surface.name, notes), robot, start, None, None)
    return Surface(found.points, found.normals, surface.name), found.notes


def _name_of(source: str) -> str:
    return source if source.startswith("example:") else Path(source).name


def _middle_of(surface: Surface, count: int) -> Surface:
    away = np.linalg.norm(surface.points - surface.points.mean(axis=0), axis=1)
    kept = np.sort(np.argsort(away, kind="stable")[:count])
    return Surface(surface.points[kept], surface.normals[kept], surface.name)


def _motion(args: argparse.Namespace) -> tuple[Callable[[int], Motion], float | None, tuple[str, ...]]:
    """A motion for a seed, the length of a recording (s), and what has been done to it."""
    match = LUJAN.fullmatch(args.motion)
    if args.motion == "still" or match:
        if args.motion_units is not None or args.motion_rate is not None:
            raise ConfigError("--motion-units and --motion-rate are for a recording; give --motion FILE")
        return (_lujan(match) if match else _still), None, ()
    if not _may_be_file(args.motion):
        known = f"lujan, lujan:AMPLITUDE:PERIOD, still, {', '.join(f'example:{name}' for name in MOTIONS)}"
        raise ConfigError(f"--motion {shown(args.motion)} is unknown: choose {known}, or a file of a recording")
    found = read_motion(args.motion, units=args.motion_units, rate_hz=args.motion_rate, strict=args.strict)
    motion = recorded(found.stamps, found.displacement, description=f"recorded in {_name_of(args.motion)}")
    return (lambda _seed: motion), found.duration_s, found.notes


def _may_be_file(text: str) -> bool:
    """Tell whether this is meant as a recording: a file, what is named like one, or a bundled one."""
    named = bool(Path(text).suffix) and not text.startswith(("lujan", "still"))
    return named or text.startswith("example:") or Path(text).is_file()


def _still(_seed: int) -> Motion:
    return still()


def _lujan(match: re.Match[str]) -> Callable[[int], Motion]:
    if match["amplitude"] is None:
        return lambda seed: liver_500(seed)[2]
    amplitude = quantity(match["amplitude"], "length", "--motion: amplitude")
    period_s = quantity(match["period"], "time", "--motion: period")
    try:
        lujan(amplitude=amplitude, period_s=period_s)
    except ConfigError as error:
        units = "AMPLITUDE:PERIOD are in m and s unless they have units, such as 15mm:4s"
        raise ConfigError(f"--motion {match[0]}: {error}; {units}") from None
    from ravengc.track.liver import ALONG

    return lambda seed: lujan(amplitude=amplitude, period_s=period_s, seed=seed, direction=ALONG)


def _settings(args: argparse.Namespace, surface: Surface, start: Array) -> tuple[TrackSettings, Camera]:
    """The benchmark's settings, changed by the file, changed by the options."""
    _, _, _, camera, settings = liver_500()
    settings = replace(settings, start_q=tuple(start.tolist()))
    if args.surface is not None:
        settings = replace(settings, order="tour", hold_from_arrival=True)
    if args.quick:
        settings = replace(settings, hold_points=QUICK_HOLDS, hold_s=QUICK_HOLD_S)
    tables = {} if args.settings is None else _tables(args.settings)
    settings = _changed(settings, tables.get("track", {}), f"{args.settings}: [track]")
    camera = _changed(camera, tables.get("camera", {}), f"{args.settings}: [camera]")
    options = {name: value for name in ("mode", "predictor") if (value := getattr(args, name)) is not None}
    return replace(settings, **options, hold_points=min(settings.hold_points, len(surface))), camera


def _tables(path: Path) -> dict[str, dict[str, Any]]:
    from ravengc.config.files import decode, read_bytes

    try:
        tables = tomllib.loads(decode(read_bytes(path), str(path)))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ParseError(f"not valid TOML: {error}", file=str(path)) from error
    for name, table in tables.items():
        if name not in TABLES or not isinstance(table, dict):
            raise ConfigError(f"{path}: {shown(name)} is no table of settings; expected [track] and [camera]")
    if "seed" in tables.get("camera", {}):
        raise ConfigError(f"{path}: [camera]: seed comes from --seed; leave it out")
    return tables


def _changed(settings: Any, table: dict[str, Any], where: str) -> Any:
    from ravengc.experiments.settings import settings_from

    return settings_from(type(settings), {**asdict(settings), **table}, where) if table else settings


def _methods(args: argparse.Namespace, settings: TrackSettings) -> dict[str, TrackSettings]:
    found = {settings.method: settings}
    if args.baseline:
        found["naive"] = replace(settings, method="naive", approach="step", feed_forward=False)
    if args.oracle:
        found["oracle"] = replace(settings, method="oracle")
    return found


def _command(args: argparse.Namespace) -> str:
    """The options that decide what is run, as they are typed."""
    import shlex

    words = ["ravengc", "track"]
    flags = ("singular", "strict", "baseline", "oracle", "quick")
    defaults = {"motion": "lujan", "robot": "panda", "seed": 0, "seeds": 1}
    for name in (
        "surface", "units", "points", "at", "turn", "facing", "motion", "motion_units", "motion_rate", "robot", "mode",
        "predictor", "seed", "seeds", "settings",
    ):  # fmt: skip
        value = getattr(args, name)
        if value is not None and value != defaults.get(name):
            text = ",".join(f"{x:.15g}" for x in value) if isinstance(value, tuple) else str(value)
            words += [f"--{name.replace('_', '-')}", text]
    return shlex.join([*words, *(f"--{name}" for name in flags if getattr(args, name))])
