"""A run over a moving surface to be looked at in three dimensions: one HTML file that plays it back, made by viser."""

from __future__ import annotations

import io
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ravengc.atomic import check_writable
from ravengc.config.files import write_atomically
from ravengc.errors import ConfigError, MissingExtraError
from ravengc.reports.track_figures import OUTCOME_COLOURS

if TYPE_CHECKING:
    from pathlib import Path

    import ravengc
    from ravengc.track import TrackResult

__all__ = ["check_view", "frame_rows", "require_viser", "write_view"]

Array = NDArray[np.float64]

FRAMES_HZ, MOST_FRAMES = 20.0, 2000
PURPOSE = "the view of the run in three dimensions"
LINK_COLOUR, JOINT_COLOUR, TOOL_COLOUR, TARGET_COLOUR = (205, 209, 214), (61, 108, 176), (43, 47, 54), (209, 96, 61)
WAITING = (150, 156, 164)
SHORTEST_LINK_M = 1e-4
THICKNESS, SLENDER, POINT = 0.02, 0.25, 0.007
"""Radius of the links, of the arm's reach; of the tool, of that; of the points, of the surface's size."""


class _Scene(NamedTuple):
    """What moves: a rod per link, a ball per joint, tool and target, the surface's frame and its points, a text."""

    rods: list[Any]
    balls: list[Any]
    tool: Any
    target: Any
    surface: Any
    cloud: Any
    text: Any


def require_viser() -> Any:
    """Return the package viser; MissingExtraError if it is not installed."""
    try:
        import viser
    except ImportError as error:
        raise MissingExtraError("viser", "view", PURPOSE) from error
    return viser


def check_view(path: Path) -> None:
    """Raise ConfigError or MissingExtraError if no view could be written to ``path``, before the run that it shows."""
    if path.suffix.lower() != ".html":
        raise ConfigError(f"{path}: the view is one HTML file; expected a name ending in .html")
    require_viser()
    check_writable(path)


def write_view(path: Path, run: TrackResult, robot: ravengc.Robot) -> None:
    """Write a run as an HTML file that needs no other and no network: play, pause, speed, and the camera by mouse.

    Every frame shows the arm, the surface where it is, its points in the colour of what became of them, and where the
    tool should be. MissingExtraError without viser, ConfigError where the file cannot be written.
    """
    viser = require_viser()
    with redirect_stdout(io.StringIO()):  # it greets
        try:
            server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        except OSError as error:
            raise ConfigError(f"{path}: viser cannot start on this machine: {error.strerror or error}") from error
        try:
            page = _recorded(server, run, robot)
        finally:
            server.stop()
    write_atomically(path, page)


def _recorded(server: Any, run: TrackResult, robot: ravengc.Robot) -> str:
    rows = frame_rows(run)
    links = np.array([_links(robot, q) for q in run.trace.q[rows]])
    with server.atomic():  # nobody is looking yet: its thread need not wake for every message
        scene = _built(server, run, links[0])
        recording = server.get_scene_serializer()
        for i, row in enumerate(rows):
            _show(scene, run, int(row), links[i])
            recording.insert_sleep(_pause(run, rows, i))
    page: str = recording.as_html()
    return page


def frame_rows(run: TrackResult) -> NDArray[np.int64]:
    """Return the rows of the trace that are shown: 20 a second, fewer of a long run."""
    stamps = run.trace.stamps
    length = float(stamps[-1] - stamps[0])
    count = int(min(MOST_FRAMES, max(2.0, FRAMES_HZ * length), len(stamps)))
    times = np.linspace(stamps[0], stamps[-1], count)
    return np.unique(np.searchsorted(stamps, times).clip(0, len(stamps) - 1))


def _pause(run: TrackResult, rows: NDArray[np.int64], i: int) -> float:
    after = rows[min(i + 1, len(rows) - 1)]
    return float(run.trace.stamps[after] - run.trace.stamps[rows[i]]) or 1.0 / FRAMES_HZ


def _links(robot: ravengc.Robot, q: Array) -> Array:
    """From where to where (k, 2, 3) each link reaches, m: from the frame that carries it to its own; last the tool."""
    spec = robot.spec
    places = {name: robot.forward_kinematics(q, frame=name)[:3, 3] for name in robot.frame_names}
    pairs = [(link.parent or "base", link.name) for link in spec.links]
    return np.array([(places[a], places[b]) for a, b in (*pairs, (spec.tip or spec.links[-1].name, "tool"))])


def _built(server: Any, run: TrackResult, links: Array) -> _Scene:
    scene, points = server.scene, run.surface.points
    size = float(np.linalg.norm(np.ptp(points, axis=0))) or 0.1
    reach = float(np.linalg.norm(links[:, 1] - links[:, 0], axis=1).sum())
    thick = THICKNESS * reach
    middle = points.mean(axis=0)
    scene.set_up_direction("+z")
    scene.add_grid("/floor", width=2.0 * reach, height=2.0 * reach, cell_size=0.1, section_size=0.5)
    server.initial_camera.position = tuple(middle + (1.5 * size + 0.2 * reach) * np.array((0.8, -0.8, 0.6)))
    server.initial_camera.look_at = tuple(middle)
    radii = [thick] * (len(links) - 1) + [SLENDER * thick]
    rods = [
        scene.add_cylinder(f"/arm/rod{i}", radius=radius, height=1.0, scale=(1.0, 1.0, 1.0), color=LINK_COLOUR)
        for i, radius in enumerate(radii)
    ]
    balls = [
        scene.add_icosphere(f"/arm/joint{i}", radius=1.25 * thick, color=JOINT_COLOUR, subdivisions=2)
        for i in range(len(links))
    ]
    surface = scene.add_frame("/surface", show_axes=False)
    cloud = scene.add_point_cloud(
        "/surface/points",
        points.astype(np.float32),
        _colours(run, -1.0),
        point_size=2.0 * POINT * size,
        point_shape="circle",
        precision="float32",
    )
    tour = points[run.visits.point]
    if len(tour) > 1:
        lines = np.stack((tour[:-1], tour[1:]), axis=1).astype(np.float32)
        scene.add_line_segments("/surface/tour", lines, WAITING, thickness=0.4 * POINT * size)
    tool = scene.add_icosphere("/tool", radius=2.0 * POINT * size, color=TOOL_COLOUR, subdivisions=2)
    target = scene.add_icosphere("/target", radius=2.2 * POINT * size, color=TARGET_COLOUR, opacity=0.5)
    text = scene.add_label("/text", "", position=(middle[0], middle[1], middle[2] - 0.8 * size))
    return _Scene(rods, balls, tool, target, surface, cloud, text)


def _show(scene: _Scene, run: TrackResult, row: int, links: Array) -> None:
    """Bring everything to where it was in a row of the trace; what has not changed is not sent."""
    trace = run.trace
    for rod, ball, (start, end) in zip(scene.rods, scene.balls, links, strict=True):
        ball.position = start
        length = float(np.linalg.norm(end - start))
        if (length > SHORTEST_LINK_M) != rod.visible:
            rod.visible = length > SHORTEST_LINK_M
        if rod.visible:
            rod.position, rod.wxyz = 0.5 * (start + end), _along((end - start) / length)
            if abs(length - rod.scale[2]) > SHORTEST_LINK_M:
                rod.scale = (1.0, 1.0, length)
    scene.tool.position, scene.target.position = trace.tool[row], trace.target[row]
    scene.surface.position = trace.displacement[row]
    now = float(trace.stamps[row])
    finished = int((_finished(run) <= now).sum())
    text = f"{now - float(trace.stamps[0]):.0f} s: {trace.phase[row]}, {finished} of {len(run.visits)} points done"
    if scene.text.text != text:
        scene.text.text = text
    colours = _colours(run, now)
    if not np.array_equal(colours, scene.cloud.colors):
        scene.cloud.colors = colours


def _finished(run: TrackResult) -> Array:
    """When each visit was over (s); never, for one that was not begun."""
    over = run.visits.start_s + run.visits.time_s
    return np.where(np.isfinite(over), over, np.inf)


def _colours(run: TrackResult, now: float) -> NDArray[np.uint8]:
    """A colour (n, 3) for every point of the surface at a time: its outcome's, from when its visit was over."""
    colours = np.tile(np.array(WAITING, dtype=np.uint8), (len(run.surface), 1))
    over = _finished(run) <= now
    for outcome, colour in OUTCOME_COLOURS.items():
        rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        colours[run.visits.point[over & (run.visits.outcome == outcome)]] = rgb
    return colours


def _along(direction: Array) -> Array:
    """The quaternion (w, x, y, z) that turns z into a unit vector the shortest way."""
    x, y, z = direction
    if z < -1.0 + 1e-9:
        return np.array((0.0, 1.0, 0.0, 0.0))
    quaternion = np.array((1.0 + z, -y, x, 0.0))
    turned: Array = quaternion / np.linalg.norm(quaternion)
    return turned
